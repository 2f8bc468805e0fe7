//! `cascade triads`: which wavenumbers feed which, where the law is quadratic.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use wavecascade::Error;
use wavecascade::budget::{Motion, TriadsRequest, chain_triads};
use wavecascade::field::is_run_file;
use wavecascade::observer::Observer;
use wavecascade::report::RunFile;

use crate::chain_args::How;
use crate::described::{Describing, Found, Given, Publishing, ResultArgs};
use crate::failure::Failure;
use crate::parse;
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

impl Triads {
    fn read(&self) -> Result<RunFile, Error> {
        if self.run.is_file() && !is_run_file(&self.run)? {
            return Err(not_a_run(&self.run));
        }
        RunFile::read(&self.run)
    }
}

/// A field, whose law is not known.
pub fn not_a_run(name: &Path) -> Error {
    Error::Unfit {
        path: name.to_owned(),
        expected: "a run file of `cascade simulate`, whose law is known".into(),
        found: "a file that is no run".into(),
    }
}

impl Describing for Triads {
    fn name(&self) -> &'static str {
        "triads"
    }

    fn how(&self) -> &How {
        &self.result.how
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let file = match given.run {
            Some(run) => run,
            None => Arc::new(self.read()?),
        };
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

impl Publishing for Triads {
    fn result(&self) -> &ResultArgs {
        &self.result
    }

    fn files(&self) -> Result<(Vec<PathBuf>, &'static str), Failure> {
        Ok((vec![self.run.clone()], "npz"))
    }
}
