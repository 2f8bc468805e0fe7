//! Integrals over time from uniform samples.
//!
//! Each interval takes the integral of the polynomial through the samples nearest to it; near the
//! ends the same samples serve several intervals. With P points the error of a smooth integrand
//! falls as `dt^P` (one more for odd P); a kink `|t|^s` limits it to `dt^{s+1}`.

use ndarray::{Array2, ArrayView2, Axis};

use crate::chain::integral_of_lagrange;

/// Points of the polynomials that velocities are integrated with: kinks where contacts open
/// (`t^{5/2}` of a Hertz contact) leave nothing to higher orders.
pub(super) const CUBIC: usize = 4;

/// Integrals from the first sample to each, of every column of `(time, column)`, by polynomials through so many points, or all where
/// there are fewer.
pub(super) fn running(rates: ArrayView2<f64>, dt: f64, points: usize) -> Array2<f64> {
    let samples = rates.nrows();
    let points = points.min(samples);
    // By where among its points an interval begins.
    let begins = 0..points.saturating_sub(1);
    let weights: Vec<Vec<f64>> = begins.map(|s| interval(points, s)).collect();
    let mut out = Array2::zeros(rates.dim());
    for i in 0..samples.saturating_sub(1) {
        let first = (i + 1).saturating_sub(points / 2).min(samples - points);
        let (before, mut after) = out.view_mut().split_at(Axis(0), i + 1);
        let mut now = after.row_mut(0);
        now.assign(&before.row(i));
        for (n, weight) in weights[i - first].iter().enumerate() {
            now.scaled_add(dt * weight, &rates.row(first + n));
        }
    }
    out
}

/// Weights of the samples 0, 1, ... in the integral from `s` to `s + 1`.
fn interval(points: usize, s: usize) -> Vec<f64> {
    let places: Vec<f64> = (0..points).map(|j| j as f64 - s as f64).collect();
    let all: Vec<usize> = (0..points).collect();
    let weight = |j: &usize| integral_of_lagrange(&places, &all, *j, 1.0);
    all.iter().map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_calculus_polynomials_are_integrated_exactly() {
        for samples in [1, 2, 3, 4, 7, 8, 9, 20] {
            for points in [2, CUBIC, 8] {
                let degree = points.min(samples) as i32 - 1;
                let values = Array2::from_shape_fn((samples, 1), |(i, _)| {
                    (0.1 * i as f64 - 0.3).powi(degree)
                });
                let sums = running(values.view(), 0.1, points);
                let primitive = |t: f64| t.powi(degree + 1) / f64::from(degree + 1);
                for i in 0..samples {
                    let expected = primitive(0.1 * i as f64 - 0.3) - primitive(-0.3);
                    assert!(
                        (sums[[i, 0]] - expected).abs() < 3e-15, // of up to 5.4
                        "{samples} {points} {i}"
                    );
                }
            }
        }
    }
}
