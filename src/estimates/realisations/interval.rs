//! Intervals of spectra from their degrees of freedom.

use ndarray::Array2;

use super::SIGNIFICANCE;
use super::effective::effective_segments;
use super::ensemble::{LEAST_STEADINESS, share_that_counts, steadiness};
use crate::numeric::{chi_square_quantile, student_two_sided, sum_of_squares};
use crate::prepare::{Detrend, Trend};
use crate::transform::Segments;

/// How well the spectra of records like one of them are known.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SpectrumInterval {
    /// How evenly the energy of the record is spread over it, see [`Independence::steadiness`](super::Independence::steadiness).
    pub steadiness: f64,
    /// Independent segments that a stationary record would have.
    pub effective_segments: f64,
    /// Probability with which the true spectrum is outside of the interval.
    pub alpha: f64,
    /// Twice the number of independent segments; `None` of a transient, which is one realisation.
    pub degrees_of_freedom: Option<f64>,
    /// What a value is multiplied by for the ends of its interval.
    pub factors: Option<[f64; 2]>,
}

impl SpectrumInterval {
    /// Of the average over `segments` of a record under a window; `None` where the record is constant but for
    /// rounding, and where no frequency lies between 0 and the Nyquist frequency.
    pub(crate) fn of_record(record: &[f64], window: &[f64], segments: Segments) -> Option<Self> {
        const ROUNDING: f64 = 1e-28;
        if segments.length < 3 {
            return None;
        }
        // An offset is not what moves.
        let mut moving = record.to_vec();
        Trend::remove_from(&mut moving, Detrend::Mean, |_| true, &mut Vec::new());
        if sum_of_squares(&moving) <= ROUNDING * sum_of_squares(record) {
            return None;
        }
        let effective = effective_segments(window, segments);
        let steadiness = steadiness(&moving);
        let white = std::iter::repeat_n(1.0, segments.length / 2);
        let counting = share_that_counts(steadiness, record.len(), (white, segments.length));
        let degrees =
            (steadiness >= LEAST_STEADINESS).then_some((2.0 * effective * counting).max(2.0));
        Some(SpectrumInterval {
            steadiness,
            effective_segments: effective,
            alpha: SIGNIFICANCE,
            degrees_of_freedom: degrees,
            factors: degrees.map(|degrees| interval_factors(degrees, SIGNIFICANCE)),
        })
    }
}

/// What a spectrum with `degrees` degrees of freedom is multiplied by for the ends of its interval: the true
/// one lies between `S nu / q(1 - alpha/2)` and `S nu / q(alpha/2)` with probability `1 - alpha`, `q` the
/// quantiles of the chi-square distribution.
///
/// Source: R. B. Blackman, J. W. Tukey, "The Measurement of Power Spectra" (1958), section 9; D. B. Percival, A.
/// T. Walden, "Spectral Analysis for Physical Applications" (1993), eq. 258.
pub fn interval_factors(degrees: f64, alpha: f64) -> [f64; 2] {
    let of = |share: f64| degrees / chi_square_quantile(share, degrees);
    [of(1.0 - 0.5 * alpha), of(0.5 * alpha)]
}

/// [`interval_factors`] between two numbers of degrees of freedom, by Chebyshev polynomials: adaptive weights
/// give each cell its own.
pub(crate) struct FactorTable {
    /// Ends of `ln nu`.
    low: f64,
    high: f64,
    /// Coefficients of the logarithms of both factors.
    coefficients: Vec<[f64; 2]>,
}

/// Nodes; over a factor of sixty the error is below 1e-11.
const NODES: usize = 48;

impl FactorTable {
    pub fn new(degrees: [f64; 2], alpha: f64) -> FactorTable {
        // Room for rounding at the ends.
        let (low, high) = (degrees[0].ln() - 1e-9, degrees[1].ln() + 1e-9);
        let angle = |i: usize| std::f64::consts::PI * (i as f64 + 0.5) / NODES as f64;
        let value = |i: usize| {
            let x = angle(i).cos();
            let degrees = (0.5 * (low + high) + 0.5 * (high - low) * x).exp();
            interval_factors(degrees, alpha).map(f64::ln)
        };
        let values: Vec<[f64; 2]> = (0..NODES).map(value).collect();
        let coefficient = |j: usize| {
            let mut sum = [0.0; 2];
            for (i, value) in values.iter().enumerate() {
                let weight = (j as f64 * angle(i)).cos() * 2.0 / NODES as f64;
                sum[0] += weight * value[0];
                sum[1] += weight * value[1];
            }
            if j == 0 { sum.map(|c| 0.5 * c) } else { sum }
        };
        FactorTable {
            low,
            high,
            coefficients: (0..NODES).map(coefficient).collect(),
        }
    }

    /// The ends of the intervals of a spectrum.
    pub fn ends(&self, spectrum: &Array2<f64>, degrees: &Array2<f64>) -> [Array2<f64>; 2] {
        let (mut low, mut high) = (degrees.clone(), spectrum.clone());
        for (low, high) in low.iter_mut().zip(&mut high) {
            let factors = self.at(*low);
            *low = *high * factors[0];
            *high *= factors[1];
        }
        [low, high]
    }

    /// NaN outside of the ends.
    pub fn at(&self, degrees: f64) -> [f64; 2] {
        let u = degrees.ln();
        if !(self.low..=self.high).contains(&u) {
            return [f64::NAN; 2];
        }
        let x = (2.0 * u - self.low - self.high) / (self.high - self.low);
        // Clenshaw's recurrence.
        let (mut next, mut after) = ([0.0; 2], [0.0; 2]);
        for c in self.coefficients[1..].iter().rev() {
            let now = [0, 1].map(|i| c[i] + 2.0 * x * next[i] - after[i]);
            (next, after) = (now, next);
        }
        [0, 1].map(|i| (self.coefficients[0][i] + x * next[i] - after[i]).exp())
    }
}

/// `t^2 / (2 K - 2)` of K independent realisations: the variance of a phase at `1 - alpha`, but for `(1 - g) / g`.
pub(crate) fn phase_spread(alpha: f64, independent: f64) -> f64 {
    let degrees = 2.0 * independent - 2.0;
    student_two_sided(alpha, degrees).powi(2) / degrees
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two degrees of freedom are an exponential distribution.
    #[test]
    fn val_closed_form_factors_of_a_periodogram() {
        let [low, high] = interval_factors(2.0, 0.05);
        assert!((low * -0.025_f64.ln() - 1.0).abs() < 1e-13, "{low}");
        assert!((high * -(-0.025_f64).ln_1p() - 1.0).abs() < 1e-13, "{high}");
    }

    /// Less their mean, two samples are as steady as can be whatever they are.
    #[test]
    fn regress_two_samples_have_no_interval() {
        let of = |record: &[f64]| {
            let segments = Segments::whole(record.len());
            SpectrumInterval::of_record(record, &vec![1.0; record.len()], segments)
        };
        assert_eq!(of(&[0.3, -2.0]), None);
        assert!(of(&[0.3, -2.0, 1.1]).is_some());
    }
}
