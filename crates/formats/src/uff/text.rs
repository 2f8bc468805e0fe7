//! Lines and columns of universal files.

use crate::{Error, Result};

/// Goes through the lines of a file, which may hold binary data between them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lines<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
}

impl<'a> Lines<'a> {
    /// The next line without its end; none at the end of the file.
    pub(super) fn next(&mut self) -> Option<&'a [u8]> {
        let left = self.bytes.get(self.at..).filter(|left| !left.is_empty())?;
        let end = left.iter().position(|&byte| byte == b'\n');
        self.at += end.map_or(left.len(), |end| end + 1);
        let line = &left[..end.unwrap_or(left.len())];
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// The next line, which the data set must have.
    pub(super) fn expect(&mut self, what: &str) -> Result<&'a [u8]> {
        let at = self.at;
        let end = || Error::damaged(format!("byte {at}"), what, "the end of the file");
        self.next().ok_or_else(end)
    }
}

/// Whether a line begins or ends a data set.
pub(super) fn is_delimiter(line: &[u8]) -> bool {
    line.trim_ascii() == b"-1"
}

/// The columns `from..to`, without blanks around, as far as the line has them.
pub(super) fn columns(line: &[u8], from: usize, to: usize) -> &[u8] {
    let to = to.min(line.len());
    line.get(from..to).unwrap_or_default().trim_ascii()
}

/// The text of columns; empty for `NONE`.
pub(super) fn label(line: &[u8], from: usize, to: usize) -> String {
    let text = String::from_utf8_lossy(columns(line, from, to)).into_owned();
    if text == "NONE" { String::new() } else { text }
}

/// An integer; 0 for blanks.
pub(super) fn integer(line: &[u8], from: usize, to: usize, place: usize) -> Result<i64> {
    let found = columns(line, from, to);
    let text = std::str::from_utf8(found).ok();
    match text {
        Some("") => Ok(0),
        text => text
            .and_then(|text| text.parse().ok())
            .ok_or_else(|| wrong(found, "an integer", place)),
    }
}

/// A float, also with the exponent letter D of Fortran; 0 for blanks.
pub(super) fn float(line: &[u8], from: usize, to: usize, place: usize) -> Result<f64> {
    let found = columns(line, from, to);
    if found.is_empty() {
        return Ok(0.0);
    }
    let text = std::str::from_utf8(found).ok();
    let parsed = text.and_then(|text| match text.parse() {
        Ok(value) => Some(value),
        Err(_) => text.replace(['D', 'd'], "E").parse().ok(),
    });
    parsed.ok_or_else(|| wrong(found, "a number", place))
}

fn wrong(found: &[u8], expected: &str, place: usize) -> Error {
    let found = String::from_utf8_lossy(found).into_owned();
    Error::damaged(format!("the line at byte {place}"), expected, found)
}
