//! The end of a step, in one pass over an island: velocities, errors, and blocks with possible
//! contact events.

use super::correction::NEAR;
use super::islands::Island;
use super::stage::{StageSums, walk};
use crate::numeric::lanes::{AlignedRow, LaneBlock, Lanes, SimdKernel};

/// `v1 = v + (S_s - S_{s+1} - P_s) / m`, and the error estimate likewise with its own weights.
pub(super) struct Finish<'a> {
    pub(super) mobility: &'a AlignedRow,
    pub(super) static_overlap: &'a AlignedRow,
    pub(super) island: &'a Island,
    pub(super) h: f64,
    pub(super) x: &'a AlignedRow,
    pub(super) v: &'a AlignedRow,
    pub(super) x1: &'a AlignedRow,
    /// Velocities and errors: forces, and drag where there is any.
    pub(super) sums: [&'a StageSums<'a>; 2],
    pub(super) pulls: Option<[&'a StageSums<'a>; 2]>,
    pub(super) v1: &'a mut AlignedRow,
    pub(super) error: &'a mut AlignedRow,
    /// Gets the blocks in which a contact may have opened or closed.
    pub(super) openings: &'a mut Vec<usize>,
}

impl SimdKernel for Finish<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let island = self.island;
        let (first, n) = (island.blocks.start, island.blocks.len());
        let [mobility, d0] = [self.mobility, self.static_overlap].map(|row| island.of(row));
        let [x, v, x1] = [self.x, self.v, self.x1].map(|row| island.of(row));
        let [v1, error] = [self.v1, self.error].map(|row| island.of_mut(row));
        let [velocity, estimate] = self.sums;
        let (h, reach) = (L::splat(self.h), L::splat(NEAR));
        let zero = L::splat(0.0);
        let (mut worst, mut faults) = (zero, zero);
        let mut before = [zero; 4];
        self.openings.clear();
        walk(
            n,
            #[inline(always)]
            |b| StageSums::both::<L>(velocity, estimate, b),
            #[inline(always)]
            |b, left: (L, L), right: (L, L)| {
                let mut push = (left.0 - right.0, left.1 - right.1);
                if let Some([velocity, estimate]) = self.pulls {
                    let pulls = StageSums::both::<L>(velocity, estimate, b);
                    push = (push.0 - pulls.0, push.1 - pulls.1);
                }
                let mobility = L::load(&mobility[b]);
                let off = mobility * push.1;
                off.store(&mut error[b]);
                faults = faults + off * zero;
                let off = off.abs();
                worst = (off - worst).choose(off, worst);

                let (at, speed, end) = (L::load(&x[b]), L::load(&v[b]), L::load(&x1[b]));
                let speed_end = speed + mobility * push.0;
                speed_end.store(&mut v1[b]);
                let d0 = L::load(&d0[b]);
                let start = d0 + (at.take_left(before[0]) - at);
                let closing = h * (speed.take_left(before[1]) - speed);
                let finish = d0 + (end.take_left(before[2]) - end);
                let closing_end = h * (speed_end.take_left(before[3]) - speed_end);
                before = [at, speed, end, speed_end];
                let turns = zero - closing * closing_end;
                let near = closing.abs() + closing_end.abs() - start.abs().min(finish.abs());
                let grazes = turns.choose(near, zero).positive();
                let crosses = (start * finish).choose(zero, start.positive() + finish.positive());
                let behind = (reach * closing - start).positive();
                let ahead = (zero - reach * closing_end - finish).positive();
                let nears = start.positive() * finish.positive() * (behind + ahead);
                if (crosses + grazes + nears).positive_mask() != 0 {
                    self.openings.push(first + b);
                }
            },
        );
        reduce(worst, faults)
    }
}

/// The largest magnitude; NaN where a value is not finite.
pub(super) struct Largest<'a> {
    pub(super) island: &'a Island,
    pub(super) row: &'a AlignedRow,
}

impl SimdKernel for Largest<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let (mut worst, mut faults) = (L::splat(0.0), L::splat(0.0));
        for block in self.island.of(self.row) {
            let value = L::load(block);
            faults = faults + value * L::splat(0.0);
            let value = value.abs();
            worst = (value - worst).choose(value, worst);
        }
        reduce(worst, faults)
    }
}

/// The largest lane, NaN where a fault is.
#[inline(always)]
fn reduce<L: Lanes>(worst: L, faults: L) -> f64 {
    let (mut largest, mut fault) = (LaneBlock::default(), LaneBlock::default());
    worst.store(&mut largest);
    faults.store(&mut fault);
    let largest = largest.0.iter().fold(0.0, |a: f64, b| a.max(*b));
    largest + fault.0.iter().sum::<f64>()
}
