//! The linear and quadratic transfer between two sites, beside a bicoherence.

use clap::Args;
use wavecascade::estimates::TransferRequest;
use wavecascade::measure::{Frequency, Measure};
use wavecascade::{Error, Field};

use crate::estimates::bicoherence::BicoherenceArgs;
use crate::parse;
use crate::show_args::AxisUnits;

/// Which transfer is fitted.
#[derive(Debug, Args)]
#[command(next_help_heading = "Transfer")]
pub struct TransferArgs {
    /// Fit the linear and the quadratic transfer from `--site` to this site as well.
    #[arg(long, value_name = "SITE")]
    pub transfer: Option<usize>,

    /// Take the record of that site so many samples later: the time that waves need from one to the other.
    #[arg(
        long,
        value_name = "SAMPLES",
        default_value_t = 0,
        requires = "transfer"
    )]
    pub lag: usize,

    /// Frequency up to which there are terms, in cycles per unit of time, or with its unit (2kHz) [default: all below
    /// Nyquist].
    #[arg(long, value_name = "FREQUENCY", value_parser = parse::step::<Frequency>, requires = "transfer")]
    pub highest: Option<Measure<Frequency>>,

    /// How often realisations are drawn anew for the errors.
    #[arg(long, value_name = "N", default_value_t = TransferRequest::default().resamplings, requires = "transfer")]
    pub resamplings: usize,
}

impl TransferArgs {
    /// What is requested beside a bicoherence, of a field.
    ///
    /// # Errors
    /// For a frequency in a unit that the field does not have.
    pub fn request(
        &self,
        typed: &BicoherenceArgs,
        field: Option<&Field>,
    ) -> Result<Option<TransferRequest>, Error> {
        let units = field.map(AxisUnits::of).unwrap_or_default();
        let highest = units.stated("highest", self.highest)?;
        Ok(self.transfer.map(|to| TransferRequest {
            from: typed.site,
            to,
            lag: self.lag,
            highest,
            averaging: typed.averages.averaging(),
            gaps: typed.averages.gaps.into(),
            alpha: typed.averages.significance,
            resamplings: self.resamplings,
            threads: typed.estimate.threads(),
            memory: typed.estimate.memory,
        }))
    }
}
