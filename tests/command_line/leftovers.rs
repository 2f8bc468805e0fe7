//! What killed runs leave, and how it goes.
#![cfg(unix)]

use std::fs;
use std::path::PathBuf;
use std::process::Child;

use test_support::place::Place;
use test_support::running::{partial, signal, sparse, start, wait_for};

/// The directory into which a run writes its spectra. An earlier one, which only tries whether that is possible, is
/// gone again by then.
fn written(place: &Place, child: &mut Child) -> String {
    let spectra = || Some(place.path(partial(place)?).join("spectra.npz"));
    // Opened is not yet written.
    let is_written = |path: PathBuf| fs::metadata(path).is_ok_and(|file| file.len() > 1 << 20);
    wait_for(child, || spectra().is_some_and(is_written));
    partial(place).unwrap()
}

#[test]
fn regress_the_next_run_removes_what_a_killed_one_left() {
    let place = test_support::pulse::place();
    sparse(&place, "long.npy", 40_000, 400);
    let before = place.names();
    let long = ["analyze", "long.npy", "--out", "result"];
    let mut killed = start(&place, &long);
    written(&place, &mut killed);
    signal(&killed, "KILL");
    killed.wait().unwrap();
    let words = ["analyze", "wave.npy", "--out", "other", "--figures", "none"];
    place.good(&words);
    let mut after = before.clone();
    after.insert("other".to_owned());
    assert_eq!(place.names(), after);

    // One that still runs is left alone.
    let mut child = start(&place, &long);
    let held = written(&place, &mut child);
    place.good(&[&words[..], &["--force"]].concat());
    assert!(place.path(held).exists());
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
