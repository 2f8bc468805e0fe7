//! `cascade bicoherence`: coupling of three frequencies, and on request the transfer between two sites.

use clap::Args;
use std::ops::Range;
use wavecascade::estimates::{Bicoherence, BicoherenceRequest, Transfer, bicoherence, transfer};
use wavecascade::observer::Observer;
use wavecascade::sheet::{Describe, PlotRow, Sheet};
use wavecascade::{Error, Field};

use crate::described::{self, About, Describing, Given};
use crate::estimates::EstimateArgs;
use crate::estimates::averages::SegmentArgs;
use crate::estimates::transfer::TransferArgs;
use crate::parse;

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

/// What was found.
struct Found {
    bicoherence: Bicoherence,
    transfer: Option<Transfer>,
}

impl Describing for BicoherenceArgs {
    fn about(&self) -> About<'_> {
        self.estimate.about("bicoherence")
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<described::Found, Error> {
        let first = given.fields.first().copied();
        let of_transfer = self.transfer.request(self, first)?;
        let request = self.request(first.map_or(0, Field::n_sites));
        let bicoherence = bicoherence(given.fields, &request, observer)?;
        let transfer = of_transfer.map(|request| transfer(given.fields, &request, observer));
        Ok(described::Found::of(Found {
            bicoherence,
            transfer: transfer.transpose()?,
        }))
    }
}

impl BicoherenceArgs {
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

impl Describe for Found {
    fn describe(&self) -> Sheet<'_> {
        let mut sheet = self.bicoherence.describe();
        if let Some(transfer) = &self.transfer {
            sheet.include("transfer", transfer.describe());
        }
        sheet
    }

    fn pictures(&self) -> Vec<PlotRow> {
        let transfer = self.transfer.iter().flat_map(Transfer::pictures);
        self.bicoherence
            .pictures()
            .into_iter()
            .chain(transfer)
            .collect()
    }
}
