//! A measured field against a run of a chain, at the field's places and times: where they agree, and where they part.
//!
//! Nothing is fitted to the chain. A difference is stated where noise does not make it: noise is what the run leaves of a
//! record, or the run as late and as large as that record, whichever leaves less; or what is there before the fronts, where that is
//! much less.

mod bands;
mod front;
mod sheet;

use std::sync::atomic::AtomicU64;

use serde::Serialize;

pub use bands::InBand;

use super::cause::{Cause, cause};
use super::model::{Model, rms};
use super::noise::{Linear, Noise};
use super::records::Records;
use super::result::judge;
use super::shown::Overlay;
use super::solver::square;
use super::verdict::{Misfit, misfit};
use super::{EXACT, reliable};
use crate::analyze::{Request, Results, analyze};
use crate::chain::scene::SceneSource;
use crate::field::Axis;
use crate::moved::Movement;
use crate::numeric::LineFit;
use crate::observer::Observer;
use crate::{Field, Result};
use front::{Curve, Front, Told};

/// Standard errors by which a difference is told: by chance once in 16 000.
const TOLD: f64 = 4.0;

/// Level of the tests of what is left, over that of a fit, whose tests are wrong in 4 % of fields of noise.
const LEVEL: f64 = 0.02;

/// Independent samples before the fronts that tell the noise, and what it is at most of all that is left.
const QUIET: f64 = 40.0;
const CLEAN: f64 = 0.6;

/// Fewest bodies that tell an attenuation, and what moved.
const BODIES: usize = 4;

/// How a field is compared.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareRequest {
    /// As in [`super::FitRequest`].
    pub bodies: Option<Vec<usize>>,
    /// Relative difference of energies up to which they agree.
    pub within: f64,
}

impl Default for CompareRequest {
    fn default() -> Self {
        CompareRequest {
            bodies: None,
            within: 0.05,
        }
    }
}

/// One record: of the measurement, and of the run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AtBody {
    pub body: usize,
    /// Standard deviation of the noise.
    pub noise: f64,
    /// When half of the run's largest value is first reached, measured and in the run; NaN where the record has no front, or
    /// noise hides it.
    pub arrival: [f64; 2],
    pub arrival_error: f64,
    pub is_late: bool,
    /// The largest value of the run, and that times the size of the measured front.
    pub peak: [f64; 2],
    pub peak_error: f64,
    pub is_other: bool,
    /// Energy of the difference over that of the measurement, with the noise.
    pub residual: f64,
}

/// Decrease of the logarithm of the largest value from body to body, with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Attenuated {
    pub rate: f64,
    pub error: f64,
}

/// What was found. Pairs are of the measurement and of the run.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    #[serde(skip)]
    pub request: CompareRequest,
    #[serde(skip)]
    pub overlay: Overlay,
    pub bodies: Vec<AtBody>,
    pub bands: Vec<InBand>,
    pub attenuation: Option<[Attenuated; 2]>,
    /// What moved along x.
    #[serde(skip)]
    pub moved: Option<[Movement; 2]>,
    /// What noise does not explain of the difference; `None` for nothing.
    pub misfit: Option<Misfit>,
    /// The one number of the chain, of the clock or of a gain that explains it.
    pub cause: Option<Cause>,
    /// Whether the difference is the error of runs.
    #[serde(rename = "exact")]
    pub is_exact: bool,
    /// Energy of the difference over that of the measurement, with the noise.
    pub left: f64,
    /// Until when runs agree, of a chain that amplifies rounding.
    pub horizon: Option<f64>,
}

impl CompareRequest {
    /// Compares a field with the run of a scene.
    ///
    /// # Errors
    /// [`crate::Error::Request`] and [`crate::Error::Unfit`] for records that are not of the chain, and chains that amplify
    /// rounding from the start; [`crate::Error::Scene`]; [`crate::Error::Cancelled`].
    pub fn run(
        &self,
        field: &Field,
        scene: &SceneSource,
        observer: &dyn Observer,
    ) -> Result<Comparison> {
        let records = Records::of(field, scene, self.bodies.as_deref())?;
        self.of_records(records, scene, observer)
    }

    /// The same of records.
    ///
    /// # Errors
    /// As [`CompareRequest::run`].
    pub fn of_records(
        &self,
        records: Records,
        scene: &SceneSource,
        observer: &dyn Observer,
    ) -> Result<Comparison> {
        let runs = AtomicU64::new(0);
        let mut model = Model::of(scene, (&[], &[]), &records, (observer, &runs))?;
        let (used, until, run_error) = reliable(&model, &[])?;
        model.records = &used;
        let (minimum, predicted) = model.minimum(&[])?;
        let is_exact = rms(&minimum.residual) <= used.size() * EXACT.max(3.0 * run_error);
        let pair = Pair::of(&used, &predicted, is_exact);
        let bodies: Vec<AtBody> = (0..pair.sites()).map(|site| pair.body(site)).collect();
        let is_told = bodies.iter().any(|at| at.is_late || at.is_other);
        let misfit = misfit(&model, &minimum, &predicted, &judge(&model, &minimum).noise)
            .filter(|misfit| !is_exact && (is_told || misfit.level < LEVEL));
        let of_misfit = misfit.as_ref().map(|misfit| &misfit.bodies);
        let cause = match misfit.is_some() || is_told {
            true => cause(&model, &minimum, of_misfit.unwrap_or(&used.bodies))?,
            false => None,
        };
        let mut moves = None;
        if pair.sites() >= BODIES {
            let [measured, run] = [&pair.measured, &pair.run].map(|values| moved(&used, values));
            moves = measured?.zip(run?).map(<[_; 2]>::from);
        }
        Ok(Comparison {
            moved: moves,
            overlay: Overlay::of(&used, &predicted),
            bands: bands::bands(&pair),
            attenuation: attenuations(&bodies),
            left: minimum.squares / square(&pair.measured).max(f64::MIN_POSITIVE),
            bodies,
            misfit,
            cause: cause.filter(|cause| cause.is_all),
            is_exact,
            horizon: until,
            request: self.clone(),
        })
    }
}

/// What moves along x, of samples that are 0 where they are missing.
fn moved(records: &Records, values: &[f64]) -> Result<Option<Movement>> {
    let mut samples = Field::from_array(records.plane(values));
    samples.time = Axis {
        origin: records.times[0],
        step: records.step(),
        unit: None,
    };
    samples.quantity = records.quantity;
    let request = Request {
        results: Results {
            answer: true,
            ..Results::NONE
        },
        ..Request::default()
    };
    let (analysis, _) = analyze(&samples, &request)?;
    Ok(analysis.answer.map(|answer| answer.frequency))
}

/// By how much largest values fall from body to body: lines through their logarithms.
fn attenuations(bodies: &[AtBody]) -> Option<[Attenuated; 2]> {
    let of = |which: usize| {
        let reached = bodies.iter().filter(|at| at.arrival[0].is_finite());
        let points = reached.map(|at| (at.body as f64, at.peak[which].ln()));
        let points: Vec<(f64, f64)> = points.collect();
        let line = (points.len() >= BODIES).then(|| LineFit::through(&points))??;
        Some(Attenuated {
            rate: -line.slope,
            error: line.slope_error,
        })
    };
    Some([of(0)?, of(1)?])
}

/// Records of a measurement, and of a run there, 0 where they are missing.
struct Pair<'a> {
    records: &'a Records,
    measured: Vec<f64>,
    run: Vec<f64>,
    /// The run, where nothing is missing.
    whole: &'a [f64],
    known: Vec<bool>,
    fronts: Vec<Option<(Front, Told)>>,
    noise: Noise,
    /// Whether the noise is that before the fronts, and not all that is left.
    is_quiet: bool,
}

impl<'a> Pair<'a> {
    fn of(records: &'a Records, run: &'a [f64], is_exact: bool) -> Pair<'a> {
        let mut pair = Pair {
            measured: records.masked(records.values.iter().copied()),
            run: records.masked(run.iter().copied()),
            known: records.is_known(),
            records,
            whole: run,
            fronts: Vec::new(),
            noise: Noise::default(),
            is_quiet: false,
        };
        let fronts: Vec<Option<Front>> = (0..pair.sites())
            .map(|site| Front::of(&pair.curve(site), pair.measured(site), pair.known(site)))
            .collect();
        // At most the noise, and what the run as late and as large as the records misses.
        let least = |site: usize| {
            let [plain, moved] = [None, fronts[site]].map(|front| pair.left(site, front));
            match square(&moved) < square(&plain) {
                true => moved,
                false => plain,
            }
        };
        let left: Vec<f64> = (0..pair.sites()).flat_map(least).collect();
        pair.noise = pair.noise_of(&left, &pair.known);
        let early = |site: usize| {
            let until = fronts[site].map_or(f64::NEG_INFINITY, |front| front.until());
            pair.times().iter().map(move |t| *t < until)
        };
        let before = (0..pair.sites()).flat_map(early).zip(&pair.known);
        let quiet: Vec<bool> = before.map(|(early, known)| early && *known).collect();
        let kept = left.iter().zip(&quiet);
        let kept = kept.map(|(v, quiet)| if *quiet { *v } else { 0.0 });
        let kept: Vec<f64> = kept.collect();
        let before = pair.noise_of(&kept, &quiet);
        // What is left of fronts may be no noise.
        if before.independent() > QUIET && before.sigma < CLEAN * pair.noise.sigma {
            let sigma = before.sigma;
            let sigmas = before.sigmas.iter().map(|own| own.max(sigma)).collect();
            pair.noise = Noise { sigmas, ..before };
            pair.is_quiet = true;
        }
        let told =
            |(site, front): (usize, Option<Front>)| pair.told(site, front.filter(|_| !is_exact)?);
        pair.fronts = fronts.into_iter().enumerate().map(told).collect();
        pair
    }

    fn times(&self) -> &[f64] {
        &self.records.times
    }

    fn sites(&self) -> usize {
        self.records.bodies.len()
    }

    fn of_site<'v, T>(&self, values: &'v [T], site: usize) -> &'v [T] {
        let n = self.times().len();
        &values[n * site..n * (site + 1)]
    }

    fn measured(&self, site: usize) -> &[f64] {
        self.of_site(&self.measured, site)
    }

    fn run(&self, site: usize) -> &[f64] {
        self.of_site(&self.run, site)
    }

    fn known(&self, site: usize) -> &[bool] {
        self.of_site(&self.known, site)
    }

    fn curve(&self, site: usize) -> Curve<'_> {
        Curve {
            times: self.times(),
            values: self.of_site(self.whole, site),
        }
    }

    fn noise_of(&self, left: &[f64], known: &[bool]) -> Noise {
        let none = Linear {
            columns: &[],
            lower: &[],
            sites: self.sites(),
            times: self.times().len(),
        };
        Noise::of(left, known, &none)
    }

    /// What the run leaves of a record; as late and as large as a front, if one is given.
    fn left(&self, site: usize, front: Option<Front>) -> Vec<f64> {
        let (delay, size) = front.map_or((0.0, 1.0), |front| (front.delay, front.size));
        let curve = self.curve(site);
        let (times, measured, known) = (self.times(), self.measured(site), self.known(site));
        let beyond = |i: usize| match known[i] {
            true => measured[i] - size * curve.at(times[i] - delay)[0],
            false => 0.0,
        };
        (0..times.len()).map(beyond).collect()
    }

    /// A delay that is not told but beyond its error is one of noise.
    fn told(&self, site: usize, front: Front) -> Option<(Front, Told)> {
        let (curve, known) = (self.curve(site), self.known(site));
        let noise = Noise {
            sigmas: vec![self.noise.sigmas[site]],
            sigma: self.noise.sigmas[site],
            ..self.noise.clone()
        };
        let record = (self.measured(site), known);
        let told = |front: &Front| front.told(&curve, record, &noise, self.records.step());
        let found = told(&front)?;
        if found.is_late || front.delay.abs() <= TOLD * found.delay_error {
            return Some((front, found));
        }
        let front = front.at(0.0, &curve, self.measured(site), known);
        Some((front, told(&front)?))
    }

    /// The front of a record that is late, or of another size.
    fn differs(&self, site: usize) -> Option<(Front, Told)> {
        self.fronts[site].filter(|(_, told)| told.is_late || told.is_other)
    }

    fn body(&self, site: usize) -> AtBody {
        let largest = |of: &[f64]| of.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let energy = square(self.measured(site)).max(f64::MIN_POSITIVE);
        let peak = largest(self.curve(site).values);
        let nothing = AtBody {
            body: self.records.bodies[site],
            noise: self.noise.sigmas[site],
            arrival: [f64::NAN; 2],
            arrival_error: f64::NAN,
            is_late: false,
            peak: [f64::NAN, peak],
            peak_error: f64::NAN,
            is_other: false,
            residual: square(&self.left(site, None)) / energy,
        };
        let Some((front, told)) = self.fronts[site] else {
            return nothing;
        };
        let there = |value: f64| if told.is_there { value } else { f64::NAN };
        AtBody {
            arrival: [there(front.arrival + front.delay), front.arrival],
            arrival_error: there(told.delay_error),
            is_late: told.is_late,
            peak: [front.size * peak, peak],
            peak_error: told.size_error * peak,
            is_other: told.is_other,
            ..nothing
        }
    }
}
