//! `cascade spectrum --along both`: `S(k, f)` with intervals.

use wavecascade::estimates::{SpaceTimeEstimate, spacetime};
use wavecascade::observer::Observer;
use wavecascade::{Error, Field};

use crate::estimates::spectrum::Spectrum;
use crate::estimates::{Computation, EstimateArgs, Typed};
use crate::failure::Failure;

/// What is typed of `cascade spectrum`, for spectra along both axes.
#[derive(Debug)]
pub struct SpaceTime(pub Spectrum);

impl Typed for SpaceTime {
    type Found = SpaceTimeEstimate;
    const COMMAND: &'static str = "spectrum";

    fn shared(&self) -> &EstimateArgs {
        &self.0.estimate
    }

    /// Parts have one axis, which is said.
    fn run(&self) -> Result<(), Failure> {
        let parts = &self.0.parts;
        match parts.part.is_some() || !parts.merge.is_empty() {
            true => self.0.run(),
            false => super::run(self),
        }
    }

    fn computation(&self) -> Result<impl Computation<SpaceTimeEstimate>, Error> {
        self.0.check()?;
        let request = self.0.of_both();
        Ok(move |fields: &[&Field], observer: &dyn Observer| spacetime(fields, &request, observer))
    }
}
