//! Where, how long and how fast to measure, so that records determine keys of a scene best.
//!
//! White noise of one standard deviation in each sample makes the Fisher information a sum over the bodies measured, with
//! gains `g` of error `e` eliminated body by body, and the covariance of any fit without bias is no less than its inverse:
//!
//! ```text
//! F = sum_b (J_b^T J_b - J_b^T y_b y_b^T J_b / (y_b^T y_b + s^2/e^2)) / s^2,   C >= F^-1
//! ```
//!
//! Source: C. R. Rao, Bull. Calcutta Math. Soc. 37 (1945) 81; V. V. Fedorov, Theory of Optimal Experiments (1972),
//! exchange of points; D. C. Kammer, J. Guid. Control Dyn. 14 (1991) 251, sensors.

mod choice;
mod information;
mod judge;
mod sheet;

use std::sync::atomic::{AtomicU64, Ordering};

use ndarray::Array2;

use super::directions::Direction;
use super::key::FreeKey;
use super::model::Model;
use super::records::{Records, places_in, unit_of};
use super::solver::Problem;
use super::{Instruments, reliable};
use crate::chain::EndTime;
use crate::chain::scene::SceneSource;
use crate::field::Quantity;
use crate::observer::Observer;
use crate::sweep::quantity;
use crate::{Error, Result};
use choice::{Chosen, choose, even};
pub(super) use information::cosines;
use information::{information, products, sum};
use judge::Judge;

/// Normal quantile of 95 % intervals.
const QUANTILE: f64 = 1.959_964;

/// By how much errors may exceed those of the whole run, at the finest sampling.
const ENOUGH: f64 = 1.05;

/// Information of scaled unknowns that counts as none.
const NOTHING: f64 = 1e-9;

/// Samples of a record, at most.
const MOST_SAMPLES: usize = 1 << 24;

/// Share of a direction that nothing is known of, from which on a value is undetermined.
const PART: f64 = 1e-3;

/// The noise of a sample.
#[derive(Debug, Clone, PartialEq)]
pub enum NoiseLevel {
    /// Over the root mean square of the records of all bodies.
    Share(f64),
    /// With its unit; empty for that of the scene.
    Value(f64, String),
}

impl NoiseLevel {
    /// From `2%` or `5mm/s`.
    ///
    /// # Errors
    /// The expected form.
    pub fn parse(text: &str) -> std::result::Result<NoiseLevel, String> {
        let form = || "expected a share of the records, as 2%, or a value, as 5mm/s".to_owned();
        let (share, text) = match text.trim().strip_suffix('%') {
            Some(percent) => (true, percent),
            None => (false, text),
        };
        let (value, unit) = quantity(text).ok_or_else(form)?;
        match (value > 0.0 && value.is_finite(), share, unit) {
            (true, true, "") => Ok(NoiseLevel::Share(0.01 * value)),
            (true, false, unit) => Ok(NoiseLevel::Value(value, unit.to_owned())),
            _ => Err(form()),
        }
    }
}

/// Which sensors are best.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// Those with the least volume of the confidence ellipsoid of all keys, whatever units and scales they have
    /// (D-optimal).
    #[default]
    Volume,
    /// Those with the least of the largest relative error of a key.
    Worst,
}

/// What is planned.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanRequest {
    /// Keys to determine, as [`super::FitRequest::free`] has them.
    pub free: Vec<String>,
    pub sensors: usize,
    pub noise: NoiseLevel,
    pub quantity: Quantity,
    /// Bodies, of forces contacts, that can be measured; by default all.
    pub bodies: Option<Vec<usize>>,
    pub instruments: Instruments,
    /// Samples in a unit of time, which the noise is stated of; by default those of the scene.
    pub rate: Option<f64>,
    pub criterion: Criterion,
}

impl PlanRequest {
    /// So many sensors of velocity for keys, with 1 % of noise and all else by default.
    pub fn of(free: impl IntoIterator<Item = impl Into<String>>, sensors: usize) -> PlanRequest {
        PlanRequest {
            free: free.into_iter().map(Into::into).collect(),
            sensors,
            noise: NoiseLevel::Share(0.01),
            quantity: Quantity::Velocity,
            bodies: None,
            instruments: Instruments::default(),
            rate: None,
            criterion: Criterion::default(),
        }
    }
}

/// A key that is to be determined.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PlannedKey {
    pub name: String,
    pub unit: String,
    /// In the scene, where the information is taken.
    pub value: f64,
    /// Half of its 95 % interval over its value, or itself where the value is 0: of the planned sensors, of as many
    /// evenly spaced ones, of all bodies, each up to the planned duration. NaN where they do not determine it.
    pub planned: f64,
    pub even: f64,
    pub all: f64,
}

/// A plan. Errors are halves of 95 % intervals over the values.
#[derive(Debug, Clone)]
pub struct Planned {
    pub request: PlanRequest,
    pub keys: Vec<PlannedKey>,
    pub candidates: Vec<usize>,
    pub chosen: Vec<usize>,
    pub even: Vec<usize>,
    /// Whether all choices were tried.
    pub is_exact: bool,
    /// Errors of the best 1, 2, .. sensors and of as many evenly spaced ones: `(sensors, key)`.
    pub by_number: [Array2<f64>; 2],
    /// Errors of the planned sensors if they measure up to a time: `(time, key)`.
    pub times: Vec<f64>,
    pub by_time: Array2<f64>,
    /// The same, sampled at a rate behind a filter: `(rate, key)`.
    pub rates: Vec<f64>,
    pub by_rate: Array2<f64>,
    /// Share of each body in what all know of a key if the others are known: `(body, key)`.
    pub information: Array2<f64>,
    /// What the planned sensors leave open.
    pub undetermined: Vec<Direction>,
    /// From when on, and from which rate on, errors are within 5 % of those of the whole run.
    pub duration: f64,
    pub rate: f64,
    /// Standard deviation of the noise of a sample, over that of the records.
    pub noise: f64,
    pub noise_share: f64,
    /// Until when runs agree, of a chain that amplifies rounding.
    pub horizon: Option<f64>,
    /// Units of times and samples.
    pub units: [String; 2],
    pub runs: u64,
}

impl PlanRequest {
    /// Plans the measurement of a chain.
    ///
    /// Runs use all threads of the current pool; the result does not depend on their number.
    ///
    /// # Errors
    /// [`Error::Request`] for keys that cannot be fitted, bodies that the chain has not, more sensors than bodies, noise
    /// in another unit, and chains that amplify rounding from the start; [`Error::Scene`]; [`Error::Cancelled`].
    pub fn run(&self, scene: &SceneSource, observer: &dyn Observer) -> Result<Planned> {
        let runs = AtomicU64::new(0);
        let keys = FreeKey::each(&self.free, scene)?;
        self.instruments.check()?;
        let blank = self.records(scene)?;
        // Gains are eliminated body by body.
        let clock = Instruments {
            time_shift: self.instruments.time_shift,
            ..Instruments::default()
        };
        let others = clock.unknowns(&blank);
        let mut model = Model::of(scene, (&keys, &others), &blank, (observer, &runs))?;
        let origin = vec![0.0; model.unknowns()];
        let records = Records {
            values: model.records_at(&origin, (model.local_error, false))?,
            ..blank.clone()
        };
        model.records = &records;
        let (used, until, _) = reliable(&model, &origin)?;
        model.records = &used;
        let columns = model.columns(&origin, &mut Vec::new())?;
        let size = used.size();
        let expected = "records of what moves";
        Error::require(size != 0.0, "quantity", expected, "zeros alone")?;
        let sigma = self.sigma(&records.units[1], size)?;
        let problem = Planning {
            request: self,
            records: &used,
            columns: &columns,
            keys: &keys,
            sigma,
        };
        Ok(Planned {
            horizon: until,
            runs: runs.load(Ordering::Relaxed),
            ..problem.plan(&model)
        })
    }

    /// Records of all candidates without values.
    fn records(&self, scene: &SceneSource) -> Result<Records> {
        let setup = scene.setup().map_err(|error| scene.locate(error))?;
        let mut simulation = setup.simulation.clone();
        let end = match simulation.end_time {
            EndTime::At(end) => end,
            EndTime::Arrival => {
                simulation.estimate_error = false;
                let run = simulation.run(&crate::observer::Silent)?;
                run.time[run.time.len() - 1]
            }
        };
        let step = match self.rate {
            Some(rate) => 1.0 / rate,
            None => end / (simulation.samples - 1) as f64,
        };
        let samples = (end / step * (1.0 + 1e-12)) as usize + 1;
        let expected = format!("a rate with 2 to {MOST_SAMPLES} samples up to {end:e}");
        let is_so = (2..=MOST_SAMPLES).contains(&samples);
        Error::require(is_so, "rate", expected, samples)?;
        let count = places_in(&setup.simulation.chain, self.quantity);
        let bodies = self.bodies.clone().unwrap_or_else(|| (0..count).collect());
        let most = bodies.len();
        let expected = format!("1 to {most}, one for each body that can be measured");
        let is_so = (1..=most).contains(&self.sensors);
        Error::require(is_so, "sensors", expected, self.sensors)?;
        let records = Records {
            quantity: self.quantity,
            times: (0..samples).map(|i| i as f64 * step).collect(),
            values: vec![0.0; samples * bodies.len()],
            bodies,
            units: unit_of(self.quantity, setup.units)?,
        };
        records.check(&setup)?;
        Ok(records)
    }

    fn sigma(&self, unit: &str, size: f64) -> Result<f64> {
        let (value, own) = match &self.noise {
            NoiseLevel::Share(share) => return Ok(share * size),
            NoiseLevel::Value(value, own) => (*value, own),
        };
        match super::key::ratio(own, unit) {
            _ if own.is_empty() || own == unit => Ok(value),
            Some(ratio) if !unit.is_empty() => Ok(value * ratio),
            _ => {
                let unit = Some(unit).filter(|unit| !unit.is_empty());
                let unit = unit.unwrap_or("no unit, as the scene");
                let expected = format!("a value in {unit}, or a share such as 2%");
                Err(Error::request("noise", expected, own))
            }
        }
    }
}

/// Records, their derivatives along the unknowns, and noise.
struct Planning<'a> {
    request: &'a PlanRequest,
    records: &'a Records,
    columns: &'a [Vec<f64>],
    keys: &'a [FreeKey],
    sigma: f64,
}

impl Planning<'_> {
    /// Derivatives of the record of a candidate, and behind them the record.
    fn rows(&self, body: usize) -> Vec<Vec<f64>> {
        let n = self.records.times.len();
        let part = n * body..n * (body + 1);
        let columns = self.columns.iter();
        let columns = columns.map(|column| column[part.clone()].to_vec());
        let record = self.records.record(body).to_vec();
        columns.chain([record]).collect()
    }

    fn information(&self, products: &Array2<f64>) -> Array2<f64> {
        let weight = self.request.instruments.gain_weight(self.sigma);
        let squares = weight.map(|weight| weight * weight);
        information(products, squares, self.sigma)
    }

    /// Errors by the rows of some bodies up to each end.
    fn growing(&self, judge: &Judge, rows: &[Vec<Vec<f64>>], ends: &[usize]) -> Vec<Vec<f64>> {
        let count = self.columns.len();
        let mut sums = vec![Array2::zeros((count + 1, count + 1)); rows.len()];
        let mut begin = 0;
        let upto = |end: &usize| {
            let mut whole = Array2::zeros((count, count));
            for (sums, rows) in sums.iter_mut().zip(rows) {
                *sums += &products(rows, begin..*end);
                whole += &self.information(sums);
            }
            begin = *end;
            judge.errors(&whole)
        };
        ends.iter().map(upto).collect()
    }

    fn plan(&self, model: &Model) -> Planned {
        let (n, count) = (self.records.times.len(), self.records.bodies.len());
        let rows: Vec<Vec<Vec<f64>>> = (0..count).map(|body| self.rows(body)).collect();
        let upto = |end: usize| -> Vec<Array2<f64>> {
            let each = rows.iter().map(|rows| products(rows, 0..end));
            each.map(|products| self.information(&products)).collect()
        };
        let each = upto(n);
        let judge = Judge::new((self.keys, self.request.criterion), &each);
        let best = |sensors: usize| choose(&each, sensors, &|whole| judge.score(whole));
        let most = count.min((2 * self.request.sensors).max(8));
        let chosen: Vec<Chosen> = (1..=most).map(best).collect();
        let Chosen { bodies, is_exact } = &chosen[self.request.sensors - 1];
        let evenly = even(count, self.request.sensors);
        let errors = |of: &[usize]| judge.errors(&sum(&each, of));
        let best = chosen.iter().map(|chosen| errors(&chosen.bodies));
        let spaced = (1..=most).map(|sensors| errors(&even(count, sensors)));
        let by_number = [best.collect(), spaced.collect()];
        // Up to times.
        let stride = n.div_ceil(1000);
        let ends: Vec<usize> = (1..=n).filter(|end| (n - end) % stride == 0).collect();
        let in_time: Vec<Vec<Vec<f64>>> = bodies.iter().map(|body| rows[*body].clone()).collect();
        let by_time = self.growing(&judge, &in_time, &ends);
        let at = enough(&by_time);
        let times: Vec<f64> = ends.iter().map(|end| self.records.times[end - 1]).collect();
        // Up to frequencies, which add up as samples do.
        let spectra = |rows: &Vec<Vec<f64>>| rows.iter().map(|row| cosines(row)).collect();
        let spectra: Vec<Vec<Vec<f64>>> = in_time.iter().map(spectra).collect();
        let by_rate = self.growing(&judge, &spectra, &ends);
        let rate = |end: &usize| *end as f64 / (n as f64 * self.records.step());
        let rates: Vec<f64> = ends.iter().map(rate).collect();
        let parts = upto(ends[at]);
        let all: Vec<usize> = (0..count).collect();
        let [planned, spaced, whole] =
            [bodies, &evenly, &all].map(|of| judge.errors(&sum(&parts, of)));
        let keys = self.keys.iter().enumerate().map(|(k, key)| PlannedKey {
            name: key.name.clone(),
            unit: key.unit.clone(),
            value: key.value_at(0.0),
            planned: planned[k],
            even: spaced[k],
            all: whole[k],
        });
        let of = |all: &[usize]| all.iter().map(|body| self.records.bodies[*body]).collect();
        Planned {
            keys: keys.collect(),
            candidates: self.records.bodies.clone(),
            chosen: of(bodies),
            even: of(&evenly),
            is_exact: *is_exact,
            by_number: by_number.map(plane),
            by_time: plane(by_time),
            duration: times[at],
            times,
            rate: rates[enough(&by_rate)],
            by_rate: plane(by_rate),
            rates,
            information: judge.shares(&each),
            undetermined: judge.undetermined(&sum(&each, bodies), model),
            noise: self.sigma,
            noise_share: self.sigma / self.records.size(),
            horizon: None,
            units: self.records.units.clone(),
            runs: 0,
            request: self.request.clone(),
        }
    }
}

fn plane(rows: Vec<Vec<f64>>) -> Array2<f64> {
    let count = rows.first().map_or(0, Vec::len);
    Array2::from_shape_fn((rows.len(), count), |(i, k)| rows[i][k])
}

/// The first row whose known errors are all near those of the last one.
fn enough(rows: &[Vec<f64>]) -> usize {
    let Some((last, at)) = rows.last().zip(rows.len().checked_sub(1)) else {
        return 0;
    };
    if last.iter().all(|error| error.is_nan()) {
        return at;
    }
    let near = |(error, last): (&f64, &f64)| last.is_nan() || *error <= ENOUGH * last;
    let is_near = |row: &Vec<f64>| row.iter().zip(last).all(near);
    rows.iter().position(is_near).unwrap_or(at)
}
