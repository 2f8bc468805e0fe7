//! Channels that differ from those beside them as motion does not: dead, quiet, loud, noisy.

use super::look::Look;
use super::neighbours::SAME;
use crate::numeric::{median, sorted};

/// How much louder or quieter than those beside it a site is that is too loud or quiet.
pub(super) const LOUD: f64 = 100.0;
/// Neighbours that are too loud, quiet or noisy together, at most.
const TOGETHER: usize = 2;
/// Equal samples on an extreme that make a record look clipped.
pub(super) const CLIPPED_RUN: usize = 4;
/// Energy in the top tenth of the frequency axis over that of the sites beside it; how much these may exceed
/// the median; its least share of the site's energy.
const NOISY: f64 = 30.0;
const NOISY_ALIKE: f64 = 10.0;
const NOISY_SHARE: f64 = 1e-4;
/// Sites on each side that a noisy one is held against.
const BESIDE: usize = 2;

impl Look<'_> {
    /// Constant records, but for nodes of standing waves. Sites of nothing but zeros that reach an end of the array may be ahead of a front: none
    /// is dead if the first that moves is as quiet as a front begins.
    pub fn dead(&self) -> Vec<usize> {
        let n = self.records.len();
        if self.samples < 2 {
            return Vec::new();
        }
        let largest = |j: usize| match self.records[j].scan {
            scan if scan.constant => scan.largest,
            _ => self.records[j].level,
        };
        let most = (0..n).map(largest).fold(0.0, f64::max);
        let is_zero = |j: &usize| largest(*j) == 0.0;
        let is_front = |j: Option<usize>| j.is_some_and(|j| LOUD * largest(j) < most);
        let [head, tail] = [
            (0..n).find(|j| !is_zero(j)).filter(|j| is_front(Some(*j))),
            (0..n).rfind(|j| !is_zero(j)).filter(|j| is_front(Some(*j))),
        ];
        let is_ahead = |j: usize| head.is_some_and(|head| j < head) || tail.is_some_and(|t| j > t);
        let moves = |j: usize| self.records.get(j).is_some_and(|row| row.level > 0.0);
        let is_node = |j: usize| match j {
            _ if j > 0 && moves(j - 1) && moves(j + 1) => self.is_node(j - 1, j + 1),
            0 if moves(1) && moves(2) => self.falls_to_rest(1, 2),
            _ if j >= 2 && j + 1 == n && moves(j - 1) && moves(j - 2) => {
                self.falls_to_rest(j - 1, j - 2)
            }
            _ => false,
        };
        let is_dead = |j: &usize| {
            let is_constant = self.records[*j].scan.constant && !self.is_left_out(*j);
            is_constant && !is_ahead(*j) && !is_node(*j)
        };
        (0..n).filter(is_dead).collect()
    }

    /// Sites that move: neither constant nor left out.
    pub fn live(&self) -> Vec<usize> {
        let lives = |j: &usize| self.records[*j].level > 0.0 && !self.is_left_out(*j);
        (0..self.records.len()).filter(lives).collect()
    }

    /// Sites far quieter than both beside them, while most are alike; the least part of these. A node of a
    /// standing wave is quiet, too: there the sites beside it cancel.
    pub fn quiet(&self, levels: &[f64]) -> Option<(Vec<usize>, f64)> {
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
            is_quiet && !self.is_node(live[before], live[end])
        };
        let rows = outstanding(live.len(), |i| LOUD * level(i) < median, stands_out);
        let rows: Vec<usize> = rows.into_iter().map(|i| live[i]).collect();
        let least = rows.iter().map(|&j| levels[j]).reduce(f64::min)?;
        Some((rows, least / median))
    }

    /// Whether the records beside a site, or two, are opposite: motion is least between them.
    fn is_node(&self, before: usize, after: usize) -> bool {
        let [a, b] = [before, after].map(|row| self.read(row));
        dot(&a, &b) < -SAME * (dot(&a, &a) * dot(&b, &b)).sqrt()
    }

    /// Whether the line through two records leads to rest at the site before them, as at a fixed end.
    fn falls_to_rest(&self, near: usize, far: usize) -> bool {
        let [a, b] = [near, far].map(|row| self.read(row));
        let expected: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 2.0 * a - b).collect();
        dot(&expected, &expected) < SAME * SAME * dot(&a, &a)
    }

    /// Sites with far more energy in the top tenth of the frequency axis than those beside them, while these are
    /// alike; over that of those beside them. Not those that are `loud` anyway, nor those at an end of the array, where
    /// motion that is driven there may die away from one site to the next.
    pub fn noisy(&self, loud: &[usize]) -> Option<(Vec<usize>, f64)> {
        let live = self.live();
        let top = |i: usize| self.records[live[i]].top_power();
        let median = median((0..live.len()).map(top)).filter(|median| *median > 0.0)?;
        let is_high = |i: usize| {
            let row = &self.records[live[i]];
            row.top_power() > NOISY * median
                && row.top > NOISY_SHARE
                // The ends of gaps leak.
                && row.scan.gaps == 0
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

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Whether all sites beside a run, up to two on each side, are as wanted.
fn both(from: usize, end: usize, n: usize, wanted: impl Fn(usize) -> bool) -> bool {
    let before = (0..from).rev().take(BESIDE);
    before.chain((end..n).take(BESIDE)).all(wanted)
}

/// Sites far louder than those beside them, while these are alike: one gain that is wrong; over the median.
pub(super) fn loud(levels: &[f64]) -> Option<(Vec<usize>, f64)> {
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
