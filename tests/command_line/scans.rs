//! Files with one record each, and uneven samples, on the command line.
//!
//! `val_pyuff_*`, `val_segyio_*`: scans written by pyuff 2.5.8 and segyio 1.9.14 on 2026-11-25, and the field that
//! they are (`data/make_scan_files.py`).

use std::fs;

use serde_json::Value;
use test_support::made::{open, values};
use test_support::place::{Place, set, text};

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
        fs::write(place.path(file), format!("time_us,v,hammer\n{rows}")).unwrap();
    }
    place
}

#[test]
fn the_files_of_a_scan_are_one_field() {
    let place = scan();
    let words = [
        "analyze",
        "line/*.csv",
        "--position-from",
        "name",
        "--channel",
        "v",
    ];
    let said = place.good(&words);
    assert!(said.contains("12 files are one field"), "{said}");
    assert!(
        said.contains("-11 to 0 samples later in a record"),
        "{said}"
    );
    let summary = place.json("line-cascade/summary.json");
    assert_eq!(summary["field"]["shape"], serde_json::json!([85, 12]));
    let input = summary["provenance"]["input"].as_str().unwrap();
    assert!(input.starts_with("12 files, line/x=0mm.csv to "), "{input}");
    assert_eq!(
        summary["provenance"]["input_blake3"]
            .as_str()
            .unwrap()
            .len(),
        64
    );
    let table = fs::read_to_string(place.path("line-cascade/records.csv")).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows.len(), 13);
    assert_eq!(rows[2], "line/x=5mm.csv,5,96,-1,0,");
    // It is a result that can be replaced, and planned.
    place.good(&[&words[..], &["--force", "--quiet"]].concat());
    assert!(
        place
            .good(&[&words[..], &["--plan", "--quiet"]].concat())
            .contains("12")
    );
}

#[test]
fn inspection_shows_what_is_taken_of_each_file() {
    let place = scan();
    let words = [
        "inspect",
        "line/*.csv",
        "--position-from",
        "name",
        "--reference",
        "hammer",
    ];
    let said = place.good(&words);
    for part in [
        "12 files as a field",
        "96 times",
        "12 sites from 0 mm by 5.000 mm",
        "..",
        "line/x=55mm.csv",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert!(!said.contains("line/x=25mm.csv"), "{said}");
    let listed: Value =
        serde_json::from_str(&place.good(&[&words[..], &["--json"]].concat())).unwrap();
    let records = listed["records"].as_array().unwrap();
    assert_eq!(
        (records.len(), &records[3]["position"]),
        (12, &serde_json::json!(15.0))
    );
    assert!(
        records
            .iter()
            .all(|record| record["correlation"].as_f64().unwrap() > 0.999)
    );
    assert_eq!(listed["field"]["space"]["step"], 5.0);
}

#[test]
fn what_is_no_scan_is_refused_with_advice() {
    let place = scan();
    let table = "file,position_mm\nx=0mm.csv,0\n";
    fs::write(place.path("where.csv"), table).unwrap();
    for (words, code, parts) in [
        (
            "--position-from name",
            2,
            &["expected one record, found 2", "--channel"][..],
        ),
        (
            "--position-from where.csv --channel v",
            2,
            &["a position in where.csv", "add a row"],
        ),
        (
            "--position-from name --channel w",
            2,
            &["\"w\", found v, hammer"],
        ),
        (
            "--position-from sideways",
            2,
            &["expected name, header, or a table"],
        ),
        ("--reference hammer", 2, &["--position-from"]),
        (
            "--position-from header --channel v",
            2,
            &["the headers", "--position-from table.csv"],
        ),
        ("--position-from name:y --channel v", 2, &["the names"]),
        (
            "--position-from name --channel v --resample fast",
            2,
            &["expected nearest, linear or cubic"],
        ),
        ("--position-from name --channel v --dx -1", 2, &["above 0"]),
    ] {
        let words: Vec<&str> = ["analyze", "line/*.csv"]
            .into_iter()
            .chain(words.split(' '))
            .collect();
        let output = place.command(&words).output().unwrap();
        let said = text(&output.stderr)
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
        for part in parts {
            assert!(said.contains(part), "{part}: {said}");
        }
    }
    assert_eq!(place.names(), set(&["line", "where.csv"]));
    // Without the option they are several fields, which inspection does not list.
    let output = place.command(["inspect", "line/*.csv"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("--position-from"));
}

#[test]
fn uneven_times_are_refused_or_resampled() {
    let place = Place::new();
    let time = |n: usize| n as f64 + if n % 5 == 2 { 0.2 } else { 0.0 };
    let row = |n: usize| {
        format!(
            "{},{},{}\n",
            time(n),
            (0.3 * time(n)).sin(),
            (0.3 * time(n) - 1.0).sin()
        )
    };
    let rows: String = (0..64).map(row).collect();
    fs::write(place.path("v.csv"), format!("time_s,a,b\n{rows}")).unwrap();
    let output = place.command(["analyze", "v.csv"]).output().unwrap();
    let said = text(&output.stderr);
    assert!(
        said.contains("line ") && said.contains("--resample cubic"),
        "{said}"
    );
    let said = place.good(&[
        "analyze",
        "v.csv",
        "--resample",
        "time=linear",
        "--out",
        "r",
    ]);
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("linear interpolation"), "{said}");
    let warnings = &place.json("r/summary.json")["warnings"];
    let is_it = |warning: &Value| warning["code"] == "resampled";
    assert!(warnings.as_array().unwrap().iter().any(is_it), "{warnings}");
    place.good(&["analyze", "v.csv", "--resample", "cubic", "--out", "c"]);
    let summary = place.json("c/summary.json");
    assert!(!summary["warnings"].as_array().unwrap().iter().any(is_it));
    let read_as = summary["provenance"]["read_as"].to_string();
    assert!(read_as.contains("cubic interpolation"), "{read_as}");
}

/// A scan of `tests/data` is converted to every format, each the expected field, and its analysis is that of the
/// converted field.
fn converted(kind: &str, options: &[&str]) {
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
    let pattern = "scan/*";
    let positions = numbers(&expected["positions"]);
    for out in ["field.nc", "field.npz", "field.npy", "field.csv"] {
        let words = [&["convert", pattern, out, "--quiet"][..], options].concat();
        place.good(&words);
        let field = open(&place, out);
        let rows: Vec<Vec<f64>> = values(&field)
            .outer_iter()
            .map(|row| row.to_vec())
            .collect();
        let samples = expected["samples"].as_array().unwrap().iter();
        assert_eq!(rows, samples.map(numbers).collect::<Vec<_>>(), "{out}");
        let near = |found: f64, wanted: &Value| {
            let wanted = wanted.as_f64().unwrap();
            assert!(
                (found - wanted).abs() <= 1e-15 * wanted.abs(),
                "{out}: {found} {wanted}"
            );
        };
        near(field.time.origin, &expected["t0"]);
        near(field.time.step, &expected["dt"]);
        assert_eq!(
            field.time.unit.as_deref(),
            expected["time_unit"].as_str(),
            "{out}"
        );
        assert_eq!(field.space.origin, positions[0], "{out}");
        assert_eq!(field.space.step, positions[1] - positions[0], "{out}");
        assert_eq!(
            field.space.unit.as_deref(),
            expected["space_unit"].as_str(),
            "{out}"
        );
    }
    // What the files state and the field says is the same on both ways.
    for (words, out) in [
        ([&["analyze", pattern][..], options].concat(), "a"),
        (vec!["analyze", "field.nc"], "b"),
    ] {
        place.good(&[&words[..], &["--out", out, "--figures", "none", "--quiet"]].concat());
    }
    let spectra = |of: &str| fs::read(place.path(of).join("spectra.npz")).unwrap();
    assert!(spectra("a") == spectra("b"));
}

#[test]
fn val_pyuff_a_scan_of_universal_files() {
    converted("uff", &["--position-from", "header"]);
}

#[test]
fn val_segyio_a_scan_of_seg_y_files() {
    converted("segy", &["--position-from", "header:group_x"]);
}

#[test]
fn a_scan_is_converted_with_what_was_taken_of_each_file() {
    let place = scan();
    let words = [
        "convert",
        "line/*.csv",
        "field.nc",
        "--position-from",
        "name",
        "--reference",
        "hammer",
        "--json",
    ];
    let output = place.run(&words);
    let notes = text(&output.stderr);
    assert!(
        notes.contains("12 files are one field") && notes.contains("hammer"),
        "{notes}"
    );
    let said: Value = serde_json::from_slice(&output.stdout).unwrap();
    let records = said["records"].as_array().unwrap();
    assert_eq!((records.len(), &said["shape"][1]), (12, &12.into()));
    assert_eq!(records[3]["position"], 15.0);
    assert!(
        records
            .iter()
            .all(|record| record["correlation"].as_f64().unwrap() > 0.999)
    );
    // The shell expands patterns that are not quoted; the last word is the file to write.
    let words = [
        "convert",
        "line/x=0mm.csv",
        "line/x=5mm.csv",
        "two.npy",
        "--position-from",
        "name",
        "--channel",
        "v",
    ];
    place.good(&[&words[..], &["--quiet"]].concat());
    assert_eq!(open(&place, "two.npy").n_sites(), 2);
    let said = place.bad(2, &words[..4]);
    assert!(
        said.contains("--position-from: expected it beside several files"),
        "{said}"
    );
    let said = place.bad(
        2,
        &[
            "convert",
            "line/*.csv",
            "line/x=0mm.csv",
            "--position-from",
            "name",
            "--channel",
            "v",
        ],
    );
    assert!(said.contains("is no field of this program"), "{said}");
    let said = place.bad(
        2,
        &["convert", "none/*.uff", "a.nc", "--position-from", "name"],
    );
    assert!(said.contains("none/*.uff"), "{said}");
}
