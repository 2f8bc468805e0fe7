//! `cascade triads`: which wavenumbers feed which, where the law is quadratic.

use std::ops::Range;

use wavecascade::budget::{Motion, TriadsRequest, chain_triads};

use crate::prelude::*;
use crate::view_args::request_of;

/// What `cascade triads` takes.
#[derive(Debug, Args)]
pub struct Triads {
    /// Run file of `cascade simulate`.
    pub run: PathBuf,

    /// Samples over which transfers are integrated, the end excluded [default: all].
    #[arg(long, value_name = "FIRST:END", value_parser = parse::site_range)]
    pub window_samples: Option<Range<usize>>,
    /// Working memory, such as 500MB [default: half of the free memory].
    #[arg(long, value_name = "BYTES", value_parser = parse::bytes)]
    pub memory: Option<u64>,
    #[command(flatten)]
    pub result: ResultArgs,
}

impl Describing for Triads {
    fn about(&self) -> About<'_> {
        About::of("triads", &self.result.how, [&self.run], "npz")
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let file = given.run(0, &self.run)?;
        let motion = Motion::of(&file.run)?;
        let base = request_of(&file.setup);
        let request = TriadsRequest {
            window: self.window_samples.clone(),
            units: base.units,
            threads: self.result.how.threads,
            memory: self.memory,
        };
        Ok(Found::of(chain_triads(
            &motion, base.pitch, &request, observer,
        )?))
    }
}
