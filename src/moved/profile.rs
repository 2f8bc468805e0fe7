//! Cumulative spectra of a profile, the shares of energy that moved along it, and their one error.
//!
//! `C_g(f)` is the share of the energy of group g up to f. From the first group on
//!
//! ```text
//! U_g = max_f [C_1(f) - C_g(f)]  moved up,    D_g = max_f [C_g(f) - C_1(f)]  moved down.
//! ```
//!
//! Their error is the jackknife of `C_1(f) - C_g(f)` at that f: a row of either group left out (gains, coupling, the noise of
//! each), a piece left out of both at once (the same wave passes both), and what the noise below and above f does. Variances add.

use std::ops::Range;

use super::windows::QUIET;
use super::{Evidence, Fate, GroupSpectrum, Move, Movement, Place, Reason, Verdict};
use crate::numeric::{LineFit, student_two_sided};

/// Bins up to which the grid keeps each; beyond, bins are merged into intervals of this relative width.
const FINE: usize = 512;
/// The probability by which chance exceeds three errors, and by which two, as far as they are known.
const SURELY: f64 = 0.0027;
const LIKELY: f64 = 0.0455;
/// Degrees of freedom of noise, as quiet parts have it.
const OF_NOISE: usize = 2 * QUIET;
/// Part of that by which a move is told that it exceeds at a group beside.
const BESIDE: f64 = 0.5;
/// Part of a move that energy must have gained at least.
const GAINED: f64 = 0.5;
/// Part of the larger move that the smaller one is, of energy that spreads.
const BOTH: f64 = 0.4;
/// Part of a move that is gone at the end if it does not last.
const GONE: f64 = 0.2;
/// What may move unseen from which on it is not said that nothing does.
const OPEN: f64 = 0.15;

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
}

/// Adds values one by one.
pub(super) fn add(sum: &mut [f64], values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, v)| *sum += v);
}

/// The energy of a site, or of a stretch of times, on the grid, noise subtracted.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// Site, or first and last time.
    pub at: [usize; 2],
    /// Cumulated over the grid: one of a window that holds the wave, several segments of a steady record.
    pieces: Vec<Vec<f64>>,
    /// Variance of all pieces by the noise, cumulated; empty of none.
    noise: Vec<f64>,
}

/// Energy up to an interval, and all of it.
type Below = [f64; 2];

impl Row {
    pub fn new(at: [usize; 2], mut pieces: Vec<Vec<f64>>, mut noise: Vec<f64>) -> Row {
        for values in pieces.iter_mut().chain([&mut noise]) {
            for m in 1..values.len() {
                values[m] += values[m - 1];
            }
        }
        Row { at, pieces, noise }
    }

    /// Without a piece.
    fn below(&self, m: usize, without: Option<usize>) -> Below {
        let pieces = self.pieces.iter().enumerate();
        let pieces = pieces.filter(|(i, _)| Some(*i) != without);
        let below = pieces.map(|(_, piece)| [piece[m], piece[piece.len() - 1]]);
        below.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
    }
}

fn mean(of: &[Below]) -> Below {
    let sum = |i: usize| of.iter().map(|below| below[i]).sum::<f64>();
    [sum(0), sum(1)].map(|sum| sum / of.len() as f64)
}

/// The mean of the others, without each.
fn without_one(of: &[Below]) -> impl Iterator<Item = Below> {
    (0..of.len()).map(|i| mean(&[&of[..i], &of[i + 1..]].concat()))
}

/// What an error may be: half the width of the 95 % interval, and what is told to exceed it, as two and three standard errors are.
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    likely: f64,
    sure: f64,
}

impl Errors {
    /// Adds an independent variance, which so many degrees of freedom know.
    fn add(&mut self, variance: f64, freedom: usize) {
        let of = |chance| student_two_sided(chance, freedom.max(1) as f64) * variance.sqrt();
        self.likely = self.likely.hypot(of(LIKELY));
        self.sure = self.sure.hypot(of(SURELY));
    }

    /// By the jackknife, from the values without each of n parts.
    fn add_without(&mut self, without: &[f64], freedom: usize) {
        let n = without.len() as f64;
        if n > 1.0 {
            self.add(squares(without) * (n - 1.0) / n, freedom);
        }
    }
}

/// Values less a line through them, scaled to the variance that they have left.
fn trendless(values: &[f64]) -> Vec<f64> {
    let points = values.iter().enumerate().map(|(i, v)| (i as f64, *v));
    let points: Vec<(f64, f64)> = points.collect();
    let Some(fit) = LineFit::through(&points) else {
        return values.to_vec();
    };
    let n = points.len() as f64;
    let scale = ((n - 1.0) / (n - 2.0)).sqrt();
    let left = points
        .iter()
        .map(|(x, v)| v - fit.intercept - fit.slope * x);
    left.map(|left| scale * left).collect()
}

/// Sum of squares from the mean.
fn squares(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|v| (v - mean).powi(2)).sum()
}

/// Rows in groups, in the order in which the wave passes them or in that of time.
#[derive(Debug, Clone)]
pub(crate) struct Profile {
    rows: Vec<Row>,
    groups: Vec<Range<usize>>,
    upper: Vec<f64>,
    /// Mean energy of a row of each group, cumulated.
    cumulated: Vec<Vec<f64>>,
    /// Whether rows are those of a run, which differ by what moves alone.
    is_exact: bool,
}

impl Profile {
    /// Groups of rows that hold more than noise: three errors of the energy by the draws of it.
    pub fn new(groups: Vec<Vec<Row>>, upper: &[f64], is_exact: bool) -> Profile {
        let last = upper.len() - 1;
        let is_above = |rows: &Vec<Row>| {
            let all: f64 = rows.iter().map(|row| row.below(last, None)[1]).sum();
            let noise: f64 = rows.iter().filter_map(|row| row.noise.last()).sum();
            all > 3.0 * noise.sqrt()
        };
        let groups: Vec<Vec<Row>> = groups.into_iter().filter(is_above).collect();
        let cumulated = groups.iter().map(|rows| {
            let mut sum = vec![0.0; upper.len()];
            for piece in rows.iter().flat_map(|row| &row.pieces) {
                add(&mut sum, piece);
            }
            sum.iter_mut().for_each(|sum| *sum /= rows.len() as f64);
            sum
        });
        let mut end = 0;
        let ranges = groups.iter().map(|rows| {
            end += rows.len();
            end - rows.len()..end
        });
        Profile {
            cumulated: cumulated.collect(),
            groups: ranges.collect(),
            upper: upper.to_vec(),
            rows: groups.into_iter().flatten().collect(),
            is_exact,
        }
    }

    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// The same of some of the groups.
    pub fn among(&self, groups: &[usize]) -> Profile {
        let [of_groups, sums] = [groups.iter(), groups.iter()];
        Profile {
            groups: of_groups.map(|&group| self.groups[group].clone()).collect(),
            cumulated: sums.map(|&group| self.cumulated[group].clone()).collect(),
            ..self.clone()
        }
    }

    /// First and last row of a group, in the order of travel.
    pub fn rows(&self, group: usize) -> [usize; 2] {
        let rows = &self.rows[self.groups[group].clone()];
        [rows[0].at[0], rows[rows.len() - 1].at[1]]
    }

    pub fn energy(&self, group: usize) -> f64 {
        self.cumulated[group].last().copied().unwrap_or(0.0)
    }

    fn below(&self, group: usize, m: usize) -> Below {
        [self.cumulated[group][m], self.energy(group)]
    }

    fn share(&self, group: usize, m: usize) -> f64 {
        self.cumulated[group][m] / self.energy(group)
    }

    /// Frequency up to which a share of the energy of a group lies.
    pub fn quantile(&self, group: usize, share: f64) -> f64 {
        let at = (0..self.upper.len()).find(|&m| self.share(group, m) >= share);
        self.upper[at.unwrap_or(self.upper.len() - 1)]
    }

    /// Errors of a function of the energies of a mean row of groups a and b, up to interval m and in all.
    fn errors(&self, groups: [usize; 2], m: usize, of: &dyn Fn(Below, Below) -> f64) -> Errors {
        let rows = groups.map(|group| &self.rows[self.groups[group].clone()]);
        let usual = groups.map(|group| self.below(group, m));
        let with = |i: usize, other: Below| match i {
            0 => of(other, usual[1]),
            _ => of(usual[0], other),
        };
        let each = |i: usize, without: Option<usize>| -> Vec<Below> {
            rows[i].iter().map(|row| row.below(m, without)).collect()
        };
        let mut errors = Errors::default();
        if !self.is_exact {
            let count = rows[0].len() + rows[1].len();
            // What changes evenly from row to row is no error.
            let mut both = [Errors::default(); 2];
            for i in [0, 1] {
                let rest = each(i, None);
                let without: Vec<f64> = without_one(&rest).map(|rest| with(i, rest)).collect();
                both[0].add_without(&without, count - 2);
                both[1].add_without(&trendless(&without), count.saturating_sub(4));
            }
            let is_even = rows[0].len().min(rows[1].len()) > 2 && both[1].sure < both[0].sure;
            errors = both[usize::from(is_even)];
        }
        let pieces = rows[0][0].pieces.len();
        let without = (0..pieces).map(|piece| {
            let [a, b] = [0, 1].map(|i| mean(&each(i, Some(piece))));
            of(a, b)
        });
        errors.add_without(&without.collect::<Vec<_>>(), pieces - 1);
        // Noise below and above are independent.
        for (i, rows) in rows.into_iter().enumerate() {
            let noise = |m: usize| rows.iter().filter_map(|row| row.noise.get(m)).sum::<f64>();
            let (below, all) = (noise(m), noise(self.upper.len() - 1));
            let [below, above] = [below, all - below].map(|of| of.sqrt() / rows.len() as f64);
            for off in [[below, below], [0.0, above]] {
                let other = [usual[i][0] + off[0], usual[i][1] + off[1]];
                errors.add((with(i, other) - of(usual[0], usual[1])).powi(2), OF_NOISE);
            }
        }
        errors
    }

    /// The largest share that moved up (`sign` 1) or down (-1) from the first group to `group`.
    fn moved(&self, group: usize, sign: f64) -> Move {
        let differs = |m: &usize| sign * (self.share(0, *m) - self.share(group, *m));
        let most = (0..self.upper.len()).max_by(|a, b| differs(a).total_cmp(&differs(b)));
        let interval = most.unwrap_or(0);
        let share = differs(&interval);
        let errors = match group {
            0 => Errors::default(),
            group => self.errors([0, group], interval, &|a, b| b[0] / b[1] - a[0] / a[1]),
        };
        Move {
            // Noise that is subtracted leaves cumulative shares a little outside of 0 to 1.
            share: share.clamp(0.0, 1.0),
            error: errors.likely,
            sure: errors.sure,
            at: match share > 0.0 {
                true => self.upper[interval],
                false => f64::NAN,
            },
            interval,
        }
    }

    /// U and D of each group.
    pub fn moves(&self) -> Vec<[Move; 2]> {
        (0..self.len())
            .map(|group| [1.0, -1.0].map(|sign| self.moved(group, sign)))
            .collect()
    }

    /// Energy that group b has more than group a on one side of interval m, over all of a's; and what is told to exceed its errors.
    fn gain(&self, [a, b]: [usize; 2], m: usize, is_above: bool) -> [f64; 2] {
        let part = move |of: Below| match is_above {
            true => of[1] - of[0],
            false => of[0],
        };
        let scale = self.energy(a);
        let gain = move |a: Below, b: Below| (part(b) - part(a)) / scale;
        let gained = gain(self.below(a, m), self.below(b, m));
        [gained, self.errors([a, b], m, &gain).sure]
    }

    /// The verdict on moves that count from `tolerance` on, the largest that is told, and its group.
    pub fn judge(&self, tolerance: f64, place: &dyn Fn([usize; 2]) -> Place) -> (Movement, usize) {
        let moves = self.moves();
        let last = self.len() - 1;
        let exceeds = |group: usize, way: usize, part: f64| {
            let Move { share, sure, .. } = moves[group][way];
            share > tolerance && share > part * sure
        };
        let beside = |group: usize, way: usize| {
            let near = [group - 1, (group + 1).min(last)].into_iter();
            last < 3
                || near
                    .filter(|near| *near != group)
                    .any(|near| exceeds(near, way, BESIDE))
        };
        let is_told = |group: usize, way: usize| exceeds(group, way, 1.0) && beside(group, way);
        let told = [0, 1].map(|way| {
            let told = (1..=last).filter(|&group| is_told(group, way));
            told.max_by(|&a, &b| moves[a][way].share.total_cmp(&moves[b][way].share))
        });
        let [up, down] = [0, 1].map(|way| told[way].map_or(0.0, |group| moves[group][way].share));
        // What cannot tell whether anything moves says nothing of those that can.
        let is_sharp = |group: &usize| moves[*group].iter().all(|of| of.error < OPEN);
        let mut sharp: Vec<usize> = (1..=last).filter(is_sharp).collect();
        if 2 * sharp.len() < last {
            sharp = (1..=last).collect();
        }
        let bounds = sharp.iter().flat_map(|&group| &moves[group]);
        let bound = bounds.map(|of| of.share + of.error).fold(0.0, f64::max);
        let way = usize::from(down > up);
        let verdict = match told {
            [None, None] if bound > OPEN => Verdict::Untold,
            [None, None] => Verdict::Unchanged,
            _ if up.min(down) > BOTH * up.max(down) => Verdict::Spreads,
            _ if way == 0 => Verdict::Up,
            _ => Verdict::Down,
        };
        let group = told[way].unwrap_or(sharp[sharp.len() - 1]);
        let spreads = verdict == Verdict::Spreads;
        let of = |way: usize| moves[told[way].filter(|_| spreads).unwrap_or(group)][way];
        let mut movement = Movement {
            verdict,
            up: of(0),
            down: of(1),
            at_end: Some(moves[last]),
            bound,
            energy_ratio: self.energy(group) / self.energy(0),
            from: Some(place(self.rows(0))),
            to: Some(place(self.rows(group))),
            reason: (verdict == Verdict::Untold).then_some(Reason::Noise { bound }),
            ..Movement::untold(Reason::NoEnergy)
        };
        if movement.moves() {
            movement.transfer = self.is_gained(group, way, &movement);
            movement.fate = self.fate(group, way, [&moves[group], &moves[last]]);
        }
        (movement, group)
    }

    /// Whether energy itself grew on the far side of the frequency of a move: `None` where errors hide a gain as large as
    /// the move.
    fn is_gained(&self, group: usize, way: usize, of: &Movement) -> Option<bool> {
        let by = [of.up, of.down][way];
        let least = GAINED * by.share * of.energy_ratio.min(1.0);
        match self.gain([0, group], by.interval, way == 0) {
            [gain, sure] if gain > sure.max(least) => Some(true),
            [gain, sure] if gain + sure < least => Some(false),
            _ => None,
        }
    }

    /// What becomes of a move by the last group; `None` where errors hide it.
    fn fate(&self, group: usize, way: usize, [most, end]: [&[Move; 2]; 2]) -> Option<Fate> {
        let last = self.len() - 1;
        let gone = most[way].share - end[way].share;
        let sure = most[way].sure.hypot(end[way].sure);
        if gone <= GONE * most[way].share {
            return Some(Fate::Stays);
        }
        if gone <= sure {
            return None;
        }
        match self.gain([group, last], most[way].interval, way == 1) {
            [gain, sure] if gain > sure => Some(Fate::Back),
            [gain, sure] if gain + sure < GAINED * gone => Some(Fate::Lost),
            _ => None,
        }
    }

    /// The share that moves up (`way` 0) or down (1) to the same rows; `None` where these are no group here.
    pub fn same(&self, rows: [usize; 2], way: usize) -> Option<f64> {
        let group = (0..self.len()).find(|&group| self.rows(group) == rows)?;
        Some(self.moved(group, [1.0, -1.0][way]).share)
    }

    pub fn evidence(&self, compared: [usize; 2], place: &dyn Fn([usize; 2]) -> Place) -> Evidence {
        let seen = |group: usize| GroupSpectrum {
            place: place(self.rows(group)),
            cumulative: (0..self.upper.len())
                .map(|m| self.share(group, m))
                .collect(),
            energy: self.energy(group),
        };
        Evidence {
            upper: self.upper.clone(),
            groups: (0..self.len()).map(seen).collect(),
            moves: self.moves(),
            compared,
        }
    }
}
