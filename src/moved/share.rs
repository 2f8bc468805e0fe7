//! Cumulative spectra of groups of rows, and the shares of energy that moved between two of them.

use serde::Serialize;

/// Bins up to which the grid keeps each; beyond, bins are merged into intervals of this relative width.
const FINE: usize = 512;

/// By what errors from few parts are too small where the largest of many differences is taken.
const FEW_PARTS: f64 = 1.5;
/// Errors of a share from which on it is told beside another one.
const ONE_SIDED: f64 = 1.645;

/// Intervals of the bins of a spectrum: single bins first, then intervals that grow with the axis.
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    /// Bins before the end of each interval.
    ends: Vec<usize>,
    /// The upper end of each interval, in units of the axis.
    pub upper: Vec<f64>,
}

impl Grid {
    /// For `bins` bins from 0, `step` apart; the edge between two bins lies half-way.
    pub fn new(bins: usize, step: f64) -> Grid {
        let mut ends = Vec::new();
        let mut end = 0;
        while end < bins {
            end = (end + 1 + end / FINE).min(bins);
            ends.push(end);
        }
        let upper = ends.iter().map(|&end| (end as f64 - 0.5) * step).collect();
        Grid { ends, upper }
    }

    /// Sums over the intervals.
    pub fn sums(&self, bins: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut sums = Vec::with_capacity(self.ends.len());
        let (mut sum, mut at) = (0.0, 0);
        for (m, value) in bins.enumerate() {
            sum += value;
            if m + 1 == self.ends[at] {
                sums.push(std::mem::take(&mut sum));
                at += 1;
            }
        }
        sums
    }

    /// Number of intervals that end at or below `value`.
    pub fn below(&self, value: f64) -> usize {
        self.upper.partition_point(|upper| *upper <= value)
    }

    fn len(&self) -> usize {
        self.ends.len()
    }
}

/// The energy spectrum of one site (or one part of a time window) on a grid, and its noise.
#[derive(Debug, Clone)]
pub(crate) struct Spectrum {
    /// Energy of each interval, noise subtracted: single values may be negative.
    pub energy: Vec<f64>,
    /// Variance of it that noise causes.
    pub variance: Vec<f64>,
    /// Energy below the resolution of the window, which is none of `energy`.
    pub drift: f64,
    /// Energy times group delay, in samples from the start of the window; empty where it is not requested.
    pub delay: Vec<f64>,
}

impl Spectrum {
    /// From powers of single bins and the noise in each, both as energies. Bins below `first` are drift. `padding`: bins
    /// that count as one, since the padding makes them follow each other.
    pub fn new(
        grid: &Grid,
        power: impl Iterator<Item = f64> + Clone,
        noise: impl Iterator<Item = f64> + Clone,
        first: usize,
        padding: f64,
    ) -> Spectrum {
        let moving = |m: usize, value: f64| if m < first { 0.0 } else { value };
        let rest = power.clone().zip(noise.clone()).map(|(p, n)| p - n);
        let variance = power.zip(noise).enumerate().map(|(m, (p, n))| {
            let signal = (p - n).max(0.0);
            moving(m, (2.0 * n * signal + n * n) * padding)
        });
        Spectrum {
            drift: rest.clone().take(first).sum(),
            energy: grid.sums(rest.enumerate().map(|(m, value)| moving(m, value))),
            variance: grid.sums(variance),
            delay: Vec::new(),
        }
    }
}

impl Spectrum {
    /// The same of a record whose squares count so much more.
    pub fn times(mut self, weight: f64) -> Spectrum {
        let scale = |values: &mut [f64], by: f64| values.iter_mut().for_each(|v| *v *= by);
        scale(&mut self.energy, weight);
        scale(&mut self.delay, weight);
        scale(&mut self.variance, weight * weight);
        self.drift *= weight;
        self
    }
}

/// The mean spectrum of neighbouring rows.
#[derive(Debug, Clone)]
pub(crate) struct Group {
    /// First and last row, in the order of travel.
    pub rows: [usize; 2],
    /// Mean energy of a row on the grid.
    pub spectrum: Vec<f64>,
    /// Its sum.
    pub energy: f64,
    /// Standard error of the sum.
    pub energy_error: f64,
    /// Mean energy below the resolution.
    pub drift: f64,
    /// Mean energy times group delay, as [`Spectrum::delay`].
    delay: Vec<f64>,
    /// Share of the energy up to the end of each interval.
    pub cumulative: Vec<f64>,
    /// Variance of [`Self::spectrum`] by noise, summed up to each interval.
    noise: Vec<f64>,
    /// Variance of the energy up to the end of each interval and beyond it, as parts of the record differ.
    chance: Option<[Vec<f64>; 2]>,
    /// Standard error of [`Self::cumulative`] as members, alone or in pairs, differ.
    spread: Vec<f64>,
    /// Cumulative shares without one part of the record each, for the jackknife.
    without: Vec<Vec<f64>>,
    /// Whether parts of two groups are of the same times.
    is_paired: bool,
    /// By what errors grow since few of the parts hold most of the energy.
    uneven: f64,
}

fn cumulated(values: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let sums = values.iter().map(|value| {
        sum += value;
        sum
    });
    sums.collect()
}

fn shares(values: &[f64]) -> Vec<f64> {
    let mut sums = cumulated(values);
    let all = sums.last().copied().unwrap_or(0.0);
    sums.iter_mut().for_each(|sum| *sum /= all);
    sums
}

fn added(spectra: &[&[f64]]) -> Vec<f64> {
    let mut sum = vec![0.0; spectra[0].len()];
    for spectrum in spectra {
        for (sum, value) in sum.iter_mut().zip(*spectrum) {
            *sum += value;
        }
    }
    sum
}

/// Standard error of the mean of cumulative shares, of `members` taken `together` at a time.
fn spread(members: &[&Spectrum], together: usize) -> Option<Vec<f64>> {
    let cells: Vec<Vec<f64>> = members
        .chunks_exact(together)
        .map(|cell| shares(&added(&cell.iter().map(|s| &*s.energy).collect::<Vec<_>>())))
        .collect();
    let n = cells.len() as f64;
    (cells.len() > 1).then(|| {
        let bins = 0..cells[0].len();
        bins.map(|m| {
            let mean = cells.iter().map(|cell| cell[m]).sum::<f64>() / n;
            let squares: f64 = cells.iter().map(|cell| (cell[m] - mean).powi(2)).sum();
            (squares / (n - 1.0) / n).sqrt()
        })
        .collect()
    })
}

impl Group {
    /// Of neighbours in order. Members of a chain of cells of two differ by sublattice, which is no error: the spread is
    /// that of single members or that of pairs, whichever is less; in a run, which is exact, neighbours differ by what moves
    /// alone.
    pub fn of_neighbours(
        members: &[&Spectrum],
        rows: [usize; 2],
        common: f64,
        is_exact: bool,
    ) -> Group {
        let energies: Vec<&[f64]> = members.iter().map(|s| &*s.energy).collect();
        let variances: Vec<&[f64]> = members.iter().map(|s| &*s.variance).collect();
        // What noise does at one member it does, by its correlation `common`, at the others.
        let alike = 1.0 + (members.len() - 1) as f64 * common;
        let mut variance = added(&variances);
        variance.iter_mut().for_each(|v| *v *= alike);
        let mut group = Group::of_sums(added(&energies), variance, members.len(), rows);
        group.drift = members.iter().map(|s| s.drift).sum::<f64>() / members.len() as f64;
        let delays: Vec<&[f64]> = members.iter().map(|s| &*s.delay).collect();
        group.delay = added(&delays);
        group
            .delay
            .iter_mut()
            .for_each(|delay| *delay /= members.len() as f64);
        let total = |group: &Vec<f64>| group.iter().sum::<f64>();
        group.spread = match (spread(members, 1), spread(members, 2)) {
            _ if is_exact => vec![0.0; group.cumulative.len()],
            (Some(one), Some(two)) if total(&two) < total(&one) => two,
            (Some(one), _) => one,
            _ => vec![0.0; group.cumulative.len()],
        };
        group
    }

    /// Of parts of a record, each a realisation: errors by the jackknife. `is_paired`: whether the parts of groups that are
    /// compared are of the same times.
    pub fn of_parts(
        parts: &[Vec<f64>],
        members: usize,
        rows: [usize; 2],
        is_paired: bool,
    ) -> Group {
        let all: Vec<&[f64]> = parts.iter().map(|part| &**part).collect();
        let sum = added(&all);
        let without = parts.iter().map(|part| {
            let rest: Vec<f64> = sum.iter().zip(part).map(|(s, p)| s - p).collect();
            shares(&rest)
        });
        let without = without.collect();
        let energies: Vec<f64> = parts.iter().map(|part| part.iter().sum()).collect();
        let n = parts.len() as f64;
        let mean = energies.iter().sum::<f64>() / n;
        let squares: f64 = energies.iter().map(|e| (e - mean).powi(2)).sum();
        let none = vec![0.0; sum.len()];
        let mut group = Group::of_sums(sum, none, members * parts.len(), rows);
        let even = energies.iter().map(|e| e * e).sum::<f64>() * n / (mean * n).powi(2);
        group.uneven = if even > 1.0 { even.sqrt() } else { 1.0 };
        group.energy_error = (squares / (n - 1.0).max(1.0) / n).sqrt() / members as f64;
        let of_mean = (members * members) as f64 * (n - 1.0).max(1.0) * n;
        let cumulated: Vec<Vec<f64>> = parts.iter().map(|part| cumulated(part)).collect();
        let variances = |energy: &dyn Fn(&Vec<f64>, usize) -> f64| -> Vec<f64> {
            let variance = |m: usize| {
                let energies = || cumulated.iter().map(|part| energy(part, m));
                let mean = energies().sum::<f64>() / n;
                energies().map(|e| (e - mean).powi(2)).sum::<f64>() / of_mean
            };
            (0..group.cumulative.len()).map(variance).collect()
        };
        group.chance = Some([
            variances(&|part, m| part[m]),
            variances(&|part, m| part[part.len() - 1] - part[m]),
        ]);
        group.spread = vec![0.0; group.cumulative.len()];
        group.without = without;
        group.is_paired = is_paired;
        group
    }

    /// Adds the error that a flat floor leaves in the shares, which is known to this part of the group's energy.
    pub fn add_floor_error(&mut self, flat: &[f64], error: f64) {
        let shares = shares(flat).into_iter().zip(&self.cumulative);
        self.spread = shares.map(|(flat, c)| error * (flat - c).abs()).collect();
    }

    fn of_sums(sum: Vec<f64>, variance: Vec<f64>, members: usize, rows: [usize; 2]) -> Group {
        let n = members as f64;
        let spectrum: Vec<f64> = sum.iter().map(|e| e / n).collect();
        let noise = cumulated(&variance).into_iter().map(|v| v / (n * n));
        let noise: Vec<f64> = noise.collect();
        Group {
            rows,
            energy: spectrum.iter().sum(),
            energy_error: noise.last().copied().unwrap_or(0.0).sqrt(),
            drift: 0.0,
            delay: Vec::new(),
            cumulative: shares(&sum),
            spectrum,
            noise,
            chance: None,
            spread: Vec::new(),
            without: Vec::new(),
            is_paired: false,
            uneven: 1.0,
        }
    }

    /// Rows from the first of `other` to the last of this one.
    pub fn bodies_from(&self, other: &Group) -> usize {
        self.rows[1].abs_diff(other.rows[0]) + 1
    }

    /// Whether there is more than noise: energy above three of its errors.
    pub fn has_energy(&self) -> bool {
        self.energy > 0.0 && self.energy > 3.0 * self.energy_error && self.energy.is_finite()
    }

    /// The energy of this and another one on the same grid, both without errors.
    pub fn and(&self, other: &Group) -> Group {
        let both = [&self.spectrum[..], &other.spectrum];
        let none = vec![0.0; self.spectrum.len()];
        let mut sum = Group::of_sums(added(&both), none.clone(), 1, self.rows);
        sum.spread = none;
        sum
    }

    /// Energy with that below the resolution.
    pub fn with_drift(&self) -> f64 {
        self.energy + self.drift
    }

    /// Whether most of the energy lies at frequencies that the window resolves.
    pub fn is_resolved(&self) -> bool {
        self.energy > self.drift
    }

    /// Variance of the cumulative share at interval `m` by noise and by differences of members.
    fn variance(&self, m: usize) -> f64 {
        let (share, all) = (
            self.cumulative[m],
            self.noise.last().copied().unwrap_or(0.0),
        );
        let (low, high) = (self.noise[m], all - self.noise[m]);
        let by_noise = (1.0 - share).powi(2) * low + share.powi(2) * high;
        by_noise / (self.energy * self.energy) + self.spread[m].powi(2)
    }

    /// Whether it is of a record whose parts are realisations.
    pub fn differs_by_chance(&self) -> bool {
        self.chance.is_some()
    }

    /// Energy above interval `m`, and its variance.
    pub fn above(&self, m: usize) -> [f64; 2] {
        let all = self.noise.last().copied().unwrap_or(0.0);
        let chance = self.chance.as_ref().map_or(0.0, |[_, above]| above[m]);
        let rest = all - self.noise[m] + chance;
        [self.energy * (1.0 - self.cumulative[m]), rest]
    }

    /// Energy up to interval `m`, and its variance.
    pub fn below(&self, m: usize) -> [f64; 2] {
        let chance = self.chance.as_ref().map_or(0.0, |[below, _]| below[m]);
        [self.energy * self.cumulative[m], self.noise[m] + chance]
    }

    /// Mean group delay of the energy in these intervals, in samples from the start of the window; NaN where none was requested.
    pub fn delay(&self, among: std::ops::Range<usize>) -> f64 {
        let sum = |values: &[f64]| {
            values
                .get(among.clone())
                .map_or(f64::NAN, |v| v.iter().sum())
        };
        sum(&self.delay) / sum(&self.spectrum)
    }

    /// Frequency with the largest density.
    pub fn peak(&self, grid: &Grid) -> f64 {
        let lower = |m: usize| if m == 0 { 0.0 } else { grid.upper[m - 1] };
        let density = |m: usize| self.spectrum[m] / (grid.upper[m] - lower(m));
        let best = (1..grid.len()).max_by(|&a, &b| density(a).total_cmp(&density(b)));
        best.map_or(f64::NAN, |m| 0.5 * (lower(m) + grid.upper[m]))
    }

    /// The same on another grid: cumulative shares are linear between ends of intervals.
    pub fn on(&self, from: &Grid, to: &Grid) -> Group {
        let share = |at: f64| {
            let m = from.below(at);
            let lower = |m: usize| {
                if m == 0 {
                    (0.0, 0.0)
                } else {
                    (from.upper[m - 1], self.cumulative[m - 1])
                }
            };
            match from.upper.get(m) {
                None => 1.0,
                Some(upper) => {
                    let (low, below) = lower(m);
                    below + (self.cumulative[m] - below) * (at - low) / (upper - low)
                }
            }
        };
        let cumulative: Vec<f64> = to.upper.iter().map(|at| share(*at)).collect();
        let mut before = 0.0;
        let spectrum = cumulative
            .iter()
            .map(|c| self.energy * (c - std::mem::replace(&mut before, *c)));
        let resampled = |values: &[f64]| -> Vec<f64> {
            let last = values.len() - 1;
            to.upper
                .iter()
                .map(|at| values[from.below(*at).min(last)])
                .collect()
        };
        Group {
            spectrum: spectrum.collect(),
            noise: resampled(&self.noise),
            spread: resampled(&self.spread),
            without: Vec::new(),
            cumulative,
            ..self.clone()
        }
    }

    /// Frequency up to which the share of the energy lies.
    pub fn quantile(&self, grid: &Grid, share: f64) -> f64 {
        let at = self.cumulative.iter().position(|c| *c >= share);
        grid.upper[at.unwrap_or(grid.len() - 1)]
    }
}

/// A share of energy that moved, and where.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Share {
    pub share: f64,
    /// Standard error.
    pub error: f64,
    /// Interval of the grid at whose end the shares differ most.
    pub at: usize,
}

impl Share {
    /// Whether it exceeds `tolerance` and three of its errors.
    fn is_told(&self, tolerance: f64) -> bool {
        self.share > tolerance && self.share > 3.0 * self.error
    }

    /// What it is below at 95 %.
    fn bound(&self) -> f64 {
        self.share + 1.96 * self.error
    }
}

/// `U = max_f C_a - C_b` and `D = max_f C_b - C_a`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moved {
    pub up: Share,
    pub down: Share,
}

impl Moved {
    pub fn between(a: &Group, b: &Group) -> Moved {
        let difference = |m: usize| a.cumulative[m] - b.cumulative[m];
        let bins = 0..a.cumulative.len();
        let most = |sign: f64| {
            let by = |&m: &usize, &n: &usize| {
                let (m, n) = (sign * difference(m), sign * difference(n));
                m.total_cmp(&n)
            };
            let at = bins.clone().max_by(by).unwrap_or(0);
            Share {
                // Noise that is subtracted leaves cumulative shares a little outside of 0 to 1.
                share: (sign * difference(at)).clamp(0.0, 1.0),
                error: error_of(a, b, at),
                at,
            }
        };
        Moved {
            up: most(1.0),
            down: most(-1.0),
        }
    }

    /// The larger of the two.
    pub fn most(&self) -> f64 {
        self.up.share.max(self.down.share)
    }

    pub fn bound(&self) -> f64 {
        self.up.bound().max(self.down.bound())
    }

    /// What is to be said of shares that count from `tolerance` on.
    pub fn verdict(&self, tolerance: f64) -> super::Verdict {
        use super::Verdict;
        let beside = |share: &Share| share.share > tolerance.max(ONE_SIDED * share.error);
        match (self.up.is_told(tolerance), self.down.is_told(tolerance)) {
            (true, true) => Verdict::Spreads,
            (true, false) if beside(&self.down) => Verdict::Spreads,
            (false, true) if beside(&self.up) => Verdict::Spreads,
            (true, false) => Verdict::Up,
            (false, true) => Verdict::Down,
            (false, false) => Verdict::Unchanged,
        }
    }

    /// Whether this, found with another window or other groups, says the same as `verdict`: what moved moves in it by
    /// half the tolerance or more, what did not by less than twice the tolerance and its errors.
    pub fn agrees(&self, verdict: super::Verdict, tolerance: f64) -> bool {
        use super::Verdict;
        let moves = |share: &Share| share.share > 0.5 * tolerance;
        let rests = |share: &Share| share.share < 2.0 * tolerance.max(1.5 * share.error);
        match verdict {
            Verdict::Up => {
                moves(&self.up) && (rests(&self.down) || self.down.share < self.up.share)
            }
            Verdict::Down => {
                moves(&self.down) && (rests(&self.up) || self.up.share < self.down.share)
            }
            Verdict::Spreads => moves(&self.up) && moves(&self.down),
            Verdict::Unchanged => rests(&self.up) && rests(&self.down),
            Verdict::Untold => true,
        }
    }
}

/// Standard error of the difference of two cumulative shares: by the jackknife over parts, or by noise and spread.
fn error_of(a: &Group, b: &Group, m: usize) -> f64 {
    let n = a.without.len();
    if n < 2 || n != b.without.len() {
        return (a.variance(m) + b.variance(m)).sqrt();
    }
    of_parts(a, b, m).hypot(a.spread[m].hypot(b.spread[m]))
}

/// By the jackknife.
fn of_parts(a: &Group, b: &Group, m: usize) -> f64 {
    let n = a.without.len();
    let jackknife = |values: &mut dyn Iterator<Item = f64>| {
        let values: Vec<f64> = values.collect();
        let mean = values.iter().sum::<f64>() / n as f64;
        let squares: f64 = values.iter().map(|d| (d - mean).powi(2)).sum();
        squares * (n as f64 - 1.0) / n as f64
    };
    let of = |group: &Group| jackknife(&mut group.without.iter().map(|part| part[m]));
    if !(a.is_paired && b.is_paired) {
        // The largest of many differences, of few parts, exceeds three errors of a single one too often.
        return FEW_PARTS * a.uneven.max(b.uneven) * (of(a) + of(b)).sqrt();
    }
    // A wave takes its time from one place to the other: parts are compared at the lag at which they are most alike.
    let at_lag = |lag: usize| {
        let pairs = a.without.iter().zip(b.without.iter().cycle().skip(lag));
        jackknife(&mut pairs.map(|(a, b)| a[m] - b[m]))
    };
    let mut lags = [0, 1, n - 1].map(at_lag);
    lags.sort_by(f64::total_cmp);
    let [least, next, _] = lags;
    // The least of three that are alike, where no wave is common to both, is too small.
    let alike = if next > 0.0 { least / next } else { 0.0 };
    let few = 1.0 + (FEW_PARTS - 1.0) * alike;
    few * a.uneven.max(b.uneven) * least.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::moved::Verdict;

    fn group(spectrum: &[f64]) -> Group {
        let one = Spectrum {
            energy: spectrum.to_vec(),
            variance: vec![0.0; spectrum.len()],
            drift: 0.0,
            delay: Vec::new(),
        };
        Group::of_neighbours(&[&one], [0, 0], 0.0, true)
    }

    /// By hand: of 1 and 1 a quarter moves to the second bin; of three bins the middle one empties to both sides.
    #[test]
    fn val_shares_that_move_by_construction() {
        let moved = Moved::between(&group(&[2.0, 2.0]), &group(&[0.5, 1.5]));
        assert_eq!(
            (moved.up.share, moved.up.at, moved.down.share),
            (0.25, 0, 0.0)
        );
        assert_eq!(moved.verdict(0.05), Verdict::Up);
        let moved = Moved::between(&group(&[1.0, 6.0, 1.0]), &group(&[2.0, 4.0, 2.0]));
        assert_eq!((moved.up.share, moved.down.share), (0.125, 0.125));
        assert_eq!(moved.verdict(0.05), Verdict::Spreads);
        assert_eq!(moved.verdict(0.2), Verdict::Unchanged);
    }

    /// By hand: all but a few thousandths of the energy goes, and what was not there before is a part of what is left. A ten-thousandth
    /// of what came in is no gain, a hundredth is one.
    #[test]
    fn val_a_gain_counts_by_what_came_in() {
        let place = |of: &Group| crate::moved::Place {
            rows: of.rows,
            at: 0.0,
        };
        for (gained, transfer) in [(1e-4, false), (1e-2, true)] {
            let (before, after) = (group(&[1.0, 0.0]), group(&[1e-3, gained]));
            let upper = [1.0, 2.0];
            let moved = crate::moved::Movement::between(&before, &after, &upper, 0.05, &place);
            assert_eq!(moved.verdict, Verdict::Up);
            assert_eq!(moved.transfer, Some(transfer), "{gained}: {moved:?}");
        }
    }

    /// Sums over intervals are those over bins, and single bins come first.
    #[test]
    fn val_a_grid_keeps_sums() {
        let grid = Grid::new(5000, 2.0);
        let sums = grid.sums((0..5000).map(f64::from));
        assert_eq!(sums.iter().sum::<f64>(), 4999.0 * 2500.0);
        assert_eq!((sums[3], grid.upper[3], grid.below(7.0)), (3.0, 7.0, 4));
        assert!(sums.len() < 2000 && grid.upper.last() == Some(&9999.0));
    }
}
