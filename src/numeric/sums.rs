//! Sums whose rounding does not grow with their length: pairwise, in a fixed order.

use crate::numeric::lanes::{Lanes, SimdKernel, WIDTH, widest};

/// Terms added plainly before sums are paired; large enough to vectorise.
const LEAF: usize = 256;
const LANES: usize = WIDTH;

/// `sum x_i`, relative error about `eps (LEAF / LANES + log2(n / LEAF))` of `sum |x_i|`.
pub(crate) fn sum(x: &[f64]) -> f64 {
    fold(x, &|v| v)
}

/// [`sum`] of terms as they come.
pub(crate) fn sum_of(terms: impl Iterator<Item = f64>) -> f64 {
    sum(&terms.collect::<Vec<f64>>())
}

/// `sum x_i^2`, with the same bound.
pub(crate) fn sum_of_squares(x: &[f64]) -> f64 {
    fold(x, &|v| v * v)
}

/// [`sum_of_squares`] of each column of `rows`, which have `width` numbers each, with the same
/// bits.
pub(crate) fn interleaved_sums_of_squares(rows: &[f64], width: usize, sums: &mut Vec<f64>) {
    sums.clear();
    let column = |c| -> Vec<f64> { rows.iter().skip(c).step_by(width).copied().collect() };
    match width {
        1 => sums.push(sum_of_squares(rows)),
        LANES => sums.extend(squares_across(rows.as_chunks().0, &[0.0; LANES])),
        _ => sums.extend((0..width).map(|c| sum_of_squares(&column(c)))),
    }
}

/// [`sum`] of each of eight columns less an offset, with the same bits.
pub(crate) fn sums_across(rows: &[[f64; LANES]], offsets: &[f64; LANES]) -> [f64; LANES] {
    across::<false>(rows, offsets)
}

/// [`sum_of_squares`] of each of eight columns less an offset, with the same bits.
pub(crate) fn squares_across(rows: &[[f64; LANES]], offsets: &[f64; LANES]) -> [f64; LANES] {
    across::<true>(rows, offsets)
}

/// The tree of [`fold`] for eight columns at once.
fn across<const SQUARES: bool>(rows: &[[f64; LANES]], offsets: &[f64; LANES]) -> [f64; LANES] {
    if rows.len() > LEAF {
        let half = (rows.len() / 2).next_multiple_of(LEAF);
        let (a, b) = rows.split_at(half);
        let (a, b) = (across::<SQUARES>(a, offsets), across::<SQUARES>(b, offsets));
        return std::array::from_fn(|c| a[c] + b[c]);
    }
    widest(Leaf::<SQUARES>(rows, offsets))
}

struct Leaf<'a, const SQUARES: bool>(&'a [[f64; LANES]], &'a [f64; LANES]);

impl<const SQUARES: bool> Leaf<'_, SQUARES> {
    #[inline(always)]
    fn add<L: Lanes>(sum: L, row: &[f64; LANES], offset: L) -> L {
        let v = L::read(row) - offset;
        sum + if SQUARES { v * v } else { v }
    }
}

impl<const SQUARES: bool> SimdKernel for Leaf<'_, SQUARES> {
    type Output = [f64; LANES];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [f64; LANES] {
        let (zero, offset) = (L::splat(0.0), L::read(self.1));
        let mut lanes = [zero; LANES];
        let (chunks, rest) = self.0.as_chunks::<LANES>();
        for chunk in chunks {
            for (lane, row) in lanes.iter_mut().zip(chunk) {
                *lane = Self::add(*lane, row, offset);
            }
        }
        let mut tail = zero;
        for row in rest {
            tail = Self::add(tail, row, offset);
        }
        let [a, b, c, d, e, f, g, h] = lanes;
        let mut sums = [0.0; LANES];
        ((((a + e) + (b + f)) + ((c + g) + (d + h))) + tail).write(&mut sums);
        sums
    }
}

fn fold(x: &[f64], term: &impl Fn(f64) -> f64) -> f64 {
    if x.len() <= LEAF {
        return fold_leaf(x, term);
    }
    // Halves of whole leaves: the tree depends on the length alone.
    let half = (x.len() / 2).next_multiple_of(LEAF);
    let (a, b) = x.split_at(half);
    fold(a, term) + fold(b, term)
}

fn fold_leaf(x: &[f64], term: &impl Fn(f64) -> f64) -> f64 {
    let mut lanes = [0.0; LANES];
    let chunks = x.chunks_exact(LANES);
    let tail = chunks.remainder();
    for chunk in chunks {
        for (lane, &v) in lanes.iter_mut().zip(chunk) {
            *lane += term(v);
        }
    }
    let tail: f64 = tail.iter().map(|&v| term(v)).sum();
    let [a, b, c, d, e, f, g, h] = lanes;
    (((a + e) + (b + f)) + ((c + g) + (d + h))) + tail
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_integers_exactly_at_every_length() {
        for n in 0..2000 {
            let x: Vec<f64> = (1..=n).map(f64::from).collect();
            let n = f64::from(n);
            assert_eq!(sum(&x), n * (n + 1.0) / 2.0);
            assert_eq!(sum_of_squares(&x), n * (n + 1.0) * (2.0 * n + 1.0) / 6.0);
        }
    }

    #[test]
    fn columns_side_by_side_have_the_bits_of_each_alone() {
        for (width, n) in [1, 3, 8].into_iter().flat_map(|width| {
            let lengths = [0, 1, 7, 8, 255, 256, 257, 300, 1000, 4099];
            lengths.map(move |n| (width, n))
        }) {
            let rows: Vec<f64> = (0..n * width).map(|i| (i as f64).sin()).collect();
            let mut sums = Vec::new();
            interleaved_sums_of_squares(&rows, width, &mut sums);
            for (c, sum) in sums.iter().enumerate() {
                let column: Vec<f64> = rows.iter().skip(c).step_by(width).copied().collect();
                let alone = sum_of_squares(&column);
                assert_eq!(sum.to_bits(), alone.to_bits(), "{n} {width}");
            }
        }
        let row = |n: u32| std::array::from_fn(|c| (f64::from(n) * 0.3 + c as f64).sin());
        let rows: Vec<[f64; 8]> = (0..777).map(row).collect();
        let offsets = std::array::from_fn(|c| 0.1 * c as f64);
        let sums = sums_across(&rows, &offsets);
        let squares = squares_across(&rows, &offsets);
        for c in 0..8 {
            let column: Vec<f64> = rows.iter().map(|row| row[c] - offsets[c]).collect();
            assert_eq!(sums[c].to_bits(), sum(&column).to_bits());
            assert_eq!(squares[c].to_bits(), sum_of_squares(&column).to_bits());
        }
    }

    /// Equal leaves round alike, which is the worst case: 32 additions per lane, of which the first
    /// few are inexact.
    #[test]
    fn rounding_stays_near_epsilon_over_a_million_terms() {
        let x = vec![0.1; 1_000_000];
        // A million times the double nearest 0.1 is 1e5 (1 + 5.55e-17).
        let error = sum(&x) / 1e5 - 1.0;
        assert!(error.abs() < 2e-15, "{error:e}");
    }
}
