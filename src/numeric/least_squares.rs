//! Lines and parabolas through points, with their intervals; means, jackknives, small systems of equations.

use crate::numeric::student_two_sided;

/// A line `y = intercept + slope x` by weighted least squares.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct LineFit {
    pub slope: f64,
    pub intercept: f64,
    /// Standard error of the slope from the residuals; it takes points for independent.
    pub slope_error: f64,
    /// Sum of the squared residuals, by their weights.
    pub squares: f64,
    pub points: usize,
    /// Sum of the weights, the mean of x, and the sum of its squared deviations.
    #[serde(skip)]
    pub(crate) weight: f64,
    #[serde(skip)]
    pub(crate) middle: f64,
    #[serde(skip)]
    pub(crate) spread: f64,
}

impl LineFit {
    /// Through points of equal weight.
    pub(crate) fn through(points: &[(f64, f64)]) -> Option<LineFit> {
        LineFit::weighted(points.iter().map(|(x, y)| [*x, *y, 1.0]))
    }

    /// Through points `[x, y, weight]`. `None` for fewer than three points, or for all at one x.
    pub(crate) fn weighted(points: impl Iterator<Item = [f64; 3]> + Clone) -> Option<LineFit> {
        let sum = |of: &dyn Fn([f64; 3]) -> f64| points.clone().map(|p| p[2] * of(p)).sum::<f64>();
        let (count, weight) = (points.clone().count(), sum(&|_| 1.0));
        let [x, y] = [sum(&|p| p[0]) / weight, sum(&|p| p[1]) / weight];
        let spread = sum(&|p| (p[0] - x).powi(2));
        if count < 3 || spread.is_nan() || spread <= 0.0 {
            return None;
        }
        let slope = sum(&|p| (p[0] - x) * (p[1] - y)) / spread;
        let squares = sum(&|p| (p[1] - y - slope * (p[0] - x)).powi(2));
        Some(LineFit {
            slope,
            intercept: y - slope * x,
            slope_error: (squares / (count as f64 - 2.0) / spread).sqrt(),
            squares,
            points: count,
            weight,
            middle: x,
            spread,
        })
    }

    /// Half of the regression interval of the slope at `1 - alpha`: Student's t of `n - 2` degrees of freedom.
    pub fn half_interval(&self, alpha: f64) -> f64 {
        self.half_interval_of(alpha, 1.0)
    }

    /// The same where residuals follow those beside them, so that only one of `shared` points counts: the variance of the slope
    /// is as many times larger.
    pub(crate) fn half_interval_of(&self, alpha: f64, shared: f64) -> f64 {
        let degrees = (self.points as f64 / shared - 2.0).max(1.0);
        self.slope_error * shared.sqrt() * student_two_sided(alpha, degrees)
    }
}

/// Count, mean, and sum of the squared deviations.
fn squares_of(values: &[f64]) -> [f64; 3] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [n, mean, values.iter().map(|v| (v - mean).powi(2)).sum()]
}

/// Mean and half of its interval at `1 - alpha`, of independent values: Student's t. `None` for fewer than two.
pub(crate) fn mean_of(values: &[f64], alpha: f64) -> Option<(f64, f64)> {
    let [n, mean, squares] = squares_of(values);
    let half = || (squares / (n - 1.0) / n).sqrt() * student_two_sided(alpha, n - 1.0);
    (values.len() > 1).then(|| (mean, half()))
}

/// Standard deviation of independent values; 0 of one.
pub(crate) fn deviation(values: &[f64]) -> f64 {
    let [n, _, squares] = squares_of(values);
    (squares / (n - 1.0).max(1.0)).sqrt()
}

/// Standard error of a statistic from its values without each one of the samples. Source: B. Efron, "The Jackknife" (1982).
pub(crate) fn jackknife(without: &[f64]) -> f64 {
    let [n, _, squares] = squares_of(without);
    (squares * (n - 1.0) / n).sqrt()
}

/// The top of the parabola through the logarithms of three neighbouring powers, from the middle one, and the
/// logarithm of the power there.
pub(crate) fn parabola(powers: [f64; 3]) -> [f64; 2] {
    let least = (powers[1] * 1e-30).max(f64::MIN_POSITIVE);
    let [a, b, c] = powers.map(|p| p.max(least).ln());
    let curvature = 2.0 * b - a - c;
    let top = match curvature > 0.0 {
        true => (0.5 * (c - a) / curvature).clamp(-0.5, 0.5),
        false => 0.0,
    };
    [top, b + 0.25 * (c - a) * top]
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `J^T J` of the columns of J: the normal matrix.
pub(crate) fn gram(columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let row = |a: &Vec<f64>| columns.iter().map(|b| dot(a, b)).collect();
    columns.iter().map(row).collect()
}

/// Solves linear equations with several right sides, which stand behind the square matrix; `None` where a pivot is
/// at most the share `least` of its row.
///
/// Gaussian elimination with partial pivoting. What is right of a panel of columns is updated once, with the whole
/// panel (blocking).
pub(crate) fn eliminated(mut rows: Vec<Vec<f64>>, least: f64) -> Option<Vec<Vec<f64>>> {
    let n = rows.len();
    let size = |row: &Vec<f64>| row[..n].iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let mut sizes: Vec<f64> = rows.iter().map(size).collect();
    for first in (0..n).step_by(PANEL) {
        let last = n.min(first + PANEL);
        for k in first..last {
            let largest = (k..n).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs()))?;
            rows.swap(k, largest);
            sizes.swap(k, largest);
            let (above, below) = rows.split_at_mut(k + 1);
            let pivot = above[k][k];
            if pivot.is_nan() || pivot.abs() <= least * sizes[k] {
                return None;
            }
            for row in below {
                row[k] /= pivot;
                let factor = row[k];
                subtract(&mut row[k + 1..last], factor, &above[k][k + 1..last]);
            }
        }
        for i in first + 1..n {
            let (above, below) = rows.split_at_mut(i);
            let (factors, rest) = below[0].split_at_mut(last);
            for k in first..last.min(i) {
                subtract(rest, factors[k], &above[k][last..]);
            }
        }
    }
    for i in (0..n).rev() {
        let (row, solved) = rows[i..].split_first_mut()?;
        let (factors, right) = row.split_at_mut(n);
        for (factor, solved) in factors[i + 1..].iter().zip(solved) {
            subtract(right, *factor, &solved[n..]);
        }
        right.iter_mut().for_each(|v| *v /= factors[i]);
    }
    Some(rows.into_iter().map(|row| row[n..].to_vec()).collect())
}

/// Columns of a panel.
const PANEL: usize = 16;

/// `to -= factor * from`.
fn subtract(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to -= factor * from;
    }
}

/// The least residual of equations `A x = b`, rows of A with that of b behind: the normal equations solved. They lose
/// half of the digits.
pub(crate) fn least_residual(rows: &[Vec<f64>], least: f64) -> Option<Vec<Vec<f64>>> {
    let n = rows.first()?.len() - 1;
    let mut normal = vec![vec![0.0; n + 1]; n];
    for row in rows {
        let sums = normal.iter_mut().zip(row).enumerate();
        for (j, (sums, value)) in sums.filter(|(_, (_, value))| **value != 0.0) {
            subtract(&mut sums[j..], -value, &row[j..]);
        }
    }
    for i in 0..n {
        let (above, below) = normal.split_at_mut(i);
        let mirrored = below[0].iter_mut().zip(above);
        mirrored.for_each(|(value, row)| *value = row[i]);
    }
    eliminated(normal, least)
}

/// The inverse of a normal matrix, scaled to a diagonal of ones; `None` where of an unknown the others leave less than the share
/// `least`.
pub(crate) fn inverted(normal: &[Vec<f64>], least: f64) -> Option<Vec<Vec<f64>>> {
    let n = normal.len();
    let scale: Vec<f64> = (0..n).map(|i| normal[i][i].sqrt()).collect();
    let scaled = (0..n).map(|i| {
        let row = (0..n).map(|j| normal[i][j] / scale[i] / scale[j]);
        let unit = (0..n).map(|j| f64::from(i == j));
        row.chain(unit).collect()
    });
    let mut inverse = eliminated(scaled.collect(), least)?;
    for (i, row) in inverse.iter_mut().enumerate() {
        let cells = row.iter_mut().zip(&scale);
        cells.for_each(|(cell, other)| *cell = *cell / scale[i] / other);
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `scipy.stats.linregress` (SciPy 1.17.1) of a parabola.
    #[test]
    fn val_scipy_regression() {
        let points: Vec<(f64, f64)> = (0..8).map(f64::from).map(|x| (x, x * x)).collect();
        let fit = LineFit::through(&points).unwrap();
        assert!((fit.slope - 7.0).abs() < 1e-14 && (fit.intercept + 7.0).abs() < 1e-13);
        // The residuals x^2 - 7 x + 7 have the square sum 168.
        assert!((fit.squares - 168.0).abs() < 1e-12);
        assert!((fit.slope_error - (168.0f64 / 6.0 / 42.0).sqrt()).abs() < 1e-14);
        let half = 2.446_911_851_144_969 * fit.slope_error;
        assert!((fit.half_interval(0.05) - half).abs() < 1e-12);
        assert_eq!(LineFit::through(&points[..2]), None);
        assert_eq!(LineFit::through(&[(1.0, 1.0); 5]), None);
    }

    /// Not an ill-conditioned matrix, such as Hilbert's: that would hide a wrong pivot.
    fn rows(count: usize, columns: usize) -> Vec<Vec<f64>> {
        let value = |i: usize, j: usize| ((1 + 3 * i * i + 7 * j + i * j) as f64).sin();
        let row = |i| (0..columns).map(|j| value(i, j)).collect();
        (0..count).map(row).collect()
    }

    #[test]
    fn val_known_solution_of_panels() {
        for n in [1, 2, 15, 16, 17, 63] {
            let known: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let mut equations = rows(n, n);
            equations
                .iter_mut()
                .for_each(|row| row.push(dot(row, &known)));
            let found = eliminated(equations, 0.0).unwrap().concat();
            let off = found.iter().zip(&known).map(|(f, k)| (f - k).abs());
            assert!(off.fold(0.0, f64::max) < 1e-10, "{n}");
        }
        // Equations that depend on each other.
        let near = |off: f64| vec![vec![1.0, 1.0, 1.0], vec![1.0, 1.0 + off, 2.0]];
        assert!(eliminated(near(1e-9), 1e-7).is_none() && eliminated(near(0.5), 1e-7).is_some());
    }

    #[test]
    fn val_a_least_residual_is_normal_to_the_columns() {
        let equations = rows(40, 13);
        let x = least_residual(&equations, 0.0).unwrap().concat();
        let rest: Vec<f64> = equations.iter().map(|row| dot(row, &x) - row[12]).collect();
        assert!(dot(&rest, &rest) > 1.0);
        for j in 0..12 {
            let column: Vec<f64> = equations.iter().map(|row| row[j]).collect();
            assert!(dot(&column, &rest).abs() < 1e-11, "{j}");
        }
    }
}
