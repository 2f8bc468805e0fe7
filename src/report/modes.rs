//! Spectral proper orthogonal decompositions as files: a summary, and arrays.

use num_complex::Complex;
use serde::Serialize;

use super::estimate_arrays::{Arrays, Units};
use super::{LabelledArrays, Provenance};
use crate::error::Result;
use crate::estimates::{Independence, ModeShapes, ModeWave, Modes};

/// The schema of the summary of modes.
pub const MODES_SCHEMA: &str = "cascade.modes/1";

/// `summary.json` of modes; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct ModesSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    time_unit: String,
    space_unit: String,
    segment: usize,
    overlap: usize,
    independence: Independence,
    alpha: f64,
    /// What an eigenvalue is multiplied by for the ends of its interval, away from 0 and the Nyquist frequency.
    interval: Option<[f64; 2]>,
    /// Share of the power of all frequencies that first modes hold.
    leading_share: f64,
    chosen: Vec<ChosenModes<'a>>,
}

/// The modes of one frequency.
#[derive(Debug, Serialize)]
struct ChosenModes<'a> {
    frequency: f64,
    bin: usize,
    eigenvalues: Vec<f64>,
    total: f64,
    waves: &'a [Option<ModeWave>],
}

impl<'a> ModesSummary<'a> {
    pub fn new(found: &'a Modes, provenance: &'a Provenance) -> Self {
        let (time_unit, space_unit) = found.units();
        let of = |shapes: &'a ModeShapes| ChosenModes {
            frequency: shapes.frequency,
            bin: shapes.bin,
            eigenvalues: (0..shapes.modes.nrows())
                .map(|n| found.eigenvalues[[shapes.bin, n]])
                .collect(),
            total: found.total[shapes.bin],
            waves: &shapes.waves,
        };
        ModesSummary {
            schema: MODES_SCHEMA,
            provenance,
            time_unit,
            space_unit,
            segment: found.segment[0],
            overlap: found.segment[1],
            independence: found.independence,
            alpha: found.alpha,
            interval: found.interval(1),
            leading_share: found.leading_share_of_all(),
            chosen: found.chosen.iter().map(of).collect(),
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Hands modes to `file`: `frequency` (nf), `position` (n); `eigenvalues` (nf, modes), `total` (nf), `interval`
/// (nf, 2), the factors of the ends, NaN where none can be stated; `mode_frequency` (c), `mode_real`,
/// `mode_imag` (c, kept modes, n).
///
/// # Errors
/// Those of `file`.
pub fn modes_arrays(found: &Modes, file: &dyn LabelledArrays) -> Result<()> {
    let to = Arrays(file);
    let units = Units::of(&found.time, &found.space, found.unit.as_deref());
    to.line("frequency", "frequency", &units.frequency, &found.frequency)?;
    to.line("position", "position", &units.space, &found.positions())?;
    let power = units.density(&units.frequency, &units.space);
    let axes = ["frequency", "mode"];
    to.plane("eigenvalues", axes, &power, &found.eigenvalues)?;
    to.line("total", "frequency", &power, &found.total)?;
    let bins = found.eigenvalues.nrows();
    let ends = |bin| found.interval(bin).unwrap_or([f64::NAN; 2]);
    let intervals: Vec<f64> = (0..bins).flat_map(ends).collect();
    to.of_axes(
        "interval",
        &[("frequency", bins), ("end", 2)],
        "",
        &intervals,
    )?;
    let chosen: Vec<f64> = found.chosen.iter().map(|shapes| shapes.frequency).collect();
    let axis = "mode_frequency";
    to.line(axis, axis, &units.frequency, &chosen)?;
    let kept = found
        .chosen
        .first()
        .map_or(0, |shapes| shapes.modes.nrows());
    let axes = [
        (axis, chosen.len()),
        ("kept_mode", kept),
        ("position", found.n_sites),
    ];
    let parts = |name: &str, of: fn(&Complex<f64>) -> f64| {
        let shapes = found.chosen.iter().flat_map(|shapes| &shapes.modes);
        let values: Vec<f64> = shapes.map(of).collect();
        // The integral of |mode|^2 over x is 1.
        let unit = match &units.space[..] {
            "" => String::new(),
            space => format!("1/√{space}"),
        };
        to.of_axes(name, &axes, &unit, &values)
    };
    parts("mode_real", |z| z.re)?;
    parts("mode_imag", |z| z.im)
}
