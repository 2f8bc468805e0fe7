//! Zarr stores against zarr-python and xarray (`make_zarr.py`).

use serde_json::{Map, Value as Json};
use std::fs;
use std::path::{Path, PathBuf};
use wavecascade_formats::{
    Attributes, ByteOrder, Container, Coordinate, Error, Format, Options, Place, Result, Sample,
    SampleType, Value, open_directory,
};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/zarr")
}

fn expected() -> Map<String, Json> {
    let json = fs::read(folder().join("expected.json")).unwrap();
    serde_json::from_slice(&json).unwrap()
}

fn open_path(path: &Path, options: &Options) -> Result<Container> {
    assert_eq!(Format::detect_directory(path), Some(Format::Zarr));
    open_directory(Format::Zarr, path, options)
}

fn opened(name: &str) -> Container {
    open_path(&folder().join(name), &Options::default()).unwrap()
}

/// The numbers of a variable as `make_zarr.py` writes their bits.
fn bits(container: &Container, variable: usize) -> String {
    let found = &container.variables[variable];
    let sample = found.sample_type.number().unwrap();
    let all: Vec<_> = found.dimensions.iter().map(|d| 0..d.len).collect();
    let mut out = vec![0; found.count().unwrap() as usize * sample.bytes()];
    container.read(variable, &all, &mut out).unwrap();
    hex(&mut out, sample.bytes())
}

fn hex(out: &mut [u8], size: usize) -> String {
    if ByteOrder::NATIVE == ByteOrder::Little {
        out.chunks_exact_mut(size).for_each(<[u8]>::reverse);
    }
    out.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn attributes<'a>(container: &'a Container, path: &str) -> &'a Attributes {
    &container.variables[container.find(path).unwrap()].attributes
}

#[test]
fn val_zarr_python_arrays() {
    let mut compared = 0;
    for (name, arrays) in expected() {
        let container = opened(&name);
        for (path, array) in arrays.as_object().unwrap() {
            if !path.starts_with('/') || array.is_null() {
                continue;
            }
            let at = container.find(path).unwrap();
            let found = &container.variables[at];
            // Filters and compressors that are not read.
            if name == "v2.zarr" && matches!(path.as_str(), "/bz2" | "/delta") {
                assert_eq!(found.sample_type.number(), None);
                continue;
            }
            let shape: Vec<u64> = serde_json::from_value(array["shape"].clone()).unwrap();
            assert_eq!(found.shape(), shape, "{name} {path}");
            let names: Vec<Option<String>> =
                serde_json::from_value(array["dimensions"].clone()).unwrap();
            let found_names: Vec<_> = found.dimensions.iter().map(|d| d.name.clone()).collect();
            assert_eq!(found_names, names, "{name} {path}");
            let sample = found.sample_type.number();
            let sample = sample.unwrap_or_else(|| panic!("{path}: {:?}", found.sample_type));
            assert_eq!(sample.name(), array["type"], "{name} {path}");
            assert_eq!(bits(&container, at), array["bits"], "{name} {path}");
            compared += 1;
        }
    }
    assert!(compared >= 68, "{compared}");
}

#[test]
fn val_zarr_python_what_is_no_number() {
    for name in ["v2.zarr", "v3.zarr"] {
        let container = opened(name);
        let other = |path: &str| {
            let found = &container.variables[container.find(path).unwrap()];
            match &found.sample_type {
                SampleType::Other(other) => other.clone(),
                found => panic!("{path}: {found:?}"),
            }
        };
        assert_eq!(other("texts"), "text");
        assert_eq!(other("complex"), "complex numbers");
        let title = container.attributes.text("title");
        assert_eq!(title, Some("a title"));
    }
    let container = opened("v2.zarr");
    for (path, codec) in [("bz2", "bz2"), ("delta", "delta")] {
        let found = &container.variables[container.find(path).unwrap()];
        assert!(
            matches!(&found.sample_type, SampleType::Other(other) if other.contains(codec)),
            "{found:?}"
        );
    }
}

#[test]
fn val_zarr_python_blocks_of_chunks_and_shards() {
    for (name, path) in [
        ("v2.zarr", "zlib"),
        ("v2.zarr", "unwritten"),
        ("v3.zarr", "sharded"),
        ("v3.zarr", "sharded_in_part"),
        ("v3.zarr", "transposed"),
    ] {
        let container = opened(name);
        let at = container.find(path).unwrap();
        let found = &container.variables[at];
        let size = found.sample_type.number().unwrap().bytes();
        let shape = found.shape();
        let all = &expected()[name][&format!("/{path}")]["bits"];
        let all = all.as_str().unwrap();
        let number = |index: &[u64]| {
            let at = index
                .iter()
                .zip(&shape)
                .fold(0, |at, (i, len)| at * len + i) as usize;
            &all[2 * size * at..2 * size * (at + 1)]
        };
        // Every block of two and of one index of the first dimension, of all but one of the second.
        for from in 0..shape[0] - 1 {
            for to in from + 1..=shape[0].min(from + 2) {
                let mut block: Vec<_> = shape.iter().map(|&len| 0..len).collect();
                block[0] = from..to;
                block[1] = 1..shape[1];
                let count: u64 = block.iter().map(|range| range.end - range.start).product();
                let mut out = vec![0; count as usize * size];
                container.read(at, &block, &mut out).unwrap();
                let mut wanted = String::new();
                for i in from..to {
                    for j in 1..shape[1] {
                        match shape.get(2) {
                            None => wanted += number(&[i, j]),
                            Some(&len) => (0..len).for_each(|k| wanted += number(&[i, j, k])),
                        }
                    }
                }
                assert_eq!(hex(&mut out, size), wanted, "{path} {block:?}");
            }
        }
    }
    let rows = |name: &str, path: &str| {
        let container = opened(name);
        container.variables[container.find(path).unwrap()]
            .place
            .clone()
    };
    assert_eq!(rows("v2.zarr", "zlib"), Place::Encoded { rows: 3 });
    // A chunk within a shard.
    assert_eq!(rows("v3.zarr", "sharded"), Place::Encoded { rows: 2 });
}

#[test]
fn val_xarray_encodings() {
    for name in ["xarray2.zarr", "xarray3.zarr"] {
        let container = opened(name);
        let expected = &expected()[name];
        for (path, fill) in expected["fills"].as_object().unwrap() {
            let variable = &container.variables[container.find(path).unwrap()];
            if variable.sample_type.number().is_none() {
                continue;
            }
            let found = variable.attributes.number("_FillValue");
            let found = found.map(|fill| format!("{:016x}", fill.to_bits()));
            assert_eq!(found.as_deref(), fill.as_str(), "{name} {path}");
        }
        for (path, unit) in expected["units"].as_object().unwrap() {
            let found = attributes(&container, path).text("units");
            assert_eq!(found, unit.as_str(), "{name} {path}");
        }
        for (path, bits) in expected["decoded"].as_object().unwrap() {
            let at = container.find(path).unwrap();
            let attributes = &container.variables[at].attributes;
            let scale = attributes.number("scale_factor").unwrap_or(1.0);
            let offset = attributes.number("add_offset").unwrap_or(0.0);
            let fill = attributes.number("_FillValue").unwrap();
            let decode = |number: f64| match number == fill || number.is_nan() {
                true => f64::NAN,
                false => number * scale + offset,
            };
            let numbers = container.numbers(at).unwrap();
            for (i, number) in numbers.into_iter().enumerate() {
                let bits = &bits.as_str().unwrap()[16 * i..16 * (i + 1)];
                let wanted = f64::from_bits(u64::from_str_radix(bits, 16).unwrap());
                let found = decode(number);
                let is_same = found == wanted || found.is_nan() && wanted.is_nan();
                assert!(is_same, "{name} {path} {found} {wanted}");
            }
        }
        let velocity = &container.variables[container.find("velocity").unwrap()];
        let listed = |path| Some(Coordinate::Listed(container.find(path).unwrap()));
        assert_eq!(velocity.dimensions[0].coordinate, listed("time"));
        assert_eq!(velocity.dimensions[1].coordinate, listed("x"));
        assert!(
            attributes(&container, "velocity")
                .get("_ARRAY_DIMENSIONS")
                .is_none()
        );
        assert_eq!(container.attributes.text("title"), Some("a field"));
        assert_eq!(
            container.attributes.get("list"),
            Some(&Value::Numbers(vec![1.0, 2.5]))
        );
    }
}

#[test]
fn val_xarray_fill_of_version_2_is_a_gap() {
    let container = opened("zeros2.zarr");
    let zeros = container.numbers(container.find("v").unwrap()).unwrap();
    let zeros = zeros.iter().filter(|v| **v == 0.0).count();
    assert_eq!(expected()["zeros2.zarr"]["gaps"], zeros);
    assert_eq!(attributes(&container, "v").number("_FillValue"), Some(0.0));
    // xarray does not open an array without names of its dimensions.
    assert_eq!(attributes(&container, "nameless").get("_FillValue"), None);
    let container = opened("v3.zarr");
    assert_eq!(attributes(&container, "unwritten").get("_FillValue"), None);
}

#[test]
fn val_numpy_times() {
    let units = |name: &str, path: &str| {
        let container = opened(name);
        let units = attributes(&container, path)
            .text("units")
            .map(str::to_owned);
        units.unwrap()
    };
    assert_eq!(units("v2.zarr", "when"), "milliseconds since 1970-01-01");
    assert_eq!(units("v2.zarr", "lasts"), "microseconds");
    assert_eq!(units("v3.zarr", "when"), "nanoseconds since 1970-01-01");
    let container = opened("v2.zarr");
    let when = container.integers(container.find("when").unwrap()).unwrap();
    assert_eq!(when, Some(vec![1_767_225_600_500, i64::MIN]));
}

/// A copy of a store that a test may change.
struct Scratch(PathBuf);

impl Scratch {
    fn copy(name: &str, of: &str) -> Scratch {
        let to = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(&to);
        copy(&folder().join(of), &to);
        Scratch(to)
    }

    fn open(&self) -> Result<Container> {
        open_path(&self.0, &Options::default())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let from = entry.unwrap().path();
        let to = to.join(from.file_name().unwrap());
        match from.is_dir() {
            true => copy(&from, &to),
            false => fs::write(&to, fs::read(&from).unwrap()).unwrap(),
        }
    }
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => files(&path, found),
            false => found.push(path),
        }
    }
    found.sort();
}

fn read_all(scratch: &Scratch) {
    let Ok(container) = scratch.open() else {
        return;
    };
    for variable in 0..container.variables.len() {
        if container.variables[variable].sample_type.number().is_some() {
            let _ = container.numbers(variable);
        }
    }
}

#[test]
fn regress_damaged_bytes() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for name in ["v2.zarr", "v3.zarr", "xarray3.zarr"] {
        let scratch = Scratch::copy(&format!("damaged-{name}"), name);
        let mut all = Vec::new();
        files(&scratch.0, &mut all);
        // One array at a time, so that damage of one does not hide another.
        for path in all {
            let array = path.ancestors().find(|folder| {
                folder.join("zarr.json").is_file() || folder.join(".zarray").is_file()
            });
            let Some(array) = array.filter(|array| *array != scratch.0) else {
                continue;
            };
            let scratch = std::mem::ManuallyDrop::new(Scratch(array.to_owned()));
            let bytes = fs::read(&path).unwrap();
            for length in (0..bytes.len()).step_by(1 + bytes.len() / 5) {
                fs::write(&path, &bytes[..length]).unwrap();
                read_all(&scratch);
            }
            for _ in 0..6 {
                let mut damaged = bytes.clone();
                for _ in 0..1 + random(4) {
                    if !bytes.is_empty() {
                        damaged[random(bytes.len())] = random(256) as u8;
                    }
                }
                fs::write(&path, &damaged).unwrap();
                read_all(&scratch);
            }
            fs::write(&path, &bytes).unwrap();
        }
    }
}

#[test]
fn regress_a_chunk_cut_short_is_damaged() {
    for (of, array, chunk) in [
        ("v2.zarr", "raw", "0.0"),
        ("v2.zarr", "gzip", "1.0"),
        ("v2.zarr", "blosc_lz4", "1.0"),
        ("v2.zarr", "zstd", "0.0"),
        ("v3.zarr", "crc", "c/0/0"),
        ("v3.zarr", "sharded", "c/1/0"),
    ] {
        let scratch = Scratch::copy(&format!("cut-{array}"), of);
        let chunk = scratch.0.join(array).join(chunk);
        let bytes = fs::read(&chunk).unwrap();
        fs::write(&chunk, &bytes[..bytes.len() - 5]).unwrap();
        let container = scratch.open().unwrap();
        let error = container
            .numbers(container.find(array).unwrap())
            .unwrap_err();
        assert!(matches!(&error, Error::Damaged { place, .. } if place.contains(array)));
    }
}

#[test]
fn regress_memory_and_claims_are_limited() {
    let mut options = Options::default();
    options.memory = Some(2 * 13 * 10 * 8 + 1000);
    let path = folder().join("v3.zarr");
    let container = open_path(&path, &options).unwrap();
    let at = container.find("sharded").unwrap();
    assert!(container.numbers(at).is_ok());
    options.memory = Some(13 * 10 * 8);
    let container = open_path(&path, &options).unwrap();
    let error = container.numbers(at).unwrap_err();
    assert!(matches!(error, Error::Memory { .. }), "{error}");

    // A small store may stand for little.
    let scratch = Scratch::copy("claims", "alone.zarr");
    let metadata = scratch.0.join("zarr.json");
    let text = fs::read_to_string(&metadata).unwrap();
    for (from, to, expected) in [
        (
            "\"shape\": [\n    5,",
            "\"shape\": [\n    500000000,",
            "at most",
        ),
        (
            "\"chunk_shape\": [\n        2,",
            "\"chunk_shape\": [\n        2000000000000,",
            "chunks of at most",
        ),
    ] {
        assert!(text.contains(from), "{text}");
        fs::write(&metadata, text.replace(from, to)).unwrap();
        let error = scratch
            .open()
            .and_then(|container| container.numbers(0))
            .unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    let deep = text.replace("\"shape\": [\n    5,", "\"shape\": [\n    -5,");
    fs::write(&metadata, deep).unwrap();
    assert!(scratch.open().unwrap_err().to_string().contains("a shape"));
}

#[test]
fn regress_a_store_of_one_array() {
    let container = opened("alone.zarr");
    assert_eq!(container.variables[0].path, "/alone");
    assert_eq!(
        container.variables[0].sample_type,
        SampleType::Number(Sample::F64)
    );
    assert_eq!(Format::detect_directory(&folder()), None);
}
