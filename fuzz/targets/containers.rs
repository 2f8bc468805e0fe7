//! A file of named arrays: HDF5, NetCDF, MATLAB, SEG-Y, Seismic Unix, UFF, TDMS, miniSEED, or a LAMMPS dump, as
//! the first byte says. What is read is held to a second opinion.

#![no_main]

use std::sync::Arc;

use cascade_fuzz::{file, open_and_analyze, opinion};
use libfuzzer_sys::fuzz_target;
use wavecascade::field::{OpenOptions, inspect};
use wavecascade_formats::{Format, Options, open};

const NAMES: [&str; 9] = [
    "field.h5",
    "field.nc",
    "field.mat",
    "field.sgy",
    "field.su",
    "field.uff",
    "field.tdms",
    "field.mseed",
    "field.lammpstrj",
];

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else {
        return;
    };
    let name = NAMES[usize::from(*kind) % NAMES.len()];
    let container = Format::detect(name, bytes)
        .and_then(|format| open(format, Arc::new(bytes.to_vec()), &Options::default()).ok());
    if let Some(container) = container {
        assert_eq!(opinion::disagreement(&container, bytes), None);
    }
    let path = file(name, bytes);
    let _listed = inspect(&path, &OpenOptions::default());
    open_and_analyze(&path);
});
