//! Channels whose gain changes while a steady record runs, and what uneven gains spread.

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

/// Share of the energy that amplitudes `a_j` which differ from site to site spread over all wavenumbers, as noise on them does:
/// `sum (a_{j-1} - 2 a_j + a_{j+1})^2 / 6 sum a_j^2`. A dead site is the share of one site, and smooth growth along x next to none.
pub(super) fn uneven(onsets: &[Onset]) -> f64 {
    let of_motion = |onset: &Onset| {
        let square = (2.0 * onset.size).exp() - onset.noise.unwrap_or(0.0).powi(2);
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
    /// Amplitudes after it over those before, beside those of all sites.
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
            ratio: (0.5 * step).exp(),
        })
    });
    let found: Vec<GainChange> = found.collect();
    // Motion that comes and goes at many sites is none of the sensors'.
    if PART * found.len() > sites.len() {
        return Vec::new();
    }
    found
}

fn mean(part: &[f64]) -> f64 {
    part.iter().sum::<f64>() / part.len() as f64
}
