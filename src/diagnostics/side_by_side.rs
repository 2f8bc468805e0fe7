//! Sums over the bins of eight spectra side by side, in the widest registers there are.
//!
//! Every lane undergoes the same operations, so that a spectrum's bits depend neither on its
//! neighbours nor on the processor.

use crate::chain::lanes::{Block, Lanes, WIDTH, Work, widest};
use crate::logarithm::ln_normal;

/// Bins added plainly before sums are paired.
const LEAF: usize = 32;

/// Of shares `s` over bins `q`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shares {
    /// `sum s`
    pub share: [f64; WIDTH],
    /// `sum s q`
    pub first_moment: [f64; WIDTH],
    /// `sum s^2`
    pub square: [f64; WIDTH],
    /// `- sum s ln s`
    pub entropy: [f64; WIDTH],
}

/// Of shares about their centroid.
pub(super) struct Spread {
    /// `sum s (q - centroid)^2` without the first bin.
    pub second_moment: [f64; WIDTH],
    /// The first bin at which the cumulative share reaches a half.
    pub median: [f64; WIDTH],
    pub quantile_90: [f64; WIDTH],
}

/// `sum p` over bins.
pub(super) fn total(power: &[Block]) -> [f64; WIDTH] {
    let leaf = &mut |from, to| [widest(Total(&power[from..to])).0];
    pairwise(0, power.len(), leaf)[0]
}

/// Turns `power` into shares of `total`; without a total they mean nothing.
pub(super) fn shares(power: &mut [Block], axis: &[f64], total: &[f64; WIDTH]) -> Shares {
    let total = Block(*total);
    let leaf = &mut |from, to| {
        widest(Share {
            power: &mut power[from..to],
            axis: &axis[from..to],
            total,
        })
        .map(|sum| sum.0)
    };
    let [share, first_moment, square, entropy] = pairwise(0, axis.len(), leaf);
    Shares {
        share,
        first_moment,
        square,
        entropy,
    }
}

/// Of the shares that [`shares`] left.
pub(super) fn spread(share: &[Block], axis: &[f64], centroid: &[f64; WIDTH]) -> Spread {
    let mut below = share[0].0;
    let mut levels = [0.5, 0.9].map(|level| {
        let found = below.map(|share| {
            if share >= level {
                axis[0]
            } else {
                axis[axis.len() - 1]
            }
        });
        (level, found)
    });
    let leaf = &mut |from: usize, to: usize| {
        let (share, axis) = (&share[1 + from..1 + to], &axis[1 + from..1 + to]);
        let [sum, second] = widest(About {
            share,
            axis,
            centroid: Block(*centroid),
        });
        let through: [f64; WIDTH] = std::array::from_fn(|i| below[i] + sum.0[i]);
        for (level, found) in &mut levels {
            for (i, found) in found.iter_mut().enumerate() {
                if below[i] < *level && through[i] >= *level {
                    *found = quantile(share, axis, i, below[i], *level);
                }
            }
        }
        below = through;
        [second.0]
    };
    let [second_moment] = pairwise(0, axis.len() - 1, leaf);
    let [(_, median), (_, quantile_90)] = levels;
    Spread {
        second_moment,
        median,
        quantile_90,
    }
}

/// The bin of lane `i` at which `below` and the shares up to it reach `level`; the last of these bins
/// where only their sum does.
fn quantile(share: &[Block], axis: &[f64], i: usize, below: f64, level: f64) -> f64 {
    let mut cumulative = below;
    let reaches = share.iter().position(|share| {
        cumulative += share.0[i];
        cumulative >= level
    });
    axis[reaches.unwrap_or(axis.len() - 1)]
}

/// Sums over `from .. to`: of leaves, taken in order, in a tree that depends on the length alone.
fn pairwise<const K: usize>(
    from: usize,
    to: usize,
    leaf: &mut impl FnMut(usize, usize) -> [[f64; WIDTH]; K],
) -> [[f64; WIDTH]; K] {
    if to - from <= LEAF {
        return leaf(from, to);
    }
    let half = ((to - from) / 2).next_multiple_of(LEAF);
    let a = pairwise(from, from + half, leaf);
    let b = pairwise(from + half, to, leaf);
    std::array::from_fn(|k| std::array::from_fn(|i| a[k][i] + b[k][i]))
}

struct Total<'a>(&'a [Block]);

impl Work for Total<'_> {
    type Output = Block;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Block {
        let mut sum = L::splat(0.0);
        for power in self.0 {
            sum = sum + L::load(power);
        }
        stored(sum)
    }
}

struct Share<'a> {
    power: &'a mut [Block],
    axis: &'a [f64],
    total: Block,
}

impl Work for Share<'_> {
    type Output = [Block; 4];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Block; 4] {
        let zero = L::splat(0.0);
        let total = L::load(&self.total);
        let (mut share, mut first, mut square, mut entropy) = (zero, zero, zero, zero);
        let mut logarithms = [Block::default(); LEAF];
        let logarithms = &mut logarithms[..self.axis.len()];
        for ((power, &q), to) in self.power.iter_mut().zip(self.axis).zip(&mut *logarithms) {
            let s = L::load(power) / total;
            s.store(power);
            s.store(to);
            share = share + s;
            first = first + s * L::splat(q);
            square = square + s * s;
        }
        let numbers: &mut [f64] = bytemuck::cast_slice_mut(logarithms);
        // Shares of 0, and below the normal numbers, add nothing, whatever number this makes of them.
        numbers.iter_mut().for_each(|s| *s = ln_normal(*s));
        for (power, logarithm) in self.power.iter().zip(logarithms) {
            entropy = entropy - L::load(power) * L::load(logarithm);
        }
        [
            stored(share),
            stored(first),
            stored(square),
            stored(entropy),
        ]
    }
}

struct About<'a> {
    share: &'a [Block],
    axis: &'a [f64],
    centroid: Block,
}

impl Work for About<'_> {
    type Output = [Block; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Block; 2] {
        let centroid = L::load(&self.centroid);
        let (mut sum, mut second) = (L::splat(0.0), L::splat(0.0));
        for (share, &q) in self.share.iter().zip(self.axis) {
            let s = L::load(share);
            let distance = L::splat(q) - centroid;
            sum = sum + s;
            second = second + s * distance * distance;
        }
        [stored(sum), stored(second)]
    }
}

#[inline(always)]
fn stored<L: Lanes>(lanes: L) -> Block {
    let mut block = Block::default();
    lanes.store(&mut block);
    block
}
