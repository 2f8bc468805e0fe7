//! The one error type: data in named fields, and the sentence made from them in one place.
//!
//! [`Error`] names what was expected and what was found.

mod fault;
mod nearest;
mod scene;

use std::path::{Path, PathBuf};

pub(crate) use fault::{
    DAMAGED, OTHER_VARIABLE, SIMULATE, UNFINISHED, shape_of, some_of, uneven_advice,
};
pub use fault::{Fault, FormatError, InputFault};
pub use nearest::nearest_key;
pub(crate) use nearest::{listed, one_of_words};
pub use scene::{KeyPlace, SceneFault};
pub(crate) use wavecascade_system::memory::size;
use wavecascade_system::publish::final_path;

/// A result whose error is [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong in the library.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to read something.
    #[error("cannot {action} {}: {source}", path.display())]
    Read {
        path: PathBuf,
        action: &'static str,
        source: std::io::Error,
    },

    /// The operating system refused to write something.
    #[error("cannot {action} {}: {source}", path.display())]
    Write {
        path: PathBuf,
        action: &'static str,
        source: std::io::Error,
    },

    /// A file is not what its format promises.
    #[error("{}: {fault}", path.display())]
    Input {
        path: PathBuf,
        #[source]
        fault: InputFault,
    },

    /// A request for a scan that does not fit a file of it.
    #[error("{}: {fault}", path.display())]
    Scan {
        path: PathBuf,
        #[source]
        fault: Fault,
    },

    /// A file that was written to, or another put in its place, while it was in use: what was expected and found.
    #[error("{} was changed or replaced while it was read: {change}", path.display())]
    Changed { path: PathBuf, change: String },

    /// Samples that are neither finite nor declared as gaps.
    #[error(
        "{name}: expected finite samples, found {count} that are not (NaN or infinite), \
         the first at time row {}, site {}; {sites} of {n_sites} sites are affected",
        first.0, first.1
    )]
    NonFinite {
        name: String,
        count: u64,
        first: (usize, usize),
        sites: usize,
        n_sites: usize,
    },

    /// An option whose value does not fit the field or another option.
    #[error("{option}: expected {expected}, found {found}")]
    Request {
        option: &'static str,
        expected: String,
        found: String,
    },

    /// A file that does not fit the request.
    #[error("{}: expected {expected}, found {found}", path.display())]
    Unfit {
        path: PathBuf,
        expected: String,
        found: String,
    },

    /// The path of the result holds something that is not a result.
    #[error("{} {found}, so it is not replaced", path.display())]
    OutputInUse { path: PathBuf, found: String },

    /// An invalid scene: a key is missing, unknown, or has an impossible value.
    #[error("{fault}")]
    Scene { fault: Box<SceneFault> },

    /// A sweep that another process works on.
    #[error("{} is being worked on by another process", path.display())]
    Busy { path: PathBuf },

    /// A file of a sweep that no sweep has written so.
    #[error("{}, line {line}: {reason}", path.display())]
    Damaged {
        path: PathBuf,
        line: usize,
        reason: String,
    },

    /// A result that is already there.
    #[error("{} is already there and is not overwritten", path.display())]
    Exists { path: PathBuf },

    /// The work does not fit the memory it was allowed.
    #[error("{what} needs {} of memory, allowed are {}", size(*needed), size(*allowed))]
    Memory {
        what: &'static str,
        needed: u64,
        allowed: u64,
    },

    /// The system, or a limit that it sets, refused memory.
    #[error("{what} needs {} of memory, which the system refuses", size(*needed))]
    Refused { what: &'static str, needed: u64 },

    /// Work that could not be done: threads that did not start, a figure that could not be drawn, spectra whose energy
    /// is not that of the samples (Parseval's identity).
    #[error("{0}")]
    Failed(Fault),

    /// What was asked cannot be told: noise leaves nothing of it, an iteration found no solution, or samples are too
    /// small beside others for both in one precision.
    #[error("{0}")]
    Unresolved(Fault),

    /// The observer asked to stop.
    #[error("cancelled; nothing was written")]
    Cancelled,

    /// The observer asked a sweep, or a fit that keeps its searches, to stop.
    #[error("stopped with {known} of {members} known")]
    Paused { known: usize, members: usize },
}

impl From<InputFault> for Error {
    /// Of a file whose path is added later.
    fn from(fault: InputFault) -> Error {
        Error::input(Path::new(""))(fault)
    }
}

impl From<Fault> for Error {
    /// As that of an [`InputFault`].
    fn from(fault: Fault) -> Error {
        InputFault::Other(fault).into()
    }
}

impl From<FormatError> for Error {
    fn from(fault: FormatError) -> Error {
        match fault {
            FormatError::Memory {
                needed, allowed, ..
            } => Error::Memory {
                what: "what has to be decoded of the file",
                needed,
                allowed,
            },
            FormatError::Unsupported { what, way_out } => {
                Fault::expected("a part of the format that is read", what, way_out).into()
            }
            damaged => Fault::new(damaged.to_string(), DAMAGED).into(),
        }
    }
}

impl Error {
    /// Whether the request itself is at fault (exit code 2) rather than the run (exit code 1).
    pub fn is_usage(&self) -> bool {
        use Error::*;
        matches!(
            self,
            Request { .. }
                | Unfit { .. }
                | Scan { .. }
                | Scene { .. }
                | Exists { .. }
                | OutputInUse { .. }
                | Busy { .. }
                | Memory { .. }
        )
    }

    /// The error with `path` as the file at fault, if the error names that file otherwise: a field
    /// by its own name, or the keys `field`, `record` or `quantity` of a request.
    #[must_use]
    pub fn of_file(mut self, path: &Path) -> Error {
        if let Error::NonFinite { name, .. } = &mut self {
            *name = path.display().to_string();
        }
        let path = path.to_owned();
        match self {
            Error::Request {
                option: "field" | "record" | "quantity",
                expected,
                found,
            } => Error::Unfit {
                path,
                expected,
                found,
            },
            other => other,
        }
    }

    /// The error where sample 0 of the field is sample `before` of a record.
    #[must_use]
    pub(crate) fn later(mut self, before: usize) -> Error {
        if let Error::NonFinite { first, .. } = &mut self {
            first.0 += before;
        }
        self
    }

    /// An error of memory with what is in use beside it.
    #[must_use]
    pub fn beside(mut self, used: u64) -> Error {
        if let Error::Memory {
            needed, allowed, ..
        } = &mut self
        {
            *needed = needed.saturating_add(used);
            *allowed = allowed.saturating_add(used);
        }
        self
    }

    /// The error with the option that was typed, where the library calls it `known`.
    #[must_use]
    pub fn of_option(mut self, known: &str, typed: &'static str) -> Error {
        if let Error::Request { option, .. } = &mut self
            && *option == known
        {
            *option = typed;
        }
        self
    }

    /// [`Error::Request`] of an option.
    pub fn request(
        option: &'static str,
        expected: impl Into<String>,
        found: impl ToString,
    ) -> Error {
        Error::Request {
            option,
            expected: expected.into(),
            found: found.to_string(),
        }
    }

    /// [`Error::Request`] of an option that is not as expected.
    ///
    /// # Errors
    /// Where it is not so.
    pub fn require(
        is_so: bool,
        option: &'static str,
        expected: impl Into<String>,
        found: impl ToString,
    ) -> Result<()> {
        let error = || Error::request(option, expected, found);
        is_so.then_some(()).ok_or_else(error)
    }

    /// [`Error::Failed`], without an advice.
    pub fn failed(said: impl Into<String>) -> Error {
        Error::Failed(Fault::new(said, ""))
    }

    /// Of spectra whose energy is not that of the samples.
    pub(crate) fn parseval(spectra: &str, residual: f64, bound: f64) -> Error {
        let said = format!(
            "spectra {spectra}: expected the energy of the samples to a relative {bound:e} (Parseval's \
             identity), found it off by {residual:.3e}"
        );
        let advice = "repeat it with `--precision f64`; if it stays, check the largest and smallest samples of the field";
        Error::Failed(Fault::new(said, advice))
    }

    /// [`Error::Memory`] where more than what is allowed is needed.
    pub(crate) fn beyond_memory(what: &'static str, needed: u64, allowed: u64) -> Result<()> {
        let error = Error::Memory {
            what,
            needed,
            allowed,
        };
        (needed <= allowed).then_some(()).ok_or(error)
    }

    pub(crate) fn scene(fault: SceneFault) -> Error {
        Error::Scene {
            fault: Box::new(fault),
        }
    }

    /// The error with `path` as the file whose fault was found where that is not known.
    pub(crate) fn at(mut self, path: &Path) -> Error {
        if let Error::Input { path: known, .. } = &mut self
            && known.as_os_str().is_empty()
        {
            *known = path.into();
        }
        self
    }

    /// A fault of what the file at `path` holds.
    pub(crate) fn input<F: Into<InputFault>>(path: &Path) -> impl Fn(F) -> Error + Copy {
        move |fault| Error::Input {
            path: path.to_owned(),
            fault: fault.into(),
        }
    }

    /// For `map_err` on reading: adds the path and the action.
    pub(crate) fn read<'a>(
        action: &'static str,
        path: &'a Path,
    ) -> impl FnOnce(std::io::Error) -> Error + 'a {
        move |source| Error::Read {
            path: path.to_owned(),
            action,
            source,
        }
    }

    /// For `map_err` on writing: adds the path and the action. What is still being written is called
    /// by the name that it will have.
    pub(crate) fn write<'a>(
        action: &'static str,
        path: &'a Path,
    ) -> impl FnOnce(std::io::Error) -> Error + 'a {
        move |source| Error::Write {
            path: final_path(path),
            action,
            source,
        }
    }
}
