//! Limits of memory and time, as a stranger sets them.
#![cfg(target_os = "linux")]

use ndarray::{Array2, ShapeBuilder};
use ndarray_npy::NpzWriter;
use test_support::contains_all;
use test_support::fields::noise;
use test_support::place::{Place, text};
use test_support::running::{peak, shell, start};

/// The program under `ulimit -v`, in KiB: its exit code and what it says.
fn limited(place: &Place, kibibytes: u64, words: &str) -> (Option<i32>, String) {
    // What glibc reserves for each thread would count, and varies.
    let script = format!("ulimit -v {kibibytes}; MALLOC_ARENA_MAX=1 exec \"$1\" {words}");
    let output = shell(place, &script);
    (output.status.code(), text(&output.stderr))
}

#[test]
fn regress_memory_that_is_refused_is_an_error() {
    let place = Place::new();
    place.save("field.npy", &noise(8000, 1000));
    let before = place.names();
    // More is allowed than `ulimit` lets the program have: room to map the field, none to transform it.
    for words in [
        "filter field.npy --frequency 0.1:0.2 --memory 100GB --threads 1",
        "simulate --sites 1000 --samples 100000 --end-time 10 --memory 100GB",
    ] {
        let (code, said) = limited(&place, 170_000, words);
        assert_eq!(code, Some(1), "{words}: {said}");
        assert!(said.starts_with("error: "), "{said}");
        contains_all(&said, &["help: ", "refuses"]);
        assert_eq!(place.names(), before, "{words}");
    }
}

#[test]
fn regress_a_limit_of_the_process_is_memory_at_hand() {
    let place = Place::new();
    place.save("field.npy", &noise(4000, 1000));
    // A run that is allowed may be refused after all, by the stacks of threads.
    for (words, codes) in [
        ("filter field.npy --frequency 0.1:0.2 --threads 1", [1, 2]),
        (
            "simulate --sites 1000 --samples 100000 --end-time 10",
            [2; 2],
        ),
    ] {
        let (code, said) = limited(&place, 120_000, words);
        let is_known = code.is_some_and(|code| codes.contains(&code));
        assert!(is_known, "{words}: {code:?}, {said}");
        assert!(said.contains("memory"), "{said}");
    }
}

#[test]
fn regress_stated_memory_holds() {
    const PROGRAM: u64 = 16 << 20;
    let place = Place::new();
    let field = noise(4000, 2000);
    place.save("rows.npy", &field);
    let mut columns = Array2::zeros(field.dim().f());
    columns.assign(&field);
    place.save("columns.npy", &columns);
    let file = std::fs::File::create(place.path("deflated.npz")).unwrap();
    let mut archive = NpzWriter::new_compressed(file);
    archive.add_array("v", &noise(4000, 800)).unwrap();
    archive.finish().unwrap();
    let samples = 4000 * 2000;
    let cases = [
        ("analyze rows.npy --memory 68MB", 68_000_000),
        ("analyze rows.npy --memory 54MB --figures none", 54_000_000),
        (
            "analyze columns.npy --memory 65MB --figures none",
            65_000_000,
        ),
        (
            "analyze deflated.npz --memory 80MB --figures none",
            80_000_000,
        ),
        (
            "filter rows.npy --frequency 0.1:0.2 --out rows.npz",
            // The array three times, a block that is read, scratch.
            24 * samples + PROGRAM + (16 << 20),
        ),
        (
            "simulate --sites 200 --samples 20000 --end-time 100 --memory 160MB --out run.npz",
            160_000_000 + PROGRAM,
        ),
    ];
    for (words, most) in cases {
        let more = ["--force", "--threads", "2"];
        let more = &more[..if words.starts_with("simulate") { 1 } else { 3 }];
        let words: Vec<&str> = words.split(' ').chain(more.iter().copied()).collect();
        let measured = || {
            let (output, peak) = peak(start(&place, &words));
            assert!(output.status.success(), "{}", text(&output.stderr));
            peak
        };
        // The system may map files that were just written, the program among them, in larger pieces: once more.
        let first = measured();
        let least = match first > most {
            true => measured().min(first),
            false => first,
        };
        assert!(least <= most, "{words:?}: {least} of {most}");
    }
}

/// What reads a run, or runs chains: the arrays named, and what the program takes by itself.
#[test]
fn regress_peaks_of_commands_without_a_memory_option() {
    const PROGRAM: u64 = 24 << 20;
    let place = Place::new();
    let simulate = "simulate --sites 200 --samples 10000 --end-time 20";
    for (ratio, out) in [("1", "first.npz"), ("2", "second.npz")] {
        let words = format!("{simulate} --stiffness-ratio {ratio} --out {out} --quiet");
        place.says(&words);
    }
    // Times, velocities, displacements, forces, energies passed.
    let run: u64 = 8 * 10_000 * (1 + 2 * 200 + 2 * 199);
    let swept: u64 = 8 * 10_000 * (1 + 2 * 100 + 2 * 99);
    let cases = [
        // The arrays, the pages of the file that they were read from.
        ("budget first.npz --figures none --quiet", 2 * run),
        // Two runs, the pages of one file at a time.
        ("compare first.npz second.npz --quiet", 4 * run),
        (
            "sweep --sites 100 --samples 10000 --end-time 20 --vary seed=1:3 --mass-spread 0.1 --threads 2 --out sweep --quiet",
            2 * swept,
        ),
        ("localize --order 1..2", 0),
        // Pictures.
        (
            "attenuate --ratios 1,4.9 --bodies 20 --out curves --quiet",
            48 << 20,
        ),
        (
            "attenuate --against stiffness_ratio=1:8:4 --no-extremes --sites 21 --out lengths --quiet",
            48 << 20,
        ),
        // Pages of the file that the system maps ahead.
        ("inspect first.npz", run / 2),
    ];
    for (words, arrays) in cases {
        let words: Vec<&str> = words.split(' ').collect();
        let (output, peak) = peak(start(&place, &words));
        let allowed = (arrays + PROGRAM) >> 20;
        println!("{words:?}: {} of {allowed} MiB", peak >> 20);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(peak <= arrays + PROGRAM, "{words:?}: {peak} of {arrays}");
    }
}

/// A run larger than what is free is refused before it is read.
#[test]
fn regress_a_run_larger_than_memory_is_refused() {
    let place = Place::new();
    let simulate = "simulate --sites 200 --samples 20000 --end-time 20 --out run.npz --quiet";
    place.says(simulate);
    for words in ["budget run.npz", "compare run.npz run.npz"] {
        let (code, said) = limited(&place, 170_000, words);
        assert_eq!(code, Some(2), "{words}: {said}");
        contains_all(&said, &["run.npz", "memory"]);
        assert_eq!(place.names().len(), 1, "{words}");
    }
}

#[test]
fn regress_the_time_allowed_ends_a_command() {
    let place = Place::new();
    let long = "simulate --sites 3000 --samples 1000 --max-time 50ms";
    place.refuses_for(124, long, "--max-time");
    assert!(place.names().is_empty(), "{:?}", place.names());

    let sweep = "sweep --sites 60 --samples 2000 --vary seed=1:2000 --mass-spread 0.1 --out sweep";
    // A loaded machine takes longer to the first member.
    let output = [3, 12, 48].iter().find_map(|seconds| {
        let words = format!("{sweep} --max-time {seconds}s --quiet");
        let output = place.run(&words.split(' ').collect::<Vec<_>>());
        place.path("sweep").exists().then_some(output)
    });
    let output = output.expect("a member is known");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(124), "{said}");
    contains_all(&said, &["stopped with ", " known"]);
    assert!(place.path("sweep/members.jsonl").exists());
    // While the scenes are checked, nothing is there to go on from.
    let many = "sweep --sites 60 --samples 2 --vary seed=1:100000 --mass-spread 0.1 --out many --max-time 50ms";
    place.refuses_for(124, many, "nothing was written");
    assert!(!place.path("many").exists());
    place.bad(2, &["scene", "--max-time", "soon"]);
}
