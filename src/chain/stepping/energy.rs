//! Energy that contacts pass on and sites lose, followed inside a step.

use super::super::law::Kernel;
use super::islands::Island;
use super::pair::{Span, StepScratch, push};
use super::system::{FIRST_SITE, State, System, resonator_place};
use super::tableau::Tableau;
use crate::numeric::lanes::{AlignedRow, Lanes, SimdKernel, widest};

/// Adds the energies passed on by contacts and lost, by the quadrature of the velocities.
pub(super) fn pass_on<K: Kernel>(
    system: &System<K>,
    tableau: &Tableau,
    island: &Island,
    Span { t, h }: Span,
    state: &State,
    next: &mut State,
    scratch: &mut StepScratch,
) {
    let blocks = island.blocks.clone();
    let lossy = system.is_lossy();
    let StepScratch {
        force,
        damping,
        pull,
        x,
        v,
        events,
        ..
    } = scratch;
    next.passed.0[blocks.clone()].copy_from_slice(&state.passed.0[blocks.clone()]);
    events.pass_missed_work(system, h, &mut next.passed);
    if lossy {
        next.lost.0[blocks.clone()].copy_from_slice(&state.lost.0[blocks]);
    }
    let driven = system
        .driven()
        .filter(|place| island.places().contains(place));
    if driven.is_some() {
        next.input = state.input + events.missed_input(system, t + h, h);
    }
    for &(stage, weight) in tableau.bp.iter().filter(|(_, weight)| *weight != 0.0) {
        let weights = &tableau.velocity[stage];
        push(
            system,
            island,
            &state.v,
            None,
            (weights, h),
            [force, pull],
            v,
        );
        if system.has_placed_in(island) {
            system.place(t + tableau.c[stage] * h, x, v);
        }
        events.correct_velocities(system, h, stage, v);
        let weight = weight * h;
        widest(PassOn {
            island,
            weight,
            share: &system.flux_share,
            force: &force[stage],
            v,
            passed: &mut next.passed,
        });
        if let Some(place) = driven {
            let at = t + tableau.c[stage] * h;
            let outer = system.outer_force(place, at, &force[stage], pull[stage][place]);
            next.input += weight * outer * v[place];
        }
        if lossy {
            lose_energy(system, island, weight, [&damping[stage], v], &mut next.lost);
        }
    }
}

/// Adds what dampers and drag took at a stage.
fn lose_energy<K: Kernel>(
    system: &System<K>,
    island: &Island,
    weight: f64,
    [damping, v]: [&AlignedRow; 2],
    lost: &mut AlignedRow,
) {
    let places = island.places();
    for s in places.start + 1..places.end.min(system.contacts.end) {
        let heat = weight * damping[s] * (v[s - 1] - v[s]);
        let [left, right] = system.loss_share(s);
        lost[s - 1] += left * heat;
        lost[s] += right * heat;
    }
    for s in places.start..places.end.min(FIRST_SITE + system.sites) {
        if system.is_site(s) {
            lost[s] += weight * system.losses.drag * v[s] * v[s];
        }
    }
    if let Some(resonators) = &system.resonators {
        for j in 0..system.sites {
            let (s, own) = (FIRST_SITE + j, resonator_place(system.sites, j));
            lost[s] += weight * resonators.loss(j, v[own] - v[s]);
        }
    }
}

/// `passed_s += weight F_s (left_s v_{s-1} + right_s v_s)`.
pub(super) struct PassOn<'a> {
    pub(super) island: &'a Island,
    pub(super) weight: f64,
    pub(super) share: &'a [AlignedRow; 2],
    pub(super) force: &'a AlignedRow,
    pub(super) v: &'a AlignedRow,
    pub(super) passed: &'a mut AlignedRow,
}

impl SimdKernel for PassOn<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let weight = L::splat(self.weight);
        let mut before = L::splat(0.0);
        for b in self.island.blocks.clone() {
            let speed = L::load(&self.v.0[b]);
            let left = L::load(&self.share[0].0[b]) * speed.take_left(before);
            let right = L::load(&self.share[1].0[b]) * speed;
            let flux = L::load(&self.force.0[b]) * (left + right);
            let passed = &mut self.passed.0[b];
            (L::load(passed) + weight * flux).store(passed);
            before = speed;
        }
    }
}
