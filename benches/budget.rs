//! Budgets of a run against the transforms they need: `cargo bench --bench budget`.
//!
//! A struck dimer of 300 sites at 4096 samples. The limit is the time of the transforms alone, made
//! with the same library in the same process: over sites (four rows a sample), over unit cells
//! (three rows a sample, and three back for each scale), and over time (two records a contact).
//! Medians of interleaved rounds on one thread, in processor time, so that other work on the machine
//! counts only by what it takes of shared caches and units.

use std::hint::black_box;

use column_fft::rows;
use num_complex::Complex;
use wavecascade::arrays::{Arrays, LargeArray, Sink};
use wavecascade::budget::{BudgetRequest, Integration, Motion, Views};
use wavecascade::chain::{Chain, Simulation};
use wavecascade::observer::Silent;

const SITES: usize = 300;
const SAMPLES: usize = 4096;
const ROUNDS: usize = 9;

/// Takes the arrays and forgets them.
struct Nowhere;

impl Sink for Nowhere {
    fn reserve(&self, _: LargeArray, _: (usize, usize)) -> wavecascade::Result<()> {
        Ok(())
    }

    fn put(
        &self,
        _: LargeArray,
        _: usize,
        _: usize,
        block: ndarray::ArrayView2<f64>,
    ) -> wavecascade::Result<()> {
        black_box(block);
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let simulation = Simulation::impact(Chain::dimer(SITES, 4.9272), 1.0, 295.0, SAMPLES);
    let run = simulation.run(&Silent)?;
    let motion = Motion::of(&run)?;
    let views = [
        ("wavenumber", [true, false, false]),
        ("frequency", [false, true, false]),
        ("scale", [false, false, true]),
        ("all", [true, true, true]),
    ];
    let request = |[wavenumber, frequency, scale]: [bool; 3], integration| BudgetRequest {
        views: Views {
            wavenumber,
            frequency,
            scale,
        },
        integration,
        threads: Some(1),
        ..BudgetRequest::default()
    };
    let (found, _): (_, Arrays) =
        wavecascade::budget::budget(&motion, &request([true; 3], Integration::Samples))?;
    let scales = found.scales.map_or(0, |found| found.scales.len());
    println!("{SITES} sites, {SAMPLES} samples, {scales} scales, one thread");
    println!(
        "{:>12} {:>12} {:>14} {:>8}",
        "view", "budget (ms)", "transforms", "ratio"
    );
    for (name, chosen) in views {
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..ROUNDS {
            let started = processor_time();
            let request = request(chosen, Integration::Samples);
            black_box(wavecascade::budget::run(
                &motion, &request, &Nowhere, &Silent,
            )?);
            times[0].push(processor_time() - started);
            let started = processor_time();
            transforms(chosen, scales);
            times[1].push(processor_time() - started);
        }
        let [ours, limit] = times.map(median);
        println!(
            "{name:>12} {:>12.1} {:>14.1} {:>8.2}",
            1e3 * ours,
            1e3 * limit,
            ours / limit
        );
    }
    let started = processor_time();
    let request = request([true; 3], Integration::Stepping);
    let found = wavecascade::budget::run(&motion, &request, &Nowhere, &Silent)?;
    let seconds = processor_time() - started;
    println!(
        "all, integrated inside the stepping: {seconds:.2} s, {:?}",
        found.closure.wavenumber
    );
    Ok(())
}

/// Processor time of all threads where the system tells it, else the clock.
fn processor_time() -> f64 {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
    }
    #[cfg(not(unix))]
    {
        use std::{sync::LazyLock, time::Instant};
        static START: LazyLock<Instant> = LazyLock::new(Instant::now);
        START.elapsed().as_secs_f64()
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The transforms of the views, on numbers of the right size.
fn transforms([wavenumber, frequency, scale]: [bool; 3], scales: usize) {
    let forward = |length: usize, count: usize| {
        let plan = rows::plan_fft_forward::<f64>(length);
        let mut input: Vec<f64> = (0..length).map(|i| (0.3 * i as f64).sin()).collect();
        let (mut output, mut work) = (plan.make_output_vec(), plan.make_scratch_vec());
        for _ in 0..count {
            let _ = plan.process_with_scratch(&mut input, &mut output, &mut work);
            // The transform leaves its input as scratch, which must not grow.
            input.iter_mut().for_each(|x| *x = 0.5);
            black_box(&output);
        }
    };
    if wavenumber {
        forward(SITES, 4 * SAMPLES);
    }
    if frequency {
        forward(SAMPLES, 2 * SITES);
    }
    if scale {
        forward(SITES / 2, 2 * 3 * SAMPLES);
        let plan = rows::plan_fft_inverse::<f64>(SITES / 2);
        let (mut input, mut output) = (plan.make_input_vec(), plan.make_output_vec());
        let mut work = plan.make_scratch_vec();
        for _ in 0..2 * 3 * SAMPLES * scales {
            input.iter_mut().for_each(|z| *z = Complex::new(0.5, 0.0));
            let _ = plan.process_with_scratch(&mut input, &mut output, &mut work);
            black_box(&output);
        }
    }
}
