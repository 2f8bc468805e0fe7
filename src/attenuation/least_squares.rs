//! Least squares for laws that are linear in all parameters but the first (variable projection).

use super::fit::{AttenuationLaw, Fit, Parameter};
use crate::numeric::{inverted, student_two_sided};

/// Floor of the relative residuals: below it all laws fit equally well, and the simplest is chosen.
const EXACT: f64 = 1e-8;

/// Share of a parameter's square that the others must leave.
const SINGULAR: f64 = 1e-13;

/// Grid size of the first parameter; the best grid point is refined.
pub(super) const GRID: usize = 600;

/// Best parameters and their residual sum of squares.
pub(super) struct Solution {
    pub(super) parameters: Vec<f64>,
    pub(super) squares: f64,
}

impl Solution {
    pub(super) fn residuals(&self, law: AttenuationLaw, points: &[(f64, f64)]) -> Vec<f64> {
        let off = |&(n, y): &(f64, f64)| law.at(&self.parameters, n) / y - 1.0;
        points.iter().map(off).collect()
    }
}

/// Searches the first parameter; the others follow by linear least squares.
pub(super) fn solve(law: AttenuationLaw, points: &[(f64, f64)]) -> Option<Solution> {
    let longest = points.iter().fold(1.0, |m: f64, (n, _)| m.max(*n));
    let squares = |first: f64| linear(law, first, points).map_or(f64::INFINITY, |(_, s)| s);
    let firsts = law.firsts(longest);
    let tried: Vec<f64> = firsts.iter().map(|first| squares(*first)).collect();
    let best = (0..GRID).min_by(|a, b| tried[*a].total_cmp(&tried[*b]))?;
    let [from, to] = [best.saturating_sub(1), (best + 1).min(GRID - 1)].map(|i| firsts[i]);
    let first = crate::chain::largest(from, to, |first| -squares(first)).0;
    let is_better = squares(first) <= tried[best];
    let first = if is_better { first } else { firsts[best] };
    let (weights, squares) = linear(law, first, points)?;
    let mut parameters = vec![first; law.searched()];
    parameters.extend(&weights[..law.parameters().len() - law.searched()]);
    Some(Solution {
        parameters,
        squares,
    })
}

/// Linear least squares for a given first parameter: weights and residual sum of squares.
fn linear(law: AttenuationLaw, first: f64, points: &[(f64, f64)]) -> Option<([f64; 2], f64)> {
    let mut normal = [[0.0; 2]; 2];
    let mut right = [0.0; 2];
    for &(n, y) in points {
        let shapes = law.shapes(first, n).map(|s| s / y);
        for i in 0..2 {
            right[i] += shapes[i];
            for j in 0..2 {
                normal[i][j] += shapes[i] * shapes[j];
            }
        }
    }
    let weights = if law == AttenuationLaw::Plateau {
        let [[a, b], [_, d]] = normal;
        let determinant = a * d - b * b;
        if determinant <= 1e-12 * a * d {
            return None;
        }
        [
            (d * right[0] - b * right[1]) / determinant,
            (a * right[1] - b * right[0]) / determinant,
        ]
    } else {
        [right[0] / normal[0][0], 0.0]
    };
    let off = points.iter().map(|&(n, y)| {
        let shapes = law.shapes(first, n);
        (weights[0] * shapes[0] + weights[1] * shapes[1]) / y - 1.0
    });
    let squares: f64 = off.map(|off| off * off).sum();
    squares.is_finite().then_some((weights, squares))
}

/// Lag-1 autocorrelation of the residuals, clamped to 0 to 0.98.
pub(super) fn correlation(residuals: &[f64]) -> f64 {
    let all: f64 = residuals.iter().map(|r| r * r).sum();
    let neighbours: f64 = residuals.windows(2).map(|r| r[0] * r[1]).sum();
    match all > 0.0 {
        true => (neighbours / all).clamp(0.0, 0.98),
        false => 0.0,
    }
}

pub(super) fn judged(
    law: AttenuationLaw,
    solution: &Solution,
    points: &[(f64, f64)],
    independent: f64,
) -> Option<Fit> {
    let (m, k) = (points.len() as f64, solution.parameters.len());
    let freedom = (independent - k as f64).max(1.0);
    let mean_square = (solution.squares / m).max(EXACT * EXACT);
    let fitted = (k + 1) as f64;
    let spare = (m - fitted - 1.0).max(0.5);
    let aicc = m * mean_square.ln() + 2.0 * fitted + 2.0 * fitted * (fitted + 1.0) / spare;
    let variance = solution.squares / freedom;
    let covariance = covariance(law, &solution.parameters, points, variance)?;
    let quantile = student_two_sided(0.05, freedom);
    let parameters = (0..k).map(|i| {
        let value = solution.parameters[i];
        let half = quantile * covariance[i][i].max(0.0).sqrt();
        Parameter {
            name: law.parameters()[i],
            value,
            low: value - half,
            high: value + half,
        }
    });
    Some(Fit {
        law,
        parameters: parameters.collect(),
        residual: mean_square.sqrt(),
        aicc,
        cross_validation: predicted(law, points)?.max(EXACT),
    })
}

/// `variance (J^T J)^-1` with the Jacobian J of the relative residuals.
fn covariance(
    law: AttenuationLaw,
    values: &[f64],
    points: &[(f64, f64)],
    variance: f64,
) -> Option<Vec<Vec<f64>>> {
    let k = values.len();
    let mut normal = vec![vec![0.0; k]; k];
    for &(n, y) in points {
        let shapes = law.shapes(values[0], n);
        let by_first = match law {
            AttenuationLaw::PowerLaw => -n.ln(),
            _ => -n,
        };
        let row = match law {
            AttenuationLaw::Level => [1.0 / y, 0.0, 0.0],
            _ => {
                let first = values[1] * by_first * shapes[0] / y;
                [first, shapes[0] / y, shapes[1] / y]
            }
        };
        for i in 0..k {
            for j in 0..k {
                normal[i][j] += row[i] * row[j];
            }
        }
    }
    let mut inverse = inverted(&normal, SINGULAR)?;
    let cells = inverse.iter_mut().flatten();
    cells.for_each(|cell| *cell *= variance);
    Some(inverse)
}

/// Root mean square of the relative errors of predicting each of five blocks from the others.
fn predicted(law: AttenuationLaw, points: &[(f64, f64)]) -> Option<f64> {
    const BLOCKS: usize = 5;
    let m = points.len();
    let mut squares = 0.0;
    for block in 0..BLOCKS {
        let held = block * m / BLOCKS..(block + 1) * m / BLOCKS;
        let rest = [&points[..held.start], &points[held.end..]].concat();
        let solution = solve(law, &rest)?;
        let off = solution.residuals(law, &points[held]);
        squares += off.iter().map(|r| r * r).sum::<f64>();
    }
    Some((squares / m as f64).sqrt())
}
