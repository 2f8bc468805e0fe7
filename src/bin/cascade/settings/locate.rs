//! Words and settings together, and which setting is at fault where they cannot be read.

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{ArgMatches, CommandFactory, Error};

use super::file::{Setting, SettingFault};
use super::keys::is_whole;
use crate::args::Cli;
use crate::failure::Failure;

/// What the words and settings say together. A setting that needs an `overridden` one is left out, too; a
/// fault of the words themselves ends the program.
pub fn parsed(
    words: &[OsString],
    mut settings: Vec<Setting>,
    overridden: &[Setting],
) -> Result<(ArgMatches, Vec<Setting>), Failure> {
    loop {
        let error = match matches(words, &settings) {
            Ok(matches) => return Ok((matches, settings)),
            Err(error) => error,
        };
        let Some(at) = at_fault(words, &settings, &error) else {
            error.exit();
        };
        let setting = settings.remove(at);
        let missing = named(&error, ContextKind::InvalidArg);
        let is_overridden = |name: &String| overridden.iter().any(|one| one.option() == *name);
        let needs_overridden =
            error.kind() == ErrorKind::MissingRequiredArgument && missing.iter().any(is_overridden);
        if !needs_overridden {
            return Err(fault(&setting, &error).into());
        }
    }
}

fn matches(words: &[OsString], settings: &[Setting]) -> Result<ArgMatches, Error> {
    let set = settings.iter().flat_map(|setting| &setting.words);
    // Behind the name of the command, so that words after `--` remain what they are.
    let (before, after) = words.split_at(words.len().min(2));
    let all = before.iter().cloned().chain(set.map(OsString::from));
    Cli::command().try_get_matches_from(all.chain(after.iter().cloned()))
}

/// The setting without which the error would not be, or be another one.
fn at_fault(words: &[OsString], settings: &[Setting], error: &Error) -> Option<usize> {
    let said = error.to_string();
    (0..settings.len()).find(|&at| {
        let mut others = settings.to_vec();
        others.remove(at);
        matches(words, &others).map_or_else(|error| error.to_string() != said, |_| true)
    })
}

fn fault(setting: &Setting, error: &Error) -> SettingFault {
    let found = setting.shown();
    match error.kind() {
        ErrorKind::InvalidValue => {
            let known = strings(error, ContextKind::ValidValue).join(", ");
            setting.fault(format!("one of {known}"), found)
        }
        ErrorKind::ValueValidation => {
            let source = std::error::Error::source(error);
            let reason = source.map_or_else(|| error.to_string(), ToString::to_string);
            let expected = match reason.strip_prefix("expected ") {
                Some(expected) => expected.split(", found ").next().unwrap_or(expected).into(),
                None if is_whole(&setting.arg) => format!("a whole number ({reason})"),
                None => format!("another value ({reason})"),
            };
            setting.fault(expected, found)
        }
        ErrorKind::ArgumentConflict => {
            let mut both = named(error, ContextKind::InvalidArg);
            both.extend(named(error, ContextKind::PriorArg));
            both.retain(|option| *option != setting.option());
            setting.fault(format!("it or `{}`", keys_of(&both)), "both")
        }
        ErrorKind::MissingRequiredArgument => {
            let missing = keys_of(&named(error, ContextKind::InvalidArg));
            setting.fault(format!("`{missing}` beside it"), "it alone")
        }
        _ => setting.fault(format!("another value ({error})"), found),
    }
}

/// Options as the keys that they are.
fn keys_of(options: &[String]) -> String {
    let keys = options.iter();
    let keys = keys.map(|option| option.trim_start_matches('-').replace('-', "_"));
    keys.collect::<Vec<_>>().join("`, `")
}

/// Options that an error names, without their values.
fn named(error: &Error, kind: ContextKind) -> Vec<String> {
    let options = strings(error, kind).into_iter();
    let option = |text: String| text.split([' ', '=']).next().unwrap_or(&text).to_owned();
    options.map(option).collect()
}

fn strings(error: &Error, kind: ContextKind) -> Vec<String> {
    match error.get(kind) {
        Some(ContextValue::String(one)) => vec![one.clone()],
        Some(ContextValue::Strings(some)) => some.clone(),
        _ => Vec::new(),
    }
}
