//! Stepping a chain from sample to sample.

mod correction;
mod driver;
mod energy;
mod events;
mod finish;
mod islands;
mod pair;
mod quadrature;
mod resolved;
mod stage;
mod system;
mod tableau;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::lattice::{Chain, Ends};
use super::law::{self, Kernel, Law};
use super::simulation::Simulation;
use crate::numeric::lanes::AlignedRow;
use crate::observer::Observer;
use crate::{Error, Result};
use correction::Correction;
pub(crate) use correction::{Quintic, openings};
use driver::Driver;
pub(crate) use driver::{Extreme, contact_time, stopping_time};
pub use islands::SteppedSites;
pub(crate) use system::{FIRST_CONTACT, FIRST_SITE, State, first_contact};
use system::{System, resonator_place};
pub(crate) use tableau::{MOST_STAGES, Tableau, Weights, integral_of_lagrange};
use tableau::{SYMPLECTIC_4, SYMPLECTIC_6, VERLET};

/// An integration method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Embedded Nystrom pair 8(6), corrected where contacts open and close; no damping.
    #[default]
    Nystrom,
    /// Embedded Runge-Kutta pair 8(5), corrected likewise; any force.
    RungeKutta,
    /// Second order, fixed steps; no damping.
    VelocityVerlet,
    /// Symplectic of fourth order, fixed steps; no damping.
    #[serde(rename = "symplectic-4")]
    Symplectic4,
    /// Symplectic of sixth order, fixed steps; no damping.
    #[serde(rename = "symplectic-6")]
    Symplectic6,
}

impl Scheme {
    pub const ALL: [Scheme; 5] = [
        Scheme::Nystrom,
        Scheme::RungeKutta,
        Scheme::VelocityVerlet,
        Scheme::Symplectic4,
        Scheme::Symplectic6,
    ];

    /// The order at which the error falls with the step, away from contacts that open.
    pub fn order(&self) -> u32 {
        self.tableau().order
    }

    fn tableau(&self) -> Tableau {
        match self {
            Scheme::Nystrom => Tableau::nystrom_8_6(),
            Scheme::RungeKutta => Tableau::runge_kutta_8_5(),
            Scheme::VelocityVerlet => VERLET.tableau(),
            Scheme::Symplectic4 => SYMPLECTIC_4.tableau(),
            Scheme::Symplectic6 => SYMPLECTIC_6.tableau(),
        }
    }

    /// Whether forces may depend on velocities.
    pub fn takes_losses(&self) -> bool {
        matches!(self, Scheme::RungeKutta)
    }

    /// Whether the step is chosen by the tolerance rather than given.
    pub fn is_adaptive(&self) -> bool {
        matches!(self, Scheme::Nystrom | Scheme::RungeKutta)
    }
}

/// How long the steps are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepControl {
    /// Largest estimated error of a velocity a step, in velocity units.
    LocalError(f64),
    /// Steps no longer than this; every sample is landed on.
    Fixed(f64),
}

/// What the stepping did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cost {
    pub steps: u64,
    pub rejected_steps: u64,
    /// Contact forces computed.
    pub forces: u64,
    /// Contacts corrected for opening or closing inside a step.
    pub corrected_contacts: u64,
}

/// A chain during integration.
pub(crate) trait Stepping {
    /// Makes one step towards this time, beyond which it does not go; returns where it ends.
    ///
    /// # Errors
    /// [`crate::Error::Request`] where no step is small enough, or the step given is unstable;
    /// [`crate::Error::Cancelled`] when the observer asks to stop.
    fn step_towards(&mut self, time: f64, observer: &dyn Observer) -> Result<f64>;

    /// Steps to exactly this time.
    ///
    /// # Errors
    /// As [`Stepping::step_towards`].
    fn advance_to(&mut self, time: f64, observer: &dyn Observer) -> Result<()>;

    /// The state, with a ghost place at each end.
    fn state(&self) -> &State;

    /// Displacement, velocity and acceleration of place s in a state at time t.
    fn motion(&self, s: usize, t: f64, state: &State) -> [f64; 3];

    /// The times at which contacts open or close between two marks, in order, and their places: those that `matter` at the
    /// largest overlap that they may have in between.
    fn openings(
        &self,
        between: [(f64, &State); 2],
        matters: &dyn Fn(usize, f64) -> bool,
    ) -> Vec<(f64, usize)>;

    /// The length of step that the error allows.
    fn step(&self) -> f64;

    /// Sets it, where steps cut short have hidden it.
    fn set_step(&mut self, step: f64);

    /// A state for [`Stepping::reset`].
    fn mark(&self) -> Mark;

    /// Returns to the state of `mark`.
    fn reset(&mut self, mark: &Mark);

    fn cost(&self) -> Cost;

    /// The largest estimated errors of a velocity in each step so far, added up.
    fn estimated(&self) -> f64;
}

/// A point on the way.
#[derive(Debug, Clone)]
pub(crate) struct Mark {
    pub(crate) time: f64,
    step: f64,
    pub(crate) state: State,
}

/// Request for an integration.
#[derive(Debug, Clone, Copy)]
struct Task<'a> {
    simulation: &'a Simulation,
    control: StepControl,
    /// The speed that errors are measured by.
    velocity_scale: f64,
    energy: bool,
}

/// Nodes and weights of Gauss's rule on 0..1.
pub(crate) fn gauss(nodes: usize) -> Vec<(f64, f64)> {
    quadrature::gauss_jacobi(nodes, 0.0, 0.0)
}

/// Prepares the stepping of a checked simulation; errors are measured by a speed.
///
/// # Errors
/// [`crate::Error::Request`] for losses with a scheme that does not support them, and for step
/// control that does not fit the scheme.
pub(crate) fn prepare(
    simulation: &Simulation,
    control: StepControl,
    velocity_scale: f64,
    energy: bool,
) -> Result<Box<dyn Stepping>> {
    let (chain, scheme) = (&simulation.chain, simulation.scheme);
    let expected = "`runge-kutta`, which takes losses, springs to the ground and resonators";
    let takes = !chain.has_pulls() || scheme.takes_losses();
    Error::require(takes, "scheme", expected, format!("{scheme:?}"))?;
    let task = &Task {
        simulation,
        control,
        velocity_scale,
        energy,
    };
    let pressed = chain.is_pressed();
    match chain.law.only() {
        Some(Law::Hertz) if !pressed => with_kernel(task, law::Hertz),
        Some(Law::Hertz) => with_kernel(task, law::PressedHertz),
        Some(&Law::Power { exponent }) => with_kernel(task, law::Power { exponent }),
        Some(&Law::Spring { alpha, beta }) if !pressed => {
            with_kernel(task, law::Spring { alpha, beta })
        }
        _ => with_kernel(task, law::General(laws(chain).into())),
    }
}

/// The laws of a chain's contacts at their places in rows.
fn laws(chain: &Chain) -> Vec<Option<Law>> {
    let mut laws = vec![None; first_contact(chain)];
    laws.extend(
        chain
            .all_contacts()
            .map(|contact| Some(contact.law.clone())),
    );
    if chain.ends == Ends::Periodic {
        laws[1] = laws[chain.n_sites() + 1].clone();
    }
    laws
}

fn with_kernel<K: Kernel + 'static>(task: &Task, kernel: K) -> Result<Box<dyn Stepping>> {
    let simulation = task.simulation;
    let adapts = simulation.scheme.is_adaptive();
    let can = adapts || matches!(task.control, StepControl::Fixed(_));
    Error::require(can, "step", "a step length for this scheme", "none")?;
    let cell = simulation.chain.law.each().iter();
    let mut powers: Vec<f64> = cell.filter_map(Law::opens).collect();
    powers.sort_by(f64::total_cmp);
    powers.dedup();
    // A correction would not be symplectic.
    powers.retain(|_| adapts);
    let corrections = powers.into_iter().map(Correction::new).collect();
    let system = System::new(&simulation.chain, kernel, simulation.drive.clone());
    let state = initial_state(task, &system);
    let driver = Driver::new(
        task,
        system,
        simulation.scheme.tableau(),
        corrections,
        state,
    );
    Ok(Box::new(driver))
}

fn initial_state<K: Kernel>(task: &Task, system: &System<K>) -> State {
    let simulation = task.simulation;
    let row = || AlignedRow::zeros(system.places());
    let followed = || {
        if task.energy {
            row()
        } else {
            AlignedRow::default()
        }
    };
    let (mut x, mut v, mut force) = (row(), row(), row());
    x[FIRST_SITE..][..system.sites].copy_from_slice(&simulation.displacement);
    v[FIRST_SITE..][..system.sites].copy_from_slice(&simulation.velocity);
    if let Some(all) = &system.resonators {
        let [at, speed] = match &simulation.resonators {
            Some(own) => own.each_ref(),
            None => [&simulation.displacement, &simulation.velocity],
        };
        for j in all.sites() {
            let s = resonator_place(system.sites, j);
            (x[s], v[s]) = (at[j], speed[j]);
        }
    }
    system.place(0.0, &mut x, &mut v);
    for s in system.contacts.clone() {
        force[s] = system.force(s, 0.0, &x, &v).0;
    }
    if system.periodic {
        force[1] = force[system.sites + 1];
    }
    State {
        x,
        v,
        force,
        passed: followed(),
        lost: followed(),
        input: 0.0,
    }
}
