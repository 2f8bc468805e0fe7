//! Every scheme of `cascade` on the dimer chain, in the rows that the peers print.
//!
//! Command: `cargo run --release --example cascade_rows -- --reference FILE.npz --kappa 4.9272
//! --runs 3`; run with the peers by `benches/peers/chain/run.py`. The problem, the timing (one run
//! for warming up, then `--runs` of them until three seconds have passed) and the error (the largest
//! difference of a velocity from the reference) are those of `peer.py`.

use std::error::Error;
use std::time::Instant;

use ndarray::{Array1, Array2};
use ndarray_npy::NpzReader;
use wavecascade::chain::{Accuracy, Chain, Record, Scheme, Simulation};
use wavecascade::observer::Silent;

const LONGEST_S: f64 = 3.0;

struct Asked {
    reference: String,
    kappa: f64,
    runs: usize,
}

impl Asked {
    fn read() -> Result<Asked, Box<dyn Error>> {
        let mut asked = Asked {
            reference: String::new(),
            kappa: 4.9272,
            runs: 3,
        };
        let mut words = std::env::args().skip(1);
        while let Some(name) = words.next() {
            let value = words.next().ok_or_else(|| format!("{name}: no value"))?;
            match name.as_str() {
                "--reference" => asked.reference = value,
                "--kappa" => asked.kappa = value.parse()?,
                "--runs" => asked.runs = value.parse()?,
                _ => return Err(format!("{name}: --reference, --kappa or --runs expected").into()),
            }
        }
        Ok(asked)
    }
}

fn settings(scheme: Scheme) -> Vec<(String, f64)> {
    if scheme.is_adaptive() {
        let local = |e: i32| (format!("local error 1e-{e}"), 10f64.powi(-e));
        (3..=14).map(local).collect()
    } else {
        let steps = |m: u32| (format!("{m} steps a sample"), 1.0 / f64::from(m));
        (3..=12).map(|e| steps(1 << e)).collect()
    }
}

unsafe extern "C" {
    /// Microseconds of CPU time that this process has used (POSIX).
    safe fn clock() -> std::ffi::c_long;
}

fn cpu_time() -> f64 {
    1e-6 * clock() as f64
}

fn main() -> Result<(), Box<dyn Error>> {
    let asked = Asked::read()?;
    let mut npz = NpzReader::new(std::fs::File::open(&asked.reference)?)?;
    let time: Array1<f64> = npz.by_name("t")?;
    let exact: Array2<f64> = npz.by_name("v")?;
    let (samples, sites) = exact.dim();
    let end = time[samples - 1];

    let mut simulation = Simulation::impact(Chain::dimer(sites, asked.kappa), 1.0, end, samples);
    simulation.record = Record::default();
    simulation.estimate_error = false;
    for scheme in Scheme::ALL {
        simulation.scheme = scheme;
        for (setting, value) in settings(scheme) {
            simulation.accuracy = if scheme.is_adaptive() {
                Accuracy::LocalError(value)
            } else {
                // A hair longer, so that no rounding adds a step.
                Accuracy::Step(value * end / (samples - 1) as f64 * (1.0 + 1e-12))
            };
            let mut run = match simulation.run(&Silent) {
                Ok(run) => run,
                Err(error) => {
                    eprintln!(
                        "cascade {scheme:?} {setting}, kappa {}: {error}",
                        asked.kappa
                    );
                    continue;
                }
            };
            let (mut seconds, mut cpu_seconds) = (Vec::new(), Vec::new());
            while seconds.len() < asked.runs && seconds.iter().sum::<f64>() < LONGEST_S {
                let (start, before) = (Instant::now(), cpu_time());
                run = simulation.run(&Silent)?;
                seconds.push(start.elapsed().as_secs_f64());
                cpu_seconds.push(cpu_time() - before);
            }
            let pairs = run.velocity.iter().zip(&exact);
            let error = pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()));
            let row = serde_json::json!({
                "program": "cascade",
                "scheme": serde_json::to_value(scheme)?,
                "kappa": asked.kappa,
                "setting": setting,
                "error": error,
                "seconds": seconds,
                "cpu_seconds": cpu_seconds,
            });
            println!("{row}");
        }
    }
    Ok(())
}
