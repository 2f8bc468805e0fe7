//! What is read of every file, and of mutated ones, against a second opinion: the one that random input is held to.

#[path = "../../../fuzz/src/opinion.rs"]
mod opinion;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use wavecascade_formats::{Container, Format, Options, open};

/// Files of every format but of stores in directories.
fn files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files");
    let formats = [
        "segy", "lammps", "netcdf3", "miniseed", "tdms", "uff", "mat", "hdf5",
    ];
    let of = |format: &str| fs::read_dir(folder.join(format)).unwrap();
    let all = formats.iter().flat_map(|format| of(format));
    let mut all: Vec<PathBuf> = all.map(|entry| entry.unwrap().path()).collect();
    all.retain(|path| path.extension().is_none_or(|extension| extension != "json"));
    all.sort();
    all
}

fn read(name: &str, bytes: &[u8]) -> Option<Container> {
    let format = Format::detect(name, bytes)?;
    open(format, Arc::new(bytes.to_vec()), &Options::default()).ok()
}

#[test]
fn val_files_hold_what_a_second_count_says() {
    let mut read_ones = 0;
    for path in files() {
        let bytes = fs::read(&path).unwrap();
        let Some(container) = read(&path.to_string_lossy(), &bytes) else {
            continue;
        };
        read_ones += 1;
        let said = opinion::disagreement(&container, &bytes);
        assert_eq!(said, None, "{}", path.display());
    }
    assert!(read_ones > 60, "{read_ones} files are read");
}

/// Digits and bytes that are changed one by one: what is still read is read in whole, or it is said.
#[test]
fn val_mutated_files_hold_what_a_second_count_says() {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for path in files() {
        let name = path.to_string_lossy().into_owned();
        let bytes = fs::read(&path).unwrap();
        if bytes.len() > 1 << 16 {
            continue;
        }
        for _ in 0..60 {
            let mut changed = bytes.clone();
            for _ in 0..1 + random(3) {
                let at = random(changed.len());
                changed[at] = match changed[at].is_ascii_digit() {
                    true => b'0' + random(10) as u8,
                    false => random(256) as u8,
                };
            }
            if let Some(container) = read(&name, &changed) {
                let said = opinion::disagreement(&container, &changed);
                assert_eq!(said, None, "{name}");
            }
        }
    }
}
