//! The directory of a sweep: its request in the first line, its members in the others.

#![no_main]

use cascade_fuzz::{directory, file};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let end = bytes.iter().position(|byte| *byte == b'\n');
    let (request, members) = bytes.split_at(end.map_or(bytes.len(), |at| at + 1));
    file("sweep.json", request);
    file("members.jsonl", members);
    let _ = wavecascade::sweep::read(directory());
});
