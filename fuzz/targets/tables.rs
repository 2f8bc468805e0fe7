//! A field in a table of text.

#![no_main]

use cascade_fuzz::{file, open_and_analyze};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| open_and_analyze(&file("field.csv", bytes)));
