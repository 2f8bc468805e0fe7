//! Eight chains at once by a composition of kicks and drifts, one chain a lane.
//!
//! Each lane undergoes the operations of [`super::composed`] in their order, so that its bits are
//! those of the chain alone. Contacts that have not been reached in any lane are left out.

use super::super::law::Kernel;
use super::Cost;
use super::composed::Splitting;
use super::driver::next_step;
use super::system::{State, System};
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, widest};

/// Chains of equally many sites, stepped alike.
#[derive(Debug)]
pub(crate) struct Together<K> {
    kernel: K,
    coefficient: Vec<LaneBlock>,
    static_overlap: Vec<LaneBlock>,
    mobility: Vec<LaneBlock>,
    x: Vec<LaneBlock>,
    v: Vec<LaneBlock>,
    force: Vec<LaneBlock>,
    splitting: Splitting,
    step: f64,
    time: f64,
    /// Places from this one on have not moved.
    reached: usize,
    cost: Cost,
}

impl<K: Kernel> Together<K> {
    /// Of up to [`WIDTH`] chains in their initial states.
    pub(super) fn new(
        chains: &[(System<K>, State)],
        kernel: K,
        splitting: Splitting,
        step: f64,
    ) -> Together<K> {
        let places = chains.first().map_or(0, |(system, _)| system.places());
        // The values that a row holds of each chain, gathered by place.
        let rows = |row: &dyn Fn(usize) -> Vec<f64>| -> Vec<LaneBlock> {
            let columns: Vec<Vec<f64>> = (0..chains.len()).map(row).collect();
            let lane = |s: usize, l: usize| columns.get(l).map_or(0.0, |column| column[s]);
            (0..places)
                .map(|s| LaneBlock(std::array::from_fn(|l| lane(s, l))))
                .collect()
        };
        let mut together = Together {
            kernel,
            coefficient: rows(&|l| chains[l].0.coefficient.to_vec()),
            static_overlap: rows(&|l| chains[l].0.static_overlap.to_vec()),
            mobility: rows(&|l| chains[l].0.mobility.to_vec()),
            x: rows(&|l| chains[l].1.x.to_vec()),
            v: rows(&|l| chains[l].1.v.to_vec()),
            force: rows(&|l| chains[l].1.force.to_vec()),
            splitting,
            step,
            time: 0.0,
            reached: 0,
            cost: Cost::default(),
        };
        let still = |s: &usize| {
            [&together.x, &together.v]
                .iter()
                .all(|row| is_zero(&row[*s]))
        };
        let moved = (0..places).rev().find(|s| !still(s));
        together.reached = moved.map_or(0, |s| s + 2).min(places);
        together
    }

    /// Steps to exactly this time.
    pub(crate) fn advance_to(&mut self, target: f64) {
        widest(Advance {
            together: self,
            target,
        });
    }

    /// Of each chain.
    pub(crate) fn cost(&self) -> Cost {
        self.cost
    }

    /// Copies one chain.
    pub(crate) fn read(&self, lane: usize, state: &mut State) {
        for (row, to) in [
            (&self.x, &mut state.x),
            (&self.v, &mut state.v),
            (&self.force, &mut state.force),
        ] {
            for (to, from) in to.iter_mut().zip(row) {
                *to = from.0[lane];
            }
        }
    }
}

fn is_zero(block: &LaneBlock) -> bool {
    block.0 == [0.0; WIDTH]
}

struct Advance<'a, K> {
    together: &'a mut Together<K>,
    target: f64,
}

impl<K: Kernel> SimdKernel for Advance<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Advance { together, target } = self;
        let (kicks, drifts) = (
            together.splitting.kicks.clone(),
            together.splitting.drifts.clone(),
        );
        let Some(mut step) = next_step(together.time, target, together.step) else {
            return;
        };
        kick::<K, L>(together, kicks[0] * step.h);
        loop {
            let next = next_step(step.end, target, together.step);
            for (i, drift) in drifts.iter().enumerate() {
                let kick = kicks[i + 1] * step.h;
                // The first kick of the next step follows at once the last one of this step.
                let more = next
                    .filter(|_| i + 1 == drifts.len())
                    .map(|next| kicks[0] * next.h);
                let drift = drift * step.h;
                match more {
                    Some(more) => pass::<K, L, 2>(together, drift, [kick, more]),
                    None => pass::<K, L, 1>(together, drift, [kick]),
                }
                together.cost.forces += together.reached as u64;
                let places = together.v.len();
                if together.reached < places && !is_zero(&together.v[together.reached - 1]) {
                    together.reached = (together.reached + WIDTH).min(places);
                }
            }
            together.time = step.end;
            together.cost.steps += 1;
            match next {
                Some(next) => step = next,
                None => return,
            }
        }
    }
}

/// A drift, the forces after it, and the kicks by these forces.
#[inline(always)]
fn pass<K: Kernel, L: Lanes, const KICKS: usize>(
    together: &mut Together<K>,
    drift: f64,
    kicks: [f64; KICKS],
) {
    let n = together.reached;
    let kernel = together.kernel.clone();
    let (x, v) = (&mut together.x[..n], &mut together.v[..n]);
    let (force, mobility) = (&mut together.force[..n], &together.mobility[..n]);
    let (c, d0) = (&together.coefficient[..n], &together.static_overlap[..n]);
    let drift = L::splat(drift);
    let zero = L::splat(0.0);
    let (mut before, mut left) = (zero, zero);
    let (mut speed_before, mut mobility_before) = (zero, zero);
    for s in 0..n {
        let speed = L::load(&v[s]);
        let at = L::load(&x[s]) + drift * speed;
        at.store(&mut x[s]);
        let f = kernel.force(s, L::load(&c[s]), L::load(&d0[s]), before - at);
        f.store(&mut force[s]);
        if s > 0 {
            kicked(speed_before, mobility_before * (left - f), kicks).store(&mut v[s - 1]);
        }
        (before, left) = (at, f);
        (speed_before, mobility_before) = (speed, L::load(&mobility[s]));
    }
    kicked(speed_before, mobility_before * (left - zero), kicks).store(&mut v[n - 1]);
}

#[inline(always)]
fn kicked<L: Lanes, const KICKS: usize>(mut speed: L, push: L, kicks: [f64; KICKS]) -> L {
    for kick in kicks {
        speed = speed + L::splat(kick) * push;
    }
    speed
}

#[inline(always)]
fn kick<K: Kernel, L: Lanes>(together: &mut Together<K>, kick: f64) {
    let n = together.reached;
    let kick = L::splat(kick);
    for s in 0..n {
        let right = together.force[..n]
            .get(s + 1)
            .map_or(L::splat(0.0), L::load);
        let push = L::load(&together.mobility[s]) * (L::load(&together.force[s]) - right);
        (L::load(&together.v[s]) + kick * push).store(&mut together.v[s]);
    }
}
