//! Where the keys of a scene were typed.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use crate::error::{Error, KeyPlace, SceneFault};

/// Where each key was typed.
#[derive(Debug, Clone, Default)]
pub(super) struct Places {
    path: Option<PathBuf>,
    /// Line of every key of the text, by its path (`defect[1].site`).
    lines: BTreeMap<String, usize>,
    /// What set each key that was set from outside.
    settings: BTreeMap<String, String>,
}

impl Places {
    /// The places of all keys of a parsed text.
    pub(super) fn of_text(path: Option<&Path>, text: &str, table: &DeTable<'_>) -> Places {
        let mut places = Places {
            path: path.map(Path::to_owned),
            ..Places::default()
        };
        note_lines(&mut places.lines, &line_starts(text), "", table);
        places
    }

    /// Records the origin of a key's value. Returns whether it had been set before.
    pub(super) fn set(&mut self, key: &str, source: &str) -> bool {
        self.settings
            .insert(key.to_owned(), source.to_owned())
            .is_some()
    }

    /// Has `key` named, in messages, as `other`, whose value it was made from.
    pub(super) fn stands_for(&mut self, key: &str, other: &str) {
        if let Some(source) = self.settings.get(other).cloned() {
            self.settings.insert(key.to_owned(), source);
        } else if let Some(line) = self.lines.get(other).copied() {
            self.lines.insert(key.to_owned(), line);
        }
    }

    /// The place of a key, or of the innermost thing that holds it.
    pub(super) fn of(&self, key: &str) -> KeyPlace {
        let top = key.split(['.', '[']).next().unwrap_or(key);
        if let Some(source) = self.settings.get(top) {
            return KeyPlace::Setting {
                source: source.clone(),
            };
        }
        let Some(path) = &self.path else {
            return KeyPlace::Nowhere;
        };
        let mut shorter = key;
        let line = loop {
            if let Some(line) = self.lines.get(shorter) {
                break Some(*line);
            }
            match shorter.rfind(['.', '[']) {
                Some(end) => shorter = &shorter[..end],
                None => break None,
            }
        };
        KeyPlace::File {
            path: path.clone(),
            line,
        }
    }

    /// What was expected of a key, and found.
    pub(super) fn fault(
        &self,
        key: &str,
        expected: impl Into<String>,
        found: impl Display,
    ) -> Error {
        Error::scene(SceneFault::new(self.of(key), key, expected, found))
    }

    /// Whether the key was typed.
    pub(super) fn has(&self, key: &str) -> bool {
        self.settings.contains_key(key) || self.lines.contains_key(key)
    }

    /// How a message about another key mentions this one: with its line or its option.
    pub(super) fn mention(&self, key: &str) -> String {
        match self.of(key) {
            KeyPlace::Setting { source } => format!("`{source}`"),
            KeyPlace::File {
                line: Some(line), ..
            } => format!("`{key}` (line {line})"),
            _ => format!("`{key}`"),
        }
    }
}

/// The line, from 1, in which a byte of the text is.
pub(super) fn line_at(text: &str, offset: usize) -> usize {
    let before = text.as_bytes().get(..offset).unwrap_or_default();
    before.iter().filter(|&&byte| byte == b'\n').count() + 1
}

fn line_starts(text: &str) -> Vec<usize> {
    let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
    let starts = ends.map(|(at, _)| at + 1);
    std::iter::once(0).chain(starts).collect()
}

fn note_lines(
    lines: &mut BTreeMap<String, usize>,
    starts: &[usize],
    prefix: &str,
    table: &DeTable<'_>,
) {
    let line = |offset: usize| starts.partition_point(|&start| start <= offset);
    for (key, value) in table.iter() {
        let dot = if prefix.is_empty() { "" } else { "." };
        let name = format!("{prefix}{dot}{}", key.get_ref());
        lines.insert(name.clone(), line(key.span().start));
        match value.get_ref() {
            DeValue::Table(inner) => note_lines(lines, starts, &name, inner),
            DeValue::Array(items) => {
                for (index, item) in items.iter().enumerate() {
                    let at = line(item.span().start);
                    // The place of the key is more precise if the value is on the same line.
                    if lines.get(&name) == Some(&at) && !item.get_ref().is_table() {
                        continue;
                    }
                    let name = format!("{name}[{index}]");
                    lines.insert(name.clone(), at);
                    if let DeValue::Table(inner) = item.get_ref() {
                        note_lines(lines, starts, &name, inner);
                    }
                }
            }
            _ => {}
        }
    }
}
