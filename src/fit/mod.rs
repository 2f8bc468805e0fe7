//! The chain that did what was measured: keys of a scene fitted to records, with intervals and a verdict.
//!
//! The squares of what records have beyond those of a run are least at the fitted values. Intervals are those of the
//! linearized problem, with the correlation of the noise estimated from what is left:
//!
//! ```text
//! C = H^-1 (J^T S J) H^-1,   H = J^T J,   S the covariance of autoregressive noise
//! ```
//!
//! Whether noise explains what is left is tested ([`Misfit`]). Derivatives J are central differences of runs.

mod cause;
mod compare;
mod directions;
mod gradient;
mod kept;
mod key;
mod model;
mod noise;
pub mod plan;
mod records;
mod result;
mod sheet;
mod shown;
mod solver;
mod verdict;

use std::path::PathBuf;
use std::sync::atomic::AtomicU64;

use serde::{Deserialize, Serialize};

pub use cause::Cause;
pub use compare::{AtBody, Attenuated, CompareRequest, Comparison, InBand};
pub use directions::Direction;
pub use gradient::gradient;
pub use key::FreeKey;
pub(crate) use key::settings;
pub use records::Records;
use result::Circumstances;
pub use result::{Fitted, FittedValue, Horizon};
pub use shown::Overlay;
pub use verdict::Misfit;

use crate::chain::scene::SceneSource;
use crate::numeric::Random;
use crate::observer::Observer;
use crate::system::journal::Outcome;
use crate::{Error, Field, Result};
use kept::{Asked, Ended, Kept};
use model::{Model, Other, rms};
use solver::{Problem, minimize};

/// Local error of runs, over the speed of the motion, and that of the runs that they are checked with.
const LOCAL_ERROR: f64 = 1e-9;
const FINER: f64 = 1.0 / 32.0;

/// Difference of two runs, over the size of the records, from which on a chain amplifies rounding too much.
const AMPLIFIED: f64 = 1e-3;

/// Random points, for each start but the first, of which the one that fits best is taken.
const CANDIDATES: usize = 4;

/// The standard deviation of the noise, over the size of the records, before it is known.
const GUESSED_NOISE: f64 = 0.02;

/// Fits that are repeated because the noise, which errors of gains are compared with, is known better.
const REPEATED: usize = 2;

/// Relative difference of squares up to which two searches ended in one minimum.
const SAME: f64 = 1e-4;

/// What is missed, over the size of the records, that is an error of runs.
const EXACT: f64 = 1e-7;

/// What instruments may add to records.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Instruments {
    /// Whether the clock of the records may be off.
    pub time_shift: bool,
    /// Whether each record has a gain of its own.
    pub gains: bool,
    /// Relative standard error of the gains, if known.
    pub gain_error: Option<f64>,
}

impl Instruments {
    fn check(&self) -> Result<()> {
        let error = self.gain_error.unwrap_or(1.0);
        let is_so = error > 0.0 && error.is_finite();
        Error::require(is_so, "gain-error", "a share above 0, such as 2%", error)
    }

    /// What is fitted to records beside keys.
    fn unknowns(&self, records: &Records) -> Vec<Other> {
        let clock = self.time_shift.then_some(Other::Clock);
        let gains = (0..records.bodies.len()).map(Other::Gain);
        let gains = gains.filter(|_| self.gains || self.gain_error.is_some());
        clock.into_iter().chain(gains).collect()
    }

    /// What a standard error of a gain is worth, in samples of this noise; `None` for gains that are known.
    fn gain_weight(&self, noise: f64) -> Option<f64> {
        let stated = self.gain_error.map(|error| noise / error);
        stated.or_else(|| self.gains.then_some(0.0))
    }
}

/// What is fitted, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitRequest {
    /// Free keys, each as [`FreeKey::of`] reads it.
    pub free: Vec<String>,
    /// The body of each site of the field, or of forces the contact.
    #[serde(skip)]
    pub bodies: Option<Vec<usize>>,
    pub instruments: Instruments,
    /// Searches, the first from the scene's values.
    pub starts: usize,
    /// Of the other starts.
    pub seed: u64,
    /// Directory that keeps each search once it has ended: the same fit resumes there.
    #[serde(skip)]
    pub resume: Option<PathBuf>,
}

impl Default for FitRequest {
    fn default() -> Self {
        FitRequest {
            free: Vec::new(),
            bodies: None,
            instruments: Instruments::default(),
            starts: 5,
            seed: 0,
            resume: None,
        }
    }
}

/// Where a search ended.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Search {
    /// Values of the free keys at its start and at its end.
    pub start: Vec<f64>,
    pub end: Vec<f64>,
    /// Root mean square of what the run misses, in the unit of the records.
    pub missed: f64,
    pub is_settled: bool,
}

impl FitRequest {
    /// Fits the chain of a scene to a field of records.
    ///
    /// Searches and runs use all threads of the current pool; the result does not depend on their number.
    ///
    /// # Errors
    /// [`Error::Request`] for keys that cannot be fitted, records that are not of the chain, too few samples, and
    /// chains that amplify rounding from the start; [`Error::Scene`] for the scene; [`Error::OutputInUse`] for a directory
    /// with another fit; [`Error::Cancelled`], or [`Error::Paused`] where searches are kept.
    pub fn run(
        &self,
        field: &Field,
        scene: &SceneSource,
        observer: &dyn Observer,
    ) -> Result<Fitted> {
        let records = Records::of(field, scene, self.bodies.as_deref())?;
        self.of_records(records, scene, observer)
    }

    /// The same of records.
    ///
    /// # Errors
    /// As [`FitRequest::run`].
    pub fn of_records(
        &self,
        records: Records,
        scene: &SceneSource,
        observer: &dyn Observer,
    ) -> Result<Fitted> {
        let keys = FreeKey::each(&self.free, scene)?;
        self.instruments.check()?;
        Error::require(self.starts > 0, "starts", "1 or more", "0")?;
        let runs = AtomicU64::new(0);
        let others = self.instruments.unknowns(&records);
        let mut model = Model::of(scene, (&keys, &others), &records, (observer, &runs))?;
        let noise = GUESSED_NOISE * records.size();
        model.gain_weight = self.instruments.gain_weight(noise).unwrap_or(0.0);
        records.check_number(model.unknowns())?;
        let (used, until, error) = reliable(&model, &vec![0.0; model.unknowns()])?;
        model.records = &used;
        let horizon = until.map(|until| Horizon {
            until,
            left_out: records.times.len() - used.times.len(),
        });
        let kept = Kept::open(self.resume.as_deref(), &Asked::of(self, &model)?)?;
        let ended = self.search(&model, &kept)?;
        let fitted = self.judged(&mut model, &ended, (horizon, error));
        let mut fitted = fitted.map_err(|error| kept.paused(error, self.starts))?;
        let of_searches = ended.iter().map(|search| search.runs);
        fitted.runs = runs.into_inner() + of_searches.sum::<u64>();
        Ok(fitted)
    }

    /// The chain at the best minimum: what noise makes of it, and why it misses what it misses.
    fn judged(&self, model: &mut Model, ended: &[Ended], about: Circumstances) -> Result<Fitted> {
        let values = |at: &[f64]| {
            let each = model.keys.iter().zip(at);
            each.map(|(key, u)| key.value_at(*u)).collect()
        };
        let known = model.records.known() as f64;
        let searches = ended.iter().map(|search| Search {
            start: values(&search.start),
            end: values(&search.end),
            missed: (search.squares / known).sqrt(),
            is_settled: search.is_settled,
        });
        let searches = searches.collect();
        let least = ended.iter().min_by(|a, b| a.squares.total_cmp(&b.squares));
        let at = least.map_or(&[][..], |search| &search.end);
        let (mut best, mut predicted) = model.minimum(at)?;
        if model.gain_weight > 0.0 {
            for _ in 0..REPEATED {
                let noise = result::judge(model, &best).gain_scale();
                model.gain_weight = self.instruments.gain_weight(noise).unwrap_or(0.0);
                best = minimize(model, &best.at)?;
            }
            predicted = model.predicted(&best.at)?;
        }
        let mut fitted = Fitted::of(model, &best, &predicted, about);
        fitted.searches = searches;
        if let Some(misfit) = &fitted.misfit {
            fitted.cause = cause::cause(model, &best, &misfit.bodies)?;
        }
        Ok(fitted)
    }

    /// Where all searches ended.
    fn search(&self, model: &Model, kept: &Kept) -> Result<Vec<Ended>> {
        let mut first = vec![0.0; model.unknowns()];
        if self.instruments.time_shift {
            first[model.keys.len()] = aligned(model, &first)?;
        }
        let searches: Vec<usize> = (0..self.starts).collect();
        kept.each("searches", &searches, model.observer, |search, observer| {
            let found = kept.member(search, || {
                let runs = AtomicU64::new(0);
                let model = Model {
                    observer,
                    runs: &runs,
                    ..*model
                };
                let start = match search {
                    0 => first.clone(),
                    search => self.candidate(&model, &first, *search),
                };
                let found = minimize(&model, &start)?;
                Ok(Ended {
                    start,
                    end: found.at,
                    squares: found.squares,
                    is_settled: found.is_settled,
                    runs: runs.into_inner(),
                })
            });
            found.and_then(|_| kept.sync())
        })?;
        let outcomes = kept.outcomes();
        let ended = outcomes.values().filter_map(Outcome::done);
        let ended: Vec<Ended> = ended.cloned().collect();
        match outcomes.values().next() {
            Some(Outcome::Failed(why)) if ended.is_empty() => {
                let expected = "keys with which the chain runs";
                Err(Error::request("free", expected, why))
            }
            _ => Ok(ended),
        }
    }

    /// Of some random points the one that fits best.
    fn candidate(&self, model: &Model, first: &[f64], search: usize) -> Vec<f64> {
        let mut random = Random::new(self.seed ^ (search as u64) << 32);
        let points = (0..CANDIDATES).map(|_| {
            let mut point = first.to_vec();
            for (u, key) in point.iter_mut().zip(model.keys) {
                *u = key.spread(random.uniform());
            }
            point
        });
        let tried = points.map(|point| {
            let residual = model.residual(&point);
            let squares = residual.map_or(f64::INFINITY, |r| solver::square(&r));
            (squares, point)
        });
        let best = tried.min_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or_else(|| first.to_vec(), |(_, point)| point)
    }
}

/// The shift, in samples, at which records are most like those of a run.
fn aligned(model: &Model, at: &[f64]) -> Result<f64> {
    let mut at = at.to_vec();
    at[model.keys.len()] = 0.0;
    let predicted = model.records_at(&at, (model.local_error, false))?;
    let times = model.records.times.len();
    let known = |value: f64| if value.is_finite() { value } else { 0.0 };
    let alike = |shift: isize| -> f64 {
        let records = predicted.chunks_exact(times).enumerate();
        let sums = records.map(|(site, record)| {
            let measured = model.records.record(site);
            let range = shift.max(0) as usize..times.min((times as isize + shift) as usize);
            range
                .map(|i| known(measured[i]) * record[(i as isize - shift) as usize])
                .sum::<f64>()
        });
        sums.sum()
    };
    let half = (times / 2) as isize;
    let best = (-half..=half).map(|shift| (alike(shift), shift));
    let best = best.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.abs().cmp(&a.1.abs())));
    Ok(best.map_or(0.0, |(_, shift)| shift as f64))
}

/// The local error of runs, over the speed that they guess: that of a driven chain may be far too large.
fn local_error(simulation: &crate::chain::Simulation, records: &Records) -> Result<f64> {
    if simulation.drive.is_none() {
        return Ok(LOCAL_ERROR);
    }
    let mut pilot = simulation.clone();
    pilot.end_time = crate::chain::EndTime::At(records.times[records.times.len() - 1]);
    pilot.samples = 256;
    pilot.estimate_error = false;
    let run = pilot.run(&crate::observer::Silent)?;
    let seen = run.velocity.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    Ok(LOCAL_ERROR * (seen / simulation.speed()).clamp(1e-4, 1.0))
}

/// Until when two runs agree, where that is not the end, and by how much they differ before, over the size of the
/// records.
fn horizon(model: &Model, at: &[f64]) -> Result<(Option<f64>, f64)> {
    let rough = model.records_at(at, (model.local_error, false))?;
    // Where samples are close, steps end at them: those of both runs are never the same.
    let fine = model.records_at(at, (FINER * model.local_error, true))?;
    let records = model.records;
    let (times, size) = (records.times.len(), rms(&fine).max(records.size()));
    let difference = |i: usize| {
        let sites = (0..records.bodies.len())
            .map(|site| (rough[times * site + i] - fine[times * site + i]).abs());
        sites.fold(0.0, f64::max) / size.max(f64::MIN_POSITIVE)
    };
    let differences: Vec<f64> = (0..times).map(difference).collect();
    let first = differences.iter().position(|d| *d > AMPLIFIED);
    let end = first.unwrap_or(times);
    let worst = differences[..end].iter().copied().fold(0.0, f64::max);
    let until = (end < times).then(|| records.times[end.saturating_sub(1)]);
    Ok((until, worst))
}

/// The records as far as runs agree; until when, where that is not the end; the error of runs before.
fn reliable(model: &Model, at: &[f64]) -> Result<(Records, Option<f64>, f64)> {
    let (records, unknowns) = (model.records, model.unknowns());
    let (until, error) = horizon(model, at)?;
    let used = until.map_or_else(|| records.clone(), |until| records.until(until));
    let few = used.check_number(unknowns);
    let (Some(until), Err(_)) = (until, &few) else {
        return few.map(|()| (used, until, error));
    };
    let [start, end] = [0, records.times.len() - 1].map(|i| records.times[i]);
    let share = 100.0 * ((until - start) / (end - start)).max(0.0);
    Err(Error::request(
        "scene",
        "a chain whose rounding errors stay small over the records: shorter records, or fewer bodies",
        format!("one whose runs agree until {until:e} alone, {share:.0} % of them"),
    ))
}
