//! The words of a command to what the program makes of them.

use clap::Parser;
use pyo3::prelude::*;

use super::faults;
use crate::args::{Cli, Command};

/// The command that these words are, the name of the command first.
pub fn command(words: &[String]) -> PyResult<Command> {
    let words = std::iter::once("cascade").chain(words.iter().map(String::as_str));
    let cli = Cli::try_parse_from(words).map_err(|error| faults::of_words(&error))?;
    Ok(cli.command)
}

/// Takes the typed options out of the command; the caller has named it itself.
macro_rules! typed {
    ($words:expr, $command:ident) => {
        match $crate::python::typed::command($words)? {
            $crate::args::Command::$command(typed) => typed,
            _ => {
                return Err(pyo3::exceptions::PyValueError::new_err(format!(
                    "expected the words of {}, found {:?}",
                    stringify!($command),
                    $words
                )));
            }
        }
    };
}
pub(super) use typed;

/// The words as they are kept with a result.
pub fn provenance(words: &[String]) -> Vec<String> {
    let name = words.first().map(|name| format!("wavecascade.{name}"));
    let options = words.iter().skip(1);
    let options = options.filter_map(|word| word.strip_prefix("--"));
    let options = options.map(|word| word.replacen('-', "_", word.matches('-').count()));
    name.into_iter().chain(options).collect()
}
