//! Coherence as files: a summary, and arrays.

use std::path::Path;

use serde::Serialize;

use super::{Archive, NamedArrays, Provenance};
use crate::arrays::Precision;
use crate::error::Result;
use crate::estimates::{Coherence, Delay, Independence, PhaseSpeed, SegmentsLeft};

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
    delays: &'a [Option<Delay>],
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
            delays: &found.delays,
            speeds: &found.speeds,
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Writes a coherence to the new file `path` (`.npz`): `frequency` (nf), `position` (n); `coherence`, `phase`,
/// `phase_interval`, `spectrum` (nf, n); `delay`, `delay_error` (n), NaN where there is none;
/// `speed_frequency`, `wavenumber`, `wavenumber_error`, `phase_velocity`, `phase_velocity_error` of the
/// frequencies at which enough sites are coherent. Where segments are left out, `segments`,
/// `effective_realisations`, `level` (n).
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_coherence(path: &Path, found: &Coherence) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    coherence_arrays(found, &archive)?;
    archive.finish()
}

/// The arrays of [`write_coherence`].
///
/// # Errors
/// Those of `archive`.
pub fn coherence_arrays(found: &Coherence, archive: &dyn NamedArrays) -> Result<()> {
    let line = |name: &str, values: &[f64]| archive.append(name, &[values.len()], values);
    line("frequency", &found.frequency)?;
    line("position", &found.positions())?;
    if let Some(left) = &found.segments_left {
        let segments: Vec<f64> = left.left.iter().map(|left| *left as f64).collect();
        line("segments", &segments)?;
        line("effective_realisations", &left.effective)?;
        let level = |site: usize| found.level_at(site).unwrap_or(f64::NAN);
        line("level", &(0..segments.len()).map(level).collect::<Vec<_>>())?;
    }
    for (name, array) in [
        ("coherence", &found.coherence),
        ("phase", &found.phase),
        ("phase_interval", &found.phase_interval),
        ("spectrum", &found.spectrum),
    ] {
        let values: Vec<f64> = array.iter().copied().collect();
        archive.append(name, &[array.nrows(), array.ncols()], &values)?;
    }
    let delays = |of: fn(&Delay) -> f64| -> Vec<f64> {
        let delays = found.delays.iter().map(|delay| delay.as_ref().map(of));
        delays.map(|delay| delay.unwrap_or(f64::NAN)).collect()
    };
    line("delay", &delays(|delay| delay.delay))?;
    line("delay_error", &delays(|delay| delay.error))?;
    let speeds = |of: fn(&PhaseSpeed) -> f64| -> Vec<f64> { found.speeds.iter().map(of).collect() };
    line("speed_frequency", &speeds(|speed| speed.frequency))?;
    line("wavenumber", &speeds(|speed| speed.wavenumber))?;
    line("wavenumber_error", &speeds(|speed| speed.wavenumber_error))?;
    line("phase_velocity", &speeds(|speed| speed.velocity))?;
    line(
        "phase_velocity_error",
        &speeds(|speed| speed.velocity_error),
    )
}
