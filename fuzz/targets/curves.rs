//! A measured curve of attenuation.

#![no_main]

use cascade_fuzz::file;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = wavecascade::attenuation::read_curve(&file("curve.csv", bytes));
});
