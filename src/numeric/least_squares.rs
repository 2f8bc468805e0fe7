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

/// Solves linear equations with several right sides, which stand behind the square matrix; `None` where a pivot is
/// at most the share `least` of its row.
pub(crate) fn eliminated(mut rows: Vec<Vec<f64>>, least: f64) -> Option<Vec<Vec<f64>>> {
    let n = rows.len();
    let size = |row: &Vec<f64>| row[..n].iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let mut sizes: Vec<f64> = rows.iter().map(size).collect();
    for i in 0..n {
        let largest = (i..n).max_by(|a, b| rows[*a][i].abs().total_cmp(&rows[*b][i].abs()))?;
        rows.swap(i, largest);
        sizes.swap(i, largest);
        let pivot = rows[i][i];
        if pivot.is_nan() || pivot.abs() <= least * sizes[i] {
            return None;
        }
        rows[i].iter_mut().for_each(|v| *v /= pivot);
        let row = rows[i].clone();
        for (j, other) in rows.iter_mut().enumerate() {
            let factor = other[i];
            if j != i {
                let cells = other.iter_mut().zip(&row);
                cells.for_each(|(v, r)| *v -= factor * r);
            }
        }
    }
    Some(rows.into_iter().map(|row| row[n..].to_vec()).collect())
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

    #[test]
    fn equations_that_depend_on_each_other_are_not_solved() {
        let near = |off: f64| vec![vec![1.0, 1.0, 1.0], vec![1.0, 1.0 + off, 2.0]];
        assert!(eliminated(near(1e-9), 1e-7).is_none());
        let solved = eliminated(near(0.5), 1e-7).unwrap();
        assert!((solved[0][0] + 1.0).abs() < 1e-15 && (solved[1][0] - 2.0).abs() < 1e-15);
    }
}
