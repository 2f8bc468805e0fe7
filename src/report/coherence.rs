//! Coherence as files: a summary, and arrays.

use serde::Serialize;

use super::estimate_arrays::{Arrays, Units};
use super::{LabelledArrays, Provenance};
use crate::error::Result;
use crate::estimates::{Coherence, Delay, Independence, PhaseSpeed, SegmentsLeft, WaveVelocity};

/// The schema of the summary of a coherence.
pub const COHERENCE_SCHEMA: &str = "cascade.coherence/1";

/// `summary.json` of a coherence; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct CoherenceSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    time_unit: String,
    space_unit: String,
    reference: usize,
    reference_position: f64,
    segment: usize,
    overlap: usize,
    independence: Independence,
    /// Of each site, where segments with missing samples are left out.
    segments_left: Option<&'a SegmentsLeft>,
    alpha: f64,
    level: Option<f64>,
    /// Share of the cells away from the reference, 0 and the Nyquist frequency left out, above the level.
    above_level: Option<f64>,
    /// Of each site, whether it is above chance over all frequencies.
    is_coherent: &'a [bool],
    delays: &'a [Option<Delay>],
    velocity: Option<WaveVelocity>,
    speeds: &'a [PhaseSpeed],
}

impl<'a> CoherenceSummary<'a> {
    pub fn new(found: &'a Coherence, provenance: &'a Provenance) -> Self {
        let (time_unit, space_unit) = found.units();
        CoherenceSummary {
            schema: COHERENCE_SCHEMA,
            provenance,
            time_unit,
            space_unit,
            reference: found.reference,
            reference_position: found.space.at(found.reference),
            segment: found.segment[0],
            overlap: found.segment[1],
            independence: found.independence,
            segments_left: found.segments_left.as_ref(),
            alpha: found.alpha,
            level: found.level(),
            above_level: found.above_level(),
            is_coherent: &found.is_coherent,
            delays: &found.delays,
            velocity: found.velocity,
            speeds: &found.speeds,
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Hands a coherence to `file`: `frequency` (nf), `position` (n); `coherence`, `phase`, `phase_interval`,
/// `spectrum` (nf, n); `delay`, `delay_error`, `delay_interval`, `delay_ambiguity` (n), NaN where there is none; `speed_frequency`, `wavenumber`,
/// `wavenumber_error`, `phase_velocity`, `phase_velocity_error` of the frequencies at which enough sites are
/// coherent. Where segments are left out, `segments`, `effective_realisations`, `level` (n).
///
/// # Errors
/// Those of `file`.
pub fn coherence_arrays(found: &Coherence, file: &dyn LabelledArrays) -> Result<()> {
    let to = Arrays(file);
    let units = Units::of(&found.time, &found.space, found.unit.as_deref());
    to.line("frequency", "frequency", &units.frequency, &found.frequency)?;
    to.line("position", "position", &units.space, &found.positions())?;
    if let Some(left) = &found.segments_left {
        let segments: Vec<f64> = left.left.iter().map(|left| *left as f64).collect();
        to.line("segments", "position", "", &segments)?;
        to.line("effective_realisations", "position", "", &left.effective)?;
        let level = |site: usize| found.level_at(site).unwrap_or(f64::NAN);
        let levels: Vec<f64> = (0..segments.len()).map(level).collect();
        to.line("level", "position", "", &levels)?;
    }
    let density = units.density(&units.frequency, "");
    for (name, unit, array) in [
        ("coherence", "", &found.coherence),
        ("phase", "rad", &found.phase),
        ("phase_interval", "rad", &found.phase_interval),
        ("spectrum", &density, &found.spectrum),
    ] {
        to.plane(name, ["frequency", "position"], unit, array)?;
    }
    let delays = |of: fn(&Delay) -> f64| -> Vec<f64> {
        let delays = found.delays.iter().map(|delay| delay.as_ref().map(of));
        delays.map(|delay| delay.unwrap_or(f64::NAN)).collect()
    };
    to.line("delay", "position", &units.time, &delays(|d| d.delay))?;
    to.line("delay_error", "position", &units.time, &delays(|d| d.error))?;
    to.line(
        "delay_interval",
        "position",
        &units.time,
        &delays(|d| d.interval),
    )?;
    let period = |d: &Delay| d.ambiguity.unwrap_or(f64::NAN);
    to.line("delay_ambiguity", "position", &units.time, &delays(period))?;
    let speeds = |name: &str, unit: &str, of: fn(&PhaseSpeed) -> f64| {
        let values: Vec<f64> = found.speeds.iter().map(of).collect();
        to.line(name, "speed_frequency", unit, &values)
    };
    speeds("speed_frequency", &units.frequency, |s| s.frequency)?;
    speeds("wavenumber", &units.wavenumber, |s| s.wavenumber)?;
    speeds("wavenumber_error", &units.wavenumber, |s| {
        s.wavenumber_error
    })?;
    speeds("phase_velocity", &units.velocity, |s| s.velocity)?;
    speeds("phase_velocity_error", &units.velocity, |s| {
        s.velocity_error
    })
}
