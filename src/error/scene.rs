//! What is wrong with a scene, and where.

use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;

use super::{Fault, one_of_words};

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

/// A fault of a scene: a text that is no TOML, a value that is absent, unknown, contradictory or not physical, a run whose
/// results do not fit the memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneFault {
    pub place: KeyPlace,
    /// The key at fault, such as `stiffness_ratio` or `defect[1].site`; empty for a fault of
    /// syntax.
    pub key: String,
    pub fault: Fault,
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
        self.fault.fmt(f)
    }
}

impl SceneFault {
    /// Of a value.
    pub(crate) fn new(
        place: KeyPlace,
        key: &str,
        expected: impl Into<String>,
        found: impl fmt::Display,
    ) -> SceneFault {
        let advice = match &place {
            // Not one of its keys is at fault, but the file.
            KeyPlace::File { path, line: None } if key.is_empty() => Cow::Owned(format!(
                "{START}; is it a field, `cascade analyze {}` reads it",
                path.display()
            )),
            KeyPlace::Setting { source } if source.starts_with("values of ") => {
                "write values as a list, 1,2,4, or a range: 1:10:19 (19 in equal steps), 1:10:19log, 1:10 (whole numbers)".into()
            }
            _ => "`cascade scene` prints all keys with what they mean".into(),
        };
        SceneFault {
            place,
            key: shortened(key),
            fault: Fault::expected(expected.into(), shortened(&found.to_string()), advice),
        }
    }

    /// Of a text that is no TOML, or no scene.
    pub(crate) fn syntax(place: KeyPlace, key: &str, reason: impl Into<String>) -> SceneFault {
        SceneFault {
            place,
            key: key.to_owned(),
            fault: Fault::new(reason, START),
        }
    }

    /// Of what serde says in `message`: as an expected and a found value, where it names both.
    pub(crate) fn of_serde(place: KeyPlace, key: &str, message: &str) -> SceneFault {
        let split = |prefix: &str| message.strip_prefix(prefix)?.split_once(", expected ");
        let invalid = ["invalid type: ", "invalid value: ", "invalid length "];
        if let Some((found, expected)) = invalid.into_iter().find_map(split) {
            return SceneFault::new(place, key, plain(expected), plain(found));
        }
        let unknown = ["unknown variant ", "unknown field "];
        if let Some((found, expected)) = unknown.into_iter().find_map(split) {
            let known: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
            let expected = one_of_words(found.trim_matches('`'), &known);
            return SceneFault::new(place, key, plain(&expected), plain(found));
        }
        SceneFault::syntax(place, key, shortened(message))
    }
}

const START: &str = "`cascade scene` prints a scene to start from";

/// A text, shortened to fit a message.
fn shortened(text: &str) -> String {
    const MOST: usize = 120;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
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
