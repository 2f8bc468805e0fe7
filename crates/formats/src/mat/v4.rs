//! Version 4: matrices, each behind a header of 20 bytes and its name.

use std::ops::Range;

use super::listing::{Listing, Part};
use super::until_zero;
use crate::cursor::Cursor;
use crate::{ByteOrder, Error, Result, Sample};

const HEADER: u64 = 20;
const SAMPLES: [Sample; 6] = [
    Sample::F64,
    Sample::F32,
    Sample::I32,
    Sample::I16,
    Sample::U16,
    Sample::U8,
];
/// Kinds of matrices; others are full ones.
const TEXT: i64 = 1;
const SPARSE: i64 = 2;

/// What the header of a matrix says.
struct Matrix {
    order: ByteOrder,
    sample: Sample,
    kind: i64,
    shape: [u64; 2],
    is_complex: bool,
    /// Bytes of its name, with the 0 that ends it, and of its numbers.
    name: Range<usize>,
    numbers: Range<usize>,
}

/// Whether the bytes begin with a header whose matrix they hold.
pub(crate) fn is_header(bytes: &[u8]) -> bool {
    let is_word = |c: &u8| c.is_ascii_alphanumeric() || *c == b'_';
    Matrix::at(bytes, 0).is_ok_and(|matrix| match &bytes[matrix.name] {
        [name @ .., 0] => !name.is_empty() && name.iter().all(is_word),
        _ => false,
    })
}

/// Lists the variables of a file.
pub(super) fn list(bytes: &[u8], listing: &mut Listing) -> Result<()> {
    let mut at = 0;
    while at < bytes.len() {
        let matrix = Matrix::at(bytes, at)?;
        let (path, shape) = (until_zero(&bytes[matrix.name]), &matrix.shape);
        let (start, order, sample) = (matrix.numbers.start, matrix.order, matrix.sample);
        at = matrix.numbers.end;
        let part = Part {
            bytes,
            order,
            inflated: None,
        };
        match matrix.kind {
            SPARSE => listing.push_other(path, shape, "a sparse matrix")?,
            _ if matrix.is_complex => listing.push_other(path, shape, "complex numbers")?,
            TEXT => {
                // At worst each character is a `String`.
                listing.budget.take(40 * (at - start) as u64)?;
                let codes = bytes[matrix.numbers].chunks_exact(sample.bytes());
                let codes = codes.map(|code| char::from_u32(sample.to_f64(order, code) as u32));
                let text = codes.map(|code| code.unwrap_or(char::REPLACEMENT_CHARACTER));
                listing.push_text(path, shape, text.collect(), (part, start))?;
            }
            _ => listing.push_numbers(path, shape, [sample; 2], part, start)?,
        }
    }
    Ok(())
}

impl Matrix {
    /// The matrix whose header is at byte `at`.
    fn at(bytes: &[u8], at: usize) -> Result<Matrix> {
        let cursor = Cursor {
            bytes,
            at,
            order: ByteOrder::Little,
        };
        let words = cursor.clone().take(HEADER, "the header of a matrix")?;
        let word = |order, i: usize| {
            let word = Sample::I32.to_i64(order, &words[4 * i..][..4]);
            word.unwrap_or_default()
        };
        // The type is at most 4052, which the other byte order makes larger.
        let order = match word(ByteOrder::Little, 0) {
            0..=4052 => ByteOrder::Little,
            _ => ByteOrder::Big,
        };
        let [code, rows, columns, imaginary, name] = [0, 1, 2, 3, 4].map(|i| word(order, i));
        let refused = |what: &str| {
            let way_out = "save it again with MATLAB 5 or later";
            Err(Error::unsupported(what, way_out))
        };
        match (code / 1000, order) {
            (0, ByteOrder::Little) | (1, ByteOrder::Big) => {}
            (2 | 3, _) => return refused("a MATLAB 4 file with numbers of a VAX"),
            (4, _) => return refused("a MATLAB 4 file with numbers of a Cray"),
            _ => return Err(cursor.damaged("the type of a matrix", code)),
        }
        let sample = SAMPLES.get((code / 10 % 100) as usize).copied();
        let sample = sample.filter(|_| code % 10 <= SPARSE);
        let sample = sample.ok_or_else(|| cursor.damaged("the type of a matrix", code))?;
        if let Some(length) = [rows, columns, name].into_iter().find(|length| *length < 0) {
            return Err(cursor.damaged("a length of 0 or more", length));
        }
        if !(0..=1).contains(&imaginary) {
            return Err(cursor.damaged("0 or 1 for an imaginary part", imaginary));
        }
        let (kind, shape) = (code % 10, [rows as u64, columns as u64]);
        let parts = if imaginary == 1 && kind != SPARSE {
            2
        } else {
            1
        };
        let start = at + HEADER as usize + name as usize;
        let end = (shape[0] * shape[1]).checked_mul(parts * sample.bytes() as u64);
        let end = end.and_then(|bytes| start.checked_add(usize::try_from(bytes).ok()?));
        let Some(end) = end.filter(|end| *end <= bytes.len()) else {
            let expected = format!("a matrix of {rows} rows and {columns} columns");
            let found = format!("the end of the file at byte {}", bytes.len());
            return Err(cursor.damaged(expected, found));
        };
        Ok(Matrix {
            order,
            sample,
            kind,
            shape,
            is_complex: imaginary == 1,
            name: start - name as usize..start,
            numbers: start..end,
        })
    }
}
