//! `cascade modes` as a stranger runs it.

use ndarray::{Array2, Array3};
use ndarray_npy::NpzReader;
use test_support::fields::noise;
use test_support::place::Place;

/// A wave in noise, at 0.125 cycles a sample.
fn place() -> Place {
    let place = Place::new();
    let noise = noise(2048, 12);
    let values = Array2::from_shape_fn((2048, 12), |(n, j)| {
        (0.7 * j as f64 - std::f64::consts::TAU * 0.125 * n as f64).cos() + 0.2 * noise[[n, j]]
    });
    place.save("field.npy", &values);
    place
}

#[test]
fn regress_a_wave_is_found_and_written() {
    let place = place();
    let said = place.good(&["modes", "field.npy", "--segment", "128", "--figures", "png"]);
    assert!(said.contains("a wave"), "{said}");
    let summary = place.json("field-modes/summary.json");
    let chosen = &summary["chosen"][0];
    assert_eq!(chosen["frequency"], 0.125);
    let wavenumber = chosen["waves"][0]["wavenumber"].as_f64().unwrap();
    assert!((wavenumber - 0.7).abs() < 0.01, "{wavenumber}");
    let file = std::fs::File::open(place.path("field-modes/modes.npz")).unwrap();
    let mut archive = NpzReader::new(file).unwrap();
    let eigenvalues: Array2<f64> = archive.by_name("eigenvalues").unwrap();
    assert_eq!(eigenvalues.dim(), (65, 12));
    let modes: Array3<f64> = archive.by_name("mode_real").unwrap();
    assert_eq!(modes.dim(), (1, 3, 12));
    for name in ["report.html", "figures/modes.png"] {
        assert!(place.path(format!("field-modes/{name}")).exists());
    }
}

#[test]
fn regress_what_does_not_fit_is_refused_by_its_option() {
    let place = place();
    let before = place.names();
    for (words, named) in [
        ("--frequencies 0.7", "--frequencies"),
        ("--modes 0", "--modes"),
        ("--segment 2048", "--segment"),
    ] {
        let words: Vec<&str> = ["modes", "field.npy"]
            .into_iter()
            .chain(words.split(' '))
            .collect();
        let said = place.bad(2, &words);
        assert!(said.contains(named), "{words:?}: {said}");
        assert_eq!(place.names(), before, "{words:?}");
    }
}
