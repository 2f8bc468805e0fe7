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
    let periodic = "slope field.npy --layout time-site --window none --detrend none";
    place.says(&format!("{periodic} --band 0.1:1.5 --figures png"));
    let slope = |of: &str| {
        let summary = place.json(&format!("{of}/summary.json"));
        summary["law"]["slope"].as_f64().unwrap()
    };
    assert!((slope("field-slope") + 2.0).abs() < 1e-9);
    place.has("field-slope", "report.html slope.npz figures/slope.png");
    // Sites that are 1 mm apart: the same band in another unit.
    let in_metres = "--band 100rad/m:1.5rad/mm --dx 1mm --figures none --out again";
    place.says(&format!("{periodic} {in_metres}"));
    assert!((slope("again") - slope("field-slope")).abs() < 1e-12);
    for (words, named) in [
        ("--band 1kHz:2kHz", "--along time"),
        ("--band 1rad/m:2rad/m", "no unit"),
        ("--band 1.5:0.1", "lower"),
        ("", "--band"),
    ] {
        place.refuses_for(
            2,
            &format!("slope field.npy --layout time-site --force {words}"),
            named,
        );
    }
}
