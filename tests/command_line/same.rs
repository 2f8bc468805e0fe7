//! Results are the same to the bit from any number of threads, in the least memory, and from either order of samples in a file.

use std::fs;
use std::process::Output;

use ndarray::{Array2, Axis, ShapeBuilder};
use test_support::fields::noise;
use test_support::place::{Place, names, text};

/// Of fields: `v.npy`, `w.npy`, and `gaps.npy`, which has channels that are at fault.
const FIELDS: [&str; 18] = [
    "analyze v.npy",
    "analyze gaps.npy --gaps mask --segment 128 --window-time hann --detrend-time linear --short-time-times 100",
    "analyze gaps.npy --gaps interpolate --detrend-space linear --precision f32",
    "bicoherence v.npy --segment 64 --output 5 --along 0:37",
    "bicoherence v.npy --transfer 1 --resamplings 20",
    "coherence v.npy --segment 128",
    "increments v.npy",
    "modes v.npy --segment 128 --frequencies 0.2",
    "ridges v.npy",
    "slope v.npy --along space --band 0.1:1.4",
    "slope v.npy --along time --band 0.1:0.4",
    "spectrum v.npy --segment 256 --multitaper 2,3 --detrend linear",
    "spectrum gaps.npy --segment 128 --gaps leave-out",
    "spectrum v.npy --segment 64 --overlap 30 --multitaper 2,2 --space-multitaper 2,3 --along both",
    "bicoherence v.npy w.npy --segment 64 --along 0:37",
    "coherence v.npy w.npy --segment 60 --part 2/3",
    "spectrum v.npy w.npy --segment 64 --overlap 30 --multitaper 2,2 --along both --equal-weights",
    "filter v.npy --frequency 0.1:0.2 --towards plus-x",
];

/// Of scenes and runs.
const RUNS: [&str; 9] = [
    "budget run.npz",
    "budget run.npz --from-samples --only scale",
    "triads fput.npz",
    "attenuate --ratios 2.4 --bodies 6 --lengths 3,6",
    "attenuate --sites 7 --against stiffness_ratio=1:4:3",
    "sweep --sites 6 --end-time 12 --samples 64 --vary stiffness_ratio=1:3:4",
    "fit run.npz scene.toml --free stiffness_ratio=1..4 --starts 2",
    "design scene.toml --free stiffness_ratio=1..4 --minimize peak_force_last --tries 30",
    "plan scene.toml --free tangent,stiffness_ratio --sensors 2",
];

/// The words that say where a command writes, and that place.
fn to(line: &str, out: &str) -> (String, String) {
    let out = match line.starts_with("filter") {
        true => format!("{out}.npz"),
        false => out.to_owned(),
    };
    let has_figures = !line.starts_with("filter") && !line.starts_with("sweep");
    let none = ["", " --figures none"][usize::from(has_figures)];
    (format!("{line}{none} --quiet --out {out}"), out)
}

fn run(place: &Place, line: &str) -> Output {
    place.run(&line.split(' ').collect::<Vec<_>>())
}

/// What a command writes, but for when and how it ran; at last what moved, by as many groups of sites as the memory holds.
fn written(place: &Place, line: &str, out: &str) -> Vec<Vec<u8>> {
    let (line, out) = to(line, out);
    let output = run(place, &line);
    assert!(output.status.success(), "{line}: {output:?}");
    if out.ends_with(".npz") {
        return vec![fs::read(place.path(out)).unwrap()];
    }
    let mut summary = place.json(&format!("{out}/summary.json"));
    summary["provenance"].take();
    summary["timings"].take();
    let moved = summary["moved"].take();
    let arrays = names(&place.path(&out)).into_iter();
    let arrays = arrays.filter(|name| name.ends_with(".npz") || name.ends_with(".csv"));
    let arrays = arrays.map(|name| fs::read(place.path(&out).join(name)).unwrap());
    arrays
        .chain([summary, moved].map(|json| json.to_string().into_bytes()))
        .collect()
}

/// The least memory that is not refused, which refusals name: `needs 1.50 MiB`.
fn least_memory(place: &Place, line: &str) -> f64 {
    let mut memory = 1000.0;
    loop {
        let (line, _) = to(line, "least");
        let output = run(place, &format!("{line} --force --memory {memory:.0}B"));
        if output.status.success() {
            return memory;
        }
        let said = text(&output.stderr);
        let (_, needed) = said.split_once("needs ").expect(&said);
        let words: Vec<&str> = needed.split(' ').collect();
        let unit = ["bytes", "KiB", "MiB"]
            .iter()
            .position(|of| *of == words[1]);
        let needed = words[0].parse::<f64>().unwrap() * 1024f64.powi(unit.unwrap() as i32);
        memory = needed.max(1.2 * memory) * 1.002;
    }
}

#[test]
fn regress_threads_memory_and_the_order_of_samples_do_not_move_a_bit() {
    let place = Place::new();
    let mut values = noise(601, 37);
    for folder in ["rows", "columns"] {
        fs::create_dir(place.path(folder)).unwrap();
    }
    for name in ["v.npy", "w.npy", "gaps.npy"] {
        let mut columns = Array2::zeros(values.dim().f());
        columns.assign(&values);
        place.save(&format!("rows/{name}"), &values);
        place.save(&format!("columns/{name}"), &columns);
        values.invert_axis(Axis(0));
        if name == "w.npy" {
            // Missing, dead, clipped, far from zero.
            values.slice_mut(ndarray::s![400..430, 7]).fill(f64::NAN);
            values.column_mut(5).fill(0.0);
            values.column_mut(9).mapv_inplace(|v| v.clamp(-0.5, 0.5));
            values.column_mut(17).mapv_inplace(|v| v + 1e6);
        }
    }
    for (i, line) in FIELDS.iter().enumerate() {
        let of = |order: &str| {
            let is_field = |word: &&str| word.ends_with(".npy");
            let words = line.split(' ').map(|word| match is_field(&word) {
                true => format!("{order}/{word}"),
                false => word.to_owned(),
            });
            words.collect::<Vec<_>>().join(" ")
        };
        let expected = written(
            &place,
            &format!("{} --threads 1", of("rows")),
            &format!("{i}-one"),
        );
        for order in ["rows", "columns"] {
            let line = format!("{} --threads 3", of(order));
            assert!(
                written(&place, &line, &format!("{i}-{order}")) == expected,
                "{line}"
            );
            let line = format!("{} --threads 2", of(order));
            let memory = least_memory(&place, &line);
            let line = format!("{line} --memory {memory:.0}B");
            let found = written(&place, &line, &format!("{i}-{order}-least"));
            let compared = (found.len() - 1).max(1);
            assert!(found[..compared] == expected[..compared], "{line}");
        }
    }
}

#[test]
fn regress_threads_move_no_bit_of_runs() {
    let place = Place::new();
    let scene =
        "sites = 6\nstiffness_ratio = 2.0\ntangent = 0.02\nend_time = 12.0\nsamples = 100\n";
    place.write("scene.toml", scene);
    place.says("simulate scene.toml --quiet --out run.npz");
    let fput =
        "simulate --sites 16 --law spring --alpha 0.25 --ends fixed --mode 1 --mode-amplitude 1";
    place.says(&format!(
        "{fput} --end-time 60 --samples 256 --quiet --out fput.npz"
    ));
    for (i, line) in RUNS.iter().enumerate() {
        let of = |threads| {
            written(
                &place,
                &format!("{line} --threads {threads}"),
                &format!("{i}-{threads}"),
            )
        };
        let expected = of(1);
        assert!(of(2) == expected && of(5) == expected, "{line}");
    }
}
