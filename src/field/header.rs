//! The names of a table's columns: in its first line, or in a comment before its rows.

use csv::ByteRecord;

use super::Layout;
use super::coordinates::Coordinates;
use super::csv::{number, row_meaning};
use super::meaning::known_as;
use super::options::{Header, TimeColumn};
use super::preamble::{comments, is_setting, length};
use super::rows::RowReader;

/// Whether a first line names columns: it starts with a word, or holds no number at all. The only
/// cell of a line is no name if it reads like a number that was damaged.
pub(super) fn is_header(stated: Header, record: &ByteRecord) -> bool {
    let is_text = |cell: &[u8]| number(cell).is_none();
    let is_number = |cell: &[u8]| number(cell).is_some_and(|value| !value.is_nan());
    let is_word = |cell: &[u8]| is_text(cell) && cell.trim_ascii()[0].is_ascii_alphabetic();
    match stated {
        Header::Present => true,
        Header::Absent => false,
        Header::Detect if record.len() == 1 && is_damaged(&record[0]) => false,
        Header::Detect => {
            is_word(&record[0])
                || record.iter().any(is_text) && !record.iter().any(is_number)
                || lists_coordinates(record)
        }
    }
}

/// Whether a line has nothing in its first cell, the corner of a table with an index, and even coordinates in the others,
/// as `DataFrame.to_csv` of pandas writes them.
fn lists_coordinates(record: &ByteRecord) -> bool {
    let corner = record[0].trim_ascii();
    let is_empty = corner.is_empty() || corner.eq_ignore_ascii_case(b"nan");
    let others: Option<Vec<f64>> = record.iter().skip(1).map(number).collect();
    let others = others.filter(|others| is_empty && others.len() > 2);
    others.is_some_and(|others| Coordinates::fit(&others, 0.0).is_ok())
}

/// Whether a cell is no number but begins like one, or is one with a decimal point but for its first
/// character.
fn is_damaged(cell: &[u8]) -> bool {
    let text = String::from_utf8_lossy(cell.trim_ascii());
    let mut characters = text.chars();
    let Some(first) = characters.next() else {
        return false;
    };
    let rest = characters.as_str();
    let begins = first.is_ascii_digit() || "+-.".contains(first);
    let but_for_it = || rest.contains('.') && number(rest.as_bytes()).is_some();
    number(cell).is_none() && (begins || but_for_it())
}

/// A line as the names of the columns of a row. Their delimiter may differ from that of the numbers:
/// `time,x0,x1` before `0.0 1.0 2.0`. Cells behind the last name are left out where the row has none there
/// either. Unchanged if no delimiter gives as many names.
pub(super) fn of_line(line: ByteRecord, rows: &RowReader, row: &ByteRecord) -> ByteRecord {
    let (named, filled) = (length(&line, is_setting), length(row, |_| false));
    if filled <= named && named <= row.len() {
        return line.iter().take(named).collect();
    }
    if line.len() == row.len() {
        return line;
    }
    let delimiter = char::from(rows.delimiter()).to_string();
    let cells: Vec<_> = line.iter().map(String::from_utf8_lossy).collect();
    let names = names(&cells.join(&delimiter), row.len());
    names.map_or(line, |(names, _)| names)
}

/// The names of `width` columns in the last comment before the rows that holds them, as
/// `numpy.savetxt(..., header="time,x0,x1")` writes it.
///
/// A comment holds names if one of them is the requested one, or names coordinates of the rows.
/// Names separated by blanks may be prose, so there only the first may do so.
pub(super) fn of_comments(
    text: &[u8],
    width: usize,
    layout: Layout,
    asked: &TimeColumn,
) -> Option<ByteRecord> {
    let named = comments(text).filter_map(|line| names(&String::from_utf8_lossy(line), width));
    let states = |(names, is_prose): &(ByteRecord, bool)| {
        let is_meant = |name: &[u8]| {
            let name = String::from_utf8_lossy(name);
            match asked {
                TimeColumn::Name(asked) => name.trim() == asked.trim(),
                _ => known_as(&name, row_meaning(layout)).is_some(),
            }
        };
        let looked_at = if *is_prose { 1 } else { names.len() };
        names.iter().take(looked_at).any(is_meant)
    };
    named.filter(states).last().map(|(names, _)| names)
}

/// `width` names by the first delimiter that gives this number, and whether blanks separate them.
fn names(text: &str, width: usize) -> Option<(ByteRecord, bool)> {
    let by = |delimiter: char| -> Vec<&str> { text.split(delimiter).map(str::trim).collect() };
    let fits = |names: &Vec<&str>| names.len() == width;
    let delimited = [',', ';', '\t'].into_iter().map(by).find(fits);
    let is_prose = delimited.is_none();
    let blank = || Some(text.split_whitespace().collect()).filter(fits);
    Some((ByteRecord::from(delimited.or_else(blank)?), is_prose))
}
