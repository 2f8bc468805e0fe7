//! Triples of frequencies `f1 + f2 = f3`, and sums of products of three transforms over them.

use std::ops::Range;

use rayon::prelude::*;

use super::spectra::{Spectra, Spectrum};
use crate::numeric::lanes::{Lanes, SimdKernel, WIDTH, widest};

/// The triples of bins that hold all there is: no bin 0, none at or above the Nyquist frequency.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Triples {
    /// The highest bin.
    pub last: usize,
    pub rows: Vec<TripleRow>,
}

/// Triples with one second bin, which is negative in a difference.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct TripleRow {
    pub second: isize,
    pub first: Range<usize>,
    /// Index of the first of its cells.
    pub offset: usize,
}

impl Triples {
    /// `first >= second >= least`: of one record the others repeat these. Bins less than `least` apart share
    /// power, which the first and the third must not.
    pub fn of_one(last: usize, least: usize) -> Triples {
        let sums = (least..=last / 2).map(|second| (second as isize, second..last + 1 - second));
        Triples::new(last, sums)
    }

    /// With differences, `first + second` of both signs of `second`: another record at the third frequency tells
    /// them apart. Without those whose third bin shares power with the one that is subtracted.
    pub fn of_two(last: usize, least: usize) -> Triples {
        let differences = (least..last).rev().flat_map(|size| {
            let below = size + 1..(2 * size + 1).saturating_sub(least).min(last + 1);
            let above = 2 * size + least..last + 1;
            [below, above].map(|first| (-(size as isize), first))
        });
        let sums = (least..=last / 2).map(|second| (second as isize, second..last + 1 - second));
        Triples::new(last, differences.chain(sums))
    }

    fn new(last: usize, rows: impl Iterator<Item = (isize, Range<usize>)>) -> Triples {
        let mut offset = 0;
        let rows = rows.filter(|(_, first)| !first.is_empty());
        let rows = rows.map(|(second, first)| {
            let row = TripleRow {
                second,
                offset,
                first,
            };
            offset += row.first.len();
            row
        });
        Triples {
            rows: rows.collect(),
            last,
        }
    }

    /// Number of triples.
    pub fn cells(&self) -> usize {
        let last = self.rows.last();
        last.map_or(0, |row| row.offset + row.first.len())
    }

    /// Bins of all triples, `[first, second, third]`.
    pub fn bins(&self) -> impl Iterator<Item = [isize; 3]> {
        self.rows.iter().flat_map(|row| {
            row.first.clone().map(|first| {
                let first = first as isize;
                [first, row.second, first + row.second]
            })
        })
    }
}

/// Sums over realisations, a cell a triple.
#[derive(Debug, Clone, Default)]
pub(super) struct TripleSums {
    /// Of `X1 X2 X3*`.
    pub re: Vec<f64>,
    pub im: Vec<f64>,
    /// Of `|X1 X2|^2`.
    pub pairs: Vec<f64>,
    /// Of `|X1|^2` and of `|X3|^2`, a bin each.
    pub first: Vec<f64>,
    pub third: Vec<f64>,
}

/// The sums of a row.
struct RowSums<'a> {
    row: &'a TripleRow,
    re: &'a mut [f64],
    im: &'a mut [f64],
    pairs: &'a mut [f64],
}

impl TripleSums {
    pub fn zeros(triples: &Triples) -> TripleSums {
        let cells = triples.cells();
        TripleSums {
            re: vec![0.0; cells],
            im: vec![0.0; cells],
            pairs: vec![0.0; cells],
            first: vec![0.0; triples.last + 1],
            third: vec![0.0; triples.last + 1],
        }
    }

    pub fn bytes(triples: &Triples) -> u64 {
        24 * triples.cells() as u64 + 16 * (triples.last as u64 + 1)
    }

    /// Adds all realisations of `x`, whose pairs are multiplied, and of `z`; rows in parallel. A row is summed
    /// by one thread in the order of the realisations.
    pub fn add(&mut self, triples: &Triples, x: &Spectra, z: &Spectra) {
        for r in 0..x.count() {
            let (x, z) = (x.get(r).power, z.get(r).power);
            for (sum, power) in self.first.iter_mut().zip(x) {
                *sum += power;
            }
            for (sum, power) in self.third.iter_mut().zip(z) {
                *sum += power;
            }
        }
        let (mut re, mut im, mut pairs) = (&mut self.re[..], &mut self.im[..], &mut self.pairs[..]);
        let mut rows = Vec::with_capacity(triples.rows.len());
        for row in &triples.rows {
            let (re_row, re_rest) = std::mem::take(&mut re).split_at_mut(row.first.len());
            let (im_row, im_rest) = std::mem::take(&mut im).split_at_mut(row.first.len());
            let (pairs_row, pairs_rest) = std::mem::take(&mut pairs).split_at_mut(row.first.len());
            (re, im, pairs) = (re_rest, im_rest, pairs_rest);
            rows.push(RowSums {
                row,
                re: re_row,
                im: im_row,
                pairs: pairs_row,
            });
        }
        // Few enough tasks that each reads the transforms for many rows.
        let group = rows.len().div_ceil(4 * rayon::current_num_threads()).max(1);
        let groups = rows.par_chunks_mut(group);
        groups.for_each(|rows| widest(AddProducts { rows, x, z }));
    }
}

/// Realisations whose transforms are multiplied while they are in L1.
const AT_ONCE: usize = 4;

/// Adds all realisations to these rows. A cell is summed in their order.
struct AddProducts<'a, 's> {
    rows: &'a mut [RowSums<'s>],
    x: &'a Spectra,
    z: &'a Spectra,
}

impl SimdKernel for AddProducts<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let AddProducts { rows, x, z } = self;
        let count = x.count();
        for from in (0..count).step_by(AT_ONCE) {
            for sums in rows.iter_mut() {
                match count - from {
                    1 => sums.add::<L, 1>(from, x, z),
                    2 => sums.add::<L, 2>(from, x, z),
                    3 => sums.add::<L, 3>(from, x, z),
                    _ => sums.add::<L, AT_ONCE>(from, x, z),
                }
            }
        }
    }
}

impl RowSums<'_> {
    /// Adds `R` realisations from `from` on.
    #[inline(always)]
    fn add<L: Lanes, const R: usize>(&mut self, from: usize, x: &Spectra, z: &Spectra) {
        let blocks = self.re.len().div_ceil(WIDTH);
        let mut factors = [Factors::<L>::of(self.row, blocks, x.get(from), z.get(from)); R];
        for (r, factors) in factors.iter_mut().enumerate() {
            *factors = Factors::of(self.row, blocks, x.get(from + r), z.get(from + r));
        }
        let (re, re_tail) = self.re.as_chunks_mut();
        let (im, im_tail) = self.im.as_chunks_mut();
        let (pairs, pairs_tail) = self.pairs.as_chunks_mut();
        for (b, ((re, im), pairs)) in re.iter_mut().zip(im).zip(pairs).enumerate() {
            add_block(b, &factors, [re, im, pairs]);
        }
        if !re_tail.is_empty() {
            let mut tail = [[0.0; WIDTH]; 3];
            let parts = [re_tail, im_tail, pairs_tail];
            for (tail, part) in tail.iter_mut().zip(&parts) {
                tail[..part.len()].copy_from_slice(part);
            }
            let [re, im, pairs] = &mut tail;
            add_block(blocks - 1, &factors, [re, im, pairs]);
            for (tail, part) in tail.iter().zip(parts) {
                part.copy_from_slice(&tail[..part.len()]);
            }
        }
    }
}

/// Adds the products of some realisations to a block of a row's sums.
#[inline(always)]
fn add_block<L: Lanes, const R: usize>(
    b: usize,
    factors: &[Factors<'_, L>; R],
    [re, im, pairs]: [&mut [f64; WIDTH]; 3],
) {
    let zero = L::splat(0.0);
    let (mut sum_re, mut sum_im, mut sum) = (L::read(re), L::read(im), L::read(pairs));
    for one in factors {
        let (x_re, x_im) = (L::read(&one.x[0][b]), L::read(&one.x[1][b]));
        let (z_re, z_im) = (L::read(&one.z[0][b]), L::read(&one.z[1][b]));
        let p_re = x_re.fused(one.re, zero - x_im * one.im);
        let p_im = x_re.fused(one.im, x_im * one.re);
        sum_re = p_im.fused(z_im, p_re.fused(z_re, sum_re));
        sum_im = (zero - p_re).fused(z_im, p_im.fused(z_re, sum_im));
        sum = L::read(&one.x[2][b]).fused(one.power, sum);
    }
    sum_re.write(re);
    sum_im.write(im);
    sum.write(pairs);
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
            x: [
                blocks_from(x.re, first, blocks),
                blocks_from(x.im, first, blocks),
                blocks_from(x.power, first, blocks),
            ],
            z: [
                blocks_from(z.re, third, blocks),
                blocks_from(z.im, third, blocks),
            ],
        }
    }
}

/// So many blocks from a bin on, the last of which may reach into the padding.
#[inline(always)]
fn blocks_from(values: &[f64], first: usize, blocks: usize) -> &[[f64; WIDTH]] {
    values[first..first + blocks * WIDTH].as_chunks().0
}
