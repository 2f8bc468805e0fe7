//! What a fit found.

use ndarray::Array2;

use super::cause::Cause;
use super::directions::{Direction, factored, loose};
use super::key::FreeKey;
use super::model::{Model, Other, rms};
use super::noise::{Linear, Noise};
use super::shown::Overlay;
use super::solver::{Minimum, gram, scaled};
use super::verdict::{Misfit, misfit};
use super::{EXACT, SAME, Search};
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
#[derive(Debug, Clone, serde::Serialize)]
pub struct Fitted {
    pub values: Vec<FittedValue>,
    /// Of the values, as many rows as columns; NaN where they are undetermined.
    #[serde(skip)]
    pub correlation: Array2<f64>,
    pub undetermined: Vec<Direction>,
    /// What noise does not explain; `None` for nothing.
    pub misfit: Option<Misfit>,
    /// What explains the misfit, of all that was tried.
    pub cause: Option<Cause>,
    #[serde(skip)]
    pub overlay: Overlay,
    /// Standard deviation of what is left, and its correlation with what is left so many samples later.
    pub noise: f64,
    #[serde(skip)]
    pub noise_correlation: Vec<f64>,
    /// Number of samples that would tell as much if they were independent.
    #[serde(rename = "independent_samples")]
    pub independent: f64,
    /// Share of the squares of the records that the chain explains.
    pub explained: f64,
    /// Whether what is left is the error of runs.
    #[serde(rename = "exact")]
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
    for (own, row) in sizes.iter().zip(&mut covariance) {
        let cells = row.iter_mut().zip(&sizes);
        cells.for_each(|(c, size)| *c /= own * size);
    }
    Noted {
        noise,
        unknown,
        loose: loose(&covariance),
        covariance,
    }
}

/// Where a chain amplifies rounding, and the error of runs.
pub(super) type Circumstances = (Option<Horizon>, f64);

impl Fitted {
    pub(super) fn of(
        model: &Model,
        found: &Minimum,
        predicted: &[f64],
        (horizon, run_error): Circumstances,
    ) -> Fitted {
        let records = model.records;
        let Noted {
            noise,
            covariance,
            unknown,
            loose,
        } = judge(model, found);
        let residual = &found.residual[..records.values.len()];
        let measured = records.masked(records.values.iter().copied());
        let left = rms(residual) / rms(&measured).max(f64::MIN_POSITIVE);
        let is_exact = left < ROUNDING.max(3.0 * run_error);
        let misfit = match is_exact {
            true => None,
            false => misfit(model, found, predicted, &noise),
        };
        let unknowns = unknowns(model);
        let directions = unknown.iter().chain(&loose);
        let directions = directions.map(|d| Direction::of(d, &unknowns)).collect();
        let degrees = (noise.independent() - found.at.len() as f64).max(1.0);
        let quantile = student_two_sided(ALPHA, degrees);
        let is_loose = |k: usize| unknown.iter().any(|d: &Vec<f64>| d[k].abs() > PART);
        let halves: Vec<f64> = (0..found.at.len())
            .map(|k| match is_loose(k) {
                true => f64::NAN,
                false => quantile * covariance[k][k].max(0.0).sqrt(),
            })
            .collect();
        let each = unknowns.iter().enumerate();
        let values = each
            .map(|(k, of)| of.fitted(found.at[k], halves[k]))
            .collect();
        let correlation = Array2::from_shape_fn((halves.len(), halves.len()), |(i, j)| {
            match is_loose(i) || is_loose(j) {
                true => f64::NAN,
                false => covariance[i][j] / (covariance[i][i] * covariance[j][j]).sqrt(),
            }
        });
        let settings = model.settings(&found.at).into_iter();
        Fitted {
            values,
            correlation,
            undetermined: directions,
            misfit,
            overlay: Overlay::of(records, predicted),
            noise: noise.sigma,
            noise_correlation: noise.correlation.clone(),
            independent: noise.independent(),
            explained: 1.0 - left * left,
            is_exact,
            run_error,
            horizon,
            searches: Vec::new(),
            runs: 0,
            cause: None,
            scene: settings.map(|s| [s.key, s.text]).collect(),
        }
    }

    /// How many searches ended in the best minimum.
    pub fn agreeing(&self) -> usize {
        let missed = || self.searches.iter().map(|search| search.missed);
        let best = missed().fold(f64::INFINITY, f64::min);
        let most = best + SAME * best + EXACT * self.overlay.records.size();
        missed().filter(|missed| *missed <= most).count()
    }

    /// The scene that was fitted, with the fitted values.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] for a scene that cannot be read.
    pub fn scene_text(&self, scene: &SceneSource) -> Result<String> {
        let settings = self.scene.iter();
        let settings = settings.map(|[key, text]| Setting::new(key, text, "--free"));
        scene.with(settings).whole_text()
    }

    /// A fitted value by its name.
    pub fn value(&self, name: &str) -> Option<&FittedValue> {
        self.values.iter().find(|value| value.name == name)
    }
}

/// What is searched.
#[derive(Debug, Clone, Copy)]
pub(super) enum Unknown<'a> {
    Key(&'a FreeKey),
    /// How late the records are, in steps of their samples, and the unit of time.
    Shift(f64, &'a str),
    /// Of the record of a body.
    Gain(usize),
}

/// All that a model searches, in the order of its coordinates.
pub(super) fn unknowns<'a>(model: &Model<'a>) -> Vec<Unknown<'a>> {
    let records = model.records;
    let others = model.others.iter().filter_map(|other| match other {
        Other::Clock => Some(Unknown::Shift(records.step(), &records.units[0])),
        Other::Gain(site) => Some(Unknown::Gain(records.bodies[*site])),
        Other::Gains | Other::Held(_) => None,
    });
    model.keys.iter().map(Unknown::Key).chain(others).collect()
}

impl Unknown<'_> {
    pub fn name(&self) -> String {
        match self {
            Unknown::Key(key) => key.name.clone(),
            Unknown::Shift(..) => "time_shift".into(),
            Unknown::Gain(body) => format!("gain[{body}]"),
        }
    }

    /// The value at a coordinate of the search.
    fn value_at(&self, u: f64) -> f64 {
        match self {
            Unknown::Key(key) => key.value_at(u),
            Unknown::Shift(step, _) => u * step,
            Unknown::Gain(_) => u.exp(),
        }
    }

    /// The unit of its coordinate, in values; `None` for a logarithm.
    pub fn linear(&self) -> Option<f64> {
        match self {
            Unknown::Key(key) if key.is_log => None,
            Unknown::Key(key) => Some(key.scale()),
            Unknown::Gain(_) => None,
            Unknown::Shift(step, _) => Some(*step),
        }
    }

    /// What is found where the search has ended, with half of the interval there; NaN for none.
    fn fitted(&self, at: f64, half: f64) -> FittedValue {
        let value = self.value_at(at);
        let (unit, is_at_bound) = match self {
            Unknown::Key(key) => (key.unit.as_str(), key.bounds.contains(&value)),
            Unknown::Shift(_, unit) => (*unit, false),
            Unknown::Gain(_) => ("", false),
        };
        FittedValue {
            name: self.name(),
            unit: unit.into(),
            value,
            low: self.value_at(at - half),
            high: self.value_at(at + half),
            start: self.value_at(0.0),
            is_at_bound,
            is_key: matches!(self, Unknown::Key(_)),
        }
    }
}
