//! `cascade coherence`: all sites of a field against a reference.

use wavecascade::estimates::{CoherenceRequest, DividedRequest, coherence};

use super::*;

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

impl Estimate for Coherence {
    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let found = coherence(given.fields, &self.request(), observer)?;
        Ok(Found::of(found))
    }

    fn parts(&self) -> Option<&PartArgs> {
        Some(&self.parts)
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
