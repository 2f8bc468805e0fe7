//! Ways in which the files of a scan can fail to be one field.

use std::path::PathBuf;

/// What is wrong with one file among those of a scan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScanFault {
    #[error("expected the numbers of {} in its name, found another text around them", other.display())]
    OtherName { other: PathBuf },

    /// Nothing that differs from file to file.
    #[error(
        "expected one number in {place} that differs from file to file, found {}",
        list(found)
    )]
    NoPosition {
        place: &'static str,
        found: Vec<String>,
    },

    #[error(
        "expected one number in {place} that differs from file to file, found {}",
        list(found)
    )]
    SeveralPositions {
        place: &'static str,
        found: Vec<String>,
    },

    #[error("expected a position in {}, found none", table.display())]
    NotInTable { table: PathBuf },

    #[error("expected a position in {expected}, found {found}")]
    PositionUnit { expected: String, found: String },

    #[error("expected positions that differ, found {position} as in {}", other.display())]
    EqualPositions { other: PathBuf, position: f64 },

    #[error("expected one record, found {found}")]
    Channels { found: usize },

    #[error("expected the channel {asked:?}, found {}", list(found))]
    NoSuchChannel { asked: String, found: Vec<String> },

    #[error("expected {what} {expected} as in the first file, found {found}")]
    Unlike {
        what: &'static str,
        expected: String,
        found: String,
    },

    #[error(
        "expected a start at a whole number of steps from that of the first file, found {shift} steps"
    )]
    Fraction { shift: f64 },

    #[error("expected at least two times in common, found an end before {} begins", other.display())]
    NoCommonTime { other: PathBuf },

    #[error(
        "expected a correlation coefficient of at least {least} with the reference of the first file, \
         found {found:.3} at a delay of {delay} samples"
    )]
    Uncorrelated { least: f64, found: f64, delay: i64 },

    #[error(
        "expected finite samples in the reference channel that are not all equal, found others"
    )]
    NoReference,
}

impl ScanFault {
    /// Whether the request is at fault, not a file.
    pub(super) fn is_usage(&self) -> bool {
        use ScanFault::*;
        matches!(
            self,
            OtherName { .. }
                | NoPosition { .. }
                | SeveralPositions { .. }
                | NotInTable { .. }
                | Channels { .. }
                | NoSuchChannel { .. }
        )
    }
}

fn list(found: &[String]) -> String {
    match found {
        [] => "none".into(),
        some => some.join(", "),
    }
}
