//! Contacts that open or close inside a step: finding them, and correcting the step for them.

use super::super::law::Kernel;
use super::correction::{Correction, Missed, Quintic, pressing_spans};
use super::islands::Island;
use super::pair::{PairStep, Span};
use super::resolved::{Crossing, Resolved};
use super::system::{State, System};
use super::tableau::MOST_STAGES;
use crate::numeric::lanes::{AlignedRow, WIDTH};

/// Openings that change velocities by less than this share of the tolerance are left as they are.
const NEGLIGIBLE: f64 = 1e-3;

/// A contact that opened or closed inside the step.
#[derive(Debug)]
struct Event {
    contact: usize,
    missed: Missed,
    resolved: Resolved,
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
    /// Clears the events, and returns the list of blocks to be examined after the next step.
    pub(super) fn openings(&mut self) -> &mut Vec<usize> {
        self.found.clear();
        &mut self.blocks
    }

    pub(super) fn count(&self) -> u64 {
        self.found.len() as u64
    }

    /// The longest step that resolves all of them, and the longest that may follow.
    pub(super) fn lengths(&self, h: f64) -> [f64; 2] {
        let least = |of: fn(&Resolved) -> f64| {
            let all = self.found.iter().map(|event| of(&event.resolved));
            all.fold(f64::INFINITY, f64::min)
        };
        [h * least(|r| r.longest), h * least(|r| r.onward)]
    }

    /// Whether one of them is a guard of the island.
    pub(super) fn reach_guards(&self, island: &Island) -> bool {
        self.found
            .iter()
            .any(|event| island.is_guard(event.contact))
    }

    /// Finds the contacts whose opening or closing contributes more than a thousandth of the
    /// tolerance, and the impulse that the method missed, along the interpolants of the step.
    pub(super) fn find<K: Kernel>(
        &mut self,
        step: &PairStep<K>,
        correction: &Correction,
        island: &Island,
        path: [&State; 2],
        force: &[AlignedRow],
    ) {
        let PairStep {
            system,
            tableau,
            tolerance,
            span,
            ..
        } = *step;
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
            let negligible = NEGLIGIBLE * tolerance;
            let Some(overlap) = crossing(system, negligible, s, span, path, forces) else {
                continue;
            };
            let Some(spans) = pressing_spans(&overlap) else {
                continue;
            };
            let along = (&overlap, &spans);
            let missed = if energy {
                let paths = [s - 1, s].map(|s| place_path(system, s, span, path, forces));
                let share = [system.flux_share[0][s], system.flux_share[1][s]];
                correction.along(system.kernel, tableau, along, |at| {
                    (share[0] * paths[0].slope_at(at) + share[1] * paths[1].slope_at(at)) / span.h
                })
            } else {
                correction.along(system.kernel, tableau, along, |_| 0.0)
            };
            let crossing = Crossing {
                contact: s,
                h: span.h,
                overlap: &overlap,
                spans: &spans,
            };
            found.push(Event {
                contact: s,
                missed,
                resolved: crossing.resolved(system, &missed, tolerance),
                impulses: if energy {
                    correction.up_to_stages(system.kernel, tableau, along)
                } else {
                    [0.0; MOST_STAGES]
                },
            });
        }
    }

    /// Adds the missed impulses to the end of the step, and removes them from the error estimate.
    pub(super) fn correct<K: Kernel>(
        &self,
        system: &System<K>,
        island: &Island,
        span: Span,
        next: &mut State,
        error: &mut AlignedRow,
    ) {
        for event in &self.found {
            let scale = span.h * system.coefficient[event.contact];
            for (s, sign) in [(event.contact - 1, -1.0), (event.contact, 1.0)] {
                let push = sign * scale * system.mobility[s];
                next.v[s] += push * event.missed.impulse;
                next.x[s] += push * span.h * event.missed.moment;
                error[s] -= push * event.missed.estimate;
                let unseen = system.mobility[s] * event.resolved.error;
                error[s] += unseen.copysign(error[s]);
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
    pub(super) fn pass_missed_work<K>(&self, system: &System<K>, h: f64, passed: &mut AlignedRow) {
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
        v: &mut AlignedRow,
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
    Span { t, h }: Span,
    [state, next]: [&State; 2],
    [force, force_end]: [&AlignedRow; 2],
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
    let bend = |t: f64, force: &[f64]| {
        h * h * (system.acceleration(s - 1, t, force) - system.acceleration(s, t, force))
    };
    let path = [start, closing, bend(t, force)];
    Some(Quintic::hermite(
        path,
        [finish, closing_end, bend(t + h, force_end)],
    ))
}

/// The path of place s over the step.
fn place_path<K: Kernel>(
    system: &System<K>,
    s: usize,
    Span { t, h }: Span,
    [state, next]: [&State; 2],
    [force, force_end]: [&AlignedRow; 2],
) -> Quintic {
    let bend = |t: f64, force: &[f64]| h * h * system.acceleration(s, t, force);
    Quintic::hermite(
        [state.x[s], h * state.v[s], bend(t, force)],
        [next.x[s], h * next.v[s], bend(t + h, force_end)],
    )
}
