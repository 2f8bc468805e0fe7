//! Spectra by least squares as files: a summary, and arrays.

use std::path::Path;

use serde::Serialize;

use super::{Archive, Provenance};
use crate::arrays::Precision;
use crate::error::Result;
use crate::estimates::{Lomb, LombAxis};

/// The schema of the summary of spectra by least squares.
pub const LOMB_SCHEMA: &str = "cascade.lomb/1";

/// `summary.json` of spectra by least squares; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct LombSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    axis: LombAxis,
    unit: String,
    frequencies: usize,
    lowest: f64,
    highest: f64,
    shortest_step: f64,
    longest_step: f64,
    mean_step: f64,
    missing: usize,
    averaged: usize,
    alpha: f64,
    columns: Vec<ColumnSummary>,
}

#[derive(Debug, Serialize)]
struct ColumnSummary {
    samples: usize,
    level: f64,
    frequency: f64,
    power: f64,
    /// Probability that white noise has this power anywhere.
    false_alarm: f64,
}

impl<'a> LombSummary<'a> {
    pub fn new(found: &'a Lomb, provenance: &'a Provenance) -> Self {
        let columns = found.samples.iter().zip(&found.level).zip(&found.peaks);
        LombSummary {
            schema: LOMB_SCHEMA,
            provenance,
            axis: found.axis,
            unit: found.unit(),
            frequencies: found.frequency.len(),
            lowest: found.frequency[0],
            highest: found.frequency[found.frequency.len() - 1],
            shortest_step: found.steps[0],
            longest_step: found.steps[1],
            mean_step: found.steps[2],
            missing: found.missing,
            averaged: found.averaged,
            alpha: found.alpha,
            columns: columns
                .map(
                    |((samples, level), [frequency, power, false_alarm])| ColumnSummary {
                        samples: *samples,
                        level: *level,
                        frequency: *frequency,
                        power: *power,
                        false_alarm: *false_alarm,
                    },
                )
                .collect(),
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Writes spectra by least squares to the new file `path` (`.npz`): `frequency` (nf); `power`, `density` (nf, n);
/// `samples`, `level`, `peak_frequency`, `peak_power`, `false_alarm` (n); along time also `position` (n).
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_lomb(path: &Path, found: &Lomb) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    let line = |name: &str, values: &[f64]| archive.append(name, &[values.len()], values);
    line("frequency", &found.frequency)?;
    if found.axis == LombAxis::Time {
        line("position", &found.positions)?;
    }
    for (name, array) in [("power", &found.power), ("density", &found.density)] {
        let values: Vec<f64> = array.iter().copied().collect();
        archive.append(name, &[array.nrows(), array.ncols()], &values)?;
    }
    let samples: Vec<f64> = found.samples.iter().map(|n| *n as f64).collect();
    line("samples", &samples)?;
    line("level", &found.level)?;
    let peak = |i: usize| found.peaks.iter().map(|peak| peak[i]).collect::<Vec<f64>>();
    line("peak_frequency", &peak(0))?;
    line("peak_power", &peak(1))?;
    line("false_alarm", &peak(2))?;
    archive.finish()
}
