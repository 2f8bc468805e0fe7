//! Laws of attenuation fitted to a curve, and the length at which a law reaches a level.

use serde::Serialize;

use super::least_squares::{GRID, Solution, correlation, judged, solve};

/// Relative error beyond the points that a law was fitted to, above which it predicts nothing.
const MISSED: f64 = 0.1;

/// A model of an attenuation curve; lengths n are in bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AttenuationLaw {
    /// `c`.
    Level,
    /// `a exp(-r n)`.
    Exponential,
    /// `a n^-p`.
    PowerLaw,
    /// `c + a exp(-r n)`, which settles at c.
    Plateau,
}

impl AttenuationLaw {
    pub const ALL: [AttenuationLaw; 4] = [
        AttenuationLaw::Level,
        AttenuationLaw::Exponential,
        AttenuationLaw::PowerLaw,
        AttenuationLaw::Plateau,
    ];

    /// Names of the parameters. The first one is the rate or the power, except for a level.
    pub fn parameters(self) -> &'static [&'static str] {
        match self {
            AttenuationLaw::Level => &["c"],
            AttenuationLaw::Exponential => &["r", "a"],
            AttenuationLaw::PowerLaw => &["p", "a"],
            AttenuationLaw::Plateau => &["r", "a", "c"],
        }
    }

    /// Basis functions at n; their sum, weighted by the linear parameters, is the law.
    pub(super) fn shapes(self, first: f64, n: f64) -> [f64; 2] {
        match self {
            AttenuationLaw::Level => [1.0, 0.0],
            AttenuationLaw::Exponential => [(-first * n).exp(), 0.0],
            AttenuationLaw::PowerLaw => [n.powf(-first), 0.0],
            AttenuationLaw::Plateau => [(-first * n).exp(), 1.0],
        }
    }

    /// Number of nonlinear parameters.
    pub(super) fn searched(self) -> usize {
        usize::from(self != AttenuationLaw::Level)
    }

    pub(super) fn at(self, parameters: &[f64], n: f64) -> f64 {
        let shapes = self.shapes(parameters[0], n);
        let weights = &parameters[self.searched()..];
        weights.iter().zip(shapes).map(|(w, s)| w * s).sum()
    }

    /// Grid of the first parameter, for curves of lengths up to `longest`.
    pub(super) fn firsts(self, longest: f64) -> Vec<f64> {
        let even = |from: f64, to: f64| {
            let step = (to - from) / (GRID - 1) as f64;
            (0..GRID).map(move |i| from + step * i as f64).collect()
        };
        match self {
            AttenuationLaw::Level => vec![0.0; GRID],
            AttenuationLaw::Exponential => even(-1.0 / longest, 3.0),
            AttenuationLaw::PowerLaw => even(-1.0, 5.0),
            // A decay slower than the curve is long looks like a line.
            AttenuationLaw::Plateau => {
                let ends = [(0.5 / longest).ln(), 3f64.ln()];
                let logs: Vec<f64> = even(ends[0], ends[1]);
                logs.into_iter().map(f64::exp).collect()
            }
        }
    }
}

/// Criterion by which a law is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// Akaike's information criterion, corrected for few points.
    #[default]
    Aicc,
    /// Five-fold cross-validation in contiguous blocks.
    CrossValidation,
}

/// A parameter with its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parameter {
    pub name: &'static str,
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

/// A fitted law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fit {
    pub law: AttenuationLaw,
    pub parameters: Vec<Parameter>,
    /// Root mean square of the residuals, relative to the values.
    pub residual: f64,
    pub aicc: f64,
    /// Root mean square of the prediction errors, relative to the values.
    pub cross_validation: f64,
}

/// All laws, the chosen one first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fits {
    pub criterion: Criterion,
    /// Number of fitted points, and the effective number of independent ones.
    pub points: usize,
    pub independent: f64,
    pub fits: Vec<Fit>,
}

impl Fits {
    pub fn chosen(&self) -> &Fit {
        &self.fits[0]
    }
}

/// Fits every law to points of length and value, by least squares of the relative residuals.
///
/// Errors of neighbouring points of a computed curve are correlated. With the lag-1 autocorrelation
/// rho of the residuals, the intervals count only `m (1 - rho) / (1 + rho)` of m points as
/// independent. Akaike's criterion counts all points, since a law describes the curve and does not
/// predict noise; with few points it would choose a level for any decay. `None` for fewer than six
/// points, and for values that are not positive.
pub fn fit(points: &[(f64, f64)], criterion: Criterion) -> Option<Fits> {
    let m = points.len();
    let positive = |(n, y): &(f64, f64)| [n, y].iter().all(|v| **v > 0.0 && v.is_finite());
    if m < 6 || !points.iter().all(positive) {
        return None;
    }
    let solutions = AttenuationLaw::ALL.into_iter();
    let solutions = solutions.filter_map(|law| Some((law, solve(law, points)?)));
    let solutions: Vec<(AttenuationLaw, Solution)> = solutions.collect();
    // The residuals of the best-fitting law are closest to noise.
    let by_squares = |a: &&(_, Solution), b: &&(_, Solution)| a.1.squares.total_cmp(&b.1.squares);
    let smoothest = solutions.iter().min_by(by_squares)?;
    let rho = correlation(&smoothest.1.residuals(smoothest.0, points));
    let independent = (m as f64 * (1.0 - rho) / (1.0 + rho)).clamp(5.5, m as f64);
    let fits = solutions.iter();
    let fits = fits.filter_map(|(law, solution)| judged(*law, solution, points, independent));
    let mut fits: Vec<Fit> = fits.collect();
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

    /// Limit of the law for long chains; infinite for a law that grows.
    pub fn settles_at(&self) -> f64 {
        let grows = f64::INFINITY;
        match (self.law, self.parameters[0].value > 0.0) {
            (AttenuationLaw::Level, _) => self.parameters[0].value,
            (AttenuationLaw::Plateau, true) => self.parameters[2].value,
            (AttenuationLaw::Exponential | AttenuationLaw::PowerLaw, true) => 0.0,
            (_, false) => grows,
        }
    }

    /// The largest relative error of this law beyond a part of the points, fitted to that part. `None` where it is above
    /// [`MISSED`], or where the part is too short.
    pub(super) fn missed_beyond(&self, part: f64, points: &[(f64, f64)]) -> Option<f64> {
        let seen = (part * points.len() as f64).round() as usize;
        let (seen, rest) = points.split_at(seen);
        let solution = (seen.len() >= 5).then(|| solve(self.law, seen))??;
        let residuals = solution.residuals(self.law, rest);
        let missed = residuals.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
        (missed <= MISSED).then_some(missed)
    }

    fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lengths(m: usize) -> Vec<f64> {
        (1..=m).map(|n| n as f64).collect()
    }

    fn along(n: &[f64], law: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        n.iter().map(|n| (*n, law(*n))).collect()
    }

    #[test]
    fn val_laws_are_found_again() {
        let n = lengths(40);
        for (law, y, expected) in [
            (
                AttenuationLaw::Exponential,
                along(&n, |n| 0.9 * (-n / 25.0).exp()),
                vec![0.04, 0.9],
            ),
            (
                AttenuationLaw::PowerLaw,
                along(&n, |n| 1.1 * n.powf(-0.7)),
                vec![0.7, 1.1],
            ),
            (
                AttenuationLaw::Plateau,
                along(&n, |n| 0.6 + 0.3 * (-0.2 * n).exp()),
                vec![0.2, 0.3, 0.6],
            ),
        ] {
            for criterion in [Criterion::Aicc, Criterion::CrossValidation] {
                let fits = fit(&y, criterion).unwrap();
                let chosen = fits.chosen();
                assert_eq!(chosen.law, law, "{fits:?}");
                for (p, expected) in chosen.parameters.iter().zip(&expected) {
                    assert!((p.value - expected).abs() < 2e-7, "{p:?} {expected}");
                }
            }
        }
    }

    /// For about 95 % of 400 noisy curves, the intervals contain the true rate and the true start.
    #[test]
    fn val_intervals_hold_the_truth_as_often_as_they_say() {
        let n = lengths(30);
        let mut random = crate::numeric::Random::new(7);
        let mut held = [0; 2];
        for _ in 0..400 {
            let mut y = along(&n, |n| (-0.05 * n).exp());
            y.iter_mut()
                .for_each(|(_, y)| *y *= 1.0 + 0.03 * random.normal());
            let fits = fit(&y, Criterion::Aicc).unwrap().fits;
            let exponential = fits.iter().find(|f| f.law == AttenuationLaw::Exponential);
            let found = exponential.unwrap().parameters.iter().zip([0.05, 1.0]);
            for (held, (found, truth)) in held.iter_mut().zip(found) {
                *held += usize::from(found.low <= truth && truth <= found.high);
            }
        }
        assert!(
            held.iter().all(|held| (368..=396).contains(held)),
            "{held:?}"
        );
    }

    #[test]
    fn what_cannot_be_fitted_is_not() {
        for values in [vec![1.0; 5], vec![0.0; 8]] {
            let points = along(&lengths(values.len()), |_| values[0]);
            assert!(fit(&points, Criterion::Aicc).is_none());
        }
        let level = fit(&along(&lengths(8), |_| 0.5), Criterion::Aicc).unwrap();
        assert_eq!(level.chosen().law, AttenuationLaw::Level);
        assert!((level.chosen().at(4.0) - 0.5).abs() < 1e-12);
    }
}
