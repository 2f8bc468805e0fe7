//! `cascade coherence`: all sites of a field against a reference.

use clap::Args;
use wavecascade::estimates::{
    Coherence as Found, CoherenceRequest, Combined, DividedRequest, coherence,
};
use wavecascade::observer::Observer;
use wavecascade::{Error, Field};

use crate::estimates::averages::AverageArgs;
use crate::estimates::parts::{self, InParts, PartArgs};
use crate::estimates::{Computation, EstimateArgs, Typed};
use crate::failure::Failure;

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

impl Typed for Coherence {
    type Found = Found;
    const COMMAND: &'static str = "coherence";

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    /// Or a part of it.
    fn run(&self) -> Result<(), Failure> {
        parts::run(self, |found| match found {
            Combined::Coherence(found) => Some(*found),
            _ => None,
        })
    }

    fn computation(&self) -> Result<impl Computation<Found>, Error> {
        let request = self.request();
        Ok(move |fields: &[&Field], observer: &dyn Observer| coherence(fields, &request, observer))
    }
}

impl InParts for Coherence {
    fn parts(&self) -> &PartArgs {
        &self.parts
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
