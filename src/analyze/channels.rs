//! Channels that differ from those beside them as motion does not: dead, quiet, saturated, loud, noisy.

use super::quality::Findings;
use serde_json::{Value, json};

use super::warning::Sites;
use super::{Axes, Warning};
use crate::numeric::sum_of_squares;
use crate::sheet::number;

/// How much louder or quieter than those beside it a site is that is too loud or quiet.
const LOUD: f64 = 100.0;
/// Neighbours that are too loud, quiet or noisy together, at most.
const TOGETHER: usize = 2;
/// Equal samples on an extreme that make a record look clipped.
const CLIPPED_RUN: usize = 4;
/// Energy in the top tenth of the frequency axis over that of the sites beside it; how much these may exceed
/// the median; its least share of the site's energy.
const NOISY: f64 = 30.0;
const NOISY_ALIKE: f64 = 10.0;
const NOISY_SHARE: f64 = 1e-4;
/// Sites on each side that a noisy one is held against.
const BESIDE: usize = 2;
/// Neighbours of a node of standing waves cancel up to this part.
const NODE: f64 = 0.2;

const LEAVE_OUT: &str =
    "check the sensors; leave the sites out of spectra along time with `--without-sites`";

impl Findings<'_> {
    /// Dead and saturated channels, and those unlike their neighbours. Bodies at rest and in free flight are no
    /// faults of a sensor: none of a simulated run.
    pub(super) fn channels(&self, axes: &Axes) -> Vec<Warning> {
        if self.simulated {
            return Vec::new();
        }
        let levels = self.levels();
        let mut warnings = Vec::new();
        let mut say = |rows: &[usize], code, what: &str, advice, numbers: Value| {
            if !rows.is_empty() {
                let sites = Sites::of(rows, self.first_site, axes);
                warnings.push(sites.warning(code, what, advice, numbers));
            }
        };
        let dead = self.dead(&levels);
        say(&dead, "dead-channels", "constant", LEAVE_OUT, json!({}));
        let clipped = |j: &usize| self.scans[*j].clipped_run >= CLIPPED_RUN;
        let clipped: Vec<usize> = (0..self.scans.len()).filter(clipped).collect();
        let longest = clipped.iter().map(|&j| self.scans[j].clipped_run).max();
        let what = format!(
            "on the extreme value for up to {} samples",
            longest.unwrap_or(0)
        );
        let advice = "lower the gain or the amplitude; clipping makes harmonics that are not there";
        say(
            &clipped,
            "saturated-channels",
            &what,
            advice,
            json!({"longest": longest}),
        );
        let (quiet, ratio) = self.quiet(&levels).unwrap_or_default();
        let what = format!(
            "less than 1/{LOUD} as loud as both beside, down to {} of the median",
            number(ratio)
        );
        say(
            &quiet,
            "quiet-channels",
            &what,
            LEAVE_OUT,
            json!({"ratio": ratio}),
        );
        let (loud, ratio) = loud(&levels).unwrap_or_default();
        let what = format!(
            "more than {LOUD} times as loud as those beside, up to {} times the median",
            number(ratio)
        );
        let advice = "check gains and units: this energy decides spectra and directions; leave out with \
                      `--without-sites`, or scale first";
        say(
            &loud,
            "loud-channels",
            &what,
            advice,
            json!({"ratio": ratio}),
        );
        let (noisy, ratio) = self.noisy(&loud).unwrap_or_default();
        let what = format!(
            "up to {} times the energy of those beside in the top tenth below Nyquist",
            number(ratio)
        );
        say(
            &noisy,
            "noisy-channels",
            &what,
            LEAVE_OUT,
            json!({"ratio": ratio}),
        );
        warnings
    }

    fn levels(&self) -> Vec<f64> {
        let level = |j: usize| match self.by_site {
            Some(rows) => rows[j].total.sqrt(),
            None => self.scans[j].largest,
        };
        (0..self.scans.len()).map(level).collect()
    }

    fn is_left_out(&self, j: usize) -> bool {
        self.left_out.contains(&(self.first_site + j))
    }

    /// Constant records. Sites of nothing but zeros that reach an end of the array may be ahead of a front: none
    /// is dead if the first that moves is as quiet as a front begins.
    fn dead(&self, levels: &[f64]) -> Vec<usize> {
        let n = self.scans.len();
        if self.ends.len() < 2 {
            return Vec::new();
        }
        let most = levels.iter().fold(0.0, |m: f64, v| m.max(*v));
        let is_zero = |j: &usize| self.scans[*j].largest == 0.0;
        let is_front = |j: Option<usize>| j.is_some_and(|j| LOUD * levels[j] < most);
        let [head, tail] = [
            (0..n).find(|j| !is_zero(j)).filter(|j| is_front(Some(*j))),
            (0..n).rfind(|j| !is_zero(j)).filter(|j| is_front(Some(*j))),
        ];
        let is_ahead = |j: usize| head.is_some_and(|head| j < head) || tail.is_some_and(|t| j > t);
        let is_dead = |j: &usize| self.scans[*j].constant && !is_ahead(*j) && !self.is_left_out(*j);
        (0..n).filter(is_dead).collect()
    }

    /// Sites that move: neither constant nor left out.
    fn live(&self) -> Vec<usize> {
        let lives = |j: &usize| !self.scans[*j].constant && !self.is_left_out(*j);
        (0..self.scans.len()).filter(lives).collect()
    }

    /// Sites far quieter than both beside them, while most are alike; the least part of these. A node of a
    /// standing wave is quiet, too: there the sites beside it cancel.
    fn quiet(&self, levels: &[f64]) -> Option<(Vec<usize>, f64)> {
        let live = self.live();
        let level = |i: usize| levels[live[i]];
        if !are_alike(live.iter().map(|&j| levels[j]), LOUD) {
            return None;
        }
        let median = median(live.iter().map(|&j| levels[j]))?;
        let stands_out = |from: usize, end: usize| {
            let (Some(before), true) = (from.checked_sub(1), end < live.len()) else {
                return false;
            };
            let most = (from..end).map(level).fold(0.0, f64::max);
            let is_quiet = LOUD * most < level(before).min(level(end));
            is_quiet && !self.cancel(live[before], live[end])
        };
        let rows = outstanding(live.len(), |i| LOUD * level(i) < median, stands_out);
        let rows: Vec<usize> = rows.into_iter().map(|i| live[i]).collect();
        let least = rows.iter().map(|&j| levels[j]).reduce(f64::min)?;
        Some((rows, least / median))
    }

    /// Whether two records are opposite.
    fn cancel(&self, a: usize, b: usize) -> bool {
        let (a, b) = ((self.record)(a), (self.record)(b));
        let size = |v: &[f64]| sum_of_squares(v).sqrt();
        let both: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
        size(&both) < NODE * (size(&a) + size(&b))
    }

    /// Sites with far more energy in the top tenth of the frequency axis than those beside them, while these are
    /// alike; over that of those beside them. Not those that are `loud` anyway, nor those at an end of the array, where
    /// motion that is driven there may die away from one site to the next.
    fn noisy(&self, loud: &[usize]) -> Option<(Vec<usize>, f64)> {
        let rows = self.by_site?;
        let live = self.live();
        let top = |i: usize| rows[live[i]].top;
        let median = median((0..live.len()).map(top)).filter(|median| *median > 0.0)?;
        let is_high = |i: usize| {
            let row = &rows[live[i]];
            row.top > NOISY * median
                && row.top > NOISY_SHARE * row.total
                // The ends of gaps leak.
                && self.scans[live[i]].gaps == 0
                && !loud.contains(&live[i])
        };
        let beside = |from: usize, end: usize| {
            let before = (0..from).rev().take(BESIDE);
            before.chain((end..live.len()).take(BESIDE))
        };
        let stands_out = |from: usize, end: usize| {
            let least = (from..end).map(top).fold(f64::INFINITY, f64::min);
            let beside = |i: usize| NOISY * top(i) < least && top(i) < NOISY_ALIKE * median;
            from > 0
                && end < live.len()
                && live.len() > 2 * BESIDE + TOGETHER
                && self::both(from, end, live.len(), beside)
        };
        let found = outstanding(live.len(), is_high, stands_out);
        let most_beside = |i: usize| beside(i, i + 1).map(top).fold(0.0, f64::max);
        let ratio = found
            .iter()
            .map(|&i| top(i) / most_beside(i).max(f64::MIN_POSITIVE))
            .reduce(f64::max)?;
        Some((found.into_iter().map(|i| live[i]).collect(), ratio))
    }
}

/// Whether all sites beside a run, up to two on each side, are as wanted.
fn both(from: usize, end: usize, n: usize, wanted: impl Fn(usize) -> bool) -> bool {
    let before = (0..from).rev().take(BESIDE);
    before.chain((end..n).take(BESIDE)).all(wanted)
}

/// Sites far louder than those beside them, while these are alike: one gain that is wrong; over the median.
fn loud(levels: &[f64]) -> Option<(Vec<usize>, f64)> {
    let n = levels.len();
    let moving = || levels.iter().copied().filter(|&v| v > 0.0);
    let median = median(moving())?;
    // Motion that has reached a part of the sites differs as much.
    if n < 3 || !are_alike(moving(), LOUD) {
        return None;
    }
    let stands_out = |from: usize, end: usize| {
        let least = levels[from..end]
            .iter()
            .fold(f64::INFINITY, |m, v| m.min(*v));
        let beside = [from.checked_sub(1), Some(end).filter(|&end| end < n)];
        let is_low = |j: usize| levels[j] > 0.0 && least > LOUD * levels[j];
        beside.into_iter().flatten().all(is_low)
    };
    let rows = outstanding(n, |j| levels[j] > LOUD * median, stands_out);
    let loudest = rows.iter().map(|&j| levels[j]).reduce(f64::max)?;
    Some((rows, loudest / median))
}

/// Runs of at most two candidates that stand out from those beside them, the end excluded.
fn outstanding(
    n: usize,
    is_candidate: impl Fn(usize) -> bool,
    stands_out: impl Fn(usize, usize) -> bool,
) -> Vec<usize> {
    let mut found = Vec::new();
    let mut from = 0;
    while from < n {
        let end = (from..n).find(|&j| !is_candidate(j)).unwrap_or(n);
        if (1..=TOGETHER).contains(&(end - from)) && stands_out(from, end) {
            found.extend(from..end);
        }
        from = end + 1;
    }
    found
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let sorted = sorted(values);
    sorted.get(sorted.len() / 2).copied()
}

/// Whether the quartiles are within a factor of the median.
fn are_alike(values: impl Iterator<Item = f64>, factor: f64) -> bool {
    let sorted = sorted(values);
    let quantile = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied();
    let (Some(low), Some(median), Some(high)) = (quantile(0.25), quantile(0.5), quantile(0.75))
    else {
        return false;
    };
    high <= factor * median && factor * low >= median
}
