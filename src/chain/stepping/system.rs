//! The memory layout of a chain: a ghost place at each end, and one index for places and contacts.
//!
//! Place s holds site s - 1; places 0 and N + 1 are walls, images, or nothing. Index s also names
//! the contact on the left of place s, between the places s - 1 and s: contact j of the chain is at
//! j + 2, one with a wall before site 0 at 1. All rows are padded with zeros to whole blocks: a
//! coefficient or a mobility of 0 marks a missing contact or site. Resonators follow behind the last ghost, a place
//! a site, without contacts.

use super::super::drive::{Drive, Waveform};
use super::super::lattice::{Chain, Ends, Ground, Losses};
use super::super::law::Kernel;
use super::super::resonators::Resonators;
use super::islands::Island;
use crate::numeric::lanes::AlignedRow;

#[derive(Debug)]
pub(super) struct System<K> {
    pub(super) kernel: K,
    /// Sites.
    pub(super) sites: usize,
    pub(super) coefficient: AlignedRow,
    pub(super) static_overlap: AlignedRow,
    /// The power with which each contact opens; 0 where it does not.
    pub(super) opens: AlignedRow,
    /// Whether all contacts open.
    pub(super) all_open: bool,
    /// 1/m; 0 for ghosts and for a body that moves as it is told.
    pub(super) mobility: AlignedRow,
    /// Mass of the body that is driven.
    pub(super) driven_mass: f64,
    pub(super) losses: Losses,
    pub(super) ground: Option<Ground>,
    pub(super) resonators: Option<Resonators>,
    pub(super) periodic: bool,
    pub(super) drive: Option<Drive>,
    /// The contacts that exist, the last excluded.
    pub(super) contacts: std::ops::Range<usize>,
    /// The flux through a contact is its force times these shares of the speeds left and right.
    pub(super) flux_share: [AlignedRow; 2],
}

/// Positions, velocities, forces, and what the contacts have passed on and the sites have lost.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) x: AlignedRow,
    pub(crate) v: AlignedRow,
    /// Force in each contact, damping included.
    pub(crate) force: AlignedRow,
    /// Energy passed through each contact; empty where it is not followed.
    pub(crate) passed: AlignedRow,
    /// Energy lost at each place; empty where it is not followed.
    pub(crate) lost: AlignedRow,
    /// Energy put in by a force on a body.
    pub(crate) input: f64,
}

impl State {
    /// Displacements and velocities of the resonators of a chain; empty without.
    pub(crate) fn resonators(&self, chain: &Chain) -> [&[f64]; 2] {
        let n = chain.n_sites();
        match chain.resonators() {
            Some(_) => [&self.x, &self.v].map(|row| &row[resonator_place(n, 0)..][..n]),
            None => [&[]; 2],
        }
    }

    /// Energy put in by whatever drives the chain; 0 where it is not followed.
    pub(crate) fn put_in(&self) -> f64 {
        self.passed.get(1).copied().unwrap_or(0.0) + self.input
    }
}

/// Where place s, or contact s on its left, is among the sites, or contacts, of the chain.
pub(crate) const FIRST_SITE: usize = 1;
pub(crate) const FIRST_CONTACT: usize = 2;

/// The place of the first contact that a chain has.
pub(crate) fn first_contact(chain: &Chain) -> usize {
    FIRST_CONTACT - usize::from(chain.has_left_wall())
}

/// The place of the resonator of site j, of n.
pub(super) fn resonator_place(n: usize, j: usize) -> usize {
    FIRST_SITE + n + 1 + j
}

impl<K: Kernel> System<K> {
    pub(super) fn new(chain: &Chain, kernel: K, drive: Option<Drive>) -> System<K> {
        let (n, m) = (chain.n_sites(), chain.n_contacts());
        let periodic = chain.ends == Ends::Periodic;
        let places = n + 2 + chain.resonators().map_or(0, |_| n);
        let row = || AlignedRow::zeros(places);
        let [mut coefficient, mut static_overlap, mut opens, mut mobility] =
            [(); 4].map(|()| row());
        for (s, contact) in (first_contact(chain)..).zip(chain.all_contacts()) {
            coefficient[s] = contact.coefficient;
            static_overlap[s] = contact.static_overlap;
            opens[s] = contact.law.opens().unwrap_or(0.0);
        }
        if periodic {
            for row in [&mut coefficient, &mut static_overlap, &mut opens] {
                row[1] = row[n + 1];
            }
        }
        for (inverse, mass) in mobility[FIRST_SITE..].iter_mut().zip(&chain.mass) {
            *inverse = 1.0 / mass;
        }
        for (j, all) in chain
            .resonators()
            .iter()
            .flat_map(|all| all.sites().map(move |j| (j, all)))
        {
            mobility[resonator_place(n, j)] = 1.0 / all.mass[j];
        }
        let mut flux_share = [row(), row()];
        for share in &mut flux_share {
            share[FIRST_CONTACT..n + 1].fill(0.5);
            if periodic {
                share[n + 1] = 0.5;
            }
        }
        match drive {
            Some(Drive::Wall(_)) => flux_share[0][1] = 1.0,
            Some(Drive::Force(_)) => flux_share[1][1] = 1.0,
            Some(Drive::Body(..) | Drive::Motion(..)) | None => {}
        }
        let driven = drive.as_ref().map_or(0, Drive::site);
        if let Some((site, _)) = drive.as_ref().and_then(Drive::motion) {
            mobility[FIRST_SITE + site] = 0.0;
        }
        let ends = matches!(drive, Some(Drive::Force(_) | Drive::Wall(_)));
        let first = if coefficient[1] == 0.0 && !ends {
            FIRST_CONTACT
        } else {
            1
        };
        System {
            kernel,
            sites: n,
            coefficient,
            static_overlap,
            opens,
            all_open: chain.law.all_open(),
            mobility,
            driven_mass: chain.mass[driven],
            losses: chain.losses,
            ground: chain.on_site.ground.clone(),
            resonators: chain.on_site.resonators.clone(),
            periodic,
            drive,
            contacts: first..FIRST_CONTACT + m,
            flux_share,
        }
    }

    /// Places, ghosts and resonators included.
    pub(super) fn places(&self) -> usize {
        self.sites + 2 + self.resonators.as_ref().map_or(0, |_| self.sites)
    }

    /// Overlap of contact s beyond the static one.
    #[inline(always)]
    pub(super) fn excess_overlap(&self, s: usize, x: &[f64]) -> f64 {
        x[s - 1] - x[s]
    }

    /// Overlap of contact s.
    #[inline(always)]
    pub(super) fn overlap(&self, s: usize, x: &[f64]) -> f64 {
        self.static_overlap[s] + self.excess_overlap(s, x)
    }

    /// Force of the ground on the site at place s, towards -x.
    pub(super) fn held(&self, s: usize, x: f64) -> f64 {
        match (&self.ground, s.checked_sub(FIRST_SITE)) {
            (Some(ground), Some(j)) if j < self.sites => ground.spring(j).force(x),
            _ => 0.0,
        }
    }

    /// Force of the resonator of site j on its body, towards +x; 0 without one.
    #[inline(always)]
    pub(super) fn resonator_force(&self, j: usize, [x, v]: [&[f64]; 2]) -> f64 {
        let (body, own) = (FIRST_SITE + j, resonator_place(self.sites, j));
        match &self.resonators {
            Some(all) if j < self.sites => all.force(j, x[own] - x[body], v[own] - v[body]),
            _ => 0.0,
        }
    }

    /// Displacement, velocity and acceleration of place s at time t.
    #[inline(always)]
    pub(super) fn motion(&self, drive: Option<&Drive>, s: usize, t: f64, at: &State) -> [f64; 3] {
        let State { x, v, force, .. } = at;
        let site = s.checked_sub(FIRST_SITE);
        let outer = match drive {
            Some(Drive::Wall(wave)) if s == 0 => return [x[s], v[s], wave.acceleration_at(t)],
            Some(Drive::Motion(moved, wave)) if site == Some(*moved) => {
                return [x[s], v[s], wave.acceleration_at(t)];
            }
            Some(Drive::Body(driven, wave)) if site == Some(*driven) => wave.at(t),
            _ => 0.0,
        };
        let right = force.get(s + 1).copied().unwrap_or(0.0);
        let pulled = site.map_or(0.0, |j| self.resonator_force(j, [x, v]));
        let push = force[s] - right + outer + pulled;
        let held = self.held(s, x[s]) + self.losses.drag * v[s];
        [x[s], v[s], self.mobility[s] * (push - held)]
    }

    /// The place of a body that is driven, by a force or as it moves.
    #[inline(always)]
    pub(super) fn driven(&self) -> Option<usize> {
        match &self.drive {
            Some(Drive::Body(site, _) | Drive::Motion(site, _)) => Some(FIRST_SITE + site),
            _ => None,
        }
    }

    /// The place that moves as it is told, and its displacement.
    #[inline(always)]
    pub(super) fn moved(&self) -> Option<(usize, &Waveform)> {
        match &self.drive {
            Some(Drive::Wall(wave)) => Some((0, wave)),
            Some(Drive::Motion(site, wave)) => Some((FIRST_SITE + site, wave)),
            _ => None,
        }
    }

    /// Force from outside on the driven body at place s, where contacts have these forces and others pull it back by
    /// `pull`.
    #[inline(always)]
    pub(super) fn outer_force(&self, s: usize, t: f64, force: &[f64], pull: f64) -> f64 {
        let right = force.get(s + 1).copied().unwrap_or(0.0);
        let inner = || force[s] - right - pull;
        let drive = self.drive.as_ref();
        drive.map_or(0.0, |drive| drive.push_at(t, self.driven_mass, inner))
    }

    /// Whether bodies feel other forces than those of their contacts.
    pub(super) fn has_pulls(&self) -> bool {
        self.losses.any()
            || self.ground.is_some()
            || self.resonators.is_some()
            || self.driven().is_some()
    }

    /// Whether anything takes energy out.
    pub(super) fn is_lossy(&self) -> bool {
        self.losses.any()
            || self
                .resonators
                .as_ref()
                .is_some_and(Resonators::any_damping)
    }

    /// Whether something drives the first end.
    pub(super) fn drives_end(&self) -> bool {
        matches!(self.drive, Some(Drive::Force(_) | Drive::Wall(_)))
    }

    /// Damping force of contact s, of excess overlap r, that closes with this speed.
    #[inline(always)]
    pub(super) fn damping(&self, s: usize, r: f64, closing: f64) -> f64 {
        let (losses, c, d0) = (self.losses, self.coefficient[s], self.static_overlap[s]);
        if c == 0.0 {
            return 0.0;
        }
        let closed = d0 + r > 0.0 || self.opens[s] == 0.0;
        let dashpot = if closed { losses.dashpot } else { 0.0 };
        (dashpot + losses.tangent * self.kernel.stiffness(s, c, d0, r)) * closing
    }

    /// Force of contact s at time t, damping included, and the damping alone.
    #[inline(always)]
    pub(super) fn force(&self, s: usize, t: f64, x: &[f64], v: &[f64]) -> (f64, f64) {
        if let (1, Some(Drive::Force(wave))) = (s, &self.drive) {
            return (wave.at(t), 0.0);
        }
        let r = self.excess_overlap(s, x);
        let (c, d0) = (self.coefficient[s], self.static_overlap[s]);
        let elastic = self.kernel.force(s, c, d0, r);
        if !self.losses.any() {
            return (elastic, 0.0);
        }
        let damping = self.damping(s, r, v[s - 1] - v[s]);
        (elastic + damping, damping)
    }

    /// How what contact s loses is split between the places beside it.
    pub(super) fn loss_share(&self, s: usize) -> [f64; 2] {
        match (self.is_site(s - 1), self.is_site(s)) {
            (true, true) => [0.5, 0.5],
            // The closing contact of a ring is there twice, at either end.
            (left, _) if self.periodic => {
                if left {
                    [0.5, 0.0]
                } else {
                    [0.0, 0.5]
                }
            }
            (true, false) => [1.0, 0.0],
            _ => [0.0, 1.0],
        }
    }

    /// Whether place s holds a body of the chain.
    pub(super) fn is_site(&self, s: usize) -> bool {
        (FIRST_SITE..FIRST_SITE + self.sites).contains(&s)
    }

    /// Whether places that move as they are told or are images of others, which a block alone does not know, or their
    /// contacts, are in an island.
    pub(super) fn has_placed_in(&self, island: &Island) -> bool {
        let places = island.places();
        let at_end = places.start == 0 && (self.periodic || self.drives_end());
        at_end
            || self
                .moved()
                .is_some_and(|(place, _)| places.contains(&place))
    }

    /// Sets these places as they are at time t.
    pub(super) fn place(&self, t: f64, x: &mut [f64], v: &mut [f64]) {
        let n = self.sites;
        if let Some((place, wave)) = self.moved() {
            (x[place], v[place]) = (wave.at(t), wave.rate_at(t));
        }
        if self.periodic {
            (x[0], v[0], x[n + 1], v[n + 1]) = (x[n], v[n], x[1], v[1]);
        }
    }
}
