//! Readers of every format against other programs that read and write it, and on damaged files.

mod common;
mod facts;
mod lammps;
mod mat;
mod netcdf3;
mod tdms;
mod uff;
#[cfg(feature = "zarr")]
mod zarr;

use std::sync::Arc;

use wavecascade_formats::{Error, Format, Options, open};

/// Of each folder: files, arrays that were compared, those that are not read, and variables of numbers.
#[test]
fn val_peers_every_array() {
    let mut folders = vec![
        ("lammps", [6, 21, 0, 58]),
        ("mat", [6, 85, 0, 69]),
        ("miniseed", [18, 33, 0, 24]),
        ("netcdf3", [6, 71, 0, 67]),
        ("segy", [12, 40, 0, 32]),
        ("tdms", [19, 85, 5, 53]),
        ("uff", [7, 10, 0, 32]),
    ];
    if cfg!(feature = "hdf5") {
        folders.push(("hdf5", [6, 53, 0, 53]));
    }
    if cfg!(feature = "zarr") {
        folders.push(("zarr", [6, 69, 2, 70]));
    }
    let found = folders
        .iter()
        .map(|(name, _)| (*name, common::compare_all(name)));
    assert_eq!(found.collect::<Vec<_>>(), folders);
}

/// Cut, and with a few other bytes: refused or read, never a panic; formats that are not compressed claim no more
/// than is there.
#[test]
fn regress_damaged_files_are_refused_or_read() {
    let compressed = ["hdf5", "mat", "netcdf3"].map(|folder| (folder, false));
    let others = ["lammps", "miniseed", "segy", "tdms", "uff"].map(|folder| (folder, true));
    for (folder, is_bounded) in compressed.into_iter().chain(others) {
        let mut count = 0;
        for entry in std::fs::read_dir(common::directory(folder)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let mut bytes = common::file(folder, &name);
            let Some(format) = Format::detect(&name, &bytes) else {
                continue;
            };
            if format == Format::Lammps {
                bytes.truncate(5000);
            }
            common::survives(format, &bytes, is_bounded);
            count += 1;
        }
        assert!(count > 3, "{folder}: {count}");
    }
}

/// A file that is not what its name says: the error tells what it is.
#[test]
fn regress_text_of_another_name() {
    for ending in ["h5", "nc", "mat", "dump", "tdms", "mseed", "uff", "sgy"] {
        let name = format!("bad.{ending}");
        let text = b"time,v\n0,1\n";
        let format = Format::detect(&name, text).unwrap();
        let error = open(format, Arc::new(text.to_vec()), &Options::default()).unwrap_err();
        let said = error.to_string();
        assert!(said.contains("the text \"time,v"), "{name}: {said}");
        let packed = Format::detect(&name, b"\x1f\x8b\x08");
        let is_other = ["h5", "nc", "mat", "dump"].contains(&ending);
        assert_eq!(packed.is_none(), is_other);
    }
}

#[test]
fn regress_memory_is_limited() {
    for (format, folder, name, allowed) in [
        (Format::Tdms, "tdms", "field.tdms", 1000),
        (Format::MiniSeed, "miniseed", "several.mseed", 1000),
        (Format::Mat5, "mat", "v5_compressed.mat", 300),
        (Format::Uff, "uff", "ascii.uff", 3 * 13 * 8 - 1),
        (Format::Lammps, "lammps", "granular.lammpstrj", 21 * 40),
    ] {
        let mut options = Options::default();
        options.memory = Some(allowed);
        let error = open(format, Arc::new(common::file(folder, name)), &options).unwrap_err();
        let is_it = matches!(error, Error::Memory { allowed: found, .. } if found == allowed);
        assert!(is_it, "{name}: {error}");
    }
}
