//! How a file changed while it was in use.

use std::fmt;
use std::time::SystemTime;

/// How a file changed while it was in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileChange {
    /// Another file is in its place.
    Replaced,
    /// Bytes.
    Length { expected: u64, found: u64 },
    /// Times of modification, if the file system records them.
    Modified {
        expected: Option<SystemTime>,
        found: Option<SystemTime>,
    },
    /// Its inode changed, but neither its length nor its time of modification.
    TimeKept,
}

impl fmt::Display for FileChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            FileChange::Replaced => {
                f.write_str("expected the file that was opened, found another in its place")
            }
            FileChange::Length { expected, found } => {
                write!(f, "expected {expected} bytes, found {found}")
            }
            FileChange::TimeKept => f.write_str(
                "expected no change since it was opened, found one that kept the time of modification",
            ),
            FileChange::Modified { expected, found } => {
                f.write_str("expected no modification since it was opened, found one")?;
                let times = expected.zip(found);
                match times.map(|(expected, found)| found.duration_since(expected)) {
                    None => Ok(()),
                    Some(Ok(later)) => write!(f, " {later:.3?} after the last before"),
                    Some(Err(earlier)) => {
                        write!(f, " dated {:.3?} before the last one", earlier.duration())
                    }
                }
            }
        }
    }
}
