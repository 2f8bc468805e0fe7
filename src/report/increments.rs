//! Structure functions as files: a summary, and arrays.

use serde::Serialize;

use super::estimate_arrays::{Arrays, Units};
use super::{LabelledArrays, Provenance};
use crate::error::Result;
use crate::estimates::{
    AxisIncrements, FieldAxis, Increments, IntervalBasis, ScaleMoments, ScalingExponents,
};

/// The schema of the summary of structure functions.
pub const INCREMENTS_SCHEMA: &str = "cascade.increments/1";

/// `summary.json` of structure functions; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct IncrementsSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    time_unit: String,
    space_unit: String,
    shots: usize,
    steadiness: f64,
    basis: IntervalBasis,
    alpha: f64,
    axes: Vec<AxisSummary<'a>>,
}

/// One axis.
#[derive(Debug, Serialize)]
struct AxisSummary<'a> {
    axis: FieldAxis,
    scale: Vec<f64>,
    pairs: Vec<u64>,
    flatness: Vec<f64>,
    flatness_half: Vec<f64>,
    third: Vec<f64>,
    third_half: Vec<f64>,
    exponents: Option<&'a ScalingExponents>,
}

impl<'a> IncrementsSummary<'a> {
    pub fn new(found: &'a Increments, provenance: &'a Provenance) -> Self {
        let (time_unit, space_unit) = found.units();
        let of = |axis: &'a AxisIncrements| {
            let all = |of: fn(&ScaleMoments) -> f64| axis.scales.iter().map(of).collect();
            AxisSummary {
                axis: axis.axis,
                scale: all(|m| m.scale),
                pairs: axis.scales.iter().map(|m| m.pairs).collect(),
                flatness: all(|m| m.flatness),
                flatness_half: all(ScaleMoments::flatness_half),
                third: all(|m| m.third),
                third_half: all(ScaleMoments::third_half),
                exponents: axis.exponents.as_ref(),
            }
        };
        IncrementsSummary {
            schema: INCREMENTS_SCHEMA,
            provenance,
            time_unit,
            space_unit,
            shots: found.shots,
            steadiness: found.steadiness,
            basis: found.basis,
            alpha: found.alpha,
            axes: found.axes.iter().map(of).collect(),
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Hands structure functions to `file`. For each axis, `space_` and `time_`: `scale`, `pairs` (n); `structure`,
/// `structure_half` (n, 6), orders 1 to 6; `third`, `flatness`, `skewness` (n) with their `_half`, half of the
/// interval, NaN where none can be stated; `histogram_scale` (h), `histogram_edges` (cells + 1),
/// `histogram_density` (h, cells).
///
/// # Errors
/// Those of `file`.
pub fn increments_arrays(found: &Increments, file: &dyn LabelledArrays) -> Result<()> {
    let units = Units::of(&found.time, &found.space, found.unit.as_deref());
    for axis in &found.axes {
        axis_arrays(axis, &units, &Arrays(file))?;
    }
    Ok(())
}

fn axis_arrays(axis: &AxisIncrements, units: &Units, to: &Arrays) -> Result<()> {
    let (prefix, length) = match axis.axis {
        FieldAxis::Space => ("space", &units.space),
        FieldAxis::Time => ("time", &units.time),
    };
    let n = axis.scales.len();
    let named = |name: &str| format!("{prefix}_{name}");
    let scale = named("scale");
    let line = |name: &str, unit: &str, of: fn(&ScaleMoments) -> f64| {
        let values: Vec<f64> = axis.scales.iter().map(of).collect();
        to.line(&named(name), &scale, unit, &values)
    };
    line("scale", length, |m| m.scale)?;
    line("pairs", "", |m| m.pairs as f64)?;
    let structure: Vec<f64> = axis.scales.iter().flat_map(|m| m.structure).collect();
    let orders = structure.len() / n.max(1);
    let axes = [(&scale[..], n), ("order", orders)];
    to.of_axes(&named("structure"), &axes, "", &structure)?;
    let half = axis.scales.iter().flat_map(|m| m.half[..orders].to_vec());
    let half: Vec<f64> = half.collect();
    to.of_axes(&named("structure_half"), &axes, "", &half)?;
    let cubed = units.cubed();
    line("third", &cubed, |m| m.third)?;
    line("third_half", &cubed, ScaleMoments::third_half)?;
    line("flatness", "", |m| m.flatness)?;
    line("flatness_half", "", ScaleMoments::flatness_half)?;
    line("skewness", "", |m| m.skewness)?;
    line("skewness_half", "", ScaleMoments::skewness_half)?;
    let scales = axis.histograms.iter().map(|h| axis.scales[h.index].scale);
    let scales: Vec<f64> = scales.collect();
    let of_histogram = named("histogram_scale");
    to.line(&of_histogram, &of_histogram, length, &scales)?;
    let Some(first) = axis.histograms.first() else {
        return Ok(());
    };
    let edges = named("histogram_edges");
    to.line(&edges, &edges, "", &first.edges)?;
    let cells = named("histogram_cell");
    let axes = [
        (&of_histogram[..], scales.len()),
        (&cells, first.density.len()),
    ];
    let densities = axis.histograms.iter().flat_map(|h| &h.density);
    let densities: Vec<f64> = densities.copied().collect();
    to.of_axes(&named("histogram_density"), &axes, "", &densities)
}
