//! Resonators on bodies: mass in mass.

use std::f64::consts::TAU;

use super::lattice::{Chain, not_negative};
use crate::{Error, Result};

/// A mass on each body, tied to it alone by a linear spring and a dashpot.
///
/// With `s = y - x` the resonator at y of the body at x obeys `m y'' = -k s - c s'`, and the body gets the opposite
/// force. Of a body without one all three values are 0. In SI: kg, N/m, N s/m.
#[derive(Debug, Clone, PartialEq)]
pub struct Resonators {
    /// Mass of each; 0 is none.
    pub mass: Vec<f64>,
    pub stiffness: Vec<f64>,
    pub damping: Vec<f64>,
}

impl Resonators {
    /// Force of resonator j on its body, towards +x, by how far it is ahead and how fast it gets ahead.
    #[inline]
    pub(crate) fn force(&self, j: usize, ahead: f64, rate: f64) -> f64 {
        self.stiffness[j] * ahead + self.damping[j] * rate
    }

    /// Energy of its spring.
    pub(crate) fn spring_energy(&self, j: usize, ahead: f64) -> f64 {
        0.5 * self.stiffness[j] * ahead * ahead
    }

    /// Its kinetic energy.
    pub(crate) fn kinetic_energy(&self, j: usize, velocity: f64) -> f64 {
        0.5 * self.mass[j] * velocity * velocity
    }

    /// Power that its dashpot takes.
    pub(crate) fn loss(&self, j: usize, rate: f64) -> f64 {
        self.damping[j] * rate * rate
    }

    /// Its frequency while the body is held, in cycles per unit of time; 0 where there is none.
    pub fn frequency(&self, j: usize) -> f64 {
        match self.mass[j] > 0.0 {
            true => (self.stiffness[j] / self.mass[j]).sqrt() / TAU,
            false => 0.0,
        }
    }

    pub(crate) fn any_damping(&self) -> bool {
        self.damping.iter().any(|c| *c > 0.0)
    }

    /// The sites that have one.
    pub(crate) fn sites(&self) -> impl Iterator<Item = usize> {
        (0..self.mass.len()).filter(|j| self.mass[*j] > 0.0)
    }

    /// Square roots of kinetic energies, with the signs of the velocities, and of those of the springs.
    pub(crate) fn root_energies(&self, x: &[f64], [y, w]: [&[f64]; 2]) -> [Vec<f64>; 2] {
        let kinetic = self.mass.iter().zip(w).map(|(m, w)| (0.5 * m).sqrt() * w);
        let ahead = y.iter().zip(x).map(|(y, x)| y - x);
        let springs = self.stiffness.iter().zip(ahead);
        let spring = springs.map(|(k, s)| (0.5 * k).sqrt() * s);
        [kinetic.collect(), spring.collect()]
    }

    pub(super) fn check(&self, n: usize) -> Result<()> {
        let all = [&self.mass, &self.stiffness, &self.damping];
        if let Some(other) = all.iter().find(|values| values.len() != n) {
            let expected = format!("{n} masses, stiffnesses and dampings, one a site");
            return Err(Error::request("resonator_mass", &expected, other.len()));
        }
        not_negative("resonator_mass", all.into_iter().flatten())?;
        let is_part = |j: &usize| {
            let [m, k, c] = all.map(|values| values[*j]);
            (m > 0.0) != (k > 0.0) || m == 0.0 && c > 0.0
        };
        (0..n).find(is_part).map_or(Ok(()), |j| {
            let expected = "a mass and a stiffness, or nothing";
            let found = format!("{} and {} at site {j}", self.mass[j], self.stiffness[j]);
            Err(Error::request("resonator_mass", expected, found))
        })
    }
}

impl Chain {
    pub(crate) fn resonators(&self) -> Option<&Resonators> {
        self.on_site.resonators.as_ref()
    }

    /// Mass of body j and of what is in it.
    pub(crate) fn whole_mass(&self, j: usize) -> f64 {
        self.mass[j] + self.resonators().map_or(0.0, |all| all.mass[j])
    }

    /// The largest angular frequency of a resonator against its body alone; 0 without any.
    pub(crate) fn fastest_resonator(&self) -> f64 {
        self.most_of_resonators(|all| &all.stiffness).sqrt()
    }

    /// The largest rate at which a dashpot relaxes a resonator and its body; 0 without any.
    pub(crate) fn resonator_relaxation(&self) -> f64 {
        self.most_of_resonators(|all| &all.damping)
    }

    /// The largest of these values over the reduced mass.
    fn most_of_resonators(&self, values: impl Fn(&Resonators) -> &[f64]) -> f64 {
        let over =
            |all: &Resonators, j: usize| values(all)[j] * (1.0 / all.mass[j] + 1.0 / self.mass[j]);
        let most = |all: &Resonators| all.sites().map(|j| over(all, j)).fold(0.0, f64::max);
        self.resonators().map_or(0.0, most)
    }

    /// Whether anything takes energy out.
    pub fn is_lossy(&self) -> bool {
        self.losses.any() || self.resonators().is_some_and(Resonators::any_damping)
    }

    /// Energy of all resonators.
    pub(crate) fn resonator_energy(&self, displacement: &[f64], resonators: [&[f64]; 2]) -> f64 {
        let mut energies = vec![0.0; self.resonators().map_or(0, |all| all.mass.len())];
        self.add_resonator_energies(displacement, resonators, &mut energies);
        energies.iter().sum()
    }

    /// Adds the energy of each resonator, at `[displacement, velocity]`, to that of its site.
    pub fn add_resonator_energies(
        &self,
        displacement: &[f64],
        resonators: [&[f64]; 2],
        out: &mut [f64],
    ) {
        let Some(all) = self.resonators() else { return };
        let [y, w] = resonators;
        for (j, energy) in out.iter_mut().enumerate() {
            *energy += all.spring_energy(j, y[j] - displacement[j]) + all.kinetic_energy(j, w[j]);
        }
    }
}
