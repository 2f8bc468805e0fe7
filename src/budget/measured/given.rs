//! The energy put into a chain, from a record with noise.
//!
//! Total energy plus losses, `H(t) = E(t) + int D dt`, is constant once the impact is over. Noise
//! makes it scatter, and raises it: energies are squares. A repetition raises it by as much again,
//! so that `H - <H_again - H>` is free of that to leading order. The estimate is its median over
//! the record, samples weighted by the inverse of their variance, but none above that of the median
//! variance: early samples, when little moves, are precise but carry little information. The
//! largest value over time would be biased by its noise. Its standard error is the scatter of the
//! same median over the repetitions, and a third of the change when only every second sample is
//! used.

use super::estimate::{HALVED, raised};
use super::report::Estimate;

/// Total energies and losses of repetitions.
#[derive(Debug, Default)]
pub(super) struct Given {
    again: Vec<Vec<f64>>,
}

impl Given {
    pub(super) fn add(&mut self, again: Vec<f64>) {
        self.again.push(again);
    }

    /// `here`: total energy and losses of the measurement; `half`: from every other sample.
    pub(super) fn estimate(&self, here: &[f64], half: &[f64]) -> Estimate {
        let count = self.again.len() as f64;
        let mut mean = vec![0.0; here.len()];
        for again in &self.again {
            for (mean, again) in mean.iter_mut().zip(again) {
                *mean += again / count;
            }
        }
        let mut variance = vec![0.0; here.len()];
        for again in &self.again {
            for ((variance, again), mean) in variance.iter_mut().zip(again).zip(&mean) {
                *variance += (again - mean).powi(2) / count;
            }
        }
        let floor = median(&variance, &vec![1.0; here.len()]);
        let weights: Vec<f64> = match floor > 0.0 {
            true => variance.iter().map(|v| v.max(floor).recip()).collect(),
            false => vec![1.0; here.len()],
        };
        let corrected: Vec<f64> = here
            .iter()
            .zip(&mean)
            .map(|(here, mean)| 2.0 * here - mean)
            .collect();
        let value = median(&corrected, &weights);
        let squares: f64 = self
            .again
            .iter()
            .map(|again| {
                let scattered = corrected.iter().zip(again).zip(&mean);
                let scattered: Vec<f64> = scattered.map(|((c, a), m)| c + a - m).collect();
                (median(&scattered, &weights) - value).powi(2)
            })
            .sum();
        let error = raised(self.again.len()) * (squares / count).sqrt();
        let weights: Vec<f64> = weights.iter().step_by(2).copied().collect();
        let here: Vec<f64> = here.iter().step_by(2).copied().collect();
        let sampling = HALVED * (median(&here, &weights) - median(half, &weights));
        Estimate {
            value,
            error: error.hypot(sampling),
        }
    }
}

/// The weighted median.
fn median(values: &[f64], weights: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let half = 0.5 * weights.iter().sum::<f64>();
    let mut below = 0.0;
    for i in order {
        below += weights[i];
        if below >= half {
            return values[i];
        }
    }
    f64::NAN
}
