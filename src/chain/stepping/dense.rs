//! States between steps, which change no step.
//!
//! Between the last two nodes of three, positions and velocities follow [`super::hermite`]. At one time of each step
//! that holds samples the forces there tell by how much the rates of these interpolants are off. Where that is more than
//! the tolerance allows, and beside contacts that open or close inside the step, where no polynomial follows the
//! motion, a step of the method itself leads from the step's start to each sample. It is made of as
//! many places only as its stages reach, so that its bits are those of the whole chain.

use std::ops::Range;

use super::super::lattice::Losses;
use super::super::law::Kernel;
use super::driver::Driver;
use super::hermite::{Nodes, Weights};
use super::islands::Island;
use super::pair::{PairStep, Span, press_placed, push};
use super::stage::Damp;
use super::system::State;
use super::{Mark, Stepping};
use crate::Result;
use crate::numeric::lanes::{AlignedRow, Lanes, SimdKernel, WIDTH, widest};
use crate::observer::Observer;

/// The largest estimated error of an interpolant, in units of the tolerance of a step, of which runs have
/// an eighth of theirs: errors of samples do not add up.
const SHARE: f64 = 1.0;

/// Places on each side of an opening contact that are stepped to each sample.
const BESIDE: usize = 3;

/// Places beyond those that the stages reach, which corrections change.
const CORRECTED: usize = 8;

/// A part of an island that is stepped to each sample, and the places for which it is.
#[derive(Debug, Clone, PartialEq)]
struct Patch {
    island: Island,
    places: Vec<Range<usize>>,
}

/// How the states inside a step are found: along polynomials between these nodes, if there are any, but for these parts.
#[derive(Debug, Clone, PartialEq)]
struct Inside {
    nodes: Option<Nodes>,
    patches: Vec<Patch>,
}

/// Derivatives of each place at a node, and the survey of whose islands they are.
#[derive(Debug)]
struct Rates {
    acceleration: AlignedRow,
    jerk: AlignedRow,
    survey: Option<u64>,
}

/// Nodes, and scratch for states between them.
#[derive(Debug)]
pub(super) struct Dense {
    /// The state at the start of the last step; that before it is where the next step will be.
    start: State,
    /// When these were; there is none before the first step.
    from: f64,
    before: Option<f64>,
    rates: [Rates; 3],
    inside: Option<Inside>,
    pub(super) sample: State,
    patch: State,
    /// Contacts that open or close inside the last step.
    pub(super) opened: Vec<usize>,
    /// Zeros; forces, their rates, and what is of no use.
    scratch: [AlignedRow; 4],
}

/// The last step of an island along polynomials between three nodes.
#[derive(Clone, Copy)]
struct Course<'a> {
    island: &'a Island,
    /// The state before the step, at its start, and at its end.
    states: [&'a State; 3],
    rates: &'a [Rates; 3],
    weights: &'a Weights,
}

impl Course<'_> {
    /// Displacements, velocities, accelerations and rates of these of a block at the nodes, and what is above 0 where a force acts.
    #[inline(always)]
    fn at<L: Lanes>(&self, b: usize) -> ([[L; 3]; 4], L) {
        let (states, rates) = (self.states, self.rates.each_ref());
        let [x, v]: [[L; 3]; 2] = [
            three(states.map(|at| &at.x), b),
            three(states.map(|at| &at.v), b),
        ];
        let a: [L; 3] = three(rates.map(|at| &at.acceleration), b);
        let jerk: [L; 3] = three(rates.map(|at| &at.jerk), b);
        let pushed = a[1].abs() + a[2].abs() + (v[2] - v[1]).abs();
        ([x, v, a, jerk], pushed)
    }
}

#[inline(always)]
fn three<L: Lanes>(rows: [&AlignedRow; 3], b: usize) -> [L; 3] {
    rows.map(
        #[inline(always)]
        |row| L::load(&row.0[b]),
    )
}

/// Positions and velocities; in flight those of the flight.
struct Blend<'a> {
    course: Course<'a>,
    to: &'a mut State,
}

impl SimdKernel for Blend<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let weights = self.course.weights;
        let dt = L::splat(weights.dt);
        for b in self.course.island.blocks.clone() {
            let ([x, v, a, jerk], pushed) = self.course.at::<L>(b);
            let at = weights.value(x, v, a);
            let at = pushed.choose(at, x[1] + dt * v[1]);
            at.store(&mut self.to.x.0[b]);
            let speed = pushed.choose(weights.value(v, a, jerk), v[1]);
            speed.store(&mut self.to.v.0[b]);
        }
    }
}

/// By how much the rates of the velocities are off accelerations; the latter are replaced.
struct Defects<'a> {
    course: Course<'a>,
    acceleration: &'a mut AlignedRow,
}

impl SimdKernel for Defects<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for b in self.course.island.blocks.clone() {
            let ([_, v, a, jerk], pushed) = self.course.at::<L>(b);
            let acceleration = &mut self.acceleration.0[b];
            let off = (L::load(acceleration) - self.course.weights.rate(v, a, jerk)).abs();
            pushed.choose(off, L::splat(0.0)).store(acceleration);
        }
    }
}

impl Dense {
    pub(super) fn new(time: f64, state: &State) -> Dense {
        let row = || AlignedRow::zeros(state.x.len());
        let rates = || Rates {
            acceleration: row(),
            jerk: row(),
            survey: None,
        };
        Dense {
            start: state.clone(),
            from: time,
            before: None,
            rates: [rates(), rates(), rates()],
            inside: None,
            sample: state.clone(),
            patch: state.clone(),
            opened: Vec::new(),
            scratch: [row(), row(), row(), row()],
        }
    }

    /// The nodes of a step just accepted: `next` is the state at its start, and gets the one before.
    pub(super) fn accept(&mut self, start: f64, next: &mut State) {
        std::mem::swap(&mut self.start, next);
        self.before = (start > self.from).then_some(self.from);
        self.from = start;
        self.rates.rotate_left(1);
        self.rates[2].survey = None;
        self.inside = None;
    }
}

impl<K: Kernel> Driver<K> {
    /// Finds displacements and velocities at time t inside the last step.
    pub(super) fn find_inside(&mut self, t: f64, observer: &dyn Observer) -> Result<()> {
        let Some(mut taken) = self.dense.take() else {
            return self.advance_to(t, observer);
        };
        let dense = &mut *taken;
        let inside = match dense.inside.take() {
            Some(inside) => inside,
            None => self.ways_inside(dense),
        };
        let from = dense.from;
        let (start, sample, patch) = (&dense.start, &mut dense.sample, &mut dense.patch);
        for s in self.islands.gaps.iter().cloned().flatten() {
            (sample.x[s], sample.v[s]) = (start.x[s] + (t - from) * start.v[s], start.v[s]);
        }
        if let Some(nodes) = &inside.nodes {
            let weights = nodes.at(t, false);
            for island in &self.islands.active {
                let course = Course {
                    island,
                    states: [&self.next, start, &self.state],
                    rates: &dense.rates,
                    weights: &weights,
                };
                let to = &mut *sample;
                widest(Blend { course, to });
            }
        }
        let mut well = true;
        for part in &inside.patches {
            well &= self.step_inside(&part.island, &part.places, [from, t], start, patch);
            for places in part.places.iter().cloned() {
                sample.x[places.clone()].copy_from_slice(&patch.x[places.clone()]);
                sample.v[places.clone()].copy_from_slice(&patch.v[places]);
            }
        }
        self.system.place(t, &mut sample.x, &mut sample.v);
        dense.inside = Some(inside);
        if !well {
            self.land_inside(dense, [from, t], observer)?;
        }
        self.dense = Some(taken);
        Ok(())
    }

    /// Forces of the contacts of an island, and their rates where `tangent` is 1: damping by the tangent is the rate of the force,
    /// to which it is added.
    fn press(
        &self,
        (island, tangent): (&Island, f64),
        [x, v]: [&AlignedRow; 2],
        [force, damping, pull]: [&mut AlignedRow; 3],
    ) {
        let losses = Losses {
            tangent,
            ..Losses::default()
        };
        widest(Damp {
            system: &self.system,
            losses: &losses,
            island,
            x,
            v,
            force,
            damping,
            pull,
        });
    }

    /// Accelerations by contacts of these forces, or rates of them by rates of the forces.
    fn accelerate(
        &self,
        island: &Island,
        rest: &AlignedRow,
        force: &AlignedRow,
        out: &mut AlignedRow,
    ) {
        let rows = [std::slice::from_ref(force), &[]];
        let weights = (&vec![(0, 1.0)], 1.0);
        push(&self.system, island, rest, None, weights, rows, out);
    }

    /// Where polynomials follow the last step, and where not.
    fn ways_inside(&self, dense: &mut Dense) -> Inside {
        let from = dense.from;
        let Some(before) = dense.before.filter(|_| !self.system.has_pulls()) else {
            return self.stepped();
        };
        let (sample, [rest, force, rate, pull]) = (&mut dense.sample, &mut dense.scratch);
        let states = [&self.next, &dense.start, &self.state];
        for (state, rates) in states.into_iter().zip(&mut dense.rates) {
            if rates.survey == Some(self.surveys) {
                continue;
            }
            for island in &self.islands.active {
                self.press((island, 1.0), [&state.x, &state.v], [force, rate, pull]);
                self.accelerate(island, rest, &state.force, &mut rates.acceleration);
                self.accelerate(island, rest, rate, &mut rates.jerk);
            }
            rates.survey = Some(self.surveys);
        }
        let times = Nodes::new([before, from, self.time]);
        let (checked, ratio) = times.check();
        let weights = times.at(checked, true);
        let course = |island| Course {
            island,
            states,
            rates: &dense.rates,
            weights: &weights,
        };
        for island in &self.islands.active {
            let (course, to) = (course(island), &mut *sample);
            widest(Blend { course, to });
        }
        self.system.place(checked, &mut sample.x, &mut sample.v);
        let opened = dense.opened.iter();
        let mut doubtful: Vec<Range<usize>> = opened
            .map(|s| s.saturating_sub(BESIDE)..s + BESIDE)
            .collect();
        if from < self.drive_ends {
            // What drives the first site has no polynomial.
            doubtful.push(0..WIDTH);
        }
        for island in &self.islands.active {
            let at = [&sample.x, &sample.v];
            self.press((island, 0.0), at, [&mut sample.force, rate, pull]);
        }
        press_placed(
            &self.system,
            checked,
            [&sample.x, &sample.v],
            &mut sample.force,
        );
        let allowed = SHARE * self.tolerance() / ratio;
        for island in &self.islands.active {
            let off = &mut *rate;
            self.accelerate(island, rest, &sample.force, off);
            widest(Defects {
                course: course(island),
                acceleration: off,
            });
            let blocks = island.blocks.clone().map(|b| WIDTH * b..WIDTH * (b + 1));
            let follows =
                |places: &Range<usize>| off[places.clone()].iter().all(|off| *off <= allowed);
            doubtful.extend(blocks.filter(|places| !follows(places)));
        }
        if self.system.periodic && !doubtful.is_empty() {
            return self.stepped();
        }
        Inside {
            nodes: Some(times),
            patches: self.patches(doubtful),
        }
    }

    /// All islands are stepped.
    fn stepped(&self) -> Inside {
        let whole = |island: &Island| Patch {
            island: island.clone(),
            places: vec![island.places()],
        };
        Inside {
            nodes: None,
            patches: self.islands.active.iter().map(whole).collect(),
        }
    }

    /// The parts of islands that hold these places.
    fn patches(&self, mut doubtful: Vec<Range<usize>>) -> Vec<Patch> {
        let reach = self.tableau.stages() + CORRECTED;
        doubtful.sort_unstable_by_key(|places| places.start);
        let mut patches: Vec<Patch> = Vec::new();
        for places in doubtful {
            for island in &self.islands.active {
                let all = island.places();
                let places = places.start.max(all.start)..places.end.min(all.end);
                if places.is_empty() {
                    continue;
                }
                let first = places.start.saturating_sub(reach) / WIDTH;
                let last = (places.end + reach).div_ceil(WIDTH);
                let blocks = first.max(island.blocks.start)..last.min(island.blocks.end);
                match patches.last_mut() {
                    Some(patch) if blocks.start < patch.island.blocks.end => {
                        patch.island.blocks.end = blocks.end.max(patch.island.blocks.end);
                        patch.places.push(places);
                    }
                    _ => patches.push(Patch {
                        island: Island::part(blocks),
                        places: vec![places],
                    }),
                }
            }
        }
        patches
    }

    /// One step of the method from the start of the last one; whether these places keep the
    /// tolerance.
    fn step_inside(
        &mut self,
        island: &Island,
        places: &[Range<usize>],
        [from, t]: [f64; 2],
        start: &State,
        to: &mut State,
    ) -> bool {
        let tolerance = self.tolerance();
        let step = PairStep {
            system: &self.system,
            tableau: &self.tableau,
            corrections: &self.corrections,
            tolerance,
            span: Span {
                t: from,
                h: t - from,
            },
        };
        let outcome = step.advance(island, start, to, &mut self.scratch);
        let scratch = &self.scratch;
        let keeps = |places: &Range<usize>| {
            let mut errors = scratch.error[places.clone()].iter();
            errors.all(|error| error.abs() <= tolerance) && scratch.events.resolve(places)
        };
        !outcome.leaked && places.iter().all(keeps)
    }

    /// Steps to a sample as to any time, and returns.
    fn land_inside(
        &mut self,
        dense: &mut Dense,
        [from, t]: [f64; 2],
        observer: &dyn Observer,
    ) -> Result<()> {
        let (mark, next) = (self.mark(), self.next.clone());
        let (islands, surveyed, cost) = (self.islands.clone(), self.surveyed, self.cost);
        let (step, state) = (t - from, dense.start.clone());
        self.reset(&Mark {
            time: from,
            step,
            state,
        });
        let landed = self.advance_to(t, observer);
        std::mem::swap(&mut dense.sample, &mut self.state);
        self.reset(&mark);
        (self.next, self.islands) = (next, islands);
        (self.surveyed, self.cost) = (surveyed, cost);
        landed
    }
}
