//! Dispersion read off `S(k, f)`: ridges of its branches, their velocities, and laws fitted to them.
//!
//! A ridge is a row of peaks of cuts through the spectrum: along k at each frequency, or along f at each
//! wavenumber. A peak is one only if it stands above the noise, above what stronger waves leak, and apart
//! from them.
//!
//! Sources: the place of a peak between bins, M. Gasior, J. L. Gonzalez, AIP Conf. Proc. 732, 276 (2004), with
//! the window's own correction; levels of averaged periodograms, Bendat and Piersol (2010), section 8.5;
//! branches joined by where they lead, R. J. McAulay, T. F. Quatieri, IEEE Trans. ASSP 34, 744 (1986).

mod branches;
mod fit;
mod lobe;
mod peaks;
mod sheet;

use std::f64::consts::TAU;

use ndarray::Array2;

use crate::analyze::{self, Analysis, DispersionCurve, Request, Results, Scaling, Welch};
use crate::arrays::{Collect, LargeArray};
use crate::diagnostics::{MAP_LIMIT, MapBuilder};
use crate::error::{Error, Result};
use crate::estimates::realisations::{
    FILLED, Realisations, TOGETHER, share_that_counts, steadiness_of_field,
};
use crate::estimates::{Averaging, Independence, Tapers, check_significance, first_of};
use crate::field::Field;
use crate::observer::Observer;
use crate::prepare::{Detrend, Gaps, Window};
use crate::system::check_memory;
use crate::system::memory::half_of_free_memory;
use crate::system::threads::in_pool;
use branches::Point;
pub use fit::{RidgeFit, RidgeLaw, RidgeParameter};
use lobe::Lobe;
use peaks::{Cuts, Peak};

/// Steadiness below which a field is a transient, whose waves come and go: half, as of narrow-band noise at the least.
const STEADY: f64 = 0.5;
/// Bins that the ends of two ridges of one branch are apart at most.
const JOINED: f64 = 3.0;
/// Share of a ridge's points that another follows from which on both are the same.
const COVERED: f64 = 0.5;

/// Along which axis peaks are looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RidgeCut {
    /// Along k, at each frequency: for branches that are steep in bins.
    Frequency,
    /// Along f, at each wavenumber: for branches that are flat in bins.
    Wavenumber,
}

impl RidgeCut {
    /// Of what is so across the cuts and along them, what is so of frequencies and of wavenumbers; and the other way around.
    fn sorted<T>(self, [across, along]: [T; 2]) -> [T; 2] {
        match self {
            RidgeCut::Frequency => [across, along],
            RidgeCut::Wavenumber => [along, across],
        }
    }
}

/// What ridges are read off, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct RidgesRequest {
    /// Samples a segment; `None`: the power of two at or below a quarter of the record, the whole record where
    /// it has fewer than 512 samples.
    pub segment: Option<usize>,
    /// Samples that neighbouring segments share; `None`: half a segment.
    pub overlap: Option<usize>,
    pub window_time: Window,
    /// [`Window::None`] for sites around a ring, whose waves fit.
    pub window_space: Window,
    /// Removed from each segment.
    pub detrend: Detrend,
    pub gaps: Gaps,
    /// `None`: both, each where it is sharper; at each wavenumber alone without a window along space.
    pub cut: Option<RidgeCut>,
    /// Probability by which noise has a peak anywhere in the spectrum.
    pub alpha: f64,
    /// Peaks that are weaker than the largest power by more than this, in decibels, are none.
    pub range: f64,
    /// Points of a ridge, at least.
    pub fewest: usize,
    /// Laws that are fitted to the ridges.
    pub laws: Vec<RidgeLaw>,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

impl Default for RidgesRequest {
    fn default() -> Self {
        RidgesRequest {
            segment: None,
            overlap: None,
            window_time: Window::USUAL,
            window_space: Window::USUAL,
            detrend: Detrend::Mean,
            gaps: Gaps::Refuse,
            cut: None,
            alpha: 0.01,
            range: 60.0,
            fewest: 8,
            laws: Vec::new(),
            threads: None,
            memory: None,
        }
    }
}

/// A point of a ridge. Velocities are NaN where they are not defined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RidgePoint {
    pub cut: RidgeCut,
    /// In cycles; its error is 0 where the cut is at a frequency.
    pub frequency: f64,
    pub frequency_error: f64,
    /// In rad, with its sign; its error is 0 where the cut is at a wavenumber.
    pub wavenumber: f64,
    pub wavenumber_error: f64,
    /// Power spectral density at the peak, and of the noise about it.
    pub power: f64,
    pub noise: f64,
    /// Full width at half maximum along the cut, in rad or in cycles.
    pub width: f64,
    /// `2 pi f / k`.
    pub phase_velocity: f64,
    pub phase_velocity_error: f64,
    /// `2 pi df / dk`.
    pub group_velocity: f64,
    pub group_velocity_error: f64,
}

/// Points of one branch, by rising frequency or wavenumber of their cuts.
#[derive(Debug, Clone, PartialEq)]
pub struct Ridge {
    /// Ridges whose ends meet are of one branch.
    pub branch: usize,
    pub cut: RidgeCut,
    pub points: Vec<RidgePoint>,
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Ridges {
    /// The spectrum's axes, conventions and map; of the first field where there are several. Its dispersion
    /// curves are the ridges and the fitted laws.
    pub analysis: Analysis,
    /// Of the site at which half of the energy lies at sites that are less steady. What a single transient says has no errors:
    /// those of its points and fits are NaN.
    pub independence: Independence,
    pub alpha: f64,
    /// The power that a peak must exceed, over the mean of the noise about it.
    pub level: f64,
    /// Bins of frequency, in cycles, and of wavenumber, in rad.
    pub bins: [f64; 2],
    /// Width at half maximum of one wave, in the same units.
    pub resolution: [f64; 2],
    pub ridges: Vec<Ridge>,
    /// Where there is no ridge: frequency and wavenumber of peaks above the level, of too few neighbours to be one, as tones have
    /// them; to a bin, the largest first.
    pub lone: Vec<[f64; 2]>,
    pub fits: Vec<RidgeFit>,
}

impl Ridges {
    /// How many branches there are.
    pub fn branches(&self) -> usize {
        let numbers = self.ridges.iter().map(|ridge| ridge.branch + 1);
        numbers.max().unwrap_or(0)
    }

    /// Whether the fields are one realisation, such as a transient: then nothing has an error.
    pub fn is_single(&self) -> bool {
        let steadiness = self.independence.steadiness;
        self.independence.records < 2 && (steadiness.is_nan() || steadiness < STEADY)
    }

    /// Errors by noise and spread are none of a single transient's, which is as it is.
    fn strike_errors(&mut self) {
        for point in self.ridges.iter_mut().flat_map(|ridge| &mut ridge.points) {
            point.frequency_error = f64::NAN;
            point.wavenumber_error = f64::NAN;
            point.phase_velocity_error = f64::NAN;
            point.group_velocity_error = f64::NAN;
        }
        for fit in &mut self.fits {
            fit.reduced = f64::NAN;
            fit.parameters.iter_mut().for_each(|p| p.error = f64::NAN);
        }
    }

    pub fn points(&self) -> impl Iterator<Item = &RidgePoint> {
        self.ridges.iter().flat_map(|ridge| &ridge.points)
    }
}

/// Ridges of the space-time spectra of fields with the same axes, which are averaged.
///
/// ```text
/// peak of a cut:   S > level * noise,   P(F_{2 K, 2 K n / pi} > level) = alpha / cells,
///                  noise = median of n cells / median(chi2_{2 K} / 2 K),
/// f, k:            top of the parabola through ln S of three bins, corrected for the window; of the cut, f (or k) plus the
///                  variance of the window's lobe times d ln S / df: the mean of what the window spreads into it,
/// group velocity:  2 pi df/dk of a parabola through the points about it, by least squares,
/// phase velocity:  2 pi f / k.
/// ```
///
/// `S(k, f)` is one-sided in f and signed in k; K counts the independent realisations. A peak 60 dB below
/// the largest power, one that a stronger wave's leakage explains within a factor of 4, or a bump of a broad ridge, is none. Errors are those of
/// noise, or the spread of neighbouring points if that is larger.
///
/// Units: f in cycles and k in rad per unit of the axes; velocities in units of length over units of time.
///
/// # Errors
/// [`Error::Request`] for no field, fields with different axes, fewer than 8 sites, segments and probabilities
/// that do not fit, and laws that cannot be fitted; [`Error::Memory`]; [`Error::NonFinite`];
/// [`Error::Cancelled`].
///
/// # Source
/// See [the module](self).
pub fn ridges(
    fields: &[&Field],
    request: &RidgesRequest,
    observer: &dyn Observer,
) -> Result<Ridges> {
    let first = first_of(fields)?;
    if first.n_sites() < 8 {
        let found = format!("{} in {}", first.n_sites(), first.name);
        return Err(Error::request("field", "at least 8 sites", found));
    }
    check_significance(request.alpha)?;
    if !(request.range > 0.0 && request.range <= 300.0) {
        let expected = "a range above 0 and up to 300 dB";
        return Err(Error::request("range", expected, request.range));
    }
    if request.fewest < 5 {
        let expected = "at least 5 points, which a slope needs";
        return Err(Error::request("points", expected, request.fewest));
    }
    let averaging = Averaging {
        segment: Some(request.segment.unwrap_or(match first.n_times() {
            short @ ..512 => short,
            long => 1 << (long / 4).ilog2(),
        })),
        overlap: request.overlap,
        tapers: Tapers::Window(request.window_time),
        detrend: request.detrend,
    };
    let realisations = Realisations::new(&averaging, first.n_times())?;
    let (segments, effective) = (realisations.segments, realisations.effective());
    let cells = (segments.length / 2 + 1) as u64 * first.n_sites() as u64;
    let allowed = request.memory.unwrap_or_else(half_of_free_memory);
    // The spectrum, its transpose, and that of another field.
    let held = 8 * cells * (2 + u64::from(fields.len() > 1));
    let what = "the space-time spectrum, which is held (shorter segments need less),";
    check_memory(what, held, Some(allowed))?;
    let asked = Request {
        results: Results {
            spacetime: true,
            ..Results::NONE
        },
        gaps: request.gaps,
        detrend_time: request.detrend,
        window_time: request.window_time,
        window_space: request.window_space,
        scaling: Scaling::Density,
        welch: (segments.length < segments.record).then_some(Welch {
            segment: segments.length,
            overlap: segments.length - segments.hop,
        }),
        dispersion: Some(Vec::new()),
        threads: request.threads,
        memory: Some(allowed - held),
        ..Request::default()
    };
    let spectrum_of = |field: &Field| -> Result<(Analysis, Array2<f64>)> {
        let collect = Collect::default();
        let plan = analyze::plan(field, &asked)?;
        let analysis = analyze::run(field, &plan, &collect, observer)?;
        let mut arrays = collect.into_arrays();
        let spectrum = arrays.remove(&LargeArray::SPACETIME_SPECTRUM);
        Ok((analysis, spectrum.unwrap_or_default()))
    };
    let (mut analysis, mut power) = spectrum_of(first)?;
    for field in &fields[1..] {
        let (other, spectrum) = spectrum_of(field)?;
        // Powers are stored in units of its square.
        let [unit, own] = [&other, &analysis].map(|of| of.accuracy.amplitude_unit);
        let factor = (unit / own).powi(2);
        power.zip_mut_with(&spectrum, |a, b| *a += factor * b);
    }
    if fields.len() > 1 {
        let count = fields.len() as f64;
        power.par_mapv_inplace(|p| p / count);
        if let Some(map) = &mut analysis.spacetime_map {
            let mut builder = MapBuilder::largest(power.dim(), MAP_LIMIT);
            builder.add(0, 0, power.view());
            let axes = &analysis.axes;
            let step = |bins: &[f64]| bins.get(1).copied().unwrap_or(1.0);
            let lowest = axes.wavenumber_signed.first().copied().unwrap_or(0.0);
            let y = (&map.y.label[..], 0.0, step(&axes.frequency));
            let x = (&map.x.label[..], lowest, step(&axes.wavenumber));
            *map = builder.finish(map.label.clone(), y, x);
        }
        analysis.direction_by_frequency = None;
    }
    let number = [fields.len(), segments.count(), 1];
    in_pool(request.threads, || {
        let steadiness = fields.iter().map(|field| {
            let starts = (0..field.n_sites()).step_by(TOGETHER);
            let blocks = starts.map(|from| from..field.n_sites().min(from + TOGETHER));
            steadiness_of_field(field, blocks, FILLED)
        });
        let steadiness = steadiness.sum::<f64>() / fields.len() as f64;
        let independence = Independence::new(number, effective, steadiness, segments.record);
        search(request, analysis, &power, (independence, segments.record))
    })
}

/// A ridge in bins, and what it is read off.
struct Found {
    cut: RidgeCut,
    points: Vec<Point>,
}

/// Ridges of the spectrum `[frequency, signed wavenumber]`.
fn search(
    request: &RidgesRequest,
    mut analysis: Analysis,
    power: &Array2<f64>,
    (independence, samples): (Independence, usize),
) -> Result<Ridges> {
    let (axes, segment) = (&analysis.axes, analysis.conventions.segment);
    let spectrum = power.rows().into_iter().skip(1).map(|row| row.sum());
    let counting = share_that_counts(independence.steadiness, samples, (spectrum, segment));
    let realisations = (independence.effective * counting).max(1.0);
    let (nf, nk) = power.dim();
    let df = 1.0 / (segment as f64 * axes.time.step.abs());
    let dk = TAU / (nk as f64 * axes.space.step.abs());
    let lowest = axes.wavenumber_signed.first().copied().unwrap_or(0.0);
    let along_f = Lobe::new(request.window_time, segment);
    let along_k = Lobe::new(request.window_space, axes.n_sites);
    // Neither the mean with its main lobe nor the Nyquist lines, which have no direction.
    let frequencies = (along_f.half.ceil() as usize).min(nf)..(segment.div_ceil(2)).min(nf);
    let wavenumbers = usize::from(nk.is_multiple_of(2))..nk;
    let tried = match request.cut {
        Some(cut) => vec![cut],
        None if request.window_space == Window::None => vec![RidgeCut::Wavenumber],
        None => vec![RidgeCut::Frequency, RidgeCut::Wavenumber],
    };
    let largest = power.iter().fold(0.0, |m: f64, p| m.max(*p));
    let least = largest * 10f64.powf(-0.1 * request.range);
    let level_of = |places: usize| peaks::level(power.len(), places, request.alpha, realisations);
    let level_at = |cut: &RidgeCut| level_of(cut.sorted([nk, nf])[0]);
    let (mut found, mut lone) = (Vec::new(), Vec::new());
    for cut in &tried {
        let [power, _] = cut.sorted([power.view(), power.t()]);
        let power = power.as_standard_layout();
        let [across, along] = cut.sorted([&along_f, &along_k]);
        let [cuts, places] = cut.sorted([frequencies.clone(), wavenumbers.clone()]);
        let [around_across, around_along] = cut.sorted([None, Some(nk)]);
        let cuts = Cuts {
            power: power.view(),
            along,
            across,
            realisations,
            level: level_at(cut),
            least,
            around: [around_along, around_across],
            cuts,
            places,
        };
        let rows = branches::joined(&cuts.peaks(), power.ncols()).into_iter();
        let (ridges, short): (Vec<_>, Vec<_>) = rows.partition(|row| row.len() >= request.fewest);
        found.extend(ridges.iter().map(|branch| Found {
            cut: *cut,
            points: branches::smooth(branch, across.variance),
        }));
        if *cut == tried[0] {
            // The largest of each row that is too short to be a ridge.
            let by_power = |a: &Peak, b: &Peak| a.power.total_cmp(&b.power);
            let largest = |row: Vec<Peak>| row.into_iter().max_by(by_power);
            lone = short.into_iter().filter_map(largest).collect();
            lone.sort_by(|a, b| by_power(b, a));
        }
    }
    if !found.is_empty() {
        lone.clear();
    }
    let place = |peak: &Peak| {
        let [m, j] = tried[0].sorted([peak.cut as f64, peak.at]);
        [m * df, lowest + j * dk]
    };
    let lone: Vec<[f64; 2]> = lone.iter().map(place).collect();
    if tried.len() > 1 {
        found = sharpest(found, request.fewest);
    }
    let ridge = |(found, branch): (&Found, usize)| Ridge {
        branch,
        cut: found.cut,
        points: found
            .points
            .iter()
            .map(|point| placed(found.cut, point, [df, dk], lowest))
            .collect(),
    };
    let ridges: Vec<Ridge> = found.iter().zip(numbered(&found)).map(ridge).collect();
    let site = axes.space.step.abs();
    let all: Vec<RidgePoint> = ridges.iter().flat_map(|r| r.points.clone()).collect();
    // Neighbouring cuts share what the window spreads into both.
    let shared = all
        .iter()
        .map(|point| point.cut.sorted([along_f.shared, along_k.shared])[0]);
    let shared = shared.sum::<f64>() / all.len().max(1) as f64;
    let fit = |law: &RidgeLaw| law.fit(&all, site, [df, dk], shared);
    let fits = request.laws.iter().map(fit);
    let fits = fits.collect::<Result<Vec<RidgeFit>>>()?;
    let fitted = fits.iter().map(|fit| fit.curve.clone());
    analysis.dispersion = curve(&ridges).into_iter().chain(fitted).collect();
    let mut found = Ridges {
        analysis,
        independence,
        alpha: request.alpha,
        level: tried.iter().map(level_at).fold(f64::INFINITY, f64::min),
        bins: [df, dk],
        resolution: [along_f.width * df, along_k.width * dk],
        ridges,
        lone,
        fits,
    };
    if found.is_single() {
        found.strike_errors();
    }
    Ok(found)
}

/// A point of a ridge in the units of the axes.
fn placed(cut: RidgeCut, point: &Point, [df, dk]: [f64; 2], lowest: f64) -> RidgePoint {
    let (peak, slope, slope_error) = (point.peak, point.slope, point.slope_error);
    let [m, j] = bins_of(cut, point);
    let [m_error, j_error] = cut.sorted([0.0, peak.error]);
    let [_, bin] = cut.sorted([df, dk]);
    let (frequency, wavenumber) = (m * df, lowest + j * dk);
    let (frequency_error, wavenumber_error) = (m_error * df, j_error * dk);
    // Where k is no different from 0, there is no velocity.
    let is_known = wavenumber.abs() > (2.0 * wavenumber_error).max(1e-9 * dk);
    let phase_velocity = TAU * frequency / if is_known { wavenumber } else { f64::NAN };
    let relative = (frequency_error / frequency).hypot(wavenumber_error / wavenumber);
    let (group_velocity, group_velocity_error) = match cut {
        RidgeCut::Wavenumber => (TAU * slope * df / dk, TAU * slope_error * df / dk),
        RidgeCut::Frequency => {
            let is_known = slope.abs() > 2.0 * slope_error;
            let velocity = TAU * df / dk / if is_known { slope } else { f64::NAN };
            (velocity, velocity.abs() * slope_error / slope.abs())
        }
    };
    RidgePoint {
        cut,
        frequency,
        frequency_error,
        wavenumber,
        wavenumber_error,
        power: peak.power,
        noise: peak.noise,
        width: peak.width * bin,
        phase_velocity,
        phase_velocity_error: phase_velocity.abs() * relative,
        group_velocity,
        group_velocity_error,
    }
}

/// Place of a point in bins: of frequency, of wavenumber.
fn bins_of(cut: RidgeCut, point: &Point) -> [f64; 2] {
    cut.sorted([point.across, point.peak.at])
}

impl Found {
    /// Places of the first and of the last point.
    fn ends(&self) -> [[f64; 2]; 2] {
        let last = self.points.len() - 1;
        [0, last].map(|i| bins_of(self.cut, &self.points[i]))
    }
}

/// Whether two places are as near as this in both bins.
fn are_near(a: [f64; 2], b: [f64; 2], within: [f64; 2]) -> bool {
    (0..2).all(|i| (a[i] - b[i]).abs() <= within[i])
}

/// Of ridges of both cuts the parts that cross at most a bin from one cut to the next, which are the sharper
/// ones; and others that these do not follow.
fn sharpest(found: Vec<Found>, fewest: usize) -> Vec<Found> {
    let is_sharp = |point: &Point| point.slope.abs() <= 1.0;
    let runs = found.iter().flat_map(|Found { cut, points }| {
        let runs = points.chunk_by(|a, b| is_sharp(a) == is_sharp(b));
        let runs = runs.filter(|run| run.len() >= fewest);
        runs.map(|run| Found {
            cut: *cut,
            points: run.to_vec(),
        })
    });
    let (mut kept, others): (Vec<Found>, Vec<Found>) =
        runs.partition(|run| is_sharp(&run.points[0]));
    let places = |part: &Found| -> Vec<[f64; 2]> {
        let place = |point| bins_of(part.cut, point);
        part.points.iter().map(place).collect()
    };
    let sharp: Vec<[f64; 2]> = kept.iter().flat_map(places).collect();
    let is_new = |part: &Found| {
        let followed = |point: &&Point| {
            let wide = part.cut.sorted([1.5, 1.5 * point.slope.abs().max(1.0)]);
            let at = bins_of(part.cut, point);
            sharp.iter().any(|sharp| are_near(*sharp, at, wide))
        };
        (part.points.iter().filter(followed).count() as f64) < COVERED * part.points.len() as f64
    };
    kept.extend(others.into_iter().filter(is_new));
    kept
}

/// Numbers of branches: ridges whose ends meet share one.
fn numbered(found: &[Found]) -> Vec<usize> {
    let meet = |a: &Found, b: &Found| {
        let (own, others) = (a.ends(), b.ends());
        let is_met = |p: &[f64; 2]| others.iter().any(|q| are_near(*p, *q, [JOINED; 2]));
        a.cut != b.cut && own.iter().any(is_met)
    };
    // That of the first ridge of each branch.
    let mut first: Vec<usize> = (0..found.len()).collect();
    for a in 0..found.len() {
        for b in (0..a).filter(|b| meet(&found[a], &found[*b])) {
            let (from, to) = (first[a].max(first[b]), first[a].min(first[b]));
            let joined = first.iter_mut().filter(|n| **n == from);
            joined.for_each(|n| *n = to);
        }
    }
    let rank = |n: &usize| (0..*n).filter(|i| first[*i] == *i).count();
    first.iter().map(rank).collect()
}

/// Ridges as one curve over the spectrum.
fn curve(ridges: &[Ridge]) -> Option<DispersionCurve> {
    let places = |ridge: &Ridge| {
        let points = ridge.points.iter().map(|p| (p.wavenumber, p.frequency));
        // A gap to the next one.
        points.chain([(f64::NAN, f64::NAN)]).collect::<Vec<_>>()
    };
    let (wavenumber, frequency) = ridges.iter().flat_map(places).unzip();
    (!ridges.is_empty()).then(|| DispersionCurve {
        name: "ridges".into(),
        wavenumber,
        branches: vec![frequency],
    })
}
