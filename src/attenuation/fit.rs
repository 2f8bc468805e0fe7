//! Laws of attenuation fitted to a curve, and the length at which one reaches a level.

use serde::Serialize;

/// What a curve may follow, with lengths n in bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// `c`.
    Level,
    /// `a exp(-r n)`.
    Exponential,
    /// `a n^-p`.
    PowerLaw,
    /// `c + a exp(-r n)`: what settles.
    Plateau,
}

impl Law {
    pub const ALL: [Law; 4] = [Law::Level, Law::Exponential, Law::PowerLaw, Law::Plateau];

    /// Names of the parameters; the first one is the rate or the power, except of a level.
    pub fn parameters(self) -> &'static [&'static str] {
        match self {
            Law::Level => &["c"],
            Law::Exponential => &["r", "a"],
            Law::PowerLaw => &["p", "a"],
            Law::Plateau => &["r", "a", "c"],
        }
    }

    /// Shapes whose sum, weighted by all parameters but the first, is the law.
    fn shapes(self, first: f64, n: f64) -> [f64; 2] {
        match self {
            Law::Level => [1.0, 0.0],
            Law::Exponential => [(-first * n).exp(), 0.0],
            Law::PowerLaw => [n.powf(-first), 0.0],
            Law::Plateau => [(-first * n).exp(), 1.0],
        }
    }

    /// How many parameters do not enter linearly.
    fn searched(self) -> usize {
        match self {
            Law::Level => 0,
            _ => 1,
        }
    }

    fn at(self, parameters: &[f64], n: f64) -> f64 {
        let shapes = self.shapes(parameters[0], n);
        let weights = &parameters[self.searched()..];
        weights.iter().zip(shapes).map(|(w, s)| w * s).sum()
    }

    /// Where the first parameter is looked for, from curves of lengths up to `longest`.
    fn firsts(self, longest: f64) -> Vec<f64> {
        let even = |from: f64, to: f64| {
            let step = (to - from) / (GRID - 1) as f64;
            (0..GRID).map(move |i| from + step * i as f64).collect()
        };
        match self {
            Law::Level => vec![0.0; GRID],
            Law::Exponential => even(-1.0 / longest, 3.0),
            Law::PowerLaw => even(-1.0, 5.0),
            // Slower than the record, it is a line.
            Law::Plateau => {
                let ends = [(0.5 / longest).ln(), 3f64.ln()];
                let logs: Vec<f64> = even(ends[0], ends[1]);
                logs.into_iter().map(f64::exp).collect()
            }
        }
    }
}

/// Relative residuals below which one law is as good as another, and the simplest is chosen.
const EXACT: f64 = 1e-8;

/// Values of the first parameter at which a fit is tried before the best of them is refined.
const GRID: usize = 600;

/// By what a law is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// Akaike's information criterion, corrected for few points.
    #[default]
    Aicc,
    /// The error of predicting a fifth of the points from the others, in blocks.
    CrossValidation,
}

/// A parameter and the interval that holds it with a probability of 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parameter {
    pub name: &'static str,
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// One law fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fit {
    pub law: Law,
    pub parameters: Vec<Parameter>,
    /// Root mean square of the residuals, relative to the values.
    pub residual: f64,
    pub aicc: f64,
    /// Root mean square of the errors of prediction, relative to the values.
    pub cross_validation: f64,
    /// Covariance of the parameters, row by row, and the quantile that makes intervals of it.
    #[serde(skip)]
    covariance: Vec<f64>,
    #[serde(skip)]
    quantile: f64,
}

/// All laws, the chosen one first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fits {
    pub criterion: Criterion,
    /// Points that were fitted, and how many of them count as independent.
    pub points: usize,
    pub independent: f64,
    pub fits: Vec<Fit>,
}

/// A length with its interval of 95 %, in bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Length {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

impl Fits {
    pub fn chosen(&self) -> &Fit {
        &self.fits[0]
    }
}

/// Fits every law to the values `y` at lengths `n`, by least squares of residuals relative to the
/// values.
///
/// Neighbouring points of a computed curve err together: with a correlation rho between the
/// residuals of neighbours, of m points only `m (1 - rho) / (1 + rho)` count as independent in the
/// intervals. Akaike's criterion counts all of them, since a law is to describe the curve rather
/// than to predict noise; counting few, it would choose a level for whatever falls. `None` for fewer than six points, and for values that
/// are not positive.
pub fn fit(n: &[f64], y: &[f64], criterion: Criterion) -> Option<Fits> {
    let m = n.len().min(y.len());
    let usable = m >= 6 && n.iter().chain(y).all(|v| *v > 0.0 && v.is_finite());
    if !usable {
        return None;
    }
    let points: Vec<(f64, f64)> = n.iter().copied().zip(y.iter().copied()).collect();
    let solutions: Vec<(Law, Solution)> = Law::ALL
        .iter()
        .filter_map(|law| Some((*law, solve(*law, &points)?)))
        .collect();
    // The richest law leaves least that is not noise.
    let smoothest = solutions
        .iter()
        .min_by(|a, b| a.1.squares.total_cmp(&b.1.squares))?;
    let rho = correlation(&smoothest.1.residuals(smoothest.0, &points));
    let independent = (m as f64 * (1.0 - rho) / (1.0 + rho)).clamp(5.5, m as f64);
    let mut fits: Vec<Fit> = solutions
        .into_iter()
        .filter_map(|(law, solution)| judged(law, &solution, &points, independent))
        .collect();
    fits.sort_by(|a, b| match criterion {
        Criterion::Aicc => a.aicc.total_cmp(&b.aicc),
        Criterion::CrossValidation => a.cross_validation.total_cmp(&b.cross_validation),
    });
    (!fits.is_empty()).then_some(Fits {
        criterion,
        points: m,
        independent,
        fits,
    })
}

impl Fit {
    /// The law at a length.
    pub fn at(&self, n: f64) -> f64 {
        self.law.at(&self.values(), n)
    }

    /// What the law settles at for long chains; infinite for one that grows.
    pub fn settles_at(&self) -> f64 {
        let grows = f64::INFINITY;
        match (self.law, self.parameters[0].value > 0.0) {
            (Law::Level, _) => self.parameters[0].value,
            (Law::Plateau, true) => self.parameters[2].value,
            (Law::Exponential | Law::PowerLaw, true) => 0.0,
            (_, false) => grows,
        }
    }

    /// The length at which the law is at a level, with its interval; `None` where it never is.
    pub fn reaches(&self, level: f64) -> Option<Length> {
        let values = self.values();
        let value = reaches(self.law, &values, level)?;
        let k = values.len();
        let slope = |i: usize| {
            let h = 1e-6 * values[i].abs().max(1e-9);
            let moved = |by: f64| {
                let mut values = values.clone();
                values[i] += by;
                reaches(self.law, &values, level).unwrap_or(value)
            };
            (moved(h) - moved(-h)) / (2.0 * h)
        };
        let slopes: Vec<f64> = (0..k).map(slope).collect();
        let variance: f64 = (0..k * k)
            .map(|at| slopes[at / k] * self.covariance[at] * slopes[at % k])
            .sum();
        let half = self.quantile * variance.max(0.0).sqrt();
        Some(Length {
            value,
            low: (value - half).max(0.0),
            high: value + half,
        })
    }

    fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }
}

fn reaches(law: Law, values: &[f64], level: f64) -> Option<f64> {
    let &[first, a, ..] = values else {
        return None;
    };
    let n = match law {
        Law::Level => return None,
        Law::Exponential => (a / level).ln() / first,
        Law::PowerLaw => (a / level).powf(1.0 / first),
        Law::Plateau => (a / (level - values[2])).ln() / first,
    };
    (n.is_finite() && n >= 0.0).then_some(n)
}

/// Best parameters and the sum of squares they leave.
struct Solution {
    parameters: Vec<f64>,
    squares: f64,
}

impl Solution {
    fn residuals(&self, law: Law, points: &[(f64, f64)]) -> Vec<f64> {
        let off = |&(n, y): &(f64, f64)| law.at(&self.parameters, n) / y - 1.0;
        points.iter().map(off).collect()
    }
}

/// All but the first parameter enter linearly, so that one is searched and the others follow.
fn solve(law: Law, points: &[(f64, f64)]) -> Option<Solution> {
    let longest = points.iter().fold(1.0, |m: f64, (n, _)| m.max(*n));
    let squares = |first: f64| linear(law, first, points).map_or(f64::INFINITY, |(_, s)| s);
    let firsts = law.firsts(longest);
    let tried: Vec<f64> = firsts.iter().map(|first| squares(*first)).collect();
    let best = (0..GRID).min_by(|a, b| tried[*a].total_cmp(&tried[*b]))?;
    let (from, to) = (
        firsts[best.saturating_sub(1)],
        firsts[(best + 1).min(GRID - 1)],
    );
    let first = crate::chain::largest(from, to, |first| -squares(first)).0;
    let first = if squares(first) <= tried[best] {
        first
    } else {
        firsts[best]
    };
    let (weights, squares) = linear(law, first, points)?;
    let mut parameters = vec![first; law.searched()];
    parameters.extend(&weights[..law.parameters().len() - law.searched()]);
    Some(Solution {
        parameters,
        squares,
    })
}

/// Least squares for the parameters that enter linearly.
fn linear(law: Law, first: f64, points: &[(f64, f64)]) -> Option<([f64; 2], f64)> {
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
    let weights = if law == Law::Plateau {
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
    let squares: f64 = points
        .iter()
        .map(|&(n, y)| {
            let shapes = law.shapes(first, n);
            let off = (weights[0] * shapes[0] + weights[1] * shapes[1]) / y - 1.0;
            off * off
        })
        .sum();
    squares.is_finite().then_some((weights, squares))
}

/// Correlation of neighbouring residuals, 0 to 0.98.
fn correlation(residuals: &[f64]) -> f64 {
    let all: f64 = residuals.iter().map(|r| r * r).sum();
    let neighbours: f64 = residuals.windows(2).map(|r| r[0] * r[1]).sum();
    if all > 0.0 {
        (neighbours / all).clamp(0.0, 0.98)
    } else {
        0.0
    }
}

fn judged(law: Law, solution: &Solution, points: &[(f64, f64)], independent: f64) -> Option<Fit> {
    let (m, k) = (points.len() as f64, solution.parameters.len());
    let freedom = (independent - k as f64).max(1.0);
    let mean_square = (solution.squares / m).max(EXACT * EXACT);
    let fitted = (k + 1) as f64;
    let spare = (m - fitted - 1.0).max(0.5);
    let aicc = m * mean_square.ln() + 2.0 * fitted + 2.0 * fitted * (fitted + 1.0) / spare;
    let variance = solution.squares / freedom;
    let covariance = covariance(law, &solution.parameters, points, variance)?;
    let quantile = student(freedom);
    let names = law.parameters();
    let parameters = (0..k)
        .map(|i| {
            let (value, half) = (
                solution.parameters[i],
                quantile * covariance[i * k + i].max(0.0).sqrt(),
            );
            Parameter {
                name: names[i],
                value,
                low: value - half,
                high: value + half,
            }
        })
        .collect();
    Some(Fit {
        law,
        parameters,
        residual: mean_square.sqrt(),
        aicc,
        cross_validation: predicted(law, points)?.max(EXACT),
        covariance,
        quantile,
    })
}

/// `variance (J^T J)^-1` with the derivatives J of the relative residuals.
fn covariance(law: Law, values: &[f64], points: &[(f64, f64)], variance: f64) -> Option<Vec<f64>> {
    let k = values.len();
    let mut normal = [[0.0; 3]; 3];
    for &(n, y) in points {
        let shapes = law.shapes(values[0], n);
        let by_first = match law {
            Law::PowerLaw => -n.ln(),
            _ => -n,
        };
        let row = match law {
            Law::Level => [1.0 / y, 0.0, 0.0],
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
    let inverse = inverse(normal, k)?;
    let all = (0..k * k).map(|at| variance * inverse[at / k][at % k]);
    Some(all.collect())
}

/// By Gauss-Jordan elimination of a scaled matrix of k rows; `None` where it is singular.
fn inverse(mut a: [[f64; 3]; 3], k: usize) -> Option<[[f64; 3]; 3]> {
    let scale: [f64; 3] = std::array::from_fn(|i| if i < k { a[i][i].sqrt() } else { 1.0 });
    if scale.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
        return None;
    }
    let mut b = [[0.0; 3]; 3];
    for i in 0..k {
        b[i][i] = 1.0;
        for j in 0..k {
            a[i][j] /= scale[i] * scale[j];
        }
    }
    for column in 0..k {
        let pivot = a[column][column];
        if pivot < 1e-13 {
            return None;
        }
        for j in 0..k {
            a[column][j] /= pivot;
            b[column][j] /= pivot;
        }
        for i in (0..k).filter(|i| *i != column) {
            let factor = a[i][column];
            for j in 0..k {
                a[i][j] -= factor * a[column][j];
                b[i][j] -= factor * b[column][j];
            }
        }
    }
    for i in 0..k {
        for j in 0..k {
            b[i][j] /= scale[i] * scale[j];
        }
    }
    Some(b)
}

/// Root mean square of relative errors where each of five blocks is predicted from the others.
fn predicted(law: Law, points: &[(f64, f64)]) -> Option<f64> {
    const BLOCKS: usize = 5;
    let m = points.len();
    let mut squares = 0.0;
    for block in 0..BLOCKS {
        let held = block * m / BLOCKS..(block + 1) * m / BLOCKS;
        let rest: Vec<(f64, f64)> = (0..m)
            .filter(|i| !held.contains(i))
            .map(|i| points[i])
            .collect();
        let solution = solve(law, &rest)?;
        let off = solution.residuals(law, &points[held]);
        squares += off.iter().map(|r| r * r).sum::<f64>();
    }
    Some((squares / m as f64).sqrt())
}

/// The quantile 0.975 of Student's distribution.
///
/// Source: R. A. Fisher, E. A. Cornish, Technometrics 2 (1960) 209; below five degrees of freedom by
/// interpolating the tabulated values in the inverse of the freedom.
fn student(freedom: f64) -> f64 {
    const FEW: [f64; 5] = [12.706, 4.303, 3.182, 2.776, 2.571];
    if freedom < 5.0 {
        let at = freedom.max(1.0);
        let low = at.floor();
        let [a, b] = [FEW[low as usize - 1], FEW[low as usize]];
        let share = (1.0 / low - 1.0 / at) / (1.0 / low - 1.0 / (low + 1.0));
        return a + share * (b - a);
    }
    let z: f64 = 1.959_963_984_540_054;
    let terms = [
        (z.powi(3) + z) / 4.0,
        (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0,
        (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0,
    ];
    z + terms[0] / freedom + terms[1] / freedom.powi(2) + terms[2] / freedom.powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lengths(m: usize) -> Vec<f64> {
        (1..=m).map(|n| n as f64).collect()
    }

    fn along(n: &[f64], law: impl Fn(f64) -> f64) -> Vec<f64> {
        n.iter().map(|n| law(*n)).collect()
    }

    #[test]
    fn val_laws_are_found_again() {
        let n = lengths(40);
        for (law, y, expected) in [
            (
                Law::Exponential,
                along(&n, |n| 0.9 * (-n / 25.0).exp()),
                vec![0.04, 0.9],
            ),
            (
                Law::PowerLaw,
                along(&n, |n| 1.1 * n.powf(-0.7)),
                vec![0.7, 1.1],
            ),
            (
                Law::Plateau,
                along(&n, |n| 0.6 + 0.3 * (-0.2 * n).exp()),
                vec![0.2, 0.3, 0.6],
            ),
        ] {
            for criterion in [Criterion::Aicc, Criterion::CrossValidation] {
                let fits = fit(&n, &y, criterion).unwrap();
                let chosen = fits.chosen();
                assert_eq!(chosen.law, law, "{fits:?}");
                for (p, expected) in chosen.parameters.iter().zip(&expected) {
                    assert!((p.value - expected).abs() < 2e-7, "{p:?} {expected}");
                }
            }
        }
    }

    /// Of 400 noisy curves about 95 % have the true rate, and the length that reaches a level, in
    /// their intervals.
    #[test]
    fn val_intervals_hold_the_truth_as_often_as_they_say() {
        let n = lengths(30);
        let mut state = 7;
        // Twelve uniform numbers make a nearly normal one.
        let mut noise = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                let (next, bits) = crate::reference::split_mix(state);
                state = next;
                sum += (bits >> 11) as f64 / (1_u64 << 53) as f64;
            }
            sum
        };
        let mut held = [0; 2];
        for _ in 0..400 {
            let y = along(&n, |n| (-0.05 * n).exp());
            let y: Vec<f64> = y.iter().map(|y| y * (1.0 + 0.03 * noise())).collect();
            let fits = fit(&n, &y, Criterion::Aicc).unwrap();
            let exponential = fits
                .fits
                .iter()
                .find(|f| f.law == Law::Exponential)
                .unwrap();
            let rate = exponential.parameters[0];
            held[0] += usize::from(rate.low <= 0.05 && 0.05 <= rate.high);
            let length = exponential.reaches(0.4).unwrap();
            let truth = 2.5f64.ln() / 0.05;
            held[1] += usize::from(length.low <= truth && truth <= length.high);
        }
        println!("{held:?} of 400");
        for held in held {
            assert!((368..=396).contains(&held), "{held}");
        }
    }

    #[test]
    fn val_students_quantiles() {
        for (freedom, expected) in [
            (1.0, 12.706),
            (3.0, 3.182),
            (4.0, 2.776),
            (10.0, 2.228),
            (60.0, 2.000),
        ] {
            let found = student(freedom);
            assert!((found - expected).abs() < 3e-3, "{freedom}: {found}");
        }
    }

    #[test]
    fn what_cannot_be_fitted_is_not() {
        let n = lengths(5);
        assert!(fit(&n, &[1.0; 5], Criterion::Aicc).is_none());
        let n = lengths(8);
        assert!(fit(&n, &[0.0; 8], Criterion::Aicc).is_none());
        let level = fit(&n, &[0.5; 8], Criterion::Aicc).unwrap();
        assert_eq!(level.chosen().law, Law::Level);
        assert!((level.chosen().at(4.0) - 0.5).abs() < 1e-12);
        assert!(level.chosen().reaches(0.4).is_none());
    }
}
