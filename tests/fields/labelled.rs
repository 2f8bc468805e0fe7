//! Fields in files of named arrays: which array and which dimensions are taken, and what their
//! coordinates say.
//!
//! `val_definition_*`: the file is written by the definition of NetCDF-3, and holds the values that are
//! expected. `val_peer_*`: files from elsewhere beside the array that their own program reads.

use std::fs;

use ndarray::Array2;
use test_support::fields::{option, reading};
use test_support::made::{fault, open, savez, values};
use test_support::netcdf::{NetCdf, Values, Variable};
use test_support::place::Place;
use wavecascade::error::InputFault;
use wavecascade::field::{Delays, Label, Layout, OpenOptions, Quantity, Selection, inspect};
use wavecascade::{Error, Field};

use crate::note;

const TIMES: usize = 5;
const HEIGHTS: usize = 3;
const SITES: usize = 4;

/// A sample that tells its place.
fn sample(n: usize, h: usize, j: usize) -> f64 {
    (100 * n + 10 * h + j) as f64
}

/// `velocity(time, y, x)` with coordinates.
fn scan() -> NetCdf {
    let all = (0..TIMES * HEIGHTS * SITES).map(|i| {
        let (n, rest) = (i / (HEIGHTS * SITES), i % (HEIGHTS * SITES));
        sample(n, rest / SITES, rest % SITES)
    });
    let list = |count: usize, from: f64, step: f64| {
        Values::Double((0..count).map(|i| from + i as f64 * step).collect())
    };
    NetCdf {
        dimensions: vec![("time", TIMES), ("y", HEIGHTS), ("x", SITES)],
        variables: vec![
            Variable::new("time", &[0], list(TIMES, 1.0, 0.25)).text("units", "ms"),
            Variable::new("y", &[1], list(HEIGHTS, 0.5, 0.5)).text("units", "m"),
            Variable::new("x", &[2], list(SITES, 0.0, 0.125)).text("units", "m"),
            Variable::new("velocity", &[0, 1, 2], Values::Double(all.collect()))
                .text("units", "mm/s"),
        ],
    }
}

fn save(place: &Place, name: &str, file: &NetCdf) {
    place.write(name, file.bytes());
}

fn at(text: &str) -> wavecascade::field::At {
    let (dimension, label) = text.split_once('=').unwrap();
    wavecascade::field::At {
        dimension: dimension.into(),
        label: Label::parse(label).unwrap(),
    }
}

fn opened(place: &Place, name: &str, options: &OpenOptions) -> Field {
    Field::open(place.path(name), options).unwrap()
}

#[test]
fn val_definition_a_further_dimension_is_taken_where_it_is_stated() {
    let place = Place::new();
    save(&place, "scan.nc", &scan());
    let refused = fault(&place, "scan.nc", &OpenOptions::default());
    assert!(
        refused.to_string().contains("also along y (3 values"),
        "{refused}"
    );
    for (stated, h) in [
        ("y=1", 1),
        ("y=1.2 m", 1),
        ("y=1400 mm", 2),
        ("y=#0", 0),
        ("1=#2", 2),
    ] {
        let options = reading(|it| it.at = vec![at(stated)]);
        let field = opened(&place, "scan.nc", &options);
        let expected = Array2::from_shape_fn((TIMES, SITES), |(n, j)| sample(n, h, j));
        assert_eq!(values(&field), expected, "{stated}");
        // Between two of them, it is said which one is taken.
        let said = note(&field, "nearest");
        assert_eq!(
            said.is_some(),
            stated.contains("1.2 m") || stated.contains("1400"),
            "{stated}"
        );
        if stated == "y=1.2 m" {
            let said = &said.unwrap().text;
            assert_eq!(said, "`y` is taken at 1 m (index 1), the nearest to 1.2m");
        }
        assert_eq!((field.time.origin, field.time.step), (1.0, 0.25));
        assert_eq!(field.time.unit.as_deref(), Some("ms"));
        assert_eq!(field.space.step, 0.125);
        assert_eq!(field.space.unit.as_deref(), Some("m"));
        assert_eq!(field.unit.as_deref(), Some("mm/s"));
    }
    for stated in ["y=3", "y=1 s", "y=#3", "z=0"] {
        let options = reading(|it| it.at = vec![at(stated)]);
        let refused = fault(&place, "scan.nc", &options);
        let advice = [
            "`cascade inspect FILE` lists",
            "name one of these dimensions",
        ];
        let is_known = advice
            .iter()
            .any(|words| refused.advice().starts_with(words));
        assert!(is_known, "{stated}: {refused:?}");
    }
}

/// Sites that are neither contiguous nor rows of the file are decoded.
#[test]
fn val_definition_dimensions_are_taken_by_name() {
    let place = Place::new();
    save(&place, "scan.nc", &scan());
    for memory in [None, Some(1)] {
        let options = OpenOptions {
            space_dim: Some("y".into()),
            at: vec![at("x=#3")],
            memory,
            ..OpenOptions::default()
        };
        let field = match memory {
            None => opened(&place, "scan.nc", &options),
            Some(_) => match Field::open(place.path("scan.nc"), &options) {
                Err(Error::Memory { .. }) => continue,
                other => panic!("{other:?}"),
            },
        };
        let expected = Array2::from_shape_fn((TIMES, HEIGHTS), |(n, h)| sample(n, h, 3));
        assert_eq!(values(&field), expected);
        assert_eq!((field.space.origin, field.space.step), (0.5, 0.5));
    }
    // In a scratch file: a slab fits the memory, the field does not.
    let long = 3000;
    let all = (0..2000 * 2 * long).map(|i| (i % 65_521) as i16).collect();
    let file = NetCdf {
        dimensions: vec![("time", 2000), ("z", 2), ("x", long)],
        variables: vec![Variable::new("v", &[0, 1, 2], Values::Short(all))],
    };
    save(&place, "long.nc", &file);
    let options = OpenOptions {
        space_dim: Some("z".into()),
        time_dim: Some("x".into()),
        at: vec![at("time=#7")],
        ..OpenOptions::default()
    };
    let field = opened(&place, "long.nc", &options);
    let number = |n: usize, j: usize| ((7 * 2 * long + j * long + n) % 65_521) as i16;
    let expected = Array2::from_shape_fn((long, 2), |(n, j)| f64::from(number(n, j)));
    assert_eq!(values(&field), expected);
    let options = OpenOptions {
        time_dim: Some("time".into()),
        space_dim: Some("x".into()),
        at: vec![at("z=#1")],
        ..OpenOptions::default()
    };
    let field = opened(&place, "long.nc", &options);
    let number = |n: usize, j: usize| (((n * 2 + 1) * long + j) % 65_521) as i16;
    let expected = Array2::from_shape_fn((2000, long), |(n, j)| f64::from(number(n, j)));
    assert_eq!(values(&field), expected);
}

#[test]
fn val_definition_packed_numbers_and_gaps() {
    let place = Place::new();
    let file = NetCdf {
        dimensions: vec![("time", 3), ("x", 2)],
        variables: vec![
            Variable::new(
                "acceleration",
                &[0, 1],
                Values::Short(vec![0, 1, -9, 3, 4, -7]),
            )
            .number("scale_factor", 0.5)
            .number("add_offset", 10.0)
            .number("_FillValue", -9.0)
            .number("missing_value", -7.0)
            .text("units", "m s-2"),
        ],
    };
    save(&place, "a.nc", &file);
    let field = open(&place, "a.nc");
    let found = values(&field);
    assert_eq!(found[[0, 0]], 10.0);
    assert_eq!(found[[0, 1]], 10.5);
    assert_eq!((found[[1, 1]], found[[2, 0]]), (11.5, 12.0));
    assert!(found[[1, 0]].is_nan() && found[[2, 1]].is_nan());
    assert_eq!(field.quantity, Quantity::Acceleration);
    // What NetCDF leaves where nothing was written.
    let unwritten = 9.969_209_968_386_869e36;
    let mut file = scan();
    file.variables.push(Variable::new(
        "v",
        &[0],
        Values::Double(vec![1.0, unwritten, 2.0, 3.0, 4.0]),
    ));
    save(&place, "b.nc", &file);
    let options = reading(|it| it.variable = Some("v".into()));
    let found = values(&opened(&place, "b.nc", &options));
    assert!(found[[1, 0]].is_nan() && found[[2, 0]] == 2.0);
}

/// CF conventions, 8.1 and 2.5.1: packed coordinates are unpacked, whatever their unit; a gap that is stated in
/// more digits than the samples have is one of them.
#[test]
fn val_definition_packed_coordinates_and_gaps_of_other_types() {
    let place = Place::new();
    let packed = |name, dimension, n: i16, unit| {
        Variable::new(name, &[dimension], Values::Short((0..n).collect()))
            .text("units", unit)
            .number("scale_factor", 0.25)
            .number("add_offset", 1.0)
    };
    let mut numbers: Vec<f32> = (0..24).map(|i| i as f32).collect();
    numbers[17] = 0.1;
    for (unit, step, start_of) in [
        ("s", 0.25, None),
        (
            "seconds since 2026-01-01",
            0.25,
            Some("2026-01-01 + 1 seconds"),
        ),
        ("days since 2026-01-01", 6.0, Some("2026-01-01 + 1 days")),
    ] {
        let file = NetCdf {
            dimensions: vec![("time", 4), ("x", 2), ("h", 3)],
            variables: vec![
                packed("time", 0, 4, unit),
                packed("x", 1, 2, "m"),
                packed("h", 2, 3, "m"),
                Variable::new("v", &[2, 0, 1], Values::Float(numbers.clone()))
                    .number("missing_value", 0.1),
            ],
        };
        save(&place, "p.nc", &file);
        let options = OpenOptions {
            variable: Some("v".into()),
            at: vec![at("h=1.5")],
            ..OpenOptions::default()
        };
        let field = opened(&place, "p.nc", &options);
        assert_eq!(field.time.step, step, "{unit}");
        assert_eq!(start(&field), start_of, "{unit}");
        let found = values(&field);
        assert!(found[[0, 1]].is_nan() && found[[0, 0]] == 16.0, "{unit}");
    }
}

#[test]
fn val_definition_times_since_a_date_are_exact() {
    let place = Place::new();
    // Milliseconds since 1970 in 2026, as integers: every step is one.
    let second = 1_700_000_000;
    let file = |times: Values| NetCdf {
        dimensions: vec![("when", 4), ("x", 2)],
        variables: vec![
            Variable::new("when", &[0], times).text("units", "seconds since 1970-01-01"),
            Variable::new(
                "v",
                &[1, 0],
                Values::Double((0..8).map(f64::from).collect()),
            ),
        ],
    };
    save(
        &place,
        "a.nc",
        &file(Values::Int((0..4).map(|n| second + 2 * n).collect())),
    );
    let field = open(&place, "a.nc");
    assert_eq!((field.time.origin, field.time.step), (0.0, 2.0));
    assert_eq!(field.time.unit.as_deref(), Some("s"));
    assert_eq!(field.n_sites(), 2);
    assert_eq!(values(&field)[[1, 0]], 1.0);
    assert_eq!(start(&field), Some("1970-01-01 + 1700000000 seconds"));
    // As floats they are rounded to 2e-7 s, and the step that was meant is found.
    let float = (0..4)
        .map(|n| f64::from(second) + 1e-3 * f64::from(n))
        .collect();
    save(&place, "b.nc", &file(Values::Double(float)));
    let field = open(&place, "b.nc");
    let step = field.time.step;
    assert!((step / 1e-3 - 1.0).abs() < 1e-4, "{step}");
}

#[test]
fn val_definition_lengths_of_neighbours_tell_the_layout() {
    let place = Place::new();
    let numbers = |count: usize| Values::Double((0..count).map(|i| i as f64 / 8.0).collect());
    let file = NetCdf {
        dimensions: vec![("d0", 4), ("d1", 6)],
        variables: vec![
            Variable::new("usol", &[0, 1], numbers(24)),
            Variable::new("x", &[0], numbers(4)),
            Variable::new("t", &[1], numbers(6)),
        ],
    };
    save(&place, "a.nc", &file);
    let field = open(&place, "a.nc");
    assert_eq!((field.n_times(), field.n_sites()), (6, 4));
    assert_eq!((field.time.step, field.space.step), (0.125, 0.125));
    assert_eq!(values(&field)[[5, 0]], 5.0 / 8.0);
    // Without them the layout is that of an array.
    let bare = NetCdf {
        variables: file.variables[..1].to_vec(),
        dimensions: file.dimensions.clone(),
    };
    save(&place, "b.nc", &bare);
    assert_eq!(open(&place, "b.nc").n_times(), 4);
    let options = reading(|it| it.layout = Some(Layout::SiteTime));
    assert_eq!(opened(&place, "b.nc", &options).n_times(), 6);
}

#[test]
fn a_file_in_doubt_is_asked_about() {
    let place = Place::new();
    let mut file = scan();
    let second = Variable::new(
        "pressure",
        &[0, 2],
        Values::Double(vec![0.0; TIMES * SITES]),
    );
    file.variables.push(second.clone());
    file.variables[3].name = "speed";
    save(&place, "a.nc", &file);
    let refused = fault(&place, "a.nc", &OpenOptions::default()).to_string();
    assert!(
        refused.starts_with("expected one array v(t, x), found"),
        "{refused}"
    );
    let options = reading(|it| it.variable = Some("pressur".into()));
    let found = fault(&place, "a.nc", &options);
    assert!(
        matches!(found, InputFault::NoSuchVariable { .. }),
        "{found:?}"
    );
    let options = reading(|it| it.variable = Some("pressure".into()));
    assert_eq!(opened(&place, "a.nc", &options).n_sites(), SITES);
    // One profile has no times.
    file.variables = vec![
        file.variables[2].clone(),
        Variable::new("v", &[2], Values::Int(vec![1; SITES])),
    ];
    save(&place, "b.nc", &file);
    let refused = fault(&place, "b.nc", &OpenOptions::default()).to_string();
    assert!(refused.starts_with("expected times in "), "{refused}");
    // What is listed is not needed to open a field.
    let found = inspect(&place.path("b.nc"), &OpenOptions::default()).unwrap();
    assert_eq!(found.variables.len(), 2);
    assert!(found.field.is_err());
}

#[test]
fn val_definition_a_part_is_read_between_both_ends() {
    let place = Place::new();
    let samples = Array2::from_shape_fn((40, 7), |(n, j)| (10 * n + j) as f64);
    let times: Vec<f64> = (0..40).map(|n| f64::from(n) * 1e-3).collect();
    savez(&place, "a.npz", ("v", &samples), &[("t", times.clone())]);
    let select = |text: &[&str]| OpenOptions {
        time_unit: Some("s".into()),
        select: text.iter().map(|text| selection(text)).collect(),
        ..OpenOptions::default()
    };
    for (text, rows, columns) in [
        (&["time=5ms:0.009"][..], 5..10, 0..7),
        (&["t=:#2"], 0..3, 0..7),
        (&["time=0.0041:", "site=#2:#4"], 5..40, 2..5),
    ] {
        let field = opened(&place, "a.npz", &select(text));
        let expected = samples.slice(ndarray::s![rows.clone(), columns.clone()]);
        assert_eq!(values(&field), expected, "{text:?}");
        assert_eq!(field.time.origin, rows.start as f64 * field.time.step);
        assert_eq!(field.space.origin, columns.start as f64);
    }
    for text in ["time=1:2", "time=3m:", "depth=0:1"] {
        let error = Field::open(place.path("a.npz"), &select(&[text])).unwrap_err();
        assert_eq!(option(error), "select");
    }
}

fn selection(text: &str) -> Selection {
    let (dimension, range) = text.split_once('=').unwrap();
    let (from, to) = range.split_once(':').unwrap();
    Selection {
        dimension: dimension.into(),
        from: Label::parse(from),
        to: Label::parse(to),
    }
}

#[test]
fn val_definition_jitter_is_told_and_limited() {
    let place = Place::new();
    let samples = Array2::from_shape_fn((30, 4), |(n, j)| (n * j) as f64);
    for (deviation, allowed, is_read) in [
        (0.009, None, true),
        (0.011, None, false),
        (0.011, Some(0.02), true),
        (0.009, Some(0.0), false),
    ] {
        let mut times: Vec<f64> = (0..30).map(f64::from).collect();
        times[17] += deviation;
        savez(&place, "a.npz", ("v", &samples), &[("t", times.clone())]);
        let options = reading(|it| it.jitter = allowed.unwrap_or(it.jitter));
        if !is_read {
            let fault = fault(&place, "a.npz", &options);
            assert!(
                matches!(fault, InputFault::UnevenAxis { index: 17 | 18, .. }),
                "{fault:?}"
            );
            continue;
        }
        let field = opened(&place, "a.npz", &options);
        assert_eq!(field.time.step, 1.0);
        let said = &note(&field, "jitter").unwrap().text;
        let told = format!(
            "the time coordinates are taken as even; index 17 deviates by {deviation} of a step"
        );
        assert!(said.starts_with(&told), "{said}");
    }
}

fn open_path(path: &std::path::Path) -> Field {
    Field::open(path, &OpenOptions::default()).unwrap()
}

/// Files of other programs, beside the readers.
fn fixture(name: &str) -> std::path::PathBuf {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join("crates/formats/tests/files").join(name)
}

#[test]
fn val_peer_segyio_traces_that_begin_at_different_times() {
    let path = fixture("segy/f32.sgy");
    let open = |delays, step: &str| {
        let options = OpenOptions {
            delays,
            dt: wavecascade::measure::Measure::parse(step),
            ..OpenOptions::default()
        };
        Field::open(&path, &options)
    };
    let refused = |found| match found {
        Err(Error::Input { fault, .. }) => fault,
        other => panic!("{other:?}"),
    };
    let field = open(Delays::Ignore, "1 ms").unwrap();
    let is_told = |field: &Field| note(field, "delays").is_some_and(|note| note.is_doubtful);
    assert!(is_told(&field));
    let whole = values(&field);
    let (n_times, n_sites) = whole.dim();
    let most = (n_sites - 1) as f64;
    let found = refused(open(Delays::Refuse, "1 ms"));
    assert!(
        found
            .to_string()
            .ends_with(&format!("found delays from 0 to {most} ms")),
        "{found}"
    );
    // Trace j is recorded from j ms on.
    let field = open(Delays::Align, "1 ms").unwrap();
    let aligned = values(&field);
    assert_eq!(aligned.dim(), (n_times + 1 - n_sites, n_sites));
    assert!((field.time.origin - 1e-3 * most).abs() < 1e-15);
    for ((n, j), sample) in aligned.indexed_iter() {
        assert_eq!(*sample, whole[[n + n_sites - 1 - j, j]]);
    }
    let found = refused(open(Delays::Align, "4 ms"));
    assert!(
        found.to_string().ends_with("found 0.25 of trace 1"),
        "{found}"
    );

    let field = open_path(&fixture("segy/ibm.sgy"));
    assert!(!is_told(&field), "{:?}", field.notes);
    assert_eq!(field.time.unit.as_deref(), Some("s"));
}

/// What the peer of a folder read from one of its files, `f64` and `i32` as hex.
fn read_by_its_peer(
    folder: &str,
    name: &str,
    is_it: impl Fn(&serde_json::Value) -> bool,
) -> Array2<f64> {
    let json = fs::read_to_string(fixture(folder).join("expected.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let number = |bytes: &[u8]| match bytes.len() {
        4 => f64::from(i32::from_le_bytes(bytes.try_into().unwrap())),
        _ => f64::from_le_bytes(bytes.try_into().unwrap()),
    };
    let records = json[name]
        .as_array()
        .unwrap()
        .iter()
        .filter(|one| is_it(one));
    let records: Vec<Vec<f64>> = records
        .map(|one| {
            let size: usize = one["type"].as_str().unwrap()[1..].parse().unwrap();
            let digits = one["hex"].as_str().unwrap();
            let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).unwrap();
            let bytes: Vec<u8> = (0..digits.len()).step_by(2).map(byte).collect();
            bytes.chunks(size).map(number).collect()
        })
        .collect();
    Array2::from_shape_fn((records[0].len(), records.len()), |(n, j)| records[j][n])
}

fn start(field: &Field) -> Option<&str> {
    note(field, "start")?.text.strip_prefix("times count from ")
}

#[test]
fn val_peer_nptdms_reads_the_same_field() {
    let options = reading(|it| it.variable = Some("scan".into()));
    let field = Field::open(fixture("tdms/field.tdms"), &options).unwrap();
    let of_scan =
        |one: &serde_json::Value| one["group"] == "scan" && one["channel"] != "temperature";
    assert_eq!(
        values(&field),
        read_by_its_peer("tdms", "field.tdms", of_scan)
    );
    assert_eq!((field.time.origin, field.time.step), (-0.25, 1e-5));
    assert_eq!((field.space.origin, field.space.step), (0.5, 0.5));
    let units = [&field.time.unit, &field.space.unit, &field.unit].map(Option::as_deref);
    assert_eq!(units, [Some("s"), Some("mm"), Some("mm/s")]);
    assert_eq!(start(&field), Some("2026-03-04T05:06:07.00025"));
}

#[test]
fn val_peer_obspy_reads_the_same_field() {
    let field = open_path(&fixture("miniseed/steim2_big.mseed"));
    let all = read_by_its_peer("miniseed", "steim2_big.mseed", |_| true);
    assert_eq!(values(&field), all);
    assert_eq!((field.time.origin, field.time.step), (0.0, 0.01));
    assert_eq!(field.time.unit.as_deref(), Some("s"));
    assert_eq!(start(&field), Some("2024-02-29T23:59:59.1234"));
}

#[test]
fn val_peer_lammps_a_chain_is_read_in_its_order() {
    let field = open_path(&fixture("lammps/granular.lammpstrj"));
    assert_eq!((field.n_times(), field.n_sites()), (21, 9));
    assert_eq!(field.time.step, 2e-5);
    assert!((field.space.step - 0.02).abs() < 1e-12);
    let units = (field.time.unit.as_deref(), field.space.unit.as_deref());
    assert_eq!(units, (Some("s"), Some("m")));
    assert_eq!(field.quantity, Quantity::Velocity);
    assert_eq!(field.unit.as_deref(), Some("m/s"));
    // The striker has the last number and the first place.
    let first = values(&field).row(0).to_vec();
    assert_eq!(first, [0.5, 0., 0., 0., 0., 0., 0., 0., 0.]);
    let positions = reading(|it| it.variable = Some("x".into()));
    let field = Field::open(fixture("lammps/granular.lammpstrj"), &positions).unwrap();
    assert_eq!(field.quantity, Quantity::Displacement);
}

#[cfg(feature = "zarr")]
#[test]
fn val_peer_xarray_stores_are_directories() {
    let fields = [2, 3].map(|version| {
        let path = fixture(&format!("zarr/xarray{version}.zarr"));
        let field = open_path(&path);
        assert_eq!((field.n_times(), field.n_sites()), (9, 6));
        assert_eq!((field.time.step, field.space.step), (2.5e-4, 0.125));
        let units = (field.time.unit.as_deref(), field.space.unit.as_deref());
        assert_eq!(units, (Some("s"), Some("m")));
        assert_eq!(field.unit.as_deref(), Some("m/s"));
        // The gap.
        assert!(values(&field)[[2, 3]].is_nan());
        assert!(field.content_hash.is_some() && field.file_state().is_none());
        let found = inspect(&path, &OpenOptions::default()).unwrap();
        assert_eq!(found.format, "a Zarr store");
        let packed = reading(|it| it.variable = Some("packed".into()));
        let packed = Field::open(&path, &packed).unwrap();
        for (packed, value) in values(&packed).iter().zip(values(&field)) {
            assert!((packed - value).abs() <= 5.1e-4 || packed.is_nan() && value.is_nan());
        }
        field
    });
    assert_eq!(fields[0].content_hash.as_ref().map(String::len), Some(64));
    assert_ne!(fields[0].content_hash, fields[1].content_hash);
}

#[cfg(not(feature = "zarr"))]
#[test]
fn a_zarr_store_names_the_feature_that_reads_it() {
    let path = fixture("zarr/xarray3.zarr");
    let error = Field::open(&path, &OpenOptions::default()).unwrap_err();
    assert!(error.to_string().contains("a Zarr store"), "{error}");
    let Error::Input { fault, .. } = &error else {
        panic!("{error}");
    };
    assert!(fault.advice().contains("feature zarr") && fault.advice().contains("xarray"));
    // Another directory is none.
    let error = Field::open(fixture("zarr"), &OpenOptions::default()).unwrap_err();
    assert!(
        error
            .to_string()
            .ends_with("expected a file, found a directory"),
        "{error}"
    );
}

#[cfg(feature = "hdf5")]
#[test]
fn an_array_that_its_file_cannot_hold_is_no_damaged_archive() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    // Behind the byte that chooses the format.
    let bytes = fs::read(root.join("fuzz/corpus/containers/long_chunked")).unwrap();
    let place = Place::new();
    let path = place.path("long.mat");
    fs::write(&path, &bytes[1..]).unwrap();
    let refused = Field::open(&path, &OpenOptions::default())
        .unwrap_err()
        .to_string();
    let most = 1032 * fs::metadata(&path).unwrap().len();
    let expected = format!("expected at most {most} bytes of samples in a file of this length");
    assert!(refused.contains(&expected), "{refused}");
}

#[test]
fn every_file_of_a_peer_is_listed_and_read_or_asked_about() {
    let mut read = 0;
    for folder in [
        "hdf5", "lammps", "mat", "miniseed", "netcdf3", "segy", "tdms", "uff",
    ] {
        for entry in fs::read_dir(fixture(folder)).unwrap() {
            let path = entry.unwrap().path();
            let is = |part: Option<&std::ffi::OsStr>, names: &[&str]| {
                part.is_some_and(|part| names.iter().any(|name| part == *name))
            };
            // Those with gaps, or in which atoms are lost, are refused as a whole.
            let refused = ["gap", "overlap", "lost"];
            if is(path.extension(), &["json"]) || is(path.file_stem(), &refused) {
                continue;
            }
            let found = inspect(&path, &OpenOptions::default()).unwrap();
            assert!(!found.variables.is_empty(), "{}", path.display());
            match found.field {
                Ok(field) => {
                    let _all = values(&field);
                    read += 1;
                }
                Err(Error::Input { .. }) => (),
                Err(error) => panic!("{}: {error}", path.display()),
            }
        }
    }
    assert!(read >= 12, "{read}");
}

/// First coordinates count in their own units.
#[test]
fn val_definition_origins_beside_an_array_have_units() {
    let place = Place::new();
    let numbers = (0..8).map(f64::from).collect();
    let file = NetCdf {
        dimensions: vec![("time", 4), ("x", 2)],
        variables: vec![
            Variable::new("v", &[0, 1], Values::Double(numbers))
                .text("dt", "1 ms")
                .text("t0", "5 ms")
                .number("dx", 0.5)
                .text("dx_unit", "m")
                .number("x0", 50.0)
                .text("x0_unit", "mm"),
        ],
    };
    save(&place, "o.nc", &file);
    let field = opened(&place, "o.nc", &OpenOptions::default());
    let [time, space] = [field.time, field.space];
    assert_eq!(time.origin, 0.005);
    assert_eq!(time.step, 0.001);
    assert_eq!(time.unit.as_deref(), Some("s"));
    assert_eq!(space.origin, 0.05);
    assert_eq!(space.step, 0.5);
    assert_eq!(space.unit.as_deref(), Some("m"));
}
