//! The derivatives of a run's samples.

use ndarray::Array3;

use super::{Direction, Tangents};
use crate::chain::lattice::refuse;
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
        let local = match self.accuracy {
            Accuracy::Tolerance(tolerance) => self.local_error_for(tolerance),
            Accuracy::LocalError(local) => local,
            Accuracy::Step(_) => {
                let expected = "a scheme that chooses its steps, `nystrom` or `runge-kutta`";
                return Err(refuse("gradient", expected, "fixed steps"));
            }
        };
        let shape = (directions.len(), times.len(), self.chain.n_sites());
        let needed = 6 * 8 * (shape.0 * shape.1 * shape.2) as u64;
        Error::beyond_memory("the gradient", needed, self.allowed_memory())?;
        let at = |local: f64| self.tangents(directions, times, local, observer);
        let (fine, coarse) = rayon::join(|| at(local), || at(COARSER * local));
        let (fine, coarse) = (fine?, coarse?);
        let error = |p: usize| {
            let [mut off, mut largest] = [0.0f64; 2];
            for (a, b) in fine.iter().zip(&coarse) {
                for (a, b) in a.velocity[p].iter().zip(&b.velocity[p]) {
                    (off, largest) = (off.max((a - b).abs()), largest.max(a.abs()));
                }
            }
            (2.0 * off / largest.max(f64::MIN_POSITIVE)).max(LEAST)
        };
        let array = |of: fn(&Tangents) -> &Vec<Vec<f64>>| {
            Array3::from_shape_fn(shape, |(p, time, site)| of(&fine[time])[p][site])
        };
        Ok(Gradient {
            parameters,
            displacement: array(|at| &at.displacement),
            velocity: array(|at| &at.velocity),
            error: (0..directions.len()).map(error).collect(),
        })
    }
}
