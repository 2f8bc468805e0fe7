//! Energies and their rates for the coarse-grained motion at one instant, at every scale.

use std::ops::Range;

use super::contacts::ContactState;
use super::scale::{PlannedFilter, Scales};
use super::sublattices::Filtered;
use crate::chain::{Ends, NodeState};
use crate::numeric::lanes::{Lanes, SimdKernel, widest};

/// Scratch of one thread.
#[derive(Debug, Clone, Default)]
pub(super) struct ScaleScratch {
    /// Force, overlap, velocity; damping, push, displacement, force of the ground, motion of resonators where there are any.
    rows: Filtered,
    /// Elastic force plus damping of each contact, and the forces on each site from outside and of its spring to the ground.
    at_places: [Vec<f64>; 3],
    /// Force of the contact law at the filtered overlaps.
    law_force: Vec<f64>,
    /// Of the contact left of each site, and last of the one right of the last site: energy of the law at the filtered
    /// overlaps, power that the filtered force transmits, power that it takes from the motion and the law does not store.
    at_sites: [Vec<f64>; 3],
}

/// Fluxes, energies and their rates at one scale.
#[derive(Debug, Clone, Default)]
pub(super) struct ScaleTerms {
    /// At the contacts of [`PlannedFilter::contacts`].
    pub(super) flux: Vec<f64>,
    /// At the sites of [`PlannedFilter::sites`].
    pub(super) energy: Vec<f64>,
    pub(super) energy_rate: Vec<f64>,
}

impl Scales<'_> {
    /// Transforms the state of one instant, for [`Scales::terms`] at every scale.
    pub(super) fn load(&self, at: NodeState, state: &ContactState, scratch: &mut ScaleScratch) {
        let [force, push, ground] = &mut scratch.at_places;
        let inside = self.contacts.offset..;
        let [elastic, overlap, damping] =
            [&state.elastic, &state.overlap, &state.damping].map(|row| &row[inside.clone()]);
        let chain = self.contacts.chain;
        let mut kinds = vec![elastic, overlap, at.v];
        if chain.losses.any() {
            force.clear();
            force.extend(elastic.iter().zip(damping).map(|(a, b)| a + b));
            kinds[0] = force;
            kinds.push(damping);
        }
        if let Some(site) = self.contacts.pushed_inside() {
            push.clear();
            push.resize(at.v.len(), 0.0);
            push[site] = state.push;
            kinds.push(push);
        }
        if chain.on_site.any() {
            kinds.push(at.x);
        }
        if let Some(springs) = &chain.on_site.ground {
            ground.clear();
            ground.extend((0..).zip(at.x).map(|(j, x)| springs.spring(j).force(*x)));
            kinds.push(ground);
        }
        if chain.resonators().is_some() {
            kinds.extend(at.resonators);
        }
        self.sublattices.transform(&kinds, &mut scratch.rows);
    }

    /// Filtered overlaps with their first and second time derivatives, at one scale.
    pub(super) fn overlaps(
        &self,
        planned: &PlannedFilter,
        at: NodeState,
        rows: &mut Filtered,
    ) -> [Vec<f64>; 3] {
        let mut state = ContactState::default();
        self.contacts.evaluate(at, &mut state);
        let acceleration = self.contacts.accelerations(at, &state);
        let contacts = self.contacts.offset..self.contacts.each.len();
        let apart = [at.x, at.v, &acceleration].map(|values| -> Vec<f64> {
            let apart = |i: usize| self.contacts.each[i].across(values, 0.0);
            contacts.clone().map(apart).collect()
        });
        let [a, b, c] = &apart;
        self.sublattices.transform(&[a, b, c], rows);
        let mut filtered = self.sublattices.filter(&planned.gains, rows);
        [(); 3].map(|()| filtered.next().unwrap_or_default().to_vec())
    }

    /// Flux, site energies and the rates of change of the energies, at one scale.
    pub(super) fn terms(
        &self,
        planned: &PlannedFilter,
        scratch: &mut ScaleScratch,
        terms: &mut ScaleTerms,
    ) {
        let chain = self.contacts.chain;
        let (n, m) = (chain.n_sites(), chain.n_contacts());
        let (law_force, at_sites) = (&mut scratch.law_force, &mut scratch.at_sites);
        let mut filtered = self.sublattices.filter(&planned.gains, &mut scratch.rows);
        let on_site = &chain.on_site;
        // In the order of `load`.
        let mut row = |is_there: bool| match is_there {
            true => filtered.next().unwrap_or_default(),
            false => &[],
        };
        let (force, overlap, speed) = (row(true), row(true), row(true));
        let damping = row(chain.losses.any());
        let push = row(self.contacts.pushed_inside().is_some());
        let x = row(on_site.any());
        let ground = row(on_site.ground.is_some());
        let resonators = [(); 2].map(|()| row(on_site.resonators.is_some()));
        law_force.resize(m, 0.0);
        for row in at_sites.iter_mut() {
            row.resize(m + 1, 0.0);
        }
        let [energy, passes, taken] = at_sites;
        let inside = self.contacts.offset..self.contacts.each.len();
        let out = [&mut law_force[..], &mut energy[1..]];
        self.contacts
            .forces_and_energies(inside, &overlap[..m], out);
        if chain.ends == Ends::Periodic {
            let (last, first) = (speed[n - 1], speed[0]);
            let taken_around = (force[n - 1] - law_force[n - 1]) * (last - first);
            for at in [0, n] {
                energy[at] = energy[n];
                passes[at] = 0.5 * force[n - 1] * (last + first);
                taken[at] = taken_around;
            }
        }
        let (flux, energies, energy_rate) =
            (&mut terms.flux, &mut terms.energy, &mut terms.energy_rate);
        let (contacts, sites) = (planned.contacts.clone(), planned.sites.clone());
        for row in [&mut *energies, energy_rate] {
            row.resize(sites.len(), 0.0);
        }
        widest(Powers {
            mass: &chain.mass,
            speed,
            forces: [force, &law_force[..]],
            drag: chain.losses.drag,
            inner: m.min(n - 1),
            sites: sites.clone(),
            at_sites,
            energy: energies,
            rate: energy_rate,
        });
        let right_of = |j: usize| if j + 1 < n { j + 1 } else { 0 };
        flux.clear();
        flux.extend_from_slice(&at_sites[2][1..][contacts.clone()]);
        if !damping.is_empty() {
            // The power of the filtered damper is heat, not flux.
            for (flux, j) in flux.iter_mut().zip(contacts) {
                *flux -= damping[j] * (speed[j] - speed[right_of(j)]);
            }
        }
        let out = energies.iter_mut().zip(energy_rate);
        for (j, (energy, rate)) in sites.zip(out) {
            if let Some(push) = push.get(j) {
                *rate += push * speed[j];
            }
            if let Some(springs) = &on_site.ground {
                *energy += springs.spring(j).energy(x[j]);
                *rate -= (ground[j] - springs.spring(j).force(x[j])) * speed[j];
            }
            if let Some(all) = &on_site.resonators {
                let [y, w] = resonators;
                *energy += all.spring_energy(j, y[j] - x[j]) + all.kinetic_energy(j, w[j]);
                *rate -= all.loss(j, w[j] - speed[j]);
            }
        }
        if let Some(springs) = &on_site.ground {
            // Half of what the spring of a site takes counts at either contact.
            let taken = |j: usize| (ground[j] - springs.spring(j).force(x[j])) * speed[j];
            for (flux, j) in flux.iter_mut().zip(planned.contacts.clone()) {
                *flux += 0.5 * (taken(j) + taken(right_of(j)));
            }
        }
    }
}

/// `bar F_j (bar v_j + bar v_{j+1}) / 2` and `(bar F_j - F_j(bar delta_j)) (bar v_j - bar v_{j+1})` of the contacts between
/// neighbours; from these, energies of sites and their rates of change.
struct Powers<'a> {
    mass: &'a [f64],
    speed: &'a [f64],
    /// The filtered force, and that of the law at the filtered overlaps.
    forces: [&'a [f64]; 2],
    drag: f64,
    /// Contacts between neighbours.
    inner: usize,
    sites: Range<usize>,
    /// As in [`ScaleScratch`].
    at_sites: &'a mut [Vec<f64>; 3],
    energy: &'a mut [f64],
    rate: &'a mut [f64],
}

impl SimdKernel for Powers<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let [held, passes, taken] = self.at_sites;
        let forces = self.forces[0].iter().zip(self.forces[1]);
        let contacts = self.speed.windows(2).zip(forces);
        let out = passes[1..=self.inner]
            .iter_mut()
            .zip(&mut taken[1..=self.inner]);
        for ((passes, taken), (speed, (force, law_force))) in out.zip(contacts) {
            *passes = 0.5 * force * (speed[0] + speed[1]);
            *taken = (force - law_force) * (speed[0] - speed[1]);
        }
        let beside = self.sites.start..self.sites.end + 1;
        let [held, passes, taken] = [held, passes, taken].map(|row| row[beside.clone()].windows(2));
        let masses = self.mass[self.sites.clone()].iter();
        let sites = masses.zip(&self.speed[self.sites]);
        let out = self.energy.iter_mut().zip(self.rate);
        for ((energy, rate), ((mass, speed), (held, (passes, taken)))) in
            out.zip(sites.zip(held.zip(passes.zip(taken))))
        {
            let square = speed * speed;
            *energy = 0.5 * (mass * square + held[0] + held[1]);
            // Flux and contact losses together: the filtered force less that of the law.
            let taken = 0.5 * (taken[0] + taken[1]);
            *rate = passes[0] - passes[1] - taken - self.drag * square;
        }
    }
}
