//! Thomson's adaptive weights: tapers that leak count less where the spectrum is low.

use crate::numeric::lanes::{LaneBlock, Lanes, SimdKernel, WIDTH};
use crate::numeric::ln_normal;

/// Steps of the iteration at most; it takes 3 to 8 where tapers hardly leak.
const MOST_STEPS: usize = 200;
/// Relative change of a step at which it ends.
const CHANGE: f64 = 1e-13;

/// How the eigenspectra of several tapers are averaged.
///
/// With the concentration `l_k` of taper k, the variance `v` of the samples and the eigenspectra `S_k`, in the
/// unit in which white noise has `S = v`,
///
/// ```text
/// w_k = l_k / (l_k S + (1 - l_k) v)^2,    S = sum w_k S_k / sum w_k,
/// ```
///
/// solved by iteration. Degrees of freedom: `2 (sum w_k)^2 / sum w_k^2`.
///
/// Source: Thomson (1982), eq. 5.2 to 5.4; Percival and Walden (1993), eq. 368a, 370a and 370b.
pub(crate) struct Weights {
    /// Of each taper; all 1 for equal weights.
    concentrations: Vec<f64>,
    is_adaptive: bool,
}

impl Weights {
    pub fn new(concentrations: &[f64], is_adaptive: bool) -> Weights {
        Weights {
            concentrations: concentrations.to_vec(),
            is_adaptive: is_adaptive && concentrations.len() > 1,
        }
    }

    pub fn tapers(&self) -> usize {
        self.concentrations.len()
    }

    /// Energy of each lane under tapers that are weighted by the squares of their concentrations, over cells with weights and
    /// the sums of each taper: that of the samples.
    pub fn energy<'e>(&self, cells: impl Iterator<Item = (f64, &'e [LaneBlock])>) -> [f64; WIDTH] {
        let squares = self.concentrations.iter().map(|l| l * l);
        let mut sums = [0.0; WIDTH];
        for (weight, energies) in cells {
            for (energy, square) in energies.iter().zip(squares.clone()) {
                let added = sums.iter_mut().zip(energy.0);
                added.for_each(|(sum, energy)| *sum += weight * square * energy);
            }
        }
        let all: f64 = squares.sum();
        sums.map(|sum| sum / all)
    }

    #[inline(always)]
    fn weight<L: Lanes>(&self, k: usize, relative: L) -> L {
        if !self.is_adaptive {
            return L::splat(1.0);
        }
        let own = L::splat(self.concentrations[k]);
        let leak = L::splat(1.0 - self.concentrations[k]);
        let level = own * relative + leak;
        own / (level * level)
    }

    /// The average of `count(k)` realisations of taper k with the sums `energy(k)`, all over the variance.
    #[inline(always)]
    fn average<L: Lanes>(
        &self,
        energy: impl Fn(usize) -> L,
        count: impl Fn(usize) -> L,
        start: L,
    ) -> L {
        let zero = L::splat(0.0);
        let (mut now, mut open) = (start, L::splat(1.0));
        for _ in 0..MOST_STEPS {
            let (mut top, mut bottom) = (zero, zero);
            for k in 0..self.tapers() {
                let weight = self.weight(k, now);
                top = top + weight * energy(k);
                bottom = bottom + weight * count(k);
            }
            let next = top / bottom;
            if !self.is_adaptive {
                return next;
            }
            // A lane that has converged stays, whatever the others do.
            let change = (next - now).abs() - L::splat(CHANGE) * next;
            now = open.choose(next, now);
            open = change.choose(open, zero);
            if open.positive_mask() == 0 {
                break;
            }
        }
        now
    }
}

/// Averages of all cells of a tile.
pub(crate) struct Average<'a> {
    pub weights: &'a Weights,
    /// Sums over the realisations of each taper, `[cell * tapers + taper]`.
    pub energies: &'a [LaneBlock],
    /// Realisations of each taper in each lane; above 0.
    pub count: [f64; WIDTH],
    /// Variance of the samples of each lane; above 0.
    pub variance: [f64; WIDTH],
    /// The averages, and half of the degrees of freedom of one realisation of each taper.
    pub spectrum: &'a mut [LaneBlock],
    pub shape: &'a mut [LaneBlock],
}

impl SimdKernel for Average<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let tapers = self.weights.tapers();
        let (variance, one) = (L::read(&self.variance), L::splat(1.0));
        let count = L::read(&self.count);
        let inverse = one / variance;
        let bins = self.energies.chunks_exact(tapers);
        let results = self.spectrum.iter_mut().zip(self.shape);
        for (energies, (spectrum, shape)) in bins.zip(results) {
            let energy = |k: usize| L::load(&energies[k]) * inverse;
            let mut start = energy(0);
            for k in 1..tapers {
                start = start + energy(k);
            }
            let start = start / (count * L::splat(tapers as f64));
            let found = self.weights.average(energy, |_| count, start);
            let (mut sum, mut squares) = (L::splat(0.0), L::splat(0.0));
            for k in 0..tapers {
                let weight = self.weights.weight(k, found);
                sum = sum + weight;
                squares = squares + weight * weight;
            }
            (found * variance).store(spectrum);
            (sum * (sum / squares)).store(shape);
        }
    }
}

/// The averages without one realisation, or without a whole record: sums of the deviations of their logarithms.
pub(crate) struct WithoutOne<'a> {
    pub average: &'a Weights,
    pub energies: &'a [LaneBlock],
    pub count: [f64; WIDTH],
    pub variance: [f64; WIDTH],
    pub spectrum: &'a [LaneBlock],
    /// Realisations of each taper that are left out, and their energies, `[cell * tapers + taper]`.
    pub left_out: (&'a [LaneBlock], &'a [LaneBlock]),
    /// Sums of `ln(without) - ln(with)`, and of their squares.
    pub sum: &'a mut [LaneBlock],
    pub squares: &'a mut [LaneBlock],
}

impl SimdKernel for WithoutOne<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let tapers = self.average.tapers();
        let variance = L::read(&self.variance);
        let inverse = L::splat(1.0) / variance;
        let zero = L::splat(0.0);
        let all = L::read(&self.count);
        let (left_counts, left_energies) = self.left_out;
        let sums = self.sum.iter_mut().zip(self.squares);
        let bins = self.energies.chunks_exact(tapers).zip(self.spectrum);
        let bins = bins.zip(left_energies.chunks_exact(tapers));
        for (((energies, spectrum), left), (sum, squares)) in bins.zip(sums) {
            let start = L::load(spectrum) * inverse;
            // Of one realisation alone, rounding is left.
            let energy =
                |k: usize| (L::load(&energies[k]) - L::load(&left[k])).positive() * inverse;
            let count = |k: usize| all - L::load(&left_counts[k]);
            let without = self.average.average(energy, count, start);
            let ratio = (without / start).at_each(zero, zero, |_, x, _, _| ln_normal(x));
            (L::load(sum) + ratio).store(sum);
            (L::load(squares) + ratio * ratio).store(squares);
        }
    }
}
