//! How a chain and its start change with a parameter.

use crate::chain::drive::{Drive, Waveform};
use crate::chain::lattice::{Contact, Ends};
use crate::chain::simulation::Simulation;
use crate::error::{Error, Result};

/// The derivative of a simulation's data with respect to a parameter, by a central difference of the data, not of runs.
#[derive(Debug, Clone)]
pub struct Direction {
    /// Where the parameter is less and more by half of `length`.
    pub(super) ends: [Simulation; 2],
    pub(super) length: f64,
    /// The largest derivative of the data over the size of what changes.
    pub(super) relative: f64,
}

/// Rows of what a parameter may change: inverse masses; coefficients and static overlaps of contacts; dashpot, tangent damping and
/// drag; velocities and displacements at the start, those of resonators behind those of bodies; coefficients of the ground; inverse
/// masses, stiffnesses and damping of resonators.
pub(super) fn data(simulation: &Simulation) -> [Vec<f64>; 12] {
    let chain = &simulation.chain;
    let contacts: Vec<Contact> = chain.all_contacts().collect();
    let inverse = |masses: &[f64]| masses.iter().map(|mass| 1.0 / mass).collect();
    let (mut x, mut v) = (simulation.displacement.clone(), simulation.velocity.clone());
    let [mut mobility, mut stiffness, mut damping] = [const { Vec::new() }; 3];
    if let Some(all) = chain.resonators() {
        let bodies = || [x.clone(), v.clone()];
        let [y, w] = simulation.resonators.clone().unwrap_or_else(bodies);
        x.extend(y);
        v.extend(w);
        (mobility, stiffness) = (inverse(&all.mass), all.stiffness.clone());
        damping = all.damping.clone();
    }
    let ground = chain.on_site.ground.as_ref();
    [
        inverse(&chain.mass),
        contacts.iter().map(|of| of.coefficient).collect(),
        contacts.iter().map(|of| of.static_overlap).collect(),
        vec![chain.losses.dashpot],
        vec![chain.losses.tangent],
        vec![chain.losses.drag],
        v,
        x,
        ground.map_or(Vec::new(), |ground| ground.coefficient.clone()),
        mobility,
        stiffness,
        damping,
    ]
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
        let expected = "a parameter that changes values, not how many sites there are, the ends, or the end time";
        let alike = kind(below) == kind(above);
        Error::require(alike, "gradient", expected, "another chain")?;
        if let [Some(a), Some(b)] = [&below.drive, &above.drive] {
            let kinks = |drive: &Drive| drive.waveform().kinks().collect::<Vec<f64>>();
            let stays = a.site() == b.site() && kinks(a) == kinks(b);
            let expected = "a parameter that does not move when the drive sets in or ends";
            Error::require(stays, "gradient", expected, "one that does")?;
        }
        let [mut low, mut high] = [below, above].map(|of| Vec::from(&data(of)[..7]));
        for (rows, of) in [(&mut low, below), (&mut high, above)] {
            rows[6].push(of.velocity_scale(0.0));
            let wave = of.drive.as_ref().map(Drive::waveform);
            rows.push(wave.map(Waveform::amplitude).into_iter().collect());
        }
        let relative = |(low, high): (&Vec<f64>, &Vec<f64>)| {
            let pairs = low.iter().zip(high);
            let changed = pairs.fold(0.0, |most: f64, (a, b)| most.max((b - a).abs()));
            let size = high
                .iter()
                .fold(0.0, |most: f64, value| most.max(value.abs()));
            if size > 0.0 { changed / size } else { 0.0 }
        };
        let changes = low.iter().zip(&high).map(relative);
        Ok(Direction {
            ends: [below.clone(), above.clone()],
            length,
            relative: changes.fold(0.0, f64::max) / length,
        })
    }
}
