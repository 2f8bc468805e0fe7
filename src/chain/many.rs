//! Many chains at once, on all cores.

use std::sync::Mutex;

use rayon::prelude::*;

use super::recorder::{Recorder, SampleTimes};
use super::result::Run;
use super::simulation::{Accuracy, EndTime, Simulation};
use super::stepping::{self, Cost, Scheme, StepControl};
use crate::numeric::lanes::WIDTH;
use crate::observer::{CancelOnly, Observer};
use crate::{Error, Result};

/// How many runs of a simulation's kind [`run_each`] holds on each thread.
pub(crate) fn runs_a_thread(simulation: &Simulation) -> usize {
    Alike::of(simulation).map_or(1, |_| WIDTH)
}

/// Below this number of chains alike, stepping them one by one is as fast.
const LEAST_TOGETHER: usize = WIDTH / 2 + 1;

/// Runs simulations on the threads of the current pool and passes on each result when it is
/// finished, with its index in `simulations`, in any order.
///
/// The bits of a result depend neither on the number of threads nor on the other simulations.
/// Chains of fixed steps that differ in masses, coefficients and initial states alone are stepped
/// eight at a time, unless their energies are recorded. No result is stored: a caller that needs
/// only a summary of each run holds at most eight runs per thread. The observer gets one stage with
/// one unit per simulation. After cancellation the remaining simulations yield
/// [`Error::Cancelled`].
pub fn run_each(
    simulations: &[Simulation],
    observer: &dyn Observer,
    sink: &(dyn Fn(usize, Result<Run>) + Sync),
) {
    observer.stage("chains", simulations.len() as u64);
    batches(simulations).into_par_iter().for_each(|batch| {
        if let Some(results) = together(simulations, &batch, observer) {
            for (&i, result) in batch.iter().zip(results) {
                observer.advance(1);
                sink(i, result);
            }
            return;
        }
        for i in batch {
            let run = || simulations[i].run(&CancelOnly(observer));
            let result = observer.go_on().and_then(|()| run());
            observer.advance(1);
            sink(i, result);
        }
    });
}

/// The same, with all results in the order of `simulations`.
pub fn run_many(simulations: &[Simulation], observer: &dyn Observer) -> Vec<Result<Run>> {
    let slots: Vec<Mutex<Option<Result<Run>>>> =
        simulations.iter().map(|_| Mutex::new(None)).collect();
    run_each(simulations, observer, &|i, result| {
        if let Ok(mut slot) = slots[i].lock() {
            *slot = Some(result);
        }
    });
    slots
        .into_iter()
        .map(|slot| {
            let result = slot.into_inner().unwrap_or_else(|lost| lost.into_inner());
            result.unwrap_or(Err(Error::Cancelled))
        })
        .collect()
}

/// What chains stepped together must share.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Alike {
    sites: usize,
    scheme: Scheme,
    step: f64,
    end: f64,
    samples: usize,
}

impl Alike {
    fn of(simulation: &Simulation) -> Option<Alike> {
        match (simulation.accuracy, simulation.end_time) {
            (Accuracy::Step(step), EndTime::At(end)) => Some(Alike {
                sites: simulation.chain.n_sites(),
                scheme: simulation.scheme,
                step,
                end,
                samples: simulation.samples,
            }),
            _ => None,
        }
    }
}

/// Batches of up to eight similar simulations, in order; the others are alone.
fn batches(simulations: &[Simulation]) -> Vec<Vec<usize>> {
    let mut batches: Vec<Vec<usize>> = Vec::new();
    // The last batch of each kind that is not full.
    let mut open: Vec<(Alike, usize)> = Vec::new();
    for (i, simulation) in simulations.iter().enumerate() {
        let Some(alike) = Alike::of(simulation) else {
            batches.push(vec![i]);
            continue;
        };
        match open.iter_mut().find(|(other, _)| *other == alike) {
            Some((_, batch)) if batches[*batch].len() < WIDTH => batches[*batch].push(i),
            Some((_, batch)) => {
                *batch = batches.len();
                batches.push(vec![i]);
            }
            None => {
                open.push((alike, batches.len()));
                batches.push(vec![i]);
            }
        }
    }
    batches
}

/// `None` where the batch must be, or is better, run one by one.
fn together(
    simulations: &[Simulation],
    batch: &[usize],
    observer: &dyn Observer,
) -> Option<Vec<Result<Run>>> {
    if batch.len() < LEAST_TOGETHER {
        return None;
    }
    let batch: Vec<&Simulation> = batch.iter().map(|&i| &simulations[i]).collect();
    if batch.iter().any(|simulation| simulation.check().is_err()) {
        return None;
    }
    let Alike {
        step, end, samples, ..
    } = Alike::of(batch[0])?;
    let control = StepControl::Fixed(step);
    let scales: Vec<f64> = batch.iter().map(|s| s.velocity_scale(end)).collect();
    let tasks: Vec<_> = batch
        .iter()
        .zip(&scales)
        .map(|(simulation, &scale)| simulation.task(control, scale, simulation.record.energy))
        .collect();
    let (mut stepping, mut state) = stepping::prepare_together(&tasks)?;
    let samples = SampleTimes::all(end, samples);
    let mut recorders: Vec<Recorder> = batch
        .iter()
        .zip(&scales)
        .map(|(simulation, &scale)| Recorder::new(simulation, simulation.record, scale, samples))
        .collect();
    for sample in 0..samples.number() {
        if observer.cancelled() {
            return Some(batch.iter().map(|_| Err(Error::Cancelled)).collect());
        }
        stepping.advance_to(samples.time(sample));
        for (lane, recorder) in recorders.iter_mut().enumerate() {
            stepping.read(lane, &mut state);
            recorder.keep(sample, &state);
        }
    }
    let cost: Cost = stepping.cost();
    let finished = recorders.into_iter().zip(batch).map(|(recorder, alone)| {
        match recorder.finish(control, cost) {
            Ok(mut run) if run.velocity.iter().all(|v| v.is_finite()) => {
                alone.check_energy(&mut run).map(|()| run)
            }
            // Only a run by itself finds the time of the overflow.
            _ => alone.run(&CancelOnly(observer)),
        }
    });
    Some(finished.collect())
}
