//! Defects of the data and of its sampling.

use std::ops::Range;

use num_complex::Complex;
use serde_json::json;

use super::Warning;
use super::rows::SpatialPassResult;
use super::stages::{FromRecords, Stages};
use crate::diagnostics::{Bins, SpectrumMoments};
use crate::measure::{digits, shortest};
use crate::numeric::{sum, sum_of, sum_of_squares};
use crate::prepare::{ChannelScan, Window};
use crate::sheet::{number, percent};
use crate::transform::{RecordTransform, Scaling};

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
    pub records: &'a FromRecords,
}

/// The effective bandwidth of a periodogram of white noise is 0.66 of the axis, and less for few bins.
const FLAT_PART: f64 = 0.5;
const ALIASING_SHARE: f64 = 0.01;
/// Share of the top tenth of the axis, over that of a flat spectrum, for spectra as flat as white noise.
const FLAT_SHARE: Range<f64> = 0.45..1.5;
/// Energy above the 90 % quantile of spectra with a white floor, as the top tenth foretells it: 0.1 up
/// to what differs by chance.
const FLOOR_SHARE: Range<f64> = 0.08..0.125;
/// Bins that are too few to tell flat spectra by their bandwidth.
const FEW_BINS: usize = 6;
const COMMON_SHARE: f64 = 0.5;
/// Sites from which on what is common to all is told from a long wave.
const COMMON_SITES: usize = 5;
/// The same of a single line; bins on each side that it fills, and its part of what is common.
const COMMON_LINE: f64 = 0.2;
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
/// Samples of the frames in which noise is as flat as in the whole record, and a chirp is not; sites that are
/// looked at; the effective bandwidth over the axis, 0.61 of white noise under a Hann window, below 0.3 of
/// chirps.
const FRAME: usize = 64;
const LOOKED_AT: usize = 8;
const FLAT_FRAMES: f64 = 0.4;
/// Times without any motion that look like a recording that dropped out.
const ZERO_RUN: usize = 2;
/// Standard deviations of the energy of white noise in a part of the record.
const NOISE_DEVIATIONS: f64 = 6.0;
/// Energy in a twentieth of the record: three times that of a steady record.
const CUT_SHARE: f64 = 0.15;

impl Findings<'_> {
    /// The warnings these findings give rise to.
    pub fn warnings(&self) -> Vec<Warning> {
        let energy = self.of_ends(|e| e.energy);
        if energy <= 0.0 {
            let advice = "check the range, the layout and the detrending";
            let warning = Warning::new("the prepared field is zero everywhere", advice);
            return vec![warning.coded("no-energy", json!({}))];
        }
        let results = self.all.plan.request.results;
        let mut warnings = Vec::from_iter(self.zero_times());
        if results.temporal || results.spacetime {
            warnings.extend(self.along_time(energy).into_iter().flatten());
        }
        if results.spatial || results.spacetime || results.flux_surrogate {
            warnings.extend(self.along_space(energy).into_iter().flatten());
        }
        warnings
    }

    fn of_ends(&self, part: fn(&Ends) -> f64) -> f64 {
        sum_of(self.rows.ends.iter().map(part))
    }

    /// Defects that affect spectra along time.
    fn along_time(&self, energy: f64) -> Vec<Option<Warning>> {
        let (plan, request) = (self.all.plan, &self.all.plan.request);
        let n_times = self.rows.ends.len();
        let Some(columns) = self.records.columns.as_ref().filter(|_| n_times > 1) else {
            return Vec::new();
        };
        let (rows, bins) = (&columns.rows[..], &plan.frequency_bins());
        let total = total(rows, |r| r.total);
        let share = plan.padding_time() * self::total(rows, |r| r.zero) / total;
        let is_static = (share > STATIC_SHARE).then(|| {
            let message = format!(
                "{} of the energy lies at f = 0: means of the records, not their motion, decide centroids",
                percent(share)
            );
            let advice =
                "if they are offsets of the instrument, remove them with `--detrend-time mean`";
            Warning::new(message, advice).coded("static", json!({"share": share}))
        });
        let advice = "sample faster, or low-pass before sampling; energy above Nyquist folds down";
        let folds = aliased(["aliasing-time", "frequency", advice], rows, bins, || {
            self.sweeps(rows)
        });
        let mut warnings = vec![is_static, folds];
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
            let per_total = energy / total / n_times as f64;
            let mean_square: Vec<f64> = rows.iter().map(|r| r.total * per_total).collect();
            let advice = "for a stationary record use `--window-time hann` or remove the trend; for a transient \
                          record until it has died down";
            let what = "records jump from their last to their first sample";
            let of = ["leakage-time", what, advice];
            warnings.push(jump(of, rows, bins, &steps, &mean_square, n_times));
        }
        if request.scaling == Scaling::Energy {
            warnings.push(self.cut(flat_part(rows, bins)));
        }
        warnings
    }

    /// Whether the loudest records, flat as a whole, are not so in short frames: a tone sweeps over the axis, and
    /// what it does at the end of it, it does beyond it, too.
    fn sweeps(&self, rows: &[SpectrumMoments]) -> bool {
        let mut loudest: Vec<usize> = (0..rows.len()).collect();
        loudest.sort_by(|&a, &b| rows[b].total.total_cmp(&rows[a].total).then(a.cmp(&b)));
        let transform = RecordTransform::<f64>::new(&Window::Hann.samples(FRAME), FRAME);
        let mut scratch = Default::default();
        let (mut wide, mut all) = (0.0, 0.0);
        for j in loudest.into_iter().take(LOOKED_AT) {
            for frame in self.all.record(j).chunks_exact(FRAME) {
                let spectrum = transform.spectra_of_rows(frame, 1, &mut scratch);
                let powers = spectrum[1..FRAME / 2].iter().map(|x| x.norm_sqr());
                let energy: f64 = powers.clone().sum();
                let shares = powers.map(|p| p / energy).filter(|p| *p > 0.0);
                let entropy: f64 = shares.map(|p| -p * p.ln()).sum();
                wide += energy * entropy.exp() / (FRAME / 2 - 1) as f64;
                all += energy;
            }
        }
        self.rows.ends.len() >= 2 * FRAME && wide < FLAT_FRAMES * all
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
        let moves = |ends: &Ends| ends.energy > 0.0;
        let runs = self.rows.ends.chunk_by(|a, b| moves(a) == moves(b));
        let mut row = self.all.plan.times.start;
        let runs = runs.map(|run| {
            let from = row;
            row += run.len();
            (moves(&run[0]), from..row)
        });
        let runs: Vec<(bool, Range<usize>)> = runs.collect();
        let inner = runs.get(1..runs.len().saturating_sub(1))?.iter();
        let gaps = inner.filter(|(moves, run)| !moves && run.len() >= ZERO_RUN);
        let gaps: Vec<&Range<usize>> = gaps.map(|(_, run)| run).collect();
        let (first, last) = (gaps.first()?.start, gaps.last()?.end - 1);
        let times: usize = gaps.iter().map(|gap| gap.len()).sum();
        let message = format!(
            "all sites are zero at {times} times between others, from row {first} to row {last}"
        );
        let advice = "where the recording dropped out, state `nan` there and `--gaps interpolate`";
        let numbers = json!({"times": times, "first": first, "last": last});
        let warning = Warning::new(message, advice).coded("zero-times", numbers);
        (self.scans.len() > 1 && !self.simulated).then_some(warning)
    }

    /// A record that begins in the middle of the motion, or ends while it grows.
    fn cut(&self, flat_part: f64) -> Option<Warning> {
        let ends = &self.rows.ends;
        let twentieth = ends.len() / 20;
        if twentieth == 0 {
            return None;
        }
        let energy = self.of_ends(|e| e.energy);
        let part = |ends: &[Ends]| sum_of(ends.iter().map(|e| e.energy)) / energy;
        let (head, tail) = (&ends[..twentieth], &ends[ends.len() - twentieth..]);
        let (first, last) = (part(head), part(tail));
        // Parts of a short record of noise differ by chance.
        let samples = (twentieth * self.scans.len()) as f64;
        let by_chance = 0.05 * (1.0 + NOISE_DEVIATIONS * (2.0 / samples).sqrt());
        let least = match flat_part > FLAT_PART {
            true => CUT_SHARE.max(by_chance),
            false => CUT_SHARE,
        };
        let starts_late = first > least && self.starts_in_motion();
        let message = format!(
            "{} of the energy lies in the first and {} in the last twentieth of the record",
            percent(first),
            percent(last)
        );
        let advice = "record from before the arrival until the motion has died down, or begin later with \
                      `--times FROM:` where the instrument settles";
        let numbers = json!({"first": first, "last": last});
        let warning = Warning::new(message, advice).coded("transient-cut", numbers);
        (starts_late || last > least).then_some(warning)
    }

    /// The frequency of the line in which the energy common to all sites lies, if it is one.
    fn common_line(&self) -> Option<f64> {
        let by_direction = &self.records.spacetime.as_ref()?.directions;
        let undirected: Vec<f64> = by_direction.iter().map(|d| d.undirected).collect();
        let moving = undirected.get(1..)?;
        let at = (0..moving.len()).max_by(|&a, &b| moving[a].total_cmp(&moving[b]))?;
        let near = &moving[at.saturating_sub(LINE_BINS)..(at + LINE_BINS + 1).min(moving.len())];
        // What lies at f = 0 are offsets.
        let is_line = sum(near) > LINE_PART * sum(moving) && undirected[0] < sum(near);
        let bins = self.all.plan.frequency_bins();
        let line = bins.centres[at + 1];
        let is_line = is_line && self.is_in_phase(std::f64::consts::PI * line / bins.top());
        // With the digits that half a bin leaves.
        is_line.then(|| shortest(line, 0.5 * bins.centres[1]))
    }

    /// Whether a line, in rad a sample, has one phase at both ends of the array: a wave that is far longer than it has not.
    fn is_in_phase(&self, angle: f64) -> bool {
        let sites = self.scans.len();
        let end = (sites / 4).clamp(1, ENDS);
        let taper = Window::Hann.samples(self.all.plan.axes.n_times);
        let at = |site: usize| -> Complex<f64> {
            let record = self.all.record(site);
            let terms = record.iter().zip(&taper).enumerate();
            terms
                .map(|(n, (v, w))| Complex::from_polar(v * w, -angle * n as f64))
                .sum()
        };
        let [first, last] = [0..end, sites - end..sites].map(|of| of.map(at).sum::<Complex<f64>>());
        let both = first.conj() * last;
        both.re > IN_PHASE * both.norm()
    }

    /// Motion that all sites have in common, and the line that it is. Of pulses, which hum at no frequency, it is none; of a box it is
    /// the mean flow, and of a chain between walls a mode.
    fn common(&self, energy: f64) -> Option<Warning> {
        let plan = self.all.plan;
        let share = self.of_ends(|e| e.common) / energy;
        let may_hum = !self.simulated && !self.has_fronts;
        let line = may_hum.then(|| self.common_line()).flatten();
        let is_common = share > COMMON_SHARE || (line.is_some() && share > COMMON_LINE);
        if self.scans.len() < COMMON_SITES || !is_common || plan.request.periodic {
            return None;
        }
        let what = match line {
            Some(line) => format!("{} {}", digits(line), plan.axes.units().frequency),
            None => "motion".into(),
        };
        let message = format!(
            "{what} common to all sites (k = 0) holds {:.0} % of the energy",
            100.0 * share
        );
        let error = line.map(|_| 0.5 * plan.frequency_bins().centres[1]);
        let numbers = json!({"share": share, "line": line, "line_error": error});
        let advice = "if it is noise of the instrument, remove it with `--detrend-space mean`";
        Some(Warning::new(message, advice).coded("common-mode", numbers))
    }

    /// Defects that affect spectra along space.
    fn along_space(&self, energy: f64) -> Vec<Option<Warning>> {
        let n_sites = self.scans.len();
        let mut warnings = vec![self.common(energy)];
        let (rows, ends) = (&self.rows.rows[..], &self.rows.ends);
        if rows.is_empty() || self.simulated || n_sites <= 2 {
            return warnings;
        }
        let bins = &self.all.plan.wavenumber_bins();
        let advice = "measure at sites closer together; wavenumbers beyond Nyquist fold and may seem to travel \
                      backwards";
        let of = ["aliasing-space", "wavenumber", advice];
        warnings.push(aliased(of, rows, bins, || false));
        if self.all.plan.request.window_space == Window::None {
            let steps: Vec<f64> = ends.iter().map(|e| e.step).collect();
            let mean_square = ends.iter().map(|e| e.energy / n_sites as f64);
            let mean_square: Vec<f64> = mean_square.collect();
            let advice =
                "use `--window-space hann`, or remove the trend with `--detrend-space linear`";
            let what = "profiles jump from the last to the first site";
            let of = ["leakage-space", what, advice];
            warnings.push(jump(of, rows, bins, &steps, &mean_square, n_sites));
        }
        warnings
    }
}

fn total(rows: &[SpectrumMoments], part: fn(&SpectrumMoments) -> f64) -> f64 {
    sum_of(rows.iter().map(part))
}

/// The mean effective bandwidth of spectra, weighted by their energy, over the length of the axis.
fn flat_part(rows: &[SpectrumMoments], bins: &Bins) -> f64 {
    let filled = rows.iter().filter(|r| r.effective_bandwidth.is_finite());
    let filled = sum_of(filled.map(|r| r.effective_bandwidth * r.total));
    filled / total(rows, |r| r.total) / bins.centres[bins.len() - 1]
}

/// Share of energy in the top tenth of an axis, and the lower edge of that tenth, if the share
/// suggests aliasing. Not decidable for spectra as flat as noise, and those with a floor of it. `sweeps`: whether spectra
/// that are flat are those of a tone that crosses the axis.
fn aliased(
    [code, axis, advice]: [&'static str; 3],
    rows: &[SpectrumMoments],
    bins: &Bins,
    sweeps: impl Fn() -> bool,
) -> Option<Warning> {
    let all = total(rows, |r| r.total);
    let share = total(rows, |r| r.top) / all;
    let last = bins.centres[bins.len() - 1];
    let from = bins.centres.partition_point(|&q| q <= 0.9 * last);
    let of_flat = 1.0 - (from as f64 - 0.5) * bins.step / bins.top();
    let is_wide = bins.len() < FEW_BINS || flat_part(rows, bins) > FLAT_PART;
    let is_flat = FLAT_SHARE.contains(&(share / of_flat)) && is_wide;
    let is_noise = is_flat || has_floor(rows, bins, of_flat);
    // Below a floor there is other motion, which is not flat in frames either.
    let is_folded = share > ALIASING_SHARE && (!is_noise || (is_wide && sweeps()));
    let above = 0.9 * last;
    let message = format!(
        "{} of the energy lies above {axis} {}, in the top tenth below Nyquist",
        percent(share),
        number(above)
    );
    let numbers = json!({"share": share, "above": above});
    is_folded.then(|| Warning::new(message, advice).coded(code, numbers))
}

/// Whether the energy in the top tenth is that of a white floor below other motion: spectra are as
/// dense from their 90 % quantile on as in the top tenth. A row with more than a hundredth of its
/// energy in a flat top tenth has its quantile in the floor, which then holds a tenth above it. A line
/// near the end of the axis may do so by chance: rows count whose quantile is below, or that are flat.
fn has_floor(rows: &[SpectrumMoments], bins: &Bins, of_flat: f64) -> bool {
    let high = rows.iter().filter(|r| r.top > ALIASING_SHARE * r.total);
    let (mut above, mut all) = (0.0, 0.0);
    for row in high {
        let is_flat = row.effective_bandwidth > FLAT_PART * bins.top();
        if is_flat || row.quantile_90 < 0.8 * bins.top() {
            above += row.top / of_flat * (1.0 - row.quantile_90 / bins.top());
        }
        all += row.total;
    }
    FLOOR_SHARE.contains(&(above / all))
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
    [code, what, advice]: [&'static str; 3],
    rows: &[SpectrumMoments],
    bins: &Bins,
    steps: &[f64],
    mean_square: &[f64],
    length: usize,
) -> Option<Warning> {
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
    let step = (sum(steps) / all).sqrt();
    let message = format!(
        "untapered {what} by {step:.3} of their root mean square; the jump leaks over all of the axis"
    );
    let numbers = json!({"step": step});
    (open / all > 0.5).then(|| Warning::new(message, advice).coded(code, numbers))
}
