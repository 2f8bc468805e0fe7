//! Laws of dispersion fitted to the points of all branches, by least squares.

use std::f64::consts::{PI, TAU};

use super::{RidgeCut, RidgePoint};
use crate::analyze::{Constants, DispersionCurve, formula_values, parse_constants};
use crate::error::{Error, Result};

/// Intervals of k on which the fitted curve is given.
const INTERVALS: usize = 960;
/// Least error of a point, in bins: what the place of a wave between bins is known to at best.
const LEAST_ERROR: f64 = 0.01;
/// By what all points may be off alike, in bins: a peak of a spectrum that falls is drawn to its higher side. Parameters
/// are known no better, however many points there are. Of waves with spectra that fall by 20 dB over the ridge, in
/// noise, the median of fits was off by 0.004 to 0.014 bins.
const COMMON_ERROR: f64 = 0.03;
const ITERATIONS: usize = 100;
/// Relative step of numerical derivatives.
const STEP: f64 = 1e-5;
/// Least part of the square of a parameter's derivative that the others do not explain; numerical derivatives are
/// exact to 1e-10.
const DEGENERATE: f64 = 1e-7;
/// The same of equations that are exact to rounding.
pub(super) const SINGULAR: f64 = 1e-13;

/// A law of dispersion with free parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct RidgeLaw {
    /// What was typed.
    pub name: String,
    kind: Kind,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    Monatomic {
        spacing: Option<f64>,
    },
    Diatomic {
        spacing: Option<f64>,
    },
    Formula {
        text: String,
        start: Vec<(String, f64)>,
    },
}

/// A fitted parameter.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct RidgeParameter {
    pub name: String,
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// A law fitted to the points of all branches.
#[derive(Debug, Clone, PartialEq)]
pub struct RidgeFit {
    pub name: String,
    pub parameters: Vec<RidgeParameter>,
    pub points: usize,
    /// Root mean square of the points' distances from the law along their cuts, in bins.
    pub deviation: f64,
    /// Sum of the squares of distances over errors, by the degrees of freedom. Above 1, the errors of the
    /// parameters are scaled by its root; they are no smaller than what 0.03 bins do that all points are off alike.
    pub reduced: f64,
    pub curve: DispersionCurve,
}

impl RidgeLaw {
    /// Reads `monatomic`, `diatomic`, either with `:a=DISTANCE` where bodies are not as far apart as sites, or a
    /// formula of k with the values from which its free constants start: `c*abs(k)*sqrt(1+b*k^2); c=1, b=0`.
    ///
    /// # Errors
    /// [`Error::Request`] names the fault.
    pub fn parse(text: &str) -> Result<RidgeLaw> {
        let (kind, values) = text.split_once(':').unwrap_or((text, ""));
        let lattice = |spacing| match kind.trim() {
            "monatomic" => Some(Kind::Monatomic { spacing }),
            "diatomic" => Some(Kind::Diatomic { spacing }),
            _ => None,
        };
        if lattice(None).is_some() {
            let constants = match values.trim() {
                "" => Constants::new(),
                values => parse_constants(values).map_err(of_fit)?,
            };
            let spacing = constants.get("a").copied();
            let others = constants.keys().any(|name| name != "a");
            if others || spacing.is_some_and(|a| a <= 0.0) {
                return Err(refuse(
                    format!("`{kind}`, or `{kind}:a=DISTANCE` with a distance of bodies above 0"),
                    format!("`{text}`"),
                ));
            }
            let kind = lattice(spacing).ok_or_else(|| refuse("a law".into(), text.into()))?;
            return Ok(RidgeLaw {
                name: text.trim().into(),
                kind,
            });
        }
        let (formula, start) = text.split_once(';').unwrap_or((text, ""));
        let start: Vec<(String, f64)> = match start.trim() {
            "" => Vec::new(),
            start => parse_constants(start)
                .map_err(of_fit)?
                .into_iter()
                .collect(),
        };
        if start.is_empty() {
            return Err(refuse(
                "monatomic, diatomic, or a formula with the values its constants start from, such as \
                 `c*abs(k); c=1`"
                    .into(),
                format!("`{text}`"),
            ));
        }
        let constants: Constants = start
            .iter()
            .cloned()
            .chain(spacing_constant(&start, 1.0))
            .collect();
        formula_values(formula.trim(), &constants, &[1.0]).map_err(of_fit)?;
        Ok(RidgeLaw {
            name: formula.trim().into(),
            kind: Kind::Formula {
                text: formula.trim().into(),
                start,
            },
        })
    }

    fn names(&self) -> Vec<String> {
        match &self.kind {
            Kind::Monatomic { .. } => vec!["c/m".into()],
            Kind::Diatomic { .. } => vec!["c/m1".into(), "c/m2".into()],
            Kind::Formula { start, .. } => start.iter().map(|(name, _)| name.clone()).collect(),
        }
    }

    /// Frequencies in cycles of all branches at each k; NaN where there is none. Parameters of lattices are
    /// logarithms.
    fn frequencies(&self, parameters: &[f64], k: &[f64], site: f64) -> Result<Vec<[f64; 2]>> {
        let of = |omega: [f64; 2]| omega.map(|w| w / TAU);
        Ok(match &self.kind {
            Kind::Monatomic { spacing } => {
                let (root, a) = ((0.5 * parameters[0]).exp(), spacing.unwrap_or(site));
                let at = |k: &f64| of([2.0 * root * (0.5 * k * a).sin().abs(), f64::NAN]);
                k.iter().map(at).collect()
            }
            Kind::Diatomic { spacing } => {
                let (p, q) = (parameters[0].exp(), parameters[1].exp());
                let a = spacing.unwrap_or(site);
                k.iter().map(|k| of(diatomic(p, q, k * a))).collect()
            }
            Kind::Formula { text, start } => {
                let named = start.iter().zip(parameters);
                let constants: Constants = named
                    .map(|((name, _), value)| (name.clone(), *value))
                    .chain(spacing_constant(start, site))
                    .collect();
                let mirrored: Vec<f64> = k.iter().map(|k| -k).collect();
                let forward = formula_values(text, &constants, k)?;
                let backward = formula_values(text, &constants, &mirrored)?;
                // A real wave of negative omega at -k is one of positive omega at k.
                let known = |w: f64| {
                    if w >= 0.0 && w.is_finite() {
                        w
                    } else {
                        f64::NAN
                    }
                };
                let pairs = forward.iter().zip(&backward);
                pairs.map(|(f, b)| of([known(*f), known(-b)])).collect()
            }
        })
    }

    /// Where the search begins.
    fn start(&self, points: &Points<'_>) -> Result<Vec<f64>> {
        Ok(match &self.kind {
            Kind::Formula { start, .. } => start.iter().map(|(_, value)| *value).collect(),
            Kind::Monatomic { spacing } => {
                let a = spacing.unwrap_or(points.site);
                let of = |point: &RidgePoint| {
                    let sine = (0.5 * point.wavenumber * a).sin().abs();
                    (sine > 0.05).then(|| 2.0 * (PI * point.frequency / sine).ln())
                };
                let mut all: Vec<f64> = points.all.iter().filter_map(of).collect();
                all.sort_by(f64::total_cmp);
                vec![all.get(all.len() / 2).copied().unwrap_or(0.0)]
            }
            Kind::Diatomic { .. } => {
                let highest = points.all.iter().fold(0.0, |m: f64, p| m.max(p.frequency));
                let mut best = (f64::INFINITY, Vec::new());
                // The highest frequency is that of opposite motion, 2 c (1/m1 + 1/m2), or below it.
                for ratio in 0..24 {
                    let ratio = 1.02 * 1.15f64.powi(ratio);
                    for above in 0..24 {
                        let sum = 0.5 * (TAU * highest).powi(2) * 0.9 * 1.03f64.powi(above);
                        let light = sum * ratio / (1.0 + ratio);
                        let tried = vec![(sum - light).ln(), light.ln()];
                        let squares: f64 =
                            points.residuals(self, &tried)?.iter().map(|r| r * r).sum();
                        if squares < best.0 {
                            best = (squares, tried);
                        }
                    }
                }
                best.1
            }
        })
    }

    /// Fits the law to `points`; `site` is the distance of sites, `bins` the distance of bins in f and in k.
    ///
    /// # Errors
    /// [`Error::Request`] for fewer points than parameters, for a law that is not defined at the points, and
    /// for parameters that the points do not tell apart.
    pub(super) fn fit(&self, points: &[RidgePoint], site: f64, bins: [f64; 2]) -> Result<RidgeFit> {
        let names = self.names();
        let points = Points::new(points, site, bins);
        let freedom = points.all.len() as f64 - names.len() as f64;
        if freedom < 1.0 {
            return Err(refuse(
                format!(
                    "more points than the {} parameters of `{}`",
                    names.len(),
                    self.name
                ),
                format!("{} points of ridges", points.all.len()),
            ));
        }
        let start = self.start(&points)?;
        let (found, squares, normal) = points.least_squares(self, start)?;
        let covariance = self.covariance(normal)?;
        let reduced = squares / freedom;
        let common = points.common_shift(self, &found, &covariance)?;
        let is_log = !matches!(self.kind, Kind::Formula { .. });
        let parameters = (names.into_iter().zip(&found).enumerate())
            .map(|(i, (name, value))| {
                let (value, unit) = if is_log {
                    (value.exp(), value.exp())
                } else {
                    (*value, 1.0)
                };
                let variance = reduced.max(1.0) * covariance[i][i].max(0.0);
                let error = unit * variance.sqrt().hypot(COMMON_ERROR * common[i]);
                RidgeParameter { name, value, error }
            })
            .collect();
        let distances = points.bins(&points.residuals(self, &found)?);
        let deviation =
            (distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64).sqrt();
        let nyquist = PI / site;
        let at = |n: usize| nyquist * (2.0 * n as f64 / INTERVALS as f64 - 1.0);
        let wavenumber: Vec<f64> = (0..=INTERVALS).map(at).collect();
        let curve = self.frequencies(&found, &wavenumber, site)?;
        let branch = |b: usize| curve.iter().map(|f| f[b]).collect::<Vec<f64>>();
        let branches = [branch(0), branch(1)].into_iter();
        Ok(RidgeFit {
            name: self.name.clone(),
            parameters,
            points: points.all.len(),
            deviation,
            reduced,
            curve: DispersionCurve {
                name: format!("{}, fitted", self.name),
                wavenumber,
                branches: branches
                    .filter(|b| b.iter().any(|f| f.is_finite()))
                    .collect(),
            },
        })
    }

    fn covariance(&self, normal: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>> {
        let n = normal.len();
        let scale: Vec<f64> = (0..n).map(|i| normal[i][i].sqrt()).collect();
        let scaled = (0..n).map(|i| {
            let row = (0..n).map(|j| normal[i][j] / scale[i] / scale[j]);
            row.chain((0..n).map(|j| f64::from(u8::from(i == j))))
                .collect()
        });
        let inverse = eliminated(scaled.collect(), DEGENERATE).ok_or_else(|| {
            refuse(
                format!(
                    "parameters that the ridges tell apart: of `{}` only some combination of {} is known; \
                     write the others as numbers",
                    self.name,
                    self.names().join(", ")
                ),
                "parameters that change the curve in the same way".into(),
            )
        })?;
        let of = |i: usize| {
            (0..n)
                .map(|j| inverse[i][j] / scale[i] / scale[j])
                .collect()
        };
        Ok((0..n).map(of).collect())
    }
}

/// `a`, the distance of sites, where it is no parameter.
fn spacing_constant(start: &[(String, f64)], site: f64) -> Option<(String, f64)> {
    let is_free = start.iter().any(|(name, _)| name == "a");
    (!is_free).then(|| ("a".to_owned(), site))
}

/// A fault of a formula is one of the option that gives it.
fn of_fit(error: Error) -> Error {
    match error {
        Error::Request {
            expected, found, ..
        } => refuse(expected, found),
        other => other,
    }
}

fn refuse(expected: String, found: String) -> Error {
    Error::Request {
        option: "fit",
        expected,
        found,
    }
}

/// Both omega of a chain of two masses and one spring: `w^2 = s -+ sqrt(s^2 - 4 p q sin^2 phase)`, with
/// `p = c/m1`, `q = c/m2`, `s = p + q`, and the phase from body to body.
fn diatomic(p: f64, q: f64, phase: f64) -> [f64; 2] {
    let sum = p + q;
    let product = 4.0 * p * q * phase.sin().powi(2);
    let high = sum + (sum * sum - product).max(0.0).sqrt();
    [(product / high).sqrt(), high.sqrt()]
}

/// The points to fit, with their errors as errors of the frequency.
struct Points<'a> {
    all: &'a [RidgePoint],
    wavenumbers: Vec<f64>,
    errors: Vec<f64>,
    /// What a bin of the cut is as a change of the frequency.
    bin: Vec<f64>,
    site: f64,
}

impl<'a> Points<'a> {
    fn new(all: &'a [RidgePoint], site: f64, [df, dk]: [f64; 2]) -> Self {
        let in_frequency = |point: &RidgePoint| match point.cut {
            RidgeCut::Wavenumber => (point.frequency_error, df),
            RidgeCut::Frequency => {
                let slope = (point.group_velocity / TAU).abs();
                // A branch whose slope is not known counts as one that crosses a bin in a bin.
                let slope = if slope > 0.0 && slope.is_finite() {
                    slope
                } else {
                    df / dk
                };
                (point.wavenumber_error * slope, dk * slope)
            }
        };
        let (errors, bin): (Vec<f64>, Vec<f64>) = all.iter().map(in_frequency).unzip();
        let errors = errors.iter().zip(&bin).map(|(e, b)| e.max(LEAST_ERROR * b));
        Points {
            all,
            wavenumbers: all.iter().map(|point| point.wavenumber).collect(),
            errors: errors.collect(),
            bin,
            site,
        }
    }

    /// Distances from the nearest branch over their errors.
    fn residuals(&self, law: &RidgeLaw, parameters: &[f64]) -> Result<Vec<f64>> {
        let branches = law.frequencies(parameters, &self.wavenumbers, self.site)?;
        let of = |((point, error), branches): ((&RidgePoint, &f64), &[f64; 2])| {
            let distances = branches.map(|f| point.frequency - f);
            let known = distances.into_iter().filter(|d| d.is_finite());
            known
                .min_by(|a, b| a.abs().total_cmp(&b.abs()))
                .map(|d| d / error)
        };
        let found = self.all.iter().zip(&self.errors).zip(&branches).map(of);
        found.collect::<Option<Vec<f64>>>().ok_or_else(|| {
            refuse(
                format!("a frequency of `{}` at all ridges", law.name),
                "none at some".into(),
            )
        })
    }

    fn bins(&self, residuals: &[f64]) -> Vec<f64> {
        let scaled = residuals.iter().zip(&self.errors).zip(&self.bin);
        scaled.map(|((r, error), bin)| r * error / bin).collect()
    }

    /// Parameters, the sum of squares, and the normal matrix, by the method of Levenberg and Marquardt.
    fn least_squares(
        &self,
        law: &RidgeLaw,
        start: Vec<f64>,
    ) -> Result<(Vec<f64>, f64, Vec<Vec<f64>>)> {
        let square = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
        let mut at = start;
        let mut residuals = self.residuals(law, &at)?;
        let mut squares = square(&residuals);
        let mut damping = 1e-3;
        let n = at.len();
        let mut normal = self.normal(law, &at, &residuals)?;
        for _ in 0..ITERATIONS {
            let (matrix, gradient) = &normal;
            let damped = (0..n).map(|i| {
                let row = (0..n).map(|j| matrix[i][j] * if i == j { 1.0 + damping } else { 1.0 });
                row.chain([-gradient[i]]).collect()
            });
            let Some(step) = eliminated(damped.collect(), SINGULAR) else {
                break;
            };
            let tried: Vec<f64> = at.iter().zip(&step).map(|(a, s)| a + s[0]).collect();
            let found = self.residuals(law, &tried).ok().map(|r| (square(&r), r));
            match found.filter(|(sum, _)| *sum <= squares) {
                Some((sum, found)) => {
                    let small = at
                        .iter()
                        .zip(&tried)
                        .all(|(a, b)| (a - b).abs() <= 1e-12 * (1e-6 + a.abs()));
                    let done = small || squares - sum <= 1e-14 * squares;
                    (at, squares, residuals) = (tried, sum, found);
                    normal = self.normal(law, &at, &residuals)?;
                    damping = (damping / 10.0).max(1e-12);
                    if done {
                        break;
                    }
                }
                None if damping > 1e12 => break,
                None => damping *= 10.0,
            }
        }
        Ok((at, squares, normal.0))
    }

    /// By what the parameters change if all points move by a bin to higher frequencies.
    fn common_shift(
        &self,
        law: &RidgeLaw,
        at: &[f64],
        covariance: &[Vec<f64>],
    ) -> Result<Vec<f64>> {
        let shifts = self.bin.iter().zip(&self.errors).map(|(b, e)| b / e);
        let shifts: Vec<f64> = shifts.collect();
        let derivatives = self.derivatives(law, at)?;
        let pull = |row: &Vec<f64>| row.iter().zip(&shifts).map(|(d, s)| d * s).sum::<f64>();
        let pulls: Vec<f64> = derivatives.iter().map(pull).collect();
        let moved = |row: &Vec<f64>| row.iter().zip(&pulls).map(|(c, p)| c * p).sum::<f64>();
        Ok(covariance.iter().map(moved).collect())
    }

    /// Of the residuals, by each parameter.
    fn derivatives(&self, law: &RidgeLaw, at: &[f64]) -> Result<Vec<Vec<f64>>> {
        let derivative = |i: usize| -> Result<Vec<f64>> {
            let step = STEP * at[i].abs().max(1e-3);
            let side = |sign: f64| {
                let mut moved = at.to_vec();
                moved[i] += sign * step;
                self.residuals(law, &moved)
            };
            let (above, below) = (side(1.0)?, side(-1.0)?);
            Ok(above
                .iter()
                .zip(&below)
                .map(|(a, b)| (a - b) / (2.0 * step))
                .collect())
        };
        (0..at.len()).map(derivative).collect()
    }

    fn normal(
        &self,
        law: &RidgeLaw,
        at: &[f64],
        residuals: &[f64],
    ) -> Result<(Vec<Vec<f64>>, Vec<f64>)> {
        let n = at.len();
        let derivatives = self.derivatives(law, at)?;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let row = |i: usize| {
            (0..n)
                .map(|j| dot(&derivatives[i], &derivatives[j]))
                .collect()
        };
        let gradient = (0..n).map(|i| dot(&derivatives[i], residuals)).collect();
        Ok(((0..n).map(row).collect(), gradient))
    }
}

/// Solves linear equations with several right sides, which stand behind the square matrix; `None` where a pivot is
/// at most the share `least` of its row.
pub(super) fn eliminated(mut rows: Vec<Vec<f64>>, least: f64) -> Option<Vec<Vec<f64>>> {
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
                other
                    .iter_mut()
                    .zip(&row)
                    .for_each(|(v, r)| *v -= factor * r);
            }
        }
    }
    Some(rows.into_iter().map(|row| row[n..].to_vec()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::UnitCell;

    #[test]
    fn val_branches_of_the_unit_cell() {
        let cell = UnitCell::new(vec![2.0, 0.5], vec![3.0, 3.0]).unwrap();
        for n in 0..40 {
            let phase = 0.1 * f64::from(n) - 2.0;
            let expected = cell.frequencies(phase);
            let found = diatomic(1.5, 6.0, phase);
            for (found, expected) in found.iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-7,
                    "{phase}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn equations_that_depend_on_each_other_are_not_solved() {
        let near = |off: f64| vec![vec![1.0, 1.0, 1.0], vec![1.0, 1.0 + off, 2.0]];
        assert!(eliminated(near(1e-9), DEGENERATE).is_none());
        let solved = eliminated(near(0.5), DEGENERATE).unwrap();
        assert!((solved[0][0] + 1.0).abs() < 1e-15 && (solved[1][0] - 2.0).abs() < 1e-15);
    }

    #[test]
    fn laws_that_do_not_parse_are_refused() {
        for text in [
            "",
            "monatomic:c=1",
            "diatomic:a=-1",
            "c*k",
            "c*q; c=1",
            "triatomic",
        ] {
            assert!(RidgeLaw::parse(text).is_err(), "{text}");
        }
        for text in [
            "monatomic",
            "diatomic:a=0.5",
            "c*abs(k); c=2",
            "2*w*abs(sin(k*a/2)); w=1",
        ] {
            RidgeLaw::parse(text).unwrap();
        }
    }
}
