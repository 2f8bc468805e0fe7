//! One step of an embedded pair on one island.

use super::super::drive::Drive;
use super::super::law::Kernel;
use super::correction::Correction;
use super::energy;
use super::events::Events;
use super::finish::{Finish, Largest};
use super::islands::Island;
use super::stage::{self, StageSums};
use super::system::{FIRST_SITE, State, System, resonator_place};
use super::tableau::{Tableau, Weights};
use crate::numeric::lanes::{AlignedRow, widest};

/// Scratch of a step, a row a stage where there are many.
#[derive(Debug)]
pub(super) struct StepScratch {
    pub(super) force: Vec<AlignedRow>,
    pub(super) damping: Vec<AlignedRow>,
    /// Drag on each site, and what other forces pull on it.
    pub(super) pull: Vec<AlignedRow>,
    pub(super) x: AlignedRow,
    pub(super) v: AlignedRow,
    pub(super) error: AlignedRow,
    pub(super) events: Events,
}

impl StepScratch {
    pub(super) fn new(places: usize, stages: usize, lossy: bool) -> StepScratch {
        let rows = |count| (0..count).map(|_| AlignedRow::zeros(places)).collect();
        let row = || AlignedRow::zeros(places);
        let lossy_stages = if lossy { stages } else { 0 };
        StepScratch {
            force: rows(stages),
            damping: rows(lossy_stages),
            pull: rows(lossy_stages),
            x: row(),
            v: row(),
            error: row(),
            events: Events::default(),
        }
    }
}

/// What came of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepOutcome {
    /// Largest estimated error of a velocity.
    pub(super) error: f64,
    /// A guard contact pressed.
    pub(super) leaked: bool,
    /// Contacts that were corrected.
    pub(super) corrected: u64,
    /// The longest step that resolves what closes and opens in this one.
    pub(super) longest: f64,
    /// The longest step that may follow what has closed in this one.
    pub(super) onward: f64,
}

impl Default for StepOutcome {
    fn default() -> StepOutcome {
        StepOutcome {
            error: 0.0,
            leaked: false,
            corrected: 0,
            longest: f64::INFINITY,
            onward: f64::INFINITY,
        }
    }
}

/// From time t on, by h.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub(super) t: f64,
    pub(super) h: f64,
}

/// A step of an embedded pair.
#[derive(Debug)]
pub(super) struct PairStep<'a, K> {
    pub(super) system: &'a System<K>,
    pub(super) tableau: &'a Tableau,
    /// Corrects what openings and closings add to the error.
    pub(super) corrections: &'a [Correction],
    /// Of the local error of a velocity; 0 for fixed steps.
    pub(super) tolerance: f64,
    pub(super) span: Span,
}

impl<K: Kernel> PairStep<'_, K> {
    /// Advances an island from `state` into `next`, and adds what comes of it.
    pub(super) fn advance(
        &self,
        island: &Island,
        (state, next): (&State, &mut State),
        scratch: &mut StepScratch,
        outcome: &mut StepOutcome,
    ) {
        let (system, tableau, span) = (self.system, self.tableau, self.span);
        let Span { t, h } = span;
        let blocks = island.blocks.clone();
        let last = tableau.stages() - 1;
        let mut leaked = self.stages(island, state, &mut next.x, scratch);

        let StepScratch {
            force,
            pull,
            error,
            events,
            ..
        } = scratch;
        let rows = |weights, rows| StageSums::new(weights, h, rows, island);
        let lossy = system.has_pulls();
        let pulls = lossy.then(|| [rows(&tableau.bp, pull), rows(&tableau.error, pull)]);
        let mut largest = widest(Finish {
            mobility: &system.mobility,
            static_overlap: &system.static_overlap,
            island,
            h,
            x: &state.x,
            v: &state.v,
            x1: &next.x,
            sums: [&rows(&tableau.bp, force), &rows(&tableau.error, force)],
            pulls: pulls.as_ref().map(|[velocity, error]| [velocity, error]),
            v1: &mut next.v,
            error,
            openings: events.openings(),
        });
        if system.has_placed_in(island) {
            system.place(t + h, &mut next.x, &mut next.v);
        }
        next.force.0[blocks.clone()].copy_from_slice(&force[last].0[blocks]);

        if !self.corrections.is_empty() {
            events.find(self, island, [state, next], error);
            if !events.is_empty() {
                events.correct(self, island, next, force, error);
                leaked |= island.leaks(&next.force) || events.reach_guards(island);
                largest = widest(Largest { island, row: error });
            }
        }
        // NaN is kept: it is larger than any tolerance.
        if !(outcome.error.is_nan() || outcome.error > largest) {
            outcome.error = largest;
        }
        outcome.leaked |= leaked;
        outcome.corrected += events.count();
        let [longest, onward] = events.lengths(h);
        outcome.longest = outcome.longest.min(longest);
        outcome.onward = outcome.onward.min(onward);
        if !state.passed.is_empty() {
            energy::pass_on(system, tableau, island, span, state, next, scratch);
        }
    }

    /// Forces of all stages, and the positions at the last one. Returns whether a guard contact
    /// pressed.
    fn stages(
        &self,
        island: &Island,
        state: &State,
        end: &mut AlignedRow,
        scratch: &mut StepScratch,
    ) -> bool {
        let (system, tableau) = (self.system, self.tableau);
        let Span { t, h } = self.span;
        let blocks = island.blocks.clone();
        let lossy = system.has_pulls();
        let has_placed = system.has_placed_in(island);
        let last = tableau.stages() - 1;
        let StepScratch {
            force,
            damping,
            pull,
            x,
            v,
            ..
        } = scratch;
        force[0].0[blocks.clone()].copy_from_slice(&state.force.0[blocks]);
        if lossy {
            let rows = [&mut force[0], &mut damping[0], &mut pull[0]];
            damp(system, t, island, [&state.x, &state.v], rows);
        }
        let mut leaked = false;
        for stage in 1..=last {
            let ch = tableau.c[stage] * h;
            let positions = if stage == last { &mut *end } else { &mut *x };
            if lossy {
                let flight = Some((ch, &state.v));
                let weights = (&tableau.a[stage], h * h);
                push(
                    system,
                    island,
                    &state.x,
                    flight,
                    weights,
                    [force, pull],
                    positions,
                );
                let weights = (&tableau.velocity[stage], h);
                push(system, island, &state.v, None, weights, [force, pull], v);
                if has_placed {
                    system.place(t + ch, positions, v);
                }
                let rows = [&mut force[stage], &mut damping[stage], &mut pull[stage]];
                damp(system, t + ch, island, [positions, v], rows);
            } else {
                let (before, from) = force.split_at_mut(stage);
                widest(stage::MoveAndPress {
                    system,
                    island,
                    x: &state.x,
                    v: &state.v,
                    reach: ch,
                    sums: &StageSums::new(&tableau.a[stage], h * h, before, island),
                    positions,
                    force: &mut from[0],
                });
                if has_placed {
                    system.place(t + ch, positions, v);
                    press_placed(system, t + ch, [positions, v], &mut from[0]);
                }
            }
            leaked |= island.leaks(&force[stage]);
        }
        leaked
    }
}

/// [`stage::Push`] by weighted forces, and by the drag where there are losses.
pub(super) fn push<K>(
    system: &System<K>,
    island: &Island,
    base: &AlignedRow,
    flight: Option<(f64, &AlignedRow)>,
    (weights, scale): (&Weights, f64),
    [force, pull]: [&[AlignedRow]; 2],
    out: &mut AlignedRow,
) {
    let pulls = (!pull.is_empty()).then(|| StageSums::new(weights, scale, pull, island));
    widest(stage::Push {
        mobility: &system.mobility,
        island,
        base,
        flight,
        sums: &StageSums::new(weights, scale, force, island),
        pulls: pulls.as_ref(),
        out,
    });
}

/// Forces, damping and drag of a stage.
fn damp<K: Kernel>(
    system: &System<K>,
    t: f64,
    island: &Island,
    [x, v]: [&AlignedRow; 2],
    [force, damping, pull]: [&mut AlignedRow; 3],
) {
    widest(stage::Damp {
        system,
        island,
        x,
        v,
        force,
        damping,
        pull,
    });
    if system.ground.is_some() {
        for s in island.places() {
            pull[s] += system.held(s, x[s]);
        }
    }
    if system.resonators.is_some() {
        for j in 0..system.sites {
            let force = system.resonator_force(j, [x, v]);
            pull[FIRST_SITE + j] -= force;
            // Drag acts on bodies alone.
            pull[resonator_place(system.sites, j)] = force;
        }
    }
    if let Some(Drive::Body(site, wave)) = &system.drive
        && island.places().contains(&(FIRST_SITE + site))
    {
        pull[FIRST_SITE + site] -= wave.at(t);
    }
    if system.has_placed_in(island) {
        press_placed(system, t, [x, v], force);
    }
}

/// Forces of the contacts of places that a block does not know.
pub(super) fn press_placed<K: Kernel>(
    system: &System<K>,
    t: f64,
    [x, v]: [&AlignedRow; 2],
    force: &mut AlignedRow,
) {
    let n = system.sites;
    if system.periodic {
        let image = system.force(n + 1, t, x, v).0;
        (force[1], force[n + 1]) = (image, image);
    }
    if system.drives_end() {
        force[1] = system.force(1, t, x, v).0;
    }
    if let Some((place, _)) = system.moved().filter(|(place, _)| system.is_site(*place)) {
        for s in [place, place + 1] {
            if system.contacts.contains(&s) {
                force[s] = system.force(s, t, x, v).0;
            }
        }
    }
}
