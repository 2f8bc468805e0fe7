//! Travelling waves as roots of `u = mean + (K0 + theta K1) F(u)` with side conditions.

use super::dense::Matrix;

/// The unknowns are the values u at the grid times, one mean per block, and the parameter theta;
/// `F(u) = max(u, 0)^p`. The equations of motion are integrated twice, which makes the kernels
/// smooth. The conditions fix the integration constants (means and slopes).
#[derive(Debug)]
pub(super) struct Problem {
    pub(super) exponent: f64,
    pub(super) constant: Matrix,
    /// K1, the factor of theta; `None` without a parameter.
    pub(super) linear: Option<Matrix>,
    /// Unknown values per block; a block holds one function.
    pub(super) block: usize,
    pub(super) symmetry: Symmetry,
    /// Conditions `sum_j row_j u_j = 0`.
    pub(super) on_values: Vec<Vec<f64>>,
    /// Conditions `sum_j row_j F(u_j) = 0`.
    pub(super) on_forces: Vec<Vec<f64>>,
}

/// A root, or the last iterate.
#[derive(Debug, Clone)]
pub(super) struct Root {
    pub(super) values: Vec<f64>,
    pub(super) theta: f64,
    pub(super) iterations: usize,
    /// Largest residual over the largest value.
    pub(super) residual: f64,
    pub(super) converged: bool,
}

/// Symmetry of the unknown functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Symmetry {
    /// Even: a block holds half a period, both ends included.
    Even,
    None,
}

/// Whether theta is fixed or solved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parameter {
    Held,
    Free,
}

impl Problem {
    /// Newton's method from `values` and `theta`, with at most `most` steps. With more equations
    /// than unknowns (theta fixed), Gauss-Newton steps minimize the residual.
    pub(super) fn iterate(
        &self,
        parameter: Parameter,
        values: &[f64],
        theta: f64,
        most: usize,
    ) -> Option<Root> {
        let n = values.len();
        let mut root = Root {
            values: values.to_vec(),
            theta,
            iterations: 0,
            residual: f64::INFINITY,
            converged: false,
        };
        let mut means = self.means(values);
        let mut last = f64::INFINITY;
        while root.iterations < most {
            let (mut residual, jacobian) = self.linearised(parameter, &root, &means);
            let size = largest(&root.values);
            residual.iter_mut().for_each(|r| *r = -*r);
            let square = jacobian.rows() == jacobian.row(0).len();
            let step = if square {
                jacobian.solve(residual)?
            } else {
                jacobian.least_squares(&residual)?
            };
            let change = largest(&step[..n]) / size;
            // Far from a root the parameter is ill-determined; a step must not take it out of
            // range.
            let relative = step
                .get(n + means.len())
                .map_or(0.0, |d| d.abs() / root.theta.abs());
            let damping = if relative > MOST_CHANGE {
                MOST_CHANGE / relative
            } else {
                1.0
            };
            let mut steps = step.iter().map(|d| damping * d);
            for (value, step) in root.values.iter_mut().zip(&mut steps) {
                *value += step;
            }
            for (mean, step) in means.iter_mut().zip(&mut steps) {
                *mean += step;
            }
            root.theta += steps.next().unwrap_or(0.0);
            root.iterations += 1;
            if damping == 1.0 && (change < ROUNDING || (change < NEAR && change > 0.5 * last)) {
                root.converged = true;
                break;
            }
            last = change;
        }
        root.residual =
            largest(&self.linearised(parameter, &root, &means).0) / largest(&root.values);
        // The zero wave solves the equations too.
        let alive = largest(&root.values) > 1e-3 * largest(values);
        (alive && root.values.iter().all(|v| v.is_finite())).then_some(root)
    }

    /// Largest residual over the largest value.
    pub(super) fn residual(&self, values: &[f64], theta: f64) -> f64 {
        let root = Root {
            values: values.to_vec(),
            theta,
            iterations: 0,
            residual: f64::INFINITY,
            converged: false,
        };
        let (residual, _) = self.linearised(Parameter::Held, &root, &self.means(values));
        largest(&residual) / largest(values)
    }

    fn means(&self, values: &[f64]) -> Vec<f64> {
        let mean = |values: &[f64]| {
            let sum: f64 = values.iter().sum();
            match self.symmetry {
                Symmetry::Even => {
                    let ends = 0.5 * (values[0] + values[values.len() - 1]);
                    (sum - ends) / (values.len() - 1) as f64
                }
                Symmetry::None => sum / values.len() as f64,
            }
        };
        values.chunks(self.block).map(mean).collect()
    }

    fn linearised(&self, parameter: Parameter, root: &Root, means: &[f64]) -> (Vec<f64>, Matrix) {
        let (u, p, n) = (&root.values, self.exponent, root.values.len());
        let slope: Vec<f64> = u.iter().map(|u| p * u.max(0.0).powf(p - 1.0)).collect();
        let force: Vec<f64> = u
            .iter()
            .zip(&slope)
            .map(|(u, s)| u.max(0.0) * s / p)
            .collect();
        let free = parameter == Parameter::Free && self.linear.is_some();
        let columns = n + means.len() + usize::from(free);
        let rows = n + self.on_values.len() + self.on_forces.len();
        let mut jacobian = Matrix::zeros(rows, columns);
        let mut residual = Vec::with_capacity(rows);
        for i in 0..n {
            let row = jacobian.row_mut(i);
            let constant = self.constant.row(i);
            let mut fixed: f64 = constant.iter().zip(&force).map(|(k, f)| k * f).sum();
            match &self.linear {
                None => row
                    .iter_mut()
                    .zip(constant.iter().zip(&slope))
                    .for_each(|(to, (k, s))| *to = -k * s),
                Some(linear) => {
                    let linear = linear.row(i);
                    for j in 0..n {
                        row[j] = -(constant[j] + root.theta * linear[j]) * slope[j];
                    }
                    let rate: f64 = linear.iter().zip(&force).map(|(k, f)| k * f).sum();
                    fixed += root.theta * rate;
                    if free {
                        row[columns - 1] = -rate;
                    }
                }
            }
            row[i] += 1.0;
            let block = i / self.block;
            row[n + block] = -1.0;
            residual.push(u[i] - means[block] - fixed);
        }
        for (i, condition) in (n..).zip(&self.on_values) {
            jacobian.row_mut(i)[..n].copy_from_slice(condition);
            residual.push(condition.iter().zip(u).map(|(c, u)| c * u).sum());
        }
        for (i, condition) in (n + self.on_values.len()..).zip(&self.on_forces) {
            let row = jacobian.row_mut(i);
            row.iter_mut()
                .zip(condition.iter().zip(&slope))
                .for_each(|(to, (c, s))| *to = c * s);
            residual.push(condition.iter().zip(&force).map(|(c, f)| c * f).sum());
        }
        (residual, jacobian)
    }
}

/// Largest relative change of theta per step; longer steps are damped.
const MOST_CHANGE: f64 = 0.15;
/// Relative change of the values at which the iteration has converged to rounding.
const ROUNDING: f64 = 1e-14;
/// Below this relative change, the iteration has converged once the changes no longer halve.
const NEAR: f64 = 1e-9;

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}
