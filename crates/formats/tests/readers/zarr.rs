//! Damaged stores of Zarr.

use std::fs;
use std::path::{Path, PathBuf};

use wavecascade_formats::{Container, Error, Format, Options, Result, open_directory};

use super::common::directory;

fn open_path(path: &Path, options: &Options) -> Result<Container> {
    assert_eq!(Format::detect_directory(path), Some(Format::Zarr));
    open_directory(Format::Zarr, path, options)
}

/// A copy of a store that a test may change.
struct Scratch(PathBuf);

impl Scratch {
    fn copy(name: &str, of: &str) -> Scratch {
        let to = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(&to);
        copy(&directory("zarr").join(of), &to);
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
    let path = directory("zarr").join("v3.zarr");
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
fn regress_a_folder_of_stores_is_none() {
    assert_eq!(Format::detect_directory(&directory("zarr")), None);
}
