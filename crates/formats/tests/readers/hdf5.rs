//! HDF5 against h5py, and against fields of which the truth is known.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value as Json;
use wavecascade_formats::{
    ByteOrder, Container, Coordinate, Error, Format, Options, Place, Sample, SampleType, Strided,
    Value, open,
};

const FILES: [&str; 6] = [
    "plain.h5",
    "latest.h5",
    "scales.h5",
    "xarray.nc",
    "h5netcdf.nc",
    "matlab73.mat",
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/hdf5")
}

fn open_bytes(bytes: Vec<u8>) -> Result<Container, Error> {
    open(Format::Hdf5, Arc::new(bytes), &Options::default())
}

fn open_fixture(name: &str) -> Container {
    let bytes = std::fs::read(folder().join(name)).unwrap();
    assert_eq!(Format::detect("file", &bytes), Some(Format::Hdf5));
    open_bytes(bytes).unwrap()
}

fn bits(container: &Container, variable: usize) -> Vec<u64> {
    match container.integers(variable).unwrap() {
        Some(integers) => integers.iter().map(|&i| i as u64).collect(),
        None => {
            let found = &container.variables[variable];
            let all: Vec<_> = found.dimensions.iter().map(|d| 0..d.len).collect();
            if found.sample_type == SampleType::Number(Sample::U64) {
                let mut out = vec![0; 8 * found.count().unwrap() as usize];
                container.read(variable, &all, &mut out).unwrap();
                let each = out.chunks_exact(8);
                return each
                    .map(|one| u64::from_ne_bytes(one.try_into().unwrap()))
                    .collect();
            }
            let numbers = container.numbers(variable).unwrap();
            numbers.iter().map(|x| x.to_bits()).collect()
        }
    }
}

fn numpy_name(sample: Sample) -> &'static str {
    match sample {
        Sample::F64 => "float64",
        Sample::F32 => "float32",
        Sample::F16 => "float16",
        Sample::I8 => "int8",
        Sample::I16 => "int16",
        Sample::I32 => "int32",
        Sample::I64 => "int64",
        Sample::U8 => "uint8",
        Sample::U16 => "uint16",
        Sample::U32 => "uint32",
        Sample::U64 => "uint64",
        _ => "bool",
    }
}

#[test]
fn val_h5py_every_number() {
    let expected = std::fs::read(folder().join("expected.json")).unwrap();
    let expected: Json = serde_json::from_slice(&expected).unwrap();
    for name in FILES {
        let container = open_fixture(name);
        let arrays = expected[name].as_object().unwrap();
        assert!(!arrays.is_empty());
        for (path, array) in arrays {
            let found = container.find(path);
            let found = found.unwrap_or_else(|| panic!("{name}: no {path}"));
            let variable = &container.variables[found];
            let shape: Vec<u64> = serde_json::from_value(array["shape"].clone()).unwrap();
            assert_eq!(variable.shape(), shape, "{name}{path}");
            let sample = variable.sample_type.number();
            let sample = sample.unwrap_or_else(|| panic!("{name}{path}: {variable:?}"));
            assert_eq!(numpy_name(sample), array["type"], "{name}{path}");
            let truth = array["bits"].as_array().unwrap().iter();
            let truth: Vec<u64> = truth
                .map(|one| u64::from_str_radix(one.as_str().unwrap(), 16).unwrap())
                .collect();
            assert_eq!(bits(&container, found), truth, "{name}{path}");
        }
        let numbers = container.variables.iter();
        let numbers = numbers.filter(|v| v.sample_type.number().is_some());
        assert_eq!(numbers.count(), arrays.len(), "{name}");
    }
}

#[test]
fn val_h5py_blocks() {
    let container = open_fixture("plain.h5");
    for path in ["zone/b/chunked", "contiguous", "zone/b/holes", "unwritten"] {
        let found = container.find(path).unwrap();
        let variable = &container.variables[found];
        let shape = variable.shape();
        let size = variable.sample_type.number().unwrap().bytes();
        let all: Vec<_> = shape.iter().map(|&len| 0..len).collect();
        let mut whole = vec![0; size * variable.count().unwrap() as usize];
        container.read(found, &all, &mut whole).unwrap();
        let mut block = all.clone();
        block[0] = 1..3;
        let row = whole.len() / shape[0] as usize;
        let mut out = vec![0; 2 * row];
        container.read(found, &block, &mut out).unwrap();
        assert_eq!(out, whole[row..3 * row], "{path}");
    }
}

#[test]
fn val_h5py_places_and_kinds() {
    let container = open_fixture("plain.h5");
    let variable = |path: &str| &container.variables[container.find(path).unwrap()];
    let Place::Strided(Strided { order, .. }) = variable("big_endian").place else {
        panic!("{:?}", variable("big_endian"));
    };
    assert_eq!(order, ByteOrder::Big);
    assert_eq!(variable("zone/b/chunked").place, Place::Encoded { rows: 4 });
    assert!(matches!(variable("unwritten").place, Place::Encoded { .. }));
    let other = |path: &str| match &variable(path).sample_type {
        SampleType::Other(other) => other.clone(),
        SampleType::Number(_) => panic!("{path}"),
    };
    assert_eq!(other("text"), "text");
    assert_eq!(other("complex"), "complex numbers");
    assert_eq!(other("pairs"), "a compound type of a, b");
    assert_eq!(other("reference"), "references");
    assert_eq!(other("colours"), "named values (an enumeration)");
    assert_eq!(other("empty"), "nothing");
    assert_eq!(other("odd_float"), "numbers of an unusual form");
    assert_eq!(other("odd_integer"), "numbers of an unusual form");
    assert!(other("virtual").contains("virtual data set"));
    assert!(other("outside").contains("another file"));
    assert!(other("packed").contains("zstd (filter 32015), which is not read"));
    assert!(other("zone/b/elsewhere").contains("other.h5"));
    assert!(other("zone/b/foreign_fill").contains("_FillValue"));
    for (path, way) in [
        ("virtual", "[\"v\"][...]"),
        ("outside", "[\"v\"][...]"),
        ("packed", "h5repack -f GZIP=4"),
        ("zone/b/foreign_fill", "_FillValue"),
        ("complex", "real part"),
    ] {
        let found = variable(path).sample_type.way_out();
        assert!(
            found.is_some_and(|found| found.contains(way)),
            "{path}: {found:?}"
        );
    }
    assert_eq!(variable("text").sample_type.way_out(), None);
    let error = container.numbers(container.find("packed").unwrap());
    assert!(error.unwrap_err().to_string().contains("zstd"));
    // Further names of what was found are not listed, nor are loops followed.
    assert_eq!(container.find("zone/b/again"), None);
    let name = open_fixture("matlab73.mat");
    let name = &name.variables[name.find("name").unwrap()];
    assert_eq!(name.sample_type, SampleType::Other("text".into()));
    assert_eq!(name.attributes.text("MATLAB_class"), Some("char"));
}

#[test]
fn val_h5py_attributes() {
    let container = open_fixture("plain.h5");
    let file = &container.attributes;
    assert_eq!(file.text("title"), Some("a test"));
    assert_eq!(file.number("rate"), Some(2.5));
    assert_eq!(file.text("zone/b/place"), Some("lab"));
    let of = |v: &&wavecascade_formats::Variable| v.attributes.text("units") == Some("m/s");
    let contiguous = container.variables.iter().find(of).unwrap();
    let get = |name| contiguous.attributes.get(name).unwrap().clone();
    let names = vec!["a".to_owned(), "b".to_owned()];
    assert_eq!(get("names"), Value::Texts(names));
    assert_eq!(get("numbers"), Value::Integers(vec![1, 2, 3]));
}

/// The variable that lists the values of a dimension.
fn listed(container: &Container, variable: &str, dimension: usize) -> Option<String> {
    let found = container.find(variable).unwrap();
    match container.variables[found].dimensions[dimension].coordinate {
        Some(Coordinate::Listed(i)) => Some(container.variables[i].path.clone()),
        _ => None,
    }
}

fn names(container: &Container, variable: &str) -> Vec<Option<String>> {
    let found = container.find(variable).unwrap();
    let dimensions = container.variables[found].dimensions.iter();
    dimensions.map(|d| d.name.clone()).collect()
}

#[test]
fn val_xarray_dimensions() {
    let some = |name: &str| Some(name.to_owned());
    for name in ["xarray.nc", "h5netcdf.nc"] {
        let container = open_fixture(name);
        let found = names(&container, "u");
        assert_eq!(found, [some("time"), some("x"), some("level")]);
        assert_eq!(listed(&container, "u", 0), some("/time"));
        assert_eq!(listed(&container, "u", 1), some("/x"));
        assert_eq!(listed(&container, "u", 2), None);
        assert_eq!(container.find("level"), None);
        assert_eq!(listed(&container, "time", 0), some("/time"));
        let of = |path| &container.variables[container.find(path).unwrap()].attributes;
        assert_eq!(of("u").text("units"), Some("m s-1"));
        assert_eq!(of("packed").number("scale_factor"), Some(0.5));
        assert_eq!(of("packed").number("_FillValue"), Some(-999.0));
        assert!(of("time").text("units").unwrap().contains(" since "));
    }
    let container = open_fixture("scales.h5");
    assert_eq!(names(&container, "v"), [some("t"), some("x")]);
    assert_eq!(listed(&container, "v", 0), some("/t"));
    assert_eq!(names(&container, "labelled"), [None, some("pitch")]);
}
