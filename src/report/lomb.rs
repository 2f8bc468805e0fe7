//! Spectra by least squares as files: a summary, and arrays.

use serde::Serialize;

use super::estimate_arrays::{Arrays, Units};
use super::{LabelledArrays, Provenance};
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

/// Hands spectra by least squares to `file`: `frequency` (nf); `power`, `density` (nf, n); `samples`, `level`,
/// `peak_frequency`, `peak_power`, `false_alarm` (n); along time also `position` (n).
///
/// # Errors
/// Those of `file`.
pub fn lomb_arrays(found: &Lomb, file: &dyn LabelledArrays) -> Result<()> {
    let to = Arrays(file);
    let units = Units::of(&found.time, &found.space, found.sample_unit.as_deref());
    let (axis, cycles) = match found.axis {
        LombAxis::Time => ("position", units.frequency.clone()),
        LombAxis::Space => ("profiles", units.cycles_per_length()),
    };
    to.line("frequency", "frequency", &cycles, &found.frequency)?;
    if found.axis == LombAxis::Time {
        to.line("position", axis, &units.space, &found.positions)?;
    }
    let axes = ["frequency", axis];
    to.plane("power", axes, "", &found.power)?;
    let density = units.density(&cycles, "");
    to.plane("density", axes, &density, &found.density)?;
    let samples: Vec<f64> = found.samples.iter().map(|n| *n as f64).collect();
    to.line("samples", axis, "", &samples)?;
    to.line("level", axis, "", &found.level)?;
    for (i, (name, unit)) in [
        ("peak_frequency", &cycles[..]),
        ("peak_power", ""),
        ("false_alarm", ""),
    ]
    .into_iter()
    .enumerate()
    {
        let values: Vec<f64> = found.peaks.iter().map(|peak| peak[i]).collect();
        to.line(name, axis, unit, &values)?;
    }
    Ok(())
}
