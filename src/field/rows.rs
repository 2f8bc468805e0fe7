//! The rows of a table, none of them longer than a bound.

use std::io::Read;

use csv::{ByteRecord, ReaderBuilder};

use super::open::FileSource;
use crate::error::InputFault;

/// Bytes of one row, line ends in quotes included.
const ROW_LIMIT: usize = 16 << 20;

const BOM: &[u8] = b"\xef\xbb\xbf";

pub(super) struct RowReader<'a> {
    delimiter: u8,
    reader: csv::Reader<TextCells<'a>>,
}

impl<'a> RowReader<'a> {
    pub(super) fn new(source: &'a FileSource) -> std::result::Result<RowReader<'a>, InputFault> {
        let bytes = &source.bytes[..];
        let sample = &bytes[..bytes.len().min(1 << 16)];
        if sample.starts_with(b"\xff\xfe") || sample.starts_with(b"\xfe\xff") {
            return Err(InputFault::Encoding { found: "UTF-16" });
        }
        if sample.contains(&0) {
            return Err(InputFault::Encoding {
                found: "binary data",
            });
        }
        let start = if sample.starts_with(BOM) {
            BOM.len()
        } else {
            0
        };
        let is_tsv = source
            .path
            .extension()
            .is_some_and(|extension| extension == "tsv");
        let delimiter = if is_tsv {
            b'\t'
        } else {
            detect_delimiter(&sample[start..])
        };
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
        Ok(RowReader { delimiter, reader })
    }

    /// What separates the cells.
    pub(super) fn delimiter(&self) -> u8 {
        self.delimiter
    }

    /// Whether there was another row.
    pub(super) fn next(
        &mut self,
        record: &mut ByteRecord,
    ) -> std::result::Result<bool, InputFault> {
        self.reader.get_mut().allowance = ROW_LIMIT;
        let line = self.reader.position().line();
        let read = self.reader.read_byte_record(record);
        read.map_err(|_| InputFault::RowLength {
            line: line_of_row(self.reader.get_ref().text, line),
            limit: ROW_LIMIT,
        })
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

/// Detected in the second line, since the first may be a header; else in the first.
fn detect_delimiter(sample: &[u8]) -> u8 {
    let lines = sample.split(|byte| matches!(byte, b'\n' | b'\r'));
    let line = lines
        .map(<[u8]>::trim_ascii)
        .filter(|line| !line.is_empty() && !line.starts_with(b"#"))
        .take(2)
        .last()
        .unwrap_or_default();
    let is_there = |delimiter: &u8| line.contains(delimiter);
    *b";,\t "
        .iter()
        .find(|delimiter| is_there(delimiter))
        .unwrap_or(&b',')
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_delimiter_is_told_by_the_numbers() {
        for (text, delimiter) in [
            ("time (s), v (m/s)\n0,1\n", b','),
            ("time (s)\n0\n", b','),
            ("# 1;2;3\n\n0.5\t1\n", b'\t'),
            ("a b\n1;2\n", b';'),
            ("  0.5   1.5  \n", b' '),
        ] {
            assert_eq!(detect_delimiter(text.as_bytes()), delimiter, "{text:?}");
        }
    }

    #[test]
    fn a_row_is_found_behind_blank_lines_and_comments() {
        for end in ["\n", "\r\n", "\r"] {
            let text = ["1", "", "# note", "2", "3"].join(end);
            let found: Vec<u64> = (1..=5)
                .map(|line| line_of_row(text.as_bytes(), line))
                .collect();
            assert_eq!(found, [1, 4, 4, 4, 5], "{end:?}");
        }
    }
}
