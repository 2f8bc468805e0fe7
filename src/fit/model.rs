//! What a chain with given values of the free keys would have measured.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::cause::Held;
use super::key::{FreeKey, settings};
use super::local_error;
use super::records::Records;
use super::solver::{Minimum, Problem, square};
use crate::Result;
use crate::chain::Simulation;
use crate::chain::scene::{SceneSource, Setting};
use crate::field::Quantity;
use crate::observer::{CancelOnly, Observer};

/// Change of the records, over their size, that differences of runs aim at: its square and the error of runs over it
/// are then both near 1e-6.
const CHANGE: f64 = 1e-3;

/// Shortest and longest step of a coordinate, and the first one.
const STEPS: [f64; 2] = [1e-7, 1e-2];
const FIRST_STEP: f64 = 1e-3;

/// Errors of records, over their size, that are left of runs, over their local error.
const ROUNDING: f64 = 30.0;

/// An unknown that is no key of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Other {
    /// How late the records are, in steps of their samples.
    Clock,
    /// The logarithm of the gain of a site's record.
    Gain(usize),
    /// The same of all records.
    Gains,
    /// A number that the scene holds.
    Held(Held),
}

/// Records of a chain as a function of coordinates: those of the keys, and those of the other unknowns.
#[derive(Clone, Copy)]
pub(super) struct Model<'a> {
    pub scene: &'a SceneSource,
    pub keys: &'a [FreeKey],
    pub others: &'a [Other],
    pub records: &'a Records,
    /// What a standard error of a gain adds to the residual, for each unit of its coordinate; 0 for none.
    pub gain_weight: f64,
    pub local_error: f64,
    pub observer: &'a dyn Observer,
    /// How many there were.
    pub runs: &'a AtomicU64,
}

impl<'a> Model<'a> {
    /// # Errors
    /// [`crate::Error::Scene`]; [`crate::Error::Request`] for records that are not of its chain.
    pub fn of(
        scene: &'a SceneSource,
        (keys, others): (&'a [FreeKey], &'a [Other]),
        records: &'a Records,
        (observer, runs): (&'a dyn Observer, &'a AtomicU64),
    ) -> Result<Model<'a>> {
        let setup = scene.setup().map_err(|error| scene.locate(error))?;
        records.check(&setup)?;
        Ok(Model {
            local_error: local_error(&setup.simulation, records)?,
            scene,
            keys,
            others,
            records,
            gain_weight: 0.0,
            observer,
            runs,
        })
    }

    pub fn unknowns(&self) -> usize {
        self.keys.len() + self.others.len()
    }

    /// The unknowns that are no keys, with their coordinates.
    fn others(&self, at: &[f64]) -> impl Iterator<Item = (Other, f64)> {
        let own = at[self.keys.len()..].to_vec();
        self.others.iter().copied().zip(own)
    }

    /// What the coordinates make of the scene.
    pub fn simulation(&self, at: &[f64]) -> Result<Simulation> {
        let mut simulation = self.scene.with(self.settings(at)).setup()?.simulation;
        for (other, u) in self.others(at) {
            if let Other::Held(held) = other {
                held.set(&mut simulation, u);
            }
        }
        Ok(simulation)
    }

    pub fn settings(&self, at: &[f64]) -> Vec<Setting> {
        let keys = self.keys.iter().zip(at);
        settings(self.keys, keys.map(|(key, u)| key.value_at(*u)))
    }

    /// The records, without gains, one site after the other, by steps as [`Simulation::sampled`] takes them.
    pub fn records_at(&self, at: &[f64], steps: (f64, bool)) -> Result<Vec<f64>> {
        let simulation = self.simulation(at)?;
        let clocks = self.others(at).filter(|(other, _)| *other == Other::Clock);
        let shift = clocks.map(|(_, u)| u).sum::<f64>() * self.records.step();
        self.runs.fetch_add(1, Ordering::Relaxed);
        let times: Vec<f64> = self.records.times.iter().map(|t| t - shift).collect();
        let watch = CancelOnly(self.observer);
        simulated(&simulation, self.records, &times, steps, &watch)
    }

    fn with_gains(&self, at: &[f64], mut records: Vec<f64>) -> Vec<f64> {
        let n = self.records.times.len();
        for (other, u) in self.others(at) {
            let own = match other {
                Other::Gain(site) => n * site..n * (site + 1),
                Other::Gains => 0..records.len(),
                Other::Clock | Other::Held(_) => continue,
            };
            records[own].iter_mut().for_each(|value| *value *= u.exp());
        }
        records
    }

    /// The records as they are measured.
    pub fn predicted(&self, at: &[f64]) -> Result<Vec<f64>> {
        Ok(self.with_gains(at, self.records_at(at, (self.local_error, false))?))
    }

    /// What is measured beyond what is predicted, 0 where it is missing; behind it what gains miss of 1.
    fn beyond(&self, at: &[f64], predicted: &[f64]) -> Vec<f64> {
        let pairs = self.records.values.iter().zip(predicted);
        let mut residual = self.records.masked(pairs.map(|(y, p)| y - p));
        if self.gain_weight > 0.0 {
            let gains = self.others(at);
            let gains = gains.filter(|(other, _)| matches!(other, Other::Gain(_)));
            residual.extend(gains.map(|(_, u)| -self.gain_weight * u));
        }
        residual
    }

    /// A minimum where one is known to be, by steps of no search, and the records there.
    pub fn minimum(&self, at: &[f64]) -> Result<(Minimum, Vec<f64>)> {
        let predicted = self.predicted(at)?;
        let residual = self.beyond(at, &predicted);
        let minimum = Minimum {
            at: at.to_vec(),
            squares: square(&residual),
            residual,
            columns: self.columns(at, &mut Vec::new())?,
            is_settled: true,
        };
        Ok((minimum, predicted))
    }

    /// The change of the records along a coordinate, by the central difference of two runs.
    fn along(&self, at: &[f64], k: usize, step: f64) -> Result<Vec<f64>> {
        let [low, high] = self.bounds()[k];
        let ends = [(at[k] - step).max(low), (at[k] + step).min(high)];
        let run = |u: f64| {
            let mut at = at.to_vec();
            at[k] = u;
            self.records_at(&at, (self.local_error, false))
        };
        let (below, above) = rayon::join(|| run(ends[0]), || run(ends[1]));
        let (below, above, length) = (below?, above?, ends[1] - ends[0]);
        let pairs = above.iter().zip(&below);
        Ok(pairs.map(|(a, b)| (a - b) / length).collect())
    }

    /// The same by runs whose step makes the records change by [`CHANGE`], and that step; `step` is tried first.
    fn well_along(&self, at: &[f64], k: usize, step: f64) -> Result<(Vec<f64>, f64)> {
        let column = self.along(at, k, step)?;
        let steepest = rms(&column).max(f64::MIN_POSITIVE);
        let better = (CHANGE * self.records.size() / steepest).clamp(STEPS[0], STEPS[1]);
        match better > 10.0 * step || better < 0.1 * step {
            true => Ok((self.along(at, k, better)?, better)),
            false => Ok((column, step)),
        }
    }

    /// The sites whose gain a coordinate is.
    fn gain(&self, k: usize) -> Option<Range<usize>> {
        match self.others.get(k.checked_sub(self.keys.len())?) {
            Some(Other::Gain(site)) => Some(*site..site + 1),
            Some(Other::Gains) => Some(0..self.records.bodies.len()),
            _ => None,
        }
    }

    /// The derivative of the records along a coordinate.
    pub fn column(&self, at: &[f64], k: usize) -> Result<Vec<f64>> {
        match self.gain(k) {
            Some(sites) => Ok(self.along_gain(sites, &self.predicted(at)?)),
            None => Ok(self.masked(self.with_gains(at, self.along(at, k, FIRST_STEP)?))),
        }
    }

    fn along_gain(&self, sites: Range<usize>, predicted: &[f64]) -> Vec<f64> {
        let n = self.records.times.len();
        let own = n * sites.start..n * sites.end;
        let samples = predicted.iter().enumerate();
        let samples = samples.map(|(i, v)| if own.contains(&i) { *v } else { 0.0 });
        let mut column = self.masked(samples);
        for site in sites {
            if let Some(miss) = column.get_mut(predicted.len() + site) {
                *miss = self.gain_weight;
            }
        }
        column
    }

    /// A column where samples are known, and behind it what it adds to the misses of gains, nothing.
    fn masked(&self, column: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut column = self.records.masked(column);
        if self.gain_weight > 0.0 {
            column.resize(column.len() + self.records.bodies.len(), 0.0);
        }
        column
    }
}

impl Problem for Model<'_> {
    fn bounds(&self) -> Vec<[f64; 2]> {
        let others = self.others.iter().map(|other| match other {
            Other::Held(held) => held.bounds(),
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        });
        let keys = self.keys.iter().map(FreeKey::coordinates);
        keys.chain(others).collect()
    }

    fn floor(&self) -> f64 {
        let error = ROUNDING * self.local_error * self.records.size();
        error * error * self.records.known() as f64
    }

    fn residual(&self, at: &[f64]) -> Result<Vec<f64>> {
        Ok(self.beyond(at, &self.predicted(at)?))
    }

    /// Columns of minus the derivatives of the residual. `steps` are those of differences, and become better ones.
    fn columns(&self, at: &[f64], steps: &mut Vec<f64>) -> Result<Vec<Vec<f64>>> {
        steps.resize(self.unknowns(), FIRST_STEP);
        let of_gains = (0..self.unknowns()).any(|k| self.gain(k).is_some());
        let predicted = of_gains.then(|| self.predicted(at)).transpose()?;
        let column = |k: usize| match (self.gain(k), &predicted) {
            (Some(sites), Some(predicted)) => Ok((self.along_gain(sites, predicted), steps[k])),
            _ => {
                let (column, step) = self.well_along(at, k, steps[k])?;
                Ok((self.masked(self.with_gains(at, column)), step))
            }
        };
        let found: Vec<Result<(Vec<f64>, f64)>> =
            (0..self.unknowns()).into_par_iter().map(column).collect();
        let found: Result<Vec<(Vec<f64>, f64)>> = found.into_iter().collect();
        let (columns, better) = found?.into_iter().unzip();
        *steps = better;
        Ok(columns)
    }
}

pub(super) fn rms(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|v| v * v).sum();
    (squares / values.len().max(1) as f64).sqrt()
}

/// A quantity of a run at its bodies, at rising times; before 0 bodies fly as they start.
pub(super) fn simulated(
    simulation: &Simulation,
    records: &Records,
    times: &[f64],
    steps: (f64, bool),
    observer: &dyn Observer,
) -> Result<Vec<f64>> {
    let (n, sites) = (times.len(), records.bodies.len());
    let chain = &simulation.chain;
    let before = times.iter().filter(|t| **t < 0.0).count();
    let mut values = vec![0.0; n * sites];
    for (site, &body) in records.bodies.iter().enumerate() {
        let (x, v) = (&simulation.displacement, &simulation.velocity);
        for i in 0..before {
            values[n * site + i] = match records.quantity {
                Quantity::Displacement => x[body] + times[i] * v[body],
                Quantity::Velocity => v[body],
                Quantity::Force => chain.force(body, x, v),
                _ => 0.0,
            };
        }
    }
    let mut index = before;
    simulation.sampled(
        &times[before..],
        steps,
        observer,
        &mut |at, acceleration| {
            for (site, &body) in records.bodies.iter().enumerate() {
                values[n * site + index] = match records.quantity {
                    Quantity::Displacement => at.x[body],
                    Quantity::Force => chain.force(body, at.x, at.v),
                    Quantity::Acceleration => acceleration(body),
                    _ => at.v[body],
                };
            }
            index += 1;
        },
    )?;
    observer.go_on()?;
    Ok(values)
}
