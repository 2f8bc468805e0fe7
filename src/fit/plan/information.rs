//! Sums of products of derivatives, and the information that they are.

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex;

use super::super::solver::dot;
use crate::transform::{RecordScratch, RecordTransform};

/// Sums over samples of the products of rows: derivatives of the record of a body, and behind them the record.
pub(super) fn products(rows: &[Vec<f64>], samples: Range<usize>) -> Array2<f64> {
    let part = |row: &Vec<f64>| row[samples.clone()].to_vec();
    let rows: Vec<Vec<f64>> = rows.iter().map(part).collect();
    Array2::from_shape_fn((rows.len(), rows.len()), |(i, j)| dot(&rows[i], &rows[j]))
}

/// The information that products are for noise of standard deviation `sigma`; the gain of the record is eliminated where
/// the weight of its standard error is stated.
pub(super) fn information(
    products: &Array2<f64>,
    gain_weight: Option<f64>,
    sigma: f64,
) -> Array2<f64> {
    let last = products.nrows() - 1;
    let record = gain_weight.map(|weight| products[[last, last]] + weight);
    let record = record.filter(|record| *record > 0.0);
    let of_gain = |i, j| record.map_or(0.0, |all| products[[i, last]] * products[[j, last]] / all);
    let entry = |(i, j)| (products[[i, j]] - of_gain(i, j)) / (sigma * sigma);
    Array2::from_shape_fn((last, last), entry)
}

/// The information of some bodies.
pub(super) fn sum(each: &[Array2<f64>], of: &[usize]) -> Array2<f64> {
    let nothing = Array2::zeros(each.first().map_or((0, 0), Array2::dim));
    of.iter().fold(nothing, |whole, body| whole + &each[*body])
}

/// Roots of the diagonal, 1 where it is 0.
pub(super) fn roots(whole: &Array2<f64>) -> Vec<f64> {
    let root = |value: &f64| if *value > 0.0 { value.sqrt() } else { 1.0 };
    whole.diag().iter().map(root).collect()
}

/// Rows, divided by sizes.
pub(super) fn scaled(whole: &Array2<f64>, sizes: &[f64]) -> Vec<Vec<f64>> {
    let row = |i: usize| {
        let row = (0..sizes.len()).map(|j| whole[[i, j]] / (sizes[i] * sizes[j]));
        row.collect()
    };
    (0..sizes.len()).map(row).collect()
}

/// Orthonormal cosine transform: bin k is at the frequency `k / (2 n dt)`, and sums of products stay what they are. The
/// mirrored record has no jump, so that ends do not look like high frequencies.
pub(in crate::fit) fn cosines(record: &[f64]) -> Vec<f64> {
    let n = record.len();
    let mirrored: Vec<f64> = record.iter().chain(record.iter().rev()).copied().collect();
    let transform = RecordTransform::<f64>::new(&vec![1.0; 2 * n], 2 * n);
    let mut scratch = RecordScratch::default();
    let spectrum = transform.spectra_of_rows(&mirrored, 1, &mut scratch);
    let bin = |k: usize| {
        let angle = -std::f64::consts::PI * k as f64 / (2 * n) as f64;
        let scale = if k == 0 { 1.0 } else { 2.0 } / n as f64;
        0.5 * scale.sqrt() * (spectrum[k] * Complex::from_polar(1.0, angle)).re
    };
    (0..n).map(bin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x_i = cos(pi k (i + 1/2) / n)` is one bin, and squares are kept (Parseval).
    #[test]
    fn val_closed_form_one_cosine_is_one_bin() {
        let n = 30;
        let angle = |i: usize| std::f64::consts::PI * 7.0 * (i as f64 + 0.5) / n as f64;
        let found = cosines(&(0..n).map(|i| angle(i).cos()).collect::<Vec<f64>>());
        for (k, value) in found.iter().enumerate() {
            let expected = if k == 7 { (n as f64 / 2.0).sqrt() } else { 0.0 };
            assert!((value - expected).abs() < 1e-13, "{k}: {value}");
        }
        let uneven: Vec<f64> = (0..31).map(|i| f64::from(i * i % 11) - 3.0).collect();
        let squares = |of: &[f64]| of.iter().map(|v| v * v).sum::<f64>();
        let ratio = squares(&cosines(&uneven)) / squares(&uneven);
        assert!((ratio - 1.0).abs() < 1e-14, "{ratio}");
    }
}
