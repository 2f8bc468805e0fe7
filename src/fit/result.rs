//! What a fit found.

use ndarray::Array2;

use super::cause::Cause;
use super::directions::{Coordinate, Direction, factored, loose};
use super::model::{Model, rms};
use super::noise::{Linear, Noise};
use super::records::Records;
use super::solver::{Minimum, gram, scaled};
use super::verdict::{Judged, Misfit, frequencies, mean_density};
use super::{Search, is_same};
use crate::Result;
use crate::chain::scene::{SceneSource, Setting};
use crate::numeric::student_two_sided;

/// What is left, over the records, that is no noise but the error of runs and of their differences.
const ROUNDING: f64 = 1e-6;

/// Share of a direction that nothing is known of, from which on a value has no interval.
const PART: f64 = 1e-3;

/// Significance of intervals.
const ALPHA: f64 = 0.05;

/// A fitted number with its 95 % interval.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FittedValue {
    pub name: String,
    pub unit: String,
    pub value: f64,
    /// NaN where the records do not determine it.
    pub low: f64,
    pub high: f64,
    pub start: f64,
    /// Whether the fit ended at a bound.
    pub is_at_bound: bool,
    /// Whether it is a key of the scene, and no time shift or gain.
    pub is_key: bool,
}

/// Until when the runs of a chain that amplifies rounding agree.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Horizon {
    pub until: f64,
    /// Samples of each record after it.
    pub left_out: usize,
}

/// A fitted chain.
#[derive(Debug, Clone)]
pub struct Fitted {
    pub values: Vec<FittedValue>,
    /// Of the values, as many rows as columns; NaN where they are undetermined.
    pub correlation: Array2<f64>,
    pub undetermined: Vec<Direction>,
    /// What noise does not explain; `None` for nothing.
    pub misfit: Option<Misfit>,
    /// What explains the misfit, of all that was tried.
    pub cause: Option<Cause>,
    pub records: Records,
    /// `(time, site)`.
    pub measured: Array2<f64>,
    pub fitted: Array2<f64>,
    pub residual: Array2<f64>,
    /// Power of the residual by frequency, one-sided, of all sites.
    pub frequencies: Vec<f64>,
    pub residual_spectrum: Vec<f64>,
    pub measured_spectrum: Vec<f64>,
    /// Standard deviation of what is left, and its correlation with what is left so many samples later.
    pub noise: f64,
    pub noise_correlation: Vec<f64>,
    /// Independent samples, of so many known ones.
    pub independent: f64,
    pub known: usize,
    /// Share of the squares of the records that the chain explains.
    pub explained: f64,
    /// Whether what is left is the error of runs.
    pub is_exact: bool,
    /// By how much runs of other steps differ, over the size of the records.
    pub run_error: f64,
    pub horizon: Option<Horizon>,
    pub searches: Vec<Search>,
    pub runs: u64,
    /// Lines of the scene with the fitted values.
    pub scene: Vec<[String; 2]>,
}

/// Noise and covariance at a minimum.
pub(super) struct Noted {
    pub noise: Noise,
    covariance: Vec<Vec<f64>>,
    /// Directions that nothing is known of, and those that hardly anything is.
    unknown: Vec<Vec<f64>>,
    loose: Vec<Vec<f64>>,
}

impl Noted {
    /// The noise, larger by its correlation, that errors of gains are compared with.
    pub fn gain_scale(&self) -> f64 {
        self.noise.sigma * self.noise.inflation().sqrt()
    }
}

/// Whether noise does not explain what is left at a minimum.
pub(super) fn has_misfit(model: &Model, found: &Minimum) -> Result<bool> {
    let noise = judge(model, found).noise;
    Ok(misfit(model, found, &model.predicted(&found.at)?, &noise).is_some())
}

pub(super) fn misfit(
    model: &Model,
    found: &Minimum,
    predicted: &[f64],
    noise: &Noise,
) -> Option<Misfit> {
    let known = model.records.is_known();
    let judged = Judged {
        records: model.records,
        residual: &found.residual[..known.len()],
        known: &known,
        predicted,
        columns: &found.columns,
        noise,
    };
    judged.misfit()
}

/// Estimates noise and covariance at a minimum.
pub(super) fn judge(model: &Model, found: &Minimum) -> Noted {
    let records = model.records;
    let known = records.is_known();
    let (scaled, sizes) = scaled(&found.columns);
    let (lower, unknown) = factored(gram(&scaled), &sizes);
    let linear = Linear {
        columns: &scaled,
        lower: &lower,
        sites: records.bodies.len(),
        times: records.times.len(),
    };
    let noise = Noise::of(&found.residual[..records.values.len()], &known, &linear);
    let mut covariance = linear.covariance(&noise);
    for (i, row) in covariance.iter_mut().enumerate() {
        row.iter_mut()
            .zip(&sizes)
            .for_each(|(c, size)| *c /= sizes[i] * size);
    }
    Noted {
        noise,
        unknown,
        loose: loose(&covariance),
        covariance,
    }
}

type Circumstances = (Vec<Search>, Option<Horizon>, f64);

impl Fitted {
    pub(super) fn of(model: &Model, found: &Minimum, about: Circumstances) -> Result<Fitted> {
        let (searches, horizon, run_error) = about;
        let records = model.records;
        let Noted {
            noise,
            covariance,
            unknown,
            loose,
        } = judge(model, found);
        let residual = &found.residual[..records.values.len()];
        let predicted = model.predicted(&found.at)?;
        let measured = records.masked(records.values.iter().copied());
        let left = rms(residual) / rms(&measured).max(f64::MIN_POSITIVE);
        let is_exact = left < ROUNDING.max(3.0 * run_error);
        let misfit = match is_exact {
            true => None,
            false => misfit(model, found, &predicted, &noise),
        };
        let coordinates = coordinates(model);
        let directions = unknown
            .iter()
            .chain(&loose)
            .map(|d| Direction::of(d, &coordinates))
            .collect();
        let degrees = (noise.independent() - found.at.len() as f64).max(1.0);
        let quantile = student_two_sided(ALPHA, degrees);
        let is_loose = |k: usize| unknown.iter().any(|d: &Vec<f64>| d[k].abs() > PART);
        let halves: Vec<f64> = (0..found.at.len())
            .map(|k| {
                if is_loose(k) {
                    f64::NAN
                } else {
                    quantile * covariance[k][k].max(0.0).sqrt()
                }
            })
            .collect();
        let values = values(model, &found.at, &halves);
        let correlation = Array2::from_shape_fn((halves.len(), halves.len()), |(i, j)| {
            match is_loose(i) || is_loose(j) {
                true => f64::NAN,
                false => covariance[i][j] / (covariance[i][i] * covariance[j][j]).sqrt(),
            }
        });
        let settings = model.settings(&found.at).into_iter();
        Ok(Fitted {
            values,
            correlation,
            undetermined: directions,
            misfit,
            residual: records.plane(&records.values) - records.plane(&predicted),
            measured: records.plane(&records.values),
            fitted: records.plane(&predicted),
            frequencies: frequencies(records),
            residual_spectrum: mean_density(residual, records),
            measured_spectrum: mean_density(&measured, records),
            noise: noise.sigma,
            noise_correlation: noise.correlation.clone(),
            independent: noise.independent(),
            known: records.known(),
            explained: 1.0 - left * left,
            is_exact,
            run_error,
            horizon,
            searches,
            runs: 0,
            cause: None,
            scene: settings.map(|s| [s.key, s.text]).collect(),
            records: records.clone(),
        })
    }

    /// How many searches ended in the best minimum.
    pub fn agreeing(&self) -> usize {
        let best = self
            .searches
            .iter()
            .map(|s| s.missed)
            .fold(f64::INFINITY, f64::min);
        let size = self.records.size();
        self.searches
            .iter()
            .filter(|s| is_same(s.missed, best, size))
            .count()
    }

    /// The scene that was fitted, with the fitted values.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] for a scene that cannot be read.
    pub fn scene_text(&self, scene: &SceneSource) -> Result<String> {
        let settings = self
            .scene
            .iter()
            .map(|[key, text]| Setting::new(key, text, "--free"));
        scene.with(settings).whole_text()
    }

    /// A fitted value by its name.
    pub fn value(&self, name: &str) -> Option<&FittedValue> {
        self.values.iter().find(|value| value.name == name)
    }
}

pub(super) fn coordinates(model: &Model) -> Vec<Coordinate> {
    let keys = model.keys.iter().map(|key| Coordinate {
        name: key.name.clone(),
        linear: (!key.is_log).then(|| key.value_at(1.0) - key.value_at(0.0)),
    });
    let shift = model.nuisances.shift.then(|| Coordinate {
        name: "time_shift".into(),
        linear: Some(model.records.step()),
    });
    let bodies = model.nuisances.gains.then_some(&model.records.bodies);
    let gains = bodies.into_iter().flatten().map(|body| Coordinate {
        name: format!("gain[{body}]"),
        linear: None,
    });
    keys.chain(shift).chain(gains).collect()
}

fn values(model: &Model, at: &[f64], halves: &[f64]) -> Vec<FittedValue> {
    let ends = |k: usize, of: &dyn Fn(f64) -> f64| match halves[k].is_finite() {
        true => [of(at[k] - halves[k]), of(at[k] + halves[k])],
        false => [f64::NAN; 2],
    };
    let mut all: Vec<FittedValue> = model
        .keys
        .iter()
        .enumerate()
        .map(|(k, key)| {
            let value = key.value_at(at[k]);
            let [low, high] = ends(k, &|u| key.value_at(u));
            FittedValue {
                name: key.name.clone(),
                unit: key.unit.clone(),
                value,
                low,
                high,
                start: key.start,
                is_at_bound: key.bounds.contains(&value),
                is_key: true,
            }
        })
        .collect();
    let beside = |k: usize, name: String, unit: &str, start: f64, of: &dyn Fn(f64) -> f64| {
        let [low, high] = ends(k, of);
        FittedValue {
            name,
            unit: unit.into(),
            value: of(at[k]),
            low,
            high,
            start,
            is_at_bound: false,
            is_key: false,
        }
    };
    let keys = model.keys.len();
    if model.nuisances.shift {
        let step = model.records.step();
        let unit = &model.records.units[0];
        all.push(beside(keys, "time_shift".into(), unit, 0.0, &|u| u * step));
    }
    if model.nuisances.gains {
        for (site, body) in model.records.bodies.iter().enumerate() {
            let k = model.moved() + site;
            all.push(beside(k, format!("gain[{body}]"), "", 1.0, &f64::exp));
        }
    }
    all
}
