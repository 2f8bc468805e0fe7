//! Lines through points, with their intervals; power laws and their breaks.

use crate::numeric::student_two_sided;

/// A line `y = intercept + slope x` by least squares.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct LineFit {
    pub slope: f64,
    pub intercept: f64,
    /// Standard error of the slope from the residuals; it takes points for independent.
    pub slope_error: f64,
    /// Sum of the squared residuals.
    pub squares: f64,
    pub points: usize,
}

impl LineFit {
    /// `None` for fewer than three points, or for all at one x.
    pub(crate) fn through(points: &[(f64, f64)]) -> Option<LineFit> {
        let n = points.len() as f64;
        if points.len() < 3 {
            return None;
        }
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
        let (x0, y0) = (mean(|p| p.0), mean(|p| p.1));
        let (mut xx, mut xy) = (0.0, 0.0);
        for (x, y) in points {
            xx += (x - x0) * (x - x0);
            xy += (x - x0) * (y - y0);
        }
        if xx.is_nan() || xx <= 0.0 {
            return None;
        }
        let slope = xy / xx;
        let residual = |(x, y): &(f64, f64)| (y - y0 - slope * (x - x0)).powi(2);
        let squares: f64 = points.iter().map(residual).sum();
        Some(LineFit {
            slope,
            intercept: y0 - slope * x0,
            slope_error: (squares / (n - 2.0) / xx).sqrt(),
            squares,
            points: points.len(),
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

/// Mean and half of its interval at `1 - alpha`, of independent values: Student's t. `None` for fewer than two.
pub(crate) fn mean_of(values: &[f64], alpha: f64) -> Option<(f64, f64)> {
    let n = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let error = (squares / (n - 1.0) / n).sqrt();
    Some((mean, error * student_two_sided(alpha, n - 1.0)))
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
}
