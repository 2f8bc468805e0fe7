//! Many chains at once, on all cores.

use std::sync::Mutex;

use rayon::prelude::*;

use super::run::{Run, Simulation};
use crate::analyze::Observer;
use crate::{Error, Result};

/// Runs simulations on the threads of the current pool and hands each result on as it is done,
/// with its place in `simulations`, in any order.
///
/// The bits of a result do not depend on the number of threads nor on what else is run.
/// Nothing is kept: a caller that wants a summary of each run holds no more than one run a thread.
/// The observer sees one stage, a unit for each simulation; once it asks to stop, the simulations
/// left yield [`Error::Cancelled`].
pub fn run_each(
    simulations: &[Simulation],
    observer: &dyn Observer,
    sink: &(dyn Fn(usize, Result<Run>) + Sync),
) {
    observer.stage("chains", simulations.len() as u64);
    simulations
        .par_iter()
        .enumerate()
        .for_each(|(i, simulation)| {
            let result = if observer.cancelled() {
                Err(Error::Cancelled)
            } else {
                simulation.run(&Quiet(observer))
            };
            observer.advance(1);
            sink(i, result);
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

/// Passes on only the question whether to stop.
struct Quiet<'a>(&'a dyn Observer);

impl Observer for Quiet<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}
