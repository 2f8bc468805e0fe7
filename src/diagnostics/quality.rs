//! What is wrong with the data, or with how it was sampled.

use crate::analyze::{Request, Scaling, Warning};
use crate::prepare::{ChannelScan, Window};
use crate::sum::{sum, sum_of_squares};

/// What the pass over profiles notes of each.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Ends {
    /// `sum_j v^2`.
    pub energy: f64,
    /// `(sum_j v)^2 / N`: its part at k = 0.
    pub common: f64,
    /// `(v_last - v_first)^2`.
    pub step: f64,
}

impl Ends {
    pub fn of(profile: &[f64]) -> Ends {
        let total = sum(profile);
        Ends {
            energy: sum_of_squares(profile),
            common: total * total / profile.len() as f64,
            step: (profile[profile.len() - 1] - profile[0]).powi(2),
        }
    }
}

/// What the passes over the field found, as far as they were made.
#[derive(Debug)]
pub(crate) struct Findings<'a> {
    pub scans: &'a [ChannelScan],
    pub first_site: usize,
    pub ends: &'a [Ends],
    pub first_profile: &'a [f64],
    pub last_profile: &'a [f64],
    /// Share of energy in the top tenth of the axis, and where that begins.
    pub top_frequency: Option<(f64, f64)>,
    pub top_wavenumber: Option<(f64, f64)>,
}

const ALIASING_SHARE: f64 = 0.01;
const COMMON_SHARE: f64 = 0.5;
const STEP: f64 = 0.5;
const CUT_SHARE: f64 = 0.02;
/// Equal samples on an extreme that make a record look clipped.
const CLIPPED_RUN: usize = 4;

/// The warnings these findings give rise to.
pub(crate) fn findings(found: &Findings, request: &Request) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let n_times = found.ends.len();
    let n_sites = found.scans.len();
    let of_ends = |part: fn(&Ends) -> f64| sum(&found.ends.iter().map(part).collect::<Vec<_>>());
    let energy = of_ends(|e| e.energy);

    let gaps: u64 = found.scans.iter().map(|s| s.gaps as u64).sum();
    if gaps > 0 {
        warnings.push(Warning::Gaps {
            samples: gaps,
            sites: found.scans.iter().filter(|s| s.gaps > 0).count(),
            share: gaps as f64 / (n_times * n_sites) as f64,
        });
    }
    let sites_where = |holds: &dyn Fn(&ChannelScan) -> bool| -> Vec<usize> {
        (0..n_sites)
            .filter(|&j| holds(&found.scans[j]))
            .map(|j| found.first_site + j)
            .collect()
    };
    if n_times > 1 {
        let dead = sites_where(&|s| s.constant);
        if !dead.is_empty() {
            warnings.push(Warning::DeadChannels { sites: dead });
        }
    }
    let clipped = sites_where(&|s| s.clipped_run >= CLIPPED_RUN);
    if !clipped.is_empty() {
        let longest = found.scans.iter().map(|s| s.clipped_run).max();
        warnings.push(Warning::SaturatedChannels {
            sites: clipped,
            longest: longest.unwrap_or_default(),
        });
    }
    if energy <= 0.0 {
        warnings.push(Warning::NoEnergy);
        return warnings;
    }

    if let Some((share, above)) = found.top_frequency.filter(|t| t.0 > ALIASING_SHARE) {
        warnings.push(Warning::AliasingTime { share, above });
    }
    if let Some((share, above)) = found.top_wavenumber.filter(|t| t.0 > ALIASING_SHARE) {
        warnings.push(Warning::AliasingSpace { share, above });
    }
    let common = of_ends(|e| e.common) / energy;
    if n_sites > 1 && common > COMMON_SHARE {
        warnings.push(Warning::CommonMode { share: common });
    }
    let mean_square = energy / (n_times * n_sites) as f64;
    if n_times > 2 && request.window_time == Window::None {
        let steps = found.last_profile.iter().zip(found.first_profile);
        let steps: Vec<f64> = steps.map(|(b, a)| b - a).collect();
        let step = (sum_of_squares(&steps) / n_sites as f64 / mean_square).sqrt();
        if step > STEP {
            warnings.push(Warning::LeakageTime { step });
        }
    }
    if n_sites > 2 && request.window_space == Window::None {
        let step = (of_ends(|e| e.step) / n_times as f64 / mean_square).sqrt();
        if step > STEP {
            warnings.push(Warning::LeakageSpace { step });
        }
    }
    let twentieth = n_times / 20;
    if twentieth > 0 && request.scaling == Scaling::Energy && request.window_time == Window::None {
        let part = |ends: &[Ends]| sum(&ends.iter().map(|e| e.energy).collect::<Vec<_>>()) / energy;
        let first = part(&found.ends[..twentieth]);
        let last = part(&found.ends[n_times - twentieth..]);
        if first > CUT_SHARE || last > CUT_SHARE {
            warnings.push(Warning::TransientCut { first, last });
        }
    }
    warnings
}
