//! The rows of a table, none of them longer than a bound.

use std::borrow::Cow;
use std::io::Read;

use csv::{ByteRecord, ReaderBuilder};

use super::open::FileSource;
use super::preamble::check_commas;
use super::stamp::Stamp;
use crate::error::Fault;

/// Bytes of one row, line ends in quotes included.
const ROW_LIMIT: usize = 16 << 20;

const BOM: &[u8] = b"\xef\xbb\xbf";

pub(super) struct RowReader<'a> {
    dialect: Dialect,
    /// Cells before those of the table.
    left_out: usize,
    reader: csv::Reader<TextCells<'a>>,
}

/// How a table writes cells and numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Dialect {
    delimiter: u8,
    /// Whether commas are decimal signs.
    has_decimal_commas: bool,
}

impl<'a> RowReader<'a> {
    pub(super) fn new(source: &'a FileSource) -> Result<RowReader<'a>, Fault> {
        let bytes = &source.bytes[..];
        let sample = &bytes[..bytes.len().min(1 << 16)];
        let found = match sample.starts_with(b"\xff\xfe") || sample.starts_with(b"\xfe\xff") {
            true => Some("UTF-16"),
            false => sample.contains(&0).then_some("binary data"),
        };
        if let Some(found) = found {
            let advice = "save the table as plain UTF-8 text";
            return Err(Fault::expected("text in UTF-8", found, advice));
        }
        let start = if sample.starts_with(BOM) {
            BOM.len()
        } else {
            0
        };
        let is_tsv = source.path.extension().is_some_and(|found| found == "tsv");
        let dialect = detect(&sample[start..], is_tsv);
        let delimiter = dialect.delimiter;
        if delimiter == b',' {
            check_commas(&sample[start..])?;
        }
        let text = TextCells {
            text: bytes,
            at: start,
            allowance: ROW_LIMIT,
            fold_blanks: delimiter == b' ',
            last: b'\n',
            last_is_return: false,
            blank: false,
        };
        let reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .delimiter(delimiter)
            .from_reader(text);
        Ok(RowReader {
            dialect,
            left_out: 0,
            reader,
        })
    }

    /// What separates the cells.
    pub(super) fn delimiter(&self) -> u8 {
        self.dialect.delimiter
    }

    /// Whether commas are decimal signs.
    pub(super) fn has_decimal_commas(&self) -> bool {
        self.dialect.has_decimal_commas
    }

    /// Leaves so many cells out of every row from now on, of `record` too.
    pub(super) fn leave_out(&mut self, cells: usize, record: &mut ByteRecord) {
        self.left_out = cells;
        self.cut(record);
    }

    fn cut(&self, record: &mut ByteRecord) {
        let cells = record.iter().skip(self.left_out);
        let cells = cells.map(|cell| match self.dialect.has_decimal_commas {
            true => with_point(cell),
            false => Cow::Borrowed(cell),
        });
        let mut kept: ByteRecord = cells.collect();
        kept.set_position(record.position().cloned());
        *record = kept;
    }

    /// Whether there was another row.
    pub(super) fn next(&mut self, record: &mut ByteRecord) -> Result<bool, Fault> {
        self.reader.get_mut().allowance = ROW_LIMIT;
        let line = self.reader.position().line();
        let read = self.reader.read_byte_record(record);
        let read = read.map_err(|_| {
            let line = line_of_row(self.reader.get_ref().text, line);
            let expected = format!("line {line}: expected a row of at most {ROW_LIMIT} bytes");
            let advice = "check the line ends and quotes, or save the table as `.npy`";
            Fault::new(expected + ", found a longer one", advice)
        })?;
        if self.left_out > 0 || self.dialect.has_decimal_commas {
            self.cut(record);
        }
        Ok(read)
    }
}

/// The line, counted from 1, of the first row that starts on `line` or later.
pub(super) fn line_of_row(text: &[u8], line: u64) -> u64 {
    let end = if text.contains(&b'\n') { b'\n' } else { b'\r' };
    let is_row = |line: &[u8]| {
        let line = line.trim_ascii();
        !line.is_empty() && !line.starts_with(b"#")
    };
    let lines = (1u64..).zip(text.split(|&byte| byte == end));
    let mut rows = lines.filter(|(number, text)| *number >= line && is_row(text));
    rows.next().map_or(line, |(number, _)| number)
}

/// Told by the last lines of numbers, since others may stand before them.
fn detect(sample: &[u8], is_tsv: bool) -> Dialect {
    /// Lines that are looked at.
    const MOST: usize = 64;
    let lines = sample.split(|byte| matches!(byte, b'\n' | b'\r'));
    let lines = lines.map(<[u8]>::trim_ascii);
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with(b"#"));
    let lines: Vec<&[u8]> = lines.collect();
    let last = || lines.iter().rev().take(MOST);
    let told = last().find_map(|line| {
        let is_it = |delimiter: &&u8| cells(line, **delimiter).is_some_and(|n| n > 1);
        b";\t, ".iter().find(is_it)
    });
    let second = lines.iter().take(2).next_back();
    let is_contained = |delimiter: &&u8| second.is_some_and(|line| line.contains(delimiter));
    let contained = || b";,\t ".iter().find(is_contained);
    let delimiter = match is_tsv {
        true => b'\t',
        false => told.or_else(contained).copied().unwrap_or(b','),
    };
    let numbers = last().filter(|line| cells(line, delimiter).is_some());
    let has_commas = delimiter != b',' && numbers.clone().any(|line| line.contains(&b','));
    // Points within dates are none of numbers.
    let has_point = |cell: &[u8]| super::csv::number(cell).is_some() && cell.contains(&b'.');
    let mut cells = numbers.flat_map(|line| line.split(|&byte| byte == delimiter));
    Dialect {
        delimiter,
        has_decimal_commas: has_commas && !cells.any(has_point),
    }
}

/// How many cells of numbers a line has; none if one of them is something else, or all are empty.
fn cells(line: &[u8], delimiter: u8) -> Option<usize> {
    let (mut count, mut filled) = (0, 0);
    for cell in line.split(|&byte| byte == delimiter || delimiter == b' ' && byte == b'\t') {
        let cell = cell.trim_ascii();
        let quoted = cell
            .strip_prefix(b"\"")
            .and_then(|cell| cell.strip_suffix(b"\""));
        let cell = with_point(quoted.unwrap_or(cell).trim_ascii());
        if cell.is_empty() && delimiter == b' ' {
            continue;
        }
        count += 1;
        filled += usize::from(!cell.is_empty());
        if super::csv::number(&cell).is_none() {
            Stamp::parse(&cell)?;
        }
    }
    (filled > 0).then_some(count)
}

/// A number whose decimal sign is a comma, with a point; other cells as they are.
pub(super) fn with_point(cell: &[u8]) -> Cow<'_, [u8]> {
    let is_part = |byte: &u8| byte.is_ascii_digit() || b"+-eE, ".contains(byte);
    let mut commas = (0..cell.len()).filter(|&at| cell[at] == b',');
    match (commas.next(), commas.next()) {
        (Some(at), None) if cell.iter().all(is_part) => {
            let mut cell = cell.to_vec();
            cell[at] = b'.';
            Cow::Owned(cell)
        }
        _ => Cow::Borrowed(cell),
    }
}

/// The text of a file, as far as a row is allowed to reach, with `\n` for every line end.
///
/// The only error of [`Read::read`] is that the row is longer.
struct TextCells<'a> {
    text: &'a [u8],
    at: usize,
    allowance: usize,
    /// Whether runs of blanks become one, and those at the ends of a line none.
    fold_blanks: bool,
    last: u8,
    last_is_return: bool,
    blank: bool,
}

impl Read for TextCells<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        loop {
            let text = self.text;
            let rest = &text[self.at..];
            // A comment is one only once its line has ended.
            if rest.is_empty() && self.last != b'\n' && !out.is_empty() {
                (out[0], self.last) = (b'\n', b'\n');
                return Ok(1);
            }
            let taken = &rest[..rest.len().min(out.len() / 2).min(self.allowance)];
            if taken.is_empty() && !rest.is_empty() {
                return Err(std::io::ErrorKind::InvalidData.into());
            }
            self.at += taken.len();
            self.allowance -= taken.len();
            let n = self.normalize(taken, out);
            if n > 0 || taken.is_empty() {
                return Ok(n);
            }
        }
    }
}

impl TextCells<'_> {
    /// Writes at most two bytes for each of `text`; returns the number written.
    fn normalize(&mut self, text: &[u8], out: &mut [u8]) -> usize {
        let mut n = 0;
        for &byte in text {
            let follows_return = std::mem::replace(&mut self.last_is_return, byte == b'\r');
            let byte = match byte {
                b'\n' if follows_return => continue,
                b'\r' => b'\n',
                b' ' | b'\t' if self.fold_blanks => {
                    self.blank = true;
                    continue;
                }
                byte => byte,
            };
            if self.blank && self.last != b'\n' && byte != b'\n' {
                out[n] = b' ';
                n += 1;
            }
            out[n] = byte;
            n += 1;
            (self.last, self.blank) = (byte, false);
        }
        n
    }
}
