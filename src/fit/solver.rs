//! Least squares within bounds, by the method of Levenberg and Marquardt.

pub(super) use crate::numeric::{dot, gram};
use crate::{Error, Result};

/// Steps at most, and tries of one.
const MOST_STEPS: usize = 60;
const MOST_TRIES: usize = 12;

/// The first damping, over the diagonal of the normal equations.
const DAMPING: f64 = 1e-3;

/// Decrease of the squares, over their mean, at which the search ends: a thousandth of a standard error is left.
const ENOUGH: f64 = 1e-6;

/// A residual as a function of coordinates within bounds.
pub(super) trait Problem {
    fn bounds(&self) -> Vec<[f64; 2]>;

    fn residual(&self, at: &[f64]) -> Result<Vec<f64>>;

    /// Squares that are errors of the residual itself.
    fn floor(&self) -> f64 {
        0.0
    }

    /// Minus the derivatives of the residual along each coordinate. `steps` are kept between calls.
    fn columns(&self, at: &[f64], steps: &mut Vec<f64>) -> Result<Vec<Vec<f64>>>;
}

/// Where a search ended.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Minimum {
    pub at: Vec<f64>,
    pub residual: Vec<f64>,
    pub squares: f64,
    pub columns: Vec<Vec<f64>>,
    /// Whether the squares fall no more.
    pub is_settled: bool,
}

/// The minimum next to a start. Each step solves `(J^T J + lambda D) d = J^T r` with D the largest diagonal so far;
/// lambda follows the ratio of the decrease to the predicted one. Coordinates at a bound that the gradient points
/// through are held.
///
/// Source: D. W. Marquardt, J. SIAM 11 (1963) 431; J. J. More, MINPACK; H. B. Nielsen, IMM-REP-1999-05 (lambda).
///
/// # Errors
/// Those of the residual at the start, and [`Error::Cancelled`]; elsewhere a residual that cannot be had ends no
/// search.
pub(super) fn minimize(problem: &dyn Problem, start: &[f64]) -> Result<Minimum> {
    let bounds = problem.bounds();
    let clamp = |u: f64, k: usize| u.clamp(bounds[k][0], bounds[k][1]);
    let mut at: Vec<f64> = (0..start.len()).map(|k| clamp(start[k], k)).collect();
    let mut residual = problem.residual(&at)?;
    let mut squares = square(&residual);
    let mut steps = Vec::new();
    let mut columns = problem.columns(&at, &mut steps)?;
    let mut scale = vec![0.0f64; at.len()];
    let (mut damping, mut growth) = (DAMPING, 2.0);
    let mut ended = None;
    for step in 0..MOST_STEPS {
        let matrix = gram(&columns);
        let gradient: Vec<f64> = columns.iter().map(|c| dot(c, &residual)).collect();
        let room = |k: usize| {
            let [down, up] = bounds[k].map(|end| end - at[k]);
            let is_held = (gradient[k] < 0.0 && down >= 0.0) || (gradient[k] > 0.0 && up <= 0.0);
            if is_held { [0.0; 2] } else { [down, up] }
        };
        let room: Vec<[f64; 2]> = (0..at.len()).map(room).collect();
        for k in 0..at.len() {
            scale[k] = scale[k].max(matrix[k][k]);
        }
        let mut accepted = None;
        for _ in 0..MOST_TRIES {
            let (change, is_cut) = bounded((&matrix, &gradient), &scale, damping, &room);
            let next: Vec<f64> = (0..at.len()).map(|k| clamp(at[k] + change[k], k)).collect();
            let moved: Vec<f64> = next.iter().zip(&at).map(|(a, b)| a - b).collect();
            let predicted = predicted(&matrix, &gradient, &moved);
            let enough = ENOUGH * squares / residual.len().max(1) as f64;
            if predicted <= enough && is_cut && squares > problem.floor() {
                damping *= growth;
                growth *= 2.0;
                continue;
            }
            if predicted <= enough || squares <= problem.floor() {
                ended = Some(true);
                break;
            }
            let tried = match problem.residual(&next) {
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                tried => tried.ok(),
            };
            let now = tried.as_ref().map_or(f64::INFINITY, |r| square(r));
            if now < squares {
                let ratio = (squares - now) / predicted;
                damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                growth = 2.0;
                accepted = tried.map(|residual| (next, residual, now));
                break;
            }
            damping *= growth;
            growth *= 2.0;
        }
        let Some((next, new, now)) = accepted else {
            ended = ended.or(Some(step > 0));
            break;
        };
        (at, residual, squares) = (next, new, now);
        columns = problem.columns(&at, &mut steps)?;
    }
    Ok(Minimum {
        at,
        residual,
        squares,
        columns,
        is_settled: ended.unwrap_or(false),
    })
}

pub(super) fn square(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}

/// Columns of length 1, and what they were divided by, 1 for columns of zeros.
pub(super) fn scaled(columns: &[Vec<f64>]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let size = |column: &Vec<f64>| match dot(column, column).sqrt() {
        0.0 => 1.0,
        size => size,
    };
    let sizes: Vec<f64> = columns.iter().map(size).collect();
    let columns = columns.iter().zip(&sizes);
    let columns = columns.map(|(column, size)| column.iter().map(|v| v / size).collect());
    (columns.collect(), sizes)
}

/// Columns made orthonormal, without what others explain.
#[derive(Clone, Default)]
pub(super) struct Beside {
    columns: Vec<Vec<f64>>,
}

impl Beside {
    /// Of columns of which more than a share of the squares is left beside those before them.
    pub fn of(columns: &[Vec<f64>], share: f64) -> Beside {
        let mut beside = Beside::default();
        for column in columns {
            beside.add(column, share);
        }
        beside
    }

    /// Adds a column, unless too little of its squares is left; returns it.
    pub fn add(&mut self, column: &[f64], share: f64) -> Option<&[f64]> {
        let rest = self.rest(column);
        let left = dot(&rest, &rest);
        if left.is_nan() || left <= share * dot(column, column) {
            return None;
        }
        let unit = rest.iter().map(|v| v / left.sqrt()).collect();
        self.columns.push(unit);
        self.columns.last().map(Vec::as_slice)
    }

    pub fn count(&self) -> usize {
        self.columns.len()
    }

    /// Without what the columns explain; twice, so that rounding is none.
    pub fn rest(&self, of: &[f64]) -> Vec<f64> {
        let mut rest = of.to_vec();
        for column in self.columns.iter().chain(&self.columns) {
            let share = dot(column, &rest);
            let pairs = rest.iter_mut().zip(column);
            pairs.for_each(|(r, c)| *r -= share * c);
        }
        rest
    }
}

/// By how much a step lowers the squares where the residual is linear.
fn predicted(matrix: &[Vec<f64>], gradient: &[f64], step: &[f64]) -> f64 {
    let rows = matrix.iter().zip(step);
    let bent: f64 = rows.map(|(row, s)| s * dot(row, step)).sum();
    2.0 * dot(gradient, step) - bent
}

/// The damped step within the room of each coordinate, and whether it was cut: coordinates that it would take further
/// go to the end of their room, and the others follow.
fn bounded(
    (matrix, gradient): (&[Vec<f64>], &[f64]),
    scale: &[f64],
    damping: f64,
    room: &[[f64; 2]],
) -> (Vec<f64>, bool) {
    let is_held = |ends: &[f64; 2]| ends[0] == ends[1];
    let mut fixed: Vec<Option<f64>> = room.iter().map(|r| is_held(r).then_some(0.0)).collect();
    let mut is_cut = false;
    loop {
        let change = damped((matrix, gradient), scale, damping, &fixed);
        let beyond =
            |k: &usize| fixed[*k].is_none() && !(room[*k][0]..=room[*k][1]).contains(&change[*k]);
        let Some(k) = (0..change.len()).find(beyond) else {
            return (change, is_cut);
        };
        is_cut = true;
        fixed[k] = Some(change[k].clamp(room[k][0], room[k][1]));
    }
}

fn damped(
    (matrix, gradient): (&[Vec<f64>], &[f64]),
    scale: &[f64],
    damping: f64,
    fixed: &[Option<f64>],
) -> Vec<f64> {
    let mut change: Vec<f64> = fixed.iter().map(|f| f.unwrap_or(0.0)).collect();
    let free: Vec<usize> = (0..change.len()).filter(|k| fixed[*k].is_none()).collect();
    let row = |&i: &usize| {
        let entry = |&j: &usize| match i == j {
            true => matrix[i][i] + (damping * scale[i]).max(f64::MIN_POSITIVE),
            false => matrix[i][j],
        };
        free.iter().map(entry).collect()
    };
    let rows: Vec<Vec<f64>> = free.iter().map(row).collect();
    let right = free.iter();
    let right = right.map(|&i| gradient[i] - dot(&matrix[i], &change));
    let right: Vec<f64> = right.collect();
    // No step where the matrix is none of least squares.
    if let Some(lower) = cholesky(&rows) {
        let step = free.iter().zip(solved(&lower, &right));
        step.for_each(|(&k, d)| change[k] = d);
    }
    change
}

/// The lower triangle whose product with its transpose is the matrix; `None` unless it is positive.
pub(super) fn cholesky(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let n = matrix.len();
    let mut lower = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let rest = matrix[i][j] - dot(&lower[i][..j], &lower[j][..j]);
            lower[i][j] = match i == j {
                true if rest > 0.0 => rest.sqrt(),
                true => return None,
                false => rest / lower[j][j],
            };
        }
    }
    Some(lower)
}

/// The solution for one right side.
pub(super) fn solved(lower: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let n = right.len();
    let mut x = right.to_vec();
    for i in 0..n {
        x[i] = (x[i] - dot(&lower[i][..i], &x[..i])) / lower[i][i];
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|j| lower[j][i] * x[j]).sum();
        x[i] = (x[i] - sum) / lower[i][i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The problem of Rosenbrock, without bounds and with one.
    struct Rosenbrock([f64; 2]);

    impl Problem for Rosenbrock {
        fn bounds(&self) -> Vec<[f64; 2]> {
            vec![self.0, [f64::NEG_INFINITY, f64::INFINITY]]
        }

        fn residual(&self, at: &[f64]) -> Result<Vec<f64>> {
            Ok(vec![10.0 * (at[1] - at[0] * at[0]), 1.0 - at[0]])
        }

        fn columns(&self, at: &[f64], _: &mut Vec<f64>) -> Result<Vec<Vec<f64>>> {
            Ok(vec![vec![20.0 * at[0], 1.0], vec![-10.0, 0.0]])
        }
    }

    /// J. J. More, B. S. Garbow, K. E. Hillstrom, ACM TOMS 7 (1981) 17, problem 1: minimum at (1, 1); below x = 0.5 at
    /// the bound, (0.5, 0.25).
    #[test]
    fn val_more_rosenbrock_with_and_without_a_bound() {
        for (bounds, expected) in [([-9.0, 9.0], [1.0, 1.0]), ([-9.0, 0.5], [0.5, 0.25])] {
            let found = minimize(&Rosenbrock(bounds), &[-1.2, 1.0]).unwrap();
            let mut pairs = found.at.iter().zip(expected);
            let is_near = pairs.all(|(a, b)| (a - b).abs() < 3e-6);
            assert!(found.is_settled && is_near, "{found:?}");
        }
    }
}
