//! Sums of products of three transforms over realisations.
//!
//! Realisations are summed in pairs, pairs in pairs, and so on by their index. A few rows of triples go through all levels while their sums are in cache.

use std::ops::Range;

use rayon::prelude::*;

use super::spectra::{Spectra, Spectrum};
use super::triples::{TripleRow, Triples};
use crate::estimates::realisations::{Sums, SumsShape};
use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH, widest};

/// Sums over realisations, a cell a triple.
#[derive(Debug, Clone, Copy)]
pub(super) struct TripleSums<'s> {
    /// Of `X1 X2 X3*`.
    pub re: &'s [f64],
    pub im: &'s [f64],
    /// Of `|X1 X2|^2`.
    pub pairs: &'s [f64],
    /// Of `|X1|^2` and of `|X3|^2`, a bin each.
    pub first: &'s [f64],
    pub third: &'s [f64],
}

/// What sums are compared with.
#[derive(Debug, Clone, Copy)]
pub(super) struct SumScale {
    /// The least power of a bin that is known, of the first and of the third kind.
    least: [f64; 2],
    /// Powers of two that bring the sums of `X1 X2 X3*`, `|X1 X2|^2` and `|X3|^2` near 1, so that their squares and
    /// products stay in the range of numbers.
    by: [f64; 3],
}

/// Sums of products, `[re, im, pairs]`; or of powers, `[first, third, nothing]`.
type Kinds<'a> = [&'a mut [f64]; 3];

/// The first cells of all kinds, which keep the others.
#[inline(always)]
fn split_off<'a>(kinds: &mut Kinds<'a>, cells: usize) -> Kinds<'a> {
    kinds
        .each_mut()
        .map(|kind| kind.split_off_mut(..cells).unwrap_or_default())
}

/// Blocks of a kind with a number a triple, and with a number a bin.
fn blocks(triples: &Triples) -> [usize; 2] {
    [triples.cells(), triples.last + 1].map(|numbers| numbers.div_ceil(WIDTH))
}

/// Blocks of all sums.
fn plain(triples: &Triples) -> usize {
    let [cells, bins] = blocks(triples);
    3 * cells + 2 * bins
}

impl<'s> TripleSums<'s> {
    pub fn zeros(triples: &Triples) -> Sums {
        let plain = plain(triples);
        Sums::zeros(SumsShape { plain, pieces: 0 })
    }

    pub fn bytes(triples: &Triples) -> u64 {
        (size_of::<LaneBlock>() * plain(triples)) as u64
    }

    pub fn of(triples: &Triples, sums: &'s Sums) -> TripleSums<'s> {
        let [cells, bins] = blocks(triples).map(|blocks| WIDTH * blocks);
        let numbers: &[f64] = bytemuck::cast_slice(sums.plain());
        let of_cells = |kind: usize| &numbers[kind * cells..][..triples.cells()];
        let of_bins = |kind: usize| &numbers[3 * cells + kind * bins..][..=triples.last];
        TripleSums {
            re: of_cells(0),
            im: of_cells(1),
            pairs: of_cells(2),
            first: of_bins(0),
            third: of_bins(1),
        }
    }
}

/// Power of a bin over that of the strongest, below which it holds only rounding.
pub(super) const LEAST_POWER: f64 = 1e-24;

impl TripleSums<'_> {
    /// The scale of the sums.
    pub fn scale(&self) -> SumScale {
        // Bin 0 has no power left once its mean is removed, and is in no triple.
        let largest = |powers: &[f64]| powers.iter().fold(0.0, |m: f64, p| m.max(*p));
        let [first, third] = [self.first, self.third].map(|powers| largest(&powers[1..]));
        let half = |largest: f64| match largest.is_normal() {
            true => largest.log2() as i32 / 2,
            false => 0,
        };
        let halves = [half(largest(self.pairs)), half(third)];
        SumScale {
            least: [LEAST_POWER * first, LEAST_POWER * third],
            by: [-halves[0] - halves[1], -2 * halves[0], -2 * halves[1]].map(|e| 2f64.powi(e)),
        }
    }

    /// Bicoherence and biphase of a cell, NaN where a bin has no power.
    pub fn cell(&self, cell: usize, bins: [isize; 3], scale: &SumScale) -> (f64, f64) {
        let bicoherence = self.bicoherence(cell, bins, scale);
        match bicoherence.is_nan() {
            true => (f64::NAN, f64::NAN),
            false => (bicoherence, self.biphase(cell)),
        }
    }

    /// Bicoherence of a cell, NaN where a bin has no power.
    pub fn bicoherence(
        &self,
        cell: usize,
        [first, second, third]: [isize; 3],
        scale: &SumScale,
    ) -> f64 {
        let [first, second, third] = [first, second, third].map(isize::unsigned_abs);
        let least = self.first[first].min(self.first[second]);
        let is_known = least > scale.least[0] && self.third[third] > scale.least[1];
        if !is_known {
            return f64::NAN;
        }
        let (re, im) = (self.re[cell] * scale.by[0], self.im[cell] * scale.by[0]);
        let bound = (self.pairs[cell] * scale.by[1]) * (self.third[third] * scale.by[2]);
        // `min` would make 1 of what is no number.
        match (re * re + im * im) / bound {
            above if above > 1.0 => 1.0,
            found => found,
        }
    }

    /// Phase of the sum of a cell.
    pub fn biphase(&self, cell: usize) -> f64 {
        self.im[cell].atan2(self.re[cell])
    }
}

/// Rows whose sums are in cache together. The transforms of [`AT_ONCE`] realisations are read once for all.
const ROWS: usize = 16;

/// Realisations whose products are summed before they are written.
const AT_ONCE: usize = 4;

/// Bytes of one thread for the sums of levels below, over so many realisations.
pub(super) fn working_bytes(triples: &Triples, count: usize) -> u64 {
    let rows = triples.rows.chunks(ROWS);
    let cells = rows.map(|rows| rows.iter().map(|row| row.first.len()).sum::<usize>());
    let levels = (count / AT_ONCE).checked_ilog2().unwrap_or(0) + 1;
    24 * u64::from(levels) * cells.max().unwrap_or(0) as u64
}

/// The sums over a range of the realisations of `x`, whose pairs are multiplied, and of `z`, in place of what is in
/// `sums`; rows in parallel where that is wished.
pub(super) fn sum_products(
    triples: &Triples,
    x: &Spectra,
    z: &Spectra,
    range: &Range<usize>,
    (sums, is_parallel): (&mut Sums, bool),
) {
    let [cells, bins] = blocks(triples).map(|blocks| WIDTH * blocks);
    let mut numbers: &mut [f64] = bytemuck::cast_slice_mut(sums.plain_mut());
    let mut next = |count: usize| numbers.split_off_mut(..count).unwrap_or_default();
    let mut all: Kinds<'_> = [next(cells), next(cells), next(cells)];
    let [first, third] = [next(bins), next(bins)];
    let powers: Kinds<'_> = [
        &mut first[..=triples.last],
        &mut third[..=triples.last],
        &mut [],
    ];
    let add_powers = |range: Range<usize>, [first, third, _]: Kinds<'_>, is_new: bool| {
        for (sums, spectra) in [(first, x), (third, z)] {
            for (m, sum) in sums.iter_mut().enumerate() {
                let of = |r: usize| spectra.get(range.start + r).power[m];
                let value = match range.len() {
                    1 => of(0),
                    2 => of(0) + of(1),
                    3 => (of(0) + of(1)) + of(2),
                    _ => (of(0) + of(1)) + (of(2) + of(3)),
                };
                *sum = if is_new { value } else { *sum + value };
            }
        }
    };
    sum_tree(range.clone(), powers, true, &add_powers, &mut Vec::new());
    let mut groups = Vec::with_capacity(triples.rows.len().div_ceil(ROWS));
    for rows in triples.rows.chunks(ROWS) {
        let cells = rows.iter().map(|row| row.first.len()).sum();
        groups.push((rows, split_off(&mut all, cells)));
    }
    let sum = |scratch: &mut Vec<Vec<f64>>, (rows, kinds): (&[TripleRow], Kinds<'_>)| {
        let add = |range, sums: Kinds<'_>, is_new| {
            widest(AddProducts {
                rows,
                range,
                sums,
                is_new,
                x,
                z,
            });
        };
        sum_tree(range.clone(), kinds, true, &add, scratch);
    };
    // In one piece where other threads are at work already.
    let least = if is_parallel { 1 } else { groups.len().max(1) };
    let groups = groups.into_par_iter().with_min_len(least);
    groups.for_each_init(Vec::new, sum);
}

/// The sums of a tree over a range of leaves that begins with a node as large as half of it or more, written or
/// added to others. `leaves` does so with up to [`AT_ONCE`] of them; `scratch`: space for sums of nodes below.
fn sum_tree(
    range: Range<usize>,
    mut sums: Kinds<'_>,
    is_new: bool,
    leaves: &impl Fn(Range<usize>, Kinds<'_>, bool),
    scratch: &mut Vec<Vec<f64>>,
) {
    let count = range.len();
    if count <= AT_ONCE {
        return leaves(range, sums, is_new);
    }
    if !is_new {
        let mut sums_below = scratch.pop().unwrap_or_default();
        let [a, b, c] = sums.each_ref().map(|kind| kind.len());
        sums_below.resize(a + b + c, 0.0);
        let (first, others) = sums_below.split_at_mut(a);
        let (second, third) = others.split_at_mut(b);
        sum_tree(range, [first, second, third], true, leaves, scratch);
        let values = [0..a, a..a + b, a + b..a + b + c].map(|part| &sums_below[part]);
        widest(AddSums { sums, values });
        scratch.push(sums_below);
        return;
    }
    let middle = range.start + (1 << (count - 1).ilog2());
    let left: Kinds<'_> = sums.each_mut().map(|kind| &mut **kind);
    sum_tree(range.start..middle, left, true, leaves, scratch);
    sum_tree(middle..range.end, sums, false, leaves, scratch);
}

/// Adds numbers to others.
struct AddSums<'a> {
    sums: Kinds<'a>,
    values: [&'a [f64]; 3],
}

impl SimdKernel for AddSums<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (sums, values) in self.sums.into_iter().zip(self.values) {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += value;
            }
        }
    }
}

/// The sums over up to [`AT_ONCE`] realisations of some rows.
struct AddProducts<'a> {
    rows: &'a [TripleRow],
    range: Range<usize>,
    sums: Kinds<'a>,
    /// Whether sums are written, not added to.
    is_new: bool,
    x: &'a Spectra,
    z: &'a Spectra,
}

impl SimdKernel for AddProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut kinds = self.sums;
        for row in self.rows {
            let mut own = split_off(&mut kinds, row.first.len());
            let of = (row, self.range.start, self.is_new);
            match self.range.len() {
                1 => add_row::<L, 1>(of, &mut own, self.x, self.z),
                2 => add_row::<L, 2>(of, &mut own, self.x, self.z),
                3 => add_row::<L, 3>(of, &mut own, self.x, self.z),
                _ => add_row::<L, AT_ONCE>(of, &mut own, self.x, self.z),
            }
        }
    }
}

/// The sums of a row over `R` realisations from one on.
#[inline(always)]
fn add_row<L: Lanes, const R: usize>(
    (row, from, is_new): (&TripleRow, usize, bool),
    [re, im, pairs]: &mut Kinds<'_>,
    x: &Spectra,
    z: &Spectra,
) {
    let blocks = re.len().div_ceil(WIDTH);
    let mut factors = [Factors::<L>::of(row, blocks, x.get(from), z.get(from)); R];
    for (r, factors) in factors.iter_mut().enumerate() {
        *factors = Factors::of(row, blocks, x.get(from + r), z.get(from + r));
    }
    let (re, re_tail) = re.as_chunks_mut();
    let (im, im_tail) = im.as_chunks_mut();
    let (pairs, pairs_tail) = pairs.as_chunks_mut();
    for (b, ((re, im), pairs)) in re.iter_mut().zip(im).zip(pairs).enumerate() {
        add_block(b, &factors, [re, im, pairs], is_new);
    }
    if !re_tail.is_empty() {
        let mut tail = [[0.0; WIDTH]; 3];
        let parts = [re_tail, im_tail, pairs_tail];
        for (tail, part) in tail.iter_mut().zip(&parts) {
            tail[..part.len()].copy_from_slice(part);
        }
        let [re, im, pairs] = &mut tail;
        add_block(blocks - 1, &factors, [re, im, pairs], is_new);
        for (tail, part) in tail.iter().zip(parts) {
            part.copy_from_slice(&tail[..part.len()]);
        }
    }
}

/// The products of some realisations in a block of a row, summed in pairs.
#[inline(always)]
fn add_block<L: Lanes, const R: usize>(
    b: usize,
    factors: &[Factors<'_, L>; R],
    [re, im, pairs]: [&mut [f64; WIDTH]; 3],
    is_new: bool,
) {
    let mut sums = factors[0].products(b);
    if R > 1 {
        add(&mut sums, factors[1].products(b));
    }
    if R == 3 {
        add(&mut sums, factors[2].products(b));
    }
    if R == 4 {
        let mut others = factors[2].products(b);
        add(&mut others, factors[3].products(b));
        add(&mut sums, others);
    }
    if !is_new {
        let mut before = [L::read(re), L::read(im), L::read(pairs)];
        add(&mut before, sums);
        sums = before;
    }
    sums[0].write(re);
    sums[1].write(im);
    sums[2].write(pairs);
}

#[inline(always)]
fn add<L: Lanes>(sums: &mut [L; 3], values: [L; 3]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum = *sum + value;
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
