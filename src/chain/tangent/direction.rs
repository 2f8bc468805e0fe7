//! How a chain and its start change with a parameter.

use crate::chain::drive::{Drive, Waveform};
use crate::chain::lattice::{Chain, Contact, Ends, refuse};
use crate::chain::law::Laws;
use crate::chain::simulation::Simulation;
use crate::error::Result;

/// The derivative of a simulation's data with respect to a parameter, by a central difference of the data, not of runs.
#[derive(Debug, Clone)]
pub struct Direction {
    pub(super) mass: Vec<f64>,
    /// Of the contacts, one with a wall before site 0 first.
    pub(super) coefficient: Vec<f64>,
    pub(super) static_overlap: Vec<f64>,
    pub(super) dashpot: f64,
    pub(super) tangent: f64,
    pub(super) drag: f64,
    pub(super) ground: Vec<f64>,
    /// Mass, stiffness and damping of resonators.
    pub(super) resonators: [Vec<f64>; 3],
    /// Displacements and velocities at the start, those of resonators behind those of bodies.
    pub(super) start: [Vec<f64>; 2],
    /// Laws at both ends of the difference, where they are not the same: of contacts, and to the ground.
    pub(super) laws: Option<[Laws; 2]>,
    pub(super) ground_laws: Option<[Laws; 2]>,
    pub(super) drive: Option<[Waveform; 2]>,
    /// Length of the difference.
    pub(super) length: f64,
    /// The largest of these derivatives over the size of what changes.
    pub(super) relative: f64,
}

/// All contacts of a chain, one with a wall before site 0 first.
pub(super) fn all_contacts(chain: &Chain) -> impl Iterator<Item = Contact<'_>> {
    chain.left_contact().into_iter().chain(chain.contacts())
}

/// Displacements and velocities at the start, those of resonators behind those of bodies.
pub(super) fn start_of(simulation: &Simulation) -> [Vec<f64>; 2] {
    let mut start = [simulation.displacement.clone(), simulation.velocity.clone()];
    if simulation.chain.resonators().is_some() {
        let bodies = start.clone();
        let own = simulation.resonators.as_ref().unwrap_or(&bodies);
        for (all, own) in start.iter_mut().zip(own) {
            all.extend_from_slice(own);
        }
    }
    start
}

impl Direction {
    /// From simulations whose parameter is less and more by half of `length`.
    ///
    /// # Errors
    /// [`crate::Error::Request`] for a parameter that changes more than numbers: sites, ends, end time, or when a drive sets in
    /// and ends.
    pub fn between(below: &Simulation, above: &Simulation, length: f64) -> Result<Direction> {
        let chains = [&below.chain, &above.chain];
        let kind = |ends: Ends| std::mem::discriminant(&ends);
        let same = chains[0].n_sites() == chains[1].n_sites()
            && chains[0].n_contacts() == chains[1].n_contacts()
            && kind(chains[0].ends) == kind(chains[1].ends)
            && below.end_time == above.end_time
            && chains.map(|c| c.resonators().is_some())[0] == chains[1].resonators().is_some()
            && chains[0].on_site.ground.is_some() == chains[1].on_site.ground.is_some();
        let expected = "a parameter that changes values, not how many sites there are, the ends, or the end time";
        if !same {
            return Err(refuse("gradient", expected, "another chain"));
        }
        let rate = |a: f64, b: f64| (b - a) / length;
        let rates = |rows: [&[f64]; 2]| -> Vec<f64> {
            rows[0]
                .iter()
                .zip(rows[1])
                .map(|(a, b)| rate(*a, *b))
                .collect()
        };
        let of_contacts = |value: fn(Contact) -> f64| {
            let rows = chains.map(|chain| all_contacts(chain).map(value).collect::<Vec<f64>>());
            rates([&rows[0], &rows[1]])
        };
        let losses = chains.map(|chain| chain.losses);
        let grounds = chains.map(|chain| chain.on_site.ground.as_ref());
        let of_resonators = |which: usize| match chains.map(|chain| chain.resonators()) {
            [Some(a), Some(b)] => {
                let rows = [a, b].map(|all| [&all.mass, &all.stiffness, &all.damping][which]);
                rates([rows[0], rows[1]])
            }
            _ => Vec::new(),
        };
        let starts = [below, above].map(start_of);
        let largest = |row: &[f64]| row.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let relative = |rate: f64, size: f64| if size > 0.0 { rate / size } else { 0.0 };
        let speed = above.velocity_scale(0.0);
        let differ = |laws: [&Laws; 2]| (laws[0] != laws[1]).then(|| laws.map(Laws::clone));
        let mut direction = Direction {
            relative: 0.0,
            mass: rates([&chains[0].mass, &chains[1].mass]),
            coefficient: of_contacts(|contact| contact.coefficient),
            static_overlap: of_contacts(|contact| contact.static_overlap),
            dashpot: rate(losses[0].dashpot, losses[1].dashpot),
            tangent: rate(losses[0].tangent, losses[1].tangent),
            drag: rate(losses[0].drag, losses[1].drag),
            ground: match grounds {
                [Some(a), Some(b)] => rates([&a.coefficient, &b.coefficient]),
                _ => Vec::new(),
            },
            resonators: [0, 1, 2].map(of_resonators),
            start: [0, 1].map(|i| rates([&starts[0][i], &starts[1][i]])),
            laws: differ(chains.map(|chain| &chain.law)),
            ground_laws: match grounds {
                [Some(a), Some(b)] => differ([&a.law, &b.law]),
                _ => None,
            },
            drive: drives([&below.drive, &above.drive])?,
            length,
        };
        let overlaps: Vec<f64> = all_contacts(chains[1])
            .map(|of| of.static_overlap)
            .collect();
        let driven = direction
            .drive
            .as_ref()
            .map(|[a, b]| [a, b].map(Waveform::amplitude));
        direction.relative = [
            relative(largest(&direction.mass), largest(&chains[1].mass)),
            relative(
                largest(&direction.coefficient),
                largest(&chains[1].coefficient),
            ),
            relative(largest(&direction.static_overlap), largest(&overlaps)),
            relative(largest(&direction.start[1]), speed),
            relative(direction.dashpot.abs(), losses[1].dashpot),
            relative(direction.tangent.abs(), losses[1].tangent),
            relative(direction.drag.abs(), losses[1].drag),
            driven.map_or(0.0, |[a, b]| relative(rate(a, b).abs(), b.abs())),
        ]
        .into_iter()
        .fold(0.0, f64::max);
        Ok(direction)
    }
}

/// Both waveforms, where they are not the same.
fn drives([below, above]: [&Option<Drive>; 2]) -> Result<Option<[Waveform; 2]>> {
    let (Some(a), Some(b)) = (below, above) else {
        return Ok(None);
    };
    if a == b {
        return Ok(None);
    }
    let kinks = |drive: &Drive| drive.waveform().kinks().collect::<Vec<f64>>();
    if a.site() != b.site() || kinks(a) != kinks(b) {
        let expected = "a parameter that does not move when the drive sets in or ends";
        return Err(refuse("gradient", expected, "one that does"));
    }
    Ok(Some([a.waveform().clone(), b.waveform().clone()]))
}
