//! The answer of an analysis: what moved along x and in time, and which way the energy goes.

use std::ops::Range;

use super::plan::Plan;
use super::result::Direction;
use super::spacetime::{ByDirection, Frequencies};
use super::warning::{Sites, Warning};
use crate::error::Result;
use crate::moved::{
    AlongX, Answer, ArrivalWindows, FOLDED, Movement, Options, Place, Profiles, Reason, Source,
    TOLERANCE, Verdict, along_x, in_time, quick,
};
use crate::numeric::sum;
use crate::observer::Observer;
use crate::prepare::{Prepared, Window};
use crate::transform::{RecordScratch, RecordTransform, fold};

/// Bands of the wavenumber axis, and ratio of their energies from which on it is flat.
const BANDS: usize = 10;
const FLAT: f64 = 0.6;
/// Bins of the aperture below which motion is that of the whole array.
const MEAN_MOTION: f64 = 1.5;
/// Sites that a struck chain's front has passed before wavenumbers are compared, or a quarter of the chain.
const PASSED: usize = 10;
/// Part of the directed energy that goes the other way than arrivals from which on windows hold it.
const BACK: f64 = 0.25;
/// Part of its energy that a wave still has at the last sites, below which it is known to come from the first.
const DECAYS: f64 = 0.8;
/// Share of directed energy that goes one way where records have no arrivals but a direction.
const ONE_WAY: f64 = 0.8;

/// Why shares by direction are withheld.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Undirected {
    /// Share of energy in the top tenth of the wavenumber axis.
    Folded { share: f64 },
    /// Wavelengths over twice the spacing, by the speed of arrivals, at the frequency below which half of the energy lies.
    Short { wavelength: f64 },
    /// The same over twice the length of the array, where wavenumbers of both signs are one.
    Long { wavelength: f64 },
    /// Noise is all there is.
    Noise,
}

/// Finds the answer from a field that is prepared and, where they were transformed, the sum of squares of its `samples` and its directions.
pub(super) fn find(
    plan: &Plan,
    prepared: &Prepared,
    samples: Option<f64>,
    spacetime: Option<&Frequencies>,
    observer: &dyn Observer,
) -> Result<Answer> {
    let (request, axes) = (&plan.request, &plan.axes);
    let struck = prepared
        .struck()
        .map(|site| site.saturating_sub(plan.sites.start));
    let toward_minus = spacetime.is_some_and(|found| {
        let (plus, minus) = by_sign(&found.directions);
        minus > ONE_WAY * (plus + minus)
    });
    let options = Options {
        dt: axes.time.step,
        tolerance: request.least_move.unwrap_or(TOLERANCE),
        window: request
            .front_window
            .map(|w| (w / axes.time.step).round().max(1.0) as usize),
        noise: request.noise.map(|noise| noise / prepared.unit()),
        struck,
        toward_minus,
        first_site: plan.sites.start,
        origin: axes.space.origin,
        dx: axes.space.step,
        most_bytes: plan.answer_bytes,
    };
    let mut along = along_x(prepared, &options, observer)?;
    let noise = samples.map_or(0.0, |samples| along.noise * axes.n_times as f64 / samples);
    let is_known = spacetime.is_none_or(|found| goes(&found.directions, noise, toward_minus));
    // What decays comes from where it is largest, though evanescent waves have no direction.
    let of = &along.movement;
    let decays = of.transfer == Some(false) && of.energy_ratio < DECAYS;
    if !along.has_fronts && struck.is_none() && !is_known && !decays {
        along.movement.transfer = None;
    }
    let windows = along.window.map(|(width, samples)| ArrivalWindows {
        arrivals: along.arrivals.clone(),
        width,
        samples,
    });
    let since = since(&along, struck);
    let (wavenumber, along_t) = match plan.request.without_sites.is_empty() {
        true => wavenumbers(plan, prepared, &along, &since, struck),
        false => (Movement::untold(Reason::MissingSites), None),
    };
    Ok(Answer {
        frequency: along.movement,
        launch: along.launch,
        front: along.front,
        tail: along.tail,
        wavenumber,
        speed: along.speed,
        is_struck: along.is_struck,
        is_lossy: false,
        has_fronts: along.has_fronts,
        is_one_way: along.is_one_way,
        along_x: along.evidence,
        along_t,
        since,
        period: 1.0 / along.median,
        windows,
        gain_changes: along.gain_changes,
        gain_steps: along.gain_steps,
        uneven: along.uneven,
        noise,
    })
}

/// Takes back energies along x that gains which change hide; returns what to say of them.
pub(super) fn gains(answer: &mut Answer, plan: &Plan) -> Vec<Warning> {
    let axes = &plan.axes;
    let named = |sites: Vec<usize>| Sites::of(&sites, plan.sites.start, axes);
    let (steps, changes) = (&answer.gain_steps, &answer.gain_changes);
    let steps = (!steps.is_empty()).then(|| Warning::GainSteps {
        sites: named(steps.iter().map(|step| step.site).collect()),
        ratios: steps.iter().map(|step| step.ratio).collect(),
        errors: steps.iter().map(|step| step.error).collect(),
    });
    let changes = (!changes.is_empty()).then(|| Warning::GainChanges {
        sites: named(changes.iter().map(|change| change.site).collect()),
        times: changes
            .iter()
            .map(|change| axes.time.at(change.sample))
            .collect(),
        time_unit: axes.time_unit().to_owned(),
        ratios: changes.iter().map(|change| change.ratio).collect(),
    });
    let found: Vec<Warning> = steps.into_iter().chain(changes).collect();
    if !found.is_empty() {
        answer.frequency.without_energies();
    }
    found
}

/// Withdraws what moves along x where arrivals run one way and nothing is seen to come back, though a good part of the energy does.
pub(super) fn returns(answer: &mut Answer, direction: Direction) {
    let moves = !matches!(
        answer.frequency.verdict,
        Verdict::Unchanged | Verdict::Untold
    );
    let (plus, minus) = (direction.toward_plus_x, direction.toward_minus_x);
    if moves && answer.is_one_way && plus.min(minus) > BACK * (plus + minus) {
        answer.frequency = answer.frequency.clone().but_untold(Reason::Returns);
    }
}

/// Rows from which on a struck chain's front is well inside, to its arrival at the far end.
fn since(along: &AlongX, struck: Option<usize>) -> Option<Range<usize>> {
    let struck = struck.filter(|_| along.is_struck)?;
    let last = along.arrivals.len() - 1;
    // The launch is none of the travel.
    let formed = along
        .movement
        .settled_at
        .map_or(0, |site| site - along.first_site);
    let passed = struck.max(formed) + PASSED.min(last / 4).max(1);
    let start = along.arrivals.get(passed).copied().flatten()?;
    let end = along.arrivals[last].unwrap_or(usize::MAX);
    (start < end).then_some(start..end)
}

fn by_sign(directions: &[ByDirection]) -> (f64, f64) {
    let total = |of: fn(&ByDirection) -> f64| sum(&directions.iter().map(of).collect::<Vec<_>>());
    (total(|d| d.toward_plus_x), total(|d| d.toward_minus_x))
}

/// Whether waves go one way, that towards -x or the other, but for this share of noise.
fn goes(directions: &[ByDirection], noise: f64, toward_minus: bool) -> bool {
    let (plus, minus) = by_sign(directions);
    let of_noise = 0.5 * noise * (plus + minus);
    let [along, against] = match toward_minus {
        true => [minus - of_noise, plus - of_noise],
        false => [plus - of_noise, minus - of_noise],
    };
    along > ONE_WAY * (along + against.max(0.0))
}

fn wavenumbers(
    plan: &Plan,
    prepared: &Prepared,
    along: &AlongX,
    since: &Option<Range<usize>>,
    struck: Option<usize>,
) -> (Movement, Option<crate::moved::Evidence>) {
    let axes = &plan.axes;
    let sites = axes.n_sites;
    if sites < 8 {
        return (Movement::untold(Reason::FewSites { sites }), None);
    }
    if along.levels.is_empty() {
        let reason = along.movement.reason.unwrap_or(Reason::NoEnergy);
        return (Movement::untold(reason), None);
    }
    // The ends of a steady wave do not meet.
    let window = match along.has_fronts {
        true => vec![1.0; sites],
        false => Window::Hann.samples(sites),
    };
    let padded = quick(4 * sites);
    let padding = padded as f64 / sites as f64;
    let variances = along.levels.iter().map(|[_, noise]| noise * noise);
    let noise: Vec<f64> = variances.collect();
    let tapered: Vec<f64> = noise.iter().zip(&window).map(|(n, w)| n * w * w).collect();
    let profiles = OfField {
        prepared,
        levels: &along.levels,
        noise: sum(&noise),
        tapered_noise: sum(&tapered),
        transform: RecordTransform::new(&window, padded),
    };
    let among = match since {
        Some(since) => since.start..since.end.min(axes.n_times),
        None => 0..axes.n_times,
    };
    let time = &axes.time;
    let first_time = plan.times.start;
    in_time(&Source {
        profiles: &profiles,
        among,
        step: std::f64::consts::TAU / (padded as f64 * axes.space.step.abs()),
        first: (MEAN_MOTION * padding).ceil() as usize,
        padding,
        period: 1.0 / (along.median * time.step),
        // The kinetic part of a run's energy oscillates all the while.
        is_steady: !along.has_fronts || struck.is_some(),
        is_run: struck.is_some(),
        is_short: along
            .speed
            .is_some_and(|speed| speed.value.abs() < 2.0 * axes.space.step.abs() * along.median),
        uneven: along.uneven,
        returns: false,
        tolerance: plan.request.least_move.unwrap_or(TOLERANCE),
        along_x: along.movement.verdict,
        place: &|rows: Range<usize>| Place {
            rows: [rows.start + first_time, rows.end - 1 + first_time],
            at: 0.5 * (time.at(rows.start) + time.at(rows.end - 1)),
        },
    })
}

/// Profiles of a measured field: `v^2`.
struct OfField<'a> {
    prepared: &'a Prepared<'a>,
    levels: &'a [[f64; 2]],
    /// Sums of the variances, as they are and under the window.
    noise: f64,
    tapered_noise: f64,
    transform: RecordTransform<f64>,
}

impl OfField<'_> {
    fn profile(&self, time: usize) -> Vec<f64> {
        let mut profile = vec![0.0; self.levels.len()];
        self.prepared.profiles(time..time + 1, &mut profile);
        self.prepared.release_pages();
        for (v, [baseline, _]) in profile.iter_mut().zip(self.levels) {
            *v -= baseline;
        }
        profile
    }
}

impl Profiles for OfField<'_> {
    fn energy(&self, time: usize) -> f64 {
        self.profile(time).iter().map(|v| v * v).sum::<f64>() - self.noise
    }

    fn at_ends(&self, time: usize) -> f64 {
        let profile = self.profile(time);
        let n = profile.len();
        let outer = (n / 20).max(1);
        let energy = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>();
        let ends = energy(&profile[..outer]) + energy(&profile[n - outer..]);
        let even = energy(&profile) * 2.0 * outer as f64 / n as f64;
        if even > 0.0 { ends / even } else { 0.0 }
    }

    fn powers(&self, time: usize) -> Vec<f64> {
        let profile = self.profile(time);
        let mut scratch = RecordScratch::default();
        let padded = self.transform.padded();
        let (bins, _) = self
            .transform
            .transform(std::iter::once(&profile[..]), &mut scratch);
        let power = bins.iter().enumerate();
        power
            .map(|(m, x)| fold(m, padded) * (x.norm_sqr() - self.tapered_noise))
            .collect()
    }
}

/// Why shares by direction are withheld, if they are. The bodies of a chain are all there is: its waves do not fold.
pub(super) fn withheld(
    plan: &Plan,
    answer: Option<&Answer>,
    spacetime: &Frequencies,
    simulated: bool,
) -> Option<Undirected> {
    if simulated {
        return None;
    }
    let energies = spacetime.wavenumber_energies.as_deref()?;
    // Offsets of sensors do not travel.
    let moving = energies.iter().zip(&spacetime.static_energies);
    let energies: Vec<f64> = moving.map(|(all, still)| (all - still).max(0.0)).collect();
    let still = sum(&spacetime.static_energies);
    let nk = energies.len();
    let top = nk / 20;
    // Noise is as much at all wavenumbers.
    let noise = answer.map_or(0.0, |answer| answer.noise);
    let all = sum(&energies);
    let (noise, tenth) = (noise * (all + still), (2 * top) as f64 / nk as f64);
    let high = sum(&energies[..top]) + sum(&energies[nk - top..]) - noise * tenth;
    let rest = all - noise;
    if rest <= 0.1 * all {
        return Some(Undirected::Noise);
    }
    let is_steady = answer.is_none_or(|answer| !answer.has_fronts);
    if is_steady && is_flat(&energies) {
        return Some(Undirected::Noise);
    }
    let share = high / rest;
    // All that gains spread may lie there.
    if share > FOLDED + answer.map_or(0.0, |answer| answer.uneven) {
        return Some(Undirected::Folded { share });
    }
    let answer = answer?;
    let wavelength = answer.speed?.value.abs() * answer.period;
    let spacing = plan.axes.space.step.abs();
    match wavelength {
        short if short < 2.0 * spacing => Some(Undirected::Short { wavelength }),
        // Waves of both signs are not two.
        long if long > 2.0 * spacing * plan.axes.n_sites as f64 => {
            Some(Undirected::Long { wavelength })
        }
        _ => None,
    }
}

/// Whether there is about as much energy at all wavenumbers, of both signs: records that do not follow each other.
fn is_flat(energies: &[f64]) -> bool {
    let size = energies.len().div_ceil(BANDS);
    let bands = energies.chunks(size).filter(|band| band.len() == size);
    let (least, most) = bands
        .map(sum)
        .fold((f64::INFINITY, 0.0f64), |(least, most), band| {
            (least.min(band), most.max(band))
        });
    least > FLAT * most
}
