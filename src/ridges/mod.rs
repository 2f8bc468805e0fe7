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
mod single;

use std::f64::consts::TAU;
use std::ops::Range;

use ndarray::Array2;

use crate::analyze::{self, Analysis, DispersionCurve, Request, Results, Scaling, Welch};
use crate::arrays::{Collect, LargeArray};
use crate::diagnostics::{MAP_LIMIT, MapBuilder};
use crate::error::{Error, Result};
use crate::estimates::{Averaging, Independence};
use crate::field::Field;
use crate::observer::Observer;
use crate::prepare::{Detrend, Gaps, Window};
use crate::system::memory::half_of_free_memory;
use crate::system::threads::in_pool;
use branches::Point;
pub use fit::{RidgeFit, RidgeLaw, RidgeParameter};
use lobe::Lobe;
use peaks::{Cuts, Peak};
use single::{is_single, steadiness, without_errors};

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
    /// Fields whose spectra are averaged.
    pub records: usize,
    /// Independent realisations of the average, of noise.
    pub realisations: f64,
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
    /// Whether the fields are one realisation, such as a transient: then nothing has an error.
    pub fn is_single(&self) -> bool {
        is_single(&self.independence)
    }

    /// How many branches there are.
    pub fn branches(&self) -> usize {
        self.ridges
            .iter()
            .map(|ridge| ridge.branch + 1)
            .max()
            .unwrap_or(0)
    }

    pub fn points(&self) -> impl Iterator<Item = &RidgePoint> {
        self.ridges.iter().flat_map(|ridge| &ridge.points)
    }
}

/// Ridges of the space-time spectra of fields with the same axes, which are averaged.
///
/// ```text
/// peak of a cut:   S > level * noise,   P(chi2_{2 K} / 2 K > level) = alpha / cells,
///                  noise = median / median(chi2_{2 K} / 2 K),
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
    let first = checked(fields, request)?;
    let averaging = Averaging {
        segment: Some(request.segment.unwrap_or(match first.n_times() {
            short @ ..512 => short,
            long => 1 << (long / 4).ilog2(),
        })),
        overlap: request.overlap,
        tapers: crate::estimates::Tapers::Window(request.window_time),
        detrend: request.detrend,
    };
    let (segments, effective) = averaging.independent(first.n_times())?;
    let realisations = effective * fields.len() as f64;
    let cells = (segments.length / 2 + 1) as u64 * first.n_sites() as u64;
    let allowed = request.memory.unwrap_or_else(half_of_free_memory);
    // The spectrum, its transpose, and that of another field.
    let held = 8 * cells * (2 + u64::from(fields.len() > 1));
    if held >= allowed {
        let what = "the space-time spectrum, which is held (shorter segments need less),";
        return Err(Error::Memory {
            what,
            needed: held,
            allowed,
        });
    }
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
    let mut sum: Option<(Analysis, Array2<f64>)> = None;
    for field in fields {
        let collect = Collect::default();
        let plan = analyze::plan(field, &asked)?;
        let analysis = analyze::run(field, &plan, &collect, observer)?;
        let spectrum = collect
            .into_arrays()
            .remove(&LargeArray::SPACETIME_SPECTRUM);
        let spectrum = spectrum.unwrap_or_default();
        // Powers are stored in units of its square.
        let unit = |analysis: &Analysis| analysis.accuracy.amplitude_unit;
        match &mut sum {
            None => sum = Some((analysis, spectrum)),
            Some((first, sum)) => {
                let factor = (unit(&analysis) / unit(first)).powi(2);
                sum.zip_mut_with(&spectrum, |a, b| *a += factor * b);
            }
        }
    }
    let Some((mut analysis, mut power)) = sum else {
        return Err(refuse("field", "at least one field".into(), "none".into()));
    };
    if fields.len() > 1 {
        let count = fields.len() as f64;
        power.par_mapv_inplace(|p| p / count);
        remap(&mut analysis, &power);
    }
    in_pool(request.threads, || {
        Search {
            request,
            analysis,
            power,
            realisations,
            independence: Independence::new(
                [fields.len(), segments.count(), 1],
                effective,
                steadiness(fields),
            ),
            segment: segments.length,
        }
        .run()
    })
}

/// The map of an average.
fn remap(analysis: &mut Analysis, power: &Array2<f64>) {
    if let Some(map) = &mut analysis.spacetime_map {
        let mut builder = MapBuilder::largest(power.dim(), MAP_LIMIT);
        builder.add(0, 0, power.view());
        let (x, y) = (&map.x, &map.y);
        *map = builder.finish(
            map.label.clone(),
            (&y.label, y.low, y.high),
            (&x.label, x.low, x.high),
        );
    }
    analysis.direction_by_frequency = None;
}

fn refuse(option: &'static str, expected: String, found: String) -> Error {
    Error::Request {
        option,
        expected,
        found,
    }
}

fn checked<'a>(fields: &[&'a Field], request: &RidgesRequest) -> Result<&'a Field> {
    let first = crate::estimates::first_of(fields)?;
    if first.n_sites() < 8 {
        let found = format!("{} in {}", first.n_sites(), first.name);
        return Err(refuse("field", "at least 8 sites".into(), found));
    }
    if !(request.alpha > 0.0 && request.alpha < 1.0) {
        let expected = "a probability between 0 and 1".to_owned();
        return Err(refuse("significance", expected, request.alpha.to_string()));
    }
    if !(request.range > 0.0 && request.range <= 300.0) {
        let expected = "a range above 0 and up to 300 dB".to_owned();
        return Err(refuse("range", expected, request.range.to_string()));
    }
    if request.fewest < 5 {
        let expected = "at least 5 points, which a slope needs".to_owned();
        return Err(refuse("points", expected, request.fewest.to_string()));
    }
    Ok(first)
}

/// The search for ridges of a spectrum.
struct Search<'a> {
    request: &'a RidgesRequest,
    analysis: Analysis,
    /// `[frequency, signed wavenumber]`
    power: Array2<f64>,
    realisations: f64,
    independence: Independence,
    /// Samples a transform along time.
    segment: usize,
}

/// A ridge in bins, and what it is read off.
struct Found {
    cut: RidgeCut,
    points: Vec<Point>,
}

impl Search<'_> {
    fn run(mut self) -> Result<Ridges> {
        let axes = &self.analysis.axes;
        let (nf, nk) = self.power.dim();
        let df = 1.0 / (self.segment as f64 * axes.time.step.abs());
        let dk = TAU / (nk as f64 * axes.space.step.abs());
        let lowest = axes.wavenumber_signed.first().copied().unwrap_or(0.0);
        let along_f = Lobe::new(self.request.window_time, self.segment);
        let along_k = Lobe::new(self.request.window_space, axes.n_sites);
        // Neither the mean with its main lobe nor the Nyquist lines, which have no direction.
        let frequencies =
            (along_f.half.ceil() as usize).min(nf)..(self.segment.div_ceil(2)).min(nf);
        let wavenumbers = usize::from(nk.is_multiple_of(2))..nk;
        let (by_frequency, by_wavenumber) = match self.request.cut {
            Some(cut) => (cut == RidgeCut::Frequency, cut == RidgeCut::Wavenumber),
            None => (self.request.window_space != Window::None, true),
        };
        let least = 10f64.powf(-0.1 * self.request.range);
        let cuts =
            |power, along, across, cuts: &Range<usize>, places: &Range<usize>, around| Cuts {
                power,
                along,
                across,
                realisations: self.realisations,
                alpha: self.request.alpha,
                least,
                around,
                cuts: cuts.clone(),
                places: places.clone(),
            };
        let around = [Some(nk), None];
        let at_frequencies = cuts(
            self.power.view(),
            &along_k,
            &along_f,
            &frequencies,
            &wavenumbers,
            around,
        );
        let level = at_frequencies.level();
        let (mut found, mut lone) = (Vec::new(), Vec::new());
        if by_frequency {
            let (ridges, peaks) = self.found(&at_frequencies, RidgeCut::Frequency);
            found.extend(ridges);
            lone.extend(peaks);
        }
        if by_wavenumber {
            let transposed = self.power.t();
            let transposed = transposed.as_standard_layout();
            let around = [None, Some(nk)];
            let at_wavenumbers = cuts(
                transposed.view(),
                &along_f,
                &along_k,
                &wavenumbers,
                &frequencies,
                around,
            );
            let (ridges, peaks) = self.found(&at_wavenumbers, RidgeCut::Wavenumber);
            found.extend(ridges);
            if !by_frequency {
                lone.extend(peaks);
            }
        }
        if !found.is_empty() {
            lone.clear();
        }
        lone.sort_by(|a, b| b.1.power.total_cmp(&a.1.power));
        let lone = lone.iter().map(|(cut, peak)| {
            let (across, at) = (peak.cut as f64, peak.at);
            let [m, j] = match cut {
                RidgeCut::Frequency => [across, at],
                RidgeCut::Wavenumber => [at, across],
            };
            [m * df, lowest + j * dk]
        });
        let lone: Vec<[f64; 2]> = lone.collect();
        if by_frequency && by_wavenumber {
            found = sharpest(found, self.request.fewest);
        }
        let branches = numbered(&found);
        let place = |cut, point: &Point| placed(cut, point, [df, dk], lowest);
        let ridges: Vec<Ridge> = found
            .iter()
            .zip(branches)
            .map(|(found, branch)| Ridge {
                branch,
                cut: found.cut,
                points: found
                    .points
                    .iter()
                    .map(|point| place(found.cut, point))
                    .collect(),
            })
            .collect();
        let all: Vec<RidgePoint> = ridges
            .iter()
            .flat_map(|r| r.points.iter().copied())
            .collect();
        let site = axes.space.step.abs();
        let fits = self
            .request
            .laws
            .iter()
            .map(|law| law.fit(&all, site, [df, dk]));
        let fits = fits.collect::<Result<Vec<RidgeFit>>>()?;
        let (mut ridges, mut fits) = (ridges, fits);
        if is_single(&self.independence) {
            without_errors(&mut ridges, &mut fits);
        }
        self.analysis.dispersion = curves(&ridges);
        self.analysis
            .dispersion
            .extend(fits.iter().map(|fit| fit.curve.clone()));
        Ok(Ridges {
            analysis: self.analysis,
            records: self.independence.records,
            realisations: self.realisations,
            independence: self.independence,
            alpha: self.request.alpha,
            level,
            bins: [df, dk],
            resolution: [along_f.width * df, along_k.width * dk],
            ridges,
            lone,
            fits,
        })
    }

    /// Ridges, and the largest peak of each row of peaks that is too short to be one.
    fn found(&self, cuts: &Cuts<'_>, cut: RidgeCut) -> (Vec<Found>, Vec<(RidgeCut, Peak)>) {
        let places = cuts.power.ncols();
        let rows = branches::joined(&cuts.peaks(), places, 1).into_iter();
        let (ridges, lone): (Vec<_>, Vec<_>) =
            rows.partition(|row| row.len() >= self.request.fewest);
        let smooth = ridges
            .iter()
            .map(|branch| branches::smooth(branch, cuts.across.variance));
        let largest = lone.iter().filter_map(|row| {
            let largest = row.iter().max_by(|a, b| a.power.total_cmp(&b.power));
            Some((cut, *largest?))
        });
        (
            smooth.map(|points| Found { cut, points }).collect(),
            largest.collect(),
        )
    }
}

/// A point of a ridge in the units of the axes.
fn placed(cut: RidgeCut, point: &Point, [df, dk]: [f64; 2], lowest: f64) -> RidgePoint {
    let Point {
        peak,
        across,
        slope,
        slope_error,
    } = *point;
    let (at, error) = (peak.at, peak.error);
    let (m, j, f_error, k_error, bin) = match cut {
        RidgeCut::Frequency => (across, at, 0.0, error * dk, dk),
        RidgeCut::Wavenumber => (at, across, error * df, 0.0, df),
    };
    let (frequency, wavenumber) = (m * df, lowest + j * dk);
    let phase_velocity = TAU * frequency / wavenumber;
    let relative = (f_error / frequency).hypot(k_error / wavenumber);
    // Where k is no different from 0, there is no velocity.
    let known = wavenumber.abs() > (2.0 * k_error).max(1e-9 * dk);
    let (group_velocity, group_velocity_error) = match cut {
        RidgeCut::Wavenumber => (TAU * slope * df / dk, TAU * slope_error * df / dk),
        RidgeCut::Frequency if slope.abs() > 2.0 * slope_error => {
            let velocity = TAU * df / (slope * dk);
            (velocity, velocity.abs() * slope_error / slope.abs())
        }
        RidgeCut::Frequency => (f64::NAN, f64::NAN),
    };
    RidgePoint {
        cut,
        frequency,
        frequency_error: f_error,
        wavenumber,
        wavenumber_error: k_error,
        power: peak.power,
        noise: peak.noise,
        width: peak.width * bin,
        phase_velocity: if known { phase_velocity } else { f64::NAN },
        phase_velocity_error: if known {
            phase_velocity.abs() * relative
        } else {
            f64::NAN
        },
        group_velocity,
        group_velocity_error,
    }
}

/// Place of a point in bins: of frequency, of wavenumber.
fn bins_of(cut: RidgeCut, point: &Point) -> [f64; 2] {
    match cut {
        RidgeCut::Frequency => [point.across, point.peak.at],
        RidgeCut::Wavenumber => [point.peak.at, point.across],
    }
}

/// Of ridges of both cuts the parts that cross at most a bin from one cut to the next, which are the sharper
/// ones; and others that these do not follow.
fn sharpest(found: Vec<Found>, fewest: usize) -> Vec<Found> {
    let (mut kept, mut others) = (Vec::new(), Vec::new());
    for Found { cut, points } in found {
        for run in points.chunk_by(|a, b| (a.slope.abs() <= 1.0) == (b.slope.abs() <= 1.0)) {
            let is_sharp = run[0].slope.abs() <= 1.0;
            if run.len() >= fewest {
                let part = Found {
                    cut,
                    points: run.to_vec(),
                };
                if is_sharp {
                    kept.push(part)
                } else {
                    others.push(part)
                }
            }
        }
    }
    let sharp: Vec<[f64; 2]> = kept
        .iter()
        .flat_map(|part: &Found| part.points.iter().map(|point| bins_of(part.cut, point)))
        .collect();
    let is_new = |part: &Found| {
        let followed = |point: &&Point| {
            let [m, j] = bins_of(part.cut, point);
            let slope = point.slope.abs().max(1.0);
            let (wide_m, wide_j) = match part.cut {
                RidgeCut::Frequency => (1.5, 1.5 * slope),
                RidgeCut::Wavenumber => (1.5 * slope, 1.5),
            };
            sharp
                .iter()
                .any(|at| (at[0] - m).abs() <= wide_m && (at[1] - j).abs() <= wide_j)
        };
        (part.points.iter().filter(followed).count() as f64) < COVERED * part.points.len() as f64
    };
    kept.extend(others.into_iter().filter(is_new));
    kept
}

/// Numbers of branches: ridges whose ends meet share one.
fn numbered(found: &[Found]) -> Vec<usize> {
    let mut number: Vec<usize> = (0..found.len()).collect();
    let ends = |part: &Found| {
        let ends = [part.points.first(), part.points.last()]
            .into_iter()
            .flatten();
        ends.map(|point| bins_of(part.cut, point))
            .collect::<Vec<_>>()
    };
    for a in 0..found.len() {
        for b in 0..a {
            let (one, other) = (ends(&found[a]), ends(&found[b]));
            let meet = one.iter().any(|p| {
                other
                    .iter()
                    .any(|q| (p[0] - q[0]).abs() <= JOINED && (p[1] - q[1]).abs() <= JOINED)
            });
            if meet && found[a].cut != found[b].cut && number[a] != number[b] {
                let (from, to) = (number[a].max(number[b]), number[a].min(number[b]));
                number
                    .iter_mut()
                    .filter(|n| **n == from)
                    .for_each(|n| *n = to);
            }
        }
    }
    let mut order: Vec<usize> = Vec::new();
    for n in &number {
        if !order.contains(n) {
            order.push(*n);
        }
    }
    let rank = |n: &usize| order.iter().position(|o| o == n).unwrap_or_default();
    number.iter().map(rank).collect()
}

/// Ridges as curves over the spectrum, all under one name.
fn curves(ridges: &[Ridge]) -> Vec<DispersionCurve> {
    let points: usize = ridges.iter().map(|ridge| ridge.points.len() + 1).sum();
    let mut wavenumber = Vec::with_capacity(points);
    let mut frequency = Vec::with_capacity(points);
    for ridge in ridges {
        for point in &ridge.points {
            wavenumber.push(point.wavenumber);
            frequency.push(point.frequency);
        }
        // A gap to the next one.
        wavenumber.push(f64::NAN);
        frequency.push(f64::NAN);
    }
    match ridges.is_empty() {
        true => Vec::new(),
        false => vec![DispersionCurve {
            name: "ridges".into(),
            wavenumber,
            branches: vec![frequency],
        }],
    }
}
