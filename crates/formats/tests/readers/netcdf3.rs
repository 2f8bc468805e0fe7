//! NetCDF-3 files against the reader of netCDF4.

use std::sync::Arc;

use super::common::{compare_all, files, open_bytes};
use wavecascade_formats::{Error, Format, Options, open};

#[test]
fn val_netcdf4_every_variable() {
    compare_all("netcdf3", 6);
}

/// One byte each along `n`, 250 to 255 and 0, with attributes as NetCDF writes unsigned ones.
fn unsigned(stated: &str) -> Vec<u8> {
    let word = |text: &str| {
        let mut bytes = (text.len() as u32).to_be_bytes().to_vec();
        bytes.extend(text.as_bytes());
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        bytes
    };
    let number = |number: u32| number.to_be_bytes().to_vec();
    let mut bytes = [
        b"CDF\x01".to_vec(),
        number(0),
        number(10),
        number(1),
        word("n"),
        number(7),
    ]
    .concat();
    bytes.extend(
        [
            [0; 8].to_vec(),
            number(11),
            number(1),
            word("v"),
            number(1),
            number(0),
        ]
        .concat(),
    );
    let attributes = [
        number(12),
        number(2),
        word("_Unsigned"),
        number(2),
        word(stated),
    ]
    .concat();
    let fill = [
        word("_FillValue"),
        number(1),
        number(1),
        vec![0xff, 0, 0, 0],
    ]
    .concat();
    bytes.extend([attributes, fill, number(1), number(8)].concat());
    let begin = bytes.len() as u32 + 4;
    bytes.extend([number(begin), vec![250, 251, 252, 253, 254, 255, 0, 0]].concat());
    bytes
}

#[test]
fn val_definition_unsigned_bytes() {
    let found = |stated: &str| {
        let container = open_bytes("a.nc", &unsigned(stated));
        let fill = container.variables[0].attributes.number("_FillValue");
        (container.numbers(0).unwrap(), fill)
    };
    let as_unsigned = vec![250.0, 251.0, 252.0, 253.0, 254.0, 255.0, 0.0];
    assert_eq!(found("true"), (as_unsigned, Some(255.0)));
    let as_signed = vec![-6.0, -5.0, -4.0, -3.0, -2.0, -1.0, 0.0];
    assert_eq!(found("false"), (as_signed, Some(-1.0)));
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
