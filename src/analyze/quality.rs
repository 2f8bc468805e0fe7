//! Defects of the data and of its sampling.

use super::{Request, Warning};
use crate::diagnostics::{Bins, SpectrumMoments};
use crate::numeric::{sum, sum_of_squares};
use crate::prepare::{ChannelScan, Window};
use crate::transform::Scaling;

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
    /// The field is a simulated run: no sensor, and sites are all the bodies there are.
    pub simulated: bool,
    pub ends: &'a [Ends],
    pub first_profile: &'a [f64],
    pub last_profile: &'a [f64],
    /// Measures of each site's spectrum.
    pub by_site: Option<&'a [SpectrumMoments]>,
    /// Measures of each time's spectrum.
    pub by_time: Option<&'a [SpectrumMoments]>,
    pub frequency: Bins<'a>,
    pub wavenumber: Bins<'a>,
    /// By how much records are longer with zeros; bin 0 is narrower by that.
    pub padding_time: f64,
}

const ALIASING_SHARE: f64 = 0.01;
/// Share of the top tenth of the axis for spectra as flat as white noise. The effective bandwidth
/// of a periodogram of white noise is 0.66 of the axis, and less for few bins.
const FLAT_SHARE: std::ops::Range<f64> = 0.05..0.15;
const FLAT_PART: f64 = 0.5;
const COMMON_SHARE: f64 = 0.5;
const STATIC_SHARE: f64 = 0.5;
/// A jump between the ends, over the root mean square, and over that of neighbours.
const STEP: f64 = 0.5;
const STEP_OVER_NEIGHBOURS: f64 = 2.0;
/// Energy in a twentieth of the record: three times that of a steady record.
const CUT_SHARE: f64 = 0.15;
/// Equal samples on an extreme that make a record look clipped.
const CLIPPED_RUN: usize = 4;

/// The warnings these findings give rise to.
pub(crate) fn findings(found: &Findings, request: &Request) -> Vec<Warning> {
    let mut warnings = found.of_samples();
    let energy = found.of_ends(|e| e.energy);
    if energy <= 0.0 {
        warnings.push(Warning::NoEnergy);
        return warnings;
    }
    let results = request.results;
    if results.temporal || results.spacetime {
        warnings.extend(found.along_time(request));
    }
    if results.spatial || results.spacetime || results.flux_surrogate {
        warnings.extend(found.along_space(request, energy));
    }
    warnings
}

impl Findings<'_> {
    fn of_ends(&self, part: fn(&Ends) -> f64) -> f64 {
        sum(&self.ends.iter().map(part).collect::<Vec<_>>())
    }

    /// Gaps, dead and saturated channels.
    fn of_samples(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let (n_times, n_sites) = (self.ends.len(), self.scans.len());
        let gaps: u64 = self.scans.iter().map(|s| s.gaps as u64).sum();
        if gaps > 0 {
            warnings.push(Warning::Gaps {
                samples: gaps,
                sites: self.scans.iter().filter(|s| s.gaps > 0).count(),
                share: gaps as f64 / (n_times * n_sites) as f64,
            });
        }
        // Bodies at rest and in free flight are no faults of a sensor.
        if self.simulated {
            return warnings;
        }
        let sites_where = |holds: &dyn Fn(&ChannelScan) -> bool| -> Vec<usize> {
            (0..n_sites)
                .filter(|&j| holds(&self.scans[j]))
                .map(|j| self.first_site + j)
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
            let longest = self.scans.iter().map(|s| s.clipped_run).max();
            warnings.push(Warning::SaturatedChannels {
                sites: clipped,
                longest: longest.unwrap_or_default(),
            });
        }
        warnings
    }

    /// Defects that affect spectra along time.
    fn along_time(&self, request: &Request) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let n_times = self.ends.len();
        let Some(rows) = self.by_site.filter(|_| n_times > 1) else {
            return warnings;
        };
        let total = total(rows, |r| r.total);
        let share = self.padding_time * self::total(rows, |r| r.zero) / total;
        if share > STATIC_SHARE {
            warnings.push(Warning::Static { share });
        }
        if let Some((share, above)) = aliased(rows, &self.frequency) {
            warnings.push(Warning::AliasingTime { share, above });
        }
        // A run ends when it was asked to, and its bodies fly on.
        if self.simulated || request.window_time != Window::None {
            return warnings;
        }
        // A transient that starts from rest is complete when it has decayed. Without losses it
        // never decays, and a taper would weight early sites differently from late ones.
        if n_times > 2 && request.welch.is_none() && self.starts_in_motion() {
            // Totals of rows are sums of squares but for a factor; so are those of all.
            let steps = self.last_profile.iter().zip(self.first_profile);
            let steps: Vec<f64> = steps.map(|(b, a)| (b - a).powi(2)).collect();
            let energy = self.of_ends(|e| e.energy);
            let per_total = energy / total / n_times as f64;
            let mean_square: Vec<f64> = rows.iter().map(|r| r.total * per_total).collect();
            if open_share(rows, &self.frequency, &steps, &mean_square) > 0.5 {
                let step = (sum(&steps) / sum(&mean_square)).sqrt();
                warnings.push(Warning::LeakageTime { step });
            }
        }
        if request.scaling == Scaling::Energy {
            warnings.extend(self.cut());
        }
        warnings
    }

    /// Whether most sites move at the first sample. An impact starts at a few sites; a late or
    /// stationary record has motion at many.
    fn starts_in_motion(&self) -> bool {
        let largest = |v: &[f64]| v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        // Scans are of samples as they are in the file, profiles of prepared ones.
        let level = 0.1 * largest(self.first_profile).max(largest(self.last_profile));
        let moving = self.first_profile.iter().filter(|v| v.abs() > level);
        2 * moving.count() > self.scans.len()
    }

    /// A record that begins in the middle of the motion, or ends while it grows.
    fn cut(&self) -> Option<Warning> {
        let twentieth = self.ends.len() / 20;
        if twentieth == 0 {
            return None;
        }
        let energy = self.of_ends(|e| e.energy);
        let part = |ends: &[Ends]| sum(&ends.iter().map(|e| e.energy).collect::<Vec<_>>()) / energy;
        let first = part(&self.ends[..twentieth]);
        let last = part(&self.ends[self.ends.len() - twentieth..]);
        let starts_late = first > CUT_SHARE && self.starts_in_motion();
        (starts_late || last > CUT_SHARE).then_some(Warning::TransientCut { first, last })
    }

    /// Defects that affect spectra along space.
    fn along_space(&self, request: &Request, energy: f64) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let n_sites = self.scans.len();
        let common = self.of_ends(|e| e.common) / energy;
        if n_sites > 1 && common > COMMON_SHARE {
            warnings.push(Warning::CommonMode { share: common });
        }
        let Some(rows) = self.by_time.filter(|_| !self.simulated && n_sites > 2) else {
            return warnings;
        };
        if let Some((share, above)) = aliased(rows, &self.wavenumber) {
            warnings.push(Warning::AliasingSpace { share, above });
        }
        if request.window_space == Window::None {
            let steps: Vec<f64> = self.ends.iter().map(|e| e.step).collect();
            let mean_square = self.ends.iter().map(|e| e.energy / n_sites as f64);
            let mean_square: Vec<f64> = mean_square.collect();
            if open_share(rows, &self.wavenumber, &steps, &mean_square) > 0.5 {
                let step = (sum(&steps) / sum(&mean_square)).sqrt();
                warnings.push(Warning::LeakageSpace { step });
            }
        }
        warnings
    }
}

fn total(rows: &[SpectrumMoments], part: fn(&SpectrumMoments) -> f64) -> f64 {
    sum(&rows.iter().map(part).collect::<Vec<_>>())
}

/// Share of energy in the top tenth of an axis, and the lower edge of that tenth, if the share
/// suggests aliasing. Not decidable for spectra as flat as noise.
fn aliased(rows: &[SpectrumMoments], bins: &Bins) -> Option<(f64, f64)> {
    let all = total(rows, |r| r.total);
    let share = total(rows, |r| r.top) / all;
    let filled = rows.iter().filter(|r| r.effective_bandwidth.is_finite());
    let filled: Vec<f64> = filled.map(|r| r.effective_bandwidth * r.total).collect();
    let top = bins.centres[bins.len() - 1];
    let is_flat = FLAT_SHARE.contains(&share) && sum(&filled) / all > FLAT_PART * top;
    (share > ALIASING_SHARE && !is_flat).then_some((share, 0.9 * top))
}

/// Share of the energy in rows whose ends do not meet: they are further apart than half the root mean
/// square, and than neighbours are, by far. `steps` are squared.
///
/// Neighbours a step d apart differ in the mean square by `sum p (2 sin(q d / 2))^2`, q in rad, of
/// shares p, at most by `d^2` times the second moment of q, and by 4.
fn open_share(rows: &[SpectrumMoments], bins: &Bins, steps: &[f64], mean_square: &[f64]) -> f64 {
    let per_step = std::f64::consts::PI / bins.top();
    let open = rows.iter().zip(steps).zip(mean_square);
    let open = open.map(|((row, &step), &mean_square)| {
        let second_moment = row.centroid.powi(2) + row.bandwidth.powi(2);
        let neighbours = mean_square * (per_step.powi(2) * second_moment).min(4.0);
        let is_open =
            step > STEP.powi(2) * mean_square && step > STEP_OVER_NEIGHBOURS.powi(2) * neighbours;
        if is_open { mean_square } else { 0.0 }
    });
    sum(&open.collect::<Vec<_>>()) / sum(mean_square)
}
