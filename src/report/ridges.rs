//! Ridges as files: a summary, a table, arrays.

use serde::Serialize;

use super::arrays::power_of;
use super::estimate_arrays::{Arrays, Units};
use super::{LabelledArrays, Provenance};
use crate::error::Result;
use crate::ridges::{RidgeCut, RidgeParameter, RidgePoint, Ridges};
use crate::unit;

/// The schema of the summary of ridges.
pub const RIDGES_SCHEMA: &str = "cascade.ridges/1";

/// `summary.json` of ridges; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct RidgesSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    time_unit: String,
    space_unit: String,
    records: usize,
    segment: usize,
    overlap: usize,
    segments: usize,
    window_time: &'a str,
    window_space: &'a str,
    realisations: f64,
    /// Below a half the fields are a transient, of which nothing has an error.
    steadiness: f64,
    alpha: f64,
    level: f64,
    frequency_bin: f64,
    wavenumber_bin: f64,
    frequency_resolution: f64,
    wavenumber_resolution: f64,
    branches: usize,
    ridges: Vec<RidgeSummary>,
    fits: Vec<FitSummary<'a>>,
}

#[derive(Debug, Serialize)]
struct RidgeSummary {
    branch: usize,
    cut: RidgeCut,
    points: usize,
    frequency: [f64; 2],
    wavenumber: [f64; 2],
}

#[derive(Debug, Serialize)]
struct FitSummary<'a> {
    law: &'a str,
    parameters: &'a [RidgeParameter],
    points: usize,
    deviation_bins: f64,
    reduced_chi_square: f64,
}

impl<'a> RidgesSummary<'a> {
    pub fn new(found: &'a Ridges, provenance: &'a Provenance) -> Self {
        let axes = &found.analysis.axes;
        let conventions = &found.analysis.conventions;
        let ends = |points: &[RidgePoint], of: fn(&RidgePoint) -> f64| {
            let all = points.iter().map(of);
            let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            });
            [low, high]
        };
        RidgesSummary {
            schema: RIDGES_SCHEMA,
            provenance,
            time_unit: axes.time_unit().to_owned(),
            space_unit: axes.space_unit().to_owned(),
            records: found.records,
            segment: conventions.segment,
            overlap: conventions.overlap,
            segments: conventions.segments,
            window_time: &conventions.window_time.name,
            window_space: &conventions.window_space.name,
            realisations: found.realisations,
            steadiness: found.independence.steadiness,
            alpha: found.alpha,
            level: found.level,
            frequency_bin: found.bins[0],
            wavenumber_bin: found.bins[1],
            frequency_resolution: found.resolution[0],
            wavenumber_resolution: found.resolution[1],
            branches: found.branches(),
            ridges: found
                .ridges
                .iter()
                .map(|ridge| RidgeSummary {
                    branch: ridge.branch,
                    cut: ridge.cut,
                    points: ridge.points.len(),
                    frequency: ends(&ridge.points, |point| point.frequency),
                    wavenumber: ends(&ridge.points, |point| point.wavenumber),
                })
                .collect(),
            fits: found
                .fits
                .iter()
                .map(|fit| FitSummary {
                    law: &fit.name,
                    parameters: &fit.parameters,
                    points: fit.points,
                    deviation_bins: fit.deviation,
                    reduced_chi_square: fit.reduced,
                })
                .collect(),
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

type Column = (&'static str, fn(&RidgePoint) -> f64);

/// Numbers of a point, by their names in tables and archives.
const COLUMNS: [Column; 11] = [
    ("frequency", |p| p.frequency),
    ("frequency_error", |p| p.frequency_error),
    ("wavenumber", |p| p.wavenumber),
    ("wavenumber_error", |p| p.wavenumber_error),
    ("power", |p| p.power),
    ("noise", |p| p.noise),
    ("width", |p| p.width),
    ("phase_velocity", |p| p.phase_velocity),
    ("phase_velocity_error", |p| p.phase_velocity_error),
    ("group_velocity", |p| p.group_velocity),
    ("group_velocity_error", |p| p.group_velocity_error),
];

/// The points as a table, a row each: `branch`, `cut`, then the numbers; empty cells where one is not defined.
pub fn ridges_csv(found: &Ridges) -> String {
    let names: Vec<&str> = COLUMNS.iter().map(|(name, _)| *name).collect();
    let mut text = format!("branch,cut,{}\n", names.join(","));
    for ridge in &found.ridges {
        let cut = match ridge.cut {
            RidgeCut::Frequency => "frequency",
            RidgeCut::Wavenumber => "wavenumber",
        };
        for point in &ridge.points {
            text.push_str(&format!("{},{cut}", ridge.branch));
            for (_, of) in COLUMNS {
                text.push(',');
                let value = of(point);
                if value.is_finite() {
                    text.push_str(&value.to_string());
                }
            }
            text.push('\n');
        }
    }
    text
}

/// Hands ridges to `file`: `branch`, `at_frequency` (1 for cuts at a frequency, 0 for those at a wavenumber) and
/// the columns of [`ridges_csv`], one value a point; of each fit n `fit_n_wavenumber` and `fit_n_frequency`
/// (branches, wavenumbers).
///
/// # Errors
/// Those of `file`.
pub fn ridges_arrays(found: &Ridges, file: &dyn LabelledArrays) -> Result<()> {
    let to = Arrays(file);
    let (axes, sample) = (&found.analysis.axes, found.analysis.unit.as_deref());
    let units = Units::of(&axes.time, &axes.space, sample);
    let of_ridge = |name: &str, of: fn(&crate::ridges::Ridge) -> f64| {
        let ridges = found.ridges.iter();
        let values = ridges.flat_map(|ridge| std::iter::repeat_n(of(ridge), ridge.points.len()));
        to.line(name, "point", "", &values.collect::<Vec<f64>>())
    };
    of_ridge("branch", |ridge| ridge.branch as f64)?;
    of_ridge("at_frequency", |ridge| {
        f64::from(u8::from(ridge.cut == RidgeCut::Frequency))
    })?;
    let density = power_of(&found.analysis).over_both(axes);
    let density = unit::split(&density).1;
    for (name, of) in COLUMNS {
        let of_column = match name {
            "frequency" | "frequency_error" => &units.frequency,
            "wavenumber" | "wavenumber_error" => &units.wavenumber,
            "power" | "noise" => density,
            // Along k at some points, along f at others.
            "width" => "",
            _ => &units.velocity,
        };
        let values: Vec<f64> = found.points().map(of).collect();
        to.line(name, "point", of_column, &values)?;
    }
    for (n, fit) in found.fits.iter().enumerate() {
        let curve = &fit.curve;
        let axis = format!("fit_{n}_wavenumber");
        to.line(&axis, &axis, &units.wavenumber, &curve.wavenumber)?;
        let branches = format!("fit_{n}_branch");
        let axes = [
            (&branches[..], curve.branches.len()),
            (&axis, curve.wavenumber.len()),
        ];
        let name = format!("fit_{n}_frequency");
        to.of_axes(&name, &axes, &units.frequency, &curve.branches.concat())?;
    }
    Ok(())
}
