//! Version 4: matrices, each behind a header of 20 bytes and its name.

use super::listing::{Listing, Part, count, rows_of_text};
use crate::{ByteOrder, Error, Result, Sample};

const HEADER: usize = 20;
const SAMPLES: [Sample; 6] = [
    Sample::F64,
    Sample::F32,
    Sample::I32,
    Sample::I16,
    Sample::U16,
    Sample::U8,
];

/// Header of a matrix.
struct Header {
    order: ByteOrder,
    sample: Sample,
    kind: Kind,
    shape: [u64; 2],
    is_complex: bool,
    /// With the 0 that ends it.
    name_len: usize,
}

#[derive(PartialEq)]
enum Kind {
    Full,
    Text,
    Sparse,
}

/// Whether the bytes begin with a header whose matrix they hold.
pub(crate) fn is_header(bytes: &[u8]) -> bool {
    let Ok(header) = Header::parse(bytes, 0) else {
        return false;
    };
    let name = bytes.get(HEADER..HEADER + header.name_len);
    let is_name = name.is_some_and(|name| {
        let (last, name) = name.split_last().unwrap_or((&1, &[]));
        let is_word = |c: &u8| c.is_ascii_alphanumeric() || *c == b'_';
        *last == 0 && !name.is_empty() && name.iter().all(is_word)
    });
    is_name && header.end(0).is_some_and(|end| end <= bytes.len())
}

/// Lists the variables of a file.
pub(super) fn list(bytes: &[u8], listing: &mut Listing) -> Result<()> {
    let mut at = 0;
    while at < bytes.len() {
        let header = Header::parse(bytes, at)?;
        let end = header.end(at).filter(|end| *end <= bytes.len());
        let Some(end) = end else {
            let [rows, columns] = header.shape;
            let expected = format!("a matrix of {rows} rows and {columns} columns");
            let found = format!("the end of the file at byte {}", bytes.len());
            return Err(Error::damaged(format!("byte {at}"), expected, found));
        };
        let start = at + HEADER + header.name_len;
        let name = bytes[at + HEADER..start].split(|c| *c == 0).next();
        let path = String::from_utf8_lossy(name.unwrap_or_default()).into_owned();
        let shape = &header.shape;
        let part = Part {
            bytes,
            order: header.order,
            inflated: None,
        };
        if header.kind == Kind::Sparse {
            listing.push_other(path, shape, "a sparse matrix")?;
        } else if header.is_complex {
            listing.push_other(path, shape, "complex numbers")?;
        } else if header.kind == Kind::Text {
            // At worst each character is a `String`.
            listing.budget.take(40 * (end - start) as u64)?;
            let codes = bytes[start..end].chunks_exact(header.sample.bytes());
            let character = |code| header.sample.to_f64(header.order, code) as u32;
            let character = |code| char::from_u32(character(code)).unwrap_or('\u{fffd}');
            let text: Vec<char> = codes.map(character).collect();
            let found = format!("{} characters", text.len());
            let rows = rows_of_text(shape, &text);
            let rows = rows.map_err(|expected| part.damaged(start, expected, found))?;
            listing.push_text(path, shape, rows)?;
        } else {
            listing.push_numbers(path, shape, [header.sample; 2], part, start)?;
        }
        at = end;
    }
    Ok(())
}

impl Header {
    fn parse(bytes: &[u8], at: usize) -> Result<Header> {
        let damaged =
            |expected: &str, found: String| Error::damaged(format!("byte {at}"), expected, found);
        let Some(words) = bytes.get(at..).and_then(|rest| rest.get(..HEADER)) else {
            let found = format!("{} bytes", bytes.len() - at);
            return Err(damaged("the header of a matrix (20 bytes)", found));
        };
        let word = |order, i: usize| {
            let word = Sample::I32.to_i64(order, &words[4 * i..][..4]);
            word.unwrap_or_default()
        };
        // The type is at most 4052, which the other byte order makes larger.
        let little = word(ByteOrder::Little, 0);
        let order = match little {
            0..=4052 => ByteOrder::Little,
            _ => ByteOrder::Big,
        };
        let kind = word(order, 0);
        let refused = |what: &str| {
            Err(Error::unsupported(
                what,
                "save it again with MATLAB 5 or later",
            ))
        };
        match (kind / 1000, order) {
            (0, ByteOrder::Little) | (1, ByteOrder::Big) => {}
            (2 | 3, _) => return refused("a MATLAB 4 file with numbers of a VAX"),
            (4, _) => return refused("a MATLAB 4 file with numbers of a Cray"),
            _ => return Err(damaged("the type of a matrix", kind.to_string())),
        }
        let sample = SAMPLES.get((kind / 10 % 100) as usize);
        let kinds = [Kind::Full, Kind::Text, Kind::Sparse].into_iter();
        let matrix = kinds.into_iter().nth((kind % 10) as usize);
        let (Some(&sample), Some(matrix)) = (sample, matrix) else {
            return Err(damaged("the type of a matrix", kind.to_string()));
        };
        let length = |i| {
            let length = word(order, i);
            u64::try_from(length).map_err(|_| damaged("a length of 0 or more", length.to_string()))
        };
        let is_complex = match word(order, 3) {
            0 => false,
            1 => true,
            other => return Err(damaged("0 or 1 for an imaginary part", other.to_string())),
        };
        let name_len = length(4)?;
        Ok(Header {
            order,
            sample,
            kind: matrix,
            shape: [length(1)?, length(2)?],
            is_complex,
            name_len: usize::try_from(name_len)
                .map_err(|_| damaged("the length of a name", name_len.to_string()))?,
        })
    }

    /// Where the matrix ends; `None` beyond a `usize`.
    fn end(&self, at: usize) -> Option<usize> {
        let parts = if self.is_complex && self.kind != Kind::Sparse {
            2
        } else {
            1
        };
        let count = count(&self.shape)?;
        let bytes = count.checked_mul(parts * self.sample.bytes() as u64)?;
        let start = at.checked_add(HEADER)?.checked_add(self.name_len)?;
        start.checked_add(usize::try_from(bytes).ok()?)
    }
}
