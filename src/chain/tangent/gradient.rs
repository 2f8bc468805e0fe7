//! The derivatives of a run's samples.

use ndarray::{Array3, Axis};

use super::Direction;
use crate::chain::simulation::{Accuracy, Simulation};
use crate::error::{Error, Result};
use crate::observer::Observer;

/// Local error of the pass that derivatives are checked with, over theirs.
const COARSER: f64 = 32.0;

/// The least error stated, over the largest derivative: differences of runs, where they are known so well, agree to this.
const LEAST: f64 = 1e-7;

/// How a run changes with parameters; arrays are `(parameter, time, site)`.
#[derive(Debug, Clone)]
pub struct Gradient {
    /// Names of the parameters, and their units, empty for none.
    pub parameters: Vec<(String, String)>,
    /// Per unit of the parameter.
    pub displacement: Array3<f64>,
    pub velocity: Array3<f64>,
    /// Of each parameter twice the largest difference of a derivative of a velocity from that of a pass with a local error larger
    /// by 32, over the largest one; 1e-7 at least.
    pub error: Vec<f64>,
}

impl Gradient {
    /// The parameters with their units: `young [GPa], angle [deg]`.
    pub fn names(&self) -> String {
        let name = |(name, unit): &(String, String)| match unit.is_empty() {
            true => name.clone(),
            false => format!("{name} [{unit}]"),
        };
        self.parameters
            .iter()
            .map(name)
            .collect::<Vec<_>>()
            .join(", ")
    }
}

impl Simulation {
    /// Derivatives at these times, rising from 0, with the error of a run of this accuracy.
    ///
    /// # Errors
    /// [`Error::Request`] for schemes of fixed steps; [`Error::Memory`]; as [`Simulation::tangents`].
    pub fn gradient(
        &self,
        parameters: Vec<(String, String)>,
        directions: &[Direction],
        times: &[f64],
        observer: &dyn Observer,
    ) -> Result<Gradient> {
        let local = self.local_error("gradient")?;
        let shape = (directions.len(), times.len(), self.chain.n_sites());
        let needed = 6 * 8 * (shape.0 * shape.1 * shape.2) as u64;
        Error::beyond_memory("the gradient", needed, self.allowed_memory())?;
        let at = |local: f64| self.tangents(directions, times, local, observer);
        let (fine, coarse) = rayon::join(|| at(local), || at(COARSER * local));
        let ([displacement, velocity], [_, coarse]) = (fine?, coarse?);
        let error = |p: usize| {
            let [mut off, mut largest] = [0.0f64; 2];
            let [fine, coarse] = [&velocity, &coarse].map(|of| of.index_axis(Axis(0), p));
            for (a, b) in fine.iter().zip(coarse) {
                (off, largest) = (off.max((a - b).abs()), largest.max(a.abs()));
            }
            (2.0 * off / largest.max(f64::MIN_POSITIVE)).max(LEAST)
        };
        let error = (0..directions.len()).map(error).collect();
        Ok(Gradient {
            parameters,
            displacement,
            velocity,
            error,
        })
    }

    /// That of the run along which derivatives are found, which `option` asks for.
    pub(super) fn local_error(&self, option: &'static str) -> Result<f64> {
        match self.accuracy {
            Accuracy::Tolerance(tolerance) => Ok(self.local_error_for(tolerance)),
            Accuracy::LocalError(local) => Ok(local),
            Accuracy::Step(_) => {
                let expected = "a scheme that chooses its steps, `nystrom` or `runge-kutta`";
                Err(Error::request(option, expected, "fixed steps"))
            }
        }
    }
}
