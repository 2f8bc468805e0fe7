//! Files with one record each, and uneven samples, on the command line.
//!
//! `val_pyuff_*`, `val_segyio_*`: scans written by pyuff 2.5.8 and segyio 1.9.14 on 2026-11-25, and the field that
//! they are (`data/make_scan_files.py`).

use std::fs;

use serde_json::Value;
use test_support::made::{open, values};
use test_support::place::{Place, text};

/// A wave of 96 times at 12 positions, the times of site j later by j steps.
fn scan() -> Place {
    let place = Place::new();
    fs::create_dir(place.path("line")).unwrap();
    for j in 0..12 {
        let row = |n: usize| {
            let s = n as f64 + j as f64 - 2.0 * j as f64 - 30.0;
            let v = (-(s / 5.0f64).powi(2)).exp() * (0.8 * s).cos();
            let hammer = (-(n as f64 - 8.0).powi(2) / 4.0).exp();
            format!("{},{v:e},{hammer:e}\n", n + j)
        };
        let rows: String = (0..96).map(row).collect();
        let file = format!("line/x={}mm.csv", 5 * j);
        place.write(file, format!("time_us,v,hammer\n{rows}"));
    }
    place
}

#[test]
fn the_files_of_a_scan_are_one_field() {
    let place = scan();
    let line = "analyze line/*.csv --position-from name --channel v";
    let said = place.says(line);
    assert!(said.contains("12 files are one field"), "{said}");
    let summary = place.json("line-cascade/summary.json");
    assert_eq!(summary["field"]["shape"], serde_json::json!([85, 12]));
    let provenance = &summary["provenance"];
    let input = provenance["input"].as_str().unwrap();
    assert!(input.starts_with("12 files, line/x=0mm.csv to "), "{input}");
    assert_eq!(provenance["input_blake3"].as_str().unwrap().len(), 64);
    let table = place.read("line-cascade/records.csv");
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!((rows.len(), rows[2]), (13, "line/x=5mm.csv,5,96,-1,0,"));
    // It is a result that can be replaced, and planned.
    place.says(&format!("{line} --force --quiet"));
    assert!(place.says(&format!("{line} --plan --quiet")).contains("12"));
    for (words, named) in [
        ("--position-from name", "--channel"),
        ("--position-from sideways", "name, header, or a table"),
        ("--reference hammer", "--position-from"),
        ("--position-from name --channel w", "v, hammer"),
    ] {
        let said = place.refuses(2, &format!("analyze line/*.csv {words} --force"));
        let said = test_support::made::in_one_line(&said);
        assert!(said.contains(named), "{words}: {said}");
    }
}

#[test]
fn inspection_and_conversion_show_what_is_taken_of_each_file() {
    let place = scan();
    for command in ["inspect line/*.csv", "convert line/*.csv field.nc"] {
        let line = format!("{command} --position-from name --reference hammer --json");
        let output = place.run(&line.split(' ').collect::<Vec<_>>());
        assert!(output.status.success(), "{}", text(&output.stderr));
        let listed: Value = serde_json::from_slice(&output.stdout).unwrap();
        let records = listed["records"].as_array().unwrap();
        assert_eq!((records.len(), &records[3]["position"]), (12, &15.0.into()));
        let is_alike = |record: &Value| record["correlation"].as_f64().unwrap() > 0.999;
        assert!(records.iter().all(is_alike), "{listed}");
    }
    // The shell expands patterns that are not quoted; the last word is the file to write.
    let two = "convert line/x=0mm.csv line/x=5mm.csv";
    place.says(&format!(
        "{two} two.npy --position-from name --channel v --quiet"
    ));
    assert_eq!(open(&place, "two.npy").n_sites(), 2);
    for (line, named) in [
        ("inspect line/*.csv".to_owned(), "--position-from"),
        (format!("{two} two.npy"), "--position-from"),
        (
            format!("{two} line/x=10mm.csv --position-from name --channel v"),
            "line/x=10mm.csv",
        ),
    ] {
        place.refuses_for(2, &line, named);
    }
}

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
