//! Sums of powers of increments, and what they give with its interval.

use crate::numeric::lanes::{Lanes, SimdKernel, WIDTH, widest};

/// The highest order.
pub const ORDERS: usize = 6;
/// Count, sums of `|d|^1` to `|d|^6`, of `d^3`, the increments that are not 0, and two for the local flatness.
pub(super) type Sums = [f64; ORDERS + 5];
/// Sum of `d^3`.
const SIGNED: usize = ORDERS + 1;
/// Increments that are not 0.
pub(super) const MOVED: usize = ORDERS + 2;
/// Numerator and denominator of the local flatness.
pub(super) const LOCAL: [usize; 2] = [ORDERS + 3, ORDERS + 4];
/// Orders 1 to 6, the third moment with its sign, flatness, skewness, local flatness.
pub(super) const STATISTICS: usize = ORDERS + 4;
/// Increments that are summed plainly before sums are paired.
const LEAF: usize = 256;

/// Sums of powers, paired so that their rounding does not grow with their number; the tree depends on the
/// number of leaves alone.
#[derive(Debug, Clone, Default)]
pub(super) struct PowerSums {
    /// Sums of `2^level` leaves each, the levels descending.
    stack: Vec<(u32, Sums)>,
}

impl PowerSums {
    /// Adds the increments `b - a` that are finite.
    pub fn add(&mut self, a: &[f64], b: &[f64]) {
        for (a, b) in a.chunks(LEAF).zip(b.chunks(LEAF)) {
            self.join(widest(Leaf(a, b)));
        }
    }

    /// Adds the total of other sums.
    pub fn join(&mut self, mut sums: Sums) {
        let mut level = 0;
        while let Some((top, before)) = self.stack.last()
            && *top == level
        {
            sums = added(before, &sums);
            level += 1;
            self.stack.pop();
        }
        self.stack.push((level, sums));
    }

    pub fn total(&self) -> Sums {
        let from_last = self.stack.iter().rev();
        from_last.fold(Sums::default(), |sum, (_, part)| added(part, &sum))
    }
}

pub(super) fn added(a: &Sums, b: &Sums) -> Sums {
    std::array::from_fn(|i| a[i] + b[i])
}

/// What sums say of one scale.
pub(super) fn statistics(sums: &Sums) -> [f64; STATISTICS] {
    let mean = |i: usize| sums[i] / sums[0];
    let mut found = std::array::from_fn(|p| mean(p + 1));
    found[ORDERS] = mean(SIGNED);
    found[ORDERS + 1] = mean(4) / (mean(2) * mean(2));
    found[ORDERS + 2] = mean(SIGNED) / mean(2).powf(1.5);
    found[ORDERS + 3] = sums[LOCAL[0]] / sums[LOCAL[1]];
    found
}

struct Leaf<'a>(&'a [f64], &'a [f64]);

impl SimdKernel for Leaf<'_> {
    type Output = Sums;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Sums {
        let mut sums = [[0.0; WIDTH]; ORDERS + 5];
        let (a, a_rest) = self.0.as_chunks::<WIDTH>();
        let (b, b_rest) = self.1.as_chunks::<WIDTH>();
        for (a, b) in a.iter().zip(b) {
            add_block(&mut sums, a, b);
        }
        if !a_rest.is_empty() {
            // What is not there counts as missing.
            let (mut a, mut b) = ([f64::NAN; WIDTH], [f64::NAN; WIDTH]);
            a[..a_rest.len()].copy_from_slice(a_rest);
            b[..b_rest.len()].copy_from_slice(b_rest);
            add_block(&mut sums, &a, &b);
        }
        sums.map(|[a, b, c, d, e, f, g, h]| ((a + e) + (b + f)) + ((c + g) + (d + h)))
    }
}

#[inline(always)]
fn add_block(sums: &mut [[f64; WIDTH]; ORDERS + 5], a: &[f64; WIDTH], b: &[f64; WIDTH]) {
    for i in 0..WIDTH {
        let d = b[i] - a[i];
        let is_there = d.abs() < f64::INFINITY;
        let d = if is_there { d } else { 0.0 };
        let size = d.abs();
        let square = d * d;
        let cube = square * size;
        sums[0][i] += if is_there { 1.0 } else { 0.0 };
        sums[1][i] += size;
        sums[2][i] += square;
        sums[3][i] += cube;
        sums[4][i] += square * square;
        sums[5][i] += square * cube;
        sums[6][i] += cube * cube;
        sums[SIGNED][i] += square * d;
        sums[MOVED][i] += if d == 0.0 { 0.0 } else { 1.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_stays_near_epsilon_over_a_million_terms() {
        let (a, b) = (vec![0.0; 1_000_000], vec![0.1; 1_000_000]);
        let mut sums = PowerSums::default();
        sums.add(&a, &b);
        assert!((sums.total()[1] / 1e5 - 1.0).abs() < 2e-15);
    }
}
