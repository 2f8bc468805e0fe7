//! Travelling waves as roots of `u = mean + (K0 + theta K1) F(u)` with side conditions.

use super::series::largest;
use crate::numeric::{eliminated, least_residual};

/// The unknowns are the values u at the grid times, one mean per function, and the parameter theta;
/// `F(u) = max(u, 0)^p`. The equations of motion are integrated twice, which makes the kernels
/// smooth. The conditions fix the integration constants (means and slopes).
#[derive(Debug)]
pub(super) struct Problem {
    pub(super) exponent: f64,
    /// K0, and K1, the factor of theta.
    pub(super) kernels: [Vec<Vec<f64>>; 2],
    /// How many times of a period each unknown stands for.
    pub(super) weights: Vec<f64>,
    /// Unknown values per function.
    pub(super) block: usize,
    /// Conditions `sum_j row_j u_j = 0`.
    pub(super) on_values: Vec<Vec<f64>>,
    /// Conditions `sum_j row_j F(u_j) = 0`.
    pub(super) on_forces: Vec<Vec<f64>>,
}

/// A root, or an iterate.
#[derive(Debug, Clone)]
pub(super) struct Root {
    pub(super) values: Vec<f64>,
    pub(super) means: Vec<f64>,
    pub(super) theta: f64,
    pub(super) iterations: usize,
    /// Largest residual over the largest value.
    pub(super) residual: f64,
    pub(super) converged: bool,
}

/// Whether theta is fixed or solved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parameter {
    Held,
    Free,
}

impl Problem {
    /// Where an iteration starts.
    pub(super) fn start(&self, values: Vec<f64>, theta: f64) -> Root {
        let blocks = values
            .chunks(self.block)
            .zip(self.weights.chunks(self.block));
        let mean = |(values, weights): (&[f64], &[f64])| {
            let sum: f64 = values.iter().zip(weights).map(|(v, w)| v * w).sum();
            sum / weights.iter().sum::<f64>()
        };
        let mut root = Root {
            means: blocks.map(mean).collect(),
            values,
            theta,
            iterations: 0,
            residual: 0.0,
            converged: true,
        };
        root.residual = self.residual(&root);
        root
    }

    /// Newton's method, with at most `most` steps. With more equations than unknowns (theta fixed),
    /// Gauss-Newton steps minimize the residual.
    pub(super) fn iterate(
        &self,
        parameter: Parameter,
        mut root: Root,
        most: usize,
    ) -> Option<Root> {
        let (size, n) = (largest(&root.values), root.values.len());
        let mut last = f64::INFINITY;
        root.converged = false;
        for _ in 0..most {
            let rows = self.linearised(parameter, &root);
            let step = match rows.len() < rows[0].len() {
                true => eliminated(rows, SINGULAR)?,
                false => least_residual(&rows, SINGULAR)?,
            };
            let step = step.concat();
            let change = largest(&step[..n]) / largest(&root.values);
            // Far from a root the parameter is ill-determined; a step must not take it out of
            // range.
            let relative = step.get(n + root.means.len()).map(|d| d / root.theta);
            let damping = (MOST_CHANGE / relative.unwrap_or(0.0).abs()).min(1.0);
            let unknowns = root.values.iter_mut().chain(&mut root.means);
            let unknowns = unknowns.chain([&mut root.theta]).zip(&step);
            unknowns.for_each(|(unknown, step)| *unknown += damping * step);
            root.iterations += 1;
            if damping == 1.0 && (change < ROUNDING || (change < NEAR && change > 0.5 * last)) {
                root.converged = true;
                break;
            }
            last = change;
        }
        root.residual = self.residual(&root);
        // The zero wave solves the equations too.
        let is_alive = largest(&root.values) > 1e-3 * size;
        (is_alive && root.values.iter().all(|v| v.is_finite())).then_some(root)
    }

    fn residual(&self, root: &Root) -> f64 {
        let rows = self.linearised(Parameter::Held, root);
        let residuals: Vec<f64> = rows.iter().map(|row| row[row.len() - 1]).collect();
        largest(&residuals) / largest(&root.values)
    }

    /// Rows of the Jacobian, each with its negative residual behind it.
    fn linearised(&self, parameter: Parameter, root: &Root) -> Vec<Vec<f64>> {
        let (u, p, n) = (&root.values, self.exponent, root.values.len());
        let slope: Vec<f64> = u.iter().map(|u| p * u.max(0.0).powf(p - 1.0)).collect();
        let forces = u.iter().zip(&slope).map(|(u, s)| u.max(0.0) * s / p);
        let force: Vec<f64> = forces.collect();
        let columns = n + root.means.len() + usize::from(parameter == Parameter::Free);
        let [constant, linear] = &self.kernels;
        let equation = |i: usize| {
            let mut row = vec![0.0; columns + 1];
            let (mut sum, mut rate) = (0.0, 0.0);
            for (j, (constant, linear)) in constant[i].iter().zip(&linear[i]).enumerate() {
                let kernel = constant + root.theta * linear;
                row[j] = -kernel * slope[j];
                sum += kernel * force[j];
                rate += linear * force[j];
            }
            if parameter == Parameter::Free {
                row[columns - 1] = -rate;
            }
            row[i] += 1.0;
            row[n + i / self.block] = -1.0;
            row[columns] = root.means[i / self.block] + sum - u[i];
            row
        };
        let condition = |condition: &[f64], values: &[f64], slope: &[f64]| {
            let mut row: Vec<f64> = condition.iter().zip(slope).map(|(c, s)| c * s).collect();
            row.resize(columns, 0.0);
            let terms = condition.iter().zip(values).map(|(c, v)| c * v);
            row.push(-terms.sum::<f64>());
            row
        };
        let ones = vec![1.0; n];
        let on_values = (self.on_values.iter()).map(|row| condition(row, u, &ones));
        let on_forces = (self.on_forces.iter()).map(|row| condition(row, &force, &slope));
        (0..n)
            .map(equation)
            .chain(on_values)
            .chain(on_forces)
            .collect()
    }
}

/// Pivots below this share of their row are rounding.
const SINGULAR: f64 = f64::EPSILON * f64::EPSILON;
/// Largest relative change of theta per step; longer steps are damped.
const MOST_CHANGE: f64 = 0.15;
/// Relative change of the values at which the iteration has converged to rounding.
const ROUNDING: f64 = 1e-14;
/// Below this relative change, the iteration has converged once the changes no longer halve.
const NEAR: f64 = 1e-9;
