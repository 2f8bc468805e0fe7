//! NetCDF-3 files.

use std::sync::Arc;

use super::common::{expected, file};
use wavecascade_formats::{Format, Options, open};

#[test]
fn regress_short_file_is_an_error() {
    for name in expected("netcdf3").keys() {
        let bytes = file("netcdf3", name);
        // Padding of up to 3 bytes may follow the last sample.
        for len in 0..bytes.len() - 3 {
            let cut: Vec<u8> = bytes[..len].to_vec();
            let opened = open(Format::NetCdf3, Arc::new(cut), &Options::default());
            assert!(opened.is_err(), "{name}, {len} bytes");
        }
    }
}
