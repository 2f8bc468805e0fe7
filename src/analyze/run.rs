//! The run: passes over the field in the order of the plan, and the assembly of their results.

use serde_json::json;

use super::along::{self, Headline};
use super::arrays::Outputs;
use super::columns::TemporalPassResult;
use super::display::Display;
use super::labels::Power;
use super::noise::KnownNoise;
use super::plan::{Plan, plan};
use super::quality::Findings;
use super::reference::References;
use super::request::Request;
use super::result::*;
use super::rows::SpatialPassResult;
use super::spacetime::ByDirection;
use super::stages::{Clock, FromProfiles, FromRecords, Stages};
use super::{Warning, answer, front};
use crate::arrays::{Arrays, Collect, LargeArray, Precision, Sink};
use crate::diagnostics::SpectrumMoments;
use crate::error::Result;
use crate::field::Field;
use crate::moved::ArrivalWindows;
use crate::numeric::{in_band, sum, sum_of, sum_of_squares};
use crate::observer::{Observer, Silent};
use crate::prepare::{GAIN_STEPS, Prepared, Sites, channels};
use crate::sheet::number;
use crate::transform::Real;
use crate::unit::label;

/// Analyses a field that fits in memory: plan, run, collect. Arrays that are not requested are absent.
///
/// # Errors
/// As [`plan`], and [`crate::Error::NonFinite`].
pub fn analyze(field: &Field, request: &Request) -> Result<(Analysis, Arrays)> {
    let collect = Collect::default();
    let analysis = run(field, &plan(field, request)?, &collect, &Silent)?;
    Ok((analysis, collect.into_arrays()))
}

/// Carries out `plan` on the field for which it was made; large arrays go to `sink` block by block.
///
/// # Errors
/// [`crate::Error::NonFinite`] for gaps if they are refused, [`crate::Error::Cancelled`], and
/// errors of the sink.
pub fn run(
    field: &Field,
    plan: &Plan,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<Analysis> {
    plan.check(field)?;
    crate::system::threads::in_pool(Some(plan.threads), || match plan.request.precision {
        Precision::F64 => passes::<f64>(field, plan, sink, observer),
        Precision::F32 => passes::<f32>(field, plan, sink, observer),
    })
}

fn passes<T: Real>(
    field: &Field,
    plan: &Plan,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<Analysis> {
    let (results, precision) = (plan.request.results, plan.request.precision);
    let outputs = Outputs::new(plan, sink)?;
    let mut clock = Clock::new();

    let (prepared, scans) = Prepared::new(
        field,
        plan.times.clone(),
        plan.sites.clone(),
        plan.request.preparation(plan.segments),
        plan.tiles,
        observer,
    )?;
    clock.lap(plan, "preparation");
    let unit = prepared.unit();
    let stored = stored_square(unit, precision);
    let find = || KnownNoise::find(field, plan, unit, observer);
    let noise = plan.request.subtract_noise.then(find).transpose()?;
    if noise.is_some() {
        clock.lap(plan, "noise");
    }
    let references = References::find(plan, &prepared, &scans, noise.as_ref(), observer)?;
    clock.lap(plan, "reference");
    let stages = Stages {
        noise: noise.as_ref(),
        plan,
        prepared: &prepared,
        references,
        stored,
        outputs: &outputs,
        observer,
    };
    let (records, profiles) = stages.run::<T>(&mut clock)?;
    let (columns, spacetime) = (records.columns.as_ref(), records.spacetime.as_ref());

    let parseval = parseval(plan, &records, &profiles.rows);
    parseval.check(precision)?;
    let noise_left = noise.as_ref().zip(columns);
    let noise_left = noise_left
        .map(|(noise, columns)| noise.left(&columns.subtracted, plan.time_scale.measure * stored));
    let power_unit = if stored == 1.0 { unit } else { 1.0 };
    // A guessed axis carries no verdict.
    let is_told = results.answer && !prepared.is_silent() && !field.has_guessed_layout();
    let find = || answer::find(&stages, &records);
    let mut answer = is_told.then(find).transpose()?;
    let display = Display::find(plan, &records, &profiles.rows);
    let range = (plan.times.clone(), plan.sites.clone());
    let simulated = field.struck.is_some();
    let known = (&plan.request.without_sites[..], Some(&scans[..]));
    let channels = channels(field, range, known, observer)?;
    let has_steps = channels.iter().any(|warning| warning.code == GAIN_STEPS);
    let found = Findings {
        all: &stages,
        scans: &scans,
        simulated,
        has_fronts: answer.as_ref().is_some_and(|answer| answer.has_fronts),
        rows: &profiles.rows,
        records: &records,
    };
    let mut warnings = warnings(field, &found, channels);
    if let Some(answer) = answer.as_mut().filter(|_| !simulated) {
        let space = &field.space;
        warnings.extend(answer::gains(answer, plan, space, has_steps));
    }
    let direction = spacetime.map(|s| direction(plan, &s.directions));
    let undirected =
        spacetime.and_then(|found| answer::withheld(plan, answer.as_ref(), found, simulated));
    let told = direction.filter(|_| undirected.is_none());
    if let Some((answer, direction)) = answer.as_mut().zip(told) {
        answer::returns(answer, direction.above(answer.noise));
    }
    clock.lap(plan, "answer");
    let along_space = columns.filter(|_| results.temporal);
    let windows = answer.as_ref().and_then(|answer| answer.windows.as_ref());
    let along_space = along_space.map(|columns| stages.along_space(columns, &records, windows));
    let (along_space, front) = along_space.unzip();
    // All of a chain that moves from the start stands in modes: no front passes.
    let stands = field.struck.is_some() && answer.as_ref().is_some_and(|of| !of.has_fronts);
    let front = front.filter(|_| !stands);
    let along_time = results.spatial.then(|| stages.along_time(&profiles));
    // A single site has no wavenumber axis.
    let by_frequency = spacetime.filter(|_| plan.axes.n_sites > 1);
    let (scaling, samples) = (plan.request.scaling, field.unit.as_deref());
    let power = Power::new(&plan.axes, scaling, samples, power_unit);
    let label = |array| match array {
        LargeArray::SAMPLES => label(field.quantity.in_words(), samples.unwrap_or_default()),
        _ => power.of_array(array),
    };
    Ok(Analysis {
        name: field.name.clone(),
        content_hash: field.content_hash.clone(),
        quantity: field.quantity,
        unit: field.unit.clone(),
        offset: (plan.times.start, plan.sites.start),
        axes: plan.axes.clone(),
        conventions: plan.conventions.clone(),
        parseval,
        direction,
        answer,
        undirected,
        direction_by_frequency: by_frequency.map(|found| shares(&found.directions)),
        interval: records.interval,
        noise: noise_left,
        along_space,
        along_time,
        front,
        maps: outputs.finish(&plan.axes, &display, label, unit),
        display,
        dispersion: plan.dispersion.clone(),
        short_time: profiles.short_time,
        short_space: profiles.short_space,
        sample_error: None,
        accuracy: accuracy(precision, power_unit, records.checked, &parseval),
        timings: clock.timings,
        warnings,
    })
}

/// What to doubt about the field and its results.
fn warnings(field: &Field, found: &Findings, channels: Vec<Warning>) -> Vec<Warning> {
    let (plan, unit) = (found.all.plan, found.all.prepared.unit());
    let doubts = field.notes.iter().filter(|note| note.is_doubtful);
    let mut warnings: Vec<Warning> = doubts.map(Warning::from).collect();
    let all = plan.sites.clone();
    let sites = Sites {
        indices: all
            .filter(|site| plan.request.without_sites.contains(site))
            .collect(),
        space: &field.space,
    };
    if !sites.indices.is_empty() {
        let what = "left out, and with them spectra along space";
        let advice = "bring the sites that are left to even distances with `--resample cubic`";
        warnings.push(sites.warning("sites-left-out", what, advice, json!({})));
    }
    warnings.extend(channels);
    warnings.extend(found.warnings());
    if found.all.stored == 1.0 && unit != 1.0 {
        let largest = found.scans.iter().fold(0.0, |m: f64, s| m.max(s.largest));
        let [size, of] = [largest, unit].map(number);
        let message = format!(
            "squares of amplitudes up to {size} leave the number range; spectra are in units of {of} squared"
        );
        let advice = "change the unit of the field so that amplitudes come near 1";
        let numbers = json!({"largest": largest, "unit": unit});
        warnings.push(Warning::new(message, advice).coded("unrepresentable", numbers));
    }
    if plan.flux_refused {
        let message = "the quantity is not a velocity, so no kinetic flux surrogate is given";
        let advice =
            "differentiate or integrate to the velocity first, or leave the flux out with `--only`";
        warnings.push(Warning::new(message, advice).coded("no-kinetic-energy", json!({})));
    }
    warnings
}

fn accuracy(
    precision: Precision,
    amplitude_unit: f64,
    checked: Option<(f64, usize)>,
    parseval: &Parseval,
) -> Accuracy {
    let residuals = [parseval.time, parseval.space, parseval.spacetime];
    let residuals = residuals.into_iter().flatten().map(f64::abs);
    Accuracy {
        precision,
        amplitude_unit,
        spot_check: checked.map(|c| c.0),
        spot_checks: checked.map_or(0, |c| c.1),
        parseval: residuals.reduce(f64::max),
        estimated_by: match checked {
            Some(_) => "direct sums in twice the precision; Parseval's identity",
            None => "Parseval's identity",
        },
    }
}

/// Measures of rows as results.
impl Stages<'_> {
    fn along_space(
        &self,
        columns: &TemporalPassResult,
        found: &FromRecords,
        windows: Option<&ArrivalWindows>,
    ) -> (Moments, Front) {
        let (plan, reference) = (self.plan, self.references.site);
        let noise = self.noise_in(&plan.window_time, plan.segments.count());
        let noise_at = |site: usize| match self.noise {
            Some(known) => Some(known.energies[site]),
            None => noise,
        };
        let mut defined = along::defined(&columns.rows, &columns.energies, noise_at);
        for (row, defined) in defined.iter_mut().enumerate() {
            let is_known = self.noise.is_none_or(|noise| noise.is_known(row));
            *defined &= is_known && !plan.is_left_out(row);
        }
        let measure = plan.time_scale.measure * self.stored;
        let mut moments = Moments::gather(&columns.rows, &defined, measure, plan.padding_time());
        for site in &plan.request.without_sites {
            moments.energy[site - plan.sites.start] = f64::NAN;
        }
        let passed = &columns.passed[..];
        let front = front::gather(plan, found.front, passed, &defined, reference, windows);
        // Where the record ends while the front passes, the end makes a part of the spectrum.
        let whole = match front.length {
            Some(_) => &front.fits,
            None => &defined,
        };
        let place = |row| plan.place(row);
        moments.headline = Headline::of(&moments.high_share, &defined, whole, reference, place);
        moments.edge = found.edge;
        (moments, front)
    }

    fn along_time(&self, found: &FromProfiles) -> Moments {
        let (plan, rows) = (self.plan, &found.rows);
        let noise = self.noise_in(&plan.window_space, 1);
        let defined = along::defined(&rows.rows, &rows.energies, |_| noise);
        let measure = plan.space_scale.measure * self.stored;
        let mut moments = Moments::gather(&rows.rows, &defined, measure, plan.padding_space());
        let place = |row| (plan.times.start + row, plan.axes.time.at(row));
        let reference = self.references.time;
        moments.headline = Headline::of(&moments.high_share, &defined, &defined, reference, place);
        moments.edge = found.edge;
        moments
    }

    /// The energy `sum (w v)^2` of the known noise in a row with the given number of segments.
    fn noise_in(&self, window: &[f64], segments: usize) -> Option<f64> {
        let noise = self.plan.request.noise? / self.prepared.unit();
        Some(noise * noise * sum_of_squares(window) * segments as f64)
    }
}

/// `unit^2`, by which spectra are multiplied before they are stored; 1 (they stay in units of
/// `unit^2`) where that would leave the number range within 80 binary orders of the largest.
fn stored_square(unit: f64, precision: Precision) -> f64 {
    let limit = match precision {
        Precision::F64 => 470.0,
        Precision::F32 => 23.0,
    };
    match unit.log2().abs() <= limit {
        true => unit * unit,
        false => 1.0,
    }
}

fn parseval(plan: &Plan, records: &FromRecords, rows: &SpatialPassResult) -> Parseval {
    let columns = records.columns.as_ref();
    let residual = |transformed: f64, samples: f64| {
        (samples > 0.0 && samples.is_finite()).then(|| transformed / samples - 1.0)
    };
    let total = |rows: &[SpectrumMoments]| sum_of(rows.iter().map(|r| r.total));
    let segments = plan.segments.count() as f64;
    let (time, space) = (plan.time_scale, plan.space_scale);
    let along_time = columns.filter(|_| plan.request.results.temporal);
    Parseval {
        time: along_time.and_then(|c| {
            let samples = sum(&c.energies) / segments * time.energy;
            let subtracted = sum_of(c.subtracted.iter().map(|one| one.total));
            residual((total(&c.rows) + subtracted) * time.measure, samples)
        }),
        space: match plan.transforms_space() {
            true => {
                let samples = sum(&rows.energies) * space.energy;
                residual(total(&rows.rows) * space.measure, samples)
            }
            false => None,
        },
        spacetime: columns.zip(records.spacetime.as_ref()).and_then(|(c, by)| {
            let tapered = c.energies.iter().zip(&plan.window_space);
            let tapered = sum_of(tapered.map(|(e, w)| e * w * w));
            let samples = tapered / segments * time.energy * space.energy;
            let total = sum_of(by.directions.iter().map(ByDirection::total));
            residual(total * time.measure * space.measure, samples)
        }),
    }
}

fn direction(plan: &Plan, by: &[ByDirection]) -> Direction {
    let band = plan.direction_band;
    let of = |part: fn(&ByDirection) -> f64| {
        let all = by.iter().zip(&plan.axes.frequency);
        let chosen = all.filter(|(_, q)| in_band(**q, band));
        sum_of(chosen.map(|(b, _)| part(b)))
    };
    // A field without energy has no direction, 0 / 0 being NaN, and neither has a single site.
    let total = match plan.axes.n_sites {
        1 => f64::NAN,
        _ => of(ByDirection::total),
    };
    Direction {
        toward_plus_x: of(|b| b.toward_plus_x) / total,
        toward_minus_x: of(|b| b.toward_minus_x) / total,
        undirected: of(|b| b.undirected) / total,
        band,
    }
}

fn shares(by: &[ByDirection]) -> [Vec<f64>; 2] {
    let share = |part: fn(&ByDirection) -> f64| by.iter().map(|b| part(b) / b.total()).collect();
    [share(|b| b.toward_plus_x), share(|b| b.toward_minus_x)]
}
