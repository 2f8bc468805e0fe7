//! The solitary wave of the homogeneous chain: exact, and by a published fit.

use super::equations::Grid;
use super::problem::{Parameter, Problem};
use super::series::Series;
use crate::error::{Error, Fault, Result};

/// `psi(t) = F^{1/p}` of the solitary wave of `psi'' = (1/2) [psi(t+1)^p - 2 psi^p + psi(t-1)^p]`:
/// the limit of a dimer's wave when its fast part has no inertia.
#[derive(Debug, Clone)]
pub struct SlowWave {
    pub(super) exponent: f64,
    pub(super) series: Series,
}

impl SlowWave {
    /// Exact to rounding, by Newton's method for the convolution form `psi = g * psi^p`.
    ///
    /// # Errors
    /// [`Error::Request`] for an exponent that is not above 1, [`Error::Unresolved`] where the wave
    /// is too wide (exponents close to 1).
    pub fn exact(exponent: f64) -> Result<SlowWave> {
        let is_so = exponent > 1.0 && exponent.is_finite();
        Error::require(is_so, "exponent", "an exponent above 1", exponent)?;
        let (mut period, mut density) = (5.0, 16.0);
        while 0.5 * period * density < MOST_POINTS as f64 {
            let series = solitary(Grid::new(period, density), exponent)?;
            // The tail decays doubly exponentially; beyond this level it is rounding.
            let tail = series.value(0.45 * period) / series.value(0.0);
            if tail.abs() > 1e-13 {
                period *= 1.15;
            } else if series.spectral_tail() > 1e-15 && density < 48.0 {
                density *= 1.3;
            } else {
                return Ok(SlowWave { exponent, series });
            }
        }
        Err(unresolved(
            "the solitary wave",
            format!("a wave no wider than {period} site times"),
            format!("a wider one at the exponent {exponent}"),
        ))
    }

    /// The same wave by the fit of S. Sen, J. Hong, J. Bang, E. Avalos, R. Doney, *Solitary waves
    /// in the granular chain*, Phys. Rep. 462 (2008) 21: displacement
    /// `(A/2) tanh[(C1 t + C3 t^3 + C5 t^5)/2]`, Hertz contacts. The fit does not determine A; here
    /// the peak is that of the exact wave.
    ///
    /// # Errors
    /// As [`SlowWave::exact`].
    pub fn fitted() -> Result<SlowWave> {
        let displacement = |t: f64| {
            let square = t * t;
            let inner = t * (2.39536 + square * (0.268529 + square * 0.0061347));
            0.5 * (0.5 * inner).tanh()
        };
        let overlap = |t: f64| displacement(t + 0.5) - displacement(t - 0.5);
        let scale = SlowWave::exact(1.5)?.overlap(0.0) / overlap(0.0);
        let grid = Grid::new(10.0, FITTED_DENSITY);
        let half = grid.half as isize;
        let values = (1 - half..=half).map(|j| scale * overlap(grid.time(j)));
        let values: Vec<f64> = values.collect();
        Ok(SlowWave {
            exponent: 1.5,
            series: Series::through(grid.period, &values),
        })
    }

    /// `psi(t)`.
    pub fn overlap(&self, time: f64) -> f64 {
        self.series.value(time)
    }

    /// `psi(t)^p`.
    pub fn force(&self, time: f64) -> f64 {
        self.overlap(time).max(0.0).powf(self.exponent)
    }

    /// A time beyond which the wave is below rounding.
    pub(super) fn end(&self) -> f64 {
        0.5 * self.series.period()
    }
}

/// Most grid points per half period; larger systems take more than seconds to solve.
pub(super) const MOST_POINTS: usize = 700;
/// Points per unit of time that resolve the fitted wave to rounding.
const FITTED_DENSITY: f64 = 48.0;

fn solitary(grid: Grid, exponent: f64) -> Result<Series> {
    let (p, n) = (exponent, grid.half as isize);
    let (plain, ahead, behind) = (grid.kernel(0.0), grid.kernel(1.0), grid.kernel(-1.0));
    let mut kernel = vec![vec![0.0; grid.half + 1]; grid.half + 1];
    for (row, j) in kernel.iter_mut().zip(0..) {
        for from in 1 - n..=n {
            let [plain, ahead, behind] =
                [&plain, &ahead, &behind].map(|kernel| grid.at_lag(kernel, from, j));
            row[from.unsigned_abs()] += plain - 0.5 * (ahead + behind);
        }
    }
    let (mut weights, mut tail) = (vec![2.0; grid.half + 1], vec![0.0; grid.half + 1]);
    (weights[0], weights[grid.half], tail[grid.half]) = (1.0, 1.0, 1.0);
    let problem = Problem {
        exponent,
        kernels: [kernel, vec![vec![0.0; grid.half + 1]; grid.half + 1]],
        weights,
        block: grid.half + 1,
        on_values: vec![tail],
        on_forces: Vec::new(),
    };
    // V. F. Nesterenko's long-wave solution, with the amplitude for which `sum psi = sum F / 2`.
    let wavenumber = (6.0 * (p - 1.0) * (p - 1.0) / (p * (p + 1.0))).sqrt();
    let shape: Vec<f64> = (0..=n)
        .map(|j| (wavenumber * grid.time(j)).min(0.5 * std::f64::consts::PI))
        .map(|angle| angle.cos().max(0.0).powf(2.0 / (p - 1.0)))
        .collect();
    let forces: f64 = shape.iter().map(|s| s.powf(p)).sum();
    let amplitude = (2.0 * shape.iter().sum::<f64>() / forces).powf(1.0 / (p - 1.0));
    let start = shape.iter().map(|s| amplitude * s).collect();
    match problem.iterate(Parameter::Held, problem.start(start, 1.0), 40) {
        Some(root) if root.converged => {
            let all = (1 - n..=n).map(|j| root.values[j.unsigned_abs()]);
            Ok(Series::through(grid.period, &all.collect::<Vec<_>>()))
        }
        _ => Err(unresolved(
            "the solitary wave",
            "Newton's method to converge",
            format!("none at the exponent {exponent}"),
        )),
    }
}

pub(super) fn unresolved(
    what: &str,
    expected: impl Into<String>,
    found: impl Into<String>,
) -> Error {
    let (expected, found) = (expected.into(), found.into());
    let said = format!("{what}: expected {expected}, found {found}");
    Error::Unresolved(Fault::new(said, ""))
}
