//! Gains that step along x, and channels whose gain changes while a steady record runs.

use super::along_x::median;
use super::onset::{Onset, piece};
use crate::numeric::student_two_sided;

/// Pieces on each side of a change, at least.
const SIDE: usize = 4;
/// Samples of a piece, at least: levels of fewer scatter too much.
const SAMPLES: usize = 32;
/// The least ratio of amplitudes, and the probability by which chance makes such a change in any record.
const LEAST: f64 = 1.5;
const CHANCE: f64 = 1e-3;
/// Sites that make up a common level, at least, and the largest part of them that may change.
const SITES: usize = 6;
const PART: usize = 4;

/// Sites on each side of a step along x, and how much they may differ, and motion and noise step apart, as a part of the step's
/// logarithm.
const BESIDE: usize = 4;
const ALIKE: f64 = 0.3;

/// A site from which on records are larger or smaller, their motion and their noise alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GainStep {
    pub site: usize,
    /// Amplitudes from it on over those before.
    pub ratio: f64,
}

/// Steps between `live` sites.
pub(super) fn steps(onsets: &[Onset], live: &[bool]) -> Vec<GainStep> {
    let sites: Vec<usize> = (0..onsets.len()).filter(|&j| live[j]).collect();
    let step = |i: usize, what: usize| {
        let side = |sites: &[usize]| {
            let mut sizes: Vec<f64> = sites.iter().map(|&j| onsets[j].sizes[what]).collect();
            sizes.sort_by(f64::total_cmp);
            // One of them may be loud by itself.
            let spread = (sizes[BESIDE - 1] - sizes[1]).min(sizes[BESIDE - 2] - sizes[0]);
            (0.5 * (sizes[1] + sizes[2]), spread)
        };
        let (before, after) = (side(&sites[i - BESIDE..i]), side(&sites[i..i + BESIDE]));
        let step = after.0 - before.0;
        let are_alike = before.1.max(after.1) < ALIKE * step.abs().max(LEAST.ln());
        are_alike.then_some(step)
    };
    let places = BESIDE..(sites.len() + 1).saturating_sub(BESIDE);
    let found: Vec<(usize, f64)> = places
        .filter_map(|i| {
            let (motion, noise) = (step(i, 0)?, step(i, 1)?);
            let is_step =
                motion.abs() > LEAST.ln() && (noise - motion).abs() < ALIKE * motion.abs();
            is_step.then_some((i, motion))
        })
        .collect();
    // Places beside a step see it, too: it is where neighbours differ most.
    let jump = |i: usize| (onsets[sites[i]].sizes[0] - onsets[sites[i - 1]].sizes[0]).abs();
    let is_largest = |&&(i, _): &&(usize, f64)| {
        let mut near = found.iter().map(|(other, _)| *other);
        near.all(|other| other.abs_diff(i) >= BESIDE || other == i || jump(other) < jump(i))
    };
    let kept = found.iter().filter(is_largest);
    kept.map(|(i, step)| GainStep {
        site: sites[*i],
        ratio: step.exp(),
    })
    .collect()
}

/// A record that becomes larger or smaller from a sample on, while the others do not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GainChange {
    pub site: usize,
    /// The first sample, to a piece of the record.
    pub sample: usize,
    /// Amplitudes after it over those before.
    pub ratio: f64,
}

/// Changes at `live` sites of a record of `samples`: the step of `ln e_j(i) - median_j ln e_j(i)` over the pieces i, twice that of the amplitudes.
pub(super) fn changes(onsets: &[Onset], live: &[bool], samples: usize) -> Vec<GainChange> {
    let sites: Vec<usize> = (0..onsets.len()).filter(|&j| live[j]).collect();
    let pieces = onsets.first().map_or(0, |onset| onset.levels.len());
    if sites.len() < SITES || pieces < 2 * SIDE || piece(samples) < SAMPLES {
        return Vec::new();
    }
    let level = |j: usize, i: usize| f64::from(onsets[j].levels[i]);
    let own = |j: usize| median(&mut (0..pieces).map(|i| level(j, i)).collect::<Vec<_>>());
    let owns: Vec<f64> = sites.iter().map(|&j| own(j)).collect();
    let common = (0..pieces).map(|i| {
        let levels = sites.iter().zip(&owns).map(|(&j, own)| level(j, i) - own);
        median(&mut levels.collect::<Vec<_>>())
    });
    let common: Vec<f64> = common.collect();
    // At any site and any piece.
    let chance = CHANCE / (sites.len() * pieces) as f64;
    let errors = student_two_sided(chance, (pieces - 2) as f64);
    let found = sites.iter().filter_map(|&j| {
        let rest: Vec<f64> = (0..pieces).map(|i| level(j, i) - common[i]).collect();
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let squares = |part: &[f64]| {
            let mean = mean(part);
            part.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
        };
        let within = |at: &usize| squares(&rest[..*at]) + squares(&rest[*at..]);
        let at = (SIDE..=pieces - SIDE).min_by(|a, b| within(a).total_cmp(&within(b)))?;
        let step = mean(&rest[at..]) - mean(&rest[..at]);
        let deviation = (within(&at) / (pieces - 2) as f64).sqrt();
        let error = deviation * (1.0 / at as f64 + 1.0 / (pieces - at) as f64).sqrt();
        let changes = step.abs() > (2.0 * LEAST.ln()).max(errors * error);
        changes.then(|| GainChange {
            site: j,
            sample: at * piece(samples),
            ratio: ratio(onsets, beside(&sites, j), j, at),
        })
    });
    let found: Vec<GainChange> = found.collect();
    // Motion that comes and goes at many sites is none of the sensors'.
    match PART * found.len() <= sites.len() {
        true => found,
        false => Vec::new(),
    }
}

/// Up to two of the `sites` on each side of j.
fn beside(sites: &[usize], j: usize) -> impl Iterator<Item = usize> + '_ {
    let at = sites.partition_point(|site| *site < j);
    let around = at.saturating_sub(2)..(at + 3).min(sites.len());
    around.map(|i| sites[i]).filter(move |site| *site != j)
}

/// Amplitudes at site j after the piece `at` over those before, beside those of its neighbours.
fn ratio(onsets: &[Onset], beside: impl Iterator<Item = usize>, j: usize, at: usize) -> f64 {
    let grows = |j: usize| {
        let energies = onsets[j].levels.iter().map(|level| f64::from(*level).exp());
        let (before, after): (Vec<_>, Vec<_>) = energies.enumerate().partition(|(i, _)| *i < at);
        let mean =
            |part: Vec<(usize, f64)>| part.iter().map(|(_, e)| e).sum::<f64>() / part.len() as f64;
        mean(after) / mean(before)
    };
    let others: Vec<f64> = beside.map(grows).collect();
    let common = others.iter().map(|ratio| ratio.ln()).sum::<f64>() / others.len() as f64;
    (grows(j) / common.exp()).sqrt()
}
