//! Defects of the data and of its sampling.

use num_complex::Complex;
use serde_json::json;

use super::Warning;
use super::aliasing::aliased;
use super::columns::TemporalPassResult;
use super::rows::SpatialPassResult;
use super::spacetime::Frequencies;
use super::stages::Stages;
use crate::diagnostics::{Bins, SpectrumMoments};
use crate::numeric::{sum, sum_of, sum_of_squares};
use crate::prepare::{ChannelScan, Window};
use crate::sheet::{number, percent, six_digits, three_digits};
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
pub(super) struct Findings<'a> {
    pub all: &'a Stages<'a>,
    pub scans: &'a [ChannelScan],
    /// The field is a simulated run: no sensor, and sites are all the bodies there are.
    pub simulated: bool,
    pub has_fronts: bool,
    pub rows: &'a SpatialPassResult,
    pub columns: Option<&'a TemporalPassResult>,
    pub spacetime: Option<&'a Frequencies>,
}

/// The effective bandwidth of a periodogram of white noise is 0.66 of the axis, and less for few bins.
pub(super) const FLAT_PART: f64 = 0.5;
const COMMON_SHARE: f64 = 0.5;
/// Sites from which on what is common to all is told from a long wave.
const COMMON_SITES: usize = 5;
/// The same of a single line; bins on each side that it fills, and its part of what is common.
const COMMON_LINE: f64 = 0.2;
/// Error of a frequency, as a part of it, up to which it is not said.
const KNOWN: f64 = 0.01;
const LINE_BINS: usize = 2;
const LINE_PART: f64 = 0.8;
/// Sites at each end of the array whose phase is compared, at most, and the cosine of their difference from which on it is one.
const ENDS: usize = 4;
const IN_PHASE: f64 = 0.9;
const STATIC_SHARE: f64 = 0.5;
/// A jump between the ends, over the root mean square, and over that of neighbours.
const STEP: f64 = 0.5;
const STEP_OVER_NEIGHBOURS: f64 = 2.0;
/// The energy that a jump leaks into the top tenth of the axis, where `|V|^2` is a quarter of its
/// square, over its square; and the least part of what is there that it makes up.
const LEAKED: f64 = 0.025;
const LEAKED_PART: f64 = 0.6;
/// Times without any motion that look like a recording that dropped out.
const ZERO_RUN: usize = 2;
/// Level of a start-up transient over that of the second half of the record: at its first sample, and
/// until it is over; by how much the rest may differ; its least share of the energy.
const START_LEVEL: f64 = 16.0;
const STARTED_LEVEL: f64 = 4.0;
const START_SHARE: f64 = 0.02;
/// Standard deviations of the energy of white noise in a part of the record.
const NOISE_DEVIATIONS: f64 = 6.0;
/// Energy in a twentieth of the record: three times that of a steady record.
const CUT_SHARE: f64 = 0.15;

impl Findings<'_> {
    /// The warnings these findings give rise to.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let energy = self.of_ends(|e| e.energy);
        if energy <= 0.0 {
            let advice = "check the range, the layout and the detrending";
            let warning = Warning::new("the prepared field is zero everywhere", advice);
            warnings.push(warning.coded("no-energy", json!({})));
            return warnings;
        }
        if !self.simulated {
            warnings.extend(self.zero_times());
        }
        let results = self.all.plan.request.results;
        if results.temporal || results.spacetime {
            warnings.extend(self.along_time());
        }
        if results.spatial || results.spacetime || results.flux_surrogate {
            warnings.extend(self.along_space(energy));
        }
        warnings
    }

    fn of_ends(&self, part: fn(&Ends) -> f64) -> f64 {
        sum_of(self.rows.ends.iter().map(part))
    }

    /// Defects that affect spectra along time.
    fn along_time(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let (plan, request) = (self.all.plan, &self.all.plan.request);
        let n_times = self.rows.ends.len();
        let Some(columns) = self.columns.filter(|_| n_times > 1) else {
            return warnings;
        };
        let (rows, bins) = (&columns.rows[..], &plan.frequency_bins());
        let total = total(rows, |r| r.total);
        let share = plan.padding_time() * self::total(rows, |r| r.zero) / total;
        if share > STATIC_SHARE {
            let message = format!(
                "{} of the energy lies at f = 0: means of the records, not their motion, decide centroids",
                percent(share)
            );
            let advice =
                "if they are offsets of the instrument, remove them with `--detrend-time mean`";
            let numbers = json!({"share": share});
            warnings.push(Warning::new(message, advice).coded("static", numbers));
        }
        let found = aliased(rows, bins, || self.sweeps(rows));
        let advice = "sample faster, or low-pass before sampling; energy above Nyquist folds down";
        warnings.extend(found.map(|found| of_top("aliasing-time", "frequency", found, advice)));
        // A run ends when it was asked to, and its bodies fly on.
        if self.simulated || request.window_time != Window::None {
            return warnings;
        }
        // A transient that starts from rest is complete when it has decayed. Without losses it
        // never decays, and a taper would weight early sites differently from late ones.
        if n_times > 2 && request.welch.is_none() && self.starts_in_motion() {
            // Totals of rows are sums of squares but for a factor; so are those of all.
            let steps = self.rows.last_profile.iter().zip(&self.rows.first_profile);
            let steps: Vec<f64> = steps.map(|(b, a)| (b - a).powi(2)).collect();
            let energy = self.of_ends(|e| e.energy);
            let per_total = energy / total / n_times as f64;
            let mean_square: Vec<f64> = rows.iter().map(|r| r.total * per_total).collect();
            if let Some(step) = jump(rows, bins, &steps, &mean_square, n_times) {
                let advice = "for a stationary record use `--window-time hann` or remove the trend; for a transient \
                              record until it has died down";
                let what = "records jump from their last to their first sample";
                warnings.push(of_jump("leakage-time", what, step, advice));
            }
        }
        let start_up = self.start_up();
        if request.scaling == Scaling::Energy {
            warnings.extend(self.cut(start_up.is_some(), flat_part(rows, bins)));
        }
        warnings.extend(start_up);
        warnings
    }

    /// Whether most sites move at the first sample. An impact starts at a few sites; a late or
    /// stationary record has motion at many.
    fn starts_in_motion(&self) -> bool {
        let largest = |v: &[f64]| v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        // Scans are of samples as they are in the file, profiles of prepared ones.
        let [first, last] = [&self.rows.first_profile, &self.rows.last_profile];
        let level = 0.1 * largest(first).max(largest(last));
        let moving = first.iter().filter(|v| v.abs() > level);
        2 * moving.count() > self.scans.len()
    }

    /// Times at which nothing moves, between others: two or more in a row.
    fn zero_times(&self) -> Option<Warning> {
        let moves = |n: &usize| self.rows.ends[*n].energy > 0.0;
        let all = 0..self.rows.ends.len();
        let (first, last) = (all.clone().find(moves)?, all.clone().rfind(moves)?);
        let mut zeros = Vec::new();
        let mut from = first;
        while from < last {
            let end = (from..=last).find(moves).unwrap_or(last);
            if end - from >= ZERO_RUN {
                zeros.extend(from..end);
            }
            from = end + 1;
        }
        let (&first, &last) = (zeros.first()?, zeros.last()?);
        let [first, last] = [first, last].map(|row| self.all.plan.times.start + row);
        let times = zeros.len();
        let message = format!(
            "all sites are zero at {times} times between others, from row {first} to row {last}"
        );
        let advice = "where the recording dropped out, state `nan` there and `--gaps interpolate`";
        let numbers = json!({"times": times, "first": first, "last": last});
        let warning = Warning::new(message, advice).coded("zero-times", numbers);
        (self.scans.len() > 1).then_some(warning)
    }

    /// A transient of all sites at the start of a record that is steady from its twentieth part on.
    fn start_up(&self) -> Option<Warning> {
        let ends = &self.rows.ends;
        let n = ends.len();
        let twentieth = n / 20;
        let mean = |part: &[Ends]| sum_of(part.iter().map(|e| e.energy)) / part.len() as f64;
        if twentieth == 0 || !self.starts_in_motion() {
            return None;
        }
        let late = mean(&ends[n / 2..]);
        let early = mean(&ends[twentieth..n / 2]);
        let is_high = |e: &&Ends| e.energy > STARTED_LEVEL * late;
        let times = ends.iter().take_while(is_high).count();
        let is_steady = early <= STARTED_LEVEL * late && late <= STARTED_LEVEL * early;
        let ratio = ends[0].energy / late;
        let share = mean(&ends[..times.max(1)]) * times as f64 / self.of_ends(|e| e.energy);
        let found = ratio > START_LEVEL && times <= twentieth && is_steady && share > START_SHARE;
        let message = format!(
            "{} of the energy lies in the first {times} samples, where it is {} times that of the second half of the \
             record",
            percent(share),
            number(ratio)
        );
        let advice = "if it is the instrument that settles, begin later with `--times FROM:`";
        let numbers = json!({"times": times, "share": share, "ratio": ratio});
        found.then(|| Warning::new(message, advice).coded("start-up", numbers))
    }

    /// A record that begins in the middle of the motion, or ends while it grows.
    fn cut(&self, starts_up: bool, flat_part: f64) -> Option<Warning> {
        let ends = &self.rows.ends;
        let twentieth = ends.len() / 20;
        if twentieth == 0 {
            return None;
        }
        let energy = self.of_ends(|e| e.energy);
        let part = |ends: &[Ends]| sum_of(ends.iter().map(|e| e.energy)) / energy;
        let first = part(&ends[..twentieth]);
        let last = part(&ends[ends.len() - twentieth..]);
        // Parts of a short record of noise differ by chance.
        let samples = (twentieth * self.scans.len()) as f64;
        let by_chance = 0.05 * (1.0 + NOISE_DEVIATIONS * (2.0 / samples).sqrt());
        let least = match flat_part > FLAT_PART {
            true => CUT_SHARE.max(by_chance),
            false => CUT_SHARE,
        };
        let starts_late = first > least && !starts_up && self.starts_in_motion();
        let message = format!(
            "{} of the energy lies in the first and {} in the last twentieth of the record",
            percent(first),
            percent(last)
        );
        let advice = "record from before the arrival until the motion has died down; a cut transient has no energy \
                      spectrum of its own";
        let numbers = json!({"first": first, "last": last});
        let warning = Warning::new(message, advice).coded("transient-cut", numbers);
        (starts_late || last > least).then_some(warning)
    }

    /// The frequency of the line in which the energy common to all sites lies, if it is one.
    fn common_line(&self) -> Option<[f64; 2]> {
        let by_direction = &self.spacetime?.directions;
        let undirected: Vec<f64> = by_direction.iter().map(|d| d.undirected).collect();
        let moving = undirected.get(1..)?;
        let at = (0..moving.len()).max_by(|&a, &b| moving[a].total_cmp(&moving[b]))?;
        let near = &moving[at.saturating_sub(LINE_BINS)..(at + LINE_BINS + 1).min(moving.len())];
        // What lies at f = 0 are offsets.
        let is_line = sum(near) > LINE_PART * sum(moving) && undirected[0] < sum(near);
        let bins = self.all.plan.frequency_bins();
        let (line, bin) = (bins.centres[at + 1], bins.centres[1]);
        let is_line = is_line && self.is_in_phase(std::f64::consts::PI * line / bins.top());
        // No finer than it is known.
        let digit = 10f64.powf(bin.log10().ceil());
        let line = match line >= 10.0 * digit {
            true => (line / digit).round() * digit,
            false => line,
        };
        is_line.then_some([line, 0.5 * bin])
    }

    /// Whether a line, in rad a sample, has one phase at both ends of the array: a wave that is far longer than it has not.
    fn is_in_phase(&self, angle: f64) -> bool {
        let sites = self.scans.len();
        let end = (sites / 4).clamp(1, ENDS);
        let at = |site: usize| -> Complex<f64> {
            let record = self.all.record(site);
            let taper = Window::Hann.samples(record.len());
            let terms = record.iter().zip(taper).enumerate();
            terms
                .map(|(n, (v, w))| Complex::from_polar(v * w, -angle * n as f64))
                .sum()
        };
        let [first, last]: [Complex<f64>; 2] =
            [(0..end).map(at).sum(), (sites - end..sites).map(at).sum()];
        let both = first.conj() * last;
        both.re > IN_PHASE * both.norm()
    }

    /// Motion that all sites have in common, and the line that it is. Of pulses, which hum at no frequency, it is none; of a box it is
    /// the mean flow, and of a chain between walls a mode.
    fn common(&self, energy: f64) -> Option<Warning> {
        let plan = self.all.plan;
        let share = self.of_ends(|e| e.common) / energy;
        let line = match self.simulated || self.has_fronts {
            true => None,
            false => self.common_line(),
        };
        let is_common = share > COMMON_SHARE || (line.is_some() && share > COMMON_LINE);
        if self.scans.len() < COMMON_SITES || !is_common || plan.request.periodic {
            return None;
        }
        let what = match line {
            Some([line, half]) => {
                let half_of_one_digit = format!("{half:.0e}").parse().unwrap_or(half);
                let error = match half > KNOWN * line {
                    true => format!(" ± {}", six_digits(half_of_one_digit)),
                    false => String::new(),
                };
                let unit = plan.axes.frequency_unit();
                format!("{}{error} {unit}", three_digits(line))
            }
            None => "motion".into(),
        };
        let message = format!(
            "{what} common to all sites (k = 0) holds {:.0} % of the energy",
            100.0 * share
        );
        let [line, error] = [0, 1].map(|i| line.map(|line| line[i]));
        let numbers = json!({"share": share, "line": line, "line_error": error});
        let advice = "if it is noise of the instrument, remove it with `--detrend-space mean`";
        Some(Warning::new(message, advice).coded("common-mode", numbers))
    }

    /// Defects that affect spectra along space.
    fn along_space(&self, energy: f64) -> Vec<Warning> {
        let n_sites = self.scans.len();
        let mut warnings: Vec<Warning> = self.common(energy).into_iter().collect();
        let (rows, ends) = (&self.rows.rows[..], &self.rows.ends);
        if rows.is_empty() || self.simulated || n_sites <= 2 {
            return warnings;
        }
        let bins = &self.all.plan.wavenumber_bins();
        let found = aliased(rows, bins, || false);
        let advice = "measure at sites closer together; wavenumbers beyond Nyquist fold and may seem to travel \
                      backwards";
        warnings.extend(found.map(|found| of_top("aliasing-space", "wavenumber", found, advice)));
        if self.all.plan.request.window_space == Window::None {
            let steps: Vec<f64> = ends.iter().map(|e| e.step).collect();
            let mean_square = ends.iter().map(|e| e.energy / n_sites as f64);
            let mean_square: Vec<f64> = mean_square.collect();
            if let Some(step) = jump(rows, bins, &steps, &mean_square, n_sites) {
                let advice =
                    "use `--window-space hann`, or remove the trend with `--detrend-space linear`";
                let what = "profiles jump from the last to the first site";
                warnings.push(of_jump("leakage-space", what, step, advice));
            }
        }
        warnings
    }
}

/// Whether most of the energy lies in a line that all sites have in common.
pub(super) fn is_hum(warning: &Warning) -> bool {
    let share = warning.numbers["share"].as_f64().unwrap_or(0.0);
    warning.code == "common-mode" && warning.numbers["line"].is_number() && share > COMMON_SHARE
}

fn of_top(code: &'static str, axis: &str, (share, above): (f64, f64), advice: &str) -> Warning {
    let message = format!(
        "{} of the energy lies above {axis} {}, in the top tenth below Nyquist",
        percent(share),
        number(above)
    );
    Warning::new(message, advice).coded(code, json!({"share": share, "above": above}))
}

fn of_jump(code: &'static str, what: &str, step: f64, advice: &str) -> Warning {
    let message = format!(
        "untapered {what} by {step:.3} of their root mean square; the jump leaks over all of the axis"
    );
    Warning::new(message, advice).coded(code, json!({"step": step}))
}

pub(super) fn total(rows: &[SpectrumMoments], part: fn(&SpectrumMoments) -> f64) -> f64 {
    sum_of(rows.iter().map(part))
}

/// The mean effective bandwidth of spectra, weighted by their energy, over the length of the axis.
pub(super) fn flat_part(rows: &[SpectrumMoments], bins: &Bins) -> f64 {
    let filled = rows.iter().filter(|r| r.effective_bandwidth.is_finite());
    let filled = sum_of(filled.map(|r| r.effective_bandwidth * r.total));
    filled / total(rows, |r| r.total) / bins.centres[bins.len() - 1]
}

/// The root mean square distance of the ends of rows over that of samples, where most of the energy lies in rows whose
/// ends do not meet: they are further apart than half the root mean square, and than neighbours are, by far. `steps`
/// are squared.
///
/// Neighbours a step d apart differ in the mean square by `sum p (2 sin(q d / 2))^2`, q in rad, of
/// shares p, at most by `d^2` times the second moment of q, and by 4. A jump counts only where what
/// it leaks is a part of what the top tenth of the axis holds: on noise, and where neighbours differ
/// anyway, it is none.
fn jump(
    rows: &[SpectrumMoments],
    bins: &Bins,
    steps: &[f64],
    mean_square: &[f64],
    length: usize,
) -> Option<f64> {
    let per_step = std::f64::consts::PI / bins.top();
    let open = rows.iter().zip(steps).zip(mean_square);
    let open = open.map(|((row, &step), &mean_square)| {
        let second_moment = row.centroid.powi(2) + row.bandwidth.powi(2);
        let neighbours = mean_square * (per_step.powi(2) * second_moment).min(4.0);
        let leaked = LEAKED * step / (mean_square * length as f64);
        let is_open = step > STEP.powi(2) * mean_square
            && step > STEP_OVER_NEIGHBOURS.powi(2) * neighbours
            && leaked * row.total > LEAKED_PART * row.top;
        if is_open { mean_square } else { 0.0 }
    });
    let (open, all) = (sum_of(open), sum(mean_square));
    (open / all > 0.5).then(|| (sum(steps) / all).sqrt())
}
