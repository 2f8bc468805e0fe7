//! Time against error of a struck dimer chain, by every scheme.
//!
//! `cargo bench --bench chain` prints a table in CSV: for each stiffness ratio, number of samples,
//! scheme and accuracy the largest error of a velocity at the samples relative to the impact speed
//! (against a run of the default scheme with a local error of 3e-14), the shortest and the median
//! processor time of the stepping alone (one pass, velocities recorded), and what was done for it.
//! `-- pass` prints the same for the default, which records everything and checks itself.
//! A first argument that names no mode picks stiffness ratios: `-- 4.9272`. With `--test` small
//! chains are run once.

#[cfg(not(target_os = "linux"))]
use std::time::Instant;

use wavecascade::chain::{Accuracy, Chain, Record, Run, Scheme, Simulation};
use wavecascade::observer::Silent;

/// What is measured, and how often.
struct Plan {
    sites: usize,
    end: f64,
    repeats: usize,
    ratios: Vec<f64>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let has = |name: &str| arguments.iter().any(|argument| argument == name);
    let ratios: Vec<f64> = arguments.iter().filter_map(|a| a.parse().ok()).collect();
    let plan = Plan {
        sites: if has("--test") { 24 } else { 300 },
        end: if has("--test") { 10.0 } else { 295.0 },
        repeats: if has("--test") { 1 } else { 9 },
        ratios: if ratios.is_empty() {
            vec![1.0, 4.9272, 14.622, 1631.0]
        } else {
            ratios
        },
    };
    work_precision(&plan, has("pass"));
}

fn work_precision(plan: &Plan, whole: bool) {
    println!(
        "stiffness_ratio,samples,scheme,accuracy,error,best_ms,median_ms,steps,rejected,forces,corrected"
    );
    for &ratio in &plan.ratios {
        for samples in [64, 4096] {
            let chain = Chain::dimer(plan.sites, ratio);
            let mut simulation = Simulation::impact(chain, 1.0, plan.end, samples);
            simulation.record = Record::default();
            simulation.estimate_error = false;
            simulation.accuracy = Accuracy::LocalError(3e-14);
            let best = run(&simulation);
            for (scheme, accuracy) in accuracies(ratio, whole) {
                simulation.scheme = scheme;
                simulation.accuracy = accuracy;
                if whole {
                    simulation.record = Record::ALL;
                    simulation.estimate_error = true;
                }
                let Some((times, found)) = timed(&simulation, plan.repeats) else {
                    continue;
                };
                let error = (&found.velocity - &best.velocity)
                    .iter()
                    .fold(0.0, |worst: f64, d| worst.max(d.abs()));
                let cost = found.report.cost;
                println!(
                    "{ratio},{samples},{scheme:?},{accuracy:?},{error:.2e},{:.3},{:.3},{},{},{},{}",
                    times[0],
                    times[times.len() / 2],
                    cost.steps,
                    cost.rejected_steps,
                    cost.forces,
                    cost.corrected_contacts
                );
            }
        }
    }
}

/// Schemes and how accurate they are asked to be.
fn accuracies(ratio: f64, whole: bool) -> Vec<(Scheme, Accuracy)> {
    let tens = |from: i32, to: i32| (from..=to).map(|e| 10f64.powi(-e));
    if whole {
        return tens(4, 11)
            .map(|tolerance| (Scheme::Nystrom, Accuracy::Tolerance(tolerance)))
            .collect();
    }
    let mut all: Vec<(Scheme, Accuracy)> = Vec::new();
    for scheme in [Scheme::Nystrom, Scheme::RungeKutta] {
        let local = tens(4, 12).flat_map(|e| [e, 0.3 * e]);
        all.extend(local.map(|local| (scheme, Accuracy::LocalError(local))));
    }
    // In units of the shortest time in which a contact acts.
    let unit = ratio.powf(-0.4);
    for (scheme, longest) in [
        (Scheme::VelocityVerlet, 0.2),
        (Scheme::Symplectic4, 0.6),
        (Scheme::Symplectic6, 1.0),
    ] {
        let steps = (0..5).map(|n| unit * longest * 0.5f64.powi(n));
        all.extend(steps.map(|step| (scheme, Accuracy::Step(step))));
    }
    all
}

fn run(simulation: &Simulation) -> Run {
    simulation.run(&Silent).expect("a chain that can be run")
}

/// Sorted times in ms, and the last run; `None` where the step is too long to be stable.
fn timed(simulation: &Simulation, repeats: usize) -> Option<(Vec<f64>, Run)> {
    let mut found = simulation.run(&Silent).ok()?;
    let mut times = Vec::new();
    for _ in 0..repeats {
        let start = processor_seconds();
        found = run(simulation);
        times.push((processor_seconds() - start) * 1e3);
    }
    times.sort_by(f64::total_cmp);
    Some((times, found))
}

/// Processor time of this thread where the system tells it, else the clock: other work of a shared
/// machine is not counted.
fn processor_seconds() -> f64 {
    #[cfg(target_os = "linux")]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
    }
    #[cfg(not(target_os = "linux"))]
    {
        static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
        START.get_or_init(Instant::now).elapsed().as_secs_f64()
    }
}
