//! What an analysis yields beside the large arrays: one value for JSON, figures and terminal.

use std::collections::BTreeMap;

use ndarray::Array3;

use super::along::Headline;
use super::axes::Axes;
use super::dispersion::DispersionCurve;
use super::display::Display;
use crate::arrays::{LargeArray, Precision};
use crate::diagnostics::Map;
use crate::error::{Error, Result};
use crate::estimates::{NoiseFloor, SpectrumInterval};
use crate::field::Quantity;
use crate::moved::{Answer, Reason};
use crate::prepare::WindowGains;
use crate::sheet::Warning;

/// Measures of a family of spectra, one value a row (a site for `S(f, x)`, a time for `S(k, t)`).
///
/// A bin represents the interval of half a bin to both sides of its frequency (wavenumber) `q_m`; 0
/// and, at even length, Nyquist represent half a bin inside the axis. With `p_m` the share of bin m
/// in the row's energy, every bin with its one-sided weight, 0 included, and `w_m` the width of its
/// interval:
///
/// - `centroid = sum q_m p_m`, `bandwidth` the root of `sum (q_m - centroid)^2 p_m`;
/// - `effective_bandwidth = exp(-sum p_m ln(p_m / w_m))`, which is `exp(-integral p ln p dq)` of
///   the density p; independent of padding;
/// - `entropy = -sum p_m ln p_m / ln(bins)`, the normalised entropy (0 to 1), which depends on the
///   number of bins;
/// - `participation = 1 / sum p_m^2`, a number of bins;
/// - `zero_share`, the part of the mean: `p_0`, times the padded over the unpadded length;
/// - `median` and `quantile_90`: where the cumulative energy reaches 50 % and 90 %, read off at the
///   ends of the intervals, linear in between;
/// - `low_share` and `high_share`: the cumulative energy up to the band edge, and the rest.
///
/// Rows with energy below 1e-6 of the largest, or below the noise if known
/// ([`Request::noise`](super::Request::noise)), are NaN except for the energy; so are sites left out, those
/// whose noise is unknown where that of others is subtracted (they would seem to have gained energy at high frequency), and all rows of an axis with a single bin. Units: those of the axis for the first four, otherwise shares and
/// numbers.
#[derive(Debug, Clone, Default)]
pub struct Moments {
    pub centroid: Vec<f64>,
    pub bandwidth: Vec<f64>,
    pub effective_bandwidth: Vec<f64>,
    pub entropy: Vec<f64>,
    pub participation: Vec<f64>,
    pub zero_share: Vec<f64>,
    pub median: Vec<f64>,
    pub quantile_90: Vec<f64>,
    pub low_share: Vec<f64>,
    pub high_share: Vec<f64>,
    /// Integral of the row's spectrum (0 for a row without energy), in the requested scaling.
    pub energy: Vec<f64>,
    pub edge: BandEdge,
    pub headline: Headline,
}

/// How a band edge came about.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case", tag = "chosen_by")]
pub enum BandEdge {
    /// Given by the user.
    Given { value: f64 },
    /// 90 % of the energy at the reference row is below it.
    Reference {
        value: f64,
        /// Index of the reference site or time in the file.
        index: usize,
        /// Its coordinate.
        at: f64,
    },
    /// 90 % of the energy at the reference row is within three bins of 0 (of the transformed length
    /// without padding): the record does not resolve an edge, and there are no shares.
    Unresolved {
        /// The unresolved edge.
        value: f64,
        index: usize,
        at: f64,
        /// Distance between bins of the record without padding.
        bin: f64,
    },
    /// The reference has no energy, or no row has, or there is but one bin.
    #[default]
    Undefined,
}

impl BandEdge {
    /// NaN, below which no bin is, where it is not known.
    pub fn value(&self) -> f64 {
        match *self {
            BandEdge::Given { value } | BandEdge::Reference { value, .. } => value,
            BandEdge::Unresolved { .. } | BandEdge::Undefined => f64::NAN,
        }
    }
}

/// A site or a time, and the share of its energy in the high band.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Spot {
    /// Index in the file.
    pub index: usize,
    /// Coordinate.
    pub at: f64,
    /// `None` where there is no band edge.
    pub high_share: Option<f64>,
}

/// The window over which shares at the front's passage are taken.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct FrontWindow {
    /// Length, in units of time.
    pub window: f64,
    pub samples: usize,
    /// Width at half maximum of the pulse at the reference; `None` where the length was given.
    pub pulse_width: Option<f64>,
}

/// Shares of the bands over the passage of the front, one value a site.
///
/// From the arrival on, when the magnitude first exceeds a hundredth of the site's largest, over a
/// window of the same length at all sites, untapered; the band edge is that of the whole record.
/// NaN where the window does not fit into the record, and where the site is undefined. Shares at the
/// front and over the whole record differ, and the latter depend on the record's length.
#[derive(Debug, Clone)]
pub struct Front {
    /// `None` where no site has energy, the reference has no pulse (it is above half of its largest magnitude at both ends), the
    /// window is longer than the record, or more than half of the sites move from the first sample on, or before the wave arrives.
    pub length: Option<FrontWindow>,
    /// Time of each arrival.
    pub arrival: Vec<f64>,
    /// Whether the window fits into the record from there on.
    pub fits: Vec<bool>,
    /// Of the energy of the window; the rest lies below the band edge.
    pub high_share: Vec<f64>,
    pub headline: Headline,
}

/// Shares of the energy that travel each way. They sum to 1; NaN for a field without energy.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub struct Direction {
    pub toward_plus_x: f64,
    pub toward_minus_x: f64,
    /// On `f = 0`, on `k = 0` or on a Nyquist line.
    pub undirected: f64,
    /// Frequencies summed over.
    pub band: (f64, f64),
}

impl Direction {
    /// The shares of the energy above noise, which holds the share `noise` of all and goes both ways alike.
    pub(super) fn above(self, noise: f64) -> Direction {
        let rest = |part: f64| ((part - 0.5 * noise) / (1.0 - noise)).clamp(0.0, 1.0);
        let [plus, minus] = [self.toward_plus_x, self.toward_minus_x].map(rest);
        Direction {
            toward_plus_x: plus,
            toward_minus_x: minus,
            undirected: (1.0 - plus - minus).max(0.0),
            ..self
        }
    }
}

/// `(energy in the transform domain) / (energy of the prepared, tapered samples) - 1`.
#[derive(Debug, Clone, Copy, Default, serde::Serialize)]
pub struct Parseval {
    pub time: Option<f64>,
    pub space: Option<f64>,
    pub spacetime: Option<f64>,
}

impl Parseval {
    /// That each residual is explained by rounding: at most 1e-10, and in single precision 1e-4, a
    /// thousand times what is found on any field.
    ///
    /// # Errors
    /// [`Error::Failed`] with the first that is not.
    pub fn check(&self, precision: Precision) -> Result<()> {
        let bound = match precision {
            Precision::F64 => 1e-10,
            Precision::F32 => 1e-4,
        };
        for (spectra, residual) in [
            ("along time", self.time),
            ("along space", self.space),
            ("in space and time", self.spacetime),
        ] {
            if let Some(residual) = residual.filter(|r| r.is_nan() || r.abs() > bound) {
                return Err(Error::parseval(spectra, residual, bound));
            }
        }
        Ok(())
    }
}

/// Short-time spectra along one axis, of records of sites or of profiles of instants.
#[derive(Debug, Clone)]
pub struct ShortTimeSpectra {
    /// Indices of the sites (or times) in the range analyzed.
    pub rows: Vec<usize>,
    /// Their coordinates.
    pub at: Vec<f64>,
    /// Bin frequencies (cycles) or wavenumbers (rad).
    pub bins: Vec<f64>,
    /// Centre of each frame: a time, or a position.
    pub frames: Vec<f64>,
    pub segment: usize,
    pub hop: usize,
    pub window: WindowGains,
    /// `(row, bin, frame)`
    pub values: Array3<f64>,
}

impl ShortTimeSpectra {
    /// The largest value of all.
    pub(crate) fn largest(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }
}

/// Time and traffic of one stage of the run; stages may run concurrently and share the threads.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Timing {
    pub stage: &'static str,
    pub seconds: f64,
    pub bytes_read: u64,
    pub bytes_written: u64,
    pub transforms: u64,
    /// Length of each of these transforms; 0 where there are none.
    pub transform_length: usize,
}

/// Error of the result, and its source.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Accuracy {
    pub precision: Precision,
    /// Unit of the stored amplitudes: 1 unless squares leave the number range, then a power of
    /// two; spectra are then in units of its square.
    pub amplitude_unit: f64,
    /// Root mean square difference of spot-checked amplitudes (of one site's transform along time)
    /// from direct sums in twice the precision, relative to the root mean square of all its
    /// amplitudes; `None` where nothing was checked.
    pub spot_check: Option<f64>,
    /// How many amplitudes were checked.
    pub spot_checks: usize,
    /// The largest of the Parseval residuals, as a magnitude.
    pub parseval: Option<f64>,
    pub estimated_by: &'static str,
}

/// Windows in use, with their gains for a sine and for noise.
#[derive(Debug, Clone)]
pub struct Conventions {
    pub scaling: super::Scaling,
    pub window_time: WindowGains,
    pub window_space: WindowGains,
    /// Samples per transform along time: the record, or a Welch segment.
    pub segment: usize,
    pub overlap: usize,
    pub segments: usize,
    pub padded_time: usize,
    pub padded_space: usize,
}

/// Share of the energy below which noise does not count.
const NOISE: f64 = 0.02;

impl Analysis {
    /// [`Self::direction`] of the energy above the noise; `None` where it says nothing of the waves. Over a band of frequencies the noise
    /// is not known.
    pub fn direction_of_waves(&self) -> Option<Direction> {
        let direction = self.direction.filter(|_| self.undirected.is_none())?;
        let is_whole =
            self.axes.frequency.last() == Some(&direction.band.1) && direction.band.0 == 0.0;
        let noise = self.answer.as_ref().map_or(0.0, |answer| answer.noise);
        Some(match is_whole && noise > NOISE {
            true => direction.above(noise),
            false => direction,
        })
    }
}

/// The result of an analysis, but for the large arrays, which went to the [`crate::arrays::Sink`].
#[derive(Debug, Clone)]
pub struct Analysis {
    pub name: String,
    pub content_hash: Option<String>,
    pub quantity: Quantity,
    pub unit: Option<String>,
    /// First time row and first site of the file that were analyzed.
    pub offset: (usize, usize),
    pub axes: Axes,
    pub conventions: Conventions,
    pub parseval: Parseval,
    pub direction: Option<Direction>,
    /// What moved, if it was asked for.
    pub answer: Option<Answer>,
    /// Why [`Self::direction`] says nothing of the waves.
    pub undirected: Option<Reason>,
    /// Share of energy towards +x and towards -x at each frequency (NaN without energy).
    pub direction_by_frequency: Option<[Vec<f64>; 2]>,
    /// How well `S(f, x)` is known at the reference site, if the record is stationary.
    pub interval: Option<SpectrumInterval>,
    /// The noise that was subtracted from spectra along time, in the requested scaling; densities of the noise are
    /// power spectral densities.
    pub noise: Option<NoiseFloor>,
    /// Redistribution of frequency content along x: one value a site.
    pub along_space: Option<Moments>,
    /// Redistribution of wavenumber content along t: one value a time.
    pub along_time: Option<Moments>,
    /// The passage of the front, beside the whole record.
    pub front: Option<Front>,
    /// The part of each axis that figures show.
    pub display: Display,
    /// Of the samples and of each large array, with its rows and columns. No maps where
    /// [`Request::maps`](super::Request::maps) is off.
    pub maps: BTreeMap<LargeArray, Map>,
    /// What `S(k, f)` is held against; empty where it was not requested.
    pub dispersion: Vec<DispersionCurve>,
    pub short_time: Option<ShortTimeSpectra>,
    pub short_space: Option<ShortTimeSpectra>,
    /// Stated error of the samples over the largest of them, of a run; figures leave out what is below it.
    pub sample_error: Option<f64>,
    pub accuracy: Accuracy,
    pub timings: Vec<Timing>,
    pub warnings: Vec<Warning>,
}
