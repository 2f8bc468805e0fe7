//! `S(k, f)` with intervals as files: a summary, and arrays.

use serde::Serialize;

use super::estimate_arrays::{Arrays, Units};
use super::spectrum::DegreesSummary;
use super::{LabelledArrays, Provenance};
use crate::error::Result;
use crate::estimates::{Independence, SpaceTimeEstimate};
use crate::unit::compose;

/// The schema of the summary of space-time spectra with intervals.
pub const SPACETIME_SCHEMA: &str = "cascade.spacetime/1";

/// `summary.json` of a space-time spectrum with intervals; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct SpaceTimeSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    time_unit: String,
    space_unit: String,
    unit: Option<&'a str>,
    segment: usize,
    overlap: usize,
    tapers_along_time: usize,
    tapers_along_space: usize,
    /// `NW` bins of several tapers, as a frequency and as a wavenumber.
    half_bandwidth: [Option<f64>; 2],
    independence: Independence,
    evenness_along_space: f64,
    alpha: f64,
    /// Of cells whose transforms are complex.
    degrees_of_freedom: Option<DegreesSummary>,
    power: f64,
    mean_square: f64,
    parseval_residual: f64,
    /// Of the largest density.
    largest: Largest,
    /// Shares of the power.
    towards_plus_x: f64,
    towards_minus_x: f64,
    undirected: f64,
}

#[derive(Debug, Serialize)]
struct Largest {
    frequency: f64,
    wavenumber: f64,
    density: f64,
}

impl<'a> SpaceTimeSummary<'a> {
    pub fn new(found: &'a SpaceTimeEstimate, provenance: &'a Provenance) -> Self {
        let (time_unit, space_unit) = found.units();
        let degrees = found.degrees_range();
        let (row, column) = found.largest();
        let [towards_plus_x, towards_minus_x, undirected] = found.directions();
        SpaceTimeSummary {
            schema: SPACETIME_SCHEMA,
            provenance,
            time_unit,
            space_unit,
            unit: found.unit.as_deref(),
            segment: found.segment[0],
            overlap: found.segment[1],
            tapers_along_time: found.tapers[0],
            tapers_along_space: found.tapers[1],
            half_bandwidth: found.half_bandwidth,
            independence: found.independence,
            evenness_along_space: found.evenness,
            alpha: found.alpha,
            degrees_of_freedom: degrees.map(|degrees| DegreesSummary::new(degrees, found.alpha)),
            power: found.power,
            mean_square: found.mean_square,
            parseval_residual: found.parseval,
            largest: Largest {
                frequency: found.frequency[row],
                wavenumber: found.wavenumber[column],
                density: found.spectrum[[row, column]],
            },
            towards_plus_x,
            towards_minus_x,
            undirected,
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Hands a space-time spectrum to `file`: `frequency` (nf), `wavenumber` (nk); `spectrum`, `degrees_of_freedom`,
/// `low`, `high` (nf, nk), NaN where there is no interval.
///
/// # Errors
/// Those of `file`.
pub fn spacetime_arrays(found: &SpaceTimeEstimate, file: &dyn LabelledArrays) -> Result<()> {
    let to = Arrays(file);
    let units = Units::of(&found.time, &found.space, found.unit.as_deref());
    to.line("frequency", "frequency", &units.frequency, &found.frequency)?;
    to.line(
        "wavenumber",
        "wavenumber",
        &units.wavenumber,
        &found.wavenumber,
    )?;
    let density = match units.frequency.is_empty() || units.wavenumber.is_empty() {
        true => String::new(),
        false => compose(
            &[&units.density(&units.frequency, "")],
            &[&units.wavenumber],
        ),
    };
    for (name, unit, array) in [
        ("spectrum", &density[..], &found.spectrum),
        ("degrees_of_freedom", "", &found.degrees),
        ("low", &density, &found.low),
        ("high", &density, &found.high),
    ] {
        to.plane(name, ["frequency", "wavenumber"], unit, array)?;
    }
    Ok(())
}
