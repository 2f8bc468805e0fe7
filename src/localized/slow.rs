//! The solitary wave of the homogeneous chain: exact, and by a published fit.

use super::dense::Matrix;
use super::grid::Grid;
use super::problem::{Parameter, Problem, Symmetry};
use super::series::Series;
use crate::{Error, Result};

/// `psi(t) = F^{1/p}` of the solitary wave of `psi'' = (1/m) [psi(t+H)^p - 2 psi^p + psi(t-H)^p]`.
/// H is the travel time per site.
#[derive(Debug, Clone)]
pub struct SlowWave {
    pub(super) exponent: f64,
    shape: SlowShape,
}

#[derive(Debug, Clone)]
enum SlowShape {
    Exact(Series),
    Fitted { amplitude: f64 },
}

impl SlowWave {
    /// The limit of a dimer's wave when its fast part has no inertia: H = 1, m = 2. Exact to
    /// rounding, by Newton's method for the convolution form `psi = g * psi^p`.
    ///
    /// # Errors
    /// [`Error::Request`] for an exponent that is not above 1, [`Error::Unresolved`] where the wave
    /// is too wide (exponents close to 1).
    pub fn exact(exponent: f64) -> Result<SlowWave> {
        let series = solitary(exponent, 1.0, 0.5)?;
        Ok(SlowWave {
            exponent,
            shape: SlowShape::Exact(series),
        })
    }

    /// The same wave by the fit of S. Sen, J. Hong, J. Bang, E. Avalos, R. Doney, *Solitary waves
    /// in the granular chain*, Phys. Rep. 462 (2008) 21: displacement
    /// `(A/2) tanh[(C1 t + C3 t^3 + C5 t^5)/2]`, Hertz contacts. The fit does not determine A; here
    /// the peak is that of the exact wave.
    ///
    /// # Errors
    /// As [`SlowWave::exact`].
    pub fn fitted() -> Result<SlowWave> {
        let peak = SlowWave::exact(1.5)?.overlap(0.0);
        Ok(SlowWave {
            exponent: 1.5,
            shape: SlowShape::Fitted {
                amplitude: peak / fitted_overlap(0.0),
            },
        })
    }

    /// `psi(t)`.
    pub fn overlap(&self, time: f64) -> f64 {
        match &self.shape {
            SlowShape::Exact(series) => series.value(time),
            SlowShape::Fitted { amplitude } => amplitude * fitted_overlap(time),
        }
    }

    /// `psi(t)^p`.
    pub fn force(&self, time: f64) -> f64 {
        self.overlap(time).max(0.0).powf(self.exponent)
    }

    /// Grid points per unit of time that resolve the wave.
    pub(super) fn density(&self) -> f64 {
        match &self.shape {
            SlowShape::Exact(series) => 2.0 * series.len() as f64 / series.period(),
            SlowShape::Fitted { .. } => 16.0,
        }
    }

    /// A time beyond which the wave is below rounding.
    pub(super) fn end(&self) -> f64 {
        match &self.shape {
            SlowShape::Exact(series) => 0.5 * series.period(),
            SlowShape::Fitted { .. } => 5.0,
        }
    }
}

fn fitted_overlap(time: f64) -> f64 {
    let displacement = |t: f64| {
        let square = t * t;
        let inner = t * (2.39536 + square * (0.268529 + square * 0.0061347));
        0.5 * (0.5 * inner).tanh()
    };
    displacement(time + 0.5) - displacement(time - 0.5)
}

/// The solitary wave with the travel time `delay` per site and the inverse mass `rate`.
pub(super) fn solitary(exponent: f64, delay: f64, rate: f64) -> Result<Series> {
    check_exponent(exponent)?;
    let mut period = 5.0 * delay;
    let mut density = 16.0 / delay;
    while 0.5 * period * density < MOST_POINTS {
        let series = solitary_on(Grid::new(period, density), exponent, delay, rate)?;
        // The tail decays doubly exponentially; beyond this level it is rounding.
        let tail = series.value(0.45 * period) / series.value(0.0);
        if tail.abs() > 1e-13 {
            period *= 1.15;
        } else if series.spectral_tail() > 1e-15 && density < 48.0 / delay {
            density *= 1.3;
        } else {
            return Ok(series);
        }
    }
    Err(unresolved(
        "the solitary wave",
        format!("a wave no wider than {period} site times"),
        format!("a wider one at the exponent {exponent}"),
    ))
}

/// Most grid points per half period; larger systems take more than seconds to solve.
pub(super) const MOST_POINTS: f64 = 700.0;

fn solitary_on(grid: Grid, exponent: f64, delay: f64, rate: f64) -> Result<Series> {
    let n = grid.half + 1;
    let mut kernel = grid.kernel(0.0);
    let (ahead, behind) = (grid.kernel(delay), grid.kernel(-delay));
    for ((k, a), b) in kernel.iter_mut().zip(&ahead).zip(&behind) {
        *k = rate * (2.0 * *k - a - b);
    }
    let mut constant = Matrix::zeros(n, n);
    grid.fill_even(&kernel, 1.0, &mut constant, (0, 0));
    let mut tail = vec![0.0; n];
    tail[n - 1] = 1.0;
    let problem = Problem {
        exponent,
        constant,
        linear: None,
        block: n,
        symmetry: Symmetry::Even,
        on_values: vec![tail],
        on_forces: Vec::new(),
    };
    // V. F. Nesterenko's long-wave solution, with the amplitude for which
    // `sum psi = rate delay^2 sum F`.
    let p = exponent;
    let wavenumber = (6.0 * (p - 1.0) * (p - 1.0) / (p * (p + 1.0))).sqrt() / delay;
    let shape: Vec<f64> = (0..n as isize)
        .map(|j| (wavenumber * grid.time(j)).min(0.5 * std::f64::consts::PI))
        .map(|angle| angle.cos().max(0.0).powf(2.0 / (p - 1.0)))
        .collect();
    let forces: f64 = shape.iter().map(|s| s.powf(p)).sum();
    let total: f64 = shape.iter().sum();
    let amplitude = (total / (rate * delay * delay * forces)).powf(1.0 / (p - 1.0));
    let start: Vec<f64> = shape.iter().map(|s| amplitude * s).collect();
    let root = problem.iterate(Parameter::Held, &start, 1.0, 40);
    match root {
        Some(root) if root.converged => Ok(Series::even(grid.period, &root.values)),
        _ => Err(unresolved(
            "the solitary wave",
            "Newton's method to converge".into(),
            format!("none at the exponent {exponent}"),
        )),
    }
}

pub(super) fn check_exponent(exponent: f64) -> Result<()> {
    if exponent > 1.0 && exponent.is_finite() {
        return Ok(());
    }
    Err(Error::Request {
        option: "exponent",
        expected: "an exponent above 1".into(),
        found: exponent.to_string(),
    })
}

pub(super) fn unresolved(what: &str, expected: String, found: String) -> Error {
    Error::Unresolved {
        what: what.into(),
        expected,
        found,
    }
}
