//! Energy site by site: energies, fluxes, losses, and whether they balance.
//!
//! `de_j/dt = J_{j-1} - J_j - D_j` with half of each contact's energy and losses at the sites beside
//! it, all of a wall's contact at the site that touches it, and
//! `J_j = (F_j + Fd_j) (v_j + v_{j+1}) / 2`.

use std::ops::Range;

use super::balance::worst_of;
use super::contacts::{ContactState, Contacts};
use super::motion::ChainState;
use crate::chain::Ends;

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
    pub(super) fn evaluate(&mut self, contacts: &Contacts, at: ChainState, state: &ContactState) {
        let chain = contacts.chain();
        let (m, offset) = (chain.n_contacts(), contacts.offset);
        let (energy, loss, flux) = (&mut self.energy, &mut self.loss, &mut self.flux);
        energy.clear();
        let kinetic = chain.mass.iter().zip(at.v);
        energy.extend(kinetic.map(|(m, v)| 0.5 * m * v * v));
        self.kinetic = crate::numeric::sum(energy);
        self.contact = crate::numeric::sum(&state.energy);
        if let Some(ground) = &chain.on_site.ground {
            let held = at.x.iter().enumerate();
            let held: Vec<f64> = held.map(|(j, x)| ground.energy(j, *x)).collect();
            self.contact += crate::numeric::sum(&held);
            energy
                .iter_mut()
                .zip(held)
                .for_each(|(energy, held)| *energy += held);
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
        // Contacts of neighbours first; then those at the ends.
        let inner = m.min(at.v.len() - 1);
        let joined = offset..offset + inner;
        let [elastic, damping, closing, held] = [
            &state.elastic,
            &state.damping,
            &state.closing,
            &state.energy,
        ]
        .map(|row| row[joined.clone()].iter());
        let forces = elastic.zip(damping.clone());
        for ((flux, v), (elastic, damping)) in flux.iter_mut().zip(at.v.windows(2)).zip(forces) {
            *flux = 0.5 * (elastic + damping) * (v[0] + v[1]);
        }
        share(held.copied(), energy);
        if chain.losses.any() {
            share(damping.zip(closing).map(|(d, closing)| d * closing), loss);
        }
        for i in (0..offset).chain(inner + offset..contacts.len()) {
            let heat = state.damping[i] * state.closing[i];
            let force = state.elastic[i] + state.damping[i];
            match contacts.sites(i) {
                [Some(left), Some(right)] => {
                    for site in [left, right] {
                        self.energy[site] += 0.5 * state.energy[i];
                        self.loss[site] += 0.5 * heat;
                    }
                    self.flux[i - offset] = 0.5 * force * (at.v[left] + at.v[right]);
                }
                [left, right] => {
                    if let Some(site) = left.or(right) {
                        self.energy[site] += state.energy[i];
                        self.loss[site] += heat;
                    }
                    if left.is_none() {
                        self.input += force * state.wall_velocity;
                        self.wall_heat = state.damping[i] * state.wall_velocity;
                    }
                }
            }
        }
        self.input += state.push * at.v.get(contacts.pushed()).copied().unwrap_or(0.0);
    }
}

/// Gives half of what each contact between neighbours has to either site.
fn share(contacts: impl Iterator<Item = f64> + Clone, sites: &mut [f64]) {
    for (right, value) in sites[1..].iter_mut().zip(contacts.clone()) {
        *right += 0.5 * value;
    }
    for (left, value) in sites.iter_mut().zip(contacts) {
        *left += 0.5 * value;
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

/// Follows what each site gained against what came, went and was lost, over a window.
#[derive(Debug)]
pub(super) struct Balance {
    times: Range<usize>,
    sites: Range<usize>,
    periodic: bool,
    /// The site inside the chain that a force drives.
    pushed: Option<usize>,
    start: Option<(Vec<f64>, Exchanged)>,
    came: Vec<f64>,
    off: Vec<f64>,
    worst: f64,
}

impl Balance {
    pub(super) fn new(times: Range<usize>, sites: Range<usize>, contacts: &Contacts) -> Balance {
        Balance {
            times,
            sites,
            pushed: contacts.pushed_inside(),
            periodic: contacts.chain().ends == Ends::Periodic,
            start: None,
            came: Vec::new(),
            off: Vec::new(),
            worst: 0.0,
        }
    }

    /// Adds sample i.
    pub(super) fn follow(&mut self, i: usize, energy: &[f64], now: &Exchanged) {
        if !self.times.contains(&i) {
            return;
        }
        let Some((first, then)) = &self.start else {
            self.start = Some((energy.to_vec(), now.clone()));
            return;
        };
        let passed = |j: usize| now.passed[j] - then.passed[j];
        let (sites, contacts) = (self.sites.clone(), now.passed.len());
        // What came to each site from the left, and last what left behind them all.
        let came = &mut self.came;
        came.clear();
        came.push(match sites.start.checked_sub(1) {
            Some(left) => passed(left),
            None if self.periodic => passed(contacts - 1),
            None if self.pushed.is_none() => now.input - then.input,
            None => 0.0,
        });
        came.extend((sites.start..sites.end.min(contacts)).map(passed));
        came.resize(sites.len() + 1, 0.0);
        let changes = energy[sites.clone()].iter().zip(&first[sites.clone()]);
        let off = &mut self.off;
        off.clear();
        off.extend(
            changes
                .zip(came.windows(2))
                .map(|((now, first), came)| now - first - came[0] + came[1]),
        );
        if let Some(site) = self.pushed.filter(|site| sites.contains(site)) {
            off[site - sites.start] -= now.input - then.input;
        }
        if !now.lost.is_empty() {
            let lost = now.lost[sites.clone()].iter().zip(&then.lost[sites]);
            for (off, (now, then)) in off.iter_mut().zip(lost) {
                *off += now - then;
            }
        }
        off.iter_mut().for_each(|off| *off = off.abs());
        self.worst = worst_of(self.worst, off);
    }

    /// The largest residual, in units of energy.
    pub(super) fn worst(&self) -> f64 {
        self.worst
    }
}
