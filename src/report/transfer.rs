//! A transfer between two sites as files: a summary, and arrays.

use std::path::Path;

use serde::Serialize;

use super::{Archive, Provenance};
use crate::arrays::Precision;
use crate::error::Result;
use crate::estimates::{Independence, OutputTransfer, PairTransfer, Transfer, TransferShares};

/// The schema of the summary of a transfer.
pub const TRANSFER_SCHEMA: &str = "cascade.transfer/1";

/// `summary.json` of a transfer; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct TransferSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    time_unit: String,
    space_unit: String,
    from: usize,
    from_position: f64,
    to: usize,
    to_position: f64,
    lag: usize,
    segment: usize,
    overlap: usize,
    independence: Independence,
    alpha: f64,
    /// The most unknowns of a frequency.
    unknowns: usize,
    blocks: usize,
    resamplings: usize,
    /// Mean square of the input in all frequencies of the model.
    input: f64,
    shares: TransferShares,
    /// Whether quadratic terms explain realisations that were not fitted.
    holds: bool,
    /// The frequency that most power passes, if it is more than chance.
    passage: Option<&'a OutputTransfer>,
    outputs: &'a [OutputTransfer],
}

impl<'a> TransferSummary<'a> {
    pub fn new(found: &'a Transfer, provenance: &'a Provenance) -> Self {
        let (time_unit, space_unit) = found.units();
        TransferSummary {
            schema: TRANSFER_SCHEMA,
            provenance,
            time_unit,
            space_unit,
            from: found.from,
            from_position: found.space.at(found.from),
            to: found.to,
            to_position: found.space.at(found.to),
            lag: found.lag,
            segment: found.segment[0],
            overlap: found.segment[1],
            independence: found.independence,
            alpha: found.alpha,
            unknowns: found.unknowns,
            blocks: found.blocks,
            resamplings: found.resamplings,
            input: found.input(),
            shares: found.shares,
            holds: found.holds(),
            passage: found.passage(),
            outputs: &found.outputs,
        }
    }

    /// # Errors
    /// None for results of this library.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self)
    }
}

/// Writes a transfer to the new file `path` (`.npz`): of each output frequency (nf) `frequency`, `input`, `output`,
/// `magnitude`, `magnitude_error`, `phase`, `linear`, `linear_error`, `gain`, `gain_error`, `residual`, `flux`,
/// `flux_error`, `above`, `above_error`, `held_out_linear`, `held_out_quadratic`; of each pair (np) `pair_first`, `pair_second`,
/// `pair_third`, `pair_re`, `pair_im`, `pair_gain`, `pair_gain_error`.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_transfer(path: &Path, found: &Transfer) -> Result<()> {
    let archive = Archive::create(path, Precision::F64)?;
    let line = |name: &str, of: fn(&OutputTransfer) -> f64| {
        let values: Vec<f64> = found.outputs.iter().map(of).collect();
        archive.append(name, &[values.len()], &values)
    };
    line("frequency", |o| o.frequency)?;
    line("input", |o| o.input)?;
    line("output", |o| o.output)?;
    line("magnitude", |o| o.magnitude)?;
    line("magnitude_error", |o| o.magnitude_error)?;
    line("phase", |o| o.phase)?;
    line("linear", |o| o.linear)?;
    line("linear_error", |o| o.linear_error)?;
    line("gain", |o| o.gain)?;
    line("gain_error", |o| o.gain_error)?;
    line("residual", |o| o.residual)?;
    line("flux", |o| o.flux)?;
    line("flux_error", |o| o.flux_error)?;
    line("above", |o| o.above)?;
    line("above_error", |o| o.above_error)?;
    line("held_out_linear", |o| o.held_out_linear)?;
    line("held_out_quadratic", |o| o.held_out_quadratic)?;
    let line = |name: &str, of: fn(&PairTransfer) -> f64| {
        let values: Vec<f64> = found.pairs.iter().map(of).collect();
        archive.append(name, &[values.len()], &values)
    };
    line("pair_first", |p| p.first)?;
    line("pair_second", |p| p.second)?;
    line("pair_third", |p| p.third)?;
    line("pair_re", |p| p.re)?;
    line("pair_im", |p| p.im)?;
    line("pair_gain", |p| p.gain)?;
    line("pair_gain_error", |p| p.gain_error)?;
    archive.finish()
}
