//! `cascade bicoherence` as a stranger runs it.

use ndarray::{Array1, Array2};
use ndarray_npy::NpzReader;
use test_support::fields::noise;
use test_support::place::Place;

/// A record with a quadratic part, and one without.
fn place() -> Place {
    let place = Place::new();
    let source = noise(8192, 2);
    let mut low = [0.0; 2];
    let values = Array2::from_shape_fn((8192, 2), |(n, j)| {
        low[j] = 0.7 * low[j] + source[[n, j]];
        match j {
            0 => low[j] + 0.3 * low[j] * low[j],
            _ => source[[n, j]],
        }
    });
    place.save("field.npy", &values);
    place
}

#[test]
fn regress_coupling_is_found_and_written() {
    let place = place();
    let said = place.says("bicoherence field.npy --segment 64 --dt 10us --figures png");
    let first = said.lines().next().unwrap();
    assert!(first.starts_with("field.npy: "), "{said}");
    assert!(first.contains("are coupled with"), "{said}");
    assert!(said.contains("biphase"), "{said}");
    let summary = place.json("field-bicoherence/summary.json");
    assert!(summary["above_map_level"].as_u64().unwrap() > 20);
    assert_eq!(summary["correction"], "Sidak");
    let strongest = &summary["strongest"][0];
    assert!(strongest["biphase"].as_f64().unwrap().abs() < 0.5);
    assert!(
        summary["along"]["above_level"][0].as_u64() > summary["along"]["above_level"][1].as_u64()
    );
    let file = std::fs::File::open(place.path("field-bicoherence/bicoherence.npz")).unwrap();
    let mut archive = NpzReader::new(file).unwrap();
    let cells: Array1<f64> = archive.by_name("bicoherence").unwrap();
    assert_eq!(cells.len(), 210);
    let along: Array2<f64> = archive.by_name("along_largest").unwrap();
    assert_eq!(along.dim(), (33, 2));
    place.has("field-bicoherence", "report.html figures/bicoherence.png");
    let again = [
        "bicoherence",
        "field.npy",
        "--figures",
        "none",
        "--output",
        "1",
        "--every",
        "0",
    ];
    place.bad(2, &again);
    place.good(&[&again[..], &["--force"]].concat());
}

#[test]
fn regress_what_does_not_fit_is_refused_by_its_option() {
    let place = place();
    let before = place.names();
    for (words, named) in [
        ("--site 2", "--site"),
        ("--output 2", "--output"),
        ("--along 0:3", "--along"),
        ("--segment 8192", "--segment"),
        ("--multitaper 4,7", "--multitaper"),
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
