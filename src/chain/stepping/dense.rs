//! States between steps, which change no step.
//!
//! Between the last two nodes of three, positions, velocities and the energy that contacts have
//! passed on follow [`super::hermite`]. At one time of each step that holds samples the forces there
//! tell by how much the rates of these interpolants are off. Where that is more than the tolerance
//! allows, and beside contacts that open or close inside the step, where no polynomial follows the
//! motion, a step of the method itself leads from the step's start to each sample. It is made of as
//! many places only as its stages reach, so that its bits are those of the whole chain.

use std::ops::Range;

use super::super::law::Kernel;
use super::driver::Driver;
use super::hermite::Nodes;
use super::islands::Island;
use super::pair::{PairStep, Span};
use super::rates::{Blend, Defects, Derive, NodeRows, Press, Rates};
use super::system::State;
use super::{Mark, Stepping};
use crate::Result;
use crate::numeric::lanes::{WIDTH, widest};
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

/// Nodes, and scratch for states between them.
#[derive(Debug)]
pub(super) struct Dense {
    /// Blocks of which samples are wanted, in order.
    wanted: Vec<Range<usize>>,
    /// The state at the start of the last step; that before it is where the next step will be.
    pub(super) start: State,
    /// When these were; there is none before the first step.
    from: f64,
    before: Option<f64>,
    rates: [Rates; 3],
    inside: Option<Inside>,
    pub(super) sample: State,
    patch: State,
    /// Contacts that open or close inside the last step.
    pub(super) opened: Vec<usize>,
    largest: Vec<[f64; 2]>,
}

impl Dense {
    pub(super) fn new(time: f64, state: &State, wanted: &[Range<usize>]) -> Dense {
        let places = state.x.len();
        let rates = || Rates::new(places, !state.passed.is_empty());
        Dense {
            wanted: blocks_of(wanted),
            start: state.clone(),
            from: time,
            before: None,
            rates: [rates(), rates(), rates()],
            inside: None,
            sample: state.clone(),
            patch: state.clone(),
            opened: Vec::new(),
            largest: Vec::new(),
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
    /// Finds the state at time t inside the last step.
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
        self.leave_alone(t - from, &dense.wanted, start, sample);
        if let Some(nodes) = &inside.nodes {
            let weights = nodes.at(t, false);
            let islands = self.islands.active.iter();
            for blocks in
                islands.flat_map(|island| common(dense.wanted.iter().cloned(), &island.blocks))
            {
                widest(Blend {
                    island: &Island::part(blocks),
                    nodes: NodeRows {
                        states: [&self.next, start, &self.state],
                        rates: dense.rates.each_ref(),
                    },
                    weights: &weights,
                    to: sample,
                });
            }
        }
        let mut well = true;
        for part in &inside.patches {
            well &= self.step_inside(&part.island, &part.places, [from, t], start, patch);
            let places = part.places.iter();
            places.for_each(|places| copy(patch, sample, places));
        }
        self.system.place(t, &mut sample.x, &mut sample.v);
        dense.inside = Some(inside);
        if !well {
            self.land_inside(dense, [from, t], observer)?;
        }
        self.dense = Some(taken);
        Ok(())
    }

    /// Flights, and what outside the islands stays as it was.
    fn leave_alone(&self, dt: f64, wanted: &[Range<usize>], start: &State, sample: &mut State) {
        for gap in &self.islands.gaps {
            for gap in common(wanted.iter().map(places_of), gap) {
                let (x, v) = (&start.x[gap.clone()], &start.v[gap.clone()]);
                for ((to, x), v) in sample.x[gap.clone()].iter_mut().zip(x).zip(v) {
                    *to = x + dt * v;
                }
                sample.v[gap.clone()].copy_from_slice(v);
                if !start.lost.is_empty() {
                    sample.lost[gap.clone()].copy_from_slice(&start.lost[gap.clone()]);
                }
            }
        }
        let moved = self.islands.at_rest.min(sample.force.len());
        for shut in self.islands.shut(moved) {
            for shut in common(wanted.iter().map(places_of), &shut) {
                sample.force[shut.clone()].fill(0.0);
                if !start.passed.is_empty() {
                    sample.passed[shut.clone()].copy_from_slice(&start.passed[shut]);
                }
            }
        }
    }

    /// Forces at the positions of a sample.
    fn press_inside(&self, sample: &mut State, t: f64) {
        let State { x, v, force, .. } = sample;
        for island in &self.islands.active {
            widest(Press {
                system: &self.system,
                island,
                x,
                force,
            });
        }
        super::pair::press_placed(&self.system, t, [x, v], force);
    }

    /// Where polynomials follow the last step, and where not.
    fn ways_inside(&mut self, dense: &mut Dense) -> Inside {
        let from = dense.from;
        let Some(before) = dense.before.filter(|_| !self.system.has_pulls()) else {
            return self.stepped();
        };
        let (sample, largest) = (&mut dense.sample, &mut dense.largest);
        let states = [&self.next, &dense.start, &self.state];
        for (state, rates) in states.into_iter().zip(&mut dense.rates) {
            if rates.survey == Some(self.surveys) {
                continue;
            }
            for island in &self.islands.active {
                widest(Derive {
                    system: &self.system,
                    island,
                    state,
                    rates,
                });
            }
            rates.survey = Some(self.surveys);
        }
        let times = Nodes::new([before, from, self.time]);
        let (checked, ratio) = times.check();
        let weights = times.at(checked, true);
        let nodes = NodeRows {
            states,
            rates: dense.rates.each_ref(),
        };
        let allowed = [1.0, self.energy_scale].map(|unit| SHARE * self.tolerance() * unit / ratio);
        let opened = dense.opened.iter();
        let mut doubtful: Vec<Range<usize>> = opened
            .map(|s| s.saturating_sub(BESIDE)..s + BESIDE)
            .collect();
        for island in &self.islands.active {
            widest(Blend {
                island,
                nodes,
                weights: &weights,
                to: sample,
            });
        }
        self.system.place(checked, &mut sample.x, &mut sample.v);
        if from < self.drive_ends {
            // What drives the first site has no polynomial.
            doubtful.push(0..WIDTH);
        }
        self.press_inside(sample, checked);
        for island in &self.islands.active {
            largest.clear();
            widest(Defects {
                system: &self.system,
                island,
                nodes,
                weights: &weights,
                at: sample,
                largest,
            });
            for (b, off) in island.blocks.clone().zip(largest.iter()) {
                let follows = off
                    .iter()
                    .zip(allowed)
                    .all(|(off, allowed)| *off <= allowed);
                if !follows {
                    doubtful.push(WIDTH * b..WIDTH * (b + 1));
                }
            }
        }
        let wanted = dense.wanted.iter();
        let wanted = |places: &Range<usize>| common(wanted.clone().map(places_of), places).next();
        doubtful.retain(|places| wanted(places).is_some());
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

/// The blocks that hold these places.
fn blocks_of(wanted: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut blocks: Vec<Range<usize>> = Vec::new();
    for places in wanted {
        let of = places.start / WIDTH..places.end.div_ceil(WIDTH);
        match blocks.last_mut() {
            Some(last) if of.start <= last.end => last.end = last.end.max(of.end),
            _ => blocks.push(of),
        }
    }
    blocks
}

fn places_of(blocks: &Range<usize>) -> Range<usize> {
    WIDTH * blocks.start..WIDTH * blocks.end
}

/// What a range has in common with each of others.
fn common<'a>(
    ranges: impl Iterator<Item = Range<usize>> + 'a,
    with: &Range<usize>,
) -> impl Iterator<Item = Range<usize>> + 'a {
    let with = with.clone();
    let both = move |range: Range<usize>| range.start.max(with.start)..range.end.min(with.end);
    ranges.map(both).filter(|range| !range.is_empty())
}

/// Copies places and the contacts on their left.
fn copy(from: &State, to: &mut State, places: &Range<usize>) {
    for (from, to) in [
        (&from.x, &mut to.x),
        (&from.v, &mut to.v),
        (&from.force, &mut to.force),
        (&from.passed, &mut to.passed),
        (&from.lost, &mut to.lost),
    ] {
        if !to.is_empty() {
            to[places.clone()].copy_from_slice(&from[places.clone()]);
        }
    }
}
