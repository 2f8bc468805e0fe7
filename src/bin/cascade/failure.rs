//! Messages of failures, and their exit codes.

use std::io::ErrorKind;
use std::path::PathBuf;

use wavecascade::Error;
use wavecascade::chain::scene::KeyPlace;

use crate::advice;
use crate::progress::{reason, stopped_code};
use crate::terminal::{Tone, message};

/// Why a command did not end well.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error(transparent)]
    Library(#[from] Error),
    /// A pattern that is none, or matches nothing.
    #[error("expected files that `{pattern}` matches, found {found}")]
    Pattern { pattern: String, found: String },
    /// Some of several have no result, as this says.
    #[error("{0}")]
    Partly(String),
    /// Several fields, interrupted after some of them.
    #[error("cancelled after {known} of {fields} fields; {} keeps what is known of them", out.display())]
    Stopped {
        known: usize,
        fields: usize,
        out: PathBuf,
    },
    /// Standard output was closed or could not be written.
    #[error("cannot write to standard output: {0}")]
    Output(#[from] std::io::Error),
}

impl From<serde_json::Error> for Failure {
    fn from(error: serde_json::Error) -> Self {
        Failure::Output(error.into())
    }
}

/// As shells count an interrupt; other signals are counted likewise.
pub const INTERRUPTED: u8 = 130;

/// As `timeout` ends what took too long.
pub const TIMED_OUT: u8 = 124;

impl Failure {
    /// Prints it to standard error. 2: the request was wrong; 1: the run failed; 130: interrupted, 143: terminated; 124: the time of `--max-time` is over.
    pub fn report(&self) -> u8 {
        if let Some(mut text) = self.text() {
            if let Some(reason) = reason().filter(|_| self.is_stopped()) {
                text = format!("{text}: {reason}");
            }
            message(Tone::Error, &text);
        }
        if let Some(advice) = self.advice() {
            message(Tone::Help, &advice);
        }
        self.exit_code()
    }

    /// What went wrong; nothing where it is none of the user's business.
    pub fn text(&self) -> Option<String> {
        Some(match self {
            Failure::Library(Error::Request {
                option,
                expected,
                found,
            }) => format!("--{option}: expected {expected}, found {found}"),
            // A key that is missing where there is no file is an option that is missing.
            Failure::Library(Error::Scene { fault })
                if fault.place == KeyPlace::Nowhere && !fault.key.is_empty() =>
            {
                let option = fault.key.replace('_', "-");
                format!("--{}", fault.to_string().replacen(&fault.key, &option, 1))
            }
            // A reader that went away (`cascade ... | head`) has read enough: no failure.
            Failure::Output(error) if error.kind() == ErrorKind::BrokenPipe => return None,
            other => other.to_string(),
        })
    }

    /// What the user can do, where that is known.
    pub fn advice(&self) -> Option<String> {
        match self {
            Failure::Library(error) => advice::of_error(error),
            Failure::Pattern { .. } => Some("check the folder and the ending".into()),
            _ => None,
        }
    }

    /// Whether the user ended the work, by an interrupt or by `--max-time`.
    fn is_stopped(&self) -> bool {
        matches!(
            self,
            Failure::Library(Error::Cancelled | Error::Paused { .. }) | Failure::Stopped { .. }
        )
    }

    fn exit_code(&self) -> u8 {
        match self {
            _ if self.is_stopped() => stopped_code(),
            Failure::Library(error) if error.is_usage() => 2,
            Failure::Pattern { .. } => 2,
            Failure::Output(error) if error.kind() == ErrorKind::BrokenPipe => 0,
            _ => 1,
        }
    }
}
