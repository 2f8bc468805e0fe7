//! Lines and columns of universal files.

use crate::{Error, Result};

/// Goes through the lines of a file, which may hold binary data between them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lines<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
}

/// A line without its end, and its first byte.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    pub text: &'a [u8],
    at: usize,
}

impl<'a> Lines<'a> {
    /// The next line; none at the end of the file.
    pub(super) fn next(&mut self) -> Option<Line<'a>> {
        let at = self.at;
        let left = self.bytes.get(at..).filter(|left| !left.is_empty())?;
        let end = left.iter().position(|&byte| byte == b'\n');
        self.at += end.map_or(left.len(), |end| end + 1);
        let text = &left[..end.unwrap_or(left.len())];
        let text = text.strip_suffix(b"\r").unwrap_or(text);
        Some(Line { text, at })
    }

    /// The next line, which the data set must have.
    pub(super) fn expect(&mut self, what: &str) -> Result<Line<'a>> {
        let at = self.at;
        let end = || Error::damaged(format!("byte {at}"), what, "the end of the file");
        self.next().ok_or_else(end)
    }
}

impl<'a> Line<'a> {
    /// Whether it begins or ends a data set.
    pub(super) fn is_delimiter(self) -> bool {
        self.text.trim_ascii() == b"-1"
    }

    /// The columns `from..to`, without blanks around, as far as the line has them.
    pub(super) fn columns(self, from: usize, to: usize) -> &'a [u8] {
        let to = to.min(self.text.len());
        self.text.get(from..to).unwrap_or_default().trim_ascii()
    }

    /// The text of columns; empty for `NONE`.
    pub(super) fn label(self, from: usize, to: usize) -> String {
        let text = String::from_utf8_lossy(self.columns(from, to)).into_owned();
        if text == "NONE" { String::new() } else { text }
    }

    /// An integer; 0 for blanks.
    pub(super) fn integer(self, from: usize, to: usize) -> Result<i64> {
        self.parsed(from, to, "an integer", |text| text.parse().ok())
    }

    /// A float, also with the exponent letter D of Fortran; 0 for blanks.
    pub(super) fn float(self, from: usize, to: usize) -> Result<f64> {
        self.parsed(from, to, "a number", |text| match text.parse() {
            Ok(value) => Some(value),
            Err(_) => text.replace(['D', 'd'], "E").parse().ok(),
        })
    }

    fn parsed<T: Default>(
        self,
        from: usize,
        to: usize,
        expected: &str,
        parse: impl FnOnce(&str) -> Option<T>,
    ) -> Result<T> {
        let found = self.columns(from, to);
        let parsed = match found.is_empty() {
            true => Some(T::default()),
            false => str::from_utf8(found).ok().and_then(parse),
        };
        parsed.ok_or_else(|| self.damaged(expected, found))
    }

    pub(super) fn damaged(self, expected: &str, found: &[u8]) -> Error {
        let found = String::from_utf8_lossy(&found[..found.len().min(40)]).into_owned();
        Error::damaged(format!("the line at byte {}", self.at), expected, found)
    }
}
