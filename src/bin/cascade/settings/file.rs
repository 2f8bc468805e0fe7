//! A settings file: its keys with their lines, and what can be wrong with it.

use std::fmt;
use std::path::{Path, PathBuf};

use clap::{Arg, Command};
use toml::de::DeTable;
use toml::{Table, Value};
use wavecascade::Error;
use wavecascade::error::nearest_key;

use super::keys::{Kind, is_named, key_of, reason_against, words};
use crate::failure::Failure;

/// Bytes of a file that are read at most.
const LENGTH_LIMIT: u64 = 65_536;

/// A fault of a settings file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SettingFault {
    pub path: PathBuf,
    pub line: Option<usize>,
    /// Empty for a fault of the whole file.
    pub key: String,
    pub problem: Problem,
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Problem {
    /// The text is no TOML.
    Syntax { reason: String },
    /// A key that is unknown, or whose value does not fit.
    Value { expected: String, found: String },
}

impl fmt::Display for SettingFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, "{line}:")?;
        }
        if !self.key.is_empty() {
            write!(f, " {}:", self.key)?;
        }
        match &self.problem {
            Problem::Syntax { reason } => write!(f, " {reason}"),
            Problem::Value { expected, found } => write!(f, " expected {expected}, found {found}"),
        }
    }
}

/// A key that a file sets.
#[derive(Debug, Clone)]
pub struct Setting {
    pub path: PathBuf,
    pub line: Option<usize>,
    pub key: String,
    /// The option that it sets.
    pub arg: Arg,
    pub value: Value,
    /// The words that a command line would have for it.
    pub words: Vec<String>,
}

impl Setting {
    pub fn fault(&self, expected: impl Into<String>, found: impl Into<String>) -> SettingFault {
        SettingFault {
            path: self.path.clone(),
            line: self.line,
            key: self.key.clone(),
            problem: Problem::Value {
                expected: expected.into(),
                found: found.into(),
            },
        }
    }

    /// The option that it sets, as it is typed.
    pub fn option(&self) -> String {
        format!("--{}", self.arg.get_long().unwrap_or_default())
    }

    /// The value as the file has it.
    pub fn shown(&self) -> String {
        shortened(&self.value.to_string())
    }

    /// Where it stands, for provenance and messages.
    pub fn place(&self) -> String {
        match self.line {
            Some(line) => format!("{}:{line}", self.path.display()),
            None => self.path.display().to_string(),
        }
    }
}

/// The settings of a file. Keys of a style that `command` has no option for are left out: other
/// commands have it.
pub fn read(kind: Kind, path: &Path, command: &Command) -> Result<Vec<Setting>, Failure> {
    let (table, lines) = parse(path)?;
    let (all, usable) = (kind.keys(), kind.of_command(command));
    let mut settings = Vec::new();
    for (key, value) in &table {
        let line = lines
            .iter()
            .find(|(name, _)| name == key)
            .map(|(_, line)| *line);
        let fault = |expected: String, found: String| {
            Failure::from(SettingFault {
                path: path.to_owned(),
                line,
                key: key.clone(),
                problem: Problem::Value { expected, found },
            })
        };
        if !all.iter().any(|arg| is_named(arg, key)) {
            return Err(fault(
                expected_in_place_of(kind, key, &all),
                format!("`{key}`"),
            ));
        }
        let Some(arg) = usable.iter().find(|arg| is_named(arg, key)) else {
            continue;
        };
        let refused = |expected| fault(expected, shortened(&value.to_string()));
        settings.push(Setting {
            path: path.to_owned(),
            line,
            key: key.clone(),
            arg: arg.clone(),
            words: words(arg, value).map_err(refused)?,
            value: value.clone(),
        });
    }
    settings.sort_by_key(|setting| setting.line);
    Ok(settings)
}

/// What would be right where an unknown key stands.
fn expected_in_place_of(kind: Kind, key: &str, known: &[Arg]) -> String {
    let what = match kind {
        Kind::Analysis => "a key of analysis settings",
        Kind::Style => "a key of styles",
    };
    if let Some(reason) = reason_against(key) {
        return format!("it on the command line, since {reason}");
    }
    let elsewhere = match kind {
        Kind::Style => Kind::Analysis.keys(),
        Kind::Analysis => Vec::new(),
    };
    if elsewhere.iter().any(|arg| is_named(arg, key)) {
        return format!(
            "{what}; those of analyses stand in {}",
            Kind::Analysis.file_name()
        );
    }
    let names: Vec<String> = known.iter().map(key_of).collect();
    match nearest_key(&key.replace('-', "_"), names.iter().map(String::as_str)) {
        Some(name) => format!("{what} (`{name}`?)"),
        None => what.into(),
    }
}

/// The keys with their values, and with their lines.
fn parse(path: &Path) -> Result<(Table, Vec<(String, usize)>), Failure> {
    let read = |source| Error::Read {
        path: path.to_owned(),
        action: "read",
        source,
    };
    let whole = |line, problem| SettingFault {
        path: path.to_owned(),
        line,
        key: String::new(),
        problem,
    };
    let refuse = |expected: String, found: String| whole(None, Problem::Value { expected, found });
    let file = std::fs::metadata(path).map_err(read)?;
    if !file.is_file() {
        return Err(refuse("a file".into(), "something else".into()).into());
    }
    if file.len() > LENGTH_LIMIT {
        let expected = format!("settings of at most {LENGTH_LIMIT} bytes");
        return Err(refuse(expected, format!("{} bytes", file.len())).into());
    }
    let bytes = std::fs::read(path).map_err(read)?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        refuse(
            "text in UTF-8".into(),
            format!("something else at byte {at}"),
        )
    })?;
    let line_of = |offset: usize| text[..offset].matches('\n').count() + 1;
    let syntax = |error: toml::de::Error| {
        let line = error.span().map(|span| line_of(span.start));
        let reason = error.message().trim().replace('\n', ", ");
        Failure::from(whole(line, Problem::Syntax { reason }))
    };
    let spanned = DeTable::parse(&text).map_err(syntax)?;
    let lines = spanned.get_ref().iter();
    let lines = lines.map(|(key, _)| (key.get_ref().to_string(), line_of(key.span().start)));
    let lines = lines.collect();
    let table = toml::from_str(&text).map_err(syntax)?;
    Ok((table, lines))
}

fn shortened(text: &str) -> String {
    const MOST: usize = 120;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
