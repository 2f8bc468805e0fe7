//! Energy site by site: energies, fluxes, losses, and whether they balance.
//!
//! `de_j/dt = J_{j-1} - J_j - D_j` with half of each contact's energy and losses at the sites beside
//! it, all of a wall's contact at the site that touches it, and
//! `J_j = (F_j + Fd_j) (v_j + v_{j+1}) / 2`.

use std::ops::Range;

use super::balance::{RunningBalance, add};
use super::contacts::{ContactState, Contacts};
use super::motion::Motion;
use crate::chain::{Ends, NodeState};

/// Energies and rates at one instant.
#[derive(Debug, Clone, Default)]
pub(super) struct SiteTerms {
    /// At each site.
    pub(super) energy: Vec<f64>,
    /// Rate at which each site loses energy.
    pub(super) loss: Vec<f64>,
    /// Through each contact of the chain, towards +x; 0 at a wall.
    pub(super) flux: Vec<f64>,
    /// Power that a driven end puts in.
    pub(super) input: f64,
    /// Part of it that a driven wall puts into its damper.
    pub(super) wall_heat: f64,
    pub(super) kinetic: f64,
    /// In contacts, in springs to the ground, and in those of resonators.
    pub(super) contact: f64,
}

impl SiteTerms {
    /// Those of this instant, with its contacts.
    pub(super) fn evaluate(&mut self, contacts: &Contacts, at: NodeState, state: &ContactState) {
        let chain = contacts.chain;
        let (m, offset) = (chain.n_contacts(), contacts.offset);
        let (energy, loss, flux) = (&mut self.energy, &mut self.loss, &mut self.flux);
        energy.clear();
        let kinetic = chain.mass.iter().zip(at.v);
        energy.extend(kinetic.map(|(m, v)| 0.5 * m * v * v));
        self.kinetic = crate::numeric::sum(energy);
        self.contact = crate::numeric::sum(&state.energy);
        if let Some(ground) = &chain.on_site.ground {
            let held = at.x.iter().enumerate();
            let held: Vec<f64> = held.map(|(j, x)| ground.spring(j).energy(*x)).collect();
            self.contact += crate::numeric::sum(&held);
            add(energy, 1.0, &held);
        }
        (self.input, self.wall_heat) = (0.0, 0.0);
        loss.clear();
        loss.extend(at.v.iter().map(|v| chain.losses.drag * v * v));
        if let Some(all) = chain.resonators() {
            let [y, w] = at.resonators;
            for j in all.sites() {
                let of = [
                    all.kinetic_energy(j, w[j]),
                    all.spring_energy(j, y[j] - at.x[j]),
                ];
                self.kinetic += of[0];
                self.contact += of[1];
                energy[j] += of[0] + of[1];
                loss[j] += all.loss(j, w[j] - at.v[j]);
            }
        }
        flux.clear();
        flux.resize(m, 0.0);
        // That with a wall before site 0 comes last.
        for i in (offset..contacts.each.len()).chain(0..offset) {
            let heat = state.damping[i] * state.closing[i];
            let force = state.elastic[i] + state.damping[i];
            let sites = contacts.each[i].sites;
            if let [Some(left), Some(right)] = sites {
                flux[i - offset] = 0.5 * force * (at.v[left] + at.v[right]);
            }
            let share = if sites.contains(&None) { 1.0 } else { 0.5 };
            for site in sites.into_iter().flatten() {
                energy[site] += share * state.energy[i];
                loss[site] += share * heat;
            }
            if sites[0].is_none() {
                self.input += force * state.wall_velocity;
                self.wall_heat = state.damping[i] * state.wall_velocity;
            }
        }
        self.input += state.push * at.v.get(contacts.pushed()).copied().unwrap_or(0.0);
    }
}

/// Energies that came and went since the first sample.
#[derive(Debug, Clone, Default)]
pub(super) struct Exchanged {
    /// Through each contact towards +x.
    pub(super) passed: Vec<f64>,
    /// At each site; empty for a chain without losses.
    pub(super) lost: Vec<f64>,
    pub(super) input: f64,
}

impl Exchanged {
    /// Adds a node of a quadrature.
    pub(super) fn add(&mut self, weight: f64, rates: &SiteTerms) {
        add(&mut self.passed, weight, &rates.flux);
        add(&mut self.lost, weight, &rates.loss);
        self.input += weight * rates.input;
    }

    /// Takes what the motion followed inside its steps up to sample i.
    pub(super) fn set(&mut self, motion: &Motion, i: usize) {
        let followed = [
            (&mut self.passed, motion.energy_passed),
            (&mut self.lost, motion.energy_lost),
        ];
        for (sums, array) in followed {
            if let Some(array) = array {
                sums.clear();
                sums.extend(&array.row(i));
            }
        }
        self.input = motion.energy_input.map_or(self.input, |input| input[i]);
    }
}

/// Follows what each site holds less what came, plus what went and was lost, over a window: it is constant.
#[derive(Debug)]
pub(super) struct SiteBalance {
    times: Range<usize>,
    sites: Range<usize>,
    periodic: bool,
    /// The site at which a drive puts energy in.
    driven: usize,
    pub(super) exchanged: Exchanged,
    kept: Vec<f64>,
    balance: RunningBalance,
}

impl SiteBalance {
    pub(super) fn new(
        times: Range<usize>,
        sites: Range<usize>,
        contacts: &Contacts,
    ) -> SiteBalance {
        let chain = contacts.chain;
        let lossy = if chain.is_lossy() { chain.n_sites() } else { 0 };
        SiteBalance {
            times,
            sites,
            driven: contacts.pushed(),
            periodic: chain.ends == Ends::Periodic,
            exchanged: Exchanged {
                passed: vec![0.0; chain.n_contacts()],
                lost: vec![0.0; lossy],
                input: 0.0,
            },
            kept: Vec::new(),
            balance: RunningBalance::default(),
        }
    }

    /// Adds sample i.
    pub(super) fn compare(&mut self, i: usize, energy: &[f64]) {
        if !self.times.contains(&i) {
            return;
        }
        let (kept, now) = (&mut self.kept, &self.exchanged);
        let around = match self.periodic {
            true => now.passed[now.passed.len() - 1],
            false => 0.0,
        };
        kept.clear();
        kept.extend(self.sites.clone().map(|j| {
            let right = now.passed.get(j).copied().unwrap_or(0.0);
            let left = j.checked_sub(1).map_or(around, |left| now.passed[left]);
            let input = if j == self.driven { now.input } else { 0.0 };
            let lost = now.lost.get(j).copied().unwrap_or(0.0);
            energy[j] + right - left - input + lost
        }));
        self.balance.compare(kept);
    }

    /// The largest residual, in units of energy.
    pub(super) fn worst(&self) -> f64 {
        self.balance.worst()
    }
}
