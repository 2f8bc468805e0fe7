//! Sums and forces of a stage, block by block, each in one pass over an island.
//!
//! A stage stores the force of each contact, not the acceleration of each site: with `S_s = sum_m
//! w_m F_m,s` the site at place s is pushed by `S_s - S_{s+1}`, since contact s acts on it to the
//! right and contact s + 1 to the left. Contacts outside the given blocks carry no force.

use super::super::law::Kernel;
use super::islands::Island;
use super::system::System;
use super::tableau::{MOST_STAGES, Weights};
use crate::numeric::lanes::{AlignedRow, LaneBlock, Lanes, SimdKernel, WIDTH};

/// Sums over stages of weighted rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct StageSums<'a> {
    terms: [(f64, &'a [LaneBlock]); MOST_STAGES],
    number: usize,
}

impl<'a> StageSums<'a> {
    #[inline(always)]
    pub(super) fn new(
        weights: &Weights,
        scale: f64,
        rows: &'a [AlignedRow],
        island: &Island,
    ) -> Self {
        let mut sums = StageSums {
            terms: [(0.0, &[]); MOST_STAGES],
            number: weights.len().min(MOST_STAGES),
        };
        for (term, &(row, weight)) in sums.terms.iter_mut().zip(weights) {
            *term = (scale * weight, &rows[row].0[island.blocks.clone()]);
        }
        sums
    }

    /// Of one block, by two sets of weights for the same rows.
    #[inline(always)]
    pub(super) fn both<L: Lanes>(one: &Self, other: &Self, block: usize) -> (L, L) {
        unrolled(
            one.number,
            (L::splat(0.0), L::splat(0.0)),
            #[inline(always)]
            |sums, i| {
                let ((weight, row), (weight_2, _)) = (one.terms[i], other.terms[i]);
                let value = L::load(&row[block]);
                (
                    sums.0 + L::splat(weight) * value,
                    sums.1 + L::splat(weight_2) * value,
                )
            },
        )
    }

    /// Of one block, counted from the first of the island.
    #[inline(always)]
    fn at<L: Lanes>(&self, block: usize) -> L {
        unrolled(
            self.number,
            L::splat(0.0),
            #[inline(always)]
            |sum, i| {
                let (weight, row) = self.terms[i];
                sum + L::splat(weight) * L::load(&row[block])
            },
        )
    }
}

/// A fold over the first indices. Most sums have a few terms: a loop over them takes as long for its ends as for the terms.
#[inline(always)]
fn unrolled<T>(number: usize, start: T, add: impl Fn(T, usize) -> T) -> T {
    #[inline(always)]
    fn of<T, const N: usize>(mut sum: T, add: impl Fn(T, usize) -> T) -> T {
        for i in 0..N {
            sum = add(sum, i);
        }
        sum
    }
    match number {
        1 => of::<T, 1>(start, add),
        2 => of::<T, 2>(start, add),
        3 => of::<T, 3>(start, add),
        4 => of::<T, 4>(start, add),
        5 => of::<T, 5>(start, add),
        6 => of::<T, 6>(start, add),
        7 => of::<T, 7>(start, add),
        8 => of::<T, 8>(start, add),
        _ => {
            let mut sum = start;
            for i in 0..number {
                sum = add(sum, i);
            }
            sum
        }
    }
}

/// Sums of blocks whose right neighbours can be had.
pub(super) trait Right: Copy {
    fn nothing() -> Self;

    fn right(self, after: Self) -> Self;
}

impl<L: Lanes> Right for L {
    #[inline(always)]
    fn nothing() -> L {
        L::splat(0.0)
    }

    #[inline(always)]
    fn right(self, after: L) -> L {
        self.take_right(after)
    }
}

impl<L: Lanes> Right for (L, L) {
    #[inline(always)]
    fn nothing() -> (L, L) {
        (L::splat(0.0), L::splat(0.0))
    }

    #[inline(always)]
    fn right(self, after: (L, L)) -> (L, L) {
        (self.0.take_right(after.0), self.1.take_right(after.1))
    }
}

/// Walks through blocks with the sums of each and the sums of each place's right neighbour.
#[inline(always)]
pub(super) fn walk<T: Right>(
    blocks: usize,
    sums: impl Fn(usize) -> T,
    mut visit: impl FnMut(usize, T, T),
) {
    // A sum is used two blocks after it was begun, so that none is waited for.
    let mut here = sums(0);
    let mut after = if blocks > 1 { sums(1) } else { T::nothing() };
    for b in 0..blocks {
        let later = if b + 2 < blocks {
            sums(b + 2)
        } else {
            T::nothing()
        };
        visit(b, here, here.right(after));
        (here, after) = (after, later);
    }
}

/// Where the place before the first block is: so far left that its contact is open.
#[inline(always)]
pub(super) fn outside<L: Lanes>(island: &Island) -> L {
    L::splat(if island.blocks.start == 0 {
        0.0
    } else {
        f64::NEG_INFINITY
    })
}

/// Positions `x + reach v + (S_s - S_{s+1}) / m`, and the forces there.
pub(super) struct MoveAndPress<'a, K> {
    pub(super) system: &'a System<K>,
    pub(super) island: &'a Island,
    pub(super) x: &'a AlignedRow,
    pub(super) v: &'a AlignedRow,
    pub(super) reach: f64,
    pub(super) sums: &'a StageSums<'a>,
    pub(super) positions: &'a mut AlignedRow,
    pub(super) force: &'a mut AlignedRow,
}

impl<K: Kernel> SimdKernel for MoveAndPress<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (system, island) = (self.system, self.island);
        let (first, n) = (island.blocks.start, island.blocks.len());
        let [x, v, mobility] = [self.x, self.v, &system.mobility].map(|row| island.of(row));
        let [c, d0] = [&system.coefficient, &system.static_overlap].map(|row| island.of(row));
        let [positions, force] = [self.positions, self.force].map(|row| island.of_mut(row));
        let reach = L::splat(self.reach);
        let mut before = outside::<L>(island);
        let sums = self.sums;
        // The root of a block is taken while the next one moves.
        let mut r = L::splat(0.0);
        walk(
            n,
            #[inline(always)]
            |b| sums.at::<L>(b),
            #[inline(always)]
            |b, left, right| {
                let flight = reach * L::load(&v[b]);
                let push = L::load(&mobility[b]) * (left - right);
                let at = L::load(&x[b]) + (flight + push);
                if b > 0 {
                    press(
                        &system.kernel,
                        first + b - 1,
                        [&c[b - 1], &d0[b - 1]],
                        r,
                        &mut force[b - 1],
                    );
                }
                r = at.take_left(before) - at;
                at.store(&mut positions[b]);
                before = at;
            },
        );
        press(
            &system.kernel,
            first + n - 1,
            [&c[n - 1], &d0[n - 1]],
            r,
            &mut force[n - 1],
        );
    }
}

/// Forces of a block at the excess overlaps `r`.
#[inline(always)]
fn press<K: Kernel, L: Lanes>(
    kernel: &K,
    block: usize,
    [c, d0]: [&LaneBlock; 2],
    r: L,
    force: &mut LaneBlock,
) {
    let force_there = kernel.force(WIDTH * block, L::load(c), L::load(d0), r);
    force_there.store(force);
}

/// `base + reach slope + (S_s - S_{s+1} - P_s) / m`, P the sums of forces on the sites themselves.
pub(super) struct Push<'a> {
    pub(super) mobility: &'a AlignedRow,
    pub(super) island: &'a Island,
    pub(super) base: &'a AlignedRow,
    pub(super) flight: Option<(f64, &'a AlignedRow)>,
    pub(super) sums: &'a StageSums<'a>,
    pub(super) pulls: Option<&'a StageSums<'a>>,
    pub(super) out: &'a mut AlignedRow,
}

impl SimdKernel for Push<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let island = self.island;
        let n = island.blocks.len();
        let [mobility, base] = [self.mobility, self.base].map(|row| island.of(row));
        let flight = self.flight.map(
            #[inline(always)]
            |(reach, slope)| (L::splat(reach), island.of(slope)),
        );
        let out = island.of_mut(self.out);
        let (sums, pulls) = (self.sums, self.pulls);
        walk(
            n,
            #[inline(always)]
            |b| sums.at::<L>(b),
            #[inline(always)]
            |b, left, right| {
                let mut force = left - right;
                if let Some(pulls) = pulls {
                    force = force - pulls.at::<L>(b);
                }
                let mut sum = L::load(&mobility[b]) * force;
                if let Some((reach, slope)) = flight {
                    sum = reach * L::load(&slope[b]) + sum;
                }
                (L::load(&base[b]) + sum).store(&mut out[b]);
            },
        );
    }
}

/// Forces and damping at positions and velocities; `pull` gets the drag.
pub(super) struct Damp<'a, K> {
    pub(super) system: &'a System<K>,
    pub(super) island: &'a Island,
    pub(super) x: &'a AlignedRow,
    pub(super) v: &'a AlignedRow,
    pub(super) force: &'a mut AlignedRow,
    pub(super) damping: &'a mut AlignedRow,
    pub(super) pull: &'a mut AlignedRow,
}

impl<K: Kernel> SimdKernel for Damp<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (kernel, losses) = (&self.system.kernel, self.system.losses);
        let [dashpot, tangent, drag] = [losses.dashpot, losses.tangent, losses.drag].map(L::splat);
        let [zero, one] = [0.0, 1.0].map(L::splat);
        let mut before = [outside::<L>(self.island), zero];
        for b in self.island.blocks.clone() {
            let (x, speed) = (L::load(&self.x.0[b]), L::load(&self.v.0[b]));
            let r = x.take_left(before[0]) - x;
            let closing = speed.take_left(before[1]) - speed;
            let c = L::load(&self.system.coefficient.0[b]);
            let d0 = L::load(&self.system.static_overlap.0[b]);
            let at = WIDTH * b;
            let touches = L::load(&self.system.opens.0[b]).choose(d0 + r, one);
            let closed = touches.choose(dashpot, zero);
            let damper = closed + tangent * kernel.stiffness(at, c, d0, r);
            let damping = c.choose(damper * closing, zero);
            damping.store(&mut self.damping.0[b]);
            (kernel.force(at, c, d0, r) + damping).store(&mut self.force.0[b]);
            (drag * speed).store(&mut self.pull.0[b]);
            before = [x, speed];
        }
    }
}
