//! `cascade triads`: which wavenumbers feed which, where the law is quadratic.

use std::ops::Range;
use std::path::PathBuf;

use clap::Args;
use wavecascade::budget::{Motion, Triads as Found, TriadsRequest, chain_triads};
use wavecascade::field::is_run_file;
use wavecascade::observer::Observer;
use wavecascade::report::RunFile;
use wavecascade::{Error, Field};

use crate::estimates::{Computation, EstimateArgs, Typed};
use crate::further::input_options;
use crate::parse;
use crate::view_args::request_of;
use crate::words;

/// What `cascade triads` takes.
#[derive(Debug, Args)]
pub struct Triads {
    /// Run file of `cascade simulate`.
    #[arg(required = true, num_args = 1, value_name = "RUN")]
    pub run: Vec<PathBuf>,

    /// Samples over which transfers are integrated, the end excluded [default: all].
    #[arg(long, value_name = "FIRST:END", value_parser = parse::site_range)]
    pub window_samples: Option<Range<usize>>,
    /// Working memory, such as 500MB [default: half of the free memory].
    #[arg(long, value_name = "BYTES", value_parser = parse::bytes)]
    pub memory: Option<u64>,
    #[command(flatten)]
    pub estimate: EstimateArgs,
}

impl Triads {
    /// Of a run and its scene.
    pub fn of_run(&self, file: &RunFile, observer: &dyn Observer) -> Result<Found, Error> {
        let motion = Motion::of(&file.run)?;
        let base = request_of(&file.setup);
        let request = TriadsRequest {
            window: self.window_samples.clone(),
            units: base.units,
            threads: self.estimate.threads(),
            memory: self.memory,
        };
        chain_triads(&motion, base.pitch, &request, observer)
    }
}

impl Typed for Triads {
    type Found = Found;
    const COMMAND: &'static str = "triads";
    const EXTENSION: &'static str = "npz";

    fn fields(&self) -> &[PathBuf] {
        &self.run
    }

    fn shared(&self) -> &EstimateArgs {
        &self.estimate
    }

    fn memory(&self) -> Option<u64> {
        self.memory
    }

    fn computation(&self) -> Result<impl Computation<Found>, Error> {
        let path = &self.run[0];
        let is_run = path.is_file() && is_run_file(path)?;
        // What is no file is told where it is opened.
        if path.is_file() {
            self.check(&path.display().to_string(), is_run, words::as_text())?;
        }
        Ok(move |_: &[&Field], observer: &dyn Observer| {
            let found = self.of_run(&RunFile::read(path)?, observer);
            found.map_err(|error| error.of_file(path))
        })
    }
}

impl Triads {
    /// That it is a run, and that the words have no axes for it.
    ///
    /// # Errors
    /// [`Error::Unfit`].
    pub fn check(&self, name: &str, is_run: bool, words: Vec<String>) -> Result<(), Error> {
        let typed = input_options(words);
        let (expected, found) = match is_run {
            false => (
                "a run file of `cascade simulate`, whose law is known",
                "a file that is no run",
            ),
            true if !typed.is_empty() => (
                "no options of fields with a run file, which has its own axes",
                typed.trim(),
            ),
            true => return Ok(()),
        };
        Err(Error::Unfit {
            path: name.into(),
            expected: expected.into(),
            found: found.into(),
        })
    }
}
