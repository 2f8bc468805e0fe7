//! What interpolants between steps need at their nodes, and how well they follow the motion.

use super::super::law::Kernel;
use super::hermite::Weights;
use super::islands::Island;
use super::system::{State, System};
use crate::numeric::lanes::{AlignedRow, LaneBlock, Lanes, SimdKernel, WIDTH};

/// Derivatives at a node: of each place, and of the energy that each contact passes on.
#[derive(Debug)]
pub(super) struct Rates {
    pub(super) acceleration: AlignedRow,
    pub(super) jerk: AlignedRow,
    /// Empty where no energy is followed.
    pub(super) flux: AlignedRow,
    pub(super) flux_rate: AlignedRow,
    /// The islands for which they are known.
    pub(super) survey: Option<u64>,
}

impl Rates {
    pub(super) fn new(places: usize, energy: bool) -> Rates {
        let row = || AlignedRow::zeros(places);
        let followed = || if energy { row() } else { AlignedRow::default() };
        Rates {
            acceleration: row(),
            jerk: row(),
            flux: followed(),
            flux_rate: followed(),
            survey: None,
        }
    }
}

/// Fills the rates of an island, without losses.
pub(super) struct Derive<'a, K> {
    pub(super) system: &'a System<K>,
    pub(super) island: &'a Island,
    pub(super) state: &'a State,
    pub(super) rates: &'a mut Rates,
}

impl<K: Kernel> SimdKernel for Derive<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (mobility, flux_share) = (&self.system.mobility, &self.system.flux_share);
        let State { x, v, force, .. } = self.state;
        let zero = L::splat(0.0);
        let blocks = self.island.blocks.clone();
        let first = blocks.start;
        let mut here = growth::<K, L>(
            self.system,
            self.state,
            blocks.start,
            [left_of(x, first), left_of(v, first)],
        );
        let mut acceleration_before = zero;
        let energy = !self.rates.flux.is_empty();
        let mut v_before = left_of(v, first);
        for b in blocks {
            let (at, speed): (L, L) = (load(x, b), load(v, b));
            let after = match b + 1 < x.0.len() {
                true => growth::<K, L>(self.system, self.state, b + 1, [at, speed]),
                false => zero,
            };
            let push: L = load(force, b);
            let mobility: L = load(mobility, b);
            let acceleration = mobility * (push - push.take_right(load(force, b + 1)));
            acceleration.store(&mut self.rates.acceleration.0[b]);
            (mobility * (here - here.take_right(after))).store(&mut self.rates.jerk.0[b]);
            if energy {
                let shares: [L; 2] = [load(&flux_share[0], b), load(&flux_share[1], b)];
                let mean = shares[0] * speed.take_left(v_before) + shares[1] * speed;
                let bend = shares[0] * acceleration.take_left(acceleration_before)
                    + shares[1] * acceleration;
                (push * mean).store(&mut self.rates.flux.0[b]);
                (here * mean + push * bend).store(&mut self.rates.flux_rate.0[b]);
            }
            acceleration_before = acceleration;
            v_before = speed;
            here = after;
        }
    }
}

/// A block, zeros where there is none.
#[inline(always)]
fn load<L: Lanes>(row: &AlignedRow, b: usize) -> L {
    match row.0.get(b) {
        Some(block) => L::load(block),
        None => L::splat(0.0),
    }
}

/// The block before one.
#[inline(always)]
fn left_of<L: Lanes>(row: &AlignedRow, b: usize) -> L {
    match b {
        0 => L::splat(0.0),
        _ => load(row, b - 1),
    }
}

#[inline(always)]
fn three<L: Lanes>(rows: [&[LaneBlock]; 3], b: usize) -> [L; 3] {
    [
        L::load(&rows[0][b]),
        L::load(&rows[1][b]),
        L::load(&rows[2][b]),
    ]
}

/// The rates of the forces of a block, with positions and velocities of the block before it.
#[inline(always)]
fn growth<K: Kernel, L: Lanes>(system: &System<K>, state: &State, b: usize, before: [L; 2]) -> L {
    let (at, speed): (L, L) = (load(&state.x, b), load(&state.v, b));
    let r = at.take_left(before[0]) - at;
    let closing = speed.take_left(before[1]) - speed;
    let (c, d0) = (
        load(&system.coefficient, b),
        load(&system.static_overlap, b),
    );
    system.kernel.stiffness(WIDTH * b, c, d0, r) * closing
}

/// The state before a step, at its start, and at its end.
#[derive(Clone, Copy)]
pub(super) struct NodeRows<'a> {
    pub(super) states: [&'a State; 3],
    pub(super) rates: [&'a Rates; 3],
}

/// Positions between the nodes, and velocities and energies passed where rows for them are given.
/// Places that no force acts on are those of their flight, in or outside islands.
pub(super) struct Blend<'a> {
    pub(super) island: &'a Island,
    pub(super) nodes: NodeRows<'a>,
    pub(super) weights: &'a Weights,
    pub(super) to: &'a mut State,
}

impl SimdKernel for Blend<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Blend {
            island,
            nodes: NodeRows { states, rates },
            weights,
            to,
        } = self;
        let x = states.map(|state| island.of(&state.x));
        let v = states.map(|state| island.of(&state.v));
        let a = rates.map(|rates| island.of(&rates.acceleration));
        let j = rates.map(|rates| island.of(&rates.jerk));
        let [x_out, v_out] = [&mut to.x, &mut to.v].map(|row| island.of_mut(row));
        let dt = L::splat(weights.dt);
        for b in 0..island.blocks.len() {
            let (x, v): ([L; 3], [L; 3]) = (three(x, b), three(v, b));
            let (a, j): ([L; 3], [L; 3]) = (three(a, b), three(j, b));
            let pushed = a[1].abs() + a[2].abs() + (v[2] - v[1]).abs();
            let at = weights.value(x, v, a);
            pushed.choose(at, x[1] + dt * v[1]).store(&mut x_out[b]);
            let speed = weights.value(v, a, j);
            pushed.choose(speed, v[1]).store(&mut v_out[b]);
        }
        if to.passed.is_empty() {
            return;
        }
        let w = states.map(|state| island.of(&state.passed));
        let flux = rates.map(|rates| island.of(&rates.flux));
        let bend = rates.map(|rates| island.of(&rates.flux_rate));
        for (b, out) in island.of_mut(&mut to.passed).iter_mut().enumerate() {
            let (w, flux, bend): ([L; 3], [L; 3], [L; 3]) =
                (three(w, b), three(flux, b), three(bend, b));
            let passes = flux[1].abs() + flux[2].abs() + (w[2] - w[1]).abs();
            passes.choose(weights.value(w, flux, bend), w[1]).store(out);
        }
    }
}

/// Forces at positions.
pub(super) struct Press<'a, K> {
    pub(super) system: &'a System<K>,
    pub(super) island: &'a Island,
    pub(super) x: &'a AlignedRow,
    pub(super) force: &'a mut AlignedRow,
}

impl<K: Kernel> SimdKernel for Press<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut before = super::stage::outside::<L>(self.island);
        for b in self.island.blocks.clone() {
            let at = L::load(&self.x.0[b]);
            let r = at.take_left(before) - at;
            let c = L::load(&self.system.coefficient.0[b]);
            let d0 = L::load(&self.system.static_overlap.0[b]);
            let force = self.system.kernel.force(WIDTH * b, c, d0, r);
            force.store(&mut self.force.0[b]);
            before = at;
        }
    }
}

/// By how much the rates of the interpolants at a time are off those of the motion there, the
/// largest of each block: of velocities, and of energies passed.
pub(super) struct Defects<'a, K> {
    pub(super) system: &'a System<K>,
    pub(super) island: &'a Island,
    pub(super) nodes: NodeRows<'a>,
    pub(super) weights: &'a Weights,
    /// What the interpolants and their forces are there.
    pub(super) at: &'a State,
    /// Gets a pair for each block of the island.
    pub(super) largest: &'a mut Vec<[f64; 2]>,
}

impl<K: Kernel> SimdKernel for Defects<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let NodeRows { states, rates } = self.nodes;
        let zero = L::splat(0.0);
        let blocks = self.island.blocks.clone();
        let mut v_before = zero;
        for b in blocks.clone() {
            let push: L = load(&self.at.force, b);
            let after = match b + 1 < blocks.end {
                true => load(&self.at.force, b + 1),
                false => zero,
            };
            let right = push.take_right(after);
            let acceleration = load::<L>(&self.system.mobility, b) * (push - right);
            let v: [L; 3] = states.map(|state| load(&state.v, b));
            let a: [L; 3] = rates.map(|rates| load(&rates.acceleration, b));
            let j: [L; 3] = rates.map(|rates| load(&rates.jerk, b));
            let pushed = a[1].abs() + a[2].abs() + (v[2] - v[1]).abs();
            let off = (acceleration - self.weights.rate(v, a, j)).abs();
            let mut pair = [largest(pushed.choose(off, zero)), 0.0];
            if !self.at.passed.is_empty() {
                let speed: L = load(&self.at.v, b);
                let share: [L; 2] = [0, 1].map(|side| load(&self.system.flux_share[side], b));
                let flux = push * (share[0] * speed.take_left(v_before) + share[1] * speed);
                v_before = speed;
                let w: [L; 3] = states.map(|state| load(&state.passed, b));
                let rate: [L; 3] = rates.map(|rates| load(&rates.flux, b));
                let bend: [L; 3] = rates.map(|rates| load(&rates.flux_rate, b));
                let passes = rate[1].abs() + rate[2].abs() + (w[2] - w[1]).abs();
                let off = (flux - self.weights.rate(w, rate, bend)).abs();
                pair[1] = largest(passes.choose(off, zero));
            }
            self.largest.push(pair);
        }
    }
}

/// The largest lane; NaN where one is.
#[inline(always)]
fn largest<L: Lanes>(value: L) -> f64 {
    let mut block = LaneBlock::default();
    value.store(&mut block);
    let most = block.0.iter().fold(0.0, |a: f64, b| a.max(*b));
    most + 0.0 * block.0.iter().sum::<f64>()
}
