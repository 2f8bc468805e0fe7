//! Straight lines through quiet parts, and the uncertainty of a channel's offset and slope.

use crate::numeric::LineFit;

/// The line through a quiet part, over samples from `start` on; `None` for fewer than three samples.
pub(super) fn line_through(record: &[f64], start: usize) -> Option<LineFit> {
    let points = record.iter().enumerate();
    let points: Vec<(f64, f64)> = points.map(|(i, v)| (i as f64 - start as f64, *v)).collect();
    LineFit::through(&points)
}

/// Variance of what a line leaves.
pub(super) fn variance(line: &LineFit) -> f64 {
    line.squares / (line.points as f64 - 2.0)
}

/// Variance of a quantity over channels, given values and the variances of their errors.
pub(super) fn spread_of(values: Vec<(f64, f64)>) -> f64 {
    let mut spread = 0.0;
    let mut doubt = 0.0;
    // Weights need the spread; three rounds settle it.
    for _ in 0..3 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (value, error) in &values {
            let all = error + spread;
            if all > 0.0 {
                let weight = (all * all).recip();
                sum += weight * (value * value - error);
                weights += weight;
            }
        }
        if weights == 0.0 || !weights.is_finite() {
            return values.iter().map(|(v, _)| v * v).sum::<f64>() / values.len() as f64;
        }
        spread = (sum / weights).max(0.0);
        doubt = (2.0 / weights).sqrt();
    }
    spread + doubt
}

/// Offset and slope (per sample) given a line and how large they are over all channels.
pub(super) struct Drifting {
    pub(super) offset: f64,
    pub(super) slope: f64,
    /// Of the offset, of both, of the slope.
    pub(super) covariance: [f64; 3],
}

impl Drifting {
    pub(super) fn of(line: Option<LineFit>, variance: f64, prior: [f64; 2]) -> Drifting {
        let mut covariance = [prior[0], 0.0, prior[1]];
        let mut at = [0.0, 0.0];
        // The gain of a Kalman filter, with offset and slope at the middle of the line measured
        // apart, since their errors are independent.
        let measured = line.map(|line| {
            let mean = line.intercept + line.slope * line.middle;
            [
                ([1.0, line.middle], mean, variance / line.points as f64),
                ([0.0, 1.0], line.slope, variance / line.spread),
            ]
        });
        for (row, measured, error) in measured.into_iter().flatten() {
            let [p, c, q] = covariance;
            let along = [p * row[0] + c * row[1], c * row[0] + q * row[1]];
            let total = row[0] * along[0] + row[1] * along[1] + error;
            if total == 0.0 {
                continue;
            }
            let miss = measured - row[0] * at[0] - row[1] * at[1];
            at = [0, 1].map(|i| at[i] + along[i] / total * miss);
            covariance = [
                p - along[0] * along[0] / total,
                c - along[0] * along[1] / total,
                q - along[1] * along[1] / total,
            ];
        }
        Drifting {
            offset: at[0],
            slope: at[1],
            covariance,
        }
    }
}
