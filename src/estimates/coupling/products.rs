//! Sums of products of three transforms over realisations.
//!
//! A few rows of triples go through all realisations while their sums are in cache.

use rayon::prelude::*;

use super::spectra::{Evenness, Spectra, Spectrum};
use super::triples::{TripleRow, Triples};
use crate::numeric::lanes::{Lanes, SimdKernel, WIDTH, widest};

/// Sums over realisations.
#[derive(Debug, Clone)]
pub(super) struct TripleSums {
    /// Of real and imaginary part of `X1 X2 X3*`, and of `|X1 X2|^2`, a cell a triple.
    products: [Vec<f64>; 3],
    /// Of `|X1|^2` and of `|X3|^2`, a bin each.
    powers: [Vec<f64>; 2],
    pub evenness: Evenness,
}

/// Sums of products of some triples.
type Kinds<'a> = [&'a mut [f64]; 3];

/// The first cells of all kinds, which keep the others.
#[inline(always)]
fn split_off<'a>(kinds: &mut Kinds<'a>, cells: usize) -> Kinds<'a> {
    kinds
        .each_mut()
        .map(|kind| kind.split_off_mut(..cells).unwrap_or_default())
}

/// Power of a bin over that of the strongest, below which it holds only rounding.
pub(super) const LEAST_POWER: f64 = 1e-24;

impl TripleSums {
    pub fn zeros(triples: &Triples) -> TripleSums {
        TripleSums {
            products: [(); 3].map(|()| vec![0.0; triples.cells()]),
            powers: [(); 2].map(|()| vec![0.0; triples.last + 1]),
            evenness: Evenness::zeros(triples.last),
        }
    }

    pub fn bytes(triples: &Triples) -> u64 {
        8 * (3 * triples.cells() + 2 * (triples.last + 1)) as u64
    }

    /// The least power of a bin that is known, of the first and of the third kind.
    pub fn least(&self) -> [f64; 2] {
        // Bin 0 has no power left once its mean is removed, and is in no triple.
        let largest = |powers: &[f64]| powers[1..].iter().fold(0.0, |m: f64, p| m.max(*p));
        self.powers
            .each_ref()
            .map(|powers| LEAST_POWER * largest(powers))
    }

    /// Bicoherence of a cell, NaN where a bin has no power.
    pub fn bicoherence(&self, cell: usize, bins: [isize; 3], least: [f64; 2]) -> f64 {
        let [first, second, third] = bins.map(isize::unsigned_abs);
        let [inputs, outputs] = &self.powers;
        let lower = inputs[first].min(inputs[second]);
        if !(lower > least[0] && outputs[third] > least[1]) {
            return f64::NAN;
        }
        // In an order in which no product leaves the range of numbers.
        let [re, im, pairs] = self.products.each_ref().map(|sums| sums[cell]);
        let size = re.hypot(im);
        let found = (size / pairs) * (size / outputs[third]);
        // `min` would make 1 of what is no number.
        if found > 1.0 { 1.0 } else { found }
    }

    /// Phase of the sum of a cell.
    pub fn biphase(&self, cell: usize) -> f64 {
        let [re, im, _] = &self.products;
        im[cell].atan2(re[cell])
    }
}

/// Rows whose sums are in cache together. The transforms of [`AT_ONCE`] realisations are read once for all.
const ROWS: usize = 16;

/// Realisations whose products are summed before they are written.
const AT_ONCE: usize = 4;

/// Adds the products of all realisations of `x`, whose pairs are multiplied, and of `z` to the sums; rows in parallel where
/// that is wished.
pub(super) fn add_products(
    triples: &Triples,
    [x, z]: [&Spectra; 2],
    sums: &mut TripleSums,
    is_parallel: bool,
) {
    for (spectra, powers) in [x, z].into_iter().zip(&mut sums.powers) {
        spectra.add_power(powers);
    }
    sums.evenness.add(x, z);
    let mut all: Kinds<'_> = sums.products.each_mut().map(|sums| &mut sums[..]);
    let mut groups = Vec::with_capacity(triples.rows.len().div_ceil(ROWS));
    for rows in triples.rows.chunks(ROWS) {
        let cells = rows.iter().map(|row| row.first.len()).sum();
        groups.push((rows, split_off(&mut all, cells)));
    }
    // In one piece where other threads are at work already.
    let least = if is_parallel { 1 } else { groups.len().max(1) };
    let groups = groups.into_par_iter().with_min_len(least);
    groups.for_each(|(rows, sums)| widest(AddProducts { rows, sums, x, z }));
}

/// Adds the products of all realisations in some rows.
struct AddProducts<'a> {
    rows: &'a [TripleRow],
    sums: Kinds<'a>,
    x: &'a Spectra,
    z: &'a Spectra,
}

impl SimdKernel for AddProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self) {
        let (mut from, count) = (0, self.x.count());
        while from < count {
            let is_full = count - from >= AT_ONCE;
            let mut kinds = self.sums.each_mut().map(|kind| &mut **kind);
            for row in self.rows {
                let own = split_off(&mut kinds, row.first.len());
                match is_full {
                    true => add_row::<L, AT_ONCE>((row, from), own, self.x, self.z),
                    false => add_row::<L, 1>((row, from), own, self.x, self.z),
                }
            }
            from += if is_full { AT_ONCE } else { 1 };
        }
    }
}

/// Adds the products of a row in `R` realisations from one on.
#[inline(always)]
fn add_row<L: Lanes, const R: usize>(
    (row, from): (&TripleRow, usize),
    [re, im, pairs]: Kinds<'_>,
    x: &Spectra,
    z: &Spectra,
) {
    let blocks = re.len().div_ceil(WIDTH);
    let mut factors = [Factors::<L>::of(row, blocks, x.get(from), z.get(from)); R];
    for (r, factors) in factors.iter_mut().enumerate().skip(1) {
        *factors = Factors::of(row, blocks, x.get(from + r), z.get(from + r));
    }
    let (re, re_tail) = re.as_chunks_mut();
    let (im, im_tail) = im.as_chunks_mut();
    let (pairs, pairs_tail) = pairs.as_chunks_mut();
    for (b, ((re, im), pairs)) in re.iter_mut().zip(im).zip(pairs).enumerate() {
        add_block(b, &factors, [re, im, pairs]);
    }
    if !re_tail.is_empty() {
        let mut tail = [[0.0; WIDTH]; 3];
        let parts = [re_tail, im_tail, pairs_tail];
        for (tail, part) in tail.iter_mut().zip(&parts) {
            tail[..part.len()].copy_from_slice(part);
        }
        add_block(blocks - 1, &factors, tail.each_mut());
        for (tail, part) in tail.iter().zip(parts) {
            part.copy_from_slice(&tail[..part.len()]);
        }
    }
}

/// Adds the products of some realisations in a block of a row, which are summed before they are added.
#[inline(always)]
fn add_block<L: Lanes, const R: usize>(
    b: usize,
    factors: &[Factors<'_, L>; R],
    sums: [&mut [f64; WIDTH]; 3],
) {
    let mut products = factors[0].products(b);
    for others in &factors[1..] {
        for (product, other) in products.iter_mut().zip(others.products(b)) {
            *product = *product + other;
        }
    }
    for (sum, product) in sums.into_iter().zip(products) {
        (L::read(sum) + product).write(sum);
    }
}

/// What is multiplied in one realisation of a row.
#[derive(Clone, Copy)]
struct Factors<'s, L> {
    /// The transform at the second frequency, and its power.
    re: L,
    im: L,
    power: L,
    /// Transforms at the first frequencies, and their powers.
    x: [&'s [[f64; WIDTH]]; 3],
    /// Transforms at the third.
    z: [&'s [[f64; WIDTH]]; 2],
}

impl<'s, L: Lanes> Factors<'s, L> {
    #[inline(always)]
    fn of(row: &TripleRow, blocks: usize, x: Spectrum<'s>, z: Spectrum<'s>) -> Self {
        let (first, size) = (row.first.start, row.second.unsigned_abs());
        let third = first.wrapping_add_signed(row.second);
        // The transform at -f is the conjugate of that at f.
        let sign = if row.second < 0 { -1.0 } else { 1.0 };
        Factors {
            re: L::splat(x.re[size]),
            im: L::splat(sign * x.im[size]),
            power: L::splat(x.power[size]),
            x: [x.re, x.im, x.power].map(|x| blocks_from(x, first, blocks)),
            z: [z.re, z.im].map(|z| blocks_from(z, third, blocks)),
        }
    }

    /// `X1 X2 X3*`, real and imaginary part, and `|X1 X2|^2` of a block.
    #[inline(always)]
    fn products(&self, b: usize) -> [L; 3] {
        let zero = L::splat(0.0);
        let (x_re, x_im) = (L::read(&self.x[0][b]), L::read(&self.x[1][b]));
        let (z_re, z_im) = (L::read(&self.z[0][b]), L::read(&self.z[1][b]));
        let p_re = x_re.fused(self.re, zero - x_im * self.im);
        let p_im = x_re.fused(self.im, x_im * self.re);
        [
            p_im.fused(z_im, p_re * z_re),
            (zero - p_re).fused(z_im, p_im * z_re),
            L::read(&self.x[2][b]) * self.power,
        ]
    }
}

/// So many blocks from a bin on, the last of which may reach into the padding.
#[inline(always)]
fn blocks_from(values: &[f64], first: usize, blocks: usize) -> &[[f64; WIDTH]] {
    values[first..first + blocks * WIDTH].as_chunks().0
}
