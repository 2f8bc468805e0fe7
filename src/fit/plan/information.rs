//! Sums of products of derivatives, and the information that they are.

use std::ops::Range;

use num_complex::Complex;

use crate::transform::{RecordScratch, RecordTransform};

/// A symmetric matrix.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Matrix {
    count: usize,
    values: Vec<f64>,
}

impl Matrix {
    pub fn zero(count: usize) -> Matrix {
        Matrix {
            count,
            values: vec![0.0; count * count],
        }
    }

    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i * self.count + j]
    }

    pub fn add(&mut self, other: &Matrix) {
        let pairs = self.values.iter_mut().zip(&other.values);
        pairs.for_each(|(a, b)| *a += b);
    }

    pub fn sum(each: &[Matrix], of: &[usize]) -> Matrix {
        let mut whole = Matrix::zero(each.first().map_or(0, |one| one.count));
        of.iter().for_each(|i| whole.add(&each[*i]));
        whole
    }

    /// Roots of the diagonal, 1 where it is 0.
    pub fn roots(&self) -> Vec<f64> {
        let root = |i: usize| match self.at(i, i) {
            value if value > 0.0 => value.sqrt(),
            _ => 1.0,
        };
        (0..self.count).map(root).collect()
    }

    /// Rows, divided by sizes.
    pub fn scaled(&self, sizes: &[f64]) -> Vec<Vec<f64>> {
        let row = |i: usize| {
            let row = (0..self.count).map(|j| self.at(i, j) / (sizes[i] * sizes[j]));
            row.collect()
        };
        (0..self.count).map(row).collect()
    }
}

/// Sums over samples of a body: of its derivatives with each other and with its record, and of the record's squares.
pub(super) struct Sums {
    both: Matrix,
    with_record: Vec<f64>,
    record: f64,
}

impl Sums {
    pub fn new(unknowns: usize) -> Sums {
        Sums {
            both: Matrix::zero(unknowns),
            with_record: vec![0.0; unknowns],
            record: 0.0,
        }
    }

    /// Adds samples of rows: of derivatives, and behind them of the record.
    pub fn add(&mut self, rows: &[Vec<f64>], samples: Range<usize>) {
        let count = self.with_record.len();
        let sum = |a: &[f64], b: &[f64]| -> f64 {
            let pairs = a[samples.clone()].iter().zip(&b[samples.clone()]);
            pairs.map(|(a, b)| a * b).sum()
        };
        for i in 0..count {
            for j in 0..count {
                self.both.values[i * count + j] += sum(&rows[i], &rows[j]);
            }
            self.with_record[i] += sum(&rows[i], &rows[count]);
        }
        self.record += sum(&rows[count], &rows[count]);
    }

    /// The information of the body for noise of standard deviation `sigma`; its gain is eliminated where the weight of
    /// its standard error is stated.
    pub fn information(&self, gain_weight: Option<f64>, sigma: f64) -> Matrix {
        let mut whole = self.both.clone();
        let record = gain_weight.map(|weight| self.record + weight);
        if let Some(record) = record.filter(|record| *record > 0.0) {
            for (i, a) in self.with_record.iter().enumerate() {
                for (j, b) in self.with_record.iter().enumerate() {
                    whole.values[i * whole.count + j] -= a * b / record;
                }
            }
        }
        whole
            .values
            .iter_mut()
            .for_each(|value| *value /= sigma * sigma);
        whole
    }
}

/// Orthonormal cosine transform: bin k is at the frequency `k / (2 n dt)`, and sums of products stay what they are. The
/// mirrored record has no jump, so that ends do not look like high frequencies.
pub(in crate::fit) fn cosines(record: &[f64]) -> Vec<f64> {
    let n = record.len();
    let mirrored: Vec<f64> = record.iter().chain(record.iter().rev()).copied().collect();
    let transform = RecordTransform::<f64>::new(&vec![1.0; 2 * n], 2 * n);
    let mut scratch = RecordScratch::default();
    let (spectrum, _) = transform.transform(std::iter::once(&mirrored[..]), &mut scratch);
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
