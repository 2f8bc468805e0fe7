//! `cascade bicoherence`: coupling of three frequencies, and on request the transfer between two sites.

use std::ops::Range;

use wavecascade::estimates::{
    Bicoherence, BicoherenceRequest, Transfer, TransferRequest, bicoherence, transfer,
};
use wavecascade::measure::{Frequency, Measure};
use wavecascade::sheet::{PlotRow, Sheet};

use super::*;

/// What `cascade bicoherence` takes.
#[derive(Debug, Args)]
pub struct BicoherenceArgs {
    /// Index of the site of the two frequencies that are added.
    #[arg(long, short, value_name = "SITE", default_value_t = BicoherenceRequest::default().site)]
    pub site: usize,

    /// Index of the site of their sum and difference [default: the same, where differences repeat sums].
    #[arg(long, value_name = "SITE")]
    pub output: Option<usize>,

    /// Sites whose own bicoherence is followed along x, the end excluded [default: all].
    #[arg(long, value_name = "FIRST:END", value_parser = parse::site_range)]
    pub along: Option<Range<usize>>,

    /// Of these every N-th; 0 for none.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub every: usize,

    #[command(flatten)]
    pub averages: SegmentArgs,
    #[command(flatten)]
    pub transfer: TransferArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

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

/// What was found.
struct Coupled {
    bicoherence: Bicoherence,
    transfer: Option<Transfer>,
}

impl Estimate for BicoherenceArgs {
    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let first = given.fields.first().copied();
        let of_transfer = self.of_transfer(first)?;
        let request = self.request(first.map_or(0, Field::n_sites));
        let bicoherence = bicoherence(given.fields, &request, observer)?;
        let transfer = of_transfer.map(|request| transfer(given.fields, &request, observer));
        Ok(Found::of(Coupled {
            bicoherence,
            transfer: transfer.transpose()?,
        }))
    }
}

impl BicoherenceArgs {
    /// The transfer that is requested beside it, of a field.
    fn of_transfer(&self, field: Option<&Field>) -> Result<Option<TransferRequest>, Error> {
        let units = field.map(AxisUnits::of).unwrap_or_default();
        let typed = &self.transfer;
        let highest = units.stated("highest", typed.highest)?;
        Ok(typed.transfer.map(|to| TransferRequest {
            from: self.site,
            to,
            lag: typed.lag,
            highest,
            averaging: self.averages.averaging(),
            gaps: self.averages.gaps.into(),
            alpha: self.averages.significance,
            resamplings: typed.resamplings,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        }))
    }

    fn request(&self, n_sites: usize) -> BicoherenceRequest {
        let along = self.along.clone().unwrap_or(0..n_sites);
        BicoherenceRequest {
            site: self.site,
            output: self.output,
            along: match self.every {
                0 => Vec::new(),
                every => along.step_by(every).collect(),
            },
            averaging: self.averages.averaging(),
            gaps: self.averages.gaps.into(),
            alpha: self.averages.significance,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        }
    }
}

impl Describe for Coupled {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = self.bicoherence.describe();
        if let Some(transfer) = &self.transfer {
            sheet.include("transfer", transfer.describe());
        }
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let mut rows = self.bicoherence.pictures();
        rows.extend(self.transfer.iter().flat_map(Transfer::pictures));
        rows
    }
}
