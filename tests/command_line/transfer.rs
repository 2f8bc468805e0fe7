//! `cascade bicoherence --transfer` as a stranger runs it.

use ndarray::Array2;
use test_support::fields::noise;
use test_support::place::Place;

/// A site that is a quadratic function of the one before.
#[test]
fn regress_a_transfer_is_found_and_written() {
    let place = Place::new();
    let source = noise(4096, 2);
    let mut low = 0.0;
    let mut values = Array2::zeros((4096, 2));
    for n in 0..4096 {
        low = 0.7 * low + source[[n, 0]];
        values[[n, 0]] = low;
        values[[n, 1]] = low + 0.2 * low * low + 0.05 * source[[n, 1]];
    }
    place.save("field.npy", &values);
    let line = "bicoherence field.npy --transfer 1 --dt 1ms --resamplings 40 --figures png";
    place.says(line);
    let summary = &place.json("field-bicoherence/summary.json")["transfer"];
    assert_eq!(summary["holds"], true);
    let share = |name: &str| summary["shares"][name].as_f64().unwrap();
    assert!(share("held_out_linear") > 0.6 && share("held_out_quadratic") > 0.02);
    let archive = "field-bicoherence/bicoherence.npz";
    let frequency = place.array::<f64>(archive, "transfer_frequency");
    assert_eq!(
        frequency.len(),
        summary["outputs"].as_array().unwrap().len()
    );
    place.has("field-bicoherence", "report.html figures/bicoherence.png");
    for (words, named) in [
        ("--transfer 0", "--transfer"),
        ("--lag 3", "--transfer"),
        ("--transfer 1 --highest 1kHz", "no unit"),
    ] {
        place.refuses_for(2, &format!("bicoherence field.npy {words} --force"), named);
    }
}
