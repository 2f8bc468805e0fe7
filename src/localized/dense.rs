//! Small dense linear systems.
//!
//! Not taken from a library: the systems have only a few hundred rows, and solutions must be
//! reproducible bit for bit.

use std::ops::{Index, IndexMut};

/// A matrix in row-major order.
#[derive(Debug, Clone)]
pub(super) struct Matrix {
    columns: usize,
    values: Vec<f64>,
}

impl Matrix {
    pub(super) fn zeros(rows: usize, columns: usize) -> Matrix {
        Matrix {
            columns,
            values: vec![0.0; rows * columns],
        }
    }

    pub(super) fn rows(&self) -> usize {
        self.values.len() / self.columns
    }

    pub(super) fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.columns..][..self.columns]
    }

    pub(super) fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.values[row * self.columns..][..self.columns]
    }

    /// `A x`.
    #[cfg(test)]
    pub(super) fn times(&self, x: &[f64]) -> Vec<f64> {
        (0..self.rows()).map(|i| dot(self.row(i), x)).collect()
    }

    /// Solves `A x = b` by Gaussian elimination with partial pivoting; `None` where A is singular
    /// to rounding or not finite.
    pub(super) fn solve(mut self, mut b: Vec<f64>) -> Option<Vec<f64>> {
        let n = self.columns;
        let scale = self.values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let mut first = 0;
        while first < n {
            let last = (first + BLOCK).min(n);
            self.eliminate_panel(first, last, scale, &mut b)?;
            first = last;
        }
        for i in (0..n).rev() {
            let row = self.row(i);
            let known = dot(&row[i + 1..], &b[i + 1..]);
            b[i] = (b[i] - known) / row[i];
        }
        b.iter().all(|v| v.is_finite()).then_some(b)
    }

    /// Eliminates the panel of columns `first..last` below the diagonal. The columns to its right
    /// are updated once, with the whole panel (blocking).
    fn eliminate_panel(
        &mut self,
        first: usize,
        last: usize,
        scale: f64,
        b: &mut [f64],
    ) -> Option<()> {
        let n = self.columns;
        for k in first..last {
            let size = |i: &usize| self[(*i, k)].abs();
            let pivot = (k..n).max_by(|i, j| size(i).total_cmp(&size(j)))?;
            let largest = size(&pivot);
            if largest.is_nan() || largest <= f64::EPSILON * f64::EPSILON * scale {
                return None;
            }
            if pivot != k {
                let (above, below) = self.values.split_at_mut(pivot * n);
                above[k * n..][..n].swap_with_slice(&mut below[..n]);
                b.swap(k, pivot);
            }
            let (above, below) = self.values.split_at_mut((k + 1) * n);
            let pivot_row = &above[k * n..];
            for row in below.chunks_exact_mut(n) {
                let factor = row[k] / pivot_row[k];
                row[k] = factor;
                subtract(&mut row[k + 1..last], factor, &pivot_row[k + 1..last]);
            }
        }
        // The panel's own rows, to the right of the panel (triangular solve).
        for k in first..last {
            let (above, below) = self.values.split_at_mut((k + 1) * n);
            let pivot_row = &above[k * n + last..(k + 1) * n];
            for i in k + 1..last {
                let row = &mut below[(i - k - 1) * n..][..n];
                let factor = row[k];
                subtract(&mut row[last..], factor, pivot_row);
            }
        }
        let (panel, below) = self.values.split_at_mut(last * n);
        for row in below.chunks_exact_mut(n) {
            let (factors, rest) = row.split_at_mut(last);
            for (k, factor) in (first..last).zip(&factors[first..]) {
                subtract(rest, *factor, &panel[k * n + last..(k + 1) * n]);
            }
        }
        for i in first + 1..n {
            let known = first..i.min(last);
            b[i] -= dot(&self.row(i)[known.clone()], &b[known]);
        }
        Some(())
    }

    /// Minimizes `|A x - b|` by the normal equations. They lose half of the digits, which is
    /// accurate enough for a Gauss-Newton step.
    pub(super) fn least_squares(&self, b: &[f64]) -> Option<Vec<f64>> {
        let n = self.columns;
        let mut normal = Matrix::zeros(n, n);
        let mut right = vec![0.0; n];
        for (i, value) in b.iter().enumerate() {
            let row = self.row(i);
            for (j, &left) in row.iter().enumerate() {
                if left != 0.0 {
                    subtract(&mut normal.row_mut(j)[j..], -left, &row[j..]);
                }
            }
            subtract(&mut right, -value, row);
        }
        for i in 0..n {
            for j in 0..i {
                normal[(i, j)] = normal[(j, i)];
            }
        }
        normal.solve(right)
    }
}

/// Columns per panel.
const BLOCK: usize = 16;

impl Index<(usize, usize)> for Matrix {
    type Output = f64;

    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        &self.values[row * self.columns + column]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut f64 {
        &mut self.values[row * self.columns + column]
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `to -= factor * from`.
fn subtract(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to -= factor * from;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Not an ill-conditioned matrix, such as Hilbert's: that would hide a wrong pivot.
    fn matrix(rows: usize, columns: usize) -> Matrix {
        let mut a = Matrix::zeros(rows, columns);
        for i in 0..rows {
            for j in 0..columns {
                a[(i, j)] = ((1 + 3 * i * i + 7 * j + i * j) as f64).sin();
            }
        }
        a
    }

    #[test]
    fn val_known_solution_comes_back() {
        for n in [1, 2, 15, 16, 17, 63] {
            let a = matrix(n, n);
            let known: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let found = a.clone().solve(a.times(&known)).unwrap();
            for (f, k) in found.iter().zip(&known) {
                assert!((f - k).abs() < 1e-10, "{n}: {f} {k}");
            }
        }
    }

    #[test]
    fn val_least_squares_leaves_a_residual_normal_to_the_columns() {
        let a = matrix(40, 12);
        let b: Vec<f64> = (0..40).map(|i| (0.3 * i as f64).cos()).collect();
        let x = a.least_squares(&b).unwrap();
        let rest: Vec<f64> = a.times(&x).iter().zip(&b).map(|(a, b)| a - b).collect();
        assert!(dot(&rest, &rest) > 1.0);
        for j in 0..12 {
            let slope: f64 = (0..40).map(|i| a[(i, j)] * rest[i]).sum();
            assert!(slope.abs() < 1e-11, "{j}: {slope:e}");
        }
    }

    #[test]
    fn val_singular_systems_are_refused() {
        let mut a = matrix(20, 20);
        let twin = a.row(3).to_vec();
        a.row_mut(11).copy_from_slice(&twin);
        assert!(
            a.clone()
                .solve(vec![1.0; 20])
                .is_none_or(|x| x.iter().any(|v| v.abs() > 1e12))
        );
        a[(0, 0)] = f64::NAN;
        assert!(a.solve(vec![1.0; 20]).is_none());
    }
}
