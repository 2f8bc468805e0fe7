//! Straight lines through quiet parts, and the uncertainty of a channel's offset and slope.

/// A straight line through a quiet part.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LinearTrend {
    pub(super) count: f64,
    pub(super) offset: f64,
    pub(super) slope: f64,
    /// Squares of standard errors over the variance of the noise.
    pub(super) offset_share: f64,
    pub(super) slope_share: f64,
    /// Variance of the residuals.
    pub(super) variance: f64,
}

impl LinearTrend {
    /// `None` for fewer than three samples. Times are from `start`, in samples.
    pub(super) fn through(record: &[f64], start: usize) -> Option<LinearTrend> {
        let count = record.len() as f64;
        if record.len() < 3 {
            return None;
        }
        let middle = 0.5 * (count - 1.0);
        let mean = record.iter().sum::<f64>() / count;
        let spread = count * (count * count - 1.0) / 12.0;
        let moment = |(i, v): (usize, &f64)| (i as f64 - middle) * (v - mean);
        let slope = record.iter().enumerate().map(moment).sum::<f64>() / spread;
        let residual = |(i, v): (usize, &f64)| v - mean - slope * (i as f64 - middle);
        let squares = record.iter().enumerate().map(|s| residual(s).powi(2));
        let lever = middle - start as f64;
        Some(LinearTrend {
            count,
            offset: mean - slope * lever,
            slope,
            offset_share: 1.0 / count + lever * lever / spread,
            slope_share: 1.0 / spread,
            variance: squares.sum::<f64>() / (count - 2.0),
        })
    }
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
    pub(super) fn of(
        line: Option<LinearTrend>,
        start: usize,
        variance: f64,
        prior: [f64; 2],
    ) -> Drifting {
        let mut covariance = [prior[0], 0.0, prior[1]];
        let mut at = [0.0, 0.0];
        // The gain of a Kalman filter, with offset and slope at the middle of the line measured
        // apart, since their errors are independent.
        let measured = line.map(|line| {
            let lever = 0.5 * (line.count - 1.0) - start as f64;
            let mean = line.offset + line.slope * lever;
            [
                ([1.0, lever], mean, variance / line.count),
                ([0.0, 1.0], line.slope, variance * line.slope_share),
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
            at = [
                at[0] + along[0] / total * miss,
                at[1] + along[1] / total * miss,
            ];
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
