//! Spectra with intervals as files: a summary, and arrays.

use serde::Serialize;

use super::estimate_arrays::{Arrays, Units};
use super::{LabelledArrays, Provenance};
use crate::error::Result;
use crate::estimates::{
    Independence, LeftOutEach, Line, SpectrumAxis, SpectrumEstimate, interval_factors,
};

/// The schema of the summary of spectra with intervals.
pub const SPECTRUM_SCHEMA: &str = "cascade.spectrum/1";

/// `summary.json` of spectra with intervals; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct SpectrumSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    along: SpectrumAxis,
    time_unit: String,
    space_unit: String,
    unit: Option<&'a str>,
    segment: usize,
    overlap: usize,
    /// `NW` bins of several tapers, as a frequency (wavenumber).
    half_bandwidth: Option<f64>,
    independence: Independence,
    steadiness: &'a [f64],
    /// Sites (along space, times) without interval.
    without_interval: usize,
    /// Along space, how evenly the energy is spread over time.
    steadiness_in_time: Option<f64>,
    alpha: f64,
    degrees_of_freedom: Option<DegreesSummary>,
    jackknife_leaves_out: LeftOutEach,
    line_test: Option<LineTestSummary<'a>>,
}

/// Degrees of freedom away from 0 and from the Nyquist frequency.
#[derive(Debug, Serialize)]
struct DegreesSummary {
    least: f64,
    median: f64,
    largest: f64,
    /// Of the interval with the median.
    interval_factors: [f64; 2],
}

#[derive(Debug, Serialize)]
struct LineTestSummary<'a> {
    degrees_of_freedom: [f64; 2],
    level: f64,
    level_of_all: f64,
    lines: &'a [Line],
}

impl<'a> SpectrumSummary<'a> {
    pub fn new(found: &'a SpectrumEstimate, provenance: &'a Provenance) -> Self {
        let (time_unit, space_unit) = found.units();
        let degrees = found.degrees_range();
        SpectrumSummary {
            schema: SPECTRUM_SCHEMA,
            provenance,
            along: found.along,
            time_unit,
            space_unit,
            unit: found.unit.as_deref(),
            segment: found.segment[0],
            overlap: found.segment[1],
            half_bandwidth: found.half_bandwidth,
            independence: found.independence,
            steadiness: &found.steadiness,
            without_interval: found.without_interval(),
            steadiness_in_time: found.mean.as_ref().map(|mean| mean.steadiness),
            alpha: found.alpha,
            degrees_of_freedom: degrees.map(|[least, median, largest]| DegreesSummary {
                least,
                median,
                largest,
                interval_factors: interval_factors(median, found.alpha),
            }),
            jackknife_leaves_out: found.left_out,
            line_test: found.line_test.as_ref().map(|test| LineTestSummary {
                degrees_of_freedom: test.degrees,
                level: test.level,
                level_of_all: test.level_of_all,
                lines: &test.lines,
            }),
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Hands spectra to `file`: `frequency` (nf), `position`, `steadiness` (n); `spectrum`, `degrees_of_freedom`,
/// `low`, `high`, `jackknife_low`, `jackknife_high` (nf, n), NaN where there is no interval; of several tapers
/// `f_statistic` (nf, n). Along space, `wavenumber` and `time` take the place of `frequency` and `position`,
/// beside `mean_spectrum`, `mean_low`, `mean_high`, `effective_snapshots` (nk).
///
/// # Errors
/// Those of `file`.
pub fn spectrum_arrays(found: &SpectrumEstimate, file: &dyn LabelledArrays) -> Result<()> {
    let to = Arrays(file);
    let units = Units::of(&found.time, &found.space, found.unit.as_deref());
    let [(bins, bin_unit), (columns, column_unit)] = match found.along {
        SpectrumAxis::Time => [("frequency", &units.frequency), ("position", &units.space)],
        SpectrumAxis::Space => [("wavenumber", &units.wavenumber), ("time", &units.time)],
    };
    let density = units.density(bin_unit, "");
    to.line(bins, bins, bin_unit, &found.bins)?;
    to.line(columns, columns, column_unit, &found.coordinates())?;
    to.line("steadiness", columns, "", &found.steadiness)?;
    let plane = |name: &str, unit: &str, values: &mut dyn Iterator<Item = f64>| {
        let values: Vec<f64> = values.collect();
        let (rows, across) = found.spectrum.dim();
        to.of_axes(name, &[(bins, rows), (columns, across)], unit, &values)
    };
    plane("spectrum", &density, &mut found.spectrum.iter().copied())?;
    let degrees = &mut found.degrees.iter().copied();
    plane("degrees_of_freedom", "", degrees)?;
    plane("low", &density, &mut found.low.iter().copied())?;
    plane("high", &density, &mut found.high.iter().copied())?;
    let jackknife = |sign: f64| {
        let cells = found.spectrum.iter().zip(&found.jackknife);
        cells.map(move |(s, half)| s * (sign * half).exp())
    };
    plane("jackknife_low", &density, &mut jackknife(-1.0))?;
    plane("jackknife_high", &density, &mut jackknife(1.0))?;
    if let Some(test) = &found.line_test {
        plane("f_statistic", "", &mut test.statistic.iter().copied())?;
    }
    if let Some(mean) = &found.mean {
        to.line("mean_spectrum", bins, &density, &mean.spectrum)?;
        to.line("mean_low", bins, &density, &mean.low)?;
        to.line("mean_high", bins, &density, &mean.high)?;
        to.line("effective_snapshots", bins, "", &mean.effective_snapshots)?;
    }
    Ok(())
}
