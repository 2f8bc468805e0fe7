//! Power laws of spectra: slope over a band, breaks, slope against time, steepening.

mod breaks;
mod frames;
mod sheet;
mod steepening;

pub use breaks::BreakFit;
pub use frames::SlopeFrames;
pub use steepening::Steepening;

use num_complex::Complex;

use crate::error::{Error, Result};
use crate::estimates::realisations::{
    Averaging, Realisations, SegmentScratch, Shots, TOGETHER, Tapers, check_significance, first_of,
    refuse_left_out,
};
use crate::estimates::{FieldAxis, IntervalBasis, SIGNIFICANCE};
use crate::field::{Axis, Field};
use crate::numeric::{LineFit, at_or_below, mean_of};
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::threads::in_pool;
use crate::transform::{fold, frequencies, wavenumbers};
use breaks::breaks;
use frames::Frame;

/// All choices of [`slope`].
#[derive(Debug, Clone, PartialEq, smart_default::SmartDefault)]
pub struct SlopeRequest {
    /// Of the spectrum over wavenumbers, or over frequencies.
    #[default(FieldAxis::Space)]
    pub axis: FieldAxis,
    /// Wavenumbers in rad per unit of length, or frequencies in cycles per unit of time.
    #[default((0.0, f64::INFINITY))]
    pub band: (f64, f64),
    /// Breaks that are searched in the band, at most 2.
    #[default(1)]
    pub breaks: usize,
    /// Frames of times with a slope of their own; along x alone.
    #[default(64)]
    pub frames: usize,
    /// Along x a segment is by default all sites.
    pub averaging: Averaging,
    /// Along x, snapshots with gaps are left out instead.
    pub gaps: Gaps,
    /// Intervals hold with probability `1 - alpha`, and breaks are accepted below `alpha`.
    #[default(SIGNIFICANCE)]
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

/// What [`slope`] finds.
#[derive(Debug, Clone)]
pub struct Slope {
    pub axis: FieldAxis,
    pub time: Axis,
    pub space: Axis,
    /// Unit of the samples.
    pub unit: Option<String>,
    pub shots: usize,
    pub alpha: f64,
    /// Samples a segment, and shared by neighbours.
    pub segment: [usize; 2],
    /// Snapshots with missing samples, which are left out.
    pub left_out: u64,
    /// Wavenumbers in rad per unit of length, or frequencies in cycles per unit of time.
    pub abscissa: Vec<f64>,
    /// One-sided power spectral density, mean of all sites or times and of all shots.
    pub spectrum: Vec<f64>,
    pub law: PowerLaw,
    /// Accepted breaks.
    pub breaks: Option<BreakFit>,
    /// Along x alone.
    pub frames: Option<SlopeFrames>,
    pub steepening: Option<Steepening>,
}

/// `S = prefactor x^slope` over a band.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PowerLaw {
    /// First and last bin of the fit.
    pub band: [f64; 2],
    pub points: usize,
    pub slope: f64,
    /// Half of its interval: over shots, or of the regression.
    pub half: f64,
    pub basis: IntervalBasis,
    pub prefactor: f64,
    /// Root mean square of the residuals of `ln S`.
    pub scatter: f64,
}

impl Slope {
    /// `S x^{-slope} / prefactor`: 1 where the law holds.
    pub fn compensated(&self) -> Vec<f64> {
        let law = |x: f64| self.law.prefactor * x.powf(self.law.slope);
        let pairs = self.abscissa.iter().zip(&self.spectrum);
        pairs.map(|(x, s)| s / law(*x)).collect()
    }
}

/// The slope of a spectrum over a band, in double logarithmic scales.
///
/// # Equation
/// Least squares of `ln S = a + m ln x` over the bins of the band, each with the same weight,
///
/// ```text
/// m = sum (ln x - <ln x>) ln S / sum (ln x - <ln x>)^2.
/// ```
///
/// S is the mean one-sided power spectral density of all sites over frequencies f, or of all times over
/// wavenumbers k (`integral S dk = <v^2>`). Over several shots the interval is that of the mean of their slopes;
/// of one it is that of the regression, from its residuals alone, and is called so. Breaks are those of a
/// continuous line of several pieces, accepted by an F-test that counts all places that were tried.
///
/// # Shapes
/// Each field is one record of every site (a shot); all have the same axes.
///
/// # Units
/// S: square of the samples' unit, times time or length over rad.
///
/// # Errors
/// [`Error::Request`] for fields with different axes, bands with fewer than three bins of power, more than two breaks, segments
/// that do not fit; [`Error::NonFinite`]; [`Error::Memory`]; [`Error::Cancelled`]; [`Error::Failed`].
///
/// # Source
/// N. R. Draper, H. Smith, "Applied Regression Analysis" (1998), chapter 1; V. M. R. Muggeo, Stat. Med. 22, 3055
/// (2003) for lines with breaks.
pub fn slope(fields: &[&Field], request: &SlopeRequest, observer: &dyn Observer) -> Result<Slope> {
    let first = first_of(fields)?;
    let n = request.axis.of([first.n_sites(), first.n_times()]);
    let mut averaging = request.averaging.clone();
    if request.axis == FieldAxis::Space && matches!(averaging.tapers, Tapers::Window(_)) {
        averaging.segment = averaging.segment.or(Some(n));
    }
    let realisations = &Realisations::new(&averaging, n)?;
    let breaks = request.breaks;
    Error::require(breaks <= 2, "breaks", "0, 1 or 2 breaks", breaks)?;
    check_significance(request.alpha)?;
    let length = realisations.segments.length;
    let abscissa = request.axis.of([
        wavenumbers(length, first.space.step.abs()),
        frequencies(length, first.time.step),
    ]);
    let (from, to) = request.band;
    let is_inside = |x: f64| at_or_below(from, x) && at_or_below(x, to) && x > 0.0;
    let bins = (0..abscissa.len()).filter(|m| is_inside(abscissa[*m]));
    let bins: Vec<usize> = bins.collect();
    let [apart, last] = [1, abscissa.len() - 1].map(|m| abscissa[m]);
    let expected =
        format!("a band with three or more of the bins, which are {apart} apart, up to {last}");
    let found = format!("{from}:{to} with {}", bins.len());
    Error::require(bins.len() >= 3, "band", expected, found)?;
    let work = Work {
        fields,
        first,
        request,
        realisations,
        abscissa: &abscissa,
        bins: &bins,
        observer,
    };
    in_pool(request.threads, || work.run())
}

struct Work<'a> {
    fields: &'a [&'a Field],
    first: &'a Field,
    request: &'a SlopeRequest,
    realisations: &'a Realisations,
    abscissa: &'a [f64],
    /// Those of the band.
    bins: &'a [usize],
    observer: &'a dyn Observer,
}

impl Work<'_> {
    /// Logarithms of the bins of the band, and of the powers there.
    fn points(&self, spectrum: &[f64]) -> Vec<(f64, f64)> {
        let bins = self.bins.iter().filter(|m| spectrum[**m] > 0.0);
        let logs = bins.map(|m| (self.abscissa[*m].ln(), spectrum[*m].ln()));
        logs.collect()
    }

    fn run(&self) -> Result<Slope> {
        let alpha = self.request.alpha;
        let (spectra, frames, left_out) = match self.request.axis {
            FieldAxis::Time => (self.in_time()?, None, 0),
            FieldAxis::Space => {
                let found = self.fields.iter().map(|field| self.in_frames(field));
                let found: Vec<Vec<Frame>> = found.collect::<Result<_>>()?;
                let spectra: Vec<Vec<f64>> = found.iter().map(|one| Frame::mean(one)).collect();
                let used: u64 = found.iter().flatten().map(|frame| frame.snapshots).sum();
                let all = self.fields.len() * self.first.n_times();
                let left_out = all as u64 - used;
                (spectra, Some(self.joined(&found)), left_out)
            }
        };
        let spectrum = mean_spectrum(&spectra);
        let all = self.points(&spectrum);
        let (expected, found) = ("a band with three or more bins of power", all.len());
        let refused = || Error::request("band", expected, format!("{found} of them"));
        let line = LineFit::through(&all).ok_or_else(refused)?;
        let slope = |one: &Vec<f64>| Some(LineFit::through(&self.points(one))?.slope);
        let of_shots: Vec<f64> = spectra.iter().filter_map(slope).collect();
        // A window gives neighbouring bins a part in common.
        let of_line = || line.half_interval_of(alpha, self.realisations.shared_bins());
        let (half, basis) = match mean_of(&of_shots, alpha) {
            Some((_, half)) => (half, IntervalBasis::Shots),
            None => (of_line(), IntervalBasis::Regression),
        };
        let steepening = frames.as_ref();
        let steepening = steepening.and_then(|frames| Steepening::of(frames, self));
        let segments = self.realisations.segments;
        Ok(Slope {
            axis: self.request.axis,
            time: self.first.time.clone(),
            space: self.first.space.clone(),
            unit: self.first.unit.clone(),
            shots: self.fields.len(),
            alpha,
            segment: [segments.length, segments.length - segments.hop],
            left_out,
            abscissa: self.abscissa.to_vec(),
            spectrum,
            law: PowerLaw {
                band: [all[0].0.exp(), all[all.len() - 1].0.exp()],
                points: line.points,
                slope: line.slope,
                half,
                basis,
                prefactor: line.intercept.exp(),
                scatter: (line.squares / line.points as f64).sqrt(),
            },
            breaks: breaks(&all, self.request.breaks, alpha),
            frames,
            steepening,
        })
    }

    /// The mean spectrum of all sites, of each shot.
    fn in_time(&self) -> Result<Vec<Vec<f64>>> {
        let realisations = self.realisations;
        let (gaps, memory) = (self.request.gaps, self.request.memory);
        refuse_left_out(gaps, "the mean spectrum of all sites")?;
        let reached = realisations.reached();
        let shots = Shots::new(self.fields, gaps, memory, reached, self.observer)?;
        let (bins, samples) = (realisations.bins(), self.first.n_times() as u64);
        let threads = rayon::current_num_threads() as u64;
        let tile =
            TOGETHER as u64 * (8 * samples + 16 * bins as u64) + realisations.working_bytes();
        let held = threads * tile + 8 * (bins * (shots.tiles() + self.fields.len())) as u64;
        let block = shots.block("the spectra of this field", held)?;
        let mut found = Vec::new();
        shots.each(block, |shot| {
            let mut tiles = vec![vec![0.0; bins]; shots.tiles()];
            shot.each_tile(
                "spectra",
                &mut tiles,
                |scratch: &mut SegmentScratch, sites, records, sums| {
                    realisations.each(records, scratch, |_, spectra| {
                        add_powers(sums, spectra, sites.len());
                    });
                },
            )?;
            let sum = |m: usize| tiles.iter().map(|tile| tile[m]).sum::<f64>();
            found.push((0..bins).map(sum).collect::<Vec<f64>>());
            Ok(())
        })?;
        let count = (realisations.count() * self.first.n_sites()) as f64;
        let density = self.first.time.step / count;
        for spectrum in &mut found {
            for (m, value) in spectrum.iter_mut().enumerate() {
                *value *= density * fold(m, realisations.segments.length);
            }
        }
        Ok(found)
    }
}

/// Adds the powers of `width` records to the sum of each bin.
fn add_powers(sums: &mut [f64], spectra: &[Complex<f64>], width: usize) {
    for (sum, row) in sums.iter_mut().zip(spectra.chunks_exact(width)) {
        *sum += row.iter().map(|x| x.norm_sqr()).sum::<f64>();
    }
}

fn mean_spectrum(spectra: &[impl AsRef<[f64]>]) -> Vec<f64> {
    let bins = 0..spectra.first().map_or(0, |one| one.as_ref().len());
    let sum = |m: usize| spectra.iter().map(|one| one.as_ref()[m]).sum::<f64>();
    bins.map(|m| sum(m) / spectra.len() as f64).collect()
}
