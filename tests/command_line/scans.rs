//! Files with one record each, and uneven samples, on the command line.
//!
//! `val_pyuff_*`, `val_segyio_*`: scans written by pyuff 2.5.8 and segyio 1.9.14 on 2026-11-25, and the field that
//! they are (`data/make_scan_files.py`).

use std::fs;

use serde_json::Value;
use test_support::made::{open, values};
use test_support::place::Place;

/// A scan of `tests/data` is converted, is the expected field, and its analysis is that of the converted field.
fn converted(kind: &str, options: &str) {
    let expected: Value = serde_json::from_str(include_str!("../data/scan_files.json")).unwrap();
    let expected = &expected[kind];
    let numbers = |of: &Value| -> Vec<f64> {
        let numbers = of.as_array().unwrap().iter();
        numbers.map(|v| v.as_f64().unwrap()).collect()
    };
    let place = Place::new();
    let from = format!("{}/tests/data/scan_{kind}", env!("CARGO_MANIFEST_DIR"));
    fs::create_dir(place.path("scan")).unwrap();
    for file in fs::read_dir(from).unwrap() {
        let file = file.unwrap();
        fs::copy(file.path(), place.path("scan").join(file.file_name())).unwrap();
    }
    place.says(&format!("convert scan/* field.nc --quiet {options}"));
    let field = open(&place, "field.nc");
    let found = values(&field);
    let rows: Vec<Vec<f64>> = found.outer_iter().map(|row| row.to_vec()).collect();
    let samples = expected["samples"].as_array().unwrap().iter();
    assert_eq!(rows, samples.map(numbers).collect::<Vec<_>>());
    for (found, key) in [(field.time.origin, "t0"), (field.time.step, "dt")] {
        let wanted = expected[key].as_f64().unwrap();
        assert!(
            (found - wanted).abs() <= 1e-15 * wanted.abs(),
            "{key}: {found}"
        );
    }
    let positions = numbers(&expected["positions"]);
    assert_eq!(field.space.origin, positions[0]);
    assert_eq!(field.space.step, positions[1] - positions[0]);
    for (found, key) in [
        (field.time.unit, "time_unit"),
        (field.space.unit, "space_unit"),
    ] {
        assert_eq!(found.as_deref(), expected[key].as_str());
    }
    // What the files state and the field says is the same on both ways.
    let spectra = [format!("scan/* {options}"), "field.nc".to_owned()].map(|of| {
        place.says(&format!(
            "analyze {of} --out a --figures none --quiet --force"
        ));
        fs::read(place.path("a/spectra.npz")).unwrap()
    });
    assert!(spectra[0] == spectra[1]);
}

#[test]
fn val_pyuff_a_scan_of_universal_files() {
    converted("uff", "--position-from header");
}

#[test]
fn val_segyio_a_scan_of_seg_y_files() {
    converted("segy", "--position-from header:group_x");
}
