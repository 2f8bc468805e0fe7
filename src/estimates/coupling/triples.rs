//! Triples of frequencies `f1 + f2 = f3`, and sums of products of three transforms over them.

use std::ops::Range;

use rayon::prelude::*;

use super::spectra::Spectra;

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
            let sums = RowSums {
                re: re_row,
                im: im_row,
                pairs: pairs_row,
            };
            rows.push((row, sums));
        }
        rows.into_par_iter()
            .for_each(|(row, mut sums)| sums.add(row, x, z));
    }
}

impl RowSums<'_> {
    fn add(&mut self, row: &TripleRow, x: &Spectra, z: &Spectra) {
        let (first, count) = (row.first.clone(), row.first.len());
        let third = (first.start as isize + row.second) as usize;
        let third = third..third + count;
        let size = row.second.unsigned_abs();
        for r in 0..x.count() {
            let (x, z) = (x.get(r), z.get(r));
            // The transform at -f is the conjugate of that at f.
            let sign = if row.second < 0 { -1.0 } else { 1.0 };
            let (b_re, b_im, b_power) = (x.re[size], sign * x.im[size], x.power[size]);
            let (x_re, x_im) = (&x.re[first.clone()], &x.im[first.clone()]);
            let power = &x.power[first.clone()];
            let (z_re, z_im) = (&z.re[third.clone()], &z.im[third.clone()]);
            let (re, im) = (&mut self.re[..count], &mut self.im[..count]);
            let pairs = &mut self.pairs[..count];
            for i in 0..count {
                let p_re = x_re[i] * b_re - x_im[i] * b_im;
                let p_im = x_re[i] * b_im + x_im[i] * b_re;
                re[i] += p_re * z_re[i] + p_im * z_im[i];
                im[i] += p_im * z_re[i] - p_re * z_im[i];
                pairs[i] += power[i] * b_power;
            }
        }
    }
}
