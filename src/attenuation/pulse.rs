//! The pulse at each contact of a struck chain, located inside the steps.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::follow::Following;
use crate::chain::{Ends, Resolution, Simulation};
use crate::observer::Observer;
use crate::{Error, Result};

/// The share of its peak at which a pulse arrives.
pub const FRONT: f64 = 0.01;

/// A value, and by how much it differs when the error of a step is ten times as large.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Located {
    pub value: f64,
    pub error: f64,
}

/// What a pulse is at a contact, in the units of the scene.
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
    /// When that velocity is half of its largest for the last time before it; `None` for a site that
    /// moves so from the start. A kept pulse that does not say which of both is no pulse.
    #[serde(deserialize_with = "stated")]
    pub velocity_rise_time: Option<Located>,
    /// When the force first reaches [`FRONT`] of its peak.
    pub arrival_time: Located,
    /// From the last time before the peak to the first time after it at which the force is half of
    /// the peak.
    pub width: Located,
    /// Energy passed by the first time after the peak at which the force is [`FRONT`] of it; `None`
    /// where that was not seen, and for the wall.
    #[serde(deserialize_with = "stated")]
    pub energy_pulse: Option<Located>,
    /// Energy passed by the end of what is seen. For the wall, through which none passes: through
    /// the contact before it, by the time of the peak.
    pub energy_passed: Located,
    /// Energy left on the striker's side at that time, half of this contact's included.
    pub energy_behind: f64,
    /// Energy lost there until then.
    pub energy_lost: f64,
    /// What passed, was left behind and was lost, less what there was, relative to that.
    pub closure: f64,
}

/// A value that may be null but not absent.
fn stated<'d, D: serde::Deserializer<'d>>(
    value: D,
) -> std::result::Result<Option<Located>, D::Error> {
    Option::deserialize(value)
}

/// Where pulses are followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sense {
    /// At the contacts of one long chain, until its front reaches the last site.
    Chain,
    /// On the wall behind the last body, for twice the time that the front takes to it and ten
    /// contact times more.
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
    /// From contact 0 on; for the wall its one contact, or none where nothing arrived.
    pub pulses: Vec<Pulse>,
    /// End of what was seen.
    pub end_time: f64,
    /// Whether the front reached the last site; losses may eat the pulse before.
    pub arrived: bool,
}

/// Follows the pulse of a simulation and locates what [`Pulse`] holds, by making steps again around
/// each instant; samples play no part. Errors are differences from a second run of coarser steps.
///
/// In the sense of one chain the pulses stop at the first contact whose force has not fallen to
/// half its peak when the front reaches the last site, since a reflection would enter it from
/// there on.
///
/// # Errors
/// As [`Simulation::check`]; [`Error::Request`] for ends that are periodic, or without a wall where
/// that is meant, and for a front that is at the last site from the start; [`Error::Cancelled`].
pub fn pulses(simulation: &Simulation, sense: Sense, observer: &dyn Observer) -> Result<Pulses> {
    let contacts = contacts(simulation, sense)?;
    let follow = |resolution| {
        let following = Following {
            simulation,
            sense,
            resolution,
            observer,
        };
        following.all(contacts.clone())
    };
    let coarse = follow(Resolution::Asked)?;
    let fine = follow(Resolution::Finer)?;
    let pulses = fine
        .pulses
        .into_iter()
        .zip(coarse.pulses)
        .map_while(|(fine, coarse)| {
            let (fine, coarse) = (fine?, coarse?);
            Some(fine.compared_with(&coarse))
        });
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
    let refused = match (sense, chain.ends) {
        (_, Ends::Periodic) => Some(("ends", "ends that a pulse does not run around", "periodic")),
        (Sense::Wall, Ends::Free) => Some(("ends", "a wall for the force on it", "free ends")),
        _ if last > 0 && simulation.velocity[last] != 0.0 => Some((
            "velocities",
            "a last site at rest, which the pulse has yet to reach",
            "a moving one",
        )),
        _ => None,
    };
    match (refused, sense) {
        (Some((option, expected, found)), _) => Err(refuse(option, expected.into(), found.into())),
        (None, Sense::Wall) => Ok(n - 1..n),
        (None, Sense::Chain) => Ok(0..n),
    }
}

pub(super) fn refuse(option: &'static str, expected: String, found: String) -> Error {
    Error::Request {
        option,
        expected,
        found,
    }
}

impl Pulse {
    /// With the differences from another resolution as errors.
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
