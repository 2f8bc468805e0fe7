//! Channels that differ from those beside them as motion does not: dead, quiet, loud, noisy.

use serde_json::json;

use super::Found;
use super::look::Look;
use super::neighbours::SAME;
use crate::numeric::{median, sorted};

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
        let is_front = |j: &usize| LOUD * largest(*j) < most;
        let is_some = |j: &usize| largest(*j) > 0.0;
        let head = (0..n).find(is_some).filter(is_front).unwrap_or(0);
        let tail = (0..n).rfind(is_some).filter(is_front).unwrap_or(n);
        let is_dead = |&j: &usize| self.records[j].scan.constant && !self.may_rest(j);
        (head..n.min(tail + 1)).filter(is_dead).collect()
    }

    /// Sites that move: neither constant nor left out.
    pub fn live(&self) -> Vec<usize> {
        let lives = |j: &usize| self.records[*j].level > 0.0;
        (0..self.records.len()).filter(lives).collect()
    }

    /// Records on their extreme value for long.
    pub fn clipped(&self) -> Found {
        let run = |j: &usize| self.records[*j].scan.clipped_run;
        let rows = (0..self.records.len()).filter(|j| run(j) >= CLIPPED_RUN);
        let rows: Vec<usize> = rows.collect();
        let longest = rows.iter().map(run).max().unwrap_or(0);
        (rows, longest.to_string(), json!({"longest": longest}))
    }

    /// Sites far quieter, and far louder, than those beside them, while most are alike; the least and the largest over the median. A node of
    /// a standing wave is quiet, too: there the sites beside it cancel.
    pub fn quiet_and_loud(&self) -> [(Vec<usize>, f64); 2] {
        let live = self.live();
        let levels: Vec<f64> = live.iter().map(|&j| self.records[j].level).collect();
        let sorted = sorted(levels.iter().copied());
        // Motion that has reached a part of the sites differs as much.
        let quartiles = [1, 2, 3].map(|quarter| sorted.get(quarter * sorted.len() / 4));
        let ([Some(low), Some(middle), Some(high)], 3..) = (quartiles, live.len()) else {
            return Default::default();
        };
        if *high > LOUD * middle || LOUD * low < *middle {
            return Default::default();
        }
        let over_median = |rows: &[usize], of: fn(f64, f64) -> f64| {
            let worst = rows.iter().map(|&i| levels[i]).reduce(of).unwrap_or(0.0);
            let rows = rows.iter().map(|&i| live[i]).collect();
            (rows, worst / median(levels.iter().copied()).unwrap_or(1.0))
        };
        let is_quiet = |from: usize, end: usize| {
            let is_inside = from > 0 && end < live.len();
            is_inside && !self.is_node(live[from - 1], live[end])
        };
        let quietness: Vec<f64> = levels.iter().map(|level| 1.0 / level).collect();
        let quiet = outstanding(&quietness, LOUD, 1, is_quiet);
        let loud = outstanding(&levels, LOUD, 1, |_, _| true);
        [over_median(&quiet, f64::min), over_median(&loud, f64::max)]
    }

    /// Whether a site between those that move may be at rest: at a node of a standing wave, or at a fixed end.
    fn may_rest(&self, j: usize) -> bool {
        let moves = |j: usize| self.records.get(j).is_some_and(|row| row.level > 0.0);
        let n = self.records.len();
        match j {
            0 => moves(1) && moves(2) && self.falls_to_rest(1, 2),
            _ if j + 1 == n => {
                j >= 2 && moves(j - 1) && moves(j - 2) && self.falls_to_rest(j - 1, j - 2)
            }
            _ => moves(j - 1) && moves(j + 1) && self.is_node(j - 1, j + 1),
        }
    }

    /// Whether the records beside a site, or two, are opposite: motion is least between them.
    fn is_node(&self, before: usize, after: usize) -> bool {
        let [a, b] = [before, after].map(|row| self.motion(row));
        dot(&a, &b) < -SAME * (dot(&a, &a) * dot(&b, &b)).sqrt()
    }

    /// Whether the line through two records leads to rest at the site before them, as at a fixed end.
    fn falls_to_rest(&self, near: usize, far: usize) -> bool {
        let [a, b] = [near, far].map(|row| self.motion(row));
        let expected: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 2.0 * a - b).collect();
        dot(&expected, &expected) < SAME * SAME * dot(&a, &a)
    }

    /// Sites with far more energy in the top tenth of the frequency axis than those beside them, while these are
    /// alike; over that of those beside them. Not those that are `loud` anyway, nor those at an end of the array, where
    /// motion that is driven there may die away from one site to the next.
    pub fn noisy(&self, loud: &[usize]) -> (Vec<usize>, f64) {
        let live = self.live();
        let top: Vec<f64> = live.iter().map(|&j| self.records[j].top_power()).collect();
        let middle = median(top.iter().copied()).unwrap_or(0.0);
        let is_noisy = |from: usize, end: usize| {
            // The ends of gaps leak.
            let may_be = |&j: &usize| {
                let row = &self.records[j];
                row.top > NOISY_SHARE && row.scan.gaps == 0 && !loud.contains(&j)
            };
            let mut beside = beside(&top, from, end, BESIDE);
            from > 0
                && end < live.len()
                && live.len() > 2 * BESIDE + TOGETHER
                && live[from..end].iter().all(may_be)
                && beside.all(|top| top < NOISY_ALIKE * middle)
        };
        let found = outstanding(&top, NOISY, BESIDE, is_noisy);
        let runs = found.chunk_by(|a, b| a + 1 == *b);
        let over_beside = runs.map(|run| {
            let (from, end) = (run[0], run[run.len() - 1] + 1);
            let own = top[from..end].iter().copied().fold(0.0, f64::max);
            own / beside(&top, from, end, BESIDE).fold(f64::MIN_POSITIVE, f64::max)
        });
        let ratio = over_beside.fold(0.0, f64::max);
        (found.into_iter().map(|i| live[i]).collect(), ratio)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Values beside a run, up to `most` on each side.
fn beside(values: &[f64], from: usize, end: usize, most: usize) -> impl Iterator<Item = f64> {
    let before = &values[from.saturating_sub(most)..from];
    let after = &values[end..values.len().min(end + most)];
    before.iter().chain(after).copied()
}

/// Runs of at most two sites that are `factor` times above the median, and above those up to `most` beside them, where they
/// may be at fault.
fn outstanding(
    values: &[f64],
    factor: f64,
    most: usize,
    may_be: impl Fn(usize, usize) -> bool,
) -> Vec<usize> {
    let Some(median) = median(values.iter().copied()).filter(|median| *median > 0.0) else {
        return Vec::new();
    };
    let is_high = |v: &f64| *v > factor * median;
    let (mut found, mut from) = (Vec::new(), 0);
    for run in values.chunk_by(|a, b| is_high(a) == is_high(b)) {
        let end = from + run.len();
        let least = run.iter().copied().fold(f64::INFINITY, f64::min);
        let stands_out = is_high(&run[0])
            && run.len() <= TOGETHER
            && beside(values, from, end, most).all(|v| factor * v < least)
            && may_be(from, end);
        if stands_out {
            found.extend(from..end);
        }
        from = end;
    }
    found
}
