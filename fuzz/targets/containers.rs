//! A file of named arrays: HDF5, NetCDF, MATLAB, SEG-Y, Seismic Unix, UFF, TDMS, miniSEED, or a LAMMPS dump, as
//! the first byte says.

#![no_main]

use cascade_fuzz::{file, open_and_analyze};
use libfuzzer_sys::fuzz_target;
use wavecascade::field::{OpenOptions, inspect};

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
    let path = file(NAMES[usize::from(*kind) % NAMES.len()], bytes);
    let _listed = inspect(&path, &OpenOptions::default());
    open_and_analyze(&path);
});
