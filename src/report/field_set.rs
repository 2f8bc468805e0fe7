//! A directory with the results of several fields, and an index of them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::directory::{holds_result, names as names_in, read_text};
use super::new_file::is_there;
use super::{Headlines, MovedShares, write_beside};
use crate::error::{Error, Result};
use crate::sheet::{Cell, Table, number, with_unit};
use crate::system::publish::{is_working_name, remove_abandoned};

/// Version of the layout of `index.json`.
pub const FIELDS_SCHEMA: &str = "cascade.fields/2";

const INDEX: &str = "index.json";
const TABLE: &str = "headlines.csv";
const PAGE: &str = "index.html";

/// One field and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FieldRow {
    /// Path of the field as it was given.
    pub field: String,
    /// Name of the directory of its results.
    pub name: String,
    /// What to open, from the directory on: its page or its summary.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub opens: Option<String>,
    #[serde(flatten)]
    pub outcome: FieldOutcome,
}

/// What became of a field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FieldOutcome {
    Headlines(Box<Headlines>),
    /// Why there is no result.
    Failed(String),
}

#[derive(Debug, Serialize, Deserialize)]
struct Index {
    schema: String,
    fields: Vec<FieldRow>,
}

/// A directory in which each field's results have a directory of their own. After each field,
/// `index.json`, `headlines.csv` and `index.html` list what it holds.
///
/// Each result appears whole or not at all; what is finished remains if the work is interrupted.
#[derive(Debug)]
pub struct FieldSet {
    path: PathBuf,
    rows: Vec<FieldRow>,
    /// Of an earlier call, which this one replaces.
    earlier: Vec<FieldRow>,
    /// Whether the directory was not there.
    is_new: bool,
}

impl FieldSet {
    /// Begins a directory of results at `path`.
    ///
    /// # Errors
    /// [`Error::Exists`] if results of several fields are there and are not to be replaced;
    /// [`Error::OutputInUse`] if something else is there; [`Error::Write`].
    pub fn create(path: &Path, replace: bool) -> Result<FieldSet> {
        let earlier = earlier(path)?;
        if earlier.is_some() && !replace {
            return Err(Error::Exists {
                path: path.to_owned(),
            });
        }
        let is_new = !path.exists();
        fs::create_dir_all(path).map_err(Error::write("create", path))?;
        remove_abandoned(path);
        Ok(FieldSet {
            path: path.to_owned(),
            rows: Vec::new(),
            earlier: earlier.unwrap_or_default(),
            is_new,
        })
    }

    /// Where the results of the field of this name go, and whether an earlier one is replaced.
    pub fn place(&self, name: &str) -> (PathBuf, bool) {
        let path = self.path.join(name);
        // A result has its name before it is listed, and a call may end between the two.
        let is_there = self.earlier.iter().any(|row| row.name == name) || holds_result(&path);
        (path, is_there)
    }

    /// Lists one more field.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn add(&mut self, row: FieldRow) -> Result<()> {
        if matches!(row.outcome, FieldOutcome::Failed(_)) {
            self.remove_earlier(&row.name)?;
        }
        self.earlier.retain(|earlier| earlier.name != row.name);
        self.rows.push(row);
        self.write()
    }

    /// What became of the fields so far.
    pub fn rows(&self) -> &[FieldRow] {
        &self.rows
    }

    /// Ends the work on all fields: results of an earlier call that are not of these go. A directory
    /// that has no result, and was not there before, goes, too.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn finish(mut self) -> Result<Vec<FieldRow>> {
        let stale: Vec<String> = self.earlier.iter().map(|row| row.name.clone()).collect();
        for name in stale {
            self.remove_earlier(&name)?;
        }
        self.earlier.clear();
        let is_failed = |row: &FieldRow| matches!(row.outcome, FieldOutcome::Failed(_));
        if self.is_new && self.rows.iter().all(is_failed) {
            self.remove_all();
        } else {
            self.write()?;
        }
        Ok(self.rows)
    }

    /// Ends interrupted work; results of an earlier call stay and stay listed.
    pub fn stop(self) -> Vec<FieldRow> {
        if self.is_new && self.rows.is_empty() {
            self.remove_all();
        }
        self.rows
    }

    fn remove_earlier(&self, name: &str) -> Result<()> {
        let (path, is_there) = self.place(name);
        // One that somebody has put something into stays.
        match is_there && holds_result(&path) {
            true => fs::remove_dir_all(&path).map_err(Error::write("remove", &path)),
            false => Ok(()),
        }
    }

    fn remove_all(&self) {
        for name in [INDEX, TABLE, PAGE] {
            let _ = fs::remove_file(self.path.join(name));
        }
        let _ = fs::remove_dir(&self.path);
    }

    fn write(&self) -> Result<()> {
        let rows: Vec<FieldRow> = self.rows.iter().chain(&self.earlier).cloned().collect();
        let encoded = |error: std::io::Error| Error::write("write", &self.path)(error);
        let csv = records(&rows)
            .to_csv()
            .map_err(|error| encoded(std::io::Error::other(error)))?;
        write_beside(&self.path, TABLE, csv.as_bytes())?;
        #[cfg(feature = "figures")]
        write_beside(&self.path, PAGE, super::fields_html(&rows).as_bytes())?;
        let index = Index {
            schema: FIELDS_SCHEMA.into(),
            fields: rows,
        };
        let json = serde_json::to_string_pretty(&index).map_err(|error| encoded(error.into()))?;
        write_beside(&self.path, INDEX, json.as_bytes())?;
        Ok(())
    }
}

/// What an earlier call has left at `path`; `None` where nothing is.
fn earlier(path: &Path) -> Result<Option<Vec<FieldRow>>> {
    let occupied = |found: String| Error::OutputInUse {
        path: path.to_owned(),
        found,
    };
    if !is_there(path, true)? {
        return Ok(None);
    }
    let names = names_in(path)?;
    if names.is_empty() {
        return Ok(None);
    }
    let text = read_text(&path.join(INDEX))?;
    let index = serde_json::from_str::<Index>(&text).ok();
    let index = index.filter(|index| index.schema == FIELDS_SCHEMA);
    let is_unlisted = |name: &str| holds_result(&path.join(name));
    // The first list may have failed, or been cut off by a kill, after the first result had its name.
    let is_unfinished = || {
        let is_part = |name: &String| [TABLE, PAGE].contains(&name.as_str()) || is_unlisted(name);
        text.is_empty() && names.iter().all(is_part)
    };
    let mut fields = match index {
        Some(index) => index.fields,
        None if is_unfinished() => Vec::new(),
        None => return Err(occupied(format!("holds no {INDEX} of several fields"))),
    };
    // What is not there is not listed any more.
    fields.retain(|row| names.contains(&row.name));
    let listed = |name: &str| fields.iter().any(|row| row.name == name);
    // A killed run leaves what it had begun.
    let is_begun = |name: &str| is_working_name(name.as_ref());
    let is_ours = |name: &&String| {
        let is_file = [INDEX, TABLE, PAGE].contains(&name.as_str());
        is_file || listed(name) || is_begun(name) || is_unlisted(name)
    };
    if let Some(name) = names.iter().find(|name| !is_ours(name)) {
        return Err(occupied(format!(
            "holds {name:?}, which no run has written"
        )));
    }
    Ok(Some(fields))
}

/// A name for the results of each field: `field` of field.npy, of other files with their extension.
/// Fields of one name get those of the folders before them: `first-field`, `second-field`.
///
/// # Errors
/// [`Error::Request`] if a field is given twice; [`Error::Read`] for a path that cannot be one.
pub fn field_names(fields: &[PathBuf]) -> Result<Vec<String>> {
    let mut names: Vec<String> = fields.iter().map(|field| own_name(field)).collect();
    for folders in 1.. {
        let clashing = clashing(&names);
        if clashing.is_empty() {
            break;
        }
        for n in clashing {
            let whole = fields[n].canonicalize();
            let whole = whole.or_else(|_| std::path::absolute(&fields[n]));
            let whole = whole.map_err(Error::read("find", &fields[n]))?;
            let parts: Vec<_> = whole.parent().into_iter().flatten().collect();
            if folders > parts.len() {
                let expected = "fields that differ, each with results of its own";
                let found = format!("{} twice", fields[n].display());
                return Err(Error::request("out", expected, found));
            }
            let before = parts[parts.len() - folders..].iter();
            let before = before.map(|part| part.to_string_lossy().replace(['/', '\\', ':'], ""));
            let before: Vec<String> = before.filter(|part| !part.is_empty()).collect();
            names[n] = format!("{}-{}", before.join("-"), own_name(&fields[n]));
        }
    }
    Ok(names)
}

fn own_name(field: &Path) -> String {
    let is_array = field.extension().is_none_or(|extension| extension == "npy");
    let name = match is_array {
        true => field.file_stem(),
        false => field.file_name(),
    };
    name.unwrap_or("field".as_ref())
        .to_string_lossy()
        .into_owned()
}

/// Indices of names that others have, too, or the index has; letters of both cases count as one, as on
/// some file systems.
fn clashing(names: &[String]) -> Vec<usize> {
    let lower: Vec<String> = names.iter().map(|name| name.to_lowercase()).collect();
    let mut seen: BTreeSet<&str> = [INDEX, TABLE, PAGE].into();
    let repeated: BTreeSet<&str> = lower
        .iter()
        .map(String::as_str)
        .filter(|name| !seen.insert(name))
        .collect();
    let is_repeated = |n: &usize| repeated.contains(lower[*n].as_str());
    (0..names.len()).filter(is_repeated).collect()
}

/// How many fields there are, and how many there are of each verdict in frequency: `3 fields`, `1 up, 2 unchanged`.
pub fn verdicts_in_words(rows: &[FieldRow]) -> (String, String) {
    let all = match rows.len() {
        1 => "1 field".to_owned(),
        fields => format!("{fields} fields"),
    };
    let word = |row: &FieldRow| match &row.outcome {
        FieldOutcome::Headlines(found) => found.frequency.as_ref().map(MovedShares::word),
        FieldOutcome::Failed(_) => None,
    };
    let kinds = [
        (Some("up"), "up"),
        (Some("down"), "down"),
        (Some("spreads"), "spread"),
        (Some("selective loss"), "selective loss"),
        (Some("unchanged"), "unchanged"),
        (Some("untold"), "cannot be told"),
        (None, "without a result"),
    ];
    let counted = kinds.iter().filter_map(|(kind, said)| {
        let count = rows
            .iter()
            .filter(|row| word(row).as_deref() == *kind)
            .count();
        (count > 0).then(|| format!("{count} {said}"))
    });
    (all, counted.collect::<Vec<_>>().join(", "))
}

/// Columns of the table, and where in a row of the index each has its value.
const COLUMNS: [(&str, &str); 24] = [
    ("field", "/field"),
    ("name", "/name"),
    ("times", "/headlines/times"),
    ("sites", "/headlines/sites"),
    ("frequency_unit", "/headlines/frequency/unit"),
    ("frequency_verdict", "/headlines/frequency/verdict"),
    ("frequency_up", "/headlines/frequency/up"),
    ("frequency_up_at", "/headlines/frequency/up_at"),
    ("frequency_down", "/headlines/frequency/down"),
    ("frequency_down_at", "/headlines/frequency/down_at"),
    ("frequency_transfer", "/headlines/frequency/transfer"),
    ("energy_ratio", "/headlines/energy_ratio"),
    ("from_site", "/headlines/from"),
    ("to_site", "/headlines/to"),
    ("wavenumber_unit", "/headlines/wavenumber/unit"),
    ("wavenumber_verdict", "/headlines/wavenumber/verdict"),
    ("wavenumber_up", "/headlines/wavenumber/up"),
    ("wavenumber_up_at", "/headlines/wavenumber/up_at"),
    ("wavenumber_down", "/headlines/wavenumber/down"),
    ("wavenumber_down_at", "/headlines/wavenumber/down_at"),
    ("toward_plus_x", "/headlines/toward_plus_x"),
    ("toward_minus_x", "/headlines/toward_minus_x"),
    ("warnings", "/headlines/warnings"),
    ("failure", "/failed"),
];

/// The headlines of all fields, a row for each. Numbers have all their digits; unknown values are empty.
fn records(rows: &[FieldRow]) -> Table {
    Table::of_places(&COLUMNS, rows.iter().map(|row| json!(row)))
}

/// A field by its name, and what was found of it.
type Analyzed<'a> = (&'a str, &'a Headlines);

/// Verdicts; where and how much moved; why others cannot be told. A field without a result is in none of them.
pub fn fields_tables(rows: &[FieldRow]) -> Vec<Table> {
    let analyzed = rows.iter().filter_map(|row| match &row.outcome {
        FieldOutcome::Headlines(found) => Some((row.name.as_str(), &**found)),
        FieldOutcome::Failed(_) => None,
    });
    let analyzed: Vec<Analyzed> = analyzed.collect();
    if analyzed.is_empty() {
        return Vec::new();
    }
    let name = (
        "field",
        (|(name, _)| Some((*name).into())) as Cell<Analyzed>,
    );
    let verdicts: [(&str, Cell<Analyzed>); 7] = [
        name,
        ("in frequency", |(_, of)| {
            Some(of.frequency.as_ref()?.word())
        }),
        ("up", |(_, of)| share(of.frequency.as_ref()?.up)),
        ("down", |(_, of)| share(of.frequency.as_ref()?.down)),
        ("in wavenumber", |(_, of)| {
            Some(of.wavenumber.as_ref()?.word())
        }),
        ("up", |(_, of)| share(of.wavenumber.as_ref()?.up)),
        ("down", |(_, of)| share(of.wavenumber.as_ref()?.down)),
    ];
    let places: [(&str, Cell<Analyzed>); 10] = [
        name,
        ("up past", |(_, of)| place(of, |moved| moved.up_at)),
        ("down below", |(_, of)| place(of, |moved| moved.down_at)),
        ("energy", |(_, of)| of.energy_ratio.map(number)),
        ("from site", |(_, of)| of.from.map(|site| site.to_string())),
        ("to", |(_, of)| of.to.map(|site| site.to_string())),
        ("to +x", |(_, of)| share(of.toward_plus_x)),
        ("to -x", |(_, of)| share(of.toward_minus_x)),
        ("size", |(_, of)| {
            Some(format!("{} x {}", of.times, of.sites))
        }),
        ("warnings", |(_, of)| Some(of.warnings.to_string())),
    ];
    let reasons: [(&str, Cell<Analyzed>); 3] = [
        name,
        ("in frequency", |(_, of)| {
            of.frequency.as_ref()?.reason.clone()
        }),
        ("in wavenumber", |(_, of)| {
            of.wavenumber.as_ref()?.reason.clone()
        }),
    ];
    let title = "Verdicts, and the shares of energy that moved up and down";
    let mut tables = vec![
        Table::of_columns(title, &analyzed, &verdicts).printed(),
        Table::of_columns("Where it moved, energy, direction", &analyzed, &places).printed(),
        Table::of_columns("What cannot be told, and why", &analyzed, &reasons),
    ];
    // Names alone say nothing.
    tables.retain(|table| table.head.len() > 1);
    tables
}

fn share(share: Option<f64>) -> Option<String> {
    Some(format!("{:.1} %", 100.0 * share?))
}

/// A frequency, with its unit if it has one.
fn place(of: &Headlines, at: fn(&MovedShares) -> Option<f64>) -> Option<String> {
    let moved = of.frequency.as_ref()?;
    let unit = match moved.unit.starts_with("cycles") {
        true => "",
        false => &moved.unit,
    };
    Some(with_unit(at(moved)?, unit))
}
