//! The names of a table's columns: in its first line, or in a comment before its rows.

use csv::ByteRecord;

use super::Layout;
use super::csv::{number, printed_unit};
use super::names::row_unit;
use super::options::{Header, TimeColumn};
use super::preamble::{is_setting, length};
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
    let Some(others) = others.filter(|others| is_empty && others.len() > 2) else {
        return false;
    };
    let step = (others[others.len() - 1] - others[0]) / (others.len() - 1) as f64;
    let is_even = |pair: &[f64]| (pair[1] - pair[0] - step).abs() <= 1e-6 * step;
    others.windows(2).all(is_even) && step > 0.0
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
    let lines = text.split(|&byte| matches!(byte, b'\n' | b'\r'));
    let lines = lines.map(|line| {
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
        line.trim_ascii()
    });
    let preamble = lines.take_while(|line| line.is_empty() || line.starts_with(b"#"));
    let comments = preamble.filter_map(|line| line.strip_prefix(b"#"));
    let named = comments.filter_map(|line| names(&String::from_utf8_lossy(line), width));
    let states = |(names, is_prose): &(ByteRecord, bool)| {
        let is_meant = |name: &[u8]| {
            let name = String::from_utf8_lossy(name);
            match asked {
                TimeColumn::Name(asked) => name.trim() == asked.trim(),
                _ => row_unit(&name, layout).is_some(),
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
    let blank = || Some(text.split_whitespace().collect()).filter(fits);
    match delimited {
        Some(names) => Some((ByteRecord::from(names), false)),
        None => blank().map(|names| (ByteRecord::from(names), true)),
    }
}

/// The numbers in these columns of a header that holds only numbers there, and their rounding.
pub(super) fn labels(header: &ByteRecord, columns: &[usize]) -> Option<(Vec<f64>, f64)> {
    let cells = || columns.iter().filter_map(|&column| header.get(column));
    let values: Option<Vec<f64>> = cells()
        .map(|cell| number(cell).filter(|value| value.is_finite()))
        .collect();
    Some((
        values?,
        cells().map(printed_unit).fold(f64::INFINITY, f64::min),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_starts_with_a_word_or_holds_no_number() {
        let detected =
            |cells: &[&str]| is_header(Header::Detect, &ByteRecord::from(cells.to_vec()));
        assert!(detected(&["time", "0.0", "0.5"]));
        assert!(detected(&["", "v1", "v2"]));
        assert!(detected(&["(1)", "(2)"]));
        assert!(!detected(&["1.0x", "2.0"]));
        assert!(!detected(&["1.0", "v2"]));
        assert!(!detected(&["nan", ""]));
        assert!(detected(&["v1"]) && detected(&["(1)"]) && detected(&["e (m/s)"]));
        for damaged in ["1.0x", "q.250", "-0.1.2", "x12.5e-3"] {
            assert!(!detected(&[damaged]), "{damaged}");
        }
    }

    #[test]
    fn a_comment_names_columns_if_it_names_coordinates() {
        let found = |text: &str, width| {
            let names = of_comments(
                text.as_bytes(),
                width,
                Layout::TimeSite,
                &TimeColumn::Detect,
            );
            names.map(|names| {
                names
                    .iter()
                    .map(<[u8]>::to_vec)
                    .collect::<Vec<_>>()
                    .concat()
            })
        };
        for text in [
            "# time,x0,x1\n0,1,2\n",
            "# run 5\n# time x0 x1\n# of three\n0 1 2\n",
            "\u{feff}#time; x0; x1\r\n\r\n0,1,2\n",
            "#\ttime\tx0\tx1\n# s, m, m\n0 1 2\n",
        ] {
            assert_eq!(found(text, 3), Some(b"timex0x1".to_vec()), "{text:?}");
        }
        for text in [
            "# velocity over time\n0,1,2\n",
            "# time,x0\n0,1,2\n",
            "# x0,x1,x2\n0,1,2\n",
            "0,1,2\n# time,x0,x1\n3,4,5\n",
        ] {
            assert_eq!(found(text, 3), None, "{text:?}");
        }
    }
}
