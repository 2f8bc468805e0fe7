//! What killed runs leave, and how it goes.
#![cfg(unix)]

use std::fs;

use test_support::place::{Place, set, text};
use test_support::running::{partial, signal, sparse, start, wait_for};

/// Kills an analysis while it writes, and returns the name of what it leaves.
fn killed(place: &Place, words: &[&str]) -> String {
    let mut child = start(place, words);
    wait_for(&mut child, || {
        let folder = partial(place);
        let spectra = folder.map(|name| place.path(&name).join("spectra.npz"));
        // Opened is not yet written.
        spectra.is_some_and(|path| fs::metadata(path).is_ok_and(|file| file.len() > 1 << 20))
    });
    signal(&child, "KILL");
    child.wait().unwrap();
    partial(place).unwrap()
}

#[test]
fn regress_the_next_run_removes_what_a_killed_one_left() {
    let place = test_support::pulse::place();
    sparse(&place, "long.npy", 40_000, 400);
    let before = place.names();
    let long = ["analyze", "long.npy", "--out", "result"];
    killed(&place, &long);
    let words = ["analyze", "wave.npy", "--out", "other", "--figures", "none"];
    place.good(&words);
    let mut after = before.clone();
    after.insert("other".to_owned());
    assert_eq!(place.names(), after);

    // One that still runs is left alone.
    let mut child = start(&place, &long);
    wait_for(&mut child, || partial(&place).is_some());
    let held = partial(&place);
    place.good(&[&words[..], &["--force"]].concat());
    assert_eq!(partial(&place), held);
    signal(&child, "TERM");
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert_eq!(place.names(), after);
}

/// A kill between the two renames, where names cannot be exchanged at once.
#[test]
fn regress_an_old_result_that_a_kill_took_away_comes_back() {
    let place = test_support::pulse::place();
    let words = "analyze wave.npy --out result --figures none";
    place.says(words);
    let stem = ".cascade-partial-0123456789abcdef";
    fs::rename(place.path("result"), place.path(format!("{stem}.old"))).unwrap();
    place.write(format!("{stem}.lock"), "\nresult");
    place.good(&["analyze", "wave.npy", "--out", "b", "--figures", "none"]);
    assert!(place.path("result/summary.json").exists());
}

#[test]
fn regress_processes_of_one_target_do_not_mix() {
    let place = Place::new();
    for (name, sites) in [("a.npy", 200), ("b.npy", 201)] {
        sparse(&place, name, 4000, sites);
    }
    let words = |field| ["analyze", field, "--out", "result", "--figures", "none"];
    let mut said = String::new();
    for _ in 0..4 {
        let children = ["a.npy", "b.npy"].map(|field| start(&place, &words(field)));
        let outputs = children.map(|child| child.wait_with_output().unwrap());
        let codes = outputs.each_ref().map(|output| output.status.code());
        said += &outputs.map(|output| text(&output.stderr)).concat();
        assert!(codes.contains(&Some(0)), "{said}");
        let sites = place.json("result/summary.json")["field"]["shape"][1].as_u64();
        let spectra = place.array::<f64>("result/spectra.npz", "temporal_spectrum");
        assert_eq!(spectra.shape()[1] as u64, sites.unwrap());
        assert_eq!(place.names(), set(&["a.npy", "b.npy", "result"]));
        fs::remove_dir_all(place.path("result")).unwrap();
    }
}
