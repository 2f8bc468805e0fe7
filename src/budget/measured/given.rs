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

/// `here`: total energy and losses of the measurement; `half`: from every other sample; `again`: of repetitions.
pub(super) fn estimate(here: &[f64], half: &[f64], again: &[Vec<f64>]) -> Estimate {
    let count = again.len() as f64;
    let over_repetitions = |i: usize, of: &dyn Fn(f64) -> f64| -> f64 {
        again.iter().map(|again| of(again[i]) / count).sum()
    };
    let all = 0..here.len();
    let mean: Vec<f64> = all.clone().map(|i| over_repetitions(i, &|x| x)).collect();
    let spread = |i: usize| over_repetitions(i, &|x| (x - mean[i]).powi(2));
    let variance: Vec<f64> = all.map(spread).collect();
    let floor = median(&variance, &vec![1.0; here.len()]);
    let weight = |v: &f64| {
        if floor > 0.0 {
            v.max(floor).recip()
        } else {
            1.0
        }
    };
    let weights: Vec<f64> = variance.iter().map(weight).collect();
    let pairs = here.iter().zip(&mean);
    let corrected: Vec<f64> = pairs.map(|(here, mean)| 2.0 * here - mean).collect();
    let value = median(&corrected, &weights);
    let squares = again.iter().map(|again| {
        let scattered = corrected.iter().zip(again).zip(&mean);
        let scattered: Vec<f64> = scattered.map(|((c, a), m)| c + a - m).collect();
        (median(&scattered, &weights) - value).powi(2)
    });
    let error = raised(again.len()) * (squares.sum::<f64>() / count).sqrt();
    let every_other = |values: &[f64]| -> Vec<f64> { values.iter().step_by(2).copied().collect() };
    let (weights, here) = (every_other(&weights), every_other(here));
    let sampling = HALVED * (median(&here, &weights) - median(half, &weights));
    Estimate {
        value,
        error: error.hypot(sampling),
    }
}

/// The weighted median.
fn median(values: &[f64], weights: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let half = 0.5 * weights.iter().sum::<f64>();
    let mut below = 0.0;
    let middle = order.into_iter().find(|i| {
        below += weights[*i];
        below >= half
    });
    middle.map_or(f64::NAN, |i| values[i])
}
