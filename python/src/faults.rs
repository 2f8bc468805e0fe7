//! Errors of the library as exceptions, in the same words.

use pyo3::exceptions::{
    PyFileExistsError, PyFileNotFoundError, PyKeyboardInterrupt, PyMemoryError, PyOSError,
    PyRuntimeError, PyTypeError, PyValueError,
};
use pyo3::prelude::*;
use wavecascade::Error;

use crate::failure::Failure;

/// Whether samples come from files, whose faults are errors of the system, or from an array of the caller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum From {
    Files,
    Memory,
}

/// An error of the library.
pub fn of(py: Python<'_>, error: Error, from: From) -> PyErr {
    of_failure(py, Failure::Library(error), from)
}

/// An error of a command. What to do is a note of the exception.
pub fn of_failure(py: Python<'_>, failure: Failure, from: From) -> PyErr {
    let text = match &failure {
        Failure::Library(Error::Request {
            option,
            expected,
            found,
        }) => {
            let option = option.replace('-', "_");
            format!("{option}: expected {expected}, found {found}")
        }
        Failure::Library(error) => error.to_string(),
        other => other.text().unwrap_or_default(),
    };
    let advice = failure.advice().map(|advice| keywords(&advice));
    let text = shortened(keywords(&text));
    let error = match &failure {
        Failure::Library(error) => match error {
            Error::Read { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
                PyFileNotFoundError::new_err(text)
            }
            Error::Exists { .. } => PyFileExistsError::new_err(text),
            Error::Input { .. } | Error::Scan { .. } if from == From::Files => {
                PyOSError::new_err(text)
            }
            Error::Read { .. }
            | Error::Write { .. }
            | Error::Changed { .. }
            | Error::Damaged { .. }
            | Error::Busy { .. }
            | Error::OutputInUse { .. } => PyOSError::new_err(text),
            Error::Memory { .. } | Error::Refused { .. } => PyMemoryError::new_err(text),
            Error::Cancelled | Error::Paused { .. } => PyKeyboardInterrupt::new_err(text),
            Error::Parseval { .. } | Error::Threads { .. } | Error::Draw { .. } => {
                PyRuntimeError::new_err(text)
            }
            _ => PyValueError::new_err(text),
        },
        Failure::Output(_) => PyOSError::new_err(text),
        _ => PyValueError::new_err(text),
    };
    if let Some(advice) = advice {
        // Without its note it is the same error.
        let _ = error.value(py).call_method1("add_note", (advice,));
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
