//! `cascade triads`: which wavenumbers feed which, where the law is quadratic.

use std::ops::Range;
use std::path::PathBuf;

use clap::Args;
use wavecascade::Error;
use wavecascade::budget::{Motion, Triads as Found, TriadsRequest, chain_triads};
use wavecascade::field::{file_hash, is_run_file};
use wavecascade::observer::Observer;
use wavecascade::report::RunFile;

use crate::described::{self, ResultArgs};
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
    /// The run of a file.
    ///
    /// # Errors
    /// [`Error::Unfit`] for a file that is none.
    pub fn read(&self) -> Result<RunFile, Error> {
        if self.run.is_file() && !is_run_file(&self.run)? {
            return Err(not_a_run(&self.run));
        }
        RunFile::read(&self.run)
    }

    /// Of a run and its scene.
    pub fn of_run(&self, file: &RunFile, observer: &dyn Observer) -> Result<Found, Error> {
        let motion = Motion::of(&file.run)?;
        let base = request_of(&file.setup);
        let request = TriadsRequest {
            window: self.window_samples.clone(),
            units: base.units,
            threads: self.result.how.threads.map(usize::from),
            memory: self.memory,
        };
        let found = chain_triads(&motion, base.pitch, &request, observer);
        found.map_err(|error| error.of_file(&self.run))
    }
}

/// A field, whose law is not known.
pub fn not_a_run(name: &std::path::Path) -> Error {
    Error::Unfit {
        path: name.to_owned(),
        expected: "a run file of `cascade simulate`, whose law is known".into(),
        found: "a file that is no run".into(),
    }
}

/// Runs the command.
pub fn run(typed: &Triads) -> Result<(), Failure> {
    let file = (&*typed.run, "npz");
    typed.result.make(file, "triads", |progress| {
        Ok(described::Found {
            found: typed.of_run(&typed.read()?, progress)?,
            hash: Some(file_hash(&typed.run)?),
            beside: None,
        })
    })
}
