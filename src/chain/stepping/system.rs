//! A chain laid out for stepping: a ghost site at each end, contact i between places i and i + 1.

use super::super::drive::Drive;
use super::super::lattice::{Chain, Ends, Losses};
use super::super::law::Kernel;

/// Place s holds site s - 1; place 0 and the last one are walls, images, or nothing.
#[derive(Debug)]
pub(super) struct System<K> {
    pub(super) kernel: K,
    pub(super) coefficient: Vec<f64>,
    pub(super) static_overlap: Vec<f64>,
    /// 1/m; 0 for ghosts.
    pub(super) mobility: Vec<f64>,
    pub(super) losses: Losses,
    pub(super) periodic: bool,
    pub(super) drive: Option<Drive>,
    /// The contacts that exist, the last excluded.
    pub(super) contacts: std::ops::Range<usize>,
    /// The flux through a contact is its force times these shares of the speeds beside it.
    pub(super) flux_share: Vec<[f64; 2]>,
}

/// Positions, velocities, accelerations and what they have passed on and lost.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct State {
    pub(crate) x: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) a: Vec<f64>,
    /// Energy passed through each contact; empty where it is not followed.
    pub(crate) passed: Vec<f64>,
    /// Energy lost at each place; empty where it is not followed.
    pub(crate) lost: Vec<f64>,
}

impl<K: Kernel> System<K> {
    pub(super) fn new(chain: &Chain, kernel: K, drive: Option<Drive>) -> System<K> {
        let n = chain.n_sites();
        let mut coefficient = vec![0.0; n + 1];
        coefficient[1..=chain.n_contacts()].copy_from_slice(&chain.coefficient);
        let mut static_overlap = vec![0.0; n + 1];
        for (j, overlap) in static_overlap[1..=chain.n_contacts()]
            .iter_mut()
            .enumerate()
        {
            *overlap = chain.static_overlap(j);
        }
        let periodic = chain.ends == Ends::Periodic;
        if let Ends::Fixed { left_coefficient } = chain.ends {
            coefficient[0] = left_coefficient;
            static_overlap[0] = chain
                .law
                .static_overlap(left_coefficient, chain.precompression);
        }
        if periodic {
            coefficient[0] = coefficient[n];
            static_overlap[0] = static_overlap[n];
        }
        let mut mobility = vec![0.0; n + 2];
        for (inverse, mass) in mobility[1..].iter_mut().zip(&chain.mass) {
            *inverse = 1.0 / mass;
        }
        let mut flux_share = vec![[0.5, 0.5]; n + 1];
        flux_share[0] = match drive {
            Some(Drive::Wall(_)) => [1.0, 0.0],
            Some(Drive::Force(_)) => [0.0, 1.0],
            None => [0.0, 0.0],
        };
        if !periodic {
            flux_share[n] = [0.0, 0.0];
        }
        let first = usize::from(coefficient[0] == 0.0 && drive.is_none());
        System {
            kernel,
            coefficient,
            static_overlap,
            mobility,
            losses: chain.losses,
            periodic,
            drive,
            contacts: first..1 + chain.n_contacts(),
            flux_share,
        }
    }

    pub(super) fn places(&self) -> usize {
        self.mobility.len()
    }

    /// Overlap of contact i.
    #[inline(always)]
    pub(super) fn overlap(&self, i: usize, x: &[f64]) -> f64 {
        self.static_overlap[i] + (x[i] - x[i + 1])
    }

    /// How what contact i loses is split between the places beside it.
    pub(super) fn loss_share(&self, i: usize) -> [f64; 2] {
        match (self.mobility[i] > 0.0, self.mobility[i + 1] > 0.0) {
            (true, true) => [0.5, 0.5],
            (true, false) => [1.0, 0.0],
            _ => [0.0, 1.0],
        }
    }

    /// Puts the ghosts where the ends say at time t.
    #[inline(always)]
    pub(super) fn place_ghosts(&self, t: f64, first: usize, x: &mut [f64], v: &mut [f64]) {
        if let Some(Drive::Wall(wave)) = &self.drive
            && first == 0
        {
            x[0] = wave.at(t);
            v[0] = wave.rate_at(t);
        }
    }

    /// Accelerations of the places `first..`, from the contacts between them alone.
    ///
    /// `x`, `v` and `a` start at place `first`; `force` is one longer than they are, contact `i`
    /// between the places `i` and `i + 1` of the slice at `force[i + 1]`, zeros at both ends.
    /// `damping` holds the part of the force that damps, where there are losses.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(super) fn accelerate<const LOSSY: bool>(
        &self,
        t: f64,
        first: usize,
        x: &[f64],
        v: &[f64],
        force: &mut [f64],
        damping: &mut [f64],
        a: &mut [f64],
    ) {
        let n = a.len();
        let contacts = n - 1;
        let (x, v, force) = (&x[..n], &v[..n], &mut force[..n + 1]);
        let c = &self.coefficient[first..first + contacts];
        let d0 = &self.static_overlap[first..first + contacts];
        force[0] = 0.0;
        force[n] = 0.0;
        for i in 0..contacts {
            force[i + 1] = self.kernel.force(c[i], d0[i], x[i] - x[i + 1]);
        }
        if LOSSY {
            let Losses {
                dashpot, tangent, ..
            } = self.losses;
            let damping = &mut damping[..n + 1];
            for i in 0..contacts {
                let r = x[i] - x[i + 1];
                let closed = if d0[i] + r > 0.0 || self.kernel.opening_power().is_none() {
                    dashpot
                } else {
                    0.0
                };
                let stiffness = self.kernel.stiffness(c[i], d0[i], r);
                damping[i + 1] = (closed + tangent * stiffness) * (v[i] - v[i + 1]);
                force[i + 1] += damping[i + 1];
            }
        }
        if let Some(Drive::Force(wave)) = &self.drive
            && first == 0
        {
            force[1] = wave.at(t);
        }
        let mobility = &self.mobility[first..first + n];
        for s in 0..n {
            a[s] = (force[s] - force[s + 1]) * mobility[s];
        }
        if LOSSY && self.losses.drag > 0.0 {
            for s in 0..n {
                a[s] -= self.losses.drag * mobility[s] * v[s];
            }
        }
        if self.periodic {
            a[0] = a[n - 2];
            a[n - 1] = a[1];
        }
    }
}
