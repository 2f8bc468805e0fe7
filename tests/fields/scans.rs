//! Files with one record each as one field.
//!
//! `val_identity_*`: records cut from one field, which comes back bit for bit. `val_numpy_*`: delays by
//! `data/interpolation.py` with NumPy 2.4.6 on 2026-11-25. `val_closed_form_*`: pulses and sines at known
//! times.

use std::fs;
use std::path::PathBuf;

use ndarray::{Array1, Array2, s};
use test_support::hostile::unescaped;
use test_support::made::values;
use test_support::netcdf::netcdf;
use test_support::place::Place;
use wavecascade::field::{EqualPositions, OpenOptions, PositionFrom, Scan, Scanned};
use wavecascade::{Error, Field};

use crate::read::{file, holds, options};
use crate::resample::{numbers, reference};

const TIMES: usize = 120;
const SITES: usize = 7;

fn wave() -> Array2<f64> {
    Array2::from_shape_fn((TIMES, SITES), |(n, j)| {
        let s = n as f64 - 3.0 * j as f64 - 30.0;
        (-(s / 6.0).powi(2)).exp() * (0.9 * s).sin() + 1e-3 * ((n * 7 + j) as f64).cos()
    })
}

/// Times of the field that the record of site j has.
fn span(j: usize) -> std::ops::Range<usize> {
    3 * (j % 3)..TIMES - 2 * (j % 4)
}

fn by_name() -> Scan {
    Scan::new(PositionFrom::Name(None))
}

fn opened(scan: &Scan, paths: &[PathBuf]) -> Scanned {
    scan.open(paths, &OpenOptions::default()).unwrap()
}

fn fault(scan: &Scan, paths: &[PathBuf], options: &OpenOptions) -> (PathBuf, String) {
    match scan.open(paths, options) {
        Err(Error::Scan { path, fault }) => (path, fault.to_string()),
        Err(Error::Input { path, fault }) => (path, fault.to_string()),
        other => panic!("{other:?}"),
    }
}

/// The records of the wave as files `name(j)`, each with its own times of 0.25 ms a step.
fn save(place: &Place, name: impl Fn(usize) -> String) -> Vec<PathBuf> {
    let wave = wave();
    let files = (0..SITES).map(|j| {
        let record = wave.slice(s![span(j), j]);
        let path = place.path(name(j));
        let t0 = 0.25 * span(j).start as f64;
        match path.extension().unwrap().to_str().unwrap() {
            "npy" => {
                ndarray_npy::write_npy(&path, &record.to_owned()).unwrap();
                let sidecar = format!("dt = \"0.25 ms\"\nt0 = {t0}\ntime_unit = \"ms\"\nx0 = {}\nspace_unit = \"mm\"\n", 2 * j);
                fs::write(path.with_extension("toml"), sidecar).unwrap();
            }
            "csv" => {
                let rows = record.iter().enumerate();
                let rows: String = rows.map(|(n, v)| format!("{},{v:e}\n", t0 + 0.25 * n as f64)).collect();
                fs::write(&path, format!("time_ms,v\n{rows}")).unwrap();
            }
            _ => {
                let values: Vec<String> = record.iter().map(|v| format!("{v:e}")).collect();
                let file = netcdf(&format!(
                    "time={}; time(time) f8 {t0}:0.25 units=ms; velocity(time) f8 [{}]; x() f8 [{}] units=mm; z() f8 [7] units=mm",
                    record.len(), values.join(","), 2 * j
                ));
                fs::write(&path, file).unwrap();
            }
        }
        path
    });
    // Not in the order of their positions.
    let mut files: Vec<PathBuf> = files.collect();
    files.rotate_left(3);
    files
}

fn check(scanned: &Scanned) {
    let common = 6..TIMES - 6;
    let field = &scanned.field;
    assert_eq!(values(field), wave().slice(s![common, ..]));
    assert_eq!((field.time.origin, field.time.step), (1.5, 0.25));
    assert_eq!(field.time.unit.as_deref(), Some("ms"));
    assert_eq!((field.space.origin, field.space.step), (0.0, 2.0));
    assert_eq!(field.space.unit.as_deref(), Some("mm"));
    for (j, record) in scanned.records.iter().enumerate() {
        assert_eq!(record.position, 2.0 * j as f64);
        assert_eq!(record.n_times, span(j).len());
        assert_eq!((record.delay, record.left), (-(span(j).start as f64), 0.0));
    }
}

#[test]
fn val_identity_records_are_the_field_that_they_were_cut_from() {
    let letter = |j: usize| char::from(b'a' + j as u8);
    for (from, extension) in [
        ("name", "npy"),
        ("name", "csv"),
        ("name", "nc"),
        ("header", "npy"),
        ("header", "nc"),
        ("table", "npy"),
    ] {
        let place = Place::new();
        let files = save(&place, |j| match from {
            "name" => format!("scan3_x={}mm.{extension}", 2 * j),
            _ => format!("{}.{extension}", letter(j)),
        });
        let rows = (0..SITES).map(|j| format!("{}.npy,{}\n", letter(j), 2 * j));
        let rows: String = rows.collect();
        let table = format!("file,position_mm\n{rows}other.npy,99\n");
        place.write("positions.csv", table);
        let scan = Scan::new(match from {
            "name" => PositionFrom::Name(None),
            "header" => PositionFrom::Header(None),
            _ => PositionFrom::Table(place.path("positions.csv")),
        });
        check(&opened(&scan, &files));
        // The same in a scratch file.
        if extension != "csv" {
            check(&scan.open(&files, &options("memory=5000")).unwrap());
        }
        // Metres are asked for.
        let field = scan.open(&files, &options("space-unit=m")).unwrap().field;
        assert_eq!(field.space.step, 0.002);
        assert_eq!(field.space.unit.as_deref(), Some("m"));
    }
}

/// Records of one hammer blow each, under different delays.
fn save_struck(place: &Place, delays: &[f64], times: usize) -> Vec<PathBuf> {
    let blow = |t: f64| (-(t - 40.0).powi(2) / 50.0).exp();
    let files = delays.iter().enumerate().map(|(j, delay)| {
        let row = |n: usize| {
            let t = n as f64 - delay;
            format!(
                "{n},{:e},{:e}\n",
                blow(t),
                (0.05 * (t - 2.0 * j as f64)).sin()
            )
        };
        let path = place.path(format!("x={j}.csv"));
        let rows: String = (0..times).map(row).collect();
        fs::write(&path, format!("time,hammer,v\n{rows}")).unwrap();
        path
    });
    files.collect()
}

#[test]
fn val_closed_form_records_are_aligned_by_a_reference() {
    let place = Place::new();
    let delays = [5.0, 0.0, 17.0, 9.0];
    let files = save_struck(&place, &delays, 200);
    let mut scan = by_name();
    scan.reference = Some("hammer".into());
    let scanned = opened(&scan, &files);
    let found = values(&scanned.field);
    assert_eq!(found.dim(), (183, 4));
    for (j, record) in scanned.records.iter().enumerate() {
        assert_eq!((record.delay - record.left).round(), delays[j] - 5.0);
        assert!(record.left.abs() < 1e-5, "{record:?}");
        assert!(record.correlation.unwrap() > 0.999, "{record:?}");
        for n in 0..183 {
            let t = scanned.field.time.at(n) - 5.0;
            let expected = (0.05 * (t - 2.0 * j as f64)).sin();
            assert!((found[[n, j]] - expected).abs() < 1e-14);
        }
    }
    // The hammer by its number, and the record by its name.
    scan.reference = Some("0".into());
    scan.channel = Some("v".into());
    assert_eq!(values(&opened(&scan, &files).field), found);
    scan.reference = Some("drive".into());
    let (_, fault) = fault(&scan, &files, &OpenOptions::default());
    assert!(fault.starts_with("expected the channel"), "{fault}");
}

#[test]
fn val_closed_form_fractions_of_a_sample_are_taken_out() {
    let place = Place::new();
    let delays = [0.0, 3.25, -1.5];
    let files = save_struck(&place, &delays, 200);
    let mut scan = by_name();
    scan.reference = Some("hammer".into());
    let left = opened(&scan, &files);
    for (record, delay) in left.records.iter().zip(delays) {
        assert_eq!(
            record.delay - record.left,
            (record.delay - record.left).round()
        );
        assert!((record.delay - delay).abs() < 0.01, "{record:?}");
    }
    let scanned = scan.open(&files, &options("resample=cubic")).unwrap();
    let found = values(&scanned.field);
    let mut worst: f64 = 0.0;
    for (j, record) in scanned.records.iter().enumerate() {
        assert_eq!(record.left, 0.0);
        for n in 0..found.nrows() {
            let t = scanned.field.time.at(n) + record.delay - delays[j];
            worst = worst.max((found[[n, j]] - (0.05 * (t - 2.0 * j as f64)).sin()).abs());
        }
    }
    assert!(worst < 1e-6 && worst > 1e-12, "{worst:e}");
}

#[test]
fn val_numpy_delays() {
    for case in reference()["delayed"].as_array().unwrap() {
        let place = Place::new();
        let files = ["first", "record"].map(|key| {
            let path = place.path(format!("x={}.npy", key.len()));
            ndarray_npy::write_npy(&path, &Array1::from(numbers(&case[key]))).unwrap();
            path
        });
        let mut scan = by_name();
        scan.reference = Some("0".into());
        scan.channel = Some("0".into());
        scan.least_correlation = 0.3;
        let record = &opened(&scan, &files).records[1];
        let number = |key: &str| case[key].as_f64().unwrap();
        assert_eq!(record.delay - record.left, number("samples"));
        assert!((record.left - number("fraction")).abs() < 1e-13);
        assert!((record.correlation.unwrap() - number("coefficient")).abs() < 1e-14);
        scan.least_correlation = 0.99;
        let (path, found) = fault(&scan, &files, &OpenOptions::default());
        assert!(found.contains("correlation coefficient"), "{found}");
        assert_eq!(path, files[1]);
    }
}

#[test]
fn val_closed_form_starts_between_samples() {
    let place = Place::new();
    let files: Vec<PathBuf> = [0.0, 0.3, 2.0]
        .iter()
        .enumerate()
        .map(|(j, t0)| {
            let path = place.path(format!("x={j}.csv"));
            let row =
                |n: usize| format!("{:.1},{:e}\n", t0 + n as f64, (0.1 * (t0 + n as f64)).sin());
            fs::write(
                &path,
                format!("time,v\n{}", (0..100).map(row).collect::<String>()),
            )
            .unwrap();
            path
        })
        .collect();
    let (path, found) = fault(&by_name(), &files, &OpenOptions::default());
    assert_eq!(path, files[1]);
    let steps = found.rsplit("found ").next().unwrap();
    let steps: f64 = steps.trim_end_matches(" steps").parse().unwrap();
    assert!((steps - 0.3).abs() < 1e-12, "{found}");
    let scanned = by_name().open(&files, &options("resample=cubic")).unwrap();
    let field = values(&scanned.field);
    assert_eq!((scanned.field.time.origin, field.dim()), (2.0, (98, 3)));
    let mut worst: f64 = 0.0;
    for ((n, j), found) in field.indexed_iter() {
        let expected = (0.1 * scanned.field.time.at(n)).sin();
        match j {
            1 => worst = worst.max((found - expected).abs()),
            _ => assert!((found - expected).abs() < 1e-15),
        }
    }
    assert!(worst < 2e-6 && worst > 1e-9, "{worst:e}");
}

/// What is read of a few short files: a scan a row of `scans.txt`.
#[test]
fn val_definition_files_of_scans_and_what_is_read_of_them() {
    let mut wrong = Vec::new();
    let rows = include_str!("scans.txt").lines();
    for row in rows.filter(|row| !row.is_empty() && !row.starts_with('#')) {
        let parts: Vec<&str> = row.split(" | ").collect();
        let place = Place::new();
        let (from, words) = parts[0].split_once(' ').unwrap_or((parts[0], ""));
        let mut scan = match from.split_once('=').unwrap_or((from, "")) {
            ("table", text) => {
                place.write("positions.csv", unescaped(text));
                Scan::new(PositionFrom::Table(place.path("positions.csv")))
            }
            ("header", "") => Scan::new(PositionFrom::Header(None)),
            ("header", name) => Scan::new(PositionFrom::Header(Some(name.into()))),
            (_, "") => by_name(),
            (_, name) => Scan::new(PositionFrom::Name(Some(name.into()))),
        };
        let mut others = Vec::new();
        for word in words.split(' ') {
            match word.split_once('=') {
                Some(("reference", name)) => scan.reference = Some(name.into()),
                Some(("channel", name)) => scan.channel = Some(name.into()),
                Some(("equal", _)) => scan.equal_positions = EqualPositions::Average,
                _ => others.push(word),
            }
        }
        let options = options(&others.join(" "));
        let files = parts[1].split(" + ").map(|text| {
            let (name, text) = text.split_once(' ').unwrap();
            place.write(name, file(text));
            place.path(name)
        });
        let scanned = scan.open(&files.collect::<Vec<_>>(), &options);
        for expected in parts[2].split(" ; ") {
            let is_right = match (&scanned, expected.split_once(' ').unwrap()) {
                (Err(error), ("refused", words)) => error.to_string().contains(words),
                (Ok(scanned), ("records", count)) => scanned.records.len().to_string() == count,
                (Ok(scanned), _) => holds(&scanned.field, expected),
                _ => false,
            };
            if !is_right {
                wrong.push(format!("{row}\nnot {expected:?}: {scanned:?}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn regress_the_hash_is_that_of_all_files() {
    let place = Place::new();
    let files = save(&place, |j| format!("x={j}.npy"));
    let hash = || opened(&by_name(), &files).field.content_hash.unwrap();
    let before = hash();
    assert_eq!(before.len(), 64);
    let one = ndarray_npy::read_npy::<_, Array1<f64>>(&files[2]).unwrap();
    ndarray_npy::write_npy(&files[2], &(one * 2.0)).unwrap();
    assert_ne!(hash(), before);
    assert_ne!(
        Some(before),
        Field::open(&files[0], &OpenOptions::default())
            .unwrap()
            .content_hash
    );
}
