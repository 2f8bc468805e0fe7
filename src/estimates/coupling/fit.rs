//! The least squares of a transfer at one output frequency, and its errors by drawing realisations anew.

use num_complex::Complex;
use rayon::prelude::*;

use super::spectra::{Spectra, Spectrum};
use super::transfer::deviation;
use crate::error::Result;
use crate::numeric::gram::{Gram, Solution};
use crate::numeric::{split_mix, unit_interval};
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
                let (next, bits) = split_mix(state);
                state = next;
                draws[(unit_interval(bits) * blocks.len() as f64) as usize] += 1;
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
}

/// One output frequency; powers are means over realisations.
pub(super) struct OutputFit {
    pub bin: usize,
    pub input: f64,
    pub output: f64,
    pub linear: Complex<f64>,
    pub magnitude_error: f64,
    pub linear_change: f64,
    pub linear_error: f64,
    pub gain: f64,
    pub gain_error: f64,
    /// Of each resampling.
    pub gains: Vec<f64>,
    pub residual: f64,
    pub pairs: Vec<PairFit>,
    pub determined: usize,
    /// Power of realisations that were not fitted that the linear term explains, and all terms.
    pub held_out: [f64; 2],
    /// The same of the stronger half by the weaker; its power.
    pub stronger: [f64; 2],
    pub stronger_output: f64,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct PairFit {
    /// The second is negative in a difference.
    pub bins: [isize; 2],
    pub coefficient: Complex<f64>,
    pub gain: f64,
    pub gain_error: f64,
}

/// Powers of one solution: what the linear term changes, and what each pair brings.
struct Gains {
    linear: f64,
    pairs: Vec<f64>,
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
        let mean = 1.0 / f64::from(count);
        let sum = |times: &dyn Fn(usize) -> f64| Gram::sum(&grams, times);
        let all = sum(&|_| 1.0);
        let solution = all.solve(unknowns);
        let residual = all.residual(&solution.coefficients) * mean;
        // What chance alone explains by one more term.
        let by_chance = (residual / (self.independent - solution.determined as f64)).max(0.0);
        let mut gains = Gains::of(&all, &solution, mean);
        let mut determined = 0;
        let terms = std::iter::once(&mut gains.linear).chain(&mut gains.pairs);
        for (gain, coefficient) in terms.zip(&solution.coefficients) {
            if *coefficient != Complex::default() {
                *gain -= by_chance;
                determined += 1;
            }
        }
        let resampled = self.draws.draws.iter().map(|draws| {
            let gram = sum(&|b| f64::from(draws[b]));
            let solution = gram.solve(unknowns);
            let gains = Gains::of(&gram, &solution, mean);
            (solution.coefficients[0].norm(), gains)
        });
        let resampled: Vec<(f64, Gains)> = resampled.collect();
        let of_each = |value: &dyn Fn(&Gains) -> f64| -> Vec<f64> {
            resampled.iter().map(|(_, gains)| value(gains)).collect()
        };
        let resampled_gains = of_each(&|gains| gains.pairs.iter().sum());
        let magnitudes: Vec<f64> = resampled.iter().map(|(magnitude, _)| *magnitude).collect();
        let part = |b: usize| b * PARTS / grams.len();
        let mut held_out = [0.0; 2];
        for p in 0..PARTS {
            let fitted = sum(&|b| f64::from(u8::from(part(b) != p)));
            let tested = sum(&|b| f64::from(u8::from(part(b) == p)));
            explained(&fitted, &tested, &mut held_out);
        }
        let mut order: Vec<usize> = (0..grams.len()).collect();
        order.sort_by(|a, b| strength[*a].total_cmp(&strength[*b]));
        let mut is_strong = vec![false; grams.len()];
        let strong = order[grams.len() / 2..].iter();
        strong.for_each(|b| is_strong[*b] = true);
        let weaker = sum(&|b| f64::from(u8::from(!is_strong[b])));
        let strong = sum(&|b| f64::from(u8::from(is_strong[b])));
        let mut stronger = [0.0; 2];
        explained(&weaker, &strong, &mut stronger);
        let pair = |(p, bins): (usize, &[isize; 2])| PairFit {
            bins: *bins,
            coefficient: solution.coefficients[p + 1],
            gain: gains.pairs[p],
            gain_error: deviation(&of_each(&|gains| gains.pairs[p])),
        };
        OutputFit {
            bin,
            input: all.get(0, 0).re * mean,
            output: all.output() * mean,
            linear: solution.coefficients[0],
            magnitude_error: deviation(&magnitudes),
            linear_change: gains.linear,
            linear_error: deviation(&of_each(&|gains| gains.linear)),
            gain: gains.pairs.iter().sum(),
            gain_error: deviation(&resampled_gains),
            gains: resampled_gains,
            residual: residual + by_chance * determined as f64,
            pairs: pairs.iter().enumerate().map(pair).collect(),
            determined,
            held_out: held_out.map(|power| power * mean),
            stronger: stronger.map(|power| power * mean),
            stronger_output: strong.output() * mean,
        }
    }
}

impl Gains {
    /// `mean`: 1 over the number of realisations.
    fn of(gram: &Gram, solution: &Solution, mean: f64) -> Gains {
        let b = &solution.coefficients;
        let linear = (b[0].norm_sqr() - 1.0) * gram.get(0, 0).re * mean;
        let pairs = (1..gram.unknowns()).map(|p| {
            // Of 2 L X and of all pairs with this one.
            let mut inner = b[0].conj() * 2.0 * gram.get(0, p);
            for (k, other) in b.iter().enumerate().skip(1) {
                inner += other.conj() * gram.get(k, p);
            }
            (b[p] * inner).re * mean
        });
        let pairs = pairs.collect();
        Gains { linear, pairs }
    }
}

/// Adds the power of `tested` that the linear term and all terms explain, as fitted to `fitted`.
fn explained(fitted: &Gram, tested: &Gram, sums: &mut [f64; 2]) {
    for (sum, unknowns) in sums.iter_mut().zip([1, fitted.unknowns()]) {
        let solution = fitted.solve(unknowns);
        *sum += tested.output() - tested.residual(&solution.coefficients);
    }
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
