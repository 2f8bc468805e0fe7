//! Fields as `cascade analyze` takes them: sizes, axes, cuts and precisions, and what is read back.

use std::fs;

use ndarray::{Array1, Array2, ArrayD};
use serde_json::Value;
use test_support::place::{Place, names, text};
use test_support::pulse::SIDECAR;

#[test]
fn intervals_may_be_open_and_the_wave_is_cut_where_it_arrives() {
    let place = test_support::pulse::place();
    for (options, shape) in [
        (&["--times", ":"][..], [96, 12]),
        (&["--times", "0.5:"], [46, 12]),
        (&["--times=-1:0.1"], [11, 12]),
        (&["--times", "0.1:9e99"], [86, 12]),
        // At site 11 the pulse first exceeds 1 % of its peak, 0.91, at s = -16: in row 30.
        (&["--until-arrival"], [30, 12]),
    ] {
        let base = [
            "analyze",
            "wave.npy",
            "--json",
            "--force",
            "--figures",
            "none",
        ];
        let said = place.good(&[&base[..], options].concat());
        let summary: Value = serde_json::from_str(&said).unwrap();
        assert_eq!(
            summary["field"]["shape"],
            Value::from(shape.to_vec()),
            "{options:?}"
        );
    }
}

#[test]
fn fields_of_a_few_samples_and_of_zeros_are_analysed() {
    let place = Place::new();
    let noise = |(i, j): (usize, usize)| (1.0 + i as f64 * 1.7 + j as f64 * 2.3).sin();
    for shape in [(1, 1), (1, 5), (5, 1), (2, 1), (1, 2), (2, 2), (3, 3)] {
        place.save("small.npy", &Array2::from_shape_fn(shape, noise));
        well_formed(&place, "small.npy");
    }
    place.save("zeros.npy", &Array2::<f64>::zeros((16, 8)));
    let summary = well_formed(&place, "zeros.npy");
    assert!(summary["direction"]["undirected"].is_null());
    assert!(summary["low_high"]["frequency"]["edge"].is_null());
}

/// Runs with figures: a summary without NaN, pictures that open.
fn well_formed(place: &Place, name: &str) -> Value {
    let said = place.good(&["analyze", name, "--force", "--out", "out"]);
    assert!(!said.contains("NaN") && !said.contains("inf"), "{said}");
    let json = fs::read_to_string(place.path("out/summary.json")).unwrap();
    assert!(
        !json.contains("NaN") && !json.contains("Infinity"),
        "{json}"
    );
    let figures = names(&place.path("out/figures"));
    assert!(figures.len() >= 14, "{figures:?}");
    for figure in figures {
        let bytes = fs::read(place.path("out/figures").join(&figure)).unwrap();
        if figure.ends_with("png") {
            let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes))
                .read_info()
                .unwrap();
            let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
            decoder.next_frame(&mut pixels).unwrap();
        } else {
            let svg = text(&bytes);
            assert!(svg.trim_end().ends_with("</svg>"), "{figure}");
            assert!(!svg.contains("NaN") && !svg.contains("\"inf"), "{figure}");
        }
    }
    serde_json::from_str(&json).unwrap()
}

#[test]
fn single_precision_is_stored_as_such() {
    let place = test_support::pulse::place();
    let base = ["analyze", "wave.npy", "--figures", "none", "-q", "--out"];
    place.good(&[&base[..], &["double"]].concat());
    place.good(&[&base[..], &["single", "--precision", "f32"]].concat());
    let (double, single) = ("double/spectra.npz", "single/spectra.npz");
    assert_eq!(place.arrays(double), place.arrays(single));
    let both = |name: &str| {
        (
            place.array::<f64>(double, name),
            place.array::<f32>(single, name),
        )
    };
    for name in place.arrays(single) {
        let (a, b) = both(&name);
        assert_eq!(a.shape(), b.shape(), "{name}");
    }
    for name in ["temporal_spectrum", "spacetime_spectrum"] {
        let (a, b) = both(name);
        close(&a, &b, 1e-6);
    }
    assert_eq!(
        place.json("single/summary.json")["accuracy"]["precision"],
        "f32"
    );
}

fn close(a: &ArrayD<f64>, b: &ArrayD<f32>, tolerance: f64) {
    let peak = a.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    assert!(peak > 0.0);
    for (x, y) in a.iter().zip(b) {
        assert!((x - f64::from(*y)).abs() <= tolerance * peak);
    }
}

#[test]
fn the_layout_only_names_the_axes() {
    let place = test_support::pulse::place();
    place.save(
        "turned.npy",
        &test_support::pulse::wave(96, 12)
            .t()
            .as_standard_layout()
            .into_owned(),
    );
    fs::copy(place.path("wave.toml"), place.path("turned.toml")).unwrap();
    let base = ["--figures", "none", "-q"];
    place.good(&[&["analyze", "wave.npy"], &base[..]].concat());
    place.good(
        &[
            &["analyze", "turned.npy", "--layout", "site-time"],
            &base[..],
        ]
        .concat(),
    );
    assert_eq!(
        fs::read(place.path("wave-cascade/spectra.npz")).unwrap(),
        fs::read(place.path("turned-cascade/spectra.npz")).unwrap()
    );
    // An option goes over the sidecar.
    let wrong = format!("{SIDECAR}layout = \"time-site\"\n");
    fs::write(place.path("turned.toml"), wrong).unwrap();
    let words = [
        "analyze",
        "turned.npy",
        "--layout",
        "site-time",
        "--dt",
        "0.5",
        "--json",
    ];
    let said = place.good(&[&words[..], &["--force", "--figures", "none"]].concat());
    let summary: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(summary["field"]["shape"], Value::from(vec![96, 12]));
    assert_eq!(summary["field"]["dt"], 0.5);
}

#[test]
fn an_axis_without_a_unit_says_so() {
    let place = test_support::pulse::place();
    fs::remove_file(place.path("wave.toml")).unwrap();
    let units = |options: &[&str]| {
        let base = ["analyze", "wave.npy", "--json", "--force"];
        let said = place.good(&[&base[..], options].concat());
        let summary: Value = serde_json::from_str(&said).unwrap();
        let page = fs::read_to_string(place.path("wave-cascade/report.html")).unwrap();
        let of = |axis: &str| summary["field"]["units"][axis].as_str().map(str::to_owned);
        (
            of("frequency").unwrap(),
            of("wavenumber").unwrap(),
            page.contains("time (samples)"),
        )
    };
    assert_eq!(
        units(&[]),
        ("cycles/sample".into(), "rad/site".into(), true)
    );
    let stepped = (
        "cycles/unit of time".into(),
        "rad/unit of length".into(),
        false,
    );
    assert_eq!(units(&["--dt", "0.01", "--dx", "2"]), stepped);
    let named = ["--dt", "10", "--time-unit", "ms", "--space-unit", "mm"];
    assert_eq!(units(&named), ("kHz".into(), "rad/mm".into(), false));
}

#[test]
fn arrays_read_back_with_their_axes() {
    let place = test_support::pulse::place();
    place.good(&[
        "analyze",
        "wave.npy",
        "--figures",
        "none",
        "-q",
        "--scaling",
        "density",
    ]);
    let npz = "wave-cascade/spectra.npz";
    let frequency: ArrayD<f64> = place.array(npz, "frequency");
    let spectrum: ArrayD<f64> = place.array(npz, "temporal_spectrum");
    assert_eq!(spectrum.shape(), [49, 12]);
    assert_eq!(frequency.len(), 49);
    let df = frequency[[1]] - frequency[[0]];
    let field = test_support::pulse::wave(96, 12);
    for (site, record) in field.columns().into_iter().enumerate() {
        let mean_square = record.iter().map(|v| v * v).sum::<f64>() / 96.0;
        let bins: Array1<f64> = (0..49).map(|m| spectrum[[m, site]]).collect();
        assert!((bins.sum() * df / mean_square - 1.0).abs() < 1e-13);
    }
}
