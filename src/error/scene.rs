//! What is wrong with a scene, and where.

use std::fmt;
use std::path::PathBuf;

use super::{one_of_words, size};

/// Where a key of a scene was typed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum KeyPlace {
    /// In a scene file; without a line where the key is not in it.
    File { path: PathBuf, line: Option<usize> },
    /// Set from outside, by something of this name, such as an option.
    Setting { source: String },
    /// Nowhere, in a scene without a file.
    Nowhere,
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Problem {
    /// The text is no TOML.
    Syntax { reason: String },
    /// A value that is absent, unknown, contradictory or not physical.
    Value { expected: String, found: String },
    /// A run whose results do not fit the memory, in bytes.
    TooLarge {
        sites: usize,
        samples: usize,
        needed: u64,
        allowed: u64,
    },
}

/// A fault of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneFault {
    pub place: KeyPlace,
    /// The key at fault, such as `stiffness_ratio` or `defect[1].site`; empty for a fault of
    /// syntax.
    pub key: String,
    pub problem: Problem,
}

impl fmt::Display for SceneFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            KeyPlace::File { path, line } => {
                let line = line.map(|line| format!("{line}:"));
                write!(f, "{}:{} ", path.display(), line.unwrap_or_default())?;
            }
            KeyPlace::Setting { source } => write!(f, "{source}: ")?,
            KeyPlace::Nowhere => {}
        }
        // A setting names its key itself.
        if !matches!(self.place, KeyPlace::Setting { .. }) && !self.key.is_empty() {
            write!(f, "{}: ", self.key)?;
        }
        match &self.problem {
            Problem::Syntax { reason } => f.write_str(reason),
            Problem::Value { expected, found } => write!(f, "expected {expected}, found {found}"),
            Problem::TooLarge {
                sites,
                samples,
                needed,
                allowed,
            } => write!(
                f,
                "expected a run that fits {} of memory, found {sites} sites at {samples} samples, \
                 which need {}",
                size(*allowed),
                size(*needed)
            ),
        }
    }
}

impl SceneFault {
    pub(crate) fn new(
        place: KeyPlace,
        key: &str,
        expected: impl Into<String>,
        found: impl fmt::Display,
    ) -> SceneFault {
        SceneFault {
            place,
            key: shortened(key),
            problem: Problem::Value {
                expected: expected.into(),
                found: shortened(&found.to_string()),
            },
        }
    }
}

/// A text, shortened to fit a message.
fn shortened(text: &str) -> String {
    const MOST: usize = 120;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// A message of serde as an expected and a found value.
pub(crate) fn reworded(message: &str) -> Problem {
    let value = |expected: &str, found: &str| Problem::Value {
        expected: plain(expected),
        found: shortened(&plain(found)),
    };
    let split = |prefix: &str| message.strip_prefix(prefix)?.split_once(", expected ");
    let invalid = ["invalid type: ", "invalid value: ", "invalid length "];
    if let Some((found, expected)) = invalid.into_iter().find_map(split) {
        return value(expected, found);
    }
    let unknown = ["unknown variant ", "unknown field "];
    if let Some((found, expected)) = unknown.into_iter().find_map(split) {
        let known: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
        return value(&one_of_words(found.trim_matches('`'), &known), found);
    }
    Problem::Syntax {
        reason: shortened(message),
    }
}

/// Names of Rust's types in plain words.
fn plain(words: &str) -> String {
    let named = match words {
        "f64" => "a number",
        "usize" | "u64" => "a whole number of 0 or more",
        "a boolean" | "bool" => "true or false",
        "a sequence" | "sequence" => "a list",
        "map" => "a table",
        other => other,
    };
    named
        .replace("floating point `", "the number `")
        .replace("integer `", "the number `")
        .replace("string \"", "the text \"")
        .replace("boolean `", "`")
}
