//! `cascade spectrum --along both`: `S(k, f)` with intervals.

use std::path::PathBuf;

use wavecascade::estimates::{SpaceTimeEstimate, spacetime};
use wavecascade::observer::Observer;
use wavecascade::{Error, Field};

use crate::estimate::{Computation, EstimateArgs, Typed};
use crate::spectrum::Spectrum;

/// What is typed of `cascade spectrum`, for spectra along both axes.
#[derive(Debug)]
pub struct SpaceTime(pub Spectrum);

impl Typed for SpaceTime {
    type Found = SpaceTimeEstimate;
    const COMMAND: &'static str = "spectrum";

    fn fields(&self) -> &[PathBuf] {
        &self.0.fields
    }

    fn shared(&self) -> &EstimateArgs {
        &self.0.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.0.averages.memory
    }

    fn computation(&self) -> Result<impl Computation<SpaceTimeEstimate>, Error> {
        self.0.check()?;
        let request = self.0.of_both();
        Ok(move |fields: &[&Field], observer: &dyn Observer| spacetime(fields, &request, observer))
    }
}
