//! NetCDF-3 files against the reader of netCDF4.

mod expected;

use std::sync::Arc;

use expected::{compare, damage, files, open_bytes};
use wavecascade_formats::{Coordinate, Error, Format, Options, Value, open};

#[test]
fn val_netcdf4_every_variable() {
    let files = files("netcdf3");
    assert_eq!(files.len(), 6);
    for (name, bytes, found) in files {
        let container = open_bytes(&name, &bytes);
        let found = found.as_object().unwrap();
        assert_eq!(container.variables.len(), found.len(), "{name}");
        for (path, expected) in found {
            compare(&container, path, expected);
        }
    }
}

#[test]
fn val_definition_attributes_and_coordinates() {
    for (name, bytes, _) in files("netcdf3") {
        let container = open_bytes(&name, &bytes);
        let Some(v) = container.find("v") else {
            assert!(name.starts_with("single"));
            continue;
        };
        assert_eq!(container.attributes.text("title"), Some("a test"));
        let v = &container.variables[v];
        assert_eq!(v.attributes.text("units"), Some("m/s"));
        assert_eq!(v.attributes.number("scale_factor"), Some(0.01));
        let range = v.attributes.get("valid_range");
        assert_eq!(range, Some(&Value::Integers(vec![-99, 99])));
        let listed = |name| container.find(name).map(Coordinate::Listed);
        let names = ["time", "y", "x"];
        for (dimension, name) in v.dimensions.iter().zip(names) {
            assert_eq!(dimension.name.as_deref(), Some(name));
            assert_eq!(dimension.coordinate, listed(name));
        }
    }
}

#[test]
fn regress_open_number_of_records_is_refused() {
    let (_, mut bytes, _) = files("netcdf3").swap_remove(0);
    assert_eq!(bytes[3], 1);
    bytes[4..8].fill(0xff);
    let refused = open(Format::NetCdf3, Arc::new(bytes), &Options::default()).unwrap_err();
    assert!(matches!(refused, Error::Unsupported { .. }), "{refused}");
}

#[test]
fn regress_short_file_is_an_error() {
    for (name, bytes, _) in files("netcdf3") {
        // Padding of up to 3 bytes may follow the last sample.
        for len in 0..bytes.len() - 3 {
            let cut: Vec<u8> = bytes[..len].to_vec();
            let opened = open(Format::NetCdf3, Arc::new(cut), &Options::default());
            assert!(opened.is_err(), "{name}, {len} bytes");
        }
    }
}

#[test]
fn regress_damage_never_panics() {
    for (_, bytes, _) in files("netcdf3") {
        damage(Format::NetCdf3, &bytes, 1000);
    }
}
