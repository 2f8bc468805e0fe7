//! All contacts of a chain at one instant: what every budget starts from.

use super::motion::{Instant, Motion};
use crate::chain::{Chain, Drive, Ends, Law};

/// The contacts of a chain in order of x, one with a wall before site 0 first.
#[derive(Debug)]
pub(super) struct Contacts<'a> {
    chain: &'a Chain,
    drive: Option<&'a Drive>,
    /// 1 where a wall stands before site 0, else 0.
    pub(super) offset: usize,
    coefficient: Vec<f64>,
    static_overlap: Vec<f64>,
}

/// What the contacts do at one instant; each row as long as there are contacts.
#[derive(Debug, Clone, Default)]
pub(super) struct ContactState {
    /// Overlap beyond the static one.
    pub(super) overlap: Vec<f64>,
    /// Rate of the overlap, that of a driven wall included.
    pub(super) closing: Vec<f64>,
    /// Elastic force beyond the static one.
    pub(super) elastic: Vec<f64>,
    pub(super) damping: Vec<f64>,
    /// Energy beyond the static state.
    pub(super) energy: Vec<f64>,
    /// `phi = sign(r) sqrt(V)`, so that the energy is a square.
    pub(super) phi: Vec<f64>,
    /// `d phi / d r = F / (2 phi)`, with its limit where phi is 0.
    pub(super) phi_slope: Vec<f64>,
    /// Velocity of the wall before site 0, and the force that pushes site 0 from outside.
    pub(super) wall_velocity: f64,
    pub(super) push: f64,
}

impl ContactState {
    fn resize(&mut self, contacts: usize) {
        let ContactState {
            overlap,
            closing,
            elastic,
            damping,
            energy,
            phi,
            phi_slope,
            ..
        } = self;
        for row in [overlap, closing, elastic, damping, energy, phi, phi_slope] {
            row.resize(contacts, 0.0);
        }
    }
}

impl<'a> Contacts<'a> {
    pub(super) fn of(motion: &Motion<'a>) -> Contacts<'a> {
        let chain = motion.chain;
        let left = match chain.ends {
            Ends::Fixed { left_coefficient } => Some(left_coefficient),
            _ => None,
        };
        let coefficient: Vec<f64> = left.into_iter().chain(chain.coefficient.clone()).collect();
        let of = |c: &f64| chain.law.static_overlap(*c, chain.precompression);
        Contacts {
            chain,
            drive: motion.drive,
            offset: usize::from(left.is_some()),
            static_overlap: coefficient.iter().map(of).collect(),
            coefficient,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.coefficient.len()
    }

    /// The sites that contact i joins, `None` for a wall.
    pub(super) fn sites(&self, i: usize) -> [Option<usize>; 2] {
        let n = self.chain.n_sites();
        let right = i + 1 - self.offset;
        let right = match self.chain.ends {
            _ if right < n => Some(right),
            Ends::Periodic => Some(0),
            _ => None,
        };
        [i.checked_sub(self.offset), right]
    }

    /// What contacts of these forces push site j with.
    #[inline]
    pub(super) fn push_on(&self, j: usize, force: &[f64]) -> f64 {
        let right = force.get(j + self.offset).copied().unwrap_or(0.0);
        let left = match (j + self.offset).checked_sub(1) {
            Some(left) => force[left],
            None if self.chain.ends == Ends::Periodic => force[force.len() - 1],
            None => 0.0,
        };
        left - right
    }

    /// Fills `state` from displacements and velocities at time t.
    pub(super) fn evaluate(&self, t: f64, x: &[f64], v: &[f64], state: &mut ContactState) {
        state.resize(self.len());
        let (wall, wall_velocity, push) = match self.drive {
            Some(Drive::Wall(wave)) => (wave.at(t), wave.rate_at(t), 0.0),
            Some(Drive::Force(wave)) => (0.0, 0.0, wave.at(t)),
            None => (0.0, 0.0, 0.0),
        };
        (state.wall_velocity, state.push) = (wall_velocity, push);
        let law = self.chain.law;
        for i in 0..self.len() {
            let [left, right] = self.sites(i);
            let at =
                |site: Option<usize>, values: &[f64], wall: f64| site.map_or(wall, |j| values[j]);
            // A wall on the right stands still.
            let r = at(left, x, wall) - at(right, x, 0.0);
            let closing = at(left, v, wall_velocity) - at(right, v, 0.0);
            let (c, d0) = (self.coefficient[i], self.static_overlap[i]);
            let force = law.force(c, d0, r);
            let energy = law.energy(c, d0, r);
            let phi = energy.max(0.0).sqrt().copysign(r);
            state.overlap[i] = r;
            state.closing[i] = closing;
            state.elastic[i] = force;
            state.damping[i] = self.chain.damping(c, r, closing);
            state.energy[i] = energy;
            state.phi[i] = phi;
            state.phi_slope[i] = if phi == 0.0 {
                (0.5 * law.stiffness(c, d0, r)).sqrt()
            } else {
                0.5 * force / phi
            };
        }
    }

    /// Force, damping included, and mean speed of contact j of the chain; a wall's has no speed,
    /// since nothing passes it.
    pub(super) fn force_and_speed(&self, j: usize, at: Instant) -> (f64, f64) {
        let i = j + self.offset;
        match self.sites(i) {
            [Some(left), Some(right)] => {
                let r = at.x[left] - at.x[right];
                let closing = at.v[left] - at.v[right];
                let damping = self.chain.damping(self.coefficient[i], r, closing);
                let force = self.force(i, r) + damping;
                (force, 0.5 * (at.v[left] + at.v[right]))
            }
            _ => (0.0, 0.0),
        }
    }

    /// Elastic force of contact i at an overlap beyond the static one.
    pub(super) fn force(&self, i: usize, r: f64) -> f64 {
        self.chain
            .law
            .force(self.coefficient[i], self.static_overlap[i], r)
    }

    /// Force of contact i, damping included, at an overlap beyond the static one and its rate.
    pub(super) fn total_force(&self, i: usize, r: f64, closing: f64) -> f64 {
        self.force(i, r) + self.chain.damping(self.coefficient[i], r, closing)
    }

    /// Stiffness of contact i at an overlap beyond the static one.
    pub(super) fn stiffness_at(&self, i: usize, r: f64) -> f64 {
        let (c, d0) = (self.coefficient[i], self.static_overlap[i]);
        self.chain.law.stiffness(c, d0, r)
    }

    /// Energy of contact i at an overlap beyond the static one.
    pub(super) fn energy(&self, i: usize, r: f64) -> f64 {
        self.chain
            .law
            .energy(self.coefficient[i], self.static_overlap[i], r)
    }

    /// Whether small waves on the static state are those of a linear chain.
    pub(super) fn has_linear_limit(&self) -> bool {
        self.chain.precompression > 0.0 || matches!(self.chain.law, Law::Spring { .. })
    }

    /// Stiffness of contact i in the static state.
    pub(super) fn stiffness(&self, i: usize) -> f64 {
        self.chain
            .law
            .stiffness(self.coefficient[i], self.static_overlap[i], 0.0)
    }

    pub(super) fn chain(&self) -> &'a Chain {
        self.chain
    }
}
