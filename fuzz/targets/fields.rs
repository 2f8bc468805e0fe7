//! A field in `.npy`, after the text of its sidecar.

#![no_main]

use cascade_fuzz::{file, open_and_analyze};
use libfuzzer_sys::fuzz_target;

const MAGIC: &[u8] = b"\x93NUMPY";

fuzz_target!(|bytes: &[u8]| {
    let start = bytes.windows(MAGIC.len()).position(|part| part == MAGIC);
    let (sidecar, array) = bytes.split_at(start.unwrap_or(0));
    file("field.toml", sidecar);
    open_and_analyze(&file("field.npy", array));
});
