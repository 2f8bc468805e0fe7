//! `cascade coherence`: all sites of a field against a reference.

use clap::Args;
use wavecascade::Error;
use wavecascade::estimates::{CoherenceRequest, DividedRequest, coherence};
use wavecascade::observer::Observer;

use crate::described::{About, Describing, Found, Given};
use crate::estimates::EstimateArgs;
use crate::estimates::averages::AverageArgs;
use crate::estimates::parts::{InParts, PartArgs};

/// What `cascade coherence` takes.
#[derive(Debug, Args)]
#[command(mut_arg("fields", |arg| arg.required(false).required_unless_present("merge")))]
pub struct Coherence {
    /// Index of the site that all others are compared with.
    #[arg(
        long,
        conflicts_with = "merge",
        short,
        value_name = "SITE",
        default_value_t = 0
    )]
    pub reference: usize,

    #[command(flatten)]
    pub averages: AverageArgs,
    #[command(flatten)]
    pub parts: PartArgs,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

impl Describing for Coherence {
    fn about(&self) -> About<'_> {
        self.estimate.about("coherence")
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        Ok(Found::of(coherence(
            given.fields,
            &self.request(),
            observer,
        )?))
    }
}

impl InParts for Coherence {
    fn parts(&self) -> (&PartArgs, &EstimateArgs) {
        (&self.parts, &self.estimate)
    }

    fn divided(&self) -> Result<DividedRequest, Error> {
        Ok(self.request().into())
    }
}

impl Coherence {
    fn request(&self) -> CoherenceRequest {
        CoherenceRequest {
            reference: self.reference,
            averaging: self.averages.averaging(),
            gaps: self.averages.segments.gaps.into(),
            alpha: self.averages.segments.significance,
            threads: self.estimate.threads(),
            memory: self.estimate.memory,
        }
    }
}
