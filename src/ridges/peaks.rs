//! Peaks of `S(k, f)` along one of its axes, and whether they stand above the noise.

use ndarray::{ArrayView1, ArrayView2, Axis};
use rayon::prelude::*;

use super::lobe::Lobe;
use crate::numeric::{chi_square_level, fisher_level, median, parabola};

/// Cells of a cut over which the median is taken, and the distance from one median to the next.
const MEDIAN: usize = 64;
const STRIDE: usize = 16;
/// How far above what a stronger wave leaks there a peak must stand.
const ABOVE_LEAK: f64 = 4.0;
/// Probability by which two bins of one broad ridge differ as much as a peak and the valley beside it.
const SPECKLE_DEVIATIONS: f64 = 2.326;
/// Strongest waves of the other axis whose leakage is looked at.
const STRONGEST: usize = 8;
/// Peaks of a cut at most.
const MOST: usize = 24;
/// A peak this much wider than that of one wave is a band of waves.
const BROAD: f64 = 1.4;

/// A peak of a cut through `S(k, f)`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Peak {
    /// Index of the cut.
    pub cut: usize,
    /// Place along the cut, in bins, and its standard error.
    pub at: f64,
    pub error: f64,
    pub power: f64,
    /// Logarithm of the power at that place.
    pub height: f64,
    /// Mean power of the noise about it.
    pub noise: f64,
    /// Full width at half maximum, in bins.
    pub width: f64,
}

/// Powers of which every row is a cut.
pub(super) struct Cuts<'a> {
    /// A row a cut: `[cut, place]`.
    pub power: ArrayView2<'a, f64>,
    /// Of the axis along a cut, and of the other.
    pub along: &'a Lobe,
    pub across: &'a Lobe,
    /// Independent realisations of the average.
    pub realisations: f64,
    /// See [`level`].
    pub level: f64,
    /// The power of the least peak.
    pub least: f64,
    /// Bins around the axis along a cut, and around the other, where one ends where it begins.
    pub around: [Option<usize>; 2],
    /// Cuts and places of which nothing is said: the mean, the Nyquist lines.
    pub cuts: std::ops::Range<usize>,
    pub places: std::ops::Range<usize>,
}

/// The level over the noise, of cuts with so many places: noise exceeds it in one of all cells with probability alpha. The median of
/// so many cells, of which a window makes one of two, is known as a mean of `1 / pi` of them is.
pub(super) fn level(cells: usize, places: usize, alpha: f64, realisations: f64) -> f64 {
    let own = 2.0 * realisations;
    let of_noise = own * places.min(MEDIAN) as f64 / std::f64::consts::PI;
    fisher_level(alpha / cells.max(1) as f64, [own, of_noise])
}

impl Cuts<'_> {
    /// The peaks of all cuts, cut by cut.
    pub fn peaks(&self) -> Vec<Vec<Peak>> {
        let (strongest, background) = (self.strongest(), self.background());
        let of_cut = |cut: usize| match self.cuts.contains(&cut) {
            true => self.of_cut(cut, &strongest, &background),
            false => Vec::new(),
        };
        let cuts = (0..self.power.nrows()).into_par_iter();
        cuts.map(of_cut).collect()
    }

    fn of_cut(&self, cut: usize, strongest: &[Vec<(usize, f64)>], background: &[f64]) -> Vec<Peak> {
        let powers = self.power.index_axis(Axis(0), cut);
        let noise = self.noise(powers, background);
        let at = |i: usize| background[i] * noise[(i / STRIDE).min(noise.len() - 1)];
        // Above what the strongest waves of other cuts leak into this one.
        let is_no_leak = |i: &usize| {
            strongest[*i].iter().all(|(from, strong)| {
                let leak = self.across.leak(distance(cut, *from, self.around[1]));
                powers[*i] > ABOVE_LEAK * leak * strong
            })
        };
        let is_inside = |i: &usize| *i > 0 && *i + 1 < powers.len() && self.places.contains(i);
        let is_high = |i: &usize| powers[*i] > self.level * at(*i) && powers[*i] > self.least;
        let candidates = by_power(powers).filter(is_inside).filter(is_high);
        let mut accepted: Vec<usize> = Vec::new();
        for i in candidates.filter(is_no_leak) {
            let is_apart = |j: &usize| self.is_apart(powers, i, *j);
            if accepted.len() < MOST && accepted.iter().all(is_apart) {
                accepted.push(i);
            }
        }
        accepted.sort_unstable();
        let peak = |i: &usize| self.peak(cut, powers, *i, at(*i));
        accepted.iter().map(peak).collect()
    }

    /// The mean power of the noise over the background, from medians, one every [`STRIDE`] cells.
    fn noise(&self, powers: ArrayView1<'_, f64>, background: &[f64]) -> Vec<f64> {
        let (n, degrees) = (powers.len(), 2.0 * self.realisations);
        let of_noise = chi_square_level(0.5, degrees) / degrees;
        let of = |middle: usize| {
            let from = middle.saturating_sub(MEDIAN / 2);
            let from = from.min(n.saturating_sub(MEDIAN));
            let about = powers.iter().zip(background).skip(from).take(MEDIAN);
            let ratios = about.map(|(power, background)| power / background);
            median(ratios).map_or(f64::NAN, |ratio| ratio / of_noise)
        };
        let middles = (0..n.div_ceil(STRIDE)).map(|block| block * STRIDE + STRIDE / 2);
        middles.map(of).collect()
    }

    /// Whether a peak is none of a stronger one's side lobes, nor a bump of the same broad ridge.
    fn is_apart(&self, powers: ArrayView1<'_, f64>, weak: usize, strong: usize) -> bool {
        let leak = self.along.leak(distance(weak, strong, self.around[0]));
        let between = weak.min(strong)..=weak.max(strong);
        let valley = between.map(|i| powers[i]).fold(f64::INFINITY, f64::min);
        powers[weak] > ABOVE_LEAK * leak * powers[strong] && powers[weak] > self.speckle() * valley
    }

    /// What the spectrum has along a cut whatever the cut, by two rounds of medians: of each cut over what its places have, and of each
    /// place over what its cuts have. Noise that is correlated in time or along x is such a product. Along f they are smoothed
    /// by running medians over four main lobes, so that a flat branch is no background.
    fn background(&self) -> Vec<f64> {
        let n = self.power.ncols();
        let mut found = vec![1.0; n];
        let reach = match self.around[0] {
            Some(_) => 0,
            None => (2.0 * self.along.half).ceil() as usize,
        };
        for _ in 0..2 {
            let of_cut = |cut: usize| {
                let row = self.power.index_axis(Axis(0), cut);
                let ratios = row.iter().zip(&found).map(|(power, of)| power / of);
                (cut, median(ratios).unwrap_or(1.0).max(f64::MIN_POSITIVE))
            };
            let levels: Vec<_> = self.cuts.clone().into_par_iter().map(of_cut).collect();
            let of_place = |place: usize| {
                let column = self.power.index_axis(Axis(1), place);
                let ratios = levels.iter().map(|(cut, level)| column[*cut] / level);
                median(ratios).unwrap_or(1.0)
            };
            let medians: Vec<f64> = (0..n).into_par_iter().map(of_place).collect();
            let smooth = |i: usize| {
                // Mirrored at both ends.
                let before = (i..=i + reach).map(|j| j.abs_diff(reach));
                let after = i + 1..=i + reach;
                let mirrored = |j: usize| j.min((2 * (n - 1)).saturating_sub(j));
                let about = before.chain(after).map(|j| medians[mirrored(j)]);
                median(about).unwrap_or(0.0).max(f64::MIN_POSITIVE)
            };
            found = (0..n).map(smooth).collect();
        }
        found
    }

    /// By what factor two bins of noise differ, exceeded in one pair of a hundred: the logarithm of a mean of
    /// K exponential powers has the variance of the trigamma function at K.
    fn speckle(&self) -> f64 {
        let k = self.realisations;
        let trigamma = 1.0 / k + 1.0 / (2.0 * k * k) + 1.0 / (6.0 * k * k * k);
        (SPECKLE_DEVIATIONS * (2.0 * trigamma).sqrt()).exp()
    }

    /// The strongest waves along the other axis, at each place.
    fn strongest(&self) -> Vec<Vec<(usize, f64)>> {
        let of_place = |place: usize| {
            let column = self.power.index_axis(Axis(1), place);
            let tops = by_power(column).take(STRONGEST);
            tops.map(|i| (i, column[i])).collect()
        };
        let places = (0..self.power.ncols()).into_par_iter();
        places.map(of_place).collect()
    }

    fn peak(&self, cut: usize, powers: ArrayView1<'_, f64>, i: usize, noise: f64) -> Peak {
        let half = 0.5 * powers[i];
        // From the top outwards to half of its power.
        let side = |outwards: &mut dyn Iterator<Item = usize>| -> (usize, f64) {
            let (mut j, mut share) = (i, 0.5);
            for next in outwards {
                if powers[next] < half {
                    share = (powers[j] - half) / (powers[j] - powers[next]);
                    break;
                }
                j = next;
            }
            (j, i.abs_diff(j) as f64 + share)
        };
        let (first, below) = side(&mut (0..i).rev());
        let (last, above) = side(&mut (i + 1..powers.len()));
        let width = below + above;
        let three = [powers[i - 1], powers[i], powers[i + 1]];
        let (one, k) = (self.along, self.realisations);
        let (at, error) = if width > BROAD * one.width && last - first >= 2 {
            let sum: f64 = (first..=last).map(|j| powers[j]).sum();
            let term = |j: usize| powers[j] * (j as f64 - i as f64);
            let moment: f64 = (first..=last).map(term).sum();
            // Of a box as wide, of which each bin is known to 1/sqrt(K).
            let spread = width / 12f64.sqrt();
            let count = (last - first + 1) as f64;
            (moment / sum, spread / (k * count).sqrt())
        } else {
            (one.offset(three), self.line_error(three, noise))
        };
        Peak {
            cut,
            at: i as f64 + at,
            error,
            power: powers[i],
            height: parabola(three)[1],
            noise,
            width,
        }
    }

    /// The standard error of the top of a wave in noise, by the spread of each of three powers.
    fn line_error(&self, powers: [f64; 3], noise: f64) -> f64 {
        let [middle, _] = parabola(powers);
        let squares = (0..3).map(|n| {
            let ratio = noise / powers[n].max(f64::MIN_POSITIVE);
            let square = (2.0 * ratio + ratio * ratio) / self.realisations;
            let mut moved = powers;
            moved[n] *= square.min(1.0).sqrt().exp();
            (parabola(moved)[0] - middle).powi(2)
        });
        squares.sum::<f64>().sqrt()
    }
}

/// Indices of local maxima, the ends included, the largest first.
fn by_power(values: ArrayView1<'_, f64>) -> impl Iterator<Item = usize> {
    let n = values.len();
    let is_top = |&i: &usize| {
        (i == 0 || values[i] > values[i - 1]) && (i + 1 == n || values[i] >= values[i + 1])
    };
    let mut tops: Vec<usize> = (0..n).filter(is_top).collect();
    tops.sort_by(|a, b| values[*b].total_cmp(&values[*a]).then(a.cmp(b)));
    tops.into_iter()
}

/// Bins from one to another, the shorter way around.
fn distance(a: usize, b: usize, around: Option<usize>) -> f64 {
    let straight = a.abs_diff(b);
    around.map_or(straight, |all| straight.min(all - straight)) as f64
}
