//! HDF5 against h5py, and against fields of which the truth is known.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value as Json;
use wavecascade_formats::{Container, Error, Format, Options, Sample, SampleType, open};

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
