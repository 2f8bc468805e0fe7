//! Errors of the library as exceptions, in the same words.

use std::io::ErrorKind;

use pyo3::exceptions::{
    PyFileExistsError, PyFileNotFoundError, PyKeyboardInterrupt, PyMemoryError, PyOSError,
    PyRuntimeError, PyTypeError, PyValueError,
};
use pyo3::prelude::*;
use wavecascade::Error;
use wavecascade::sheet::Warning;

use crate::failure::Failure;

/// Whether samples come from files, whose faults are errors of the system, or from an array of the caller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum From {
    Files,
    Memory,
}

/// An error of the library or of a command. What to do is a note of the exception.
pub fn of(py: Python<'_>, failure: impl Into<Failure>, from: From) -> PyErr {
    let failure = failure.into();
    let of_files = from == From::Files;
    let new: fn(String) -> PyErr = match &failure {
        Failure::Library(error) => match error {
            Error::Read { source, .. } if source.kind() == ErrorKind::NotFound => {
                PyFileNotFoundError::new_err
            }
            Error::Exists { .. } => PyFileExistsError::new_err,
            Error::Input { .. } | Error::Scan { .. } if of_files => PyOSError::new_err,
            Error::Read { .. } | Error::Write { .. } | Error::Changed { .. } => PyOSError::new_err,
            Error::Damaged { .. } | Error::Busy { .. } => PyOSError::new_err,
            Error::OutputInUse { .. } => PyOSError::new_err,
            Error::Memory { .. } | Error::Refused { .. } => PyMemoryError::new_err,
            Error::Cancelled | Error::Paused { .. } => PyKeyboardInterrupt::new_err,
            Error::Failed(_) => PyRuntimeError::new_err,
            _ => PyValueError::new_err,
        },
        Failure::Output(_) => PyOSError::new_err,
        _ => PyValueError::new_err,
    };
    let text = failure.text().unwrap_or_default();
    let error = new(shortened(keywords(&text)));
    if let Some(advice) = failure.advice() {
        // Without its note it is the same error.
        let _ = error
            .value(py)
            .call_method1("add_note", (keywords(&advice),));
    }
    error
}

/// Words that clap refuses.
pub fn of_words(error: &clap::Error) -> PyErr {
    let text = error.to_string();
    let lines = text.lines().take_while(|line| !line.is_empty());
    let text: Vec<&str> = lines.map(str::trim).collect();
    let text = text.join(" ");
    let text = shortened(keywords(text.trim_start_matches("error: ")));
    match error.kind() {
        clap::error::ErrorKind::UnknownArgument => PyTypeError::new_err(text),
        _ => PyValueError::new_err(text),
    }
}

/// A text without its middle, if it is long: it may hold all values of an array.
fn shortened(text: String) -> String {
    const ENDS: usize = 600;
    let letters: Vec<char> = text.chars().collect();
    if letters.len() <= 3 * ENDS {
        return text;
    }
    let (head, tail) = (&letters[..ENDS], &letters[letters.len() - ENDS..]);
    format!(
        "{} [..] {}",
        String::from_iter(head),
        String::from_iter(tail)
    )
}

/// `(of, message, advice)` of a finding about `of`.
pub fn warning(of: &'static str, found: &Warning) -> (&'static str, String, String) {
    (of, keywords(&found.message), keywords(&found.advice))
}

/// The text with options as keywords: `--pad-time 3` as `pad_time=3`, `--direct` as `direct`.
pub fn keywords(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, after) = rest.split_at(at);
        out += before;
        let after = &after[2..];
        let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '-';
        let end = after.find(|c| !is_of_name(c)).unwrap_or(after.len());
        let (name, behind) = after.split_at(end);
        let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic());
        if !is_name || before.ends_with('-') {
            out += "--";
            rest = after;
            continue;
        }
        out += &name.replace('-', "_");
        rest = behind;
        // A value within the same backquotes.
        let is_quoted = before.ends_with('`');
        let value = rest.strip_prefix(' ').filter(|v| !v.starts_with('-'));
        if let (true, Some(value)) = (is_quoted, value) {
            out.push('=');
            rest = value;
        }
    }
    out + rest
}
