//! Gains that step along x.

use std::ops::Range;

use serde_json::json;

use super::look::{BANDS, Look};
use super::{Found, some};
use crate::numeric::{median, sorted, student_two_sided};
use crate::sheet::with_half;

/// Sites on each side of a step of the gain, and how much bands and sites may differ, as a part of the step's logarithm; the least step; the
/// probability by which chance makes one anywhere.
const SIDE: usize = 4;
const UNEVEN: f64 = 0.3;
const LEAST: f64 = 1.5;
const CHANCE: f64 = 1e-3;
/// Standard deviation of a normal variable over the median magnitude of the difference of two, `1 / (0.6745 sqrt 2)`; and of the
/// difference of the medians of two times four of them over theirs, by their order statistics.
const OF_MAGNITUDES: f64 = 1.0484;
const OF_MEDIANS: f64 = 0.7725;

impl Look<'_> {
    /// Rows from which on records are larger or smaller, in all bands alike; by how much, with half of the 95 % interval.
    pub fn steps(&self) -> Found {
        let live = self.live();
        if live.len() < 2 * SIDE {
            return Default::default();
        }
        let of = |i: usize, band: usize| self.records[live[i]].log_power(band);
        let size = |i: usize| self.records[live[i]].level.ln();
        // Gains that differ from site to site differ beside a step, too: its standard error is that of two medians of four.
        let jumps = (1..live.len()).map(|i| (size(i) - size(i - 1)).abs());
        let error = OF_MEDIANS * OF_MAGNITUDES * median(jumps).unwrap_or(0.0);
        let surely = student_two_sided(CHANCE / live.len() as f64, (live.len() - 2) as f64);
        let least = LEAST.ln().max(surely * error);
        let step = |i: usize, of: &dyn Fn(usize) -> f64| {
            let side = |sites: Range<usize>| {
                let sizes = sorted(sites.map(of));
                // One of them may be loud by itself.
                let spread = (sizes[SIDE - 1] - sizes[1]).min(sizes[SIDE - 2] - sizes[0]);
                (0.5 * (sizes[1] + sizes[2]), spread)
            };
            let (before, after) = (side(i - SIDE..i), side(i..i + SIDE));
            (after.0 - before.0, before.1.max(after.1))
        };
        let is_step = |i: &usize| {
            let (all, _) = step(*i, &size);
            let is_like = |band: usize| {
                let (one, spread) = step(*i, &|i| of(i, band));
                spread < UNEVEN * all.abs().max(LEAST.ln())
                    && (one - all).abs() < UNEVEN * all.abs()
            };
            all.abs() > least && (0..BANDS).all(is_like)
        };
        // Places beside a step see it, too: it is where the sums of both sides and neighbours differ most.
        let change = |i: usize| {
            let sum = |sites: Range<usize>| sites.map(size).sum::<f64>();
            sum(i..i + SIDE) - sum(i - SIDE..i) + 2.0 * (size(i) - size(i - 1))
        };
        let last = live.len() - SIDE;
        let most = |i: usize| {
            let near = (i + 1).saturating_sub(SIDE).max(SIDE)..=(i + SIDE - 1).min(last);
            let way = step(i, &size).0.signum();
            let along = |i: &usize| way * change(*i);
            let most = near.max_by(|a, b| along(a).total_cmp(&along(b)));
            most.unwrap_or(i)
        };
        let mut found: Vec<usize> = (SIDE..=last).filter(is_step).map(most).collect();
        found.dedup();
        let is_largest = |i: &&usize| most(**i) == **i;
        let found: Vec<usize> = found.iter().filter(is_largest).copied().collect();
        let ratios: Vec<f64> = found.iter().map(|&i| step(i, &size).0.exp()).collect();
        let half = (1.96 * error).exp_m1();
        let errors: Vec<f64> = ratios.iter().map(|ratio| ratio * half).collect();
        let said = ratios.iter().zip(&errors);
        let said = said.map(|(ratio, error)| format!("x {}", with_half(*ratio, *error, "")));
        let rows = found.iter().map(|&i| live[i]).collect();
        let numbers = json!({"ratios": ratios, "ratio_errors": errors});
        (rows, some(said), numbers)
    }
}
