//! Laws of dispersion fitted to the points of all branches, by least squares.

use std::f64::consts::{PI, TAU};

use super::{RidgeCut, RidgePoint};
use crate::analyze::{Constants, DispersionCurve, formula_values, parse_constants};
use crate::error::{Error, Result};
use crate::numeric::{dot, eliminated, gram, inverted, median};

/// Intervals of k on which the fitted curve is given.
const INTERVALS: usize = 960;
/// Least error of a point, in bins: what the place of a wave between bins is known to at best.
const LEAST_ERROR: f64 = 0.01;
const ITERATIONS: usize = 100;
/// Searches, each with the errors that the law of the one before gives to the points.
const ROUNDS: usize = 3;
/// Relative step of numerical derivatives.
const STEP: f64 = 1e-5;
/// Least part of the square of a parameter's derivative that the others do not explain; numerical derivatives are
/// exact to 1e-10.
const DEGENERATE: f64 = 1e-7;
/// The same of equations that are exact to rounding.
const SINGULAR: f64 = 1e-13;

/// A law of dispersion with free parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct RidgeLaw {
    /// What was typed.
    pub name: String,
    kind: Kind,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    /// Of bodies so far apart; `None`: as the sites.
    Monatomic(Option<f64>),
    Diatomic(Option<f64>),
    /// With the values from which its constants start.
    Formula(Constants),
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
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct RidgeFit {
    #[serde(rename = "law")]
    pub name: String,
    pub parameters: Vec<RidgeParameter>,
    pub points: usize,
    /// Root mean square of the points' distances from the law along their cuts, in bins.
    #[serde(rename = "deviation_bins")]
    pub deviation: f64,
    /// Sum of the squares of distances over errors, by the degrees of freedom. The errors of the parameters are scaled by
    /// its root: they are those of the distances, whatever the errors of the points say.
    #[serde(rename = "reduced_chi_square")]
    pub reduced: f64,
    #[serde(skip)]
    pub curve: DispersionCurve,
}

impl RidgeLaw {
    /// Reads `monatomic`, `diatomic`, either with `:a=DISTANCE` where bodies are not as far apart as sites, or a
    /// formula of k with the values from which its free constants start: `c*abs(k)*sqrt(1+b*k^2); c=1, b=0`.
    ///
    /// # Errors
    /// [`Error::Request`] names the fault.
    pub fn parse(text: &str) -> Result<RidgeLaw> {
        let found = format!("`{text}`");
        let (kind, values) = text.split_once(':').unwrap_or((text, ""));
        let law = |name: &str, kind: Kind| RidgeLaw {
            name: name.trim().into(),
            kind,
        };
        let lattice = match kind.trim() {
            "monatomic" => Some(Kind::Monatomic as fn(_) -> Kind),
            "diatomic" => Some(Kind::Diatomic as fn(_) -> Kind),
            _ => None,
        };
        if let Some(lattice) = lattice {
            let mut constants = constants(values)?;
            let spacing = constants.remove("a");
            if !constants.is_empty() || spacing.is_some_and(|a| a <= 0.0) {
                let expected =
                    format!("`{kind}`, or `{kind}:a=DISTANCE` with a distance of bodies above 0");
                return Err(refuse(expected, found));
            }
            return Ok(law(text, lattice(spacing)));
        }
        let (formula, start) = text.split_once(';').unwrap_or((text, ""));
        let start = constants(start)?;
        if start.is_empty() {
            let expected = "monatomic, diatomic, or a formula with the values its constants start from, such as \
                            `c*abs(k); c=1`";
            return Err(refuse(expected, found));
        }
        let values: Vec<f64> = start.values().copied().collect();
        let law = law(formula, Kind::Formula(start));
        law.frequencies(&values, &[1.0], 1.0).map_err(of_fit)?;
        Ok(law)
    }

    fn names(&self) -> Vec<String> {
        match &self.kind {
            Kind::Monatomic(_) => vec!["c/m".into()],
            Kind::Diatomic(_) => vec!["c/m1".into(), "c/m2".into()],
            Kind::Formula(start) => start.keys().cloned().collect(),
        }
    }

    /// Frequencies in cycles of all branches at each k; NaN where there is none. Parameters of lattices are
    /// logarithms.
    fn frequencies(&self, parameters: &[f64], k: &[f64], site: f64) -> Result<Vec<[f64; 2]>> {
        let omega: Vec<[f64; 2]> = match &self.kind {
            Kind::Monatomic(spacing) => {
                let (root, a) = ((0.5 * parameters[0]).exp(), spacing.unwrap_or(site));
                let at = |k: &f64| [2.0 * root * (0.5 * k * a).sin().abs(), f64::NAN];
                k.iter().map(at).collect()
            }
            Kind::Diatomic(spacing) => {
                let (p, q) = (parameters[0].exp(), parameters[1].exp());
                let a = spacing.unwrap_or(site);
                k.iter().map(|k| diatomic(p, q, k * a)).collect()
            }
            Kind::Formula(start) => {
                let named = start.keys().cloned().zip(parameters.iter().copied());
                let mut constants: Constants = named.collect();
                // The distance of sites, where it is no parameter.
                constants.entry("a".into()).or_insert(site);
                let mirrored: Vec<f64> = k.iter().map(|k| -k).collect();
                let forward = formula_values(&self.name, &constants, k)?;
                let backward = formula_values(&self.name, &constants, &mirrored)?;
                // A real wave of negative omega at -k is one of positive omega at k.
                let is_known = |w: f64| w >= 0.0 && w.is_finite();
                let known = |w: f64| if is_known(w) { w } else { f64::NAN };
                let pairs = forward.iter().zip(&backward);
                pairs.map(|(f, b)| [known(*f), known(-b)]).collect()
            }
        };
        Ok(omega.iter().map(|omega| omega.map(|w| w / TAU)).collect())
    }

    /// Fits the law to `points`; `site` is the distance of sites, `bins` the distance of bins in f and in k, `shared` how
    /// many points have one error in common.
    ///
    /// # Errors
    /// [`Error::Request`] for fewer points than parameters, for a law that is not defined at the points, and
    /// for parameters that the points do not tell apart.
    pub(super) fn fit(
        &self,
        points: &[RidgePoint],
        site: f64,
        bins: [f64; 2],
        shared: f64,
    ) -> Result<RidgeFit> {
        let (name, names) = (&self.name, self.names());
        let (parameters, all) = (names.len(), points.len());
        if all <= parameters {
            let expected = format!("more points than the {parameters} parameters of `{name}`");
            return Err(refuse(expected, format!("{all} points of ridges")));
        }
        // Each known to a bin of frequency.
        let mut points = Points {
            law: self,
            all: points,
            wavenumbers: points.iter().map(|point| point.wavenumber).collect(),
            errors: vec![bins[0]; all],
            bin: vec![bins[0]; all],
            site,
            bins,
        };
        let mut found = points.start()?;
        for _ in 0..ROUNDS {
            found = points.least_squares(found)?;
            points.weigh(&found)?;
        }
        let (residuals, derivatives) = (points.residuals(&found)?, points.derivatives(&found)?);
        let Some(covariance) = inverted(&gram(&derivatives), DEGENERATE) else {
            let expected = format!(
                "parameters that the ridges tell apart: of `{name}` only some combination of {} is known; \
                 write the others as numbers",
                names.join(", ")
            );
            let found = "parameters that change the curve in the same way";
            return Err(refuse(expected, found));
        };
        let reduced = dot(&residuals, &residuals) / (all as f64 - parameters as f64);
        let is_log = !matches!(self.kind, Kind::Formula(_));
        let parameters = names.into_iter().zip(&found).enumerate();
        let parameters = parameters.map(|(i, (name, value))| {
            let (value, unit) = match is_log {
                true => (value.exp(), value.exp()),
                false => (*value, 1.0),
            };
            let error = unit * (shared * reduced * covariance[i][i].max(0.0)).sqrt();
            RidgeParameter { name, value, error }
        });
        let bins = points.errors.iter().zip(&points.bin);
        let distances = residuals.iter().zip(bins);
        let squares = distances.map(|(residual, (error, bin))| (residual * error / bin).powi(2));
        let deviation = (squares.sum::<f64>() / all as f64).sqrt();
        let at = |n: usize| PI / site * (2.0 * n as f64 / INTERVALS as f64 - 1.0);
        let wavenumber: Vec<f64> = (0..=INTERVALS).map(at).collect();
        let curve = self.frequencies(&found, &wavenumber, site)?;
        let branches = (0..2).map(|b| curve.iter().map(|f| f[b]).collect());
        let is_there = |branch: &Vec<f64>| branch.iter().any(|f| f.is_finite());
        Ok(RidgeFit {
            name: name.clone(),
            parameters: parameters.collect(),
            points: all,
            deviation,
            reduced,
            curve: DispersionCurve {
                name: format!("{name}, fitted"),
                wavenumber,
                branches: branches.filter(is_there).collect(),
            },
        })
    }
}

fn constants(text: &str) -> Result<Constants> {
    match text.trim() {
        "" => Ok(Constants::new()),
        text => parse_constants(text).map_err(of_fit),
    }
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

fn refuse(expected: impl Into<String>, found: impl ToString) -> Error {
    Error::request("fit", expected, found)
}

/// Both omega of a chain of two masses and one spring: `w^2 = s -+ sqrt(s^2 - 4 p q sin^2 phase)`, with
/// `p = c/m1`, `q = c/m2`, `s = p + q`, and the phase from body to body.
fn diatomic(p: f64, q: f64, phase: f64) -> [f64; 2] {
    let sum = p + q;
    let product = 4.0 * p * q * phase.sin().powi(2);
    let high = sum + (sum * sum - product).max(0.0).sqrt();
    [(product / high).sqrt(), high.sqrt()]
}

/// The points to fit a law to, with their errors as errors of the frequency.
struct Points<'a> {
    law: &'a RidgeLaw,
    all: &'a [RidgePoint],
    wavenumbers: Vec<f64>,
    errors: Vec<f64>,
    /// What a bin of the cut is as a change of the frequency.
    bin: Vec<f64>,
    site: f64,
    /// Distances of bins in f and in k.
    bins: [f64; 2],
}

/// Which branch lies nearest to a frequency, and how far the frequency lies above it.
fn nearest(branches: [f64; 2], frequency: f64) -> Option<(usize, f64)> {
    let distances = branches.map(|f| frequency - f).into_iter().enumerate();
    let known = distances.filter(|(_, d)| d.is_finite());
    known.min_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()))
}

impl Points<'_> {
    /// Errors as the law with these parameters has them: what it changes by within that of a wavenumber. The slope of the
    /// points themselves is noisy, and its errors are theirs.
    fn weigh(&mut self, parameters: &[f64]) -> Result<()> {
        let [df, dk] = self.bins;
        let reach = |point: &RidgePoint| point.wavenumber_error.max(LEAST_ERROR * dk);
        let law = |sign: f64| {
            let moved = self.all.iter().map(|p| p.wavenumber + sign * reach(p));
            let moved: Vec<f64> = moved.collect();
            self.law.frequencies(parameters, &moved, self.site)
        };
        let (here, sides) = (law(0.0)?, [law(-1.0)?, law(1.0)?]);
        let (errors, bin) = (self.all.iter().enumerate())
            .map(|(i, point)| match point.cut {
                RidgeCut::Wavenumber => (point.frequency_error.max(LEAST_ERROR * df), df),
                RidgeCut::Frequency => {
                    let branch = nearest(here[i], point.frequency).map_or(0, |(branch, _)| branch);
                    let change = |side: &Vec<[f64; 2]>| (side[i][branch] - here[i][branch]).abs();
                    let change = sides.iter().map(change).fold(0.0, f64::max);
                    // Where it is level, the wavenumber does not matter.
                    let slope = (change / reach(point)).max(LEAST_ERROR * df / dk);
                    (slope * reach(point), slope * dk)
                }
            })
            .unzip();
        (self.errors, self.bin) = (errors, bin);
        Ok(())
    }

    /// Distances from the nearest branch over their errors.
    fn residuals(&self, parameters: &[f64]) -> Result<Vec<f64>> {
        let law = self.law;
        let branches = law.frequencies(parameters, &self.wavenumbers, self.site)?;
        let of = |(i, point): (usize, &RidgePoint)| {
            nearest(branches[i], point.frequency).map(|(_, distance)| distance / self.errors[i])
        };
        let found: Option<Vec<f64>> = self.all.iter().enumerate().map(of).collect();
        found.ok_or_else(|| {
            let expected = format!("a frequency of `{}` at all ridges", law.name);
            refuse(expected, "none at some")
        })
    }

    /// Where the search begins.
    fn start(&self) -> Result<Vec<f64>> {
        Ok(match &self.law.kind {
            Kind::Formula(start) => start.values().copied().collect(),
            Kind::Monatomic(spacing) => {
                let a = spacing.unwrap_or(self.site);
                let of = |point: &RidgePoint| {
                    let sine = (0.5 * point.wavenumber * a).sin().abs();
                    (sine > 0.05).then(|| 2.0 * (PI * point.frequency / sine).ln())
                };
                vec![median(self.all.iter().filter_map(of)).unwrap_or(0.0)]
            }
            Kind::Diatomic(_) => {
                let highest = self.all.iter().fold(0.0, |m: f64, p| m.max(p.frequency));
                // The highest frequency is that of opposite motion, 2 c (1/m1 + 1/m2), or below it.
                let tried = (0..24 * 24).map(|n| {
                    let ratio = 1.02 * 1.15f64.powi(n / 24);
                    let sum = 0.5 * (TAU * highest).powi(2) * 0.9 * 1.03f64.powi(n % 24);
                    let light = sum * ratio / (1.0 + ratio);
                    let tried = vec![(sum - light).ln(), light.ln()];
                    let residuals = self.residuals(&tried)?;
                    Ok((dot(&residuals, &residuals), tried))
                });
                let tried = tried.collect::<Result<Vec<(f64, Vec<f64>)>>>()?;
                let best = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
                best.map(|(_, tried)| tried).unwrap_or_default()
            }
        })
    }

    /// Parameters by the method of Levenberg and Marquardt.
    fn least_squares(&self, mut at: Vec<f64>) -> Result<Vec<f64>> {
        let mut residuals = self.residuals(&at)?;
        let mut derivatives = self.derivatives(&at)?;
        let mut damping = 1e-3;
        for _ in 0..ITERATIONS {
            let squares = dot(&residuals, &residuals);
            let mut damped = gram(&derivatives);
            for (i, row) in damped.iter_mut().enumerate() {
                row[i] *= 1.0 + damping;
                row.push(-dot(&derivatives[i], &residuals));
            }
            let Some(step) = eliminated(damped, SINGULAR) else {
                break;
            };
            let tried: Vec<f64> = at.iter().zip(&step).map(|(a, s)| a + s[0]).collect();
            let found = self.residuals(&tried).ok();
            match found.filter(|found| dot(found, found) <= squares) {
                Some(found) => {
                    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-12 * (1e-6 + a.abs());
                    let is_small = at.iter().zip(&tried).all(near);
                    let done = is_small || squares - dot(&found, &found) <= 1e-14 * squares;
                    derivatives = self.derivatives(&tried)?;
                    (at, residuals) = (tried, found);
                    damping = (damping / 10.0).max(1e-12);
                    if done {
                        break;
                    }
                }
                None if damping > 1e12 => break,
                None => damping *= 10.0,
            }
        }
        Ok(at)
    }

    /// Of the residuals, by each parameter.
    fn derivatives(&self, at: &[f64]) -> Result<Vec<Vec<f64>>> {
        let derivative = |i: usize| -> Result<Vec<f64>> {
            let step = STEP * at[i].abs().max(1e-3);
            let side = |sign: f64| {
                let mut moved = at.to_vec();
                moved[i] += sign * step;
                self.residuals(&moved)
            };
            let pairs = side(1.0)?.into_iter().zip(side(-1.0)?);
            Ok(pairs.map(|(a, b)| (a - b) / (2.0 * step)).collect())
        };
        (0..at.len()).map(derivative).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_that_do_not_parse_are_refused() {
        let refused = "|monatomic:c=1|diatomic:a=-1|c*k|c*q; c=1|triatomic";
        for text in refused.split('|') {
            assert!(RidgeLaw::parse(text).is_err(), "{text}");
        }
        let taken = "monatomic|diatomic:a=0.5|c*abs(k); c=2|2*w*abs(sin(k*a/2)); w=1";
        for text in taken.split('|') {
            RidgeLaw::parse(text).unwrap();
        }
    }
}
