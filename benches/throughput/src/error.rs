//! What can go wrong while speed is measured.

use std::path::{Path, PathBuf};

/// A result whose error is [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// Why a case was not measured, or a baseline not read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A shape that cannot be transformed, or does not fit the memory.
    #[error("expected {expected}, found {found}")]
    Shape { expected: String, found: String },

    /// The processor lacks these instructions.
    #[error("expected instructions that this processor has, found {0}")]
    InstructionSet(String),

    /// The system gave no memory for the arrays.
    #[error("cannot reserve memory for the arrays: {0}")]
    Memory(#[source] std::io::Error),

    /// Worker threads could not be started.
    #[error("cannot start {threads} threads: {reason}")]
    Threads { threads: usize, reason: String },

    /// A file could not be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    File {
        action: &'static str,
        path: PathBuf,
        source: std::io::Error,
    },

    /// A file that is no baseline, or an incomplete one.
    #[error("{}: expected a baseline of throughput, {reason}", path.display())]
    Baseline { path: PathBuf, reason: String },
}

impl Error {
    /// For `map_err`: adds the path and the action.
    pub(crate) fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Error {
        move |source| Error::File {
            action,
            path: path.to_owned(),
            source,
        }
    }
}
