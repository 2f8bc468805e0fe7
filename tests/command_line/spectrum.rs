//! `cascade spectrum` as a stranger runs it.

use ndarray::{Array2, s};
use test_support::fields::noise;
use test_support::place::Place;

/// Noise at five sites, with a line at one.
#[test]
fn regress_a_line_and_its_intervals_are_found_and_written() {
    let place = Place::new();
    let source = noise(2048, 5);
    let values = Array2::from_shape_fn((2048, 5), |(n, j)| {
        let line = (std::f64::consts::TAU * 300.0 / 2048.0 * n as f64).cos();
        source[[n, j]] + if j == 1 { line } else { 0.0 }
    });
    place.save("field.npy", &values);
    place.says("spectrum field.npy --dt 1ms --multitaper 4,7 --figures png");
    let summary = place.json("field-spectrum/summary.json");
    let lines = summary["line_test"]["lines"].as_array().unwrap();
    assert_eq!((lines.len(), &lines[0]["column"]), (1, &1.into()));
    let number = |name: &str| lines[0][name].as_f64().unwrap();
    assert!((number("at") - 300.0 / 2.048).abs() < 1e-9);
    assert!((number("amplitude") - 1.0).abs() < 4.0 * number("amplitude_error"));
    for name in ["spectrum", "low", "high", "jackknife_low", "f_statistic"] {
        let array = place.array::<f64>("field-spectrum/spectrum.npz", name);
        assert_eq!(array.shape(), [1025, 5], "{name}");
        assert!(array.slice(s![5..1024, ..]).iter().all(|v| *v > 0.0));
    }
    place.has("field-spectrum", "report.html figures/spectrum.png");
    // Along space, and a periodogram.
    let common = "spectrum field.npy --figures none --periodogram";
    place.says(&format!("{common} --along space --out k"));
    let mean = place.array::<f64>("k/spectrum.npz", "mean_spectrum");
    assert_eq!(mean.len(), 3);
    place.says(&format!("{common} --out p"));
    let summary = place.json("p/summary.json");
    let degrees = summary["degrees_of_freedom"]["median"].as_f64().unwrap();
    assert!((degrees - 2.0).abs() < 1e-9 && summary["line_test"].is_null());
    for (words, named) in [
        ("--segment 5000", "--segment"),
        ("--along both --subtract-noise", "--subtract-noise"),
        ("--along all", "--along"),
    ] {
        place.refuses_for(2, &format!("spectrum field.npy {words} --force"), named);
    }
}
