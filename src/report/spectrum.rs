//! Spectra with intervals as files: a summary, and arrays.

use serde::Serialize;

use super::estimate_arrays::{Arrays, Units};
use super::{LabelledArrays, Provenance};
use crate::error::Result;
use crate::estimates::{
    Independence, LeftOutEach, Line, NoiseFloor, SegmentsLeft, SiteNoise, SpectrumAxis,
    SpectrumEstimate, SubtractedNoise, interval_factors,
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
    /// Of each site, where segments with missing samples are left out.
    segments_left: Option<&'a SegmentsLeft>,
    steadiness: &'a [f64],
    /// Sites (along space, times) without interval.
    without_interval: usize,
    /// Along space, how evenly the energy is spread over time.
    steadiness_in_time: Option<f64>,
    alpha: f64,
    degrees_of_freedom: Option<DegreesSummary>,
    /// `null` without a jackknife.
    jackknife_leaves_out: Option<LeftOutEach>,
    /// Of each site, along time.
    noise: Option<NoiseSummary<'a>>,
    line_test: Option<LineTestSummary<'a>>,
}

/// The noise of all sites; `null` where it is not known.
#[derive(Debug, Serialize)]
pub(super) struct NoiseSummary<'a> {
    known: usize,
    sites: &'a [Option<SiteNoise>],
    subtracted: Option<&'a SubtractedNoise>,
}

impl<'a> NoiseSummary<'a> {
    pub fn new(noise: &'a NoiseFloor) -> Self {
        NoiseSummary {
            known: noise.known(),
            sites: &noise.sites,
            subtracted: noise.subtracted.as_ref(),
        }
    }
}

/// Degrees of freedom away from 0 and from the Nyquist frequency.
#[derive(Debug, Serialize)]
pub(super) struct DegreesSummary {
    least: f64,
    median: f64,
    largest: f64,
    /// Of the interval with the median.
    interval_factors: [f64; 2],
}

impl DegreesSummary {
    pub fn new([least, median, largest]: [f64; 3], alpha: f64) -> Self {
        DegreesSummary {
            least,
            median,
            largest,
            interval_factors: interval_factors(median, alpha),
        }
    }
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
            segments_left: found.segments_left.as_ref(),
            steadiness: &found.steadiness,
            without_interval: found.without_interval(),
            steadiness_in_time: found.mean.as_ref().map(|mean| mean.steadiness),
            alpha: found.alpha,
            degrees_of_freedom: degrees.map(|degrees| DegreesSummary::new(degrees, found.alpha)),
            jackknife_leaves_out: found.has_jackknife.then_some(found.left_out),
            noise: found.noise.as_ref().map(NoiseSummary::new),
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
/// `low`, `high`, `jackknife_low`, `jackknife_high` (nf, n), NaN where there is no interval; along time `noise`, `noise_low`,
/// `noise_high` (n), densities; where segments are left out `segments`, `effective_realisations` (n); of several tapers
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
    if let Some(left) = &found.segments_left {
        let segments: Vec<f64> = left.left.iter().map(|left| *left as f64).collect();
        to.line("segments", columns, "", &segments)?;
        to.line("effective_realisations", columns, "", &left.effective)?;
    }
    if let Some(noise) = &found.noise {
        let of = |part: fn(&SiteNoise) -> f64| -> Vec<f64> {
            let sites = noise.sites.iter();
            sites
                .map(|site| site.as_ref().map_or(f64::NAN, part))
                .collect()
        };
        to.line("noise", columns, &density, &of(|noise| noise.density))?;
        to.line("noise_low", columns, &density, &of(|noise| noise.low))?;
        to.line("noise_high", columns, &density, &of(|noise| noise.high))?;
    }
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
