//! Energy site by site: energies, fluxes, losses, and whether they balance.
//!
//! `de_j/dt = J_{j-1} - J_j - D_j` with half of each contact's energy and losses at the sites beside
//! it, all of a wall's contact at the site that touches it, and
//! `J_j = (F_j + Fd_j) (v_j + v_{j+1}) / 2`.

use std::ops::Range;

use super::contacts::{ContactState, Contacts};
use super::motion::Instant;

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
    pub(super) contact: f64,
}

impl SiteTerms {
    pub(super) fn of(contacts: &Contacts, at: Instant, state: &ContactState) -> SiteTerms {
        let chain = contacts.chain();
        let (m, offset) = (chain.n_contacts(), contacts.offset);
        let kinetic = chain.mass.iter().zip(at.v).map(|(m, v)| 0.5 * m * v * v);
        let mut terms = SiteTerms {
            energy: kinetic.collect(),
            loss: at.v.iter().map(|v| chain.losses.drag * v * v).collect(),
            flux: vec![0.0; m],
            input: 0.0,
            wall_heat: 0.0,
            kinetic: 0.0,
            contact: crate::sum::sum(&state.energy),
        };
        terms.kinetic = crate::sum::sum(&terms.energy);
        let lossy = chain.losses.any();
        let inner = m.min(at.v.len() - 1);
        let sites = at.v.windows(2).enumerate();
        for (j, pair) in sites.take(inner) {
            let i = j + offset;
            let half = 0.5 * state.energy[i];
            terms.energy[j] += half;
            terms.energy[j + 1] += half;
            let force = state.elastic[i] + state.damping[i];
            terms.flux[j] = 0.5 * force * (pair[0] + pair[1]);
            if lossy {
                let half = 0.5 * state.damping[i] * state.closing[i];
                terms.loss[j] += half;
                terms.loss[j + 1] += half;
            }
        }
        for i in (0..offset).chain(inner + offset..contacts.len()) {
            let heat = state.damping[i] * state.closing[i];
            let force = state.elastic[i] + state.damping[i];
            match contacts.sites(i) {
                [Some(left), Some(right)] => {
                    for site in [left, right] {
                        terms.energy[site] += 0.5 * state.energy[i];
                        terms.loss[site] += 0.5 * heat;
                    }
                    terms.flux[i - offset] = 0.5 * force * (at.v[left] + at.v[right]);
                }
                [left, right] => {
                    if let Some(site) = left.or(right) {
                        terms.energy[site] += state.energy[i];
                        terms.loss[site] += heat;
                    }
                    if left.is_none() {
                        terms.input += force * state.wall_velocity;
                        terms.wall_heat = state.damping[i] * state.wall_velocity;
                    }
                }
            }
        }
        terms.input += state.push * at.v.first().copied().unwrap_or(0.0);
        terms
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
    start: Option<(Vec<f64>, Exchanged)>,
    worst: f64,
}

impl Balance {
    pub(super) fn new(times: Range<usize>, sites: Range<usize>, periodic: bool) -> Balance {
        Balance {
            times,
            sites,
            periodic,
            start: None,
            worst: 0.0,
        }
    }

    /// Takes in sample i.
    pub(super) fn follow(&mut self, i: usize, energy: &[f64], now: &Exchanged) {
        if !self.times.contains(&i) {
            return;
        }
        let Some((first, then)) = &self.start else {
            self.start = Some((energy.to_vec(), now.clone()));
            return;
        };
        let passed = |j: usize| now.passed[j] - then.passed[j];
        let mut came = match self.sites.start.checked_sub(1) {
            Some(left) => passed(left),
            None if self.periodic => passed(now.passed.len() - 1),
            None => now.input - then.input,
        };
        let mut worst = self.worst;
        for j in self.sites.clone() {
            let went = if j < now.passed.len() { passed(j) } else { 0.0 };
            let lost = now.lost.get(j).map_or(0.0, |lost| lost - then.lost[j]);
            let off = (energy[j] - first[j] - came + went + lost).abs();
            // What is not a number is worse than any residual, and stays.
            worst = if worst >= off || worst.is_nan() {
                worst
            } else {
                off
            };
            came = went;
        }
        self.worst = worst;
    }

    /// The largest residual, in units of energy.
    pub(super) fn worst(&self) -> f64 {
        self.worst
    }
}
