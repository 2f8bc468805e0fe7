//! The delay of a site behind the reference.

use std::f64::consts::TAU;

use column_fft::{Columns, ColumnsMut, ComplexToRealColumns};
use ndarray::{Array2, ArrayView1};
use num_complex::Complex;
use rayon::prelude::*;

use super::Coherence;
use super::significance::{Significance, is_own};
use crate::estimates::realisations::{Realisations, TOGETHER};
use crate::numeric::lanes::{LaneBlock, on_lines};
use crate::numeric::{LineFit, chi_square_level, student_two_sided};

/// The delay of a site behind the reference.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Delay {
    /// In units of time; positive where the site follows the reference.
    pub delay: f64,
    /// Standard error, if the records differ by a delay and independent noise: [`Self::interval`] over the quantile
    /// of the normal distribution.
    pub error: f64,
    /// Half of the interval at `1 - alpha`.
    pub interval: f64,
    /// Where a narrow band alone is coherent, its period: other delays that differ by whole periods are as likely,
    /// and `delay` is the one nearest to 0.
    pub ambiguity: Option<f64>,
    /// Where it depends on frequency: a frequency and the group delay there, of the lower and of the upper part of those that are
    /// coherent. They differ by more than twice the intervals of both.
    pub by_frequency: Option<[[f64; 2]; 2]>,
    /// Frequencies that are coherent.
    pub frequencies: usize,
    /// Root mean square of these, by their weights.
    #[serde(skip)]
    pub(super) rms_frequency: f64,
}

/// Points of the search for each one of a transform, which has at least as many as a segment has samples.
const FINER: usize = 4;
/// Bytes of a point of a plan.
const PLAN: usize = 32;
/// Least coherent frequencies.
const LEAST: usize = 2;
/// Frequencies that a sum over neighbours needs, for each of its terms.
const OF_NEIGHBOURS: f64 = 8.0;
/// Frequencies of a part that is asked for its own delay, at least, each with those that share its bin.
const OF_PART: f64 = 4.0;
/// Intervals by which the delays of two parts differ if they depend on frequency.
const SURELY: f64 = 2.0;
/// Part of the band over which `cos 2 theta` must cancel for waves of both directions to be told apart.
const TOLD: f64 = 0.5;
/// Standard deviation of a narrow band, over its mean frequency.
const NARROW: f64 = 0.2;
/// Bins from which on the width of a band is no error of the frequencies.
const RESOLVED: f64 = 0.5;
/// Bins to which a line leaks, at most.
pub(super) const FURTHEST: f64 = 2.0;
/// Share of the autocorrelation of a taper below which shifted segments have nothing in common.
const NOTHING_SHARED: f64 = 0.01;

/// Finds delays, by the maximum of
///
/// ```text
/// C(tau) = sum_f W(f) cos(phase(f) + 2 pi f tau),    W = g / (1 - g),
/// ```
///
/// over coherent frequencies between 0 and the Nyquist frequency, `g` the magnitude-squared coherence: the
/// maximum-likelihood estimate.
///
/// A delay D multiplies the cross-correlation that segments show by the autocorrelation q of their taper, which
/// falls with the lag. To first order the phase of the cross-spectrum S is less by `-q'(D) / q(D) d ln |S| / d
/// omega`; it is added, but for transients, of which segments lose nothing.
///
/// The variance is the larger of two: `B / (2 K sum (2 pi f)^2 W)`, that of independent noise, with the `B` bins
/// that the taper spreads a frequency over, and that of the residual phases. Where frequencies are many, it is that
/// of the residuals with the covariances of neighbours, as segments that a delay shifts leave residuals that
/// cancel; at least a quarter of the larger one.
///
/// Another maximum is excluded where the logarithms of the likelihoods, `2 K / B C`, differ by more than `ln(n /
/// alpha)`, over n points, without the weakest frequencies, of which a share alpha is false.
///
/// Source: C. H. Knapp, G. C. Carter, IEEE Trans. Acoust. Speech Signal Process. 24, 320 (1976); H. White,
/// Econometrica 48, 817 (1980) for residuals.
///
/// The points of the search are those of [`FINER`] transforms, of which each is a part of a point behind the one
/// before: a transform of all of them would take as many times the memory.
pub(super) struct DelaySearch<'a> {
    transform: ComplexToRealColumns<f64>,
    /// `exp(2 pi i f tau)` of each bin, with tau the distance of two points.
    next: Vec<Complex<f64>>,
    cross: &'a Coherence,
    test: Significance,
    realisations: &'a Realisations,
    /// Of a segment, in samples and in units of time.
    length: usize,
    period: f64,
    shared_bins: f64,
    /// Bins between a bin and the frequency whose power it has, for each unit of growth.
    leakage: f64,
    /// What the magnitude of a normal variable exceeds with probability alpha.
    normal: f64,
}

/// What is found of a site.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Follows {
    pub is_coherent: bool,
    pub delay: Option<Delay>,
    /// Energy of the waves that follow the reference by the delay less that of those which precede it by as much, over both; `None`
    /// where the band does not tell them apart.
    pub one_way: Option<f64>,
}

/// Working space of one thread.
#[derive(Default)]
struct Scratch {
    /// Of each site.
    coherent: [Vec<Coherent>; TOGETHER],
    sums: Vec<Complex<f64>>,
    found: Vec<f64>,
    columns: Vec<Complex<f64>>,
}

/// A coherent frequency: its bin, weight and phase, and how the logarithm of the cross-spectrum grows a bin.
#[derive(Debug, Clone, Copy)]
struct Coherent {
    bin: f64,
    weight: f64,
    phase: f64,
    growth: f64,
}

/// A maximum of C.
#[derive(Debug, Clone, Copy)]
struct Maximum {
    /// In cycles of the lowest frequency.
    tau: f64,
    /// Added to phases, for each unit of growth.
    correction: f64,
}

impl<'a> DelaySearch<'a> {
    pub fn new(realisations: &'a Realisations, cross: &'a Coherence) -> Self {
        let length = realisations.segments.length;
        let points = length.next_power_of_two();
        let angle = TAU / (FINER * points) as f64;
        let next = |m: usize| Complex::from_polar(1.0, angle * m as f64);
        let shared_bins = realisations.shared_bins();
        DelaySearch {
            transform: ComplexToRealColumns::new(points).expect("at least four samples"),
            next: (0..length.div_ceil(2)).map(next).collect(),
            cross,
            test: Significance {
                alpha: cross.alpha,
                sites: cross.coherence.ncols() - 1,
                shared_bins,
            },
            realisations,
            length,
            period: length as f64 * cross.time.step,
            shared_bins,
            leakage: leakage(realisations),
            normal: chi_square_level(cross.alpha, 1.0).sqrt(),
        }
    }

    /// Bytes of the search in segments of `length` samples, by so many threads.
    pub fn working_bytes(length: usize, threads: u64) -> u64 {
        let points = length.next_power_of_two();
        let bins = length.div_ceil(2);
        let lines = size_of::<LaneBlock>();
        let sums = 16 * (points / 2 + 1) * TOGETHER + 8 * points * TOGETHER + 2 * lines;
        let columns = 16 * ComplexToRealColumns::<f64>::scratch_len_of(points);
        // Surprises, sorted too, and which bins are a site's own.
        let coherent = size_of::<Coherent>() * bins * TOGETHER + 17 * bins;
        (17 * bins + PLAN * points) as u64 + threads * (sums + columns + coherent) as u64
    }

    /// What is found of each site; `independent`: its realisations with the reference at each frequency, NaN where no
    /// significance can be stated.
    pub fn find(&self, independent: &Array2<f64>) -> Vec<Follows> {
        let of_reference = is_own(self.cross.spectrum.column(self.cross.reference));
        let sites = 0..independent.ncols();
        let means: Vec<f64> = sites.map(|j| self.cross.independent_of(j)).collect();
        let tiles = means.par_chunks(TOGETHER).enumerate();
        let found = tiles.map_init(Scratch::default, |scratch, (tile, means)| {
            scratch.coherent.iter_mut().for_each(Vec::clear);
            let mut found = [Follows::default(); TOGETHER];
            for lane in 0..means.len() {
                let site = tile * TOGETHER + lane;
                let coherent = self.choose(&of_reference, (site, independent.column(site)));
                found[lane].is_coherent = coherent.is_some();
                scratch.coherent[lane] = coherent.unwrap_or_default();
            }
            self.of_tile(means, scratch, &mut found);
            found[..means.len()].to_vec()
        });
        let found: Vec<Vec<Follows>> = found.collect();
        found.concat()
    }

    /// The coherent frequencies of a site; `None` where it is not coherent at all.
    fn choose(
        &self,
        of_reference: &[bool],
        (site, independent): (usize, ArrayView1<f64>),
    ) -> Option<Vec<Coherent>> {
        let (cross, end) = (self.cross, self.length.div_ceil(2));
        let own = cross.spectrum.column(site);
        let coherence = cross.coherence.column(site);
        let reference = cross.spectrum.column(cross.reference);
        let of_site = is_own(own);
        let surprise = |m: usize| match of_site[m] && of_reference[m] {
            true => -(independent[m] - 1.0) * (-coherence[m]).ln_1p(),
            false => f64::NAN,
        };
        let surprises: Vec<f64> = (1..end).map(surprise).collect();
        let threshold = self.test.threshold(&surprises)?;
        let logarithm = |m: usize| (coherence[m] * own[m] * reference[m]).ln();
        // NaN is no number to be above.
        let chosen = (1..end).filter(|m| surprises[m - 1] >= threshold);
        let coherent = chosen.map(|m| {
            let [below, above] = [(m - 1).max(1), (m + 1).min(end - 1)];
            let apart = (above - below).max(1) as f64;
            let growth = 0.5 * (logarithm(above) - logarithm(below)) / apart;
            Coherent {
                bin: m as f64,
                weight: coherence[m] / (1.0 - coherence[m]).max(f64::EPSILON),
                phase: cross.phase[[m, site]],
                growth: if growth.is_finite() { growth } else { 0.0 },
            }
        });
        Some(coherent.collect())
    }

    /// The delays of a few sites, whose coherent frequencies are in `scratch`.
    fn of_tile(&self, independent: &[f64], scratch: &mut Scratch, found: &mut [Follows; TOGETHER]) {
        if scratch.coherent.iter().all(|site| site.len() < LEAST) {
            return;
        }
        // Where the sums are largest; of equal sums the first one.
        let mut largest = [(0, f64::NEG_INFINITY); TOGETHER];
        self.sweep(scratch, |point, row| {
            for ((at, most), v) in largest.iter_mut().zip(row) {
                let is_larger = v > most || (v == most && point < *at);
                *most = if is_larger { *v } else { *most };
                *at = if is_larger { point } else { *at };
            }
        });
        let maximum = |lane: usize| {
            let coherent = &scratch.coherent[lane];
            let maximum =
                (coherent.len() >= LEAST).then(|| self.refined(coherent, largest[lane].0))?;
            let allowed = self.allowed_difference(coherent, maximum, independent[lane]);
            Some((maximum, allowed))
        };
        let maxima: Vec<_> = (0..independent.len()).map(maximum).collect();
        // Points around the maximum that belong to it, and what others may not exceed.
        let mut lobes = [(0, f64::INFINITY); TOGETHER];
        for (lane, maximum) in maxima.iter().enumerate() {
            if let Some((_, allowed)) = maximum {
                let half = 0.5 * self.points() as f64 / rms(&scratch.coherent[lane]);
                lobes[lane] = (half.ceil() as usize, largest[lane].1 - allowed);
            }
        }
        let (points, mut has_rival) = (self.points(), [false; TOGETHER]);
        self.sweep(scratch, |point, row| {
            for lane in 0..TOGETHER {
                let (half, most) = lobes[lane];
                if row[lane] > most {
                    let apart = point.abs_diff(largest[lane].0);
                    has_rival[lane] |= apart.min(points - apart) > half;
                }
            }
        });
        for (lane, maximum) in maxima.into_iter().enumerate() {
            let Some((maximum, allowed)) = maximum else {
                continue;
            };
            let coherent = &scratch.coherent[lane];
            if let Some(delay) = self.delay(coherent, maximum, independent[lane]) {
                found[lane].one_way = one_way(coherent, maximum);
                let is_alone = !has_rival[lane];
                found[lane].delay = self.told(coherent, delay, allowed, is_alone);
            }
        }
    }

    fn points(&self) -> usize {
        FINER * self.transform.len()
    }

    /// Calls `visit` with the sums of all sites at each point of the search.
    fn sweep(&self, scratch: &mut Scratch, mut visit: impl FnMut(usize, &[f64; TOGETHER])) {
        let (points, bins) = (self.transform.len(), self.transform.bins());
        let sums = on_lines(&mut scratch.sums, bins * TOGETHER);
        sums.fill(Complex::default());
        for (lane, site) in scratch.coherent.iter().enumerate() {
            for one in site {
                let place = one.bin as usize * TOGETHER + lane;
                sums[place] = Complex::from_polar(one.weight, one.phase);
            }
        }
        let found = on_lines(&mut scratch.found, points * TOGETHER);
        let columns = &mut scratch.columns;
        columns.resize(self.transform.scratch_len(), Complex::default());
        for behind in 0..FINER {
            if behind > 0 {
                let rows = sums.chunks_exact_mut(TOGETHER).zip(&self.next);
                rows.for_each(|(row, next)| row.iter_mut().for_each(|sum| *sum *= next));
            }
            let input = Columns::new(&*sums, bins, TOGETHER, TOGETHER);
            let output = ColumnsMut::new(&mut *found, points, TOGETHER, TOGETHER);
            let (input, output) = (input.expect("as long"), output.expect("as long"));
            let transformed = self.transform.process_with_scratch(input, output, columns);
            transformed.expect("shapes of the plan");
            let (rows, _) = found.as_chunks::<TOGETHER>();
            for (n, row) in rows.iter().enumerate() {
                visit(FINER * n + behind, row);
            }
        }
    }

    /// The maximum next to a point of the search.
    fn refined(&self, coherent: &[Coherent], point: usize) -> Maximum {
        let points = self.points();
        let before = points * usize::from(2 * point > points);
        let start = (point as f64 - before as f64) / points as f64;
        let mut maximum = Maximum {
            tau: self.climbed(coherent, start, 0.0),
            correction: 0.0,
        };
        // The correction depends on the delay, which it hardly changes.
        for _ in 0..2 {
            maximum.correction = self.correction(maximum.tau);
            maximum.tau = self.climbed(coherent, maximum.tau, maximum.correction);
        }
        maximum
    }

    /// The maximum that Newton's method finds from `tau` on.
    fn climbed(&self, coherent: &[Coherent], mut tau: f64, correction: f64) -> f64 {
        // Within the lobe that the search found, of which the correction moves the top by more than a point.
        let most = 0.125 / rms(coherent);
        for _ in 0..8 {
            let (mut slope, mut bend) = (0.0, 0.0);
            for one in coherent {
                let (sin, cos) = one.residual(Maximum { tau, correction }).sin_cos();
                slope -= one.weight * one.bin * sin;
                bend -= one.weight * one.bin * one.bin * cos;
            }
            let step = slope / bend / TAU;
            if bend >= 0.0 || step.abs() > most {
                break;
            }
            tau -= step;
            if step.abs() <= f64::EPSILON * tau.abs() {
                break;
            }
        }
        tau
    }

    /// What is added to the phase of a bin of unit growth: `-q'(D) / q(D)` in rad.
    fn correction(&self, tau: f64) -> f64 {
        let lag = tau * self.length as f64;
        let whole = lag.abs().round() as usize;
        let shared = |lag: usize| self.realisations.autocorrelation(lag);
        let at_zero = shared(0);
        let here = shared(whole);
        // A transient is in its segment as a whole, whatever its delay.
        let is_whole = self.cross.independence.is_transient();
        if is_whole || here < NOTHING_SHARED * at_zero {
            return 0.0;
        }
        let fall = match whole {
            // An even function of the lag.
            0 => 2.0 * (at_zero - shared(1)) / at_zero * lag,
            _ => 0.5 * (shared(whole - 1) - shared(whole + 1)) / here * lag.signum(),
        };
        fall * self.length as f64 / TAU
    }

    /// By how much the sum of another maximum may be less.
    fn allowed_difference(&self, coherent: &[Coherent], at: Maximum, independent: f64) -> f64 {
        let likelihood = 2.0 * independent / self.shared_bins;
        let misfit = coherent.iter();
        let misfit = misfit.map(|one| one.weight * (1.0 - one.residual(at).cos()));
        // 1/2 for each independent frequency.
        let expected = 0.5 * coherent.len() as f64 / self.shared_bins;
        let excess = (likelihood * misfit.sum::<f64>() / expected).max(1.0);
        // So many of the frequencies are false, each with its neighbours, the weakest at best.
        let mut weights: Vec<f64> = coherent.iter().map(|one| one.weight).collect();
        weights.sort_unstable_by(f64::total_cmp);
        let neighbours = self.shared_bins.ceil() + 1.0;
        let false_ones = (self.cross.alpha * weights.len() as f64).ceil() * neighbours;
        let by_chance: f64 = weights.iter().take(false_ones as usize).sum();
        (self.points() as f64 / self.cross.alpha).ln() * excess / likelihood + 2.0 * by_chance
    }

    /// The delay of a maximum, with its error; `None` where C has no maximum there.
    fn delay(&self, coherent: &[Coherent], at: Maximum, independent: f64) -> Option<Delay> {
        let information = |one: &Coherent| one.weight * one.bin * one.bin;
        let all: f64 = coherent.iter().map(information).sum();
        let squares: f64 = coherent.iter().map(|one| information(one).powi(2)).sum();
        let bends = coherent.iter();
        let bends = bends.map(|one| information(one) * one.residual(at).cos());
        let bend: f64 = bends.sum();
        if bend <= 0.0 {
            return None;
        }
        let frequencies = all * all / squares;
        let student = |degrees: f64| student_two_sided(self.cross.alpha, degrees.max(1.0));
        let stated = (self.shared_bins / (2.0 * independent * all)).sqrt();
        let reach = self.shared_bins.ceil();
        let slope = |one: &Coherent| one.weight * one.bin * one.residual(at).sin();
        let own: f64 = coherent.iter().map(|one| slope(one).powi(2)).sum();
        let of_residuals = (self.shared_bins * own).sqrt() / bend;
        let apart = student(frequencies / self.shared_bins) * of_residuals;
        let mut half = apart.max(self.normal * stated);
        let terms = 2.0 * reach + 1.0;
        if frequencies > OF_NEIGHBOURS * terms {
            let pairs = coherent.iter().enumerate().map(|(n, one)| {
                let above = coherent[n + 1..].iter();
                let above = above.take_while(|other| other.bin - one.bin <= reach);
                2.0 * slope(one) * above.map(slope).sum::<f64>()
            });
            let variance = (own + pairs.sum::<f64>()) / (1.0 - terms / frequencies);
            let together = student(frequencies / (reach + 2.0)) * variance.max(0.0).sqrt() / bend;
            half = half.min(together.max(0.5 * half));
        }
        let period = self.period;
        let interval = half / TAU * period;
        Some(Delay {
            delay: at.tau * period,
            error: interval / self.normal,
            interval,
            ambiguity: None,
            by_frequency: self.by_frequency(coherent, at, independent),
            frequencies: coherent.len(),
            rms_frequency: rms(coherent) / period,
        })
    }
}

impl DelaySearch<'_> {
    /// The group delays of the lower and of the upper part of the coherent frequencies, where they differ: the slopes of the weighted
    /// lines through the phases of each.
    fn by_frequency(
        &self,
        coherent: &[Coherent],
        at: Maximum,
        independent: f64,
    ) -> Option<[[f64; 2]; 2]> {
        let period = self.period;
        let least = OF_PART * self.shared_bins;
        let of_part = |part: &[Coherent]| {
            let points = part.iter().map(|one| {
                let cycles = one.residual(at) / TAU;
                [one.bin, TAU * (cycles - cycles.round()), one.weight]
            });
            let line = LineFit::weighted(points)?;
            let freedom = part.len() as f64 / self.shared_bins - 2.0;
            // By independent noise, or by what is left where that is more.
            let stated = self.shared_bins / (2.0 * independent);
            let variance = stated.max(line.squares / freedom) / line.spread;
            let half = student_two_sided(self.cross.alpha, freedom.max(1.0)) * variance.sqrt();
            let delay = (at.tau - line.slope / TAU) * period;
            Some([line.middle / period, delay, half / TAU * period])
        };
        let (low, high) = coherent.split_at(coherent.len() / 2);
        if (low.len() as f64) < least {
            return None;
        }
        let (low, high) = (of_part(low)?, of_part(high)?);
        let differ = (low[1] - high[1]).abs() > SURELY * low[2].hypot(high[2]);
        differ.then(|| [low, high].map(|[frequency, delay, _]| [frequency, delay]))
    }

    /// A delay with what else is as likely: where a narrow band alone is coherent, delays that differ by its period, of which the
    /// one nearest to 0 is taken. `None` where others are as likely and the band is wide.
    fn told(
        &self,
        coherent: &[Coherent],
        delay: Delay,
        allowed: f64,
        is_alone: bool,
    ) -> Option<Delay> {
        // The frequencies whose power the coherent bins have, in bins, by their weights.
        let leaks = |one: &Coherent| (self.leakage * one.growth).clamp(-FURTHEST, FURTHEST);
        let band = coherent
            .iter()
            .map(|one| (one.weight, one.bin + leaks(one)));
        let band: Vec<(f64, f64)> = band.collect();
        let sum = |of: &dyn Fn(f64) -> f64| band.iter().map(|(w, at)| w * of(*at)).sum::<f64>();
        let all = sum(&|_| 1.0);
        let mean = sum(&|at| at) / all;
        let deviation = (sum(&|at| (at - mean).powi(2)) / all).sqrt();
        // What the sum loses where the delay is a period longer.
        let loss = sum(&|at| 1.0 - (TAU * at / mean).cos());
        if is_alone && deviation >= RESOLVED && loss >= allowed {
            return Some(delay);
        }
        let period = self.period / mean;
        (deviation < NARROW * mean).then(|| Delay {
            delay: delay.delay - period * (delay.delay / period).round(),
            ambiguity: Some(period),
            ..delay
        })
    }
}

impl Coherent {
    /// What a maximum leaves of the phase.
    fn residual(&self, at: Maximum) -> f64 {
        self.phase + at.correction * self.growth + TAU * self.bin * at.tau
    }
}

/// Bins between a bin and the frequency whose power it has, for each unit by which the logarithm of the power grows a
/// bin: `-q''(0) / q(0)` of the autocorrelation of the taper, over the square of the distance of bins in rad; 1/3
/// of a Hann window. It is exact for a line under a Gaussian taper.
pub(super) fn leakage(realisations: &Realisations) -> f64 {
    let [at_zero, beside] = [0, 1].map(|lag| realisations.autocorrelation(lag));
    let bin = TAU / realisations.segments.length as f64;
    2.0 * (at_zero - beside) / at_zero / (bin * bin)
}

/// By least squares of the complex coherence, `sqrt(g) e^{i phase} = p e^{-i theta} + m e^{i theta}` with `theta = 2 pi f tau`: waves that follow
/// and waves that precede the reference by the same delay. `(p - m) / (p + m)`.
fn one_way(coherent: &[Coherent], at: Maximum) -> Option<f64> {
    let [mut follows, mut precedes, mut both] = [0.0; 3];
    for one in coherent {
        let size = (one.weight / (1.0 + one.weight)).sqrt();
        let (residual, theta) = (one.residual(at), TAU * one.bin * at.tau);
        follows += size * residual.cos();
        precedes += size * (residual - 2.0 * theta).cos();
        both += (2.0 * theta).cos();
    }
    let count = coherent.len() as f64;
    let plus = count * follows - both * precedes;
    let minus = count * precedes - both * follows;
    (both.abs() < TOLD * count).then(|| (plus - minus) / (plus + minus))
}

/// Root mean square of the bins, by their weights.
fn rms(coherent: &[Coherent]) -> f64 {
    let all: f64 = coherent.iter().map(|one| one.weight).sum();
    let squares = coherent.iter().map(|one| one.weight * one.bin.powi(2));
    (squares.sum::<f64>() / all).sqrt()
}
