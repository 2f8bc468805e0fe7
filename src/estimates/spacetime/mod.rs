//! `S(k, f)` averaged over segments, records and tapers along both axes, with intervals.

mod pass;
mod sheet;
mod totals;

use std::f64::consts::TAU;

use ndarray::Array2;

use crate::error::{Error, Result};
use crate::estimates::SIGNIFICANCE;
use crate::estimates::realisations::{
    Averaging, FactorTable, Grid, Independence, LEAST_STEADINESS, Realisations, Shots, Tapers,
    check_significance, first_of, least_median_most, refuse_left_out, share_that_counts,
};
use crate::field::{Axis, Field, Quantity};
use crate::observer::Observer;
use crate::prepare::{Gaps, Window};
use crate::system::threads::in_pool;
use crate::transform::{fold, frequencies, wavenumbers_signed};
use pass::Pass;
use totals::Totals;

/// All choices of [`spacetime`].
#[derive(Debug, Clone, PartialEq, smart_default::SmartDefault)]
pub struct SpaceTimeRequest {
    /// Along time.
    pub averaging: Averaging,
    /// The whole record as one segment, whatever `averaging` says of segments.
    pub is_whole: bool,
    /// Along space, over all sites.
    #[default(Tapers::Window(Window::USUAL))]
    pub space: Tapers,
    /// Whether several tapers have Thomson's adaptive weights; else all have the same.
    #[default(true)]
    pub is_adaptive: bool,
    pub gaps: Gaps,
    /// Probability by which the true spectrum is outside of its interval.
    #[default(SIGNIFICANCE)]
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

/// What [`spacetime`] finds. Arrays are `(frequency, wavenumber)`.
#[derive(Debug, Clone)]
pub struct SpaceTimeEstimate {
    /// Frequencies in cycles per unit of time.
    pub frequency: Vec<f64>,
    /// Wavenumbers in rad per unit of length, ascending; positive ones travel towards +x.
    pub wavenumber: Vec<f64>,
    pub time: Axis,
    pub space: Axis,
    pub quantity: Quantity,
    /// Unit of the samples.
    pub unit: Option<String>,
    /// Samples of a segment, and shared by neighbours.
    pub segment: [usize; 2],
    /// Tapers of a segment, and of its sites.
    pub tapers: [usize; 2],
    /// Half of the width that a wave is spread over, in frequency and in wavenumber; of several tapers alone.
    pub half_bandwidth: [Option<f64>; 2],
    /// Of the site at which half of the energy lies at sites that are less steady.
    pub independence: Independence,
    /// How evenly the energy is spread over the sites, see [`Independence::steadiness`]. Below a third the
    /// tapers along space count as one.
    pub evenness: f64,
    pub alpha: f64,
    /// Whether the mean of each segment was removed: then nothing is estimated at f = 0.
    pub mean_is_removed: bool,
    /// Power spectral density, one-sided in f and two-sided in k, in the square of the samples' unit over
    /// frequency and wavenumber.
    pub spectrum: Array2<f64>,
    /// Degrees of freedom; NaN where no interval can be stated.
    pub degrees: Array2<f64>,
    /// Ends of the interval by the chi-square distribution.
    pub low: Array2<f64>,
    pub high: Array2<f64>,
    /// The integral of the spectrum over f and k.
    pub power: f64,
    /// Mean square of the samples of all segments, less what was removed from each.
    pub mean_square: f64,
    /// The integral of the spectrum by equal weights over the mean square under the squares of the tapers,
    /// minus 1: Parseval's identity.
    pub parseval: f64,
}

impl SpaceTimeEstimate {
    /// Whether intervals are stated.
    pub fn has_interval(&self) -> bool {
        self.independence.records > 1 || !self.independence.is_transient()
    }

    /// The least, the median and the largest of the degrees of freedom where transforms are complex; `None`
    /// without intervals.
    pub fn degrees_range(&self) -> Option<[f64; 3]> {
        let (length, sites) = (self.segment[0], self.wavenumber.len());
        let cells = self.degrees.indexed_iter();
        let complex = cells.filter(|((m, i), _)| !is_real([*m, *i], length, sites));
        least_median_most(complex.map(|(_, d)| *d))
    }

    /// Row and column of the largest density where an interval may be.
    pub fn largest(&self) -> (usize, usize) {
        let first = usize::from(self.mean_is_removed);
        let cells = self.spectrum.indexed_iter();
        let cells = cells.filter(|((m, _), _)| *m >= first);
        let largest = cells.max_by(|a, b| a.1.total_cmp(b.1));
        largest.map_or((0, 0), |(at, _)| at)
    }

    /// Shares of the power that travel towards +x, towards -x, and neither: at f = 0, at k = 0 and at the
    /// Nyquist wavenumber.
    pub fn directions(&self) -> [f64; 3] {
        let (mut shares, sites) = ([0.0; 3], self.wavenumber.len());
        for ((m, i), s) in self.spectrum.indexed_iter() {
            let is_nyquist = sites % 2 == 0 && i == 0;
            let kind = match self.wavenumber[i] {
                k if m == 0 || is_nyquist || k == 0.0 => 2,
                k => usize::from(k < 0.0),
            };
            shares[kind] += s;
        }
        // NaN of a field of zeros.
        let all: f64 = shares.iter().sum();
        shares.map(|share| share / all)
    }
}

/// Whether the transform of a cell is a real number.
fn is_real([m, i]: [usize; 2], length: usize, sites: usize) -> bool {
    let at_end = sites.is_multiple_of(2) && i == 0;
    fold(m, length) == 1.0 && (i == sites / 2 || at_end)
}

/// `S(k, f)` averaged over segments in time, records, and tapers in time and space.
///
/// # Equation
/// With `w_a` the tapers along time, `u_b` those along space, each with `sum w^2 = 1`, over all segments and
/// records
///
/// ```text
/// X(k, f) = sum_n sum_j w_a(n) u_b(j) v(n, j) exp(i (k x_j - 2 pi f t_n)),
/// S(k, f) = 2 dt dx / (2 pi) <|X(k, f)|^2>,    nu = 2 K,
/// S nu / q(1 - alpha/2)  <  true  <  S nu / q(alpha/2),
/// ```
///
/// with K the effective number of realisations, `K = (records) (segments and tapers in time, Welch) (tapers in
/// space)`, and q the quantiles of the chi-square distribution. At f = 0 and at the Nyquist frequency S lacks
/// the factor 2; where k is 0 or Nyquist as well, transforms are real and `nu` is half as large. With equal
/// weights of all tapers the integral of S over f and k is the mean of
/// `sum_n sum_j w_a(n)^2 u_b(j)^2 v(n, j)^2` (Parseval), without tapers the mean square.
///
/// With adaptive weights the mean over the pairs of tapers is weighted as over the tapers of
/// [`spectrum()`](super::spectrum()), with the concentration `l_a l_b` of a pair and the mean square of all
/// samples under the tapers: leakage from anywhere in the (k, f) plane counts less where S is low. Then
/// `nu = 2 K (sum w)^2 / (P sum w^2)` over the P pairs.
///
/// The interval holds for records that are stationary in time and alike along space. If most of the energy is
/// at sites with a transient, only records count; if it is at a few sites, tapers along space count as one.
///
/// # Shapes
/// Each field is one record of every site (a shot); all have the same axes. Results: `(frequency, wavenumber)`,
/// k ascending through 0.
///
/// # Units
/// The square of the samples' unit over frequency and over rad per unit of length.
///
/// # Errors
/// [`Error::Request`] for fields with different axes, fewer than four sites, an `alpha` that is no probability,
/// and segments or tapers that do not fit; [`Error::Failed`]; [`Error::NonFinite`]; [`Error::Memory`];
/// [`Error::Cancelled`]; [`Error::Failed`].
///
/// # Source
/// J. Capon, Proc. IEEE 57, 1408 (1969), section II, for the estimate by segments; P. D. Welch (1967), eq. 12,
/// and D. J. Thomson (1982) for the effective number and for the weights; A. Hanssen, Signal Process. 58, 327
/// (1997), for products of tapers along both axes.
pub fn spacetime(
    fields: &[&Field],
    request: &SpaceTimeRequest,
    observer: &dyn Observer,
) -> Result<SpaceTimeEstimate> {
    let grid = Grid::of(first_of(fields)?);
    let realisations = request.plan(&grid)?;
    in_pool(request.threads, || {
        let (gaps, memory) = (request.gaps, request.memory);
        let shots = Shots::new(fields, gaps, memory, realisations.reached(), observer)?;
        let pass = Pass::new(request, &realisations, grid.clone())?;
        let totals = pass.sum(&shots, fields.len())?;
        request.finish(&pass, fields.len(), &totals)
    })
}

/// By how much the power may differ from the energy of the samples.
const PARSEVAL: f64 = 1e-10;

impl SpaceTimeRequest {
    fn plan(&self, grid: &Grid) -> Result<Realisations> {
        check_significance(self.alpha)?;
        refuse_left_out(self.gaps, "a space-time spectrum")?;
        let expected = "at least 4 sites for spectra along both axes";
        Error::require(grid.sites >= 4, "along", expected, grid.sites)?;
        self.averaging.planned(self.is_whole, grid.times)
    }

    /// Pairs of tapers that have sums of their own: all where weights are adaptive, else one.
    fn pairs(&self) -> usize {
        match self.is_adaptive {
            true => self.averaging.tapers.count() * self.space.count(),
            false => 1,
        }
    }

    fn finish(
        &self,
        pass: &Pass<'_>,
        records: usize,
        totals: &Totals,
    ) -> Result<SpaceTimeEstimate> {
        let (grid, time) = (&pass.grid, pass.realisations);
        let (length, sites) = (time.segments.length, grid.sites);
        let count = (records * time.segments.count()) as f64;
        let tapers = [time.tapers(), pass.space.tapers()];
        let density = grid.time.step * grid.space.step / TAU;
        let duration = length as f64 * grid.time.step;
        let extent = sites as f64 * grid.space.step;
        let cell = 1.0 / duration * TAU / extent;
        let of = |mean: &dyn Fn(usize, usize) -> f64| {
            let value = |(m, i)| mean(m, i) * density * fold(m, length);
            let spectrum = Array2::from_shape_fn((time.bins(), sites), value);
            let power = spectrum.as_slice().map_or(0.0, crate::numeric::sum) * cell;
            (spectrum, power)
        };
        let (spectrum, power) = of(&|m, i| totals.mean(m, i));
        let equal = match self.pairs() {
            1 => power,
            _ => of(&|m, i| totals.equal(m, i)).1,
        };
        let tapered = totals.tapered() / count;
        let parseval = match tapered > 0.0 {
            true => equal / tapered - 1.0,
            false => 0.0,
        };
        if parseval.is_nan() || parseval.abs() > PARSEVAL {
            return Err(Error::parseval("spacetime_spectrum", parseval, PARSEVAL));
        }
        let evenness = crate::estimates::realisations::steadiness(&totals.site_amplitudes());
        let of_space = match evenness >= LEAST_STEADINESS {
            true => pass.space.effective(),
            false => 1.0,
        };
        let counts = [records, time.segments.count(), tapers[0] * tapers[1]];
        let effective = time.effective() * of_space;
        let (steadiness, samples) = (totals.steadiness(records), time.segments.record);
        let independence = Independence::new(counts, effective, steadiness, samples);
        // Realisations that count, if they have the same weight; by the shares of the weights otherwise.
        let is_steady = !independence.is_transient();
        let is_by_weights = is_steady && self.pairs() > 1;
        let most = match records {
            _ if is_steady => {
                let spectrum = spectrum.rows().into_iter().skip(1).map(|row| row.sum());
                let counting = share_that_counts(steadiness, samples, (spectrum, length));
                2.0 * (independence.effective * counting).max(1.0)
            }
            0..2 => f64::NAN,
            _ => 2.0 * records as f64,
        };
        let mean_is_removed = time.about_mean();
        let wavenumber = wavenumbers_signed(sites, grid.space.step);
        let degrees = Array2::from_shape_fn(spectrum.dim(), |(m, i)| {
            if spectrum[[m, i]] <= 0.0 || (m == 0 && mean_is_removed) {
                return f64::NAN;
            }
            let is_real = is_real([m, i], length, sites);
            let most = if is_real { 0.5 * most } else { most };
            match is_by_weights {
                true => most * totals.share(m, i),
                false => most,
            }
        });
        let least = 0.5 * most / self.pairs() as f64;

        let [low, high] = match most.is_finite() {
            true => FactorTable::new([least, most], self.alpha).ends(&spectrum, &degrees),
            false => [(); 2].map(|()| Array2::from_elem(spectrum.dim(), f64::NAN)),
        };
        let of_time = self.averaging.tapers.half_bandwidth();
        let half_bandwidth = [
            of_time.map(|nw| nw / duration),
            self.space.half_bandwidth().map(|nw| nw / (extent / TAU)),
        ];
        Ok(SpaceTimeEstimate {
            frequency: frequencies(length, grid.time.step),
            wavenumber,
            time: grid.time.clone(),
            space: grid.space.clone(),
            quantity: grid.quantity,
            unit: grid.unit.clone(),
            segment: [length, length - time.segments.hop],
            tapers,
            half_bandwidth,
            independence,
            evenness,
            alpha: self.alpha,
            mean_is_removed,
            degrees,
            low,
            high,
            power,
            mean_square: totals.square() / (count * (length * sites) as f64),
            parseval,
            spectrum,
        })
    }
}
