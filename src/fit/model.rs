//! What a chain with given values of the free keys would have measured.

use rayon::prelude::*;

use super::cause::Extra;
use super::key::{FreeKey, settings};
use super::local_error;
use super::records::Records;
use super::solver::Problem;
use crate::chain::Simulation;
use crate::chain::scene::{SceneSource, Setting};
use crate::field::Quantity;
use crate::observer::{CancelOnly, Observer};
use crate::{Error, Result};

/// Change of the records, over their size, that differences of runs aim at: its square and the error of runs over it
/// are then both near 1e-6.
const CHANGE: f64 = 1e-3;

/// Shortest and longest step of a coordinate, and the first one.
const STEPS: [f64; 2] = [1e-7, 1e-2];
const FIRST_STEP: f64 = 1e-3;

/// Errors of records, over their size, that are left of runs, over their local error.
const ROUNDING: f64 = 30.0;

/// Distance of the samples from which an acceleration is made, over the contact time.
const ASIDE: f64 = 0.01;

/// What is measured beside the keys.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Nuisances {
    pub shift: bool,
    pub gains: bool,
    /// What a standard error of a gain adds to the residual, for each unit of its coordinate; 0 for none.
    pub gain_weight: f64,
}

/// Records of a chain as a function of coordinates: those of the keys, of the time shift in steps of the samples, of one
/// number more, and logarithms of gains.
#[derive(Clone, Copy)]
pub(super) struct Model<'a> {
    pub scene: &'a SceneSource,
    pub keys: &'a [FreeKey],
    pub records: &'a Records,
    pub nuisances: Nuisances,
    pub extra: Option<Extra>,
    pub local_error: f64,
    pub observer: &'a dyn Observer,
}

impl<'a> Model<'a> {
    /// # Errors
    /// [`Error::Scene`]; [`Error::Request`] for records that are not of its chain.
    pub fn of(
        scene: &'a SceneSource,
        keys: &'a [FreeKey],
        records: &'a Records,
        nuisances: Nuisances,
        observer: &'a dyn Observer,
    ) -> Result<Model<'a>> {
        let setup = scene.setup().map_err(|error| scene.locate(error))?;
        records.check(&setup)?;
        Ok(Model {
            local_error: local_error(&setup.simulation, records)?,
            scene,
            keys,
            records,
            nuisances,
            extra: None,
            observer,
        })
    }
}

impl Model<'_> {
    /// Number of coordinates that need runs.
    pub fn moved(&self) -> usize {
        self.keys.len() + usize::from(self.nuisances.shift) + usize::from(self.extra.is_some())
    }

    pub fn unknowns(&self) -> usize {
        let gains = if self.nuisances.gains {
            self.records.bodies.len()
        } else {
            0
        };
        self.moved() + gains
    }

    /// What the coordinates make of the scene.
    pub fn simulation(&self, at: &[f64]) -> Result<Simulation> {
        let mut simulation = self.scene.with(self.settings(at)).setup()?.simulation;
        if let Some(extra) = self.extra {
            extra.set(&mut simulation, at[self.moved() - 1]);
        }
        Ok(simulation)
    }

    pub fn settings(&self, at: &[f64]) -> Vec<Setting> {
        settings(
            self.keys,
            self.keys.iter().zip(at).map(|(key, u)| key.value_at(*u)),
        )
    }

    /// The records, without gains, one site after the other.
    pub fn records_at(&self, at: &[f64], local_error: f64) -> Result<Vec<f64>> {
        let simulation = self.simulation(at)?;
        let mut shift = match self.nuisances.shift {
            true => at[self.keys.len()] * self.records.step(),
            false => 0.0,
        };
        if let Some(extra) = self.extra {
            shift += extra.shift(at[self.moved() - 1]);
        }
        self.observer.stage("run", 1);
        let times: Vec<f64> = self.records.times.iter().map(|t| t - shift).collect();
        let watch = CancelOnly(self.observer);
        let mut records = simulated(&simulation, self.records, &times, local_error, &watch)?;
        if let Some(extra) = self.extra {
            extra.scale(&mut records, times.len(), at[self.moved() - 1]);
        }
        Ok(records)
    }

    pub fn gain(&self, at: &[f64], site: usize) -> f64 {
        match self.nuisances.gains {
            true => at[self.moved() + site].exp(),
            false => 1.0,
        }
    }

    fn with_gains(&self, at: &[f64], mut records: Vec<f64>) -> Vec<f64> {
        let n = self.records.times.len();
        for (site, record) in records.chunks_exact_mut(n).enumerate() {
            let gain = self.gain(at, site);
            record.iter_mut().for_each(|value| *value *= gain);
        }
        records
    }

    /// The records as they are measured.
    pub fn predicted(&self, at: &[f64]) -> Result<Vec<f64>> {
        Ok(self.with_gains(at, self.records_at(at, self.local_error)?))
    }

    /// The change of the records along a coordinate, by the central difference of two runs whose step makes them change
    /// by [`CHANGE`], and that step.
    fn along(&self, at: &[f64], k: usize, step: f64) -> Result<Vec<f64>> {
        let [low, high] = self.bounds()[k];
        let ends = [(at[k] - step).max(low), (at[k] + step).min(high)];
        let run = |u: f64| {
            let mut at = at.to_vec();
            at[k] = u;
            self.records_at(&at, self.local_error)
        };
        let (below, above) = rayon::join(|| run(ends[0]), || run(ends[1]));
        let (below, above, length) = (below?, above?, ends[1] - ends[0]);
        Ok(above
            .iter()
            .zip(&below)
            .map(|(a, b)| (a - b) / length)
            .collect())
    }
}

impl Problem for Model<'_> {
    fn bounds(&self) -> Vec<[f64; 2]> {
        let mut all: Vec<[f64; 2]> = self.keys.iter().map(FreeKey::coordinates).collect();
        all.resize(self.unknowns(), [f64::NEG_INFINITY, f64::INFINITY]);
        if let Some(extra) = self.extra {
            all[self.moved() - 1] = extra.bounds();
        }
        all
    }

    fn floor(&self) -> f64 {
        let error = ROUNDING * self.local_error * self.records.size();
        error * error * self.records.known() as f64
    }

    /// What is measured beyond what is predicted, 0 where it is missing; behind it what gains miss of 1.
    fn residual(&self, at: &[f64]) -> Result<Vec<f64>> {
        let predicted = self.predicted(at)?;
        let pairs = self.records.values.iter().zip(&predicted);
        let mut residual = self.records.masked(pairs.map(|(y, p)| y - p));
        if self.nuisances.gains && self.nuisances.gain_weight > 0.0 {
            let gains = &at[self.moved()..];
            residual.extend(gains.iter().map(|u| -self.nuisances.gain_weight * u));
        }
        Ok(residual)
    }

    /// Columns of minus the derivatives of the residual. `steps` are those of differences, and become better ones.
    fn columns(&self, at: &[f64], steps: &mut Vec<f64>) -> Result<Vec<Vec<f64>>> {
        steps.resize(self.moved(), FIRST_STEP);
        let size = self.records.size();
        let found: Vec<Result<(Vec<f64>, f64)>> = (0..self.moved())
            .into_par_iter()
            .map(|k| {
                let mut step = steps[k];
                let mut column = self.along(at, k, step)?;
                let better = |column: &[f64]| {
                    let steepest = rms(column);
                    (CHANGE * size / steepest.max(f64::MIN_POSITIVE)).clamp(STEPS[0], STEPS[1])
                };
                let wanted = better(&column);
                if wanted > 10.0 * step || wanted < 0.1 * step {
                    step = wanted;
                    column = self.along(at, k, step)?;
                }
                Ok((self.with_gains(at, column), step))
            })
            .collect();
        let found: Result<Vec<(Vec<f64>, f64)>> = found.into_iter().collect();
        let (mut columns, better): (Vec<Vec<f64>>, Vec<f64>) = found?.into_iter().unzip();
        *steps = better;
        self.mask(&mut columns);
        if self.nuisances.gains {
            columns.extend(self.gain_columns(at)?);
        }
        Ok(columns)
    }
}

impl Model<'_> {
    /// The derivative of the records along one coordinate.
    pub fn column(&self, at: &[f64], k: usize) -> Result<Vec<f64>> {
        Ok(self.with_gains(at, self.along(at, k, FIRST_STEP)?))
    }

    /// Nothing is known of missing samples.
    fn mask(&self, columns: &mut [Vec<f64>]) {
        let extra = if self.nuisances.gain_weight > 0.0 && self.nuisances.gains {
            self.records.bodies.len()
        } else {
            0
        };
        for column in columns {
            *column = self.records.masked(column.drain(..));
            column.resize(self.records.values.len() + extra, 0.0);
        }
    }

    fn gain_columns(&self, at: &[f64]) -> Result<Vec<Vec<f64>>> {
        let predicted = self.predicted(at)?;
        let (n, sites) = (self.records.times.len(), self.records.bodies.len());
        let mut columns: Vec<Vec<f64>> = (0..sites)
            .map(|site| {
                let mut column = vec![0.0; n * sites];
                column[n * site..n * (site + 1)]
                    .copy_from_slice(&predicted[n * site..n * (site + 1)]);
                column
            })
            .collect();
        self.mask(&mut columns);
        if self.nuisances.gain_weight > 0.0 {
            for (site, column) in columns.iter_mut().enumerate() {
                column[n * sites + site] = self.nuisances.gain_weight;
            }
        }
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
    local_error: f64,
    observer: &dyn Observer,
) -> Result<Vec<f64>> {
    let (n, sites) = (times.len(), records.bodies.len());
    let chain = &simulation.chain;
    let aside = match records.quantity {
        Quantity::Acceleration => ASIDE * simulation.contact_time(simulation.speed()),
        _ => 0.0,
    };
    let before = times.iter().filter(|t| **t - 2.0 * aside < 0.0).count();
    let mut values = vec![0.0; n * sites];
    for (site, &body) in records.bodies.iter().enumerate() {
        let force = || chain.force(body, &simulation.displacement, &simulation.velocity);
        for i in 0..before {
            values[n * site + i] = match records.quantity {
                Quantity::Displacement => {
                    simulation.displacement[body] + times[i] * simulation.velocity[body]
                }
                Quantity::Velocity => simulation.velocity[body],
                Quantity::Force => force(),
                _ => 0.0,
            };
        }
    }
    let wanted: Vec<f64> = match aside > 0.0 {
        true => times[before..]
            .iter()
            .flat_map(|t| ASIDES.map(|(d, _)| t + d * aside))
            .collect(),
        false => times[before..].to_vec(),
    };
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|a, b| wanted[*a].total_cmp(&wanted[*b]));
    let rising: Vec<f64> = order.iter().map(|i| wanted[*i]).collect();
    let contacts: Vec<usize> = (0..chain.n_contacts()).collect();
    let mut at = 0;
    let mut row = |x: &[f64], v: &[f64]| {
        let index = order[at];
        at += 1;
        for (site, &body) in records.bodies.iter().enumerate() {
            let place = |i: usize| n * site + before + i;
            match records.quantity {
                Quantity::Velocity | Quantity::StrainRate => values[place(index)] = v[body],
                Quantity::Displacement => values[place(index)] = x[body],
                Quantity::Force => values[place(index)] = chain.force(body, x, v),
                Quantity::Acceleration => {
                    let weight = ASIDES[index % ASIDES.len()].1 / aside;
                    values[place(index / ASIDES.len())] += weight * v[body];
                }
            }
        }
    };
    if !rising.is_empty() {
        simulation.sampled(
            &rising,
            &contacts,
            local_error,
            observer,
            &mut |place, _| row(place.x, place.v),
        )?;
    }
    if observer.cancelled() {
        return Err(Error::Cancelled);
    }
    Ok(values)
}

/// Distances and weights of the derivative of fourth order.
const ASIDES: [(f64, f64); 4] = [
    (-2.0, 1.0 / 12.0),
    (-1.0, -2.0 / 3.0),
    (1.0, 2.0 / 3.0),
    (2.0, -1.0 / 12.0),
];
