//! What is requested of increments, and what is found.

use super::moments::{ORDERS, STATISTICS};
use crate::estimates::{FieldAxis, SIGNIFICANCE};
use crate::field::Axis;
use crate::numeric::student_two_sided;

/// All choices of [`increments`](super::increments()).
#[derive(Debug, Clone, PartialEq, smart_default::SmartDefault)]
pub struct IncrementsRequest {
    /// Separations in sites; `None`: powers of the root of two up to a quarter of the sites.
    pub separations: Option<Vec<usize>>,
    /// Lags in samples; `None`: powers of the root of two up to a quarter of the times.
    pub lags: Option<Vec<usize>>,
    /// Separations, in units of length, over which exponents are fitted.
    pub band: Option<(f64, f64)>,
    /// Lags, in units of time, over which exponents are fitted.
    pub lag_band: Option<(f64, f64)>,
    /// Scales of each axis with a histogram.
    #[default(4)]
    pub histograms: usize,
    /// Intervals hold with probability `1 - alpha`.
    #[default(SIGNIFICANCE)]
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    pub memory: Option<u64>,
}

/// What [`increments`](super::increments()) finds.
#[derive(Debug, Clone)]
pub struct Increments {
    pub time: Axis,
    pub space: Axis,
    /// Unit of the samples.
    pub unit: Option<String>,
    pub shots: usize,
    /// How evenly the squares of the samples are spread over 16 parts of the times: 1 for a stationary record, 1/16
    /// for a pulse.
    pub steadiness: f64,
    pub basis: IntervalBasis,
    pub alpha: f64,
    /// Along x, then in time; an axis without increments is left out.
    pub axes: Vec<AxisIncrements>,
}

/// What intervals rest on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum IntervalBasis {
    /// Each shot is one value.
    Shots,
    /// Each of 16 parts of a stationary record is one value.
    Parts,
    /// The residuals of a regression alone: deviations from a power law, but not what another record would give.
    Regression,
    /// A transient is one realisation.
    None,
}

/// Increments along one axis.
#[derive(Debug, Clone)]
pub struct AxisIncrements {
    pub axis: FieldAxis,
    pub scales: Vec<ScaleMoments>,
    /// Exponent by which the local flatness grows towards small scales, with half of its interval; `None` where fewer than
    /// three scales have one.
    pub growth: Option<[f64; 2]>,
    pub exponents: Option<ScalingExponents>,
    pub histograms: Vec<IncrementHistogram>,
}

/// Moments of the increments over one separation or lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScaleMoments {
    /// In sites or samples.
    pub step: usize,
    /// In units of length or time.
    pub scale: f64,
    /// Pairs of finite samples.
    pub pairs: u64,
    /// `<|d|^p>`, p from 1 to 6.
    pub structure: [f64; ORDERS],
    /// `<d^3>`.
    pub third: f64,
    /// `<d^4> / <d^2>^2`: 3 for normal increments.
    pub flatness: f64,
    /// `<d^3> / <d^2>^{3/2}`.
    pub skewness: f64,
    /// The flatness of increments in units of the level that they have at their place and in their part of the times:
    /// 3 for normal increments of any levels. NaN of lags longer than a quarter of a part, and of fewer than 64 times.
    pub local_flatness: f64,
    /// Half of the intervals of the numbers above, in their order; NaN where none can be stated.
    pub half: [f64; STATISTICS],
    /// Values that the intervals rest on.
    pub realisations: usize,
}

impl ScaleMoments {
    pub fn flatness_half(&self) -> f64 {
        self.half[ORDERS + 1]
    }

    pub fn local_flatness_half(&self) -> f64 {
        self.half[ORDERS + 3]
    }
}

impl AxisIncrements {
    /// Whether the local flatness of the smallest scale is above 3, and grows towards it, both beyond their intervals; `None`
    /// where that cannot be told.
    pub fn is_intermittent(&self) -> Option<bool> {
        let [exponent, half] = self.growth?;
        let [smallest, _] = self.local_ends()?;
        let is_above = smallest.local_flatness - 3.0 > smallest.local_flatness_half();
        Some(is_above && exponent > half)
    }

    /// The smallest and the largest scale whose local flatness has an interval.
    pub(super) fn local_ends(&self) -> Option<[&ScaleMoments; 2]> {
        let is_known = |m: &&ScaleMoments| m.local_flatness_half().is_finite();
        let mut known = self.scales.iter().filter(is_known);
        let first = known.next()?;
        Some([first, known.next_back().unwrap_or(first)])
    }

    /// Whether there is anything to have a flatness.
    pub fn moves(&self) -> bool {
        self.scales.iter().any(|m| m.structure[1] > 0.0)
    }

    /// Scales at which the third moment has a sign, with the sign: each interval leaves out 0 with the probability `1 - alpha /
    /// n` of n scales, so that chance makes none of them with `1 - alpha`.
    pub fn third_signs(&self, alpha: f64) -> Vec<(f64, f64)> {
        let known = |m: &&ScaleMoments| m.half[ORDERS].is_finite() && m.realisations > 1;
        let known = self.scales.iter().filter(known);
        let count = known.clone().count() as f64;
        let has_sign = |m: &&ScaleMoments| {
            let within = |alpha: f64| student_two_sided(alpha, m.realisations as f64 - 1.0);
            m.third.abs() > m.half[ORDERS] * within(alpha / count) / within(alpha)
        };
        let signs = known.filter(has_sign);
        signs.map(|m| (m.scale, m.third.signum())).collect()
    }
}

/// Slopes of `ln S_p` against the logarithm of the scale.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ScalingExponents {
    /// Smallest and largest scale of the fit.
    pub band: [f64; 2],
    pub points: usize,
    /// Of orders 1 to 6.
    pub exponents: [f64; ORDERS],
    /// Half of their intervals.
    pub half: [f64; ORDERS],
    pub basis: IntervalBasis,
    /// Slopes against `ln S_3` (extended self-similarity).
    pub relative: [f64; ORDERS],
}

/// Histogram of increments over their root mean square.
#[derive(Debug, Clone, PartialEq)]
pub struct IncrementHistogram {
    /// Index of the scale.
    pub index: usize,
    /// Edges of the cells, in root mean squares.
    pub edges: Vec<f64>,
    /// Probability density of `d / sqrt <d^2>`.
    pub density: Vec<f64>,
    /// Increments below the first and above the last edge.
    pub outside: [u64; 2],
}
