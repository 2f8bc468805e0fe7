//! Time grids over a period, and the kernels that map forces to overlaps on them.

use std::f64::consts::TAU;

use super::dense::Matrix;
use super::series::cosines;

/// The times `t_j = j L / (2 N)`: `j = 0..=N` for even functions, `j = 1 - N..=N` for others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    /// N.
    pub(super) half: usize,
    /// L.
    pub(super) period: f64,
}

impl Grid {
    /// The grid of about `density` points per unit of time.
    pub(super) fn new(period: f64, density: f64) -> Grid {
        Grid {
            half: (0.5 * period * density).ceil() as usize,
            period,
        }
    }

    pub(super) fn time(&self, j: isize) -> f64 {
        0.5 * self.period * j as f64 / self.half as f64
    }

    /// Samples `g(t_m + shift)`, `m = 0..2N`, of the kernel
    /// `g(t) = (1/N) sum_k cos(w_k t) / w_k^2`. With it, `x(t) = sum_j g(t - t_j) f(t_j)` solves
    /// `-x'' = f` up to the mean.
    pub(super) fn kernel(&self, shift: f64) -> Vec<f64> {
        let (n, m) = (self.half, 2 * self.half);
        let table = cosines(4 * m);
        let mut kernel = vec![0.0; m];
        for k in 1..=n {
            let w = TAU * k as f64 / self.period;
            let weight = if k == n { 0.5 } else { 1.0 } / (n as f64 * w * w);
            let (sin, cos) = (w * shift).sin_cos();
            for (j, value) in kernel.iter_mut().enumerate() {
                let turn = 4 * (k * j % m);
                *value += weight * (table[turn] * cos - table[(turn + 3 * m) % (4 * m)] * sin);
            }
        }
        kernel
    }

    /// Differentiation row: multiplied by the values on the full grid, it gives the slope at half a
    /// period.
    pub(super) fn slope_at_end(&self) -> Vec<f64> {
        let m = 2 * self.half;
        let w = TAU / self.period;
        (0..m)
            .map(|j| {
                let lag = TAU * (m - 1 - j) as f64 / m as f64;
                let terms = (1..self.half).map(|k| k as f64 * (lag * k as f64).sin());
                -2.0 * w * terms.sum::<f64>() / m as f64
            })
            .collect()
    }

    /// Adds to a block of `matrix` the convolution of an even function with an even kernel, times
    /// `factor`.
    pub(super) fn fill_even(
        &self,
        kernel: &[f64],
        factor: f64,
        matrix: &mut Matrix,
        origin: (usize, usize),
    ) {
        let n = self.half;
        for i in 0..=n {
            for j in 0..=n {
                let weight = if j == 0 || j == n { 0.5 } else { 1.0 } * factor;
                let (near, far) = (i.abs_diff(j), (i + j) % (2 * n));
                matrix[(origin.0 + i, origin.1 + j)] += weight * (kernel[near] + kernel[far]);
            }
        }
    }

    /// Adds the convolution of a function f, or of `f(-t)`, on the full grid with a kernel, times
    /// `factor`.
    pub(super) fn fill_full(
        &self,
        kernel: &[f64],
        factor: f64,
        reversed: bool,
        matrix: &mut Matrix,
    ) {
        let m = 2 * self.half;
        let first = m + 1 - self.half;
        for i in 0..m {
            for j in 0..m {
                // i and j count from the time of index 1 - N.
                let lag = if reversed {
                    i + j + 2 * first
                } else {
                    i + m - j
                };
                matrix[(i, j)] += factor * kernel[lag % m];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `-x'' = cos(2 w t)` and `-x'' = cos(2 w (t + s))` on both grids.
    #[test]
    fn val_closed_form_kernels_integrate_twice() {
        let grid = Grid {
            half: 12,
            period: 5.0,
        };
        let (w, shift) = (2.0 * TAU / 5.0, 0.4);
        let (plain, ahead, behind) = (grid.kernel(0.0), grid.kernel(shift), grid.kernel(-shift));
        let mut even = Matrix::zeros(13, 13);
        grid.fill_even(&plain, 1.0, &mut even, (0, 0));
        let both: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| a + b).collect();
        grid.fill_even(&both, 0.5, &mut even, (0, 0));
        let f: Vec<f64> = (0..13).map(|j| (w * grid.time(j)).cos()).collect();
        for (x, f) in even.times(&f).iter().zip(&f) {
            assert!((x - f * (1.0 + (w * shift).cos()) / (w * w)).abs() < 1e-14);
        }
        let mut full = Matrix::zeros(24, 24);
        grid.fill_full(&ahead, 1.0, false, &mut full);
        grid.fill_full(&behind, 2.0, true, &mut full);
        let f: Vec<f64> = (-11..13).map(|j| (w * grid.time(j) - 0.3).cos()).collect();
        for (x, j) in full.times(&f).iter().zip(-11..13) {
            let t = grid.time(j);
            let expected = (w * (t + shift) - 0.3).cos() + 2.0 * (-w * (t - shift) - 0.3).cos();
            assert!((x - expected / (w * w)).abs() < 1e-14, "{j}");
        }
    }
}
