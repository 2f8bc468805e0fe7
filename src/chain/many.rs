//! Many chains at once, on all cores.

use rayon::prelude::*;

use super::result::Run;
use super::simulation::Simulation;
use crate::Result;
use crate::observer::{CancelOnly, Observer};

/// Runs simulations on the threads of the current pool and passes on each result when it is
/// finished, with its index in `simulations`, in any order.
///
/// The bits of a result depend neither on the number of threads nor on the other simulations. No
/// result is stored: a caller that needs only a summary of each run holds at most one run per
/// thread. The observer gets one stage with one unit per simulation. After cancellation the
/// remaining simulations yield [`crate::Error::Cancelled`].
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
            let run = || simulation.run(&CancelOnly(observer));
            let result = observer.go_on().and_then(|()| run());
            observer.advance(1);
            sink(i, result);
        });
}
