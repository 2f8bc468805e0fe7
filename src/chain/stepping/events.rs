//! Contacts that open or close inside a step: finding them, and correcting the step for them.

use super::super::drive::Drive;
use super::super::law::Kernel;
use super::correction::{
    Missed, NEAR, Pressing, Quintic, opening_nearby, pressing_spans, stage_forces,
};
use super::islands::Island;
use super::pair::{PairStep, Span};
use super::resolved::{Crossing, Resolved};
use super::system::{State, System};
use super::tableau::{MOST_STAGES, Tableau, Weights};
use crate::numeric::lanes::{AlignedRow, LaneBlock, Lanes, SimdKernel, WIDTH, widest};

/// Openings that change velocities by less than this share of the tolerance are left as they are.
const NEGLIGIBLE: f64 = 1e-3;

/// Openings outside the step are corrected where they matter to this share of the tolerance.
const FELT: f64 = 0.1;

/// A contact that opened or closed inside the step.
#[derive(Debug)]
struct Event {
    contact: usize,
    /// Rather than shortly before or after it.
    inside: bool,
    missed: Missed,
    resolved: Resolved,
    /// Impulse up to each stage that the stage's velocity missed, in units of the step and of the
    /// coefficient.
    impulses: [f64; MOST_STAGES],
    /// By what the displacements that the stages missed change their forces, in the contact before,
    /// this one, and the one behind.
    changes: [[f64; MOST_STAGES]; 3],
}

impl Event {
    /// Adds what the changed forces do to the end of the step and to its error estimate.
    fn change_stages<K: Kernel>(
        &self,
        step: &PairStep<K>,
        next: &mut State,
        force: &mut [AlignedRow],
        error: &mut AlignedRow,
    ) {
        let (system, tableau, h) = (step.system, step.tableau, step.span.h);
        for (change, k) in self.changes.iter().zip(self.contact - 1..) {
            if change.iter().all(|change| *change == 0.0) {
                continue;
            }
            let sum = |weights: &Weights| -> f64 {
                weights.iter().map(|&(stage, w)| w * change[stage]).sum()
            };
            let (impulse, moment) = (h * sum(&tableau.bp), h * h * sum(&tableau.b));
            let estimate = h * sum(&tableau.error);
            for (s, sign) in [(k - 1, -1.0), (k, 1.0)] {
                let push = sign * system.mobility[s];
                next.v[s] += push * impulse;
                next.x[s] += push * moment;
                error[s] += push * estimate;
            }
            for (row, change) in force.iter_mut().zip(change) {
                row[k] += change;
            }
        }
    }
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

    pub(super) fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Contacts that open or close inside the step.
    pub(super) fn count(&self) -> u64 {
        self.found.iter().filter(|event| event.inside).count() as u64
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
        island: &Island,
        states: [&State; 2],
        error: &AlignedRow,
    ) {
        let (system, tableau) = (step.system, step.tableau);
        let (tolerance, span) = (step.tolerance, step.span);
        let Events { found, blocks } = self;
        let ends = StepEnds {
            system,
            drive: system.drive.as_ref(),
            span,
            states,
        };
        if system.has_placed_in(island) {
            // What the ghosts do became known later.
            blocks.extend([0, system.sites / WIDTH, (system.sites + 1) / WIDTH]);
            blocks.sort_unstable();
            blocks.dedup();
        }
        let energy = !states[0].passed.is_empty();
        let first = island.places().start + 1;
        let contacts = blocks.iter().flat_map(|b| WIDTH * b..WIDTH * (b + 1));
        for s in contacts.skip_while(|&s| s < first) {
            let negligible = NEGLIGIBLE * tolerance;
            let opens = system.opens[s];
            let Some(correction) = step.corrections.iter().find(|c| c.power == opens) else {
                continue;
            };
            let matters = |crosses: Crosses| {
                let mobility = [s - 1, s].map(|s| system.mobility[s]);
                let felt = || {
                    let unit = system.kernel.onset(s, crosses.most, 1.0);
                    let force = system.coefficient[s] * unit;
                    span.h * force * mobility[0].max(mobility[1]) > negligible
                };
                crosses.grazes || (crosses.passes || crosses.nears) && felt()
            };
            let Some(overlap) = ends.crossing(s, matters) else {
                continue;
            };
            let nearby = || {
                // The root of the overlap in tangent damping, which is not corrected, needs the short
                // steps beside an opening.
                let felt = error[s - 1].abs().max(error[s].abs()) >= FELT * tolerance;
                if !felt || system.losses.tangent > 0.0 {
                    return None;
                }
                let opening = opening_nearby(&overlap)?;
                Some([Some(Pressing::Near { opening }), None])
            };
            let Some(spans) = pressing_spans(&overlap).or_else(nearby) else {
                continue;
            };
            let along = (&overlap, &spans);
            let contact = (&system.kernel, s);
            let at_stages = stage_forces(contact, tableau, &overlap);
            let missed = if energy {
                let paths = [s - 1, s].map(|s| ends.place(s));
                let share = [system.flux_share[0][s], system.flux_share[1][s]];
                correction.along(contact, tableau, along, &at_stages, |at| {
                    (share[0] * paths[0].slope_at(at) + share[1] * paths[1].slope_at(at)) / span.h
                })
            } else {
                correction.along(contact, tableau, along, &at_stages, |_| 0.0)
            };
            let crossing = Crossing {
                contact: s,
                h: span.h,
                overlap: &overlap,
                spans: &spans,
            };
            let stages = correction.up_to_stages(contact, tableau, along, &at_stages);
            found.push(Event {
                contact: s,
                inside: !matches!(spans[0], Some(Pressing::Near { .. })),
                missed,
                changes: changes(tableau, &ends, s, &overlap, &stages.displacement),
                resolved: crossing.resolved(system, &missed, tolerance),
                impulses: stages.impulse,
            });
        }
    }

    /// Adds the missed impulses to the end of the step, and removes them from the error estimate.
    pub(super) fn correct<K: Kernel>(
        &self,
        step: &PairStep<K>,
        island: &Island,
        next: &mut State,
        force: &mut [AlignedRow],
        error: &mut AlignedRow,
    ) {
        let PairStep { system, span, .. } = *step;
        for event in &self.found {
            event.change_stages(step, next, force, error);
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
        system.place(end, &mut next.x, &mut next.v);
        let first = (island.places().start + 1).max(system.contacts.start);
        let last = island.places().end.min(system.contacts.end);
        for event in &self.found {
            let beside = event.contact.saturating_sub(2)..event.contact + 3;
            for s in beside.start.max(first)..beside.end.min(last) {
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

    /// Work that the quadrature missed, by what holds a body to its motion against contacts that push it: with its
    /// velocity linear in time, which is as good as the small impulses need.
    pub(super) fn missed_input<K: Kernel>(&self, system: &System<K>, end: f64, h: f64) -> f64 {
        let Some((place, wave)) = system.moved() else {
            return 0.0;
        };
        let (speed, slowing) = (wave.rate_at(end), h * wave.acceleration_at(end));
        let of = |event: &Event| {
            let sign = match event.contact {
                s if s == place => -1.0,
                s if s == place + 1 => 1.0,
                _ => return 0.0,
            };
            let missed = &event.missed;
            let work = speed * missed.impulse - slowing * missed.moment;
            sign * h * system.coefficient[event.contact] * work
        };
        self.found.iter().map(of).sum()
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

/// What a step leads to.
pub(super) struct StepEnds<'a, K> {
    pub(super) system: &'a System<K>,
    pub(super) drive: Option<&'a Drive>,
    pub(super) span: Span,
    pub(super) states: [&'a State; 2],
}

impl<K: Kernel> StepEnds<'_, K> {
    /// Displacement, velocity and acceleration of a place at both ends.
    fn motions(&self, s: usize) -> [[f64; 3]; 2] {
        let Span { t, h } = self.span;
        let at = |end: usize, t: f64| self.system.motion(self.drive, s, t, self.states[end]);
        [at(0, t), at(1, t + h)]
    }

    fn along(&self, motions: [[f64; 3]; 2]) -> Quintic {
        let h = self.span.h;
        let [start, end] = motions.map(|[x, v, a]| [x, h * v, h * h * a]);
        Quintic::hermite(start, end)
    }

    /// The path of a place.
    fn place(&self, s: usize) -> Quintic {
        self.along(self.motions(s))
    }

    /// The overlap of a contact.
    fn overlap(&self, s: usize) -> Quintic {
        let (left, right, d0) = (
            self.motions(s - 1),
            self.motions(s),
            self.system.static_overlap[s],
        );
        self.along([0, 1].map(|end| {
            let [x, v, a] = std::array::from_fn(|i| left[end][i] - right[end][i]);
            [d0 + x, v, a]
        }))
    }

    /// The overlap of contact s, if it may open or close, or is near it, and `matters` at the larger overlap of both ends, or at
    /// the way it goes if it only grazes.
    #[inline]
    pub(super) fn crossing(&self, s: usize, matters: impl Fn(Crosses) -> bool) -> Option<Quintic> {
        let (system, h) = (self.system, self.span.h);
        let [[start, closing], [finish, closing_end]] = self
            .states
            .map(|State { x, v, .. }| [system.overlap(s, x), h * (v[s - 1] - v[s])]);
        let way = closing.abs() + closing_end.abs();
        let crosses = Crosses {
            most: start.max(finish),
            way,
            passes: (start > 0.0) != (finish > 0.0),
            grazes: closing * closing_end < 0.0
                && (start > 0.0) == (closing < 0.0)
                && start.abs().min(finish.abs()) < way,
            nears: start > 0.0
                && finish > 0.0
                && (start < NEAR * closing || finish < -NEAR * closing_end),
        };
        (system.coefficient[s] != 0.0 && matters(crosses)).then(|| self.overlap(s))
    }
}

/// How a contact may open or close in a step.
pub(super) struct Crosses {
    /// The larger overlap of both ends, and the way of the overlap.
    pub(super) most: f64,
    pub(super) way: f64,
    pub(super) passes: bool,
    pub(super) grazes: bool,
    /// It presses throughout, soon after it closed or before it opens.
    nears: bool,
}

/// By what the displacements that the stages missed change the forces there.
fn changes<K: Kernel>(
    tableau: &Tableau,
    ends: &StepEnds<K>,
    e: usize,
    overlap: &Quintic,
    missed: &[f64; MOST_STAGES],
) -> [[f64; MOST_STAGES]; 3] {
    let StepEnds { system, span, .. } = *ends;
    let mut all = [[0.0; MOST_STAGES]; 3];
    let [left, right] = [e - 1, e].map(|s| system.mobility[s]);
    let scale = span.h * span.h * system.coefficient[e];
    for (i, (part, k)) in [left, -left - right, right]
        .into_iter()
        .zip(e - 1..e + 2)
        .enumerate()
    {
        let c = system.coefficient.get(k).copied().unwrap_or(0.0);
        if c == 0.0 || part == 0.0 {
            continue;
        }
        let stiffness = widest(Stiffness {
            contact: (&system.kernel, k),
            coefficient: c,
            static_overlap: system.static_overlap[k],
            overlap: &if k == e { *overlap } else { ends.overlap(k) },
            nodes: &tableau.nodes,
        });
        for (&(stage, _), stiffness) in tableau.bp.iter().zip(stiffness.0) {
            all[i][stage] = stiffness * part * scale * missed[stage];
        }
    }
    all
}

/// Of a contact along its overlap, a node a lane.
struct Stiffness<'a, K> {
    contact: (&'a K, usize),
    coefficient: f64,
    static_overlap: f64,
    overlap: &'a Quintic,
    nodes: &'a LaneBlock,
}

impl<K: Kernel> SimdKernel for Stiffness<'_, K> {
    type Output = LaneBlock;

    #[inline(always)]
    fn run<L: Lanes>(self) -> LaneBlock {
        let (kernel, at) = self.contact;
        let (c, d0) = (self.coefficient, self.static_overlap);
        let r = self.overlap.at(L::load(self.nodes)) - L::splat(d0);
        let mut out = LaneBlock::default();
        kernel.stiffness_along(at, c, d0, r).store(&mut out);
        out
    }
}
