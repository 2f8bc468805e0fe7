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
    /// Fraction of the impact energy in the pulse at the end of the chain.
    pub energy: f64,
    /// Speed of the pulse over the fitted distance, in cells per unit of time.
    pub speed: f64,
    /// When the front reaches the last site.
    pub arrival: f64,
    /// Contact forces computed to measure it.
    pub forces: u64,
}

impl LeakScan {
    /// The leaks at the given ratios, in their order, computed in parallel.
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
        self.each(ratios, observer, |ratio| {
            self.leak_at(ratio, self.local_error, None, observer)
        })
    }

    /// The leaks at ratios in their order, those that are large by a coarser time integration.
    pub(super) fn survey(&self, ratios: &[f64], observer: &dyn Observer) -> Result<Vec<Leak>> {
        self.each(ratios, observer, |ratio| {
            self.leak(ratio, f64::INFINITY, None, observer)
        })
    }

    fn each(
        &self,
        ratios: &[f64],
        observer: &dyn Observer,
        leak: impl Fn(f64) -> Result<Leak> + Sync,
    ) -> Result<Vec<Leak>> {
        self.check()?;
        observer.stage("chains", ratios.len() as u64);
        ratios
            .par_iter()
            .map(|&ratio| {
                let leak = leak(ratio);
                observer.advance(1);
                leak
            })
            .collect()
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
        let local_error = (TOLD_APART * size).min(COARSEST).max(self.local_error);
        let leak = self.leak_at(ratio, local_error, arrival, observer)?;
        // Also what could not be measured.
        let told = leak.per_cell > ABOVE * local_error;
        if told || local_error <= self.local_error {
            return Ok(leak);
        }
        let again = self.leak_at(ratio, self.local_error, Some(leak.arrival), observer)?;
        Ok(Leak {
            forces: leak.forces + again.forces,
            ..again
        })
    }

    fn leak_at(
        &self,
        ratio: f64,
        local_error: f64,
        arrival: Option<f64>,
        observer: &dyn Observer,
    ) -> Result<Leak> {
        observer.go_on()?;
        let is_positive = ratio > 0.0 && ratio.is_finite();
        Error::require(is_positive, "ratio", "a positive number", ratio)?;
        let chain = self.family.chain(ratio, self.cells);
        let mut simulation = Simulation::impact(chain, 1.0, 1.0, 2);
        simulation.estimate_error = false;
        simulation.record = Record::default();
        let (arrival, search) = match arrival {
            Some(time) => (time, 0),
            None => {
                let (time, cost) = simulation.arrival(&Silent)?;
                (time, cost.forces)
            }
        };
        simulation.end_time = EndTime::At(arrival);
        simulation.accuracy = Accuracy::LocalError(local_error);
        simulation.samples = SAMPLES;
        simulation.record.displacement = true;
        let run = simulation.run(&Silent)?;
        Ok(Leak {
            ratio,
            arrival,
            forces: run.report.cost.forces + search,
            ..measure(&run)
        })
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

/// The loss, energy and speed of the leading pulse.
fn measure(run: &Run) -> Leak {
    let sites = run.chain.n_sites();
    let initial = 0.5 * run.chain.mass[0];
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
        let moment: f64 = (2 * first..sites)
            .map(|j| 0.5 * j as f64 * energies[j])
            .sum();
        let centre = moment / energy;
        if centre > REACH as f64 && centre < (sites / 2 - REACH / 2) as f64 {
            points.push([centre, energy, run.time[k]]);
        }
    }
    let energy = points.last().map_or(f64::NAN, |last| last[1] / initial);
    let alone = 1
        + (points.windows(2))
            .take_while(|pair| pair[1][1] < (1.0 + GAIN) * pair[0][1])
            .count();
    points.truncate(alone);
    let end = points.last().map_or(0.0, |last| last[0]);
    points.retain(|point| point[0] > 0.5 * end);
    let line = |value: fn(&[f64; 3]) -> f64| {
        let points: Vec<(f64, f64)> = points.iter().map(|p| (p[0], value(p))).collect();
        let line = LineFit::through(&points).filter(|_| points.len() > 3);
        line.map_or(f64::NAN, |line| line.slope)
    };
    Leak {
        ratio: f64::NAN,
        per_cell: -line(|p| p[1].ln()).exp_m1(),
        energy,
        speed: 1.0 / line(|p| p[2]),
        arrival: f64::NAN,
        forces: 0,
    }
}

/// Indices of the local minima of leaks that are ordered by ratio.
pub fn minima(leaks: &[Leak]) -> Vec<usize> {
    let least = |w: &[Leak]| w[1].per_cell < w[0].per_cell && w[1].per_cell <= w[2].per_cell;
    let inner = leaks.windows(3).enumerate();
    inner
        .filter(|(_, w)| least(w))
        .map(|(i, _)| i + 1)
        .collect()
}
