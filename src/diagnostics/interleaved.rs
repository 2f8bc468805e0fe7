//! Sums over the bins of eight interleaved spectra, with run-time dispatch of the instruction set.
//!
//! Every lane undergoes the same operations, so that a spectrum's bits depend neither on its
//! neighbours nor on the processor.

use std::ops::Range;

use super::bins::Bins;
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, widest};
use crate::numeric::ln_normal;

/// Bins added plainly before sums are paired.
pub(super) const LEAF: usize = 32;

const NONE: LaneBlock = LaneBlock([0.0; WIDTH]);

/// A few neighbouring bins.
pub(super) struct Leaf {
    bins: Range<usize>,
    /// `sum s`
    share: LaneBlock,
    /// `c = sum s q / sum s`, of bins with a share.
    centroid: LaneBlock,
    /// `sum s (q - c)^2`
    about: LaneBlock,
}

/// `sum p` over bins.
pub(super) fn total(power: &[LaneBlock]) -> LaneBlock {
    let [sum] = pairwise(0, power.len(), &mut |from, to| {
        [(power[from..to].iter()).fold(NONE, |sum, p| sum + *p)]
    });
    sum
}

/// `sum s`, `sum s q`, `sum s^2` and `- sum s ln s` of the bins `range`, of shares `s` of `total` over bins `q`, and
/// their `leaves`; without a total they mean nothing.
pub(super) fn shares(
    (power, axis): (&[LaneBlock], &[f64]),
    range: Range<usize>,
    total: &LaneBlock,
    leaves: &mut Vec<Leaf>,
) -> [LaneBlock; 4] {
    pairwise(0, range.len(), &mut |from, to| {
        let bins = range.start + from..range.start + to;
        let (power, axis) = (&power[bins.clone()], &axis[bins.clone()]);
        let [sums @ .., centroid, about] = widest(Share { power, axis, total });
        leaves.push(Leaf {
            bins,
            share: sums[0],
            centroid,
            about,
        });
        sums
    })
}

/// `sum s (q - centroid)^2` over the bins of `leaves`: that of each about its own centroid, and of
/// these about the common one (the parallel-axis theorem), so that nothing cancels.
pub(super) fn second_moment(leaves: &[Leaf], centroid: LaneBlock) -> LaneBlock {
    let add = |sum: LaneBlock, leaf: &Leaf| {
        let distance = leaf.centroid - centroid;
        sum + (leaf.about + leaf.share * distance * distance)
    };
    let [sum] = pairwise(0, leaves.len(), &mut |from, to| {
        [leaves[from..to].iter().fold(NONE, add)]
    });
    sum
}

/// Where the cumulative share reaches each of the ascending `levels`: linear within a bin, from its
/// lower to its upper end. NaN where there are no shares.
pub(super) fn quantiles<const K: usize>(
    (power, bins): (&[LaneBlock], &Bins),
    total: &LaneBlock,
    leaves: &[Leaf],
    levels: [f64; K],
) -> [[f64; WIDTH]; K] {
    let mut found = [[f64::NAN; WIDTH]; K];
    let mut below = NONE;
    for leaf in leaves {
        let through = below + leaf.share;
        for (level, found) in levels.iter().zip(&mut found) {
            for (i, found) in found.iter_mut().enumerate() {
                if below.0[i] < *level && through.0[i] >= *level {
                    let shares = power[leaf.bins.clone()].iter();
                    let shares = shares.map(|power| power.0[i] / total.0[i]);
                    *found = bins.reached(leaf.bins.start, shares, *level - below.0[i]);
                }
            }
        }
        below = through;
    }
    found
}

/// Sums over `from .. to`: of leaves, taken in order, in a tree that depends on the length alone.
fn pairwise<const K: usize>(
    from: usize,
    to: usize,
    leaf: &mut impl FnMut(usize, usize) -> [LaneBlock; K],
) -> [LaneBlock; K] {
    if to == from {
        return [NONE; K];
    }
    if to - from <= LEAF {
        return leaf(from, to);
    }
    let half = ((to - from) / 2).next_multiple_of(LEAF);
    let a = pairwise(from, from + half, leaf);
    let b = pairwise(from + half, to, leaf);
    std::array::from_fn(|k| a[k] + b[k])
}

/// At most [`LEAF`] bins.
struct Share<'a> {
    power: &'a [LaneBlock],
    axis: &'a [f64],
    total: &'a LaneBlock,
}

impl SimdKernel for Share<'_> {
    /// `sum s`, `sum s q`, `sum s^2`, `- sum s ln s`, the centroid and `sum s (q - centroid)^2`.
    type Output = [LaneBlock; 6];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [LaneBlock; 6] {
        let zero = L::splat(0.0);
        let total = L::load(self.total);
        let (mut share, mut first, mut square) = (zero, zero, zero);
        let mut shares = [LaneBlock::default(); LEAF];
        let mut logarithms = [LaneBlock::default(); LEAF];
        let shares = &mut shares[..self.axis.len()];
        let logarithms = &mut logarithms[..self.axis.len()];
        let to = shares.iter_mut().zip(&mut *logarithms);
        for ((power, &q), (kept, to)) in self.power.iter().zip(self.axis).zip(to) {
            let s = L::load(power) / total;
            s.store(kept);
            s.store(to);
            share = share + s;
            first = first + s * L::splat(q);
            square = square + s * s;
        }
        let numbers: &mut [f64] = bytemuck::cast_slice_mut(logarithms);
        // Zero and subnormal shares contribute nothing, so the value of the logarithm does not
        // matter.
        numbers.iter_mut().for_each(|s| *s = ln_normal(*s));
        let centroid = share.choose(first / share, zero);
        let (mut entropy, mut about) = (zero, zero);
        for ((s, logarithm), &q) in shares.iter().zip(logarithms).zip(self.axis) {
            let s = L::load(s);
            let distance = L::splat(q) - centroid;
            entropy = entropy - s * L::load(logarithm);
            about = about + s * distance * distance;
        }
        [share, first, square, entropy, centroid, about].map(|sum| {
            let mut block = NONE;
            sum.store(&mut block);
            block
        })
    }
}
