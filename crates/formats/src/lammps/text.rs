//! Rows of a dump and the values in them.

use super::scan::Frame;
use crate::{Error, Result};

/// The lines of `bytes` without their ends.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split(|&byte| byte == b'\n')
}

/// Whether a line has no value.
pub(super) fn is_blank(line: &[u8]) -> bool {
    line.trim_ascii().is_empty()
}

/// What stands between blanks.
pub(super) fn values(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|value| !value.is_empty())
}

/// A value as a number.
pub(super) fn float(value: &[u8]) -> Option<f64> {
    std::str::from_utf8(value).ok()?.parse().ok()
}

/// The columns `id` and `wanted` of a row of `columns` values.
///
/// # Errors
/// The number of values, if the row has more or fewer.
pub(super) fn pick<const N: usize>(
    row: &[u8],
    columns: usize,
    id: usize,
    wanted: [usize; N],
) -> std::result::Result<(&[u8], [&[u8]; N]), usize> {
    let (mut name, mut picked) = (&row[..0], [&row[..0]; N]);
    let mut found = 0;
    for value in values(row) {
        if found == id {
            name = value;
        }
        for (slot, column) in picked.iter_mut().zip(wanted) {
            if column == found {
                *slot = value;
            }
        }
        found += 1;
    }
    match found == columns {
        true => Ok((name, picked)),
        false => Err(found),
    }
}

/// The number of an atom.
pub(super) fn id(value: &[u8], frame: &Frame) -> Result<i64> {
    let text = std::str::from_utf8(value).ok();
    text.and_then(|text| text.parse().ok())
        .ok_or_else(|| wrong(value, frame, "the id of an atom"))
}

/// The error of a value of a frame.
pub(super) fn wrong(value: &[u8], frame: &Frame, expected: &str) -> Error {
    frame.damaged(expected, value[..value.len().min(40)].escape_ascii())
}
