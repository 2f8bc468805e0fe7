//! One step of a symmetric composition of kicks and drifts on one island.

use super::super::law::Kernel;
use super::energy::PassOn;
use super::finish::Largest;
use super::islands::Island;
use super::pair::{Span, StepOutcome, StepScratch, press_placed};
use super::stage::{outside, walk};
use super::system::{State, System};
use super::tableau::Composition;
use crate::numeric::lanes::{AlignedRow, Lanes, SimdKernel, WIDTH, widest};

/// The kicks and drifts of a step, in shares of it.
#[derive(Debug)]
pub(super) struct Splitting {
    pub(super) kicks: Vec<f64>,
    pub(super) drifts: Vec<f64>,
}

impl Splitting {
    pub(super) fn new(composition: &Composition) -> Splitting {
        let (kicks, drifts) = composition.stages();
        Splitting { kicks, drifts }
    }

    /// Free flight over a step, with the roundings that the drifts make.
    #[inline(always)]
    pub(super) fn fly(&self, h: f64, v: &[f64], x: &mut [f64]) {
        for drift in &self.drifts {
            let time = drift * h;
            for (x, v) in x.iter_mut().zip(v) {
                *x += time * v;
            }
        }
    }
}

/// Advances an island from `state`, into `next`.
pub(super) fn advance<K: Kernel>(
    system: &System<K>,
    splitting: &Splitting,
    island: &Island,
    Span { mut t, h }: Span,
    state: &State,
    next: &mut State,
    scratch: &mut StepScratch,
) -> StepOutcome {
    let blocks = island.blocks.clone();
    let energy = !state.passed.is_empty();
    let has_placed = system.has_placed_in(island);
    let copy = |to: &mut AlignedRow, from: &AlignedRow| {
        to.0[blocks.clone()].copy_from_slice(&from.0[blocks.clone()]);
    };
    copy(&mut next.x, &state.x);
    copy(&mut next.v, &state.v);
    copy(&mut next.force, &state.force);
    if energy {
        copy(&mut next.passed, &state.passed);
    }
    let State {
        x,
        v,
        force,
        passed,
        input,
        ..
    } = next;
    let driven = system
        .driven()
        .filter(|place| island.places().contains(place));
    if driven.is_some() {
        *input = state.input;
    }
    let push = |time: f64, t: f64, force: &AlignedRow, v: &mut AlignedRow| {
        widest(Kick {
            mobility: &system.mobility,
            island,
            time,
            force,
            v,
        });
        if let Some(place) = driven {
            v[place] += time * system.mobility[place] * system.outer_force(place, t, force, 0.0);
        }
    };
    let mut leaked = false;
    for (i, kick) in splitting.kicks.iter().enumerate() {
        if let Some(drift) = i.checked_sub(1).and_then(|i| splitting.drifts.get(i)) {
            let time = drift * h;
            widest(Drift {
                system,
                island,
                time,
                v,
                x,
                force,
            });
            t += time;
            if has_placed {
                system.place(t, x, v);
                press_placed(system, t, [x, v], force);
            }
            leaked |= island.leaks(force);
        }
        let time = kick * h;
        if energy {
            // During a kick the force is constant and the velocity linear in time.
            let middle = &mut scratch.v;
            copy(middle, v);
            push(0.5 * time, t, force, middle);
            if has_placed {
                system.place(t, &mut scratch.x, middle);
            }
            widest(PassOn {
                island,
                weight: time,
                share: &system.flux_share,
                force,
                v: middle,
                passed,
            });
            if let Some(place) = driven {
                *input += time * system.outer_force(place, t, force, 0.0) * middle[place];
            }
        }
        push(time, t, force, v);
    }
    if has_placed {
        system.place(t, x, v);
    }
    StepOutcome {
        // A speed that is not finite is an error that no tolerance accepts.
        error: 0.0 * widest(Largest { island, row: v }),
        leaked,
        ..StepOutcome::default()
    }
}

/// `x += time v`, and the forces there.
struct Drift<'a, K> {
    system: &'a System<K>,
    island: &'a Island,
    time: f64,
    v: &'a AlignedRow,
    x: &'a mut AlignedRow,
    force: &'a mut AlignedRow,
}

impl<K: Kernel> SimdKernel for Drift<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let time = L::splat(self.time);
        let mut before = outside::<L>(self.island);
        for b in self.island.blocks.clone() {
            let at = L::load(&self.x.0[b]) + time * L::load(&self.v.0[b]);
            at.store(&mut self.x.0[b]);
            let r = at.take_left(before) - at;
            let c = L::load(&self.system.coefficient.0[b]);
            let d0 = L::load(&self.system.static_overlap.0[b]);
            self.system
                .kernel
                .force(WIDTH * b, c, d0, r)
                .store(&mut self.force.0[b]);
            before = at;
        }
    }
}

/// `v += time (F_s - F_{s+1}) / m`.
struct Kick<'a> {
    mobility: &'a AlignedRow,
    island: &'a Island,
    time: f64,
    force: &'a AlignedRow,
    v: &'a mut AlignedRow,
}

impl SimdKernel for Kick<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let time = L::splat(self.time);
        let blocks = self.island.blocks.clone();
        walk(
            blocks.len(),
            #[inline(always)]
            |b| L::load(&self.force.0[blocks.start + b]),
            #[inline(always)]
            |b, left, right| {
                let b = blocks.start + b;
                let push = L::load(&self.mobility.0[b]) * (left - right);
                (L::load(&self.v.0[b]) + time * push).store(&mut self.v.0[b]);
            },
        );
    }
}
