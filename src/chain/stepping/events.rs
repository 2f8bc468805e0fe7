//! Contacts that open or close inside a step: finding them, and correcting the step for them.

use super::super::lanes::{Row, WIDTH};
use super::super::law::Kernel;
use super::correction::{Correction, Missed, Quintic};
use super::islands::Island;
use super::pair::Span;
use super::system::{State, System};
use super::tableau::{MOST_STAGES, Tableau};

/// A contact that opened or closed inside the step.
#[derive(Debug)]
struct Event {
    contact: usize,
    missed: Missed,
    /// Impulse up to each stage that the stage's velocity missed, in units of the step and of the
    /// coefficient; zeros where energies are not followed.
    impulses: [f64; MOST_STAGES],
}

/// Scratch for a step's events.
#[derive(Debug, Default)]
pub(super) struct Events {
    found: Vec<Event>,
    blocks: Vec<usize>,
}

impl Events {
    /// Forgets those found, for the blocks of a next step to look at.
    pub(super) fn openings(&mut self) -> &mut Vec<usize> {
        self.found.clear();
        &mut self.blocks
    }

    pub(super) fn count(&self) -> u64 {
        self.found.len() as u64
    }

    /// Finds the contacts whose opening or closing weighs more than `negligible`, and what the
    /// method missed along the interpolants of the step as it stands.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn find<K: Kernel>(
        &mut self,
        system: &System<K>,
        (tableau, correction): (&Tableau, &Correction),
        negligible: f64,
        island: &Island,
        span: Span,
        path: [&State; 2],
        force: &[Row],
    ) {
        let Events { found, blocks } = self;
        let [state, _] = path;
        if system.has_moving_ends() && island.blocks.start == 0 {
            // What the ghosts do became known later.
            blocks.extend([0, system.sites / WIDTH, (system.sites + 1) / WIDTH]);
            blocks.sort_unstable();
            blocks.dedup();
        }
        let energy = !state.passed.is_empty();
        let forces = [&force[0], &force[tableau.stages() - 1]];
        let first = island.places().start + 1;
        let contacts = blocks.iter().flat_map(|b| WIDTH * b..WIDTH * (b + 1));
        for s in contacts.skip_while(|&s| s < first) {
            let Some(overlap) = crossing(system, negligible, s, span.h, path, forces) else {
                continue;
            };
            let missed = if energy {
                let paths = [s - 1, s].map(|s| place_path(system, s, span.h, path, forces));
                let share = [system.flux_share[0][s], system.flux_share[1][s]];
                correction.along(system.kernel, tableau, &overlap, |at| {
                    (share[0] * paths[0].slope_at(at) + share[1] * paths[1].slope_at(at)) / span.h
                })
            } else {
                correction.along(system.kernel, tableau, &overlap, |_| 0.0)
            };
            let Some(missed) = missed else { continue };
            found.push(Event {
                contact: s,
                missed,
                impulses: if energy {
                    correction.up_to_stages(system.kernel, tableau, &overlap)
                } else {
                    [0.0; MOST_STAGES]
                },
            });
        }
    }

    /// Adds what the method missed to the end of the step, and takes it out of the error estimate.
    pub(super) fn correct<K: Kernel>(
        &self,
        system: &System<K>,
        island: &Island,
        span: Span,
        next: &mut State,
        error: &mut Row,
    ) {
        for event in &self.found {
            let scale = span.h * system.coefficient[event.contact];
            for (s, sign) in [(event.contact - 1, -1.0), (event.contact, 1.0)] {
                let push = sign * scale * system.mobility[s];
                next.v[s] += push * event.missed.impulse;
                next.x[s] += push * span.h * event.missed.moment;
                error[s] -= push * event.missed.estimate;
            }
        }
        let end = span.t + span.h;
        system.place_ghosts(end, &mut next.x, &mut next.v);
        let first = (island.places().start + 1).max(system.contacts.start);
        let last = island.places().end.min(system.contacts.end);
        for event in &self.found {
            for s in (event.contact - 1).max(first)..(event.contact + 2).min(last) {
                next.force[s] = system.force(s, end, &next.x, &next.v).0;
            }
        }
        if system.periodic {
            next.force[1] = next.force[system.sites + 1];
        }
    }

    /// Adds the work that the quadrature missed.
    pub(super) fn pass_missed_work<K>(&self, system: &System<K>, h: f64, passed: &mut Row) {
        for event in &self.found {
            passed[event.contact] += h * system.coefficient[event.contact] * event.missed.work;
        }
    }

    /// Adds what the velocities at a stage missed.
    pub(super) fn correct_velocities<K>(
        &self,
        system: &System<K>,
        h: f64,
        stage: usize,
        v: &mut Row,
    ) {
        for event in &self.found {
            let missed = h * system.coefficient[event.contact] * event.impulses[stage];
            v[event.contact - 1] -= missed * system.mobility[event.contact - 1];
            v[event.contact] += missed * system.mobility[event.contact];
        }
    }
}

/// The overlap of contact s over the step, if it opens or closes in a way that matters.
#[inline]
fn crossing<K: Kernel>(
    system: &System<K>,
    negligible: f64,
    s: usize,
    h: f64,
    [state, next]: [&State; 2],
    [force, force_end]: [&Row; 2],
) -> Option<Quintic> {
    let (start, finish) = (system.overlap(s, &state.x), system.overlap(s, &next.x));
    let (closing, closing_end) = (
        h * (state.v[s - 1] - state.v[s]),
        h * (next.v[s - 1] - next.v[s]),
    );
    let crosses = (start > 0.0) != (finish > 0.0);
    let grazes = closing * closing_end < 0.0
        && (start > 0.0) == (closing < 0.0)
        && start.abs().min(finish.abs()) < closing.abs() + closing_end.abs();
    if !crosses && !grazes || system.coefficient[s] == 0.0 {
        return None;
    }
    if !grazes {
        let mobility = system.mobility[s - 1].max(system.mobility[s]);
        let force = system.coefficient[s] * system.kernel.power(start.max(finish));
        if h * force * mobility <= negligible {
            return None;
        }
    }
    let bend =
        |force: &[f64]| h * h * (system.acceleration(s - 1, force) - system.acceleration(s, force));
    let path = [start, closing, bend(force)];
    Some(Quintic::hermite(
        path,
        [finish, closing_end, bend(force_end)],
    ))
}

/// The path of place s over the step.
fn place_path<K: Kernel>(
    system: &System<K>,
    s: usize,
    h: f64,
    [state, next]: [&State; 2],
    [force, force_end]: [&Row; 2],
) -> Quintic {
    let bend = |force: &[f64]| h * h * system.acceleration(s, force);
    Quintic::hermite(
        [state.x[s], h * state.v[s], bend(force)],
        [next.x[s], h * next.v[s], bend(force_end)],
    )
}
