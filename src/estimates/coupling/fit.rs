//! The least squares of a transfer at one output frequency, and its errors by drawing realisations anew.

use num_complex::Complex;
use rayon::prelude::*;

use super::found::{OutputTransfer, PairTransfer};
use super::spectra::{Spectra, Spectrum};
use crate::error::Result;
use crate::numeric::gram::{Gram, Solution};
use crate::numeric::{deviation, next_uniform};
use crate::observer::Observer;

/// Blocks of neighbouring realisations, and how often each is drawn in every resampling.
pub(super) struct Resamplings {
    /// Of each block: record, and its first and last realisation plus one.
    blocks: Vec<Vec<(usize, [usize; 2])>>,
    /// `[resampling][block]`.
    draws: Vec<Vec<u16>>,
}

/// Blocks at most.
const MOST_BLOCKS: usize = 100;
/// Parts of the realisations, of which each is predicted from the others.
const PARTS: usize = 5;

impl Resamplings {
    /// Whole records are a block's where records are many or transient.
    pub fn new([records, segments]: [usize; 2], is_transient: bool, count: usize) -> Resamplings {
        let whole = is_transient || records >= MOST_BLOCKS / 5;
        let blocks: Vec<Vec<(usize, [usize; 2])>> = match whole {
            true => {
                let all: Vec<_> = (0..records).map(|record| (record, [0, segments])).collect();
                let some = all.chunks(records.div_ceil(MOST_BLOCKS));
                some.map(<[_]>::to_vec).collect()
            }
            false => {
                // Neighbours overlap, so that a block has at least two.
                let size = (records * segments).div_ceil(MOST_BLOCKS).max(2);
                let count = (segments / size).max(1);
                let range = move |b: usize| [b * segments / count, (b + 1) * segments / count];
                let of = |record| (0..count).map(move |b| vec![(record, range(b))]);
                (0..records).flat_map(of).collect()
            }
        };
        let mut state = 1;
        let draws = (0..count).map(|_| {
            let mut draws = vec![0; blocks.len()];
            for _ in 0..blocks.len() {
                draws[(next_uniform(&mut state) * blocks.len() as f64) as usize] += 1;
            }
            draws
        });
        let draws = draws.collect();
        Resamplings { draws, blocks }
    }

    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    pub fn count(&self) -> usize {
        self.draws.len()
    }

    /// Bytes that one output needs.
    pub fn bytes(&self, unknowns: usize) -> u64 {
        (self.blocks.len() as u64 + 12) * Gram::bytes(unknowns)
            + 8 * (self.draws.len() * unknowns) as u64
    }
}

/// What all outputs read.
pub(super) struct Fit<'a> {
    /// Input and output of each record.
    pub records: &'a [[Spectra; 2]],
    pub draws: &'a Resamplings,
    /// The highest bin.
    pub last: usize,
    /// Independent realisations.
    pub independent: f64,
    /// What makes squares densities, and coefficients those of Fourier coefficients.
    pub density: f64,
    pub kernel: f64,
    /// Distance of bins.
    pub df: f64,
}

/// One output frequency.
pub(super) struct OutputFit {
    /// Without what passes it.
    pub transfer: OutputTransfer,
    pub pairs: Vec<PairTransfer>,
    /// The gain of each resampling.
    pub gains: Vec<f64>,
    /// Power of realisations that were not fitted that the linear term explains, and all terms, and all of it.
    pub held_out: [f64; 3],
    /// The same of the stronger half by the weaker.
    pub stronger: [f64; 3],
}

impl Fit<'_> {
    /// All outputs, in parallel; each by one thread.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`].
    pub fn all(&self, observer: &dyn Observer) -> Result<Vec<OutputFit>> {
        let outputs = (1..self.last + 1).into_par_iter();
        let fits = outputs.map(|bin| {
            observer.go_on()?;
            let fit = self.output(bin);
            observer.advance(1);
            Ok(fit)
        });
        fits.collect()
    }

    /// Pairs with this sum or difference.
    fn pairs(&self, bin: usize) -> Vec<[isize; 2]> {
        let sums = (1..=bin / 2).map(|second| [bin - second, second].map(|b| b as isize));
        let differences =
            (1..=self.last - bin).map(|second| [(bin + second) as isize, -(second as isize)]);
        sums.chain(differences).collect()
    }

    fn output(&self, bin: usize) -> OutputFit {
        let pairs = self.pairs(bin);
        let unknowns = pairs.len() + 1;
        let mut count = 0;
        let mut row = vec![Complex::default(); unknowns + 1];
        let mut strength = Vec::with_capacity(self.draws.blocks.len());
        let blocks = self.draws.blocks.iter();
        let grams: Vec<Gram> = blocks
            .map(|block| {
                let mut gram = Gram::zeros(unknowns);
                let (mut energy, mut rows) = (0.0, 0);
                for (record, [from, to]) in block {
                    let [input, output] = &self.records[*record];
                    for r in *from..*to {
                        let x = input.get(r);
                        fill(&mut row, bin, &pairs, x, output.get(r));
                        gram.add_row(&row);
                        energy += x.power[1..=self.last].iter().sum::<f64>();
                        rows += 1;
                    }
                }
                count += rows;
                strength.push(energy / f64::from(rows));
                gram
            })
            .collect();
        let scale = self.density / f64::from(count);
        let sum = |times: &dyn Fn(usize) -> f64| Gram::sum(&grams, times);
        let part_of = |is_in: &dyn Fn(usize) -> bool| sum(&|b| f64::from(u8::from(is_in(b))));
        let all = sum(&|_| 1.0);
        let solution = all.solve(unknowns);
        let residual = all.residual(&solution.coefficients) * scale;
        // What chance alone explains by one more term.
        let by_chance = (residual / (self.independent - solution.determined as f64)).max(0.0);
        let mut gains = gains_of(&all, &solution, scale);
        let is_there = |c: &&Complex<f64>| **c != Complex::default();
        let determined = solution.coefficients.iter().filter(is_there).count();
        let terms = gains.iter_mut().zip(&solution.coefficients);
        let terms = terms.filter(|(_, coefficient)| is_there(coefficient));
        terms.for_each(|(gain, _)| *gain -= by_chance);
        // The size of the linear term, and the gains.
        let resampled = self.draws.draws.iter().map(|draws| {
            let gram = sum(&|b| f64::from(draws[b]));
            let solution = gram.solve(unknowns);
            (
                solution.coefficients[0].norm(),
                gains_of(&gram, &solution, scale),
            )
        });
        let resampled: Vec<(f64, Vec<f64>)> = resampled.collect();
        let of_each = |value: &dyn Fn(&[f64]) -> f64| -> Vec<f64> {
            resampled.iter().map(|(_, gains)| value(gains)).collect()
        };
        let error = |term: usize| deviation(&of_each(&|gains| gains[term]));
        let magnitudes: Vec<f64> = resampled.iter().map(|(magnitude, _)| *magnitude).collect();
        let resampled_gains = of_each(&|gains| gains[1..].iter().sum());
        let part = |b: usize| b * PARTS / grams.len();
        let parts = (0..PARTS).map(|p| {
            explained(
                &part_of(&|b| part(b) != p),
                &part_of(&|b| part(b) == p),
                scale,
            )
        });
        let held_out = parts.fold([0.0; 3], |a, b| std::array::from_fn(|i| a[i] + b[i]));
        let mut order: Vec<usize> = (0..grams.len()).collect();
        order.sort_by(|a, b| strength[*a].total_cmp(&strength[*b]));
        let (weak, strong) = order.split_at(grams.len() / 2);
        let [weak, strong] = [weak, strong].map(|half| part_of(&|b| half.contains(&b)));
        let pair = |(p, [first, second]): (usize, &[isize; 2])| {
            // A pair of two frequencies stands for both orders.
            let orders = if first == second { 1.0 } else { 2.0 };
            let value = solution.coefficients[p + 1] * (self.kernel / orders);
            PairTransfer {
                first: *first as f64 * self.df,
                second: *second as f64 * self.df,
                third: bin as f64 * self.df,
                re: value.re,
                im: value.im,
                gain: gains[p + 1],
                gain_error: error(p + 1),
            }
        };
        let (linear, output) = (solution.coefficients[0], all.output() * scale);
        OutputFit {
            transfer: OutputTransfer {
                frequency: bin as f64 * self.df,
                input: all.get(0, 0).re * scale,
                output,
                magnitude: linear.norm(),
                phase: linear.arg(),
                magnitude_error: deviation(&magnitudes),
                linear: gains[0],
                linear_error: error(0),
                gain: gains[1..].iter().sum(),
                gain_error: deviation(&resampled_gains),
                residual: residual + by_chance * determined as f64,
                held_out_linear: held_out[0] / output,
                held_out_quadratic: (held_out[1] - held_out[0]) / output,
                unknowns,
                undetermined: unknowns - determined,
                ..OutputTransfer::default()
            },
            pairs: pairs.iter().enumerate().map(pair).collect(),
            gains: resampled_gains,
            held_out,
            stronger: explained(&weak, &strong, scale),
        }
    }
}

/// Powers of one solution: what the linear term changes, and what each pair brings.
fn gains_of(gram: &Gram, solution: &Solution, scale: f64) -> Vec<f64> {
    let b = &solution.coefficients;
    let linear = (b[0].norm_sqr() - 1.0) * gram.get(0, 0).re;
    let pairs = (1..gram.unknowns()).map(|p| {
        // Of 2 L X and of all pairs with this one.
        let mut inner = b[0].conj() * 2.0 * gram.get(0, p);
        for (k, other) in b.iter().enumerate().skip(1) {
            inner += other.conj() * gram.get(k, p);
        }
        (b[p] * inner).re
    });
    let all = std::iter::once(linear).chain(pairs);
    all.map(|gain| gain * scale).collect()
}

/// The power of `tested` that the linear term and all terms explain, as fitted to `fitted`, and all of it.
fn explained(fitted: &Gram, tested: &Gram, scale: f64) -> [f64; 3] {
    let by = |unknowns: usize| {
        let solution = fitted.solve(unknowns);
        tested.output() - tested.residual(&solution.coefficients)
    };
    [by(1), by(fitted.unknowns()), tested.output()].map(|power| power * scale)
}

/// Input, products of pairs, and output of one realisation.
fn fill(
    row: &mut [Complex<f64>],
    bin: usize,
    pairs: &[[isize; 2]],
    x: Spectrum<'_>,
    y: Spectrum<'_>,
) {
    let at = |s: &Spectrum<'_>, bin: usize| Complex::new(s.re[bin], s.im[bin]);
    row[0] = at(&x, bin);
    for ([first, second], value) in pairs.iter().zip(&mut row[1..]) {
        let other = at(&x, second.unsigned_abs());
        let other = if *second < 0 { other.conj() } else { other };
        *value = at(&x, *first as usize) * other;
    }
    row[pairs.len() + 1] = at(&y, bin);
}
