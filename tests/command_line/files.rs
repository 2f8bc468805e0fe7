//! Inputs that change while they are read, and places that results do not fit.
#![cfg(unix)]

use std::fs::{self, File};
use std::os::unix::fs::FileExt;
use std::process::Child;

use test_support::contains_all;
use test_support::place::{Place, text};
use test_support::running::{partial, shell, sparse, start, wait_for};

/// Begins an analysis of `long.npy`, and waits until its passes begin.
fn begun(place: &Place, options: &[&str]) -> Child {
    sparse(place, "long.npy", 40_000, 400);
    let words = ["analyze", "long.npy", "--out", "result"];
    let words = [&words[..], &["--figures", "none"], options].concat();
    let mut child = start(place, &words);
    wait_for(&mut child, || {
        let folder = partial(place);
        folder.is_some_and(|name| place.path(&name).join("spectra.npz").exists())
    });
    child
}

fn writable(place: &Place) -> File {
    let file = File::options().write(true).open(place.path("long.npy"));
    file.unwrap()
}

/// What is read must be what is hashed.
#[test]
fn regress_a_field_that_changes_while_it_is_read_gives_no_result() {
    let place = Place::new();
    sparse(&place, "other.npy", 40_000, 400);
    type Change = fn(&Place);
    let changes: [(Change, [&str; 2]); 5] = [
        (
            |place| fs::rename(place.path("other.npy"), place.path("long.npy")).unwrap(),
            [
                "expected the file that was opened",
                "found another in its place",
            ],
        ),
        (
            |place| writable(place).write_all_at(b"change", 1000).unwrap(),
            ["expected no modification since it was opened", "found one"],
        ),
        (
            |place| fs::remove_file(place.path("long.npy")).unwrap(),
            ["cannot read", "long.npy"],
        ),
        (
            |place| {
                let file = writable(place);
                let before = file.metadata().unwrap().modified().unwrap();
                file.write_all_at(b"change", 1000).unwrap();
                file.set_modified(before).unwrap();
            },
            ["long.npy was changed", "kept the time of modification"],
        ),
        (
            |place| writable(place).set_len(5000).unwrap(),
            [
                "error: long.npy was shortened while it was read",
                "--read copy",
            ],
        ),
    ];
    for (change, words) in changes {
        let child = begun(&place, &[]);
        change(&place);
        let output = child.wait_with_output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        contains_all(&said, &words);
        let left = place.names();
        let is_left = |name: &String| name.ends_with(".npy");
        assert!(
            left.iter().all(is_left) || words[1] == "--read copy",
            "{left:?}"
        );
    }
    // The lock of the last one went with its process: the next run removes what it left.
    let wave = |(n, j): (usize, usize)| ((7 * n + j) as f64).sin();
    place.save("wave.npy", &ndarray::Array2::from_shape_fn((64, 8), wave));
    place.good(&["spectrum", "wave.npy", "--figures", "none"]);
    let expected = test_support::place::set(&["long.npy", "wave.npy", "wave-spectrum"]);
    assert_eq!(place.names(), expected);
}

#[test]
fn regress_a_copy_may_change_on_the_disk() {
    let place = test_support::pulse::place();
    place.says("analyze wave.npy --figures none --out mapped");
    place.says("analyze wave.npy --figures none --out copied --read copy");
    let hash = |result: &str| place.json(&format!("{result}/summary.json"))["provenance"].clone();
    let (mapped, copied) = (hash("mapped"), hash("copied"));
    assert!(mapped["input_blake3"].is_string(), "{mapped}");
    assert_eq!(mapped["input_blake3"], copied["input_blake3"]);
    let spectra = |result: &str| fs::read(place.path(result).join("spectra.npz")).unwrap();
    assert!(spectra("mapped") == spectra("copied"));

    let child = begun(&place, &["--read", "copy"]);
    writable(&place).set_len(5000).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    sparse(&place, "long.npy", 40_000, 400);
    let said = place.refuses(2, "analyze long.npy --read copy --memory 100MB");
    contains_all(&said, &["a copy of the file needs 122.08 MiB"]);
}

#[test]
fn regress_a_limit_of_the_size_of_files_is_an_error() {
    let place = test_support::pulse::place();
    place.save("wider.npy", &test_support::pulse::wave(256, 64));
    let before = place.names();
    for words in [
        "analyze wider.npy --out result",
        "filter wider.npy --out part.npz --frequency 0:2",
        "filter wider.npy --out part.npy --frequency 0:2",
        "analyze wider.npy --out result --format netcdf",
        "convert wider.npy part.nc",
        "convert wider.npy part.csv",
        "simulate --sites 60 --samples 400 --out run.nc",
        "simulate --sites 60 --samples 400 --out run.npz",
    ] {
        let output = shell(&place, &format!("ulimit -f 16; exec \"$1\" {words}"));
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{words}: {output:?}");
        assert!(said.starts_with("error: cannot "), "{said}");
        contains_all(&said, &["File too large", "ulimit -f"]);
        assert!(!said.contains("partial"), "{said}");
        assert_eq!(place.names(), before, "{words}");
    }
}

/// Starts all commands at once; their exit codes.
fn at_once(place: &Place, commands: &[&[&str]]) -> Vec<Option<i32>> {
    let started: Vec<Child> = commands.iter().map(|words| start(place, words)).collect();
    let code = |child: Child| child.wait_with_output().unwrap().status.code();
    started.into_iter().map(code).collect()
}

#[test]
fn regress_of_several_runs_of_one_new_file_one_succeeds() {
    let place = test_support::pulse::place();
    for line in [
        "convert wave.npy new.npz",
        "convert wave.npy new.nc",
        "convert wave.npy new.npy",
        "convert wave.npy new.csv",
        "filter wave.npy --towards plus-x --out new.npz",
        "simulate --sites 3 --end-time 3 --out new.npz",
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        let before = place.names();
        for _ in 0..3 {
            let mut codes = at_once(&place, &[&words[..]; 4]);
            codes.sort();
            assert_eq!(codes, [Some(0), Some(2), Some(2), Some(2)], "{line}");
            for name in place.names().difference(&before) {
                assert!(name.starts_with("new."), "{name}");
                fs::remove_file(place.path(name)).unwrap();
            }
        }
    }
}

/// An array and its sidecar are of one run.
#[test]
fn regress_of_two_runs_that_replace_one_file_one_remains() {
    let place = Place::new();
    for (name, value) in [("a.npy", 1.0), ("b.npy", 2.0)] {
        place.save(name, &ndarray::Array2::from_elem((400, 100), value));
    }
    for name in ["c.npy", "c.csv"] {
        place.good(&["convert", "a.npy", name, "--dt", "1"]);
        for _ in 0..4 {
            let [a, b] = [["a.npy", "1"], ["b.npy", "2"]]
                .map(|[from, dt]| ["convert", from, name, "--dt", dt, "--force"]);
            let codes = at_once(&place, &[&a, &b, &a, &b]);
            assert_eq!(codes, [Some(0); 4], "{name}");
            let field = test_support::made::open(&place, name);
            let mut first = [0.0];
            field.read_time_major(0..1, 0..1, &mut first);
            assert_eq!(field.time.step, first[0], "{name}");
        }
    }
}
