//! How a chain and its start change with a parameter.

use crate::chain::drive::{Drive, Waveform};
use crate::chain::lattice::{Chain, Contact, Ends, refuse};
use crate::chain::simulation::Simulation;
use crate::error::Result;

/// The derivative of a simulation's data with respect to a parameter, by a central difference of the data, not of runs.
#[derive(Debug, Clone)]
pub struct Direction {
    /// Where the parameter is less and more by half of `length`.
    pub(super) ends: [Simulation; 2],
    pub(super) length: f64,
    /// The largest derivative of the data over the size of what changes.
    pub(super) relative: f64,
}

/// All contacts of a chain, one with a wall before site 0 first.
pub(super) fn all_contacts(chain: &Chain) -> impl Iterator<Item = Contact<'_>> {
    chain.left_contact().into_iter().chain(chain.contacts())
}

pub(super) fn masses(simulation: &Simulation) -> Vec<f64> {
    simulation.chain.mass.clone()
}

pub(super) fn coefficients(simulation: &Simulation) -> Vec<f64> {
    all_contacts(&simulation.chain)
        .map(|of| of.coefficient)
        .collect()
}

pub(super) fn static_overlaps(simulation: &Simulation) -> Vec<f64> {
    all_contacts(&simulation.chain)
        .map(|of| of.static_overlap)
        .collect()
}

/// Dashpot, tangent damping and drag.
pub(super) fn losses(simulation: &Simulation) -> Vec<f64> {
    let losses = simulation.chain.losses;
    vec![losses.dashpot, losses.tangent, losses.drag]
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
        let kind = |of: &Simulation| {
            let (chain, on_site) = (&of.chain, &of.chain.on_site);
            let parts = [on_site.ground.is_some(), on_site.resonators.is_some()];
            let ends: fn(Ends) -> _ = |ends| std::mem::discriminant(&ends);
            (
                chain.n_sites(),
                chain.n_contacts(),
                ends(chain.ends),
                of.end_time,
                parts,
            )
        };
        if kind(below) != kind(above) {
            let expected = "a parameter that changes values, not how many sites there are, the ends, or the end time";
            return Err(refuse("gradient", expected, "another chain"));
        }
        if let [Some(a), Some(b)] = [&below.drive, &above.drive] {
            let kinks = |drive: &Drive| drive.waveform().kinks().collect::<Vec<f64>>();
            if a.site() != b.site() || kinks(a) != kinks(b) {
                let expected = "a parameter that does not move when the drive sets in or ends";
                return Err(refuse("gradient", expected, "one that does"));
            }
        }
        let amplitude = |of: &Simulation| {
            let wave = of.drive.as_ref().map(Drive::waveform);
            wave.map(Waveform::amplitude).into_iter().collect()
        };
        let relative = |values: &dyn Fn(&Simulation) -> Vec<f64>| {
            let [below, above] = [below, above].map(values);
            let pairs = below.iter().zip(&above);
            let changed = pairs.fold(0.0, |most: f64, (a, b)| most.max((b - a).abs()));
            let size = above
                .iter()
                .fold(0.0, |most: f64, value| most.max(value.abs()));
            if size > 0.0 { changed / size } else { 0.0 }
        };
        let speeds = relative(&|of| {
            of.velocity
                .iter()
                .copied()
                .chain([of.velocity_scale(0.0)])
                .collect()
        });
        let loss = |which: usize| relative(&move |of| vec![losses(of)[which]]);
        let all = [
            relative(&masses),
            relative(&coefficients),
            relative(&static_overlaps),
            speeds,
            loss(0),
            loss(1),
            loss(2),
            relative(&amplitude),
        ];
        Ok(Direction {
            ends: [below.clone(), above.clone()],
            length,
            relative: all.into_iter().fold(0.0, f64::max) / length,
        })
    }
}
