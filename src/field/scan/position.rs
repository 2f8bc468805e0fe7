//! Where each file of a scan was recorded.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::super::csv::{number, printed_unit};
use super::super::meaning::{Meaning, known_as};
use super::super::open::header_numbers;
use super::super::options::OpenOptions;
use super::PositionFrom;
use crate::error::{Error, Fault, Result};
use crate::measure::{self, Length};

/// One position a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Positions {
    pub(super) values: Vec<f64>,
    pub(super) unit: Option<String>,
    /// What the last digit counts.
    pub(super) rounding: f64,
}

/// A number of a file that may be its position.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct NamedNumber {
    pub(in super::super) name: String,
    pub(in super::super) value: f64,
    pub(in super::super) unit: Option<String>,
    pub(in super::super) rounding: f64,
}

/// The positions of `paths`, in their order.
pub(super) fn of(
    from: &PositionFrom,
    paths: &[PathBuf],
    options: &OpenOptions,
) -> Result<Positions> {
    match from {
        PositionFrom::Name(asked) => {
            varying("the names", asked.as_deref(), paths, &in_names(paths)?)
        }
        // What is asked of a header is all that is read.
        PositionFrom::Header(asked) => {
            let numbers = |path| header_numbers(path, options, asked.as_deref());
            let lists = paths.iter().map(|path| numbers(path.as_path()));
            varying(
                "the headers",
                None,
                paths,
                &lists.collect::<Result<Vec<_>>>()?,
            )
        }
        PositionFrom::Table(table) => of_table(table, paths),
    }
}

/// The numbers of one name that differ from file to file.
fn varying(
    place: &'static str,
    asked: Option<&str>,
    paths: &[PathBuf],
    lists: &[Vec<NamedNumber>],
) -> Result<Positions> {
    let first = lists.first().map_or(&[][..], |first| first);
    let in_all = |one: &NamedNumber| -> Option<Vec<NamedNumber>> {
        let of =
            |list: &Vec<NamedNumber>| list.iter().find(|other| other.name == one.name).cloned();
        lists.iter().map(of).collect()
    };
    let differ = |series: &Vec<NamedNumber>| series.iter().any(|one| one.value != series[0].value);
    let is_asked = |one: &&NamedNumber| asked.is_none_or(|name| one.name == name);
    let mut found: Vec<Vec<NamedNumber>> = Vec::new();
    let candidates = first.iter().filter(is_asked).filter_map(in_all);
    for series in candidates.filter(differ) {
        let is_same = |known: &Vec<NamedNumber>| {
            let mut pairs = known.iter().zip(&series);
            pairs.all(|(a, b)| (a.value, &a.unit) == (b.value, &b.unit))
        };
        if !found.iter().any(is_same) {
            found.push(series);
        }
    }
    let (found, advice): (Vec<String>, _) = match &found[..] {
        [only] => return in_one_unit(paths, only),
        [] => {
            let all = first.iter();
            let all = all.map(|one| format!("{} {}", one.name, one.value));
            (all.collect(), IN_TABLE)
        }
        several => {
            let range = |series: &Vec<NamedNumber>| {
                let values = || series.iter().map(|one| one.value);
                let (least, most) = (values().reduce(f64::min), values().reduce(f64::max));
                let [least, most] = [least, most].map(|end| end.unwrap_or(f64::NAN));
                let unit = series[0].unit.as_deref().unwrap_or_default();
                format!("{:?} ({least} to {most}{unit})", series[0].name)
            };
            let advice = match place {
                "the names" => {
                    "name the letters before the position, such as `--position-from name:x`"
                }
                _ => "name the position, such as `--position-from header:x`",
            };
            (several.iter().map(range).collect(), advice)
        }
    };
    let expected = format!("one number in {place} that differs from file to file");
    let found = match found.is_empty() {
        true => "none".into(),
        false => found.join(", "),
    };
    Err(misfit(&paths[0], Fault::expected(expected, found, advice)))
}

/// The values in the unit of the first one.
fn in_one_unit(paths: &[PathBuf], series: &[NamedNumber]) -> Result<Positions> {
    let unit = series[0].unit.clone();
    let mut values = Vec::with_capacity(series.len());
    for (one, path) in series.iter().zip(paths) {
        let named =
            |unit: &Option<String>| unit.clone().unwrap_or("a number without a unit".into());
        let factor = factor(one.unit.as_deref(), unit.as_deref()).ok_or_else(|| {
            let expected = format!("a position in {}", named(&unit));
            fault_of(path, Fault::expected(expected, named(&one.unit), ""))
        })?;
        values.push(one.value * factor);
    }
    let rounding = series.iter().map(|one| one.rounding);
    Ok(Positions {
        values,
        unit,
        rounding: rounding.fold(f64::INFINITY, f64::min),
    })
}

/// By what a length in `from` is multiplied to be one in `to`.
pub(super) fn factor(from: Option<&str>, to: Option<&str>) -> Option<f64> {
    if from == to {
        return Some(1.0);
    }
    Some(measure::size::<Length>(from?)? / measure::size::<Length>(to?)?)
}

const IN_TABLE: &str =
    "list the positions in a table with the columns file and position: `--position-from table.csv`";

/// The fault of a file of a scan.
pub(super) fn fault_of(path: &Path, fault: Fault) -> Error {
    Error::input(path)(fault)
}

/// The same where the request is at fault.
pub(super) fn misfit(path: &Path, fault: Fault) -> Error {
    Error::Scan {
        path: path.to_owned(),
        fault,
    }
}

/// The numbers in the names of files, without their extensions.
fn in_names(paths: &[PathBuf]) -> Result<Vec<Vec<NamedNumber>>> {
    let name = |path: &PathBuf| {
        path.file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let all = paths.iter().map(|path| numbers_in(&name(path)));
    let (skeletons, lists): (Vec<_>, Vec<_>) = all.unzip();
    match skeletons.iter().position(|other| *other != skeletons[0]) {
        None => Ok(lists),
        Some(odd) => {
            let expected = format!("the numbers of {} in its name", paths[0].display());
            let fault = Fault::expected(expected, "another text around them", IN_TABLE);
            Err(misfit(&paths[odd], fault))
        }
    }
}

/// The text around the numbers of a name, and the numbers.
///
/// A sign counts behind `=`, `_`, `(`, a blank and at the beginning, an exponent where digits follow it. A
/// number is called by the letters before it, or by its place from 1.
fn numbers_in(name: &str) -> (Vec<String>, Vec<NamedNumber>) {
    let (mut texts, mut numbers) = (vec![String::new()], Vec::<NamedNumber>::new());
    let mut rest = name;
    while let Some(next) = rest.chars().next() {
        let before = texts.last().and_then(|text| text.chars().last());
        let may_be_signed = before.is_none_or(|c| matches!(c, '=' | '_' | '(' | ' '));
        let len = number_len(rest, may_be_signed);
        if len == 0 {
            texts.last_mut().expect("one text").push(next);
            rest = &rest[next.len_utf8()..];
            continue;
        }
        let (text, after) = rest.split_at(len);
        let is_between = |c: char| !c.is_alphabetic();
        let unit = &after[..after.find(is_between).unwrap_or(after.len())];
        let before = texts.last().map(|text| text.trim_end_matches(is_between));
        let label = before.and_then(|text| text.rsplit(is_between).next());
        let label = label.unwrap_or_default().to_owned();
        let is_taken = label.is_empty() || numbers.iter().any(|one| one.name == label);
        numbers.push(NamedNumber {
            name: match is_taken {
                true => (numbers.len() + 1).to_string(),
                false => label,
            },
            value: text.parse().unwrap_or(f64::NAN),
            unit: measure::symbol::<Length>(unit).map(str::to_owned),
            rounding: printed_unit(text.as_bytes()),
        });
        texts.push(String::new());
        rest = after;
    }
    (texts, numbers)
}

/// How many bytes of `text` are a number at its beginning: the longest part that reads as one and has digits at both ends.
fn number_len(text: &str, may_be_signed: bool) -> usize {
    let is_part = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
    let end = text.find(|c| !is_part(c)).unwrap_or(text.len());
    let is_number = |len: &usize| {
        let part = &text[..*len];
        let unsigned = match may_be_signed {
            true => part.strip_prefix(['+', '-']).unwrap_or(part),
            false => part,
        };
        let is_digit = |c: char| c.is_ascii_digit();
        unsigned.starts_with(is_digit) && part.ends_with(is_digit) && part.parse::<f64>().is_ok()
    };
    (1..=end).rev().find(is_number).unwrap_or(0)
}

/// The positions in a table with a column of files and one of positions, with a header.
fn of_table(table: &Path, paths: &[PathBuf]) -> Result<Positions> {
    let bytes = std::fs::read(table).map_err(Error::read("read", table))?;
    let unfit = |expected: &str, found: String| Error::Unfit {
        path: table.to_owned(),
        expected: expected.into(),
        found,
    };
    let first = bytes.split(|&b| b == b'\n').next().unwrap_or_default();
    let delimiter = b"\t;,".iter().find(|delimiter| first.contains(delimiter));
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter.copied().unwrap_or(b','))
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(&bytes[..]);
    let parse = |error: csv::Error| unfit("a table of files and positions", error.to_string());
    let header = reader.headers().map_err(parse)?.clone();
    let cells: Vec<&str> = header.iter().collect();
    let unit = match cells[..] {
        [file, name] if file.to_ascii_lowercase().starts_with("file") => {
            known_as(name, Meaning::Position)
        }
        _ => None,
    };
    let columns =
        "a header with the columns `file` and `position`, with its unit such as position_mm";
    let unit = unit.ok_or_else(|| unfit(columns, cells.join(", ")))?;
    let mut rows: HashMap<String, (f64, f64)> = HashMap::new();
    for record in reader.records() {
        let record = record.map_err(parse)?;
        let cell = record[1].as_bytes();
        let value = number(cell).filter(|value| value.is_finite());
        let value =
            value.ok_or_else(|| unfit("a number as position", format!("{:?}", &record[1])))?;
        let before = rows.insert(record[0].to_owned(), (value, printed_unit(cell)));
        if before.is_some() {
            return Err(unfit("each file once", format!("{:?} twice", &record[0])));
        }
    }
    let row = |path: &PathBuf| {
        // By the whole path, else by its last part.
        let last = path.file_name().unwrap_or_default();
        let row = rows.get(&*path.to_string_lossy());
        let row = row.or_else(|| rows.get(&*last.to_string_lossy())).copied();
        row.ok_or_else(|| {
            let expected = format!("a position in {}", table.display());
            let advice = "add a row for it, with its path as typed or its last part";
            misfit(path, Fault::expected(expected, "none", advice))
        })
    };
    let found = paths.iter().map(row).collect::<Result<Vec<_>>>()?;
    let (values, roundings): (Vec<f64>, Vec<f64>) = found.into_iter().unzip();
    Ok(Positions {
        values,
        unit,
        rounding: roundings.into_iter().fold(f64::INFINITY, f64::min),
    })
}
