//! `cascade bicoherence --transfer` as a stranger runs it.

use ndarray::{Array1, Array2};
use ndarray_npy::NpzReader;
use test_support::fields::noise;
use test_support::place::Place;

/// A site that is a quadratic function of the one before.
fn place() -> Place {
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
    place
}

#[test]
fn regress_a_transfer_is_found_and_written() {
    let place = place();
    let words = ["bicoherence", "field.npy", "--transfer", "1", "--dt", "1ms"];
    let said = place.good(&[&words[..], &["--resamplings", "40", "--figures", "png"]].concat());
    assert!(said.contains("not fitted"), "{said}");
    let summary = &place.json("field-bicoherence/summary.json")["transfer"];
    assert_eq!(summary["holds"], true);
    let shares = &summary["shares"];
    assert!(
        shares["held_out_linear"].as_f64().unwrap() > 0.6,
        "{shares}"
    );
    assert!(
        shares["held_out_quadratic"].as_f64().unwrap() > 0.02,
        "{shares}"
    );
    let file = std::fs::File::open(place.path("field-bicoherence/bicoherence.npz")).unwrap();
    let mut archive = NpzReader::new(file).unwrap();
    let frequency: Array1<f64> = archive.by_name("transfer_frequency").unwrap();
    assert_eq!(
        frequency.len(),
        summary["outputs"].as_array().unwrap().len()
    );
    for name in ["report.html", "figures/bicoherence.png"] {
        assert!(place.path(format!("field-bicoherence/{name}")).exists());
    }
}

#[test]
fn regress_what_does_not_fit_is_refused_by_its_option() {
    let place = place();
    let before = place.names();
    for (words, named) in [
        ("--transfer 0", "--transfer"),
        ("--site 2 --transfer 0", "--site"),
        ("--transfer 2", "--transfer"),
        ("--lag 3", "--transfer"),
        ("--transfer 1 --lag 4096", "--lag"),
        ("--transfer 1 --segment 256", "realisations"),
        ("--transfer 1 --highest 1e-9", "--highest"),
        ("--transfer 1 --highest 1kHz", "no unit"),
        ("--transfer 1 --resamplings 3", "--resamplings"),
    ] {
        let words: Vec<&str> = ["bicoherence", "field.npy"]
            .into_iter()
            .chain(words.split(' '))
            .collect();
        let said = place.bad(2, &words);
        assert!(said.contains(named), "{words:?}: {said}");
        assert_eq!(place.names(), before, "{words:?}");
    }
}
