//! The pulse at each contact of a struck chain, located within the time steps.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::follow::Following;
use crate::chain::{Ends, Resolution, Simulation};
use crate::observer::Observer;
use crate::{Error, Result};

/// The fraction of its peak force at which a pulse arrives.
pub const FRONT: f64 = 0.01;

/// A value and its error: of a simulated pulse the difference from a run with 32 times the local error, of a measured one
/// the standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Located {
    pub value: f64,
    pub error: f64,
}

/// The pulse at a contact, in the units of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pulse {
    /// Contact n joins sites n and n + 1, the striker being site 0: n bodies lie before it.
    pub contact: usize,
    /// Largest force `max F_n(t)` beyond the static one, damping included.
    pub peak_force: Located,
    pub peak_time: Located,
    /// Largest velocity of site n, on the striker's side of the contact.
    pub peak_velocity: Located,
    pub velocity_time: Located,
    /// The last time before its peak at which that velocity rises through half of the peak; `None`
    /// for a site that moves from the start.
    pub velocity_rise_time: Option<Located>,
    /// When the force first reaches [`FRONT`] of its peak.
    pub arrival_time: Located,
    /// Full width at half maximum of the force, from the last crossing before the peak to the first
    /// after it.
    pub width: Located,
    /// Energy passed until the force first falls to [`FRONT`] of its peak; `None` if that is after
    /// the end of the run, and for the wall.
    pub energy_pulse: Option<Located>,
    /// Energy passed until the end of the run. No energy passes the wall: there, the energy passed
    /// through the contact before it until the time of the peak.
    pub energy_passed: Located,
    /// Energy left on the striker's side at that time, half of this contact's included.
    pub energy_behind: f64,
    /// Energy dissipated on the striker's side until then.
    pub energy_lost: f64,
    /// Error of the energy balance: passed + behind + lost - given, relative to the total energy.
    /// `given` is the initial energy on the striker's side plus the energy input.
    pub closure: f64,
}

/// Where pulses are followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sense {
    /// At the contacts of one long chain, until its front reaches the last site.
    Chain,
    /// On the wall behind the last body, until twice the arrival time of the front plus ten contact
    /// times.
    Wall,
}

impl Sense {
    pub fn name(self) -> &'static str {
        match self {
            Sense::Chain => "chain",
            Sense::Wall => "wall",
        }
    }
}

/// The pulses of one simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pulses {
    /// From contact 0 on; for the wall, its one contact, or none if nothing arrived.
    pub pulses: Vec<Pulse>,
    /// End of the observed time.
    pub end_time: f64,
    /// Whether the front reached the last site; losses may damp the pulse out before.
    pub arrived: bool,
}

/// Follows the pulse of a simulation. Peaks and crossings are located by repeating time steps
/// around each event, independently of the sampling. Errors are differences from a second run with
/// coarser steps.
///
/// In the chain sense, the pulses end before the first contact whose force has not fallen to half
/// of its peak when the front reaches the last site: a reflection could disturb it later.
///
/// # Errors
/// As [`Simulation::check`]; [`Error::Request`] for periodic ends, for the wall sense without a
/// wall, and for a last site that moves at the start; [`Error::Cancelled`].
pub fn pulses(simulation: &Simulation, sense: Sense, observer: &dyn Observer) -> Result<Pulses> {
    let contacts = contacts(simulation, sense)?;
    let following = |resolution| Following {
        simulation,
        sense,
        resolution,
        observer,
    };
    let coarse = following(Resolution::Asked).all(contacts.clone())?;
    let fine = following(Resolution::Finer).all(contacts)?;
    let pairs = fine.pulses.into_iter().zip(coarse.pulses);
    let pulses = pairs.map_while(|(fine, coarse)| Some(fine?.compared_with(&coarse?)));
    Ok(Pulses {
        pulses: pulses.collect(),
        end_time: fine.end_time,
        arrived: fine.arrived,
    })
}

/// The contacts at which pulses of a simulation are followed.
///
/// # Errors
/// As [`pulses`], before any work.
pub(super) fn contacts(simulation: &Simulation, sense: Sense) -> Result<Range<usize>> {
    simulation.check()?;
    let chain = &simulation.chain;
    let (last, n) = (chain.n_sites() - 1, chain.n_contacts());
    let is_open = chain.ends != Ends::Periodic;
    Error::require(is_open, "ends", "ends that are not periodic", "periodic")?;
    let has_end = sense == Sense::Chain || chain.ends != Ends::Free;
    Error::require(has_end, "ends", "a wall for the force on it", "free ends")?;
    let is_at_rest = last == 0 || simulation.velocity[last] == 0.0;
    let expected = "a last site at rest, which the pulse has yet to reach";
    Error::require(is_at_rest, "velocities", expected, "a moving one")?;
    Ok(match sense {
        Sense::Wall => n - 1..n,
        Sense::Chain => 0..n,
    })
}

impl Pulse {
    /// The pulse with its differences from another resolution as errors.
    fn compared_with(mut self, other: &Pulse) -> Pulse {
        let compare =
            |own: &mut Located, other: &Located| own.error = (own.value - other.value).abs();
        compare(&mut self.peak_force, &other.peak_force);
        compare(&mut self.peak_time, &other.peak_time);
        compare(&mut self.peak_velocity, &other.peak_velocity);
        compare(&mut self.velocity_time, &other.velocity_time);
        compare(&mut self.arrival_time, &other.arrival_time);
        compare(&mut self.width, &other.width);
        compare(&mut self.energy_passed, &other.energy_passed);
        let both = |own: Option<Located>, other: Option<Located>| {
            let (mut own, other) = (own?, other?);
            compare(&mut own, &other);
            Some(own)
        };
        self.energy_pulse = both(self.energy_pulse, other.energy_pulse);
        self.velocity_rise_time = both(self.velocity_rise_time, other.velocity_rise_time);
        self
    }
}
