//! What can be wrong with a file.

use std::fmt::Display;

/// A result whose error is [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// Why a file, or a variable of it, cannot be read. The caller names the file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The bytes are not what the format promises.
    #[error("{place}: expected {expected}, found {found}")]
    Damaged {
        /// Where, in words: `byte 240`, `line 3`, `variable /v`.
        place: String,
        /// What the format promises.
        expected: String,
        /// What is there.
        found: String,
    },

    /// A part of the format that is not read.
    #[error("found {what}, which is not read; {way_out}")]
    Unsupported {
        /// What was found.
        what: String,
        /// What the user can do, in one clause.
        way_out: String,
    },

    /// Decoding would need more memory than was allowed.
    #[error("{what} needs {needed} bytes of memory, allowed are {allowed}")]
    Memory {
        /// What is decoded.
        what: String,
        /// Bytes that it needs.
        needed: u64,
        /// Bytes that are allowed.
        allowed: u64,
    },
}

impl Error {
    /// [`Error::Damaged`].
    pub fn damaged(place: impl Display, expected: impl Display, found: impl Display) -> Error {
        Error::Damaged {
            place: place.to_string(),
            expected: expected.to_string(),
            found: found.to_string(),
        }
    }

    /// [`Error::Unsupported`].
    pub fn unsupported(what: impl Display, way_out: impl Display) -> Error {
        Error::Unsupported {
            what: what.to_string(),
            way_out: way_out.to_string(),
        }
    }

    /// The same of a part of the file.
    pub(crate) fn within(self, part: &str) -> Error {
        match self {
            Error::Damaged {
                place,
                expected,
                found,
            } => Error::damaged(format!("{part}, {place}"), expected, found),
            Error::Unsupported { what, way_out } => {
                Error::unsupported(format!("{what} in {part}"), way_out)
            }
            other => other,
        }
    }
}
