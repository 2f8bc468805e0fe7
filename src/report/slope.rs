//! Spectral slopes as files: a summary, and arrays.

use std::path::Path;

use serde::Serialize;

use super::{Archive, Provenance};
use crate::arrays::Precision;
use crate::error::Result;
use crate::estimates::{BreakFit, FieldAxis, PowerLaw, Slope, Steepening};

/// The schema of the summary of a slope.
pub const SLOPE_SCHEMA: &str = "cascade.slope/1";

/// `summary.json` of a slope; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct SlopeSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    time_unit: String,
    space_unit: String,
    axis: FieldAxis,
    shots: usize,
    segment: usize,
    overlap: usize,
    left_out: u64,
    alpha: f64,
    law: PowerLaw,
    breaks: Option<&'a BreakFit>,
    steepening: Option<Steepening>,
}

impl<'a> SlopeSummary<'a> {
    pub fn new(found: &'a Slope, provenance: &'a Provenance) -> Self {
        let (time_unit, space_unit) = found.units();
        SlopeSummary {
            schema: SLOPE_SCHEMA,
            provenance,
            time_unit,
            space_unit,
            axis: found.axis,
            shots: found.shots,
            segment: found.segment[0],
            overlap: found.segment[1],
            left_out: found.left_out,
            alpha: found.alpha,
            law: found.law,
            breaks: found.breaks.as_ref(),
            steepening: found.steepening,
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Writes a slope to the new file `path` (`.npz`): `wavenumber` or `frequency`, `spectrum`, `compensated` (bins); along x
/// `frame_time`, `frame_slope`, `frame_slope_half`, `frame_gradient` (frames).
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_slope(path: &Path, found: &Slope) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    let line = |name: &str, values: &[f64]| archive.append(name, &[values.len()], values);
    let name = match found.axis {
        FieldAxis::Space => "wavenumber",
        FieldAxis::Time => "frequency",
    };
    line(name, &found.abscissa)?;
    line("spectrum", &found.spectrum)?;
    line("compensated", &found.compensated())?;
    if let Some(frames) = &found.frames {
        line("frame_time", &frames.time)?;
        line("frame_slope", &frames.slope)?;
        line("frame_slope_half", &frames.half)?;
        line("frame_gradient", &frames.gradient)?;
    }
    archive.finish()
}
