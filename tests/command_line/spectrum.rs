//! `cascade spectrum` as a stranger runs it.

use ndarray::Array2;
use ndarray_npy::NpzReader;
use test_support::fields::noise;
use test_support::place::Place;

/// Noise at five sites, with a line at one.
fn place() -> Place {
    let place = Place::new();
    let source = noise(2048, 5);
    let values = Array2::from_shape_fn((2048, 5), |(n, j)| {
        let line = (std::f64::consts::TAU * 300.0 / 2048.0 * n as f64).cos();
        source[[n, j]] + if j == 1 { line } else { 0.0 }
    });
    place.save("field.npy", &values);
    place
}

fn arrays(place: &Place, name: &str) -> NpzReader<std::fs::File> {
    let path = place.path(format!("{name}/spectrum.npz"));
    NpzReader::new(std::fs::File::open(path).unwrap()).unwrap()
}

#[test]
fn regress_a_line_and_its_intervals_are_found_and_written() {
    let place = place();
    let words = [
        "spectrum",
        "field.npy",
        "--dt",
        "1ms",
        "--multitaper",
        "4,7",
    ];
    place.good(&[&words[..], &["--figures", "png"]].concat());
    let summary = place.json("field-spectrum/summary.json");
    let lines = summary["line_test"]["lines"].as_array().unwrap();
    assert_eq!(lines.len(), 1, "{lines:?}");
    let number = |name: &str| lines[0][name].as_f64().unwrap();
    assert_eq!(lines[0]["column"], 1);
    assert!((number("at") - 300.0 / 2.048).abs() < 1e-9);
    assert!((number("amplitude") - 1.0).abs() < 4.0 * number("amplitude_error"));
    let degrees = summary["degrees_of_freedom"]["median"].as_f64().unwrap();
    assert!((12.0..=14.0).contains(&degrees), "{degrees}");
    let mut archive = arrays(&place, "field-spectrum");
    for name in ["spectrum", "low", "high", "jackknife_low", "f_statistic"] {
        let array: Array2<f64> = archive.by_name(name).unwrap();
        assert_eq!(array.dim(), (1025, 5), "{name}");
        assert!(
            array
                .slice(ndarray::s![1..1024, ..])
                .iter()
                .all(|v| *v > 0.0)
        );
    }
    for name in ["report.html", "figures/spectrum.png"] {
        assert!(place.path(format!("field-spectrum/{name}")).exists());
    }
    let page = std::fs::read_to_string(place.path("field-spectrum/report.html")).unwrap();
    assert!(page.contains("95 % interval"));
    // Along space, and a periodogram.
    let common = [
        "spectrum",
        "field.npy",
        "--figures",
        "none",
        "--periodogram",
    ];
    place.good(&[&common[..], &["--along", "space", "--out", "k", "--quiet"]].concat());
    let mean: ndarray::Array1<f64> = arrays(&place, "k").by_name("mean_spectrum").unwrap();
    assert_eq!(mean.len(), 3);
    place.good(&[&common[..], &["--out", "p"]].concat());
    let summary = place.json("p/summary.json");
    assert!((summary["degrees_of_freedom"]["median"].as_f64().unwrap() - 2.0).abs() < 1e-9);
    assert!(summary["line_test"].is_null());
}

#[test]
fn regress_what_does_not_fit_is_refused_by_its_option() {
    let place = place();
    let before = place.names();
    for (words, named) in [
        ("--segment 5000", "--segment"),
        ("--multitaper 4,9", "--multitaper"),
        ("--equal-weights", "--multitaper"),
        ("--periodogram --segment 64", "--segment"),
        ("--along all", "--along"),
    ] {
        let words: Vec<&str> = ["spectrum", "field.npy"]
            .into_iter()
            .chain(words.split(' '))
            .collect();
        let said = place.bad(2, &words);
        assert!(said.contains(named), "{words:?}: {said}");
        assert_eq!(place.names(), before, "{words:?}");
    }
}
