//! What a run yields.

use ndarray::{Array1, Array2};

use super::drive::Drive;
use super::lattice::Chain;
use super::stepping::Cost;
use super::tangent::{Gradient, Lyapunov};
use crate::field::{Axis, Field, Quantity, graded_masses};

/// The results of a run; arrays are `(time, site)` or `(time, contact)`.
#[derive(Debug, Clone)]
pub struct Run {
    pub chain: Chain,
    pub drive: Option<Drive>,
    pub time: Array1<f64>,
    pub velocity: Array2<f64>,
    pub displacement: Option<Array2<f64>>,
    /// Force in each contact beyond the static one, damping included, positive in compression.
    pub force: Option<Array2<f64>>,
    /// `W_j(t)`: energy passed through contact j towards +x since 0; 0 at a wall.
    pub energy_passed: Option<Array2<f64>>,
    /// Energy lost at each site since 0; only where the chain has losses.
    pub energy_lost: Option<Array2<f64>>,
    /// Energy put in at a driven end since 0.
    pub energy_input: Option<Array1<f64>>,
    /// Of the resonator of each site, 0 where there is none; only where the chain has resonators.
    pub resonator_displacement: Option<Array2<f64>>,
    pub resonator_velocity: Option<Array2<f64>>,
    /// How it changes with keys of its scene, where that was requested; not read from files.
    pub gradient: Option<Gradient>,
    pub report: RunReport,
}

/// How well a run went.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RunReport {
    /// The speed that errors are relative to: the largest initial speed, or, if larger, that of the
    /// lightest site with all of the initial energy; for a driven chain the largest speed of the
    /// run.
    pub velocity_scale: f64,
    /// Twice the largest difference of a velocity, relative to the scale, between this run and one
    /// whose local error is larger by `1 / `[`CHECK_FACTOR`](super::CHECK_FACTOR), or by less next to
    /// the finest steps that rounding allows, and where both have nearly the same steps the estimated errors of all these. What rounding leaves of flights, if that is more; `None` if not requested.
    pub error: Option<f64>,
    /// Largest change of the energy not explained by input and losses, relative to the largest
    /// energy. Small drift does not imply small errors of velocities.
    pub energy_drift: Option<f64>,
    /// Where it was requested.
    #[serde(default)]
    pub lyapunov: Option<Lyapunov>,
    pub cost: Cost,
    pub warnings: Vec<RunWarning>,
}

/// A finding that its user should know.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case", tag = "code")]
#[non_exhaustive]
pub enum RunWarning {
    /// The tolerance was given up after a pair of runs: the chain amplifies their difference, and
    /// rounding with it, beyond the tolerance.
    Amplifies {
        tolerance: f64,
        reached: f64,
        /// The error that rounding alone leaves, estimated from the growth of the difference.
        rounding: f64,
        /// The rate of this growth, an estimate of the largest Lyapunov exponent, and the time up to which velocities stand to
        /// the tolerance.
        #[serde(default)]
        growth: Option<[f64; 2]>,
    },
    /// The tolerance is below the rounding error of the velocities, which have the error `reached`: smaller steps bring two runs
    /// no closer.
    Rounding { tolerance: f64, reached: f64 },
    /// The overlap of a contact left the range in which its law is known, and was taken along a line.
    OutsideLaw {
        contact: usize,
        /// The overlap farthest outside, and the range.
        overlap: f64,
        range: [f64; 2],
    },
    /// The energy changed by `drift` of its largest value, which neither work nor losses explain;
    /// velocities right to the error stated could have changed it by `allowed`.
    EnergyBalance { drift: f64, allowed: f64 },
}

impl Run {
    /// The velocities as a field, its time axis that of the samples, its sites counted.
    pub fn to_field(&self) -> Field {
        let mut field = Field::from_array(self.velocity.clone());
        field.quantity = Quantity::Velocity;
        field.name = "run".into();
        self.label(&mut field);
        let last = self.time.len() - 1;
        field.time = Axis {
            origin: 0.0,
            step: self.time[last] / last as f64,
            unit: None,
        };
        field
    }

    /// Displacements and velocities of the resonators at a sample; empty without.
    pub fn resonators_at(&self, sample: usize) -> [Vec<f64>; 2] {
        [&self.resonator_displacement, &self.resonator_velocity].map(|array| {
            let row = array.as_ref().map(|array| array.row(sample).to_vec());
            row.unwrap_or_default()
        })
    }

    /// The last body that moves, or is out of place, in the first sample; the driven one where none is.
    pub(crate) fn struck(&self) -> usize {
        let states = [Some(&self.velocity), self.displacement.as_ref()];
        let last = states.into_iter().flatten().filter_map(|samples| {
            let first = samples.outer_iter().next()?;
            (0..first.len()).rev().find(|&j| first[j] != 0.0)
        });
        let driven = self.drive.as_ref().map_or(0, Drive::site);
        last.max().unwrap_or(driven)
    }

    /// Says of a field of these velocities what its file would: which body is struck, and the masses of a graded chain.
    pub fn label(&self, field: &mut Field) {
        field.struck = Some(self.struck());
        field.masses = graded_masses(&self.chain.mass, &self.chain.coefficient);
    }
}
