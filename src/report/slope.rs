//! Spectral slopes as files: a summary, and arrays.

use serde::Serialize;

use super::estimate_arrays::{Arrays, Units};
use super::{LabelledArrays, Provenance};
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

/// Hands a slope to `file`: `wavenumber` or `frequency`, `spectrum`, `compensated` (bins); along x `frame_time`,
/// `frame_slope`, `frame_slope_half`, `frame_gradient` (frames).
///
/// # Errors
/// Those of `file`.
pub fn slope_arrays(found: &Slope, file: &dyn LabelledArrays) -> Result<()> {
    let to = Arrays(file);
    let units = Units::of(&found.time, &found.space, found.unit.as_deref());
    let (name, unit) = match found.axis {
        FieldAxis::Space => ("wavenumber", &units.wavenumber),
        FieldAxis::Time => ("frequency", &units.frequency),
    };
    to.line(name, name, unit, &found.abscissa)?;
    to.line("spectrum", name, &units.density(unit, ""), &found.spectrum)?;
    to.line("compensated", name, "", &found.compensated())?;
    let Some(frames) = &found.frames else {
        return Ok(());
    };
    to.line("frame_time", "frame_time", &units.time, &frames.time)?;
    to.line("frame_slope", "frame_time", "", &frames.slope)?;
    to.line("frame_slope_half", "frame_time", "", &frames.half)?;
    let gradient = units.gradient();
    to.line("frame_gradient", "frame_time", &gradient, &frames.gradient)
}
