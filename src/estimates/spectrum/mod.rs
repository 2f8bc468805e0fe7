//! Power spectral densities of all sites with intervals, and lines in them.

mod found;
mod lines;
mod mean;

mod noise;
mod pass;
mod peaks;
mod sheet;

pub use lines::Line;
pub use mean::MeanSpectrum;
pub(crate) use noise::no_noise;
pub use noise::{NoiseFloor, NoiseSource, SiteNoise, SubtractedNoise};
pub use peaks::Peak;

use ndarray::Array2;

use crate::error::{Error, Result};
use crate::estimates::realisations::{
    Averaging, Grid, Independence, Realisations, SegmentsLeft, Shots, check_significance, first_of,
    least_median_most,
};
use crate::estimates::{FieldAxis, SIGNIFICANCE};
use crate::field::{Axis, Field, Quantity};
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::threads::in_pool;
pub(super) use pass::Pass;

/// All choices of [`spectrum`].
#[derive(
    Debug, Clone, PartialEq, smart_default::SmartDefault, serde::Serialize, serde::Deserialize,
)]
pub struct SpectrumRequest {
    /// Time: `S(f)` at each site. Space: `S(k)` at each time, one-sided, per rad, and their mean over time.
    pub along: FieldAxis,
    pub averaging: Averaging,
    /// The whole record as one segment, whatever `averaging` says of segments: under one window, a
    /// periodogram.
    pub is_whole: bool,
    /// Whether several tapers have Thomson's adaptive weights; else all have the same.
    #[default(true)]
    pub is_adaptive: bool,
    /// Whether there is a jackknife, which takes each realisation a second time.
    #[default(true)]
    pub has_jackknife: bool,
    pub gaps: Gaps,
    /// Subtract the noise of each site from its spectrum, along time.
    pub subtract_noise: bool,
    /// Probability by which the true spectrum is outside of its interval, and by which a line is found by
    /// chance.
    #[default(SIGNIFICANCE)]
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    #[serde(skip)]
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    #[serde(skip)]
    pub memory: Option<u64>,
}

/// What a jackknife leaves out, one after another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LeftOutEach {
    /// Each segment under each taper.
    Realisation,
    /// Each record: most sites are transients.
    Record,
}

/// The test for lines, whose statistic has Fisher's distribution where there are none.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct LineTest {
    /// `F`, `(frequency, site)`; NaN at 0 and at the Nyquist frequency.
    #[serde(skip)]
    pub statistic: Array2<f64>,
    /// Its degrees of freedom: of the line, and of what is beside it, at sites without missing samples. Sites from
    /// which segments are left out have their own, and are tested by these.
    #[serde(rename = "degrees_of_freedom")]
    pub degrees: [f64; 2],
    /// What one cell exceeds by chance with probability `alpha`.
    pub level: f64,
    /// What any of all cells exceeds by chance with probability at most `alpha`, at four places of each bin.
    pub level_of_all: f64,
    /// Where F at a quarter of a bin exceeds `level_of_all`, the most certain first: one a band of the tapers.
    pub lines: Vec<Line>,
}

/// What [`spectrum`] finds. Arrays are `(frequency, site)`, or `(wavenumber, time)` along space: read "time" for
/// "site" and "snapshot" for "record" then.
#[derive(Debug, Clone)]
pub struct SpectrumEstimate {
    pub along: FieldAxis,
    /// Frequencies in cycles per unit of time, or wavenumbers in rad per unit of length.
    pub bins: Vec<f64>,
    pub time: Axis,
    pub space: Axis,
    pub quantity: Quantity,
    /// Unit of the samples.
    pub unit: Option<String>,
    /// Samples of a segment, and shared by neighbours.
    pub segment: [usize; 2],
    /// Half of the width that a line is spread over, `NW` bins; of several tapers alone.
    pub half_bandwidth: Option<f64>,
    /// Of the median of the sites' steadiness.
    pub independence: Independence,
    /// How evenly the energy of each site is spread over its record, see [`Independence::steadiness`].
    pub steadiness: Vec<f64>,
    /// Whether each site has intervals: it is steady, or there are several records.
    pub has_interval: Vec<bool>,
    pub alpha: f64,
    /// Whether the mean of each segment was removed: then nothing is estimated at 0.
    pub mean_is_removed: bool,
    /// Share of the power of white noise that detrending takes of each bin; above 0.05 there is no interval.
    pub detrended: Vec<f64>,
    /// One-sided power spectral density, in the square of the samples' unit over frequency.
    pub spectrum: Array2<f64>,
    /// Degrees of freedom; NaN where no interval can be stated.
    pub degrees: Array2<f64>,
    /// Ends of the interval by the chi-square distribution.
    pub low: Array2<f64>,
    pub high: Array2<f64>,
    /// Whether a jackknife was requested.
    pub has_jackknife: bool,
    /// Half of the interval of `ln S` by the jackknife; NaN where there is none.
    pub jackknife: Array2<f64>,
    pub left_out: LeftOutEach,
    /// What is left of each site where segments with missing samples are left out; `None` with other
    /// [`SpectrumRequest::gaps`]. Sites without any segment are NaN.
    pub segments_left: Option<SegmentsLeft>,
    /// The noise of each site; `None` along space, and of a result made of parts. Where it was subtracted, intervals hold for the difference, and
    /// the jackknife has none.
    pub noise: Option<NoiseFloor>,
    /// Of several tapers alone.
    pub line_test: Option<LineTest>,
    /// Along space, the mean over the times.
    pub mean: Option<MeanSpectrum>,
}

impl SpectrumEstimate {
    /// Positions of the sites, or the times.
    pub fn coordinates(&self) -> Vec<f64> {
        let columns = 0..self.spectrum.ncols();
        columns.map(|j| self.coordinate(j)).collect()
    }

    /// Position of a site, or a time.
    pub fn coordinate(&self, column: usize) -> f64 {
        self.along.of([&self.time, &self.space]).at(column)
    }

    /// The site with the largest mean square.
    pub fn loudest(&self) -> usize {
        let energy = |j: usize| self.spectrum.column(j).sum();
        (0..self.spectrum.ncols())
            .filter(|j| energy(*j).is_finite())
            .max_by(|&a, &b| energy(a).total_cmp(&energy(b)))
            .unwrap_or(0)
    }

    /// The least, the median and the largest of the degrees of freedom away from 0 and from the Nyquist
    /// frequency; `None` where there are none.
    pub fn degrees_range(&self) -> Option<[f64; 3]> {
        let inside = ndarray::s![1..self.segment[0].div_ceil(2), ..];
        least_median_most(self.degrees.slice(inside).iter().copied())
    }

    /// Sites without intervals.
    pub fn without_interval(&self) -> usize {
        self.has_interval.iter().filter(|has| !**has).count()
    }
}

/// Power spectral density of every site with its interval, and a test for lines.
///
/// # Equation
/// With `X` the transforms of the realisations, `sum w^2 = 1` for each taper,
///
/// ```text
/// S(f) = 2 dt <|X(f)|^2>,    nu = 2 K (sum w_k)^2 / sum w_k^2,
/// S nu / q(1 - alpha/2)  <  true  <  S nu / q(alpha/2),
/// ```
///
/// with the mean over segments and records, over tapers with the adaptive weights `w_k`, K the effective number
/// of segments and records, and q the quantiles of the chi-square distribution with `nu` degrees of freedom.
/// At 0 and at the Nyquist frequency transforms are real: S lacks the factor 2 and nu is half of it. The
/// jackknife leaves out one realisation at a time; its interval of `ln S` is `t` times
///
/// ```text
/// s^2 = (R - 1) / R  sum (ln S_i - mean ln S_i)^2,
/// ```
///
/// with Student's t of `R - 1` degrees of freedom; `R` of overlapping segments is their effective number. A line
/// of amplitude A has the transforms `A/2 e^{i phase} U_k`, `U_k = sum_n w_k(n)`:
///
/// ```text
/// mu = sum U_k X_k / sum U_k^2,    F = (K - 1) |mu|^2 sum U_k^2 / sum |X_k - mu U_k|^2,    A = 2 |mu|.
/// ```
///
/// # Shapes
/// Each field is one record of every site (a shot); all have the same axes. Results: `(frequency, site)`. Along
/// space, the snapshots of a field take the place of its records: `(wavenumber, time)`.
///
/// # Units
/// The square of the samples' unit over frequency, or over rad per unit of length; amplitudes in the samples' unit.
///
/// # Errors
/// [`Error::Request`] for fields with different axes, an `alpha` that is no probability, and segments or tapers
/// that do not fit; [`Error::NonFinite`]; [`Error::Memory`]; [`Error::Cancelled`]; [`Error::Failed`].
///
/// # Source
/// D. J. Thomson, Proc. IEEE 70, 1055 (1982), sections V and XIII; D. B. Percival, A. T. Walden, "Spectral
/// Analysis for Physical Applications" (1993), sections 7.4 and 10.11; D. J. Thomson, A. D. Chave, in "Advances
/// in Spectrum Analysis and Array Processing" 1 (1991), chapter 2, for the jackknife.
pub fn spectrum(
    fields: &[&Field],
    request: &SpectrumRequest,
    observer: &dyn Observer,
) -> Result<SpectrumEstimate> {
    let given = first_of(fields)?;
    let transposed: Vec<Field>;
    let exchanged: Vec<&Field>;
    let (first, fields) = match request.along {
        FieldAxis::Time => (given, fields),
        FieldAxis::Space => {
            transposed = fields.iter().map(|field| field.transposed()).collect();
            exchanged = transposed.iter().collect();
            (exchanged[0], &exchanged[..])
        }
    };
    let realisations = request.realisations(first.n_times())?;
    in_pool(request.threads, || {
        let (gaps, memory) = (request.gaps, request.memory);
        let shots = Shots::new(fields, gaps, memory, realisations.reached(), observer)?;
        let grid = Grid::of(first);
        let found = Pass::new(request, &realisations, &grid, fields.len()).run(&shots)?;
        Ok(match request.along {
            FieldAxis::Time => found,
            FieldAxis::Space => found.along_space(),
        })
    })
}

impl SpectrumRequest {
    /// # Errors
    /// [`Error::Request`].
    fn realisations(&self, times: usize) -> Result<Realisations> {
        check_significance(self.alpha)?;
        self.averaging.planned(self.is_whole, times)
    }

    /// The same in parts.
    pub(in crate::estimates) fn plan_in_parts(&self, grid: &Grid) -> Result<Realisations> {
        let along_time =
            "spectra along time, in parts, since each snapshot has a result of its own";
        let jackknife =
            "no jackknife in parts, which compares the mean of all realisations with each";
        let noise = "no noise subtracted in parts, which is read off the beginning of each record";
        for (holds, option, expected) in [
            (self.along == FieldAxis::Time, "along", along_time),
            (!self.has_jackknife, "part", jackknife),
            (!self.subtract_noise, "subtract-noise", noise),
        ] {
            Error::require(holds, option, expected, "it with parts")?;
        }
        self.realisations(grid.times)
    }
}
