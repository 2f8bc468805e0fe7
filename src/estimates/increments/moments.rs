//! Sums of powers of increments.

use crate::numeric::lanes::{Lanes, SimdKernel, WIDTH, widest};

/// The highest order.
pub const ORDERS: usize = 6;
/// Count, sums of `|d|^1` to `|d|^6`, and of `d^3`.
pub(super) const SUMS: usize = ORDERS + 2;
/// Sum of `d^3`.
pub(super) const SIGNED: usize = ORDERS + 1;
/// Increments that are summed plainly before sums are paired.
const LEAF: usize = 256;

/// Sums of powers, paired so that their rounding does not grow with their number; the tree depends on the
/// number of leaves alone.
#[derive(Debug, Clone, Default)]
pub(super) struct PowerSums {
    /// Sums of `2^level` leaves each, the levels descending.
    stack: Vec<(u32, [f64; SUMS])>,
}

impl PowerSums {
    /// Adds the increments `b - a` that are finite.
    pub fn add(&mut self, a: &[f64], b: &[f64]) {
        for (a, b) in a.chunks(LEAF).zip(b.chunks(LEAF)) {
            self.push(0, widest(Leaf(a, b)));
        }
    }

    /// Adds the total of other sums.
    pub fn join(&mut self, total: &[f64; SUMS]) {
        self.push(0, *total);
    }

    fn push(&mut self, level: u32, sums: [f64; SUMS]) {
        let (mut level, mut sums) = (level, sums);
        while let Some((top, before)) = self.stack.last()
            && *top == level
        {
            sums = added(before, &sums);
            level += 1;
            self.stack.pop();
        }
        self.stack.push((level, sums));
    }

    pub fn total(&self) -> [f64; SUMS] {
        let from_last = self.stack.iter().rev();
        from_last.fold([0.0; SUMS], |sum, (_, part)| added(part, &sum))
    }
}

pub(super) fn added(a: &[f64; SUMS], b: &[f64; SUMS]) -> [f64; SUMS] {
    std::array::from_fn(|i| a[i] + b[i])
}

struct Leaf<'a>(&'a [f64], &'a [f64]);

impl SimdKernel for Leaf<'_> {
    type Output = [f64; SUMS];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [f64; SUMS] {
        let mut sums = [[0.0; WIDTH]; SUMS];
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
fn add_block(sums: &mut [[f64; WIDTH]; SUMS], a: &[f64; WIDTH], b: &[f64; WIDTH]) {
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
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_integers_exactly_and_leaves_out_what_is_missing() {
        for n in [0usize, 1, 7, 8, 9, 256, 300, 5000] {
            let a: Vec<f64> = (0..n)
                .map(|i| if i % 7 == 3 { f64::NAN } else { 0.0 })
                .collect();
            let b: Vec<f64> = (0..n).map(|i| (i % 5) as f64 - 1.0).collect();
            let mut sums = PowerSums::default();
            sums.add(&a, &b);
            let there = (0..n).filter(|i| i % 7 != 3).map(|i| (i % 5) as f64 - 1.0);
            let sum = |of: fn(f64) -> f64| there.clone().map(of).sum::<f64>();
            let expected = [
                sum(|_| 1.0),
                sum(f64::abs),
                sum(|d| d * d),
                sum(|d| (d * d * d).abs()),
                sum(|d| d.powi(4)),
                sum(|d| d.powi(5).abs()),
                sum(|d| d.powi(6)),
                sum(|d| d.powi(3)),
            ];
            assert_eq!(sums.total(), expected, "{n}");
        }
    }

    #[test]
    fn rounding_stays_near_epsilon_over_a_million_terms() {
        let (a, b) = (vec![0.0; 1_000_000], vec![0.1; 1_000_000]);
        let mut sums = PowerSums::default();
        sums.add(&a, &b);
        assert!((sums.total()[1] / 1e5 - 1.0).abs() < 2e-15);
    }
}
