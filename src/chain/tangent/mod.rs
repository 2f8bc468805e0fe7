//! How a run changes with parameters: the equations of motion linearized along it.
//!
//! With the state `y = (x, v)` of a chain `y' = f(t, y; p)` its derivative `Y = dy/dp` obeys
//!
//! ```text
//! Y' = (df/dy) Y + df/dp,   Y(0) = dy(0)/dp
//! ```
//!
//! Both are integrated together, by DOP853 within the steps of the run itself, from whose states each step begins. Where a
//! contact opens or closes at the time `t*`, its stiffness goes with a power of `t - t*` and a dashpot's force jumps by `J`. Steps
//! end there; beside it they are even in `s` with `t = t* +- s^2` (`s^4` with tangent damping or powers that are no multiples of
//! 1/2), in which the equations are smooth; and the velocities of both bodies change by `J/m dt*/dp`, `dt*/dp = -(d delta/dp) / (d delta/dt)`.
//!
//! Source: E. Hairer, S. P. Norsett, G. Wanner, *Solving Ordinary Differential Equations I*, second edition (1993), I.14, II.6.

mod direction;
mod gradient;
mod lyapunov;
mod rates;

use std::ops::Range;

use ndarray::{Array3, Axis};
use rayon::prelude::*;

pub use direction::Direction;
pub use gradient::Gradient;
pub use lyapunov::Lyapunov;
use rates::{Active, Motion, Rates};

use super::simulation::Simulation;
use super::stepping::{FIRST_SITE, MOST_STAGES, State, Stepping, Tableau, Weights, first_contact};
use crate::Result;
use crate::numeric::lanes::{LaneBlock, Lanes, WIDTH};
use crate::observer::Observer;

/// The error estimated of derivatives, of order 5, over their largest so far, as a power of the local error of velocities: that of
/// order 8 is then about the latter.
const ESTIMATED: f64 = 2.0 / 3.0;

/// Derivatives of velocities that are small, over the speed of the motion and the relative change of the chain.
const SMALL: f64 = 1e-3;

/// A singular time matters up to this many lengths of an interval away from it.
const NEAR: f64 = 8.0;

/// Steps of an interval, beyond which the local error is taken as it is.
const MOST_STEPS: usize = 200;

impl Simulation {
    /// Derivatives of displacements and velocities, `(parameter, time, site)`, at rising times, along a run of this local error.
    ///
    /// Eight directions share one pass; passes go to the threads of the current pool.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub fn tangents(
        &self,
        directions: &[Direction],
        times: &[f64],
        local_error: f64,
        observer: &dyn Observer,
    ) -> Result<[Array3<f64>; 2]> {
        self.check()?;
        let shape = |parameters: usize| (parameters, times.len(), self.chain.n_sites());
        let one = |directions: &[Direction]| {
            let mut found = [0, 1].map(|_| Array3::zeros(shape(directions.len())));
            let mut time = 0;
            self.pass(directions, times, local_error, observer, &mut |follower| {
                for (i, found) in found.iter_mut().enumerate() {
                    let mut row = found.index_axis_mut(Axis(1), time);
                    let each = &follower.at.each;
                    row.indexed_iter_mut()
                        .for_each(|((p, s), to)| *to = each[s][i].0[p]);
                }
                time += 1;
            })?;
            Ok(found)
        };
        let passes: Result<Vec<_>> = directions.par_chunks(WIDTH).map(one).collect();
        let passes = passes?;
        Ok([0, 1].map(|i| {
            let each = passes.iter().map(|pass: &[Array3<f64>; 2]| pass[i].view());
            let each: Vec<_> = each.collect();
            ndarray::concatenate(Axis(0), &each).unwrap_or_else(|_| Array3::zeros(shape(0)))
        }))
    }

    fn pass(
        &self,
        directions: &[Direction],
        times: &[f64],
        local_error: f64,
        observer: &dyn Observer,
        visit: &mut dyn FnMut(&mut Follower),
    ) -> Result<()> {
        let (mut stepping, scale) = self.stepping(times, local_error, false)?;
        let mut follower = Follower::new(self, directions, [scale, local_error.powf(ESTIMATED)]);
        let mut t = 0.0;
        for &time in times {
            while t < time {
                let before = stepping.mark();
                let next = stepping.step_towards(time, observer)?;
                follower.follow([t, next], &before.state, &*stepping);
                t = next;
            }
            visit(&mut follower);
        }
        Ok(())
    }
}

/// What follows a run step by step.
struct Follower<'a> {
    rates: Rates<'a>,
    /// The place of the first link among contacts.
    first: usize,
    tableau: Tableau,
    sites: usize,
    masses: &'a [f64],
    dashpot: f64,
    /// With which `t - t*` goes with `s`.
    power: i32,
    /// Of the error of derivatives, over their largest; states are those of the run at the end of each of its steps.
    tolerance: f64,
    at: Motion,
    largest: [f64; WIDTH],
    /// When contacts last opened or closed.
    last: f64,
    stages: Vec<Motion>,
    work: Motion,
    off: Motion,
    /// Bodies from this one on are at rest.
    moved: usize,
    /// What moves other than in free flight in this step, and its places.
    active: Active,
    rows: Vec<Range<usize>>,
}

/// Times within a step: `t = origin + sign s^power`. Beside a time at which stiffnesses are singular they are even in s.
#[derive(Debug, Clone, Copy)]
struct Clock {
    origin: f64,
    sign: f64,
    power: i32,
}

impl Clock {
    fn time(&self, s: f64) -> f64 {
        self.origin + self.sign * s.powi(self.power)
    }

    /// dt/ds.
    fn speed(&self, s: f64) -> f64 {
        self.sign * f64::from(self.power) * s.powi(self.power - 1)
    }

    fn of(&self, t: f64) -> f64 {
        let share = (self.sign * (t - self.origin)).max(0.0);
        share.powf(1.0 / f64::from(self.power))
    }
}

impl<'a> Follower<'a> {
    fn new(
        simulation: &'a Simulation,
        directions: &'a [Direction],
        [scale, tolerance]: [f64; 2],
    ) -> Follower<'a> {
        let (rates, at) = Rates::new(simulation, directions);
        let places = at.places();
        let tableau = Tableau::runge_kutta_8_5();
        let losses = simulation.chain.losses;
        let mut follower = Follower {
            stages: vec![Motion::zeros(places); tableau.stages() - 1],
            work: Motion::zeros(places),
            off: Motion::zeros(places),
            tableau,
            first: first_contact(&simulation.chain),
            sites: simulation.chain.n_sites(),
            masses: &simulation.chain.mass,
            dashpot: losses.dashpot,
            power: match losses.tangent == 0.0 && rates.opens_with_roots() {
                true => 2,
                false => 4,
            },
            rates,
            tolerance,
            at,
            largest: [0.0; WIDTH],
            last: f64::NEG_INFINITY,
            moved: 0,
            active: Active::default(),
            rows: Vec::new(),
        };
        for (least, direction) in follower.largest.iter_mut().zip(directions) {
            *least = SMALL * scale * direction.relative;
        }
        follower.note();
        follower
    }

    /// Keeps the largest derivatives of velocities.
    fn note(&mut self) {
        for [_, v] in &self.at.each {
            for (most, v) in self.largest.iter_mut().zip(v.0) {
                *most = most.max(v.abs());
            }
        }
    }

    /// Goes along the last step of the run, from this state.
    fn follow(&mut self, [from, to]: [f64; 2], start: &State, stepping: &dyn Stepping) {
        let end = stepping.state();
        let places = self.at.places();
        let moves = |s: &usize| end.x[FIRST_SITE + s] != 0.0 || end.v[FIRST_SITE + s] != 0.0;
        let last = (0..self.sites).rev().find(moves).map_or(0, |s| s + 3);
        self.moved = self.moved.max(last).min(self.sites);
        let events = stepping.openings([(from, start), (to, end)], &|_, _| true);
        let presses = |i: usize| {
            let s = self.first + i;
            let presses_at = |state: &State| state.force[s] != 0.0;
            presses_at(start) || presses_at(end) || events.iter().any(|(_, event)| *event == s)
        };
        self.active = self.rates.active(self.moved, presses);
        self.rows = self.active.places(self.sites, places);
        let soon = self.next_opening(stepping, to);
        let mut t = from;
        for (time, s) in events {
            self.cross([t, time], Some(time));
            self.jump(time, s - self.first);
            self.last = time;
            t = time;
        }
        self.cross([t, to], soon);
        let mut flying = 0;
        for row in &self.rows {
            fly(&mut self.at, flying..row.start, to - from);
            flying = row.end;
        }
        fly(&mut self.at, flying..self.sites, to - from);
        for (s, base) in self.at.base.iter_mut().enumerate() {
            // Resonators are behind the last ghost.
            let place = FIRST_SITE + s + usize::from(s >= self.sites);
            *base = [end.x[place], end.v[place]];
        }
        self.note();
    }

    /// When the next contact opens after a step that ends at this time.
    fn next_opening(&self, stepping: &dyn Stepping, t: f64) -> Option<f64> {
        let end = stepping.state();
        let opens = |&i: &usize| {
            let link = &self.rates.links[i];
            let s = self.first + i;
            let [left, right] = [s - 1, s].map(|s| stepping.motion(s, t, end));
            let [r, parting, bend]: [f64; 3] = std::array::from_fn(|i| left[i] - right[i]);
            let overlap = link.static_overlap.value + r;
            // Where it presses and parts.
            let is_near = link.opens && overlap > 0.0 && parting < 0.0;
            let square = parting * parting - 2.0 * bend * overlap;
            is_near.then(|| t + 2.0 * overlap / (-parting + square.max(0.0).sqrt()))
        };
        let times = self.active.links.iter().filter_map(opens);
        times.min_by(f64::total_cmp)
    }

    /// What a dashpot that sets in or ends changes.
    fn jump(&mut self, t: f64, i: usize) {
        if self.dashpot == 0.0 {
            return;
        }
        let link = &self.rates.links[i];
        let [overlap, closing] = self.rates.overlap(link, t, &self.at);
        if closing.value == 0.0 {
            return;
        }
        // The jump is the dashpot times the speed, which cancels.
        let jump = -self.dashpot * closing.value.signum();
        let mut grows = LaneBlock::default();
        overlap.each.store(&mut grows);
        for (place, sign) in link.sites.into_iter().zip([1.0, -1.0]) {
            let Some(s) = place else { continue };
            let share = sign * jump / self.masses[s];
            let pairs = self.at.each[s][1].0.iter_mut().zip(grows.0);
            pairs.for_each(|(v, grows)| *v += share * grows);
        }
        self.rates.place(t, &mut self.at);
    }

    /// Integrates over an interval, at whose end, or soon after it, a contact opens or closes.
    fn cross(&mut self, [from, to]: [f64; 2], next: Option<f64>) {
        let h = to - from;
        if h <= 0.0 {
            return;
        }
        let before = Some(self.last).filter(|t| from - t < NEAR * h);
        let after = next.filter(|t| *t >= to && t - to < NEAR * h);
        let clock = |origin: f64, sign: f64, power: i32| Clock {
            origin,
            sign,
            power,
        };
        let power = self.power;
        match (before, after) {
            (Some(a), Some(b)) => {
                let middle = 0.5 * (from + to);
                self.run(clock(a, 1.0, power), [from, middle]);
                self.run(clock(b, -1.0, power), [middle, to]);
            }
            (Some(a), None) => self.run(clock(a, 1.0, power), [from, to]),
            (None, Some(b)) => self.run(clock(b, -1.0, power), [from, to]),
            (None, None) => self.run(clock(0.0, 1.0, 1), [from, to]),
        }
    }

    /// Steps that adapt to the error.
    fn run(&mut self, clock: Clock, [from, to]: [f64; 2]) {
        let [mut s, end] = [from, to].map(|t| clock.of(t));
        let mut step = end - s;
        for _ in 0..MOST_STEPS {
            let is_last = (end - s).abs() <= step.abs() * (1.0 + 1e-12);
            if is_last {
                step = end - s;
            }
            let (next, error) = self.attempt(&clock, s, step);
            if error > 1.0 && step.abs() > 1e-3 * (end - s).abs() {
                step *= (0.8 * error.powf(-1.0 / 6.0)).clamp(0.1, 0.7);
                continue;
            }
            self.at = next;
            if is_last {
                return;
            }
            s += step;
            step *= (0.8 * error.max(1e-10).powf(-1.0 / 6.0)).clamp(0.5, 3.0);
        }
        self.at = self.attempt(&clock, s, end - s).0;
    }

    /// One step, and its error over the tolerance.
    fn attempt(&mut self, clock: &Clock, s: f64, step: f64) -> (Motion, f64) {
        let mut at = std::mem::take(&mut self.work);
        let mut lengths = [0.0; MOST_STAGES];
        for i in 0..self.stages.len() {
            let (done, rest) = self.stages.split_at_mut(i);
            let terms = weighted(&self.tableau.velocity[i], &lengths, done);
            match terms.is_empty() {
                true => at.clone_from(&self.at),
                false => at.sum(&self.rows, Some(&self.at), &terms),
            }
            let here = s + self.tableau.c[i] * step;
            lengths[i] = step * clock.speed(here);
            let here = clock.time(here);
            self.rates.place(here, &mut at);
            self.rates.evaluate(here, &at, &self.active, &mut rest[0]);
        }
        let mut next = self.at.clone();
        let of = |weights| weighted(weights, &lengths, &self.stages);
        next.sum(&self.rows, Some(&self.at), &of(&self.tableau.bp));
        let off = &mut self.off;
        off.sum(&self.rows, None, &of(&self.tableau.error));
        self.rates.place(clock.time(s + step), &mut next);
        let mut error: f64 = 0.0;
        for place in self.rows.iter().cloned().flatten() {
            let pairs = off.each[place][1].0.iter().zip(next.each[place][1].0);
            for ((off, now), largest) in pairs.zip(self.largest) {
                let size = largest.max(now.abs()).max(f64::MIN_POSITIVE);
                error = error.max(off.abs() / (self.tolerance * size));
            }
        }
        self.work = at;
        (next, error)
    }
}

/// Rates of stages, each times its weight and its length.
fn weighted<'s>(
    weights: &Weights,
    lengths: &[f64],
    stages: &'s [Motion],
) -> Vec<(f64, &'s Motion)> {
    let of = |(stage, weight): &(usize, f64)| (lengths[*stage] * weight, &stages[*stage]);
    weights.iter().map(of).collect()
}

/// Derivatives in free flight.
fn fly(at: &mut Motion, places: Range<usize>, time: f64) {
    for s in places {
        let [x, v] = &mut at.each[s];
        x.0.iter_mut().zip(v.0).for_each(|(x, v)| *x += time * v);
    }
}
