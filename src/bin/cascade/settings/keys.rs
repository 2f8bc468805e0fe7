//! The keys of settings files, made from the declaration of the options.

use std::any::TypeId;

use clap::builder::PossibleValue;
use clap::{Arg, ArgAction, Command, CommandFactory, ValueEnum};
use toml::Value;

use crate::args::Cli;

/// Heading of the options that say how figures look; they are the keys of a style.
pub const FIGURES: &str = "Figures";

/// What a settings file is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Options of `cascade analyze`.
    Analysis,
    /// Options under the heading "Figures", of every command that draws.
    Style,
}

const OF_A_SCAN: &str = "each call says which files are one field";

/// Options that say what one call does; a file that holds for many calls cannot state them.
const OF_A_CALL: [(&str, &str); 13] = [
    ("settings", "a settings file names no other one"),
    ("out", "each call writes to a place of its own"),
    ("force", "what may be replaced is decided at each call"),
    ("plan", "a call computes or plans"),
    ("json", "each call says how it prints"),
    ("quiet", "each call says how it prints"),
    ("verbose", "each call says how it prints"),
    ("help", "it prints and stops"),
    ("position_from", OF_A_SCAN),
    ("channel", OF_A_SCAN),
    ("reference", OF_A_SCAN),
    ("least_correlation", OF_A_SCAN),
    ("equal_positions", OF_A_SCAN),
];

impl Kind {
    /// Name of the file that is looked for.
    pub fn file_name(self) -> &'static str {
        match self {
            Kind::Analysis => "analysis.toml",
            Kind::Style => "style.toml",
        }
    }

    /// The options of one command that are keys.
    pub fn of_command(self, command: &Command) -> Vec<Arg> {
        let is_key = |arg: &&Arg| {
            let is_option = arg.get_long().is_some() && !arg.is_hide_set();
            let is_figure = arg.get_help_heading() == Some(FIGURES);
            is_option
                && reason_against(&key_of(arg)).is_none()
                && match self {
                    Kind::Analysis => command.get_name() == "analyze",
                    Kind::Style => is_figure,
                }
        };
        command.get_arguments().filter(is_key).cloned().collect()
    }

    /// All keys, each once, in the order of their declaration.
    pub fn keys(self) -> Vec<Arg> {
        let mut keys: Vec<Arg> = Vec::new();
        for command in Cli::command().get_subcommands() {
            for arg in self.of_command(command) {
                if keys.iter().all(|known| known.get_long() != arg.get_long()) {
                    keys.push(arg);
                }
            }
        }
        keys
    }
}

/// Why an option is no key, for one that a file cannot state.
pub fn reason_against(key: &str) -> Option<&'static str> {
    let found = OF_A_CALL.iter().find(|(name, _)| *name == key)?;
    Some(found.1)
}

/// The key of an option: its long name with `_` for `-`.
pub fn key_of(arg: &Arg) -> String {
    arg.get_long().unwrap_or_default().replace('-', "_")
}

/// Whether a key sets this option: by its name or by an alias that help shows.
pub fn is_named(arg: &Arg, key: &str) -> bool {
    let aliases = arg.get_visible_aliases().unwrap_or_default();
    key_of(arg) == key || aliases.iter().any(|alias| alias.replace('-', "_") == key)
}

pub fn is_flag(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::SetTrue)
}

/// Whether an option takes several values.
pub fn is_list(arg: &Arg) -> bool {
    arg.get_value_delimiter().is_some() || matches!(arg.get_action(), ArgAction::Append)
}

/// Whether the values of an option are whole numbers and nothing else.
pub fn is_whole(arg: &Arg) -> bool {
    let value = arg.get_value_parser().type_id();
    let whole = [
        TypeId::of::<u16>(),
        TypeId::of::<u32>(),
        TypeId::of::<usize>(),
    ];
    whole.into_iter().any(|kind| value == kind)
}

pub fn choices(arg: &Arg) -> Vec<PossibleValue> {
    let shown = |value: &PossibleValue| !value.is_hide_set();
    match is_flag(arg) {
        true => Vec::new(),
        false => arg
            .get_possible_values()
            .into_iter()
            .filter(shown)
            .collect(),
    }
}

/// The words that a command line would have for a key of this value. The error is what was expected.
pub fn words(arg: &Arg, value: &Value) -> Result<Vec<String>, String> {
    let long = arg.get_long().unwrap_or_default();
    let set = |text: String| format!("--{long}={text}");
    match value {
        Value::Boolean(true) if is_flag(arg) => return Ok(vec![format!("--{long}")]),
        Value::Boolean(false) if is_flag(arg) => return Ok(Vec::new()),
        _ if is_flag(arg) => return Err("true or false".into()),
        _ => {}
    }
    let expected = || match is_list(arg) {
        true => "a text, a number, or a list of these".to_owned(),
        false => "a text or a number".to_owned(),
    };
    let Value::Array(items) = value else {
        return Ok(vec![set(text(value).ok_or_else(expected)?)]);
    };
    if !is_list(arg) {
        return Err("one value".into());
    }
    if items.is_empty() {
        return Err("a list of one value or more".into());
    }
    let texts: Option<Vec<String>> = items.iter().map(text).collect();
    let texts = texts.ok_or_else(expected)?;
    Ok(match arg.get_value_delimiter() {
        Some(between) => vec![set(texts.join(&between.to_string()))],
        None => texts.into_iter().map(set).collect(),
    })
}

/// A value as it is typed on a command line.
fn text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Integer(number) => Some(number.to_string()),
        Value::Float(number) => Some(format!("{number:?}")),
        Value::Boolean(flag) => Some(flag.to_string()),
        Value::Datetime(_) | Value::Array(_) | Value::Table(_) => None,
    }
}
