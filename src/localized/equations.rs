//! The equations of a family's waves on a grid, and their unknowns as functions of time.

use super::dense::Matrix;
use super::family::Family;
use super::grid::Grid;
use super::problem::{Problem, Symmetry};
use super::series::Series;
use super::wave::Alternation;

impl Family {
    /// The equations on a grid; theta is the stiffening, minus 1 for the mass dimer.
    pub(super) fn problem(&self, grid: Grid) -> Problem {
        let n = grid.half + 1;
        let (plain, ahead, behind) = (grid.kernel(0.0), grid.kernel(0.5), grid.kernel(-0.5));
        match self.alternation {
            Alternation::Stiffness => {
                let both: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| a + b).collect();
                let mut soft = Matrix::zeros(2 * n, 2 * n);
                grid.fill_even(&plain, 2.0, &mut soft, (0, 0));
                grid.fill_even(&both, -1.0, &mut soft, (0, n));
                let mut stiff = Matrix::zeros(2 * n, 2 * n);
                grid.fill_even(&both, -1.0, &mut stiff, (n, 0));
                grid.fill_even(&plain, 2.0, &mut stiff, (n, n));
                let unit = |j: usize| (0..2 * n).map(|i| f64::from(u8::from(i == j))).collect();
                let end = |j: usize| if j == 0 || j == n - 1 { 0.5 } else { 1.0 };
                let balance = (0..2 * n).map(|j| if j < n { end(j) } else { -end(j - n) });
                let scale = 1.0 / n as f64;
                Problem {
                    exponent: self.exponent,
                    constant: soft,
                    linear: Some(stiff),
                    block: n,
                    symmetry: Symmetry::Even,
                    on_values: vec![unit(n - 1), unit(2 * n - 1)],
                    on_forces: vec![balance.map(|w| scale * w).collect()],
                }
            }
            Alternation::Mass => {
                let m = 2 * grid.half;
                let mut linear = Matrix::zeros(m, m);
                grid.fill_full(&plain, 1.0, false, &mut linear);
                grid.fill_full(&behind, -1.0, true, &mut linear);
                let mut constant = Matrix::zeros(m, m);
                grid.fill_full(&plain, 2.0, false, &mut constant);
                grid.fill_full(&behind, -1.0, true, &mut constant);
                grid.fill_full(&ahead, -1.0, true, &mut constant);
                let mut end = vec![0.0; m];
                end[m - 1] = 1.0;
                Problem {
                    exponent: self.exponent,
                    constant,
                    linear: Some(linear),
                    block: m,
                    symmetry: Symmetry::None,
                    on_values: vec![end, grid.slope_at_end()],
                    on_forces: Vec::new(),
                }
            }
        }
    }

    /// Values of psi on a grid.
    pub(super) fn sample(&self, grid: Grid, psi: &[Series; 2]) -> Vec<f64> {
        let half = grid.half as isize;
        match self.alternation {
            Alternation::Stiffness => psi
                .iter()
                .flat_map(|s| (0..=half).map(|j| s.value(grid.time(j))))
                .collect(),
            Alternation::Mass => (1 - half..=half)
                .map(|j| psi[0].value(grid.time(j)))
                .collect(),
        }
    }

    /// The inverse of [`Family::sample`].
    pub(super) fn series(&self, grid: Grid, values: &[f64]) -> [Series; 2] {
        match self.alternation {
            Alternation::Stiffness => {
                let (soft, stiff) = values.split_at(grid.half + 1);
                [soft, stiff].map(|v| Series::even(grid.period, v))
            }
            Alternation::Mass => {
                let series = Series::full(grid.period, values);
                let mirrored = series.reversed();
                [series, mirrored]
            }
        }
    }
}
