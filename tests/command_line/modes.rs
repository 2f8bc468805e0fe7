//! `cascade modes` as a stranger runs it.

use ndarray::Array2;
use test_support::fields::noise;
use test_support::place::Place;

/// A wave in noise, at 0.125 cycles a sample.
#[test]
fn regress_a_wave_is_found_and_written() {
    let place = Place::new();
    let noise = noise(2048, 12);
    let values = Array2::from_shape_fn((2048, 12), |(n, j)| {
        (0.7 * j as f64 - std::f64::consts::TAU * 0.125 * n as f64).cos() + 0.2 * noise[[n, j]]
    });
    place.save("field.npy", &values);
    let said = place.says("modes field.npy --segment 128 --figures png");
    assert!(said.contains("coherent modes at 0.125"), "{said}");
    let summary = place.json("field-modes/summary.json");
    let chosen = &summary["chosen"][0];
    assert_eq!(chosen["frequency"], 0.125);
    let wavenumber = chosen["waves"][0]["wavenumber"].as_f64().unwrap();
    assert!((wavenumber - 0.7).abs() < 0.01, "{wavenumber}");
    let shape = |name: &str| {
        let array = place.array::<f64>("field-modes/modes.npz", name);
        array.shape().to_vec()
    };
    assert_eq!(shape("eigenvalues"), [65, 12]);
    assert_eq!(shape("mode_real"), [1, 3, 12]);
    place.has("field-modes", "report.html figures/modes.png");
    let said = place.refuses(2, "modes field.npy --frequencies 0.7 --force");
    assert!(said.contains("--frequencies"), "{said}");
}
