//! The answer of an analysis: what moved along x and in time, and which way the energy goes.

use std::ops::Range;

use serde_json::json;

use super::gains::{self, GainChange};
use super::plan::Plan;
use super::result::Direction;
use super::spacetime::{ByDirection, Frequencies};
use super::stages::{FromRecords, Stages};
use crate::error::Result;
use crate::field::Axis;
use crate::moved::{
    Answer, Evidence, FOLDED, Motion, Movement, Options, Place, Profiles, Reason, Source,
    TOLERANCE, Verdict, along_x, in_time,
};
use crate::numeric::{sum, sum_of, sum_of_squares};
use crate::prepare::{Prepared, Sites, Window, some};
use crate::sheet::{Warning, three_digits};
use crate::transform::{RecordScratch, RecordTransform, fold, quick};

/// Sites from which on waves have a direction.
const DIRECTED: usize = 5;
/// Bands of the wavenumber axis, and ratio of their energies from which on it is flat.
const BANDS: usize = 10;
const FLAT: f64 = 0.6;
/// Bins of the aperture below which motion is that of the whole array.
const MEAN_MOTION: f64 = 1.5;
/// Part of the directed energy that goes the other way than arrivals from which on windows hold it.
const BACK: f64 = 0.25;
/// Part of its energy that a wave still has at the last sites, below which it is known to come from the first.
const DECAYS: f64 = 0.8;
/// Snapshots before the wave enters from which on they are taken for the noise.
const QUIET: usize = 16;
/// Share of directed energy that goes one way where records have no arrivals but a direction.
const ONE_WAY: f64 = 0.8;

/// Finds the answer from a field that is prepared and, where they were transformed, its records and its directions.
pub(super) fn find(all: &Stages, records: &FromRecords) -> Result<Answer> {
    let (plan, prepared) = (all.plan, all.prepared);
    let (request, axes) = (&plan.request, &plan.axes);
    let struck = prepared.field.struck;
    let struck = struck.map(|site| site.saturating_sub(plan.sites.start));
    let spacetime = records.spacetime.as_ref();
    let toward_minus = spacetime.is_some_and(|found| goes(&found.directions, 0.0, true));
    let in_samples = |w: f64| (w / axes.time.step).round().max(1.0) as usize;
    let options = Options {
        dt: axes.time.step,
        tolerance: request.least_move.unwrap_or(TOLERANCE),
        window: request.front_window.map(in_samples),
        noise: request.noise.map(|noise| noise / prepared.unit()),
        struck,
        toward_minus,
        first_site: plan.sites.start,
        origin: axes.space.origin,
        dx: axes.space.step,
        most_bytes: plan.answer_bytes,
    };
    let mut answer = along_x(prepared, &options, all.observer)?;
    answer.is_periodic = request.periodic;
    answer.noise = records.columns.as_ref().map_or(0.0, |columns| {
        let samples = sum(&columns.energies) / plan.segments.count() as f64;
        answer.noise * axes.n_times as f64 / samples
    });
    let is_known =
        spacetime.is_none_or(|found| goes(&found.directions, answer.noise, toward_minus));
    // What decays comes from where it is largest, though evanescent waves have no direction.
    let of = &answer.frequency;
    let decays = of.transfer == Some(false) && of.energy_ratio < DECAYS;
    // Where waves stand, what a site has is that of its place.
    if !answer.has_fronts && !is_known && !decays && answer.frequency.moves() {
        answer.frequency = std::mem::take(&mut answer.frequency).but_untold(Reason::Mixed);
    }
    answer.since = since(&answer, plan.sites.start);
    let in_time = wavenumbers(plan, prepared, &answer, struck);
    answer.tell(in_time);
    Ok(answer)
}

/// Takes back energies along x that gains which change hide, in time or, if there are, in steps along x; returns what to say of the former.
pub(super) fn gains(
    answer: &mut Answer,
    plan: &Plan,
    space: &Axis,
    has_steps: bool,
) -> Option<Warning> {
    let time = &plan.axes.time;
    let changes = match answer.has_fronts {
        true => Vec::new(),
        false => gains::changes(&answer.onsets, plan.axes.n_times),
    };
    if has_steps || !changes.is_empty() {
        let of = &mut answer.frequency;
        (of.transfer, of.energy_ratio) = (None, f64::NAN);
    }
    let column = |of: &dyn Fn(&GainChange) -> f64| -> Vec<f64> { changes.iter().map(of).collect() };
    let (ratios, times) = (column(&|of| of.ratio), column(&|of| time.at(of.sample)));
    let [by, at] = [&ratios, &times].map(|of| some(of.iter().map(|x| three_digits(*x))));
    let unit = plan.axes.units().time;
    let what = format!("the gain changes in time, x {by} at {at} {unit}");
    let advice = "scale the records before energies of sites are compared";
    let numbers = json!({"times": times, "ratios": ratios});
    let indices = changes.iter().map(|change| plan.sites.start + change.site);
    let sites = Sites {
        indices: indices.collect(),
        space,
    };
    (!changes.is_empty()).then(|| sites.warning("gain-changes", &what, advice, numbers))
}

/// Withdraws what moves along x where arrivals run one way and nothing is seen to come back, though a good part of the energy does.
pub(super) fn returns(answer: &mut Answer, direction: Direction) {
    let (plus, minus) = (direction.toward_plus_x, direction.toward_minus_x);
    if answer.frequency.moves() && answer.is_one_way && plus.min(minus) > BACK * (plus + minus) {
        answer.frequency = answer.frequency.clone().but_untold(Reason::Mixed);
    }
}

/// Rows in which a struck chain's front passes the second half of the bodies that it reaches: the launch is none of the travel.
fn since(along: &Answer, first_site: usize) -> Option<Range<usize>> {
    let bodies = along.front?.bodies.map(|body| body - first_site);
    let start = along.onsets.get(bodies[0])?.arrival?;
    let end = along.onsets.last()?.arrival.unwrap_or(usize::MAX);
    (start < end).then_some(start..end)
}

/// Whether waves go one way, that towards -x or the other, but for this share of noise.
fn goes(directions: &[ByDirection], noise: f64, toward_minus: bool) -> bool {
    let total = |of: fn(&ByDirection) -> f64| sum_of(directions.iter().map(of));
    let (plus, minus) = (total(|d| d.toward_plus_x), total(|d| d.toward_minus_x));
    let of_noise = 0.5 * noise * (plus + minus);
    let mut shares = [plus - of_noise, minus - of_noise];
    shares.rotate_left(usize::from(toward_minus));
    let [along, against] = shares;
    along > ONE_WAY * (along + against.max(0.0))
}

fn wavenumbers(
    plan: &Plan,
    prepared: &Prepared,
    along: &Answer,
    struck: Option<usize>,
) -> std::result::Result<(Movement, Evidence), Reason> {
    let axes = &plan.axes;
    let sites = axes.n_sites;
    if sites < 8 || !plan.request.without_sites.is_empty() {
        return Err(Reason::FewSites);
    }
    if along.onsets.is_empty() {
        return Err(along.frequency.reason.unwrap_or(Reason::NoEnergy));
    }
    let is_box = plan.request.periodic;
    // The ends of a steady wave do not meet.
    let window = match along.has_fronts || is_box {
        true => vec![1.0; sites],
        false => Window::Hann.samples(sites),
    };
    let padded = if is_box { sites } else { quick(4 * sites) };
    let padding = padded as f64 / sites as f64;
    // What is the same at all times is a part of the motion in a box, of the sensors elsewhere.
    let level = |of: f64| if is_box { 0.0 } else { of };
    let baselines = along.onsets.iter().map(|onset| level(onset.baseline));
    let noise = along
        .onsets
        .iter()
        .map(|onset| level(onset.noise.unwrap_or(0.0)).powi(2));
    let (baselines, noise): (Vec<f64>, Vec<f64>) = (baselines.collect(), noise.collect());
    let tapered: Vec<f64> = noise.iter().zip(&window).map(|(n, w)| n * w * w).collect();
    let mut profiles = OfField {
        prepared,
        baselines,
        noise: sum(&noise),
        noise_powers: vec![sum(&tapered); padded / 2 + 1],
        window_energy: sum_of_squares(&window),
        transform: RecordTransform::new(&window, padded),
    };
    // What is there before the wave enters is none of it: noise of any colour, and hum.
    let arrivals = along.onsets.iter().filter_map(|o| o.arrival);
    let enters = arrivals.min().unwrap_or(0);
    let lead = along.windows.as_ref().map_or(0, |of| 2 * of.width as usize);
    let quiet = enters.saturating_sub(lead).min(axes.n_times);
    if along.has_fronts && struck.is_none() && !is_box && quiet >= QUIET {
        profiles.measure_noise(quiet);
    }
    let since = along.since.clone().unwrap_or(0..axes.n_times);
    let among = since.start..since.end.min(axes.n_times);
    let (time, spacing) = (&axes.time, axes.space.step.abs());
    let first_time = plan.times.start;
    let motion = match (is_box, struck.is_some(), along.has_fronts) {
        (true, ..) => Motion::Box,
        (_, true, _) => Motion::Run,
        (_, _, true) => Motion::Transient,
        _ => Motion::Steady,
    };
    in_time(&Source {
        profiles: &profiles,
        among,
        step: std::f64::consts::TAU / (padded as f64 * spacing),
        first: match is_box {
            true => 1,
            false => (MEAN_MOTION * padding).ceil() as usize,
        },
        period: along.period / time.step,
        motion,
        // The kinetic part of a run's energy oscillates all the while.
        is_inside: motion != Motion::Transient,
        is_short: (along.speed).is_some_and(|of| of.value.abs() * along.period < 2.0 * spacing),
        uneven: gains::uneven(&along.onsets),
        tolerance: plan.request.least_move.unwrap_or(TOLERANCE),
        stays_along_x: along.frequency.verdict == Verdict::Unchanged,
        place: &|rows: Range<usize>| Place {
            rows: [rows.start + first_time, rows.end - 1 + first_time],
            at: 0.5 * (time.at(rows.start) + time.at(rows.end - 1)),
        },
    })
}

/// Snapshots of a measured field: `v^2`.
struct OfField<'a> {
    prepared: &'a Prepared<'a>,
    baselines: Vec<f64>,
    /// Sum of the variances of the noise.
    noise: f64,
    /// Noise in each bin of k.
    noise_powers: Vec<f64>,
    window_energy: f64,
    transform: RecordTransform<f64>,
}

impl OfField<'_> {
    fn snapshot(&self, time: usize) -> Vec<f64> {
        let mut snapshot = vec![0.0; self.baselines.len()];
        self.prepared.profiles(time..time + 1, &mut snapshot);
        self.prepared.release_pages();
        let values = snapshot.iter_mut().zip(&self.baselines);
        values.for_each(|(v, baseline)| *v -= baseline);
        snapshot
    }

    /// Squares of the transform. What all sites have in common leaks into no other wavenumber.
    fn squares(&self, time: usize) -> Vec<f64> {
        let mut snapshot = self.snapshot(time);
        let mean = sum(&snapshot) / snapshot.len() as f64;
        snapshot.iter_mut().for_each(|v| *v -= mean);
        let mut scratch = RecordScratch::default();
        let bins = self.transform.spectra_of_rows(&snapshot, 1, &mut scratch);
        let mut squares: Vec<f64> = bins.iter().map(|x| x.norm_sqr()).collect();
        squares[0] += mean * mean * self.window_energy * self.transform.padded() as f64;
        squares
    }

    /// Takes what is there in the first `quiet` times for noise.
    fn measure_noise(&mut self, quiet: usize) {
        let times = (0..quiet).step_by(quiet.div_ceil(4 * QUIET));
        let squares: Vec<Vec<f64>> = times.map(|time| self.squares(time)).collect();
        let mean = |m: usize| squares.iter().map(|s| s[m]).sum::<f64>() / squares.len() as f64;
        self.noise_powers = (0..self.noise_powers.len()).map(mean).collect();
        let padded = self.transform.padded();
        let folded = self.noise_powers.iter().enumerate();
        let folded: Vec<f64> = folded.map(|(m, p)| p * fold(m, padded)).collect();
        self.noise = sum(&folded) / padded as f64;
    }
}

impl Profiles for OfField<'_> {
    fn energy(&self, time: usize) -> f64 {
        sum_of_squares(&self.snapshot(time)) - self.noise
    }

    fn at_ends(&self, time: usize) -> f64 {
        let snapshot = self.snapshot(time);
        let n = snapshot.len();
        let outer = (n / 20).max(1);
        let ends = sum_of_squares(&snapshot[..outer]) + sum_of_squares(&snapshot[n - outer..]);
        let even = sum_of_squares(&snapshot) * 2.0 * outer as f64 / n as f64;
        if even > 0.0 { ends / even } else { 0.0 }
    }

    fn powers(&self, time: usize) -> Vec<f64> {
        let padded = self.transform.padded();
        let powers = self.squares(time).into_iter().zip(&self.noise_powers);
        let powers = powers.enumerate();
        powers
            .map(|(m, (p, noise))| fold(m, padded) * (p - noise))
            .collect()
    }
}

/// Why shares by direction are withheld, if they are. The bodies of a chain are all there is: its waves do not fold.
pub(super) fn withheld(
    plan: &Plan,
    answer: Option<&Answer>,
    spacetime: &Frequencies,
    simulated: bool,
) -> Option<Reason> {
    if simulated {
        return None;
    }
    if plan.axes.n_sites < DIRECTED {
        return Some(Reason::FewSites);
    }
    // Offsets of sensors do not travel.
    let energies = spacetime
        .wavenumber_energies
        .iter()
        .zip(&spacetime.static_energies);
    let energies: Vec<f64> = energies
        .map(|(all, still)| (all - still).max(0.0))
        .collect();
    let (nk, all, still) = (
        energies.len(),
        sum(&energies),
        sum(&spacetime.static_energies),
    );
    // Noise is as much at all wavenumbers.
    let noise = answer.map_or(0.0, |answer| answer.noise) * (all + still);
    let top = nk / 20;
    let tenth = (2 * top) as f64 / nk as f64;
    let high = sum(&energies[..top]) + sum(&energies[nk - top..]) - noise * tenth;
    let rest = all - noise;
    let is_steady = answer.is_none_or(|answer| !answer.has_fronts);
    if rest <= 0.1 * all || (is_steady && is_flat(&energies)) {
        return Some(Reason::Noise { bound: 1.0 });
    }
    // All that gains spread may lie there.
    if high > rest * (FOLDED + answer.map_or(0.0, |answer| gains::uneven(&answer.onsets))) {
        return Some(Reason::Aperture { folds: true });
    }
    let answer = answer?;
    let wavelength = answer.speed?.value.abs() * answer.period;
    let spacing = plan.axes.space.step.abs();
    // Of waves as long as the array those of both signs are not two.
    let folds = wavelength < 2.0 * spacing;
    let is_withheld = folds || wavelength > 2.0 * spacing * plan.axes.n_sites as f64;
    is_withheld.then_some(Reason::Aperture { folds })
}

/// Whether there is about as much energy at all wavenumbers, of both signs: records that do not follow each other.
fn is_flat(energies: &[f64]) -> bool {
    let bands = energies
        .chunks_exact(energies.len().div_ceil(BANDS))
        .map(sum);
    let most = bands.clone().fold(0.0, f64::max);
    bands.fold(f64::INFINITY, f64::min) > FLAT * most
}
