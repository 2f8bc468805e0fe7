//! Reads all samples of a field a few times; prints the seconds of each, opening included, and their sum.
//!
//! Command: `cargo run --release --example read_field -- FILE [VARIABLE]`; run with the peers by
//! `benches/peers/formats/run.py`.

use std::error::Error;
use std::time::Instant;

use rayon::prelude::*;
use wavecascade::Field;
use wavecascade::field::{Layout, OpenOptions};

/// Times that a thread reads at once: few, so that their samples stay in L2.
const BLOCK: usize = 8;
const RUNS: usize = 5;

/// In lanes, as NumPy sums: one after the other, additions would take longer than reading.
fn sum(samples: &[f64]) -> f64 {
    let mut lanes = [0.0; 16];
    let parts = samples.chunks_exact(lanes.len());
    let rest: f64 = parts.remainder().iter().sum();
    for part in parts {
        lanes.iter_mut().zip(part).for_each(|(lane, v)| *lane += v);
    }
    rest + lanes.iter().sum::<f64>()
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let path = words.next().ok_or("which file?")?;
    let options = OpenOptions {
        variable: words.next(),
        layout: Some(Layout::TimeSite),
        hash: false,
        memory: Some(4 << 30),
        ..OpenOptions::default()
    };
    for _ in 0..RUNS {
        let begun = Instant::now();
        let field = Field::open(&path, &options)?;
        let (n_times, n_sites) = (field.n_times(), field.n_sites());
        let starts: Vec<usize> = (0..n_times).step_by(BLOCK).collect();
        let sums: Vec<f64> = starts
            .into_par_iter()
            .map_init(Vec::new, |room, from| {
                let times = from..n_times.min(from + BLOCK);
                room.resize(times.len() * n_sites, 0.0);
                field.read_time_major(times, 0..n_sites, room);
                sum(room)
            })
            .collect();
        let seconds = begun.elapsed().as_secs_f64();
        println!("{seconds:.4} {:e}", sums.iter().sum::<f64>());
    }
    Ok(())
}
