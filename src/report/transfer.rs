//! A transfer between two sites as files: a summary, and arrays.

use serde::Serialize;

use super::LabelledArrays;
use super::estimate_arrays::{Arrays, Units};
use crate::error::Result;
use crate::estimates::{Independence, OutputTransfer, PairTransfer, Transfer, TransferShares};

/// A transfer in the `summary.json` of a bicoherence; undefined numbers are `null`.
#[derive(Debug, Serialize)]
pub struct TransferSummary<'a> {
    from: usize,
    from_position: f64,
    to: usize,
    to_position: f64,
    lag: usize,
    segment: usize,
    overlap: usize,
    independence: Independence,
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
    pub fn new(found: &'a Transfer) -> Self {
        TransferSummary {
            from: found.from,
            from_position: found.space.at(found.from),
            to: found.to,
            to_position: found.space.at(found.to),
            lag: found.lag,
            segment: found.segment[0],
            overlap: found.segment[1],
            independence: found.independence,
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
}

/// Name, unit and values of an array.
type Column<'a, T> = (&'a str, &'a str, fn(&T) -> f64);

/// Hands a transfer to `file`, with `transfer_` before every name: of each output frequency (nf) `frequency`, `input`, `output`, `magnitude`,
/// `magnitude_error`, `phase`, `linear`, `linear_error`, `gain`, `gain_error`, `residual`, `flux`, `flux_error`,
/// `above`, `above_error`, `held_out_linear`, `held_out_quadratic`; of each pair (np) `pair_first`,
/// `pair_second`, `pair_third`, `pair_re`, `pair_im`, `pair_gain`, `pair_gain_error`.
///
/// # Errors
/// Those of `file`.
pub fn transfer_arrays(found: &Transfer, file: &dyn LabelledArrays) -> Result<()> {
    let to = Arrays(file);
    let units = Units::of(&found.time, &found.space, found.unit.as_deref());
    let cycles = &units.frequency[..];
    let density = &units.density(cycles, "")[..];
    let passed = &units.density("", "")[..];
    let of_outputs: [Column<OutputTransfer>; 17] = [
        ("frequency", cycles, |o| o.frequency),
        ("input", density, |o| o.input),
        ("output", density, |o| o.output),
        ("magnitude", "", |o| o.magnitude),
        ("magnitude_error", "", |o| o.magnitude_error),
        ("phase", "rad", |o| o.phase),
        ("linear", density, |o| o.linear),
        ("linear_error", density, |o| o.linear_error),
        ("gain", density, |o| o.gain),
        ("gain_error", density, |o| o.gain_error),
        ("residual", density, |o| o.residual),
        ("flux", passed, |o| o.flux),
        ("flux_error", passed, |o| o.flux_error),
        ("above", passed, |o| o.above),
        ("above_error", passed, |o| o.above_error),
        ("held_out_linear", "", |o| o.held_out_linear),
        ("held_out_quadratic", "", |o| o.held_out_quadratic),
    ];
    for (name, unit, of) in of_outputs {
        let values: Vec<f64> = found.outputs.iter().map(of).collect();
        let name = format!("transfer_{name}");
        to.line(&name, "transfer_frequency", unit, &values)?;
    }
    let kernel = units.over_sample();
    let of_pairs: [Column<PairTransfer>; 7] = [
        ("pair_first", cycles, |p| p.first),
        ("pair_second", cycles, |p| p.second),
        ("pair_third", cycles, |p| p.third),
        ("pair_re", &kernel, |p| p.re),
        ("pair_im", &kernel, |p| p.im),
        ("pair_gain", density, |p| p.gain),
        ("pair_gain_error", density, |p| p.gain_error),
    ];
    for (name, unit, of) in of_pairs {
        let values: Vec<f64> = found.pairs.iter().map(of).collect();
        let name = format!("transfer_{name}");
        to.line(&name, "transfer_pair", unit, &values)?;
    }
    Ok(())
}
