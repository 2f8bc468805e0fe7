//! Every estimate as a stranger runs it: options reach it, and the result is written whole.

use std::f64::consts::TAU;

use ndarray::Array2;
use serde_json::Value;
use test_support::fields::noise;
use test_support::place::Place;

/// Fields of which one thing is known each.
fn fields() -> Place {
    let (place, random) = (Place::new(), noise(4100, 12));
    let mut low = [0.0; 2];
    let quadratic = Array2::from_shape_fn((4096, 2), |(n, j)| {
        low[j] = 0.7 * low[j] + random[[n, 0]];
        match j {
            0 => low[0],
            _ => low[1] + 0.2 * low[1] * low[1] + 0.05 * random[[n, 1]],
        }
    });
    let delayed = Array2::from_shape_fn((4096, 3), |(n, j)| match j {
        0 => random[[n + 3, 0]] + 0.2 * random[[n, 1]],
        1 => random[[n, 0]] + 0.2 * random[[n, 2]],
        _ => random[[n, 3]],
    });
    let mut walk = noise(256, 32);
    for mut row in walk.outer_iter_mut() {
        let mut sum = 0.0;
        row.mapv_inplace(|step| {
            sum += step;
            sum
        });
    }
    let wave = Array2::from_shape_fn((2048, 12), |(n, j)| {
        (0.7 * j as f64 - TAU * 0.125 * n as f64).cos() + 0.2 * random[[n, j]]
    });
    // Of speed 2 both ways.
    let waves = Array2::from_shape_fn((1024, 48), |(n, j)| {
        let wave = |m: usize| {
            let f = 0.05 + 0.002 * m as f64;
            let sign = if m.is_multiple_of(2) { 1.0 } else { -1.0 };
            let phase = 7.3 * (m * m) as f64;
            (TAU * f * (n as f64 - sign * j as f64 / 2.0) + phase).cos()
        };
        (0..200).map(wave).sum::<f64>() + random[[n + j, j % 12]]
    });
    let law = Array2::from_shape_fn((20, 128), |(i, j)| {
        let term = |m: usize| (TAU * (m * j) as f64 / 128.0 + (i * m * m) as f64).cos() / m as f64;
        (1..60).map(term).sum::<f64>()
    });
    let line = Array2::from_shape_fn((2048, 5), |(n, j)| {
        let line = (TAU * 300.0 / 2048.0 * n as f64).cos();
        random[[n, j]] + if j == 1 { line } else { 0.0 }
    });
    for (name, values) in [
        ("quadratic", quadratic),
        ("delayed", delayed),
        ("walk", walk),
        ("wave", wave),
        ("waves", waves),
        ("law", law),
        ("line", line),
    ] {
        place.save(&format!("{name}.npy"), &values);
    }
    let scene = "sites = 16\nlaw = 'spring'\nalpha = 0.25\nends = 'fixed'\nmode = 1\nmode_amplitude = 1.0\n\
                 end_time = 60.0\nsamples = 512\n";
    place.write("fput.toml", scene);
    place.says("simulate fput.toml --out fput.npz --quiet");
    place
}

/// Command without its figures; a number of its summary, its value and how far off it may be; an array and its shape. A blank
/// inside of a word is `~`.
type Case<'a> = (&'a str, &'a str, [f64; 2], &'a str, &'a [usize]);

const CASES: [Case<'_>; 13] = [
    (
        "bicoherence quadratic.npy --segment 64 --site 1 --dt 10us",
        "/strongest/0/biphase",
        [0.0, 0.5],
        "bicoherence",
        &[210],
    ),
    (
        "bicoherence quadratic.npy --transfer 1 --dt 1ms --resamplings 40",
        "/transfer/shares/held_out_linear",
        [0.8, 0.2],
        "along_largest",
        &[65, 2],
    ),
    (
        "coherence delayed.npy --dt 10us",
        "/delays/1/delay",
        [3e-5, 1e-7],
        "coherence",
        &[257, 3],
    ),
    (
        "coherence delayed.npy --dt 10us --multitaper 4,7 --reference 1",
        "/delays/0/delay",
        [-3e-5, 1e-7],
        "coherence",
        &[2049, 3],
    ),
    (
        "increments walk.npy --band 1:8",
        "/axes/0/exponents/exponents/1",
        [1.0, 0.05],
        "space_structure",
        &[6, 6],
    ),
    (
        "modes wave.npy --segment 128",
        "/chosen/0/waves/0/wavenumber",
        [0.7, 0.01],
        "eigenvalues",
        &[65, 12],
    ),
    (
        "ridges waves.npy --dt 1ms --dx 1m --fit c*abs(k);~c=1",
        "/fits/0/parameters/0/value",
        [2000.0, 10.0],
        "",
        &[],
    ),
    (
        "slope law.npy --layout time-site --window none --detrend none --band 0.1:1.5",
        "/law/slope",
        [-2.0, 1e-9],
        "",
        &[],
    ),
    (
        "slope law.npy --layout time-site --window none --detrend none --band 100rad/m:1.5rad/mm --dx 1mm",
        "/law/slope",
        [-2.0, 1e-9],
        "",
        &[],
    ),
    (
        "spectrum line.npy --dt 1ms --multitaper 4,7",
        "/line_test/lines/0/at",
        [300.0 / 2.048, 1e-9],
        "jackknife_low",
        &[1025, 5],
    ),
    (
        "spectrum line.npy --periodogram",
        "/degrees_of_freedom/median",
        [2.0, 1e-9],
        "low",
        &[1025, 5],
    ),
    (
        "spectrum line.npy --periodogram --along space",
        "/segment",
        [5.0, 0.0],
        "mean_spectrum",
        &[3],
    ),
    ("triads fput.npz", "/law/quadratic", [-0.25, 1e-15], "", &[]),
];

#[test]
fn regress_estimates_are_written_with_what_is_known() {
    let place = fields();
    for (line, pointer, [expected, within], array, shape) in CASES {
        let line = format!("{line} --figures png --out result --force");
        let typed: Vec<String> = line.split(' ').map(|w| w.replace('~', " ")).collect();
        let typed: Vec<&str> = typed.iter().map(String::as_str).collect();
        let said = place.good(&typed);
        assert!(said.starts_with(&format!("{}: ", typed[1])), "{said}");
        let summary = place.json("result/summary.json");
        let found = summary.pointer(pointer).and_then(Value::as_f64);
        let off = (found.unwrap_or(f64::NAN) - expected).abs();
        assert!(off <= within, "{line}: {found:?}");
        let name = typed[0];
        place.has(
            "result",
            &format!("report.html {name}.npz figures/{name}.png"),
        );
        if !array.is_empty() {
            let array = place.array::<f64>(&format!("result/{name}.npz"), array);
            assert_eq!(array.shape(), shape, "{line}");
        }
    }
    let table = place.says("ridges waves.npy --figures none --out ridges");
    assert!(!table.is_empty());
    let k = place.array::<f64>("ridges/ridges.npz", "wavenumber");
    let rows = place.read("ridges/ridges.csv").lines().count();
    assert_eq!(rows, k.len() + 1);
    // An existing result is replaced on request.
    place.refuses_for(2, "modes wave.npy --out ridges", "--force");
}
