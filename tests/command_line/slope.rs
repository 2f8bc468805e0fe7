//! `cascade slope` as a stranger runs it.

use ndarray::Array2;
use test_support::place::Place;

#[test]
fn regress_a_power_law_is_found_and_written() {
    let place = Place::new();
    let tau = std::f64::consts::TAU;
    let values = Array2::from_shape_fn((20, 128), |(i, j)| {
        let term = |m: usize| {
            let angle = tau * (m * j) as f64 / 128.0 + (i * m * m) as f64;
            angle.cos() / m as f64
        };
        (1..60).map(term).sum::<f64>()
    });
    place.save("field.npy", &values);
    let periodic = ["--window", "none", "--detrend", "none"];
    let words = [
        &[
            "slope",
            "field.npy",
            "--band",
            "0.1:1.5",
            "--figures",
            "png",
        ][..],
        &periodic,
    ]
    .concat();
    let said = place.good(&words);
    assert!(said.contains("interval of the regression"), "{said}");
    let summary = place.json("field-slope/summary.json");
    let slope = summary["law"]["slope"].as_f64().unwrap();
    assert!((slope + 2.0).abs() < 1e-9, "{slope}");
    for name in ["report.html", "slope.npz", "figures/slope.png"] {
        assert!(place.path(format!("field-slope/{name}")).exists());
    }
    // Sites that are 1 mm apart: the same band in another unit.
    let again = ["--dx", "1mm", "--figures", "none", "--out", "again"];
    let in_metres = ["slope", "field.npy", "--band", "100rad/m:1.5rad/mm"];
    place.good(&[&in_metres[..], &periodic, &again].concat());
    let again = place.json("again/summary.json")["law"]["slope"].as_f64();
    assert!((again.unwrap() - slope).abs() < 1e-12, "{again:?}");
    let before = place.names();
    for (words, named) in [
        ("--band 1kHz:2kHz", "--along time"),
        ("--band 1rad/m:2rad/m", "no unit"),
        ("--band 1.5:0.1", "lower"),
        ("--band 0.1:0.15", "--band"),
        ("--band 0.1:1.5 --breaks 3", "--breaks"),
        ("", "--band"),
    ] {
        let words: Vec<&str> = ["slope", "field.npy", "--force"]
            .into_iter()
            .chain(words.split_whitespace())
            .collect();
        let said = place.bad(2, &words);
        assert!(said.contains(named), "{words:?}: {said}");
        assert_eq!(place.names(), before, "{words:?}");
    }
}
