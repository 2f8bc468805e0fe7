//! Spectral proper orthogonal decompositions as files: a summary, and arrays.

use std::path::Path;

use num_complex::Complex;
use serde::Serialize;

use super::{Archive, Provenance};
use crate::arrays::Precision;
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

/// Writes modes to the new file `path` (`.npz`): `frequency` (nf), `position` (n); `eigenvalues` (nf, modes),
/// `total` (nf), `interval` (nf, 2), the factors of the ends, NaN where none can be stated; `mode_frequency` (c),
/// `mode_real`, `mode_imag` (c, kept modes, n).
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_modes(path: &Path, found: &Modes) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    let line = |name: &str, values: &[f64]| archive.append(name, &[values.len()], values);
    line("frequency", &found.frequency)?;
    line("position", &found.positions())?;
    let (bins, rank) = found.eigenvalues.dim();
    let values: Vec<f64> = found.eigenvalues.iter().copied().collect();
    archive.append("eigenvalues", &[bins, rank], &values)?;
    line("total", &found.total)?;
    let ends = |bin| found.interval(bin).unwrap_or([f64::NAN; 2]);
    let intervals: Vec<f64> = (0..bins).flat_map(ends).collect();
    archive.append("interval", &[bins, 2], &intervals)?;
    let chosen: Vec<f64> = found.chosen.iter().map(|shapes| shapes.frequency).collect();
    line("mode_frequency", &chosen)?;
    let kept = found
        .chosen
        .first()
        .map_or(0, |shapes| shapes.modes.nrows());
    let shape = [chosen.len(), kept, found.n_sites];
    let parts = |of: fn(&Complex<f64>) -> f64| -> Vec<f64> {
        let shapes = found.chosen.iter().flat_map(|shapes| &shapes.modes);
        shapes.map(of).collect()
    };
    archive.append("mode_real", &shape, &parts(|z| z.re))?;
    archive.append("mode_imag", &shape, &parts(|z| z.im))?;
    archive.finish()
}
