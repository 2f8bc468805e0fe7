//! Estimates of a field in memory: milliseconds of processor time of each, the median of some runs.
//!
//! Command: `cargo run --release --example estimates -- FIELD.npy [THREADS]`. With more than one thread the milliseconds
//! are those of a clock. `benches/peers/python_estimates.py` times the peers on the same field.

use std::error::Error;
use std::time::Instant;

use wavecascade::Field;
use wavecascade::estimates::{
    Averaging, BicoherenceRequest, CoherenceRequest, ModesRequest, bicoherence, coherence, modes,
};
use wavecascade::field::{Layout, OpenOptions, ReadMode};
use wavecascade::observer::Silent;

const RUNS: usize = 7;

/// Processor time of all threads where the system tells it, else the clock.
fn processor_time(start: Instant) -> f64 {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        let _ = start;
        time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
    }
    #[cfg(not(unix))]
    start.elapsed().as_secs_f64()
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let path = words.next().ok_or("which file?")?;
    let threads: usize = words.next().map_or(Ok(1), |word| word.parse())?;
    let options = OpenOptions {
        layout: Some(Layout::TimeSite),
        hash: false,
        read: ReadMode::Copy,
        ..OpenOptions::default()
    };
    let field = Field::open(&path, &options)?;
    let threads = Some(threads);
    let averaging = |segment| Averaging {
        segment: Some(segment),
        ..Averaging::default()
    };
    let time = |name: &str, work: &dyn Fn() -> wavecascade::Result<()>| {
        let start = Instant::now();
        let clock = || match threads {
            Some(1) => processor_time(start),
            _ => start.elapsed().as_secs_f64(),
        };
        let mut milliseconds = Vec::new();
        for _ in 0..RUNS {
            let begun = clock();
            work()?;
            milliseconds.push(1e3 * (clock() - begun));
        }
        milliseconds.sort_by(f64::total_cmp);
        println!("{name:<28} {:.2}", milliseconds[RUNS / 2]);
        Ok::<(), wavecascade::Error>(())
    };
    time("coherence, 1024", &|| {
        let request = CoherenceRequest {
            averaging: averaging(1024),
            threads,
            ..CoherenceRequest::default()
        };
        coherence(&[&field], &request, &Silent).map(|_| ())
    })?;
    for (name, along) in [
        ("bicoherence of a site, 512", 0..0),
        ("bicoherence of all, 512", 0..field.n_sites()),
    ] {
        time(name, &|| {
            let request = BicoherenceRequest {
                along: along.clone().collect(),
                averaging: averaging(512),
                threads,
                ..BicoherenceRequest::default()
            };
            bicoherence(&[&field], &request, &Silent).map(|_| ())
        })?;
    }
    for segment in [512, 1024] {
        time(&format!("modes, {segment}"), &|| {
            let request = ModesRequest {
                averaging: averaging(segment),
                threads,
                ..ModesRequest::default()
            };
            modes(&[&field], &request, &Silent).map(|_| ())
        })?;
    }
    Ok(())
}
