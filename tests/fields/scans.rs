//! Files with one record each as one field.
//!
//! `val_identity_*`: records cut from one field, which comes back bit for bit. `val_numpy_*`: delays by
//! `data/interpolation.py` with NumPy 2.4.6 on 2026-11-25. `val_closed_form_*`: pulses and sines at known
//! times.

use std::fs;
use std::path::PathBuf;

use ndarray::{Array1, Array2, s};
use test_support::fields::reading;
use test_support::made::values;
use test_support::netcdf::{NetCdf, Values, Variable};
use test_support::place::Place;
use wavecascade::error::InputFault;
use wavecascade::field::{
    EqualPositions, Interpolation, OpenOptions, PositionFrom, Resample, Scan, Scanned,
};
use wavecascade::{Error, Field};

use crate::resample::{numbers, reference};
use crate::texts;

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
                let times = (0..record.len()).map(|n| t0 + 0.25 * n as f64);
                let file = NetCdf {
                    dimensions: vec![("time", record.len())],
                    variables: vec![
                        Variable::new("time", &[0], Values::Double(times.collect())).text("units", "ms"),
                        Variable::new("velocity", &[0], Values::Double(record.to_vec())),
                        Variable::new("x", &[], Values::Double(vec![2.0 * j as f64])).text("units", "mm"),
                        Variable::new("z", &[], Values::Double(vec![7.0])).text("units", "mm"),
                    ],
                };
                fs::write(&path, file.bytes()).unwrap();
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
fn val_identity_records_by_the_numbers_of_their_names() {
    for extension in ["npy", "csv", "nc"] {
        let place = Place::new();
        let files = save(&place, |j| format!("scan3_x={}mm.{extension}", 2 * j));
        check(&opened(&by_name(), &files));
        // The same in a scratch file.
        let options = reading(|it| it.memory = Some(5000));
        if extension != "csv" {
            check(&by_name().open(&files, &options).unwrap());
        }
        // Metres are asked for.
        let options = reading(|it| it.space_unit = Some("m".into()));
        let field = by_name().open(&files, &options).unwrap().field;
        assert_eq!(field.space.step, 0.002);
        assert_eq!(field.space.unit.as_deref(), Some("m"));
    }
}

#[test]
fn val_identity_records_by_their_headers() {
    let header = Scan::new(PositionFrom::Header(None));
    for extension in ["npy", "nc"] {
        let place = Place::new();
        let files = save(&place, |j| {
            format!("{}.{extension}", (b'a' + j as u8) as char)
        });
        check(&opened(&header, &files));
    }
    let place = Place::new();
    let files = save(&place, |j| format!("{j}.nc"));
    let z = Scan::new(PositionFrom::Header(Some("z".into())));
    let (_, found) = fault(&z, &files, &OpenOptions::default());
    assert!(found.starts_with("expected one number in"), "{found}");
}

#[test]
fn val_identity_records_by_a_table() {
    let place = Place::new();
    let files = save(&place, |j| format!("{}.npy", (b'a' + j as u8) as char));
    let rows: String = (0..SITES)
        .map(|j| format!("{}.npy,{}\n", (b'a' + j as u8) as char, 2 * j))
        .collect();
    let table = place.path("positions.csv");
    fs::write(&table, format!("file,position_mm\n{rows}other.npy,99\n")).unwrap();
    let scan = Scan::new(PositionFrom::Table(table.clone()));
    check(&opened(&scan, &files));
    fs::write(&table, "file,position_mm\na.npy,1\n").unwrap();
    let (path, found) = fault(&scan, &files, &OpenOptions::default());
    assert!(found.starts_with("expected a position in"), "{found}");
    assert_ne!(path, place.path("a.npy"));
    fs::write(&table, "name,width\na.npy,1\n").unwrap();
    assert!(matches!(
        scan.open(&files, &OpenOptions::default()),
        Err(Error::Unfit { .. })
    ));
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
    let options = reading(|it| it.resample = Resample::both(Interpolation::Cubic));
    let scanned = scan.open(&files, &options).unwrap();
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
    let steps = found
        .rsplit("found ")
        .next()
        .unwrap()
        .trim_end_matches(" steps");
    assert!(
        (steps.parse::<f64>().unwrap() - 0.3).abs() < 1e-12,
        "{found}"
    );
    let options = reading(|it| it.resample = Resample::both(Interpolation::Cubic));
    let scanned = by_name().open(&files, &options).unwrap();
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

#[test]
fn what_does_not_go_together_is_refused() {
    let place = Place::new();
    let write = |name: &str, text: &str| {
        let path = place.path(name);
        fs::write(&path, text).unwrap();
        path
    };
    let rows = "0,1\n1,2\n2,4\n3,1\n";
    let record = |name: &str| write(name, &format!("time_s,v\n{rows}"));
    let scan = by_name();
    let plain = OpenOptions::default();
    let of = |files: &[PathBuf]| fault(&scan, files, &plain).1;

    let two = vec![record("x=1_run5.csv"), record("x=2_run3.csv")];
    let named = Scan::new(PositionFrom::Name(Some("x".into())));
    assert_eq!(opened(&named, &two).field.space.step, 1.0);
    // The second file of each pair, and the fault.
    for (stem, text, expected) in [
        ("s", "time_s,v\n0,1\n2,2\n4,3\n6,1\n", "expected the step "),
        (
            "m",
            &format!("time_ms,v\n{rows}"),
            "expected the unit of time ",
        ),
        (
            "w",
            "time_s,v,w\n0,1,5\n1,2,3\n2,4,4\n3,9,1\n",
            "expected one record, found 2",
        ),
        (
            "l",
            "time_s,v\n9,1\n10,2\n11,4\n12,1\n",
            "expected at least two times in common",
        ),
    ] {
        let second = write(&format!("{stem}=2.csv"), text);
        let found = of(&[record(&format!("{stem}=1.csv")), second]);
        assert!(found.starts_with(expected), "{found}");
    }
    for (files, expected) in [
        (two, "expected one number in the names"),
        (
            vec![record("a1.csv"), record("b1.csv")],
            "expected the numbers of",
        ),
        (
            vec![record("p=1.0.csv"), record("p=1.00.csv"), record("p=2.csv")],
            "expected positions that differ",
        ),
    ] {
        let found = of(&files);
        assert!(found.starts_with(expected), "{found}");
    }
    let uneven = [record("u=1.csv"), record("u=2.csv"), record("u=4.csv")];
    match scan.open(&uneven, &plain) {
        Err(Error::Input {
            path,
            fault:
                InputFault::UnevenAxis {
                    axis: "space",
                    index: 1 | 2,
                    ..
                },
        }) => assert!(uneven.contains(&path)),
        other => panic!("{other:?}"),
    }
    let one = scan.open(&uneven[..1], &plain).unwrap_err();
    assert!(one.is_usage(), "{one}");
    assert!(one.to_string().contains("two files"), "{one}");
    let mut flat = by_name();
    flat.reference = Some("0".into());
    flat.channel = Some("0".into());
    let dead = [
        record("d=1.csv"),
        write("d=2.csv", "time_s,v\n0,1\n1,1\n2,1\n3,1\n"),
    ];
    assert!(
        fault(&flat, &dead, &plain)
            .1
            .contains("that are not all equal")
    );
}

#[test]
fn val_definition_equal_positions_are_averaged() {
    let place = Place::new();
    let write = |name: &str, values: [f64; 4]| {
        let rows = values.iter().enumerate().map(|(n, v)| format!("{n},{v}\n"));
        let path = place.path(name);
        fs::write(&path, format!("time,v\n{}", rows.collect::<String>())).unwrap();
        path
    };
    let files = [
        write("x=2_r=1.csv", [1.0, 5.0, 2.0, 7.0]),
        write("x=1_r=1.csv", [1.0, 2.0, 4.0, 1.0]),
        write("x=1_r=2.csv", [2.0, 4.0, 1.0, 3.0]),
    ];
    let mut scan = Scan::new(PositionFrom::Name(Some("x".into())));
    scan.equal_positions = EqualPositions::Average;
    let scanned = opened(&scan, &files);
    let expected = ndarray::array![[1.5, 1.0], [3.0, 5.0], [2.5, 2.0], [2.0, 7.0]];
    assert_eq!(values(&scanned.field), expected);
    assert_eq!(scanned.records.len(), 3);
    let said = texts(&scanned.field);
    assert!(
        said[0].contains("3 files are one field, 2 sites"),
        "{said:?}"
    );
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
