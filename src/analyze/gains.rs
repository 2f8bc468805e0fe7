//! Gains that step along x, and channels whose gain changes while a steady record runs.

use crate::moved::{Onset, median, piece};
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
/// Standard deviation of a normal variable over the median magnitude of the difference of two, `1 / (0.6745 sqrt 2)`; and of the
/// difference of the medians of two times four of them over theirs, by their order statistics.
const OF_MAGNITUDES: f64 = 1.0484;
const OF_MEDIANS: f64 = 0.7725;

/// A site from which on records are larger or smaller, their motion and their noise alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GainStep {
    pub site: usize,
    /// Amplitudes from it on over those before, and half of the 95 % interval.
    pub ratio: f64,
    pub error: f64,
}

/// Steps between live sites.
pub(super) fn steps(onsets: &[Onset]) -> Vec<GainStep> {
    let sites: Vec<usize> = (0..onsets.len()).filter(|&j| onsets[j].is_live).collect();
    if sites.len() < 2 * BESIDE {
        return Vec::new();
    }
    let size = |i: usize| onsets[sites[i]].sizes[0];
    // Gains that differ from site to site differ beside a step, too: its standard error is that of two medians of four.
    let jumps = (1..sites.len()).map(|i| (size(i) - size(i - 1)).abs());
    let error = OF_MEDIANS * OF_MAGNITUDES * median(jumps);
    let surely = student_two_sided(CHANCE / sites.len() as f64, (sites.len() - 2) as f64);
    let least = LEAST.ln().max(surely * error);
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
        (step, are_alike)
    };
    let is_step = |&i: &usize| {
        let [(motion, are_alike), (noise, noises)] = [0, 1].map(|what| step(i, what));
        are_alike && noises && motion.abs() > least && (noise - motion).abs() < ALIKE * motion.abs()
    };
    // Places beside a step see it, too: it is where the means of both sides differ most.
    let apart = |i: usize| {
        let sum = |sites: std::ops::Range<usize>| sites.map(size).sum::<f64>();
        (sum(i..i + BESIDE) - sum(i - BESIDE..i)).abs()
    };
    let last = sites.len() - BESIDE;
    let most = |i: usize| {
        let near = (i + 1).saturating_sub(BESIDE).max(BESIDE)..=(i + BESIDE - 1).min(last);
        near.max_by(|a, b| apart(*a).total_cmp(&apart(*b)))
            .unwrap_or(i)
    };
    let mut found: Vec<usize> = (BESIDE..=last).filter(is_step).map(most).collect();
    found.dedup();
    let is_largest = |i: &&usize| most(**i) == **i;
    let kept = found.iter().filter(is_largest);
    kept.map(|&i| GainStep {
        site: sites[i],
        ratio: step(i, 0).0.exp(),
        error: step(i, 0).0.exp() * (1.96 * error).exp_m1(),
    })
    .collect()
}

/// Share of the energy that amplitudes `a_j` which differ from site to site spread over all wavenumbers, as noise on them does:
/// `sum (a_{j-1} - 2 a_j + a_{j+1})^2 / 6 sum a_j^2`. A dead site is the share of one site, and smooth growth along x next to none.
pub(super) fn uneven(onsets: &[Onset]) -> f64 {
    let of_motion = |onset: &Onset| {
        let square = (2.0 * onset.sizes[0]).exp() - onset.noise.unwrap_or(0.0).powi(2);
        square.max(0.0).sqrt()
    };
    let amplitudes: Vec<f64> = onsets.iter().map(of_motion).collect();
    let bends = amplitudes.windows(3).map(|a| a[0] - 2.0 * a[1] + a[2]);
    let all: f64 = amplitudes.iter().map(|a| a * a).sum();
    match all > 0.0 {
        true => bends.map(|bend| bend * bend).sum::<f64>() / (6.0 * all),
        false => 0.0,
    }
}

/// A record that becomes larger or smaller from a sample on, while the others do not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GainChange {
    pub site: usize,
    /// The first sample, to a piece of the record.
    pub sample: usize,
    /// Amplitudes after it over those before.
    pub ratio: f64,
}

/// Changes at live sites of a record of `samples`: the step of `ln e_j(i) - median_j ln e_j(i)` over the pieces i, twice that of the amplitudes.
pub(super) fn changes(onsets: &[Onset], samples: usize) -> Vec<GainChange> {
    let sites: Vec<usize> = (0..onsets.len()).filter(|&j| onsets[j].is_live).collect();
    let pieces = onsets.first().map_or(0, |onset| onset.levels.len());
    if sites.len() < SITES || pieces < 2 * SIDE || piece(samples) < SAMPLES {
        return Vec::new();
    }
    let level = |j: usize, i: usize| f64::from(onsets[j].levels[i]);
    let own = |j: usize| median((0..pieces).map(|i| level(j, i)));
    let owns: Vec<f64> = sites.iter().map(|&j| own(j)).collect();
    let common = (0..pieces).map(|i| {
        let levels = sites.iter().zip(&owns).map(|(&j, own)| level(j, i) - own);
        median(levels)
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
