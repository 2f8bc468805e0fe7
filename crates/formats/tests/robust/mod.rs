//! Damaged copies of a file must be refused or read, never panic.

use std::sync::Arc;
use wavecascade_formats::{Format, Options, open};

/// Opens `bytes` cut at every `cut`-th length, and `mutations` copies with a few random bytes.
pub fn survives(format: Format, bytes: &[u8], cut: usize, mutations: usize) {
    for length in (0..bytes.len()).step_by(cut) {
        read_all(format, bytes[..length].to_vec());
    }
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for _ in 0..mutations {
        let mut damaged = bytes.to_vec();
        for _ in 0..1 + random(4) {
            damaged[random(bytes.len())] = random(256) as u8;
        }
        read_all(format, damaged);
    }
}

fn read_all(format: Format, bytes: Vec<u8>) {
    let length = bytes.len() as u64;
    let Ok(container) = open(format, Arc::new(bytes), &Options::default()) else {
        return;
    };
    for variable in 0..container.variables.len() {
        let found = &container.variables[variable];
        if found.sample_type.number().is_some() {
            assert!(found.count().unwrap() <= 8 * length, "{}", found.path);
            let _ = container.numbers(variable);
        }
    }
}
