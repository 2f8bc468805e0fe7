//! Sums whose rounding does not grow with their length: pairwise, in a fixed order.

use std::array::from_fn;

/// Terms added plainly before sums are paired; large enough to vectorise.
const LEAF: usize = 256;
const LANES: usize = 8;

/// `sum x_i`, relative error about `eps (LEAF / LANES + log2(n / LEAF))` of `sum |x_i|`.
pub(crate) fn sum(x: &[f64]) -> f64 {
    let [sum] = fold(x.as_chunks().0, &|_, v| v);
    sum
}

/// [`sum`] of terms as they come.
pub(crate) fn sum_of(terms: impl Iterator<Item = f64>) -> f64 {
    sum(&terms.collect::<Vec<f64>>())
}

/// `sum x_i^2`, with the same bound.
pub(crate) fn sum_of_squares(x: &[f64]) -> f64 {
    let [sum] = fold(x.as_chunks().0, &|_, v| v * v);
    sum
}

/// [`sum_of_squares`] of each column of `rows`, which have `width` numbers each, with the same
/// bits.
pub(crate) fn interleaved_sums_of_squares(rows: &[f64], width: usize, sums: &mut Vec<f64>) {
    sums.clear();
    let column = |c| -> Vec<f64> { rows.iter().skip(c).step_by(width).copied().collect() };
    match width {
        1 => sums.push(sum_of_squares(rows)),
        8 => sums.extend(squares_across(rows.as_chunks().0, &[0.0; 8])),
        _ => sums.extend((0..width).map(|c| sum_of_squares(&column(c)))),
    }
}

/// [`sum`] of each of eight columns less an offset, with the same bits.
pub(crate) fn sums_across(rows: &[[f64; 8]], offsets: &[f64; 8]) -> [f64; 8] {
    fold(rows, &|c, v| v - offsets[c])
}

/// [`sum_of_squares`] of each of eight columns less an offset, with the same bits.
pub(crate) fn squares_across(rows: &[[f64; 8]], offsets: &[f64; 8]) -> [f64; 8] {
    fold(rows, &|c, v| (v - offsets[c]) * (v - offsets[c]))
}

/// Sums of the terms of each column. The tree depends on the number of rows alone.
fn fold<const W: usize>(rows: &[[f64; W]], term: &impl Fn(usize, f64) -> f64) -> [f64; W] {
    if rows.len() > LEAF {
        // Halves of whole leaves.
        let half = (rows.len() / 2).next_multiple_of(LEAF);
        let (a, b) = rows.split_at(half);
        let (a, b) = (fold(a, term), fold(b, term));
        return from_fn(|c| a[c] + b[c]);
    }
    let add = |sum: &mut [f64; W], row: &[f64; W]| {
        for c in 0..W {
            sum[c] += term(c, row[c]);
        }
    };
    let mut lanes = [[0.0; W]; LANES];
    let (chunks, rest) = rows.as_chunks::<LANES>();
    for chunk in chunks {
        lanes
            .iter_mut()
            .zip(chunk)
            .for_each(|(lane, row)| add(lane, row));
    }
    let mut tail = [0.0; W];
    rest.iter().for_each(|row| add(&mut tail, row));
    let [a, b, c, d, e, f, g, h] = lanes;
    from_fn(|i| (((a[i] + e[i]) + (b[i] + f[i])) + ((c[i] + g[i]) + (d[i] + h[i]))) + tail[i])
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
        for (width, n) in [(1, 300), (3, 257), (8, 0), (8, 7), (8, 256), (8, 4099)] {
            let rows: Vec<f64> = (0..n * width).map(|i| (i as f64).sin()).collect();
            let column =
                |c: usize| -> Vec<f64> { rows.iter().skip(c).step_by(width).copied().collect() };
            let alone: Vec<f64> = (0..width).map(|c| sum_of_squares(&column(c))).collect();
            let mut sums = Vec::new();
            interleaved_sums_of_squares(&rows, width, &mut sums);
            assert_eq!(sums, alone, "{n} {width}");
            let offsets = [0.3; 8];
            for (c, found) in sums_across(rows.as_chunks().0, &offsets)
                .into_iter()
                .enumerate()
            {
                let less: Vec<f64> = column(c).iter().map(|v| v - 0.3).collect();
                assert!(width < 8 || found == sum(&less), "{n}");
            }
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
