//! Energy loss per cell of the leading pulse in a struck dimer, measured on simulated chains.

use rayon::prelude::*;

use super::family::Family;
use crate::chain::{Accuracy, EndTime, Record, Run, Simulation};
use crate::numeric::LineFit;
use crate::observer::{Observer, Silent};
use crate::{Error, Result};

/// Struck chains, one per ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeakScan {
    pub family: Family,
    pub cells: usize,
    /// Local error of the time integration, relative to the speed of the striker.
    pub local_error: f64,
}

/// Energy loss of one chain's leading pulse.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Leak {
    /// kappa or mu.
    pub ratio: f64,
    /// Relative decrease of the pulse's energy per cell; NaN if not measurable.
    pub per_cell: f64,
    /// When the front reaches the last site.
    pub arrival: f64,
    /// Contact forces computed to measure it.
    pub forces: u64,
}

impl LeakScan {
    /// The leaks at the given ratios, in their order, computed in parallel; those that are large by a coarser time
    /// integration.
    ///
    /// The leading pulse comprises [`REACH`] cells behind its peak and everything in front. Its
    /// energy is fitted by an exponential of the distance over the second half of its path. Where
    /// the leak is large, trailing waves catch up with the pulse, which then gains energy; its path
    /// ends before that. A leak below about 1e-15 is rounding.
    ///
    /// # Errors
    /// [`Error::Request`] for chains too short to isolate a pulse, or too long, and for ratios that
    /// are not positive; those of [`Simulation::run`].
    pub fn run(&self, ratios: &[f64], observer: &dyn Observer) -> Result<Vec<Leak>> {
        self.check()?;
        observer.stage("chains", ratios.len() as u64);
        let leaks = ratios.par_iter().map(|&ratio| {
            let leak = self.leak(ratio, f64::INFINITY, None, observer);
            observer.advance(1);
            leak
        });
        leaks.collect()
    }

    pub(super) fn check(&self) -> Result<()> {
        let range = 5 * REACH..=MOST_CELLS;
        let expected = format!("{} to {MOST_CELLS} cells", range.start());
        Error::require(range.contains(&self.cells), "cells", expected, self.cells)
    }

    /// The leak of one chain, at a time integration as coarse as tells leaks of this size apart.
    ///
    /// Without a time at which the front arrives, that is found by a run of its own.
    pub(super) fn leak(
        &self,
        ratio: f64,
        size: f64,
        arrival: Option<f64>,
        observer: &dyn Observer,
    ) -> Result<Leak> {
        let is_positive = ratio > 0.0 && ratio.is_finite();
        Error::require(is_positive, "ratio", "a positive number", ratio)?;
        let chain = self.family.chain(ratio, self.cells);
        let mut simulation = Simulation {
            estimate_error: false,
            record: Record::default(),
            ..Simulation::impact(chain, 1.0, 1.0, SAMPLES)
        };
        observer.go_on()?;
        let (arrival, mut forces) = match arrival {
            Some(time) => (time, 0),
            None => {
                let (time, cost) = simulation.arrival(&Silent)?;
                (time, cost.forces)
            }
        };
        simulation.end_time = EndTime::At(arrival);
        simulation.record.displacement = true;
        let mut local_error = (TOLD_APART * size).min(COARSEST).max(self.local_error);
        loop {
            observer.go_on()?;
            simulation.accuracy = Accuracy::LocalError(local_error);
            let run = simulation.run(&Silent)?;
            forces += run.report.cost.forces;
            let per_cell = lost_per_cell(&run);
            // A leak that could not be measured is measured anew, too.
            if per_cell > ABOVE * local_error || local_error <= self.local_error {
                return Ok(Leak {
                    ratio,
                    per_cell,
                    arrival,
                    forces,
                });
            }
            local_error = self.local_error;
        }
    }
}

/// Cells behind the peak that belong to the leading pulse.
pub const REACH: usize = 6;
/// Largest number of cells of a chain; such a run takes hours.
const MOST_CELLS: usize = 100_000;
const SAMPLES: usize = 81;
/// Coarsest local error of a time integration that measures a leak.
const COARSEST: f64 = 1e-8;
/// The local error by which leaks of about one size are told apart, over that size: a leak is off by about
/// a thousandth of the local error.
const TOLD_APART: f64 = 1e-3;
/// A leak is measured anew, more finely, unless it is this many times the local error.
const ABOVE: f64 = 100.0;
/// A peak above this fraction of the largest cell energy is a pulse.
const FOREMOST: f64 = 1e-3;
/// Relative gain of energy between samples that indicates waves catching up.
const GAIN: f64 = 1e-3;

/// Relative decrease of the leading pulse's energy per cell; NaN if not measurable.
fn lost_per_cell(run: &Run) -> f64 {
    let sites = run.chain.n_sites();
    let mut energies = vec![0.0; sites];
    let mut points = Vec::new();
    let displacement = run.displacement.iter().flat_map(|rows| rows.rows());
    for (k, x) in displacement.enumerate().skip(1) {
        let (x, v) = (x.to_vec(), run.velocity.row(k).to_vec());
        run.chain.site_energies(&x, &v, 0.0, &mut energies);
        let cell = |c: usize| energies[2 * c] + energies[2 * c + 1];
        let largest = (0..sites / 2).map(cell).fold(0.0, f64::max);
        // The leading pulse; after large losses it is not the largest one.
        let front = (1..sites / 2).rev();
        let peak = front
            .filter(|&c| cell(c) > FOREMOST * largest)
            .find(|&c| cell(c) >= cell(c - 1));
        let Some(peak) = peak else { continue };
        let first = peak.saturating_sub(REACH);
        let energy: f64 = energies[2 * first..].iter().sum();
        let moments = (2 * first..sites).map(|j| 0.5 * j as f64 * energies[j]);
        let centre = moments.sum::<f64>() / energy;
        if centre > REACH as f64 && centre < (sites / 2 - REACH / 2) as f64 {
            points.push((centre, energy.ln()));
        }
    }
    let gain = GAIN.ln_1p();
    let mut pairs = points.windows(2);
    let rises = pairs.position(|pair| pair[1].1 >= pair[0].1 + gain);
    points.truncate(rises.map_or(points.len(), |last| last + 1));
    let end = points.last().map_or(0.0, |last| last.0);
    points.retain(|point| point.0 > 0.5 * end);
    let line = LineFit::through(&points).filter(|_| points.len() > 3);
    line.map_or(f64::NAN, |line| -line.slope.exp_m1())
}

/// Indices of the local minima of leaks that are ordered by ratio.
pub fn minima(leaks: &[Leak]) -> Vec<usize> {
    let size = |i: usize| leaks[i].per_cell;
    let is_least = |i: &usize| size(*i) < size(i - 1) && size(*i) <= size(i + 1);
    (1..leaks.len().max(2) - 1).filter(is_least).collect()
}
