//! NumPy's `.npy` format, versions 1 to 3.
//!
//! The header is a Python dictionary; only the one form that NumPy writes is read: the keys
//! `descr`, `fortran_order` and `shape`, each once, without nesting. Lengths are checked against
//! the bytes there are before anything relies on them.
//!
//! Source: NumPy Enhancement Proposal 1 and `numpy.lib.format`.

use std::cmp::Ordering;

use crate::cursor::beginning;
use crate::{
    ByteOrder, Bytes, Container, Dimension, Error, Format, Options, Place, Result, Sample, Strided,
    Variable, numpy_times, strides,
};

const MAGIC: &[u8] = b"\x93NUMPY";
/// Header bytes that are read at most; NumPy itself writes 118 and reads 10000.
const LONGEST: usize = 65_536;
/// Bytes that suffice for [`Header::parse`].
pub(crate) const PREFIX: u64 = 12 + LONGEST as u64;
const MOST_DIMENSIONS: usize = 64;
const AS_NUMBERS: &str = "save numbers: `numpy.save(path, array.astype(float))`";

/// The format of these bytes, if it is the one of this module.
pub(crate) fn detect(bytes: &[u8]) -> Option<Format> {
    bytes.starts_with(MAGIC).then_some(Format::Npy)
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, _options: &Options) -> Result<Container> {
    let mut container = Container::new(format, &bytes);
    let bytes = (*bytes).as_ref();
    let header = Header::parse(bytes)?;
    if header.is_text || header.counts.is_some() {
        return Err(Error::unsupported("texts or dates as samples", AS_NUMBERS));
    }
    header.check_len(bytes.len() as u64)?;
    container.push(header.variable("array", Some(0)));
    Ok(container)
}

/// What a header states.
#[derive(Debug, PartialEq)]
pub(crate) struct Header {
    sample: Sample,
    order: ByteOrder,
    is_fortran: bool,
    pub shape: Vec<u64>,
    /// Bytes before the first sample.
    pub start: usize,
    /// Of dates and spans of time, their unit and how many of it a number counts.
    counts: Option<(String, f64)>,
    /// Whether it is one text (`numpy.array("text")`), whose characters are the numbers.
    pub is_text: bool,
}

impl Header {
    /// Reads the header at the start of `bytes`; the first [`PREFIX`] suffice.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for sound samples that are neither numbers nor one text.
    pub fn parse(bytes: &[u8]) -> Result<Header> {
        let cut = |expected: usize| too_short(expected as u64, bytes.len() as u64);
        if !bytes.starts_with(MAGIC) {
            let expected = "the NumPy signature \\x93NUMPY";
            return Err(Error::damaged("byte 0", expected, beginning(bytes)));
        }
        let (text_start, version) = match bytes.get(MAGIC.len()..8).ok_or_else(|| cut(8))? {
            [1, 0] => (10, 1),
            [2 | 3, 0] => (12, 2),
            other => {
                let what = format!("version {other:?} of the format");
                return Err(Error::unsupported(what, "write it again with `numpy.save`"));
            }
        };
        let length = bytes.get(8..text_start).ok_or_else(|| cut(text_start))?;
        let length = ByteOrder::Little.unsigned(length) as usize;
        if length > LONGEST {
            let expected = format!("a header of at most {LONGEST} bytes in version {version}");
            return Err(Error::damaged("byte 8", expected, length));
        }
        let start = text_start + length;
        let text = bytes.get(text_start..start).ok_or_else(|| cut(start))?;
        let tokens = Tokens {
            text,
            at: 0,
            last: 0,
            text_start,
        };
        tokens.header(start)
    }

    fn of(descr: &[u8], is_fortran: bool, shape: Vec<u64>, start: usize) -> Result<Header> {
        let (order, kind) = match descr {
            [b'<', kind @ ..] => (ByteOrder::Little, kind),
            [b'>', kind @ ..] => (ByteOrder::Big, kind),
            [b'|' | b'=', kind @ ..] => (ByteOrder::NATIVE, kind),
            kind => (ByteOrder::NATIVE, kind),
        };
        let told = || format!("{:?}", String::from_utf8_lossy(descr));
        let other = || Error::unsupported(format!("samples of the type {}", told()), AS_NUMBERS);
        let kind = str::from_utf8(kind).map_err(|_| other())?;
        let mut header = Header {
            sample: Sample::I64,
            order,
            is_fortran,
            shape,
            start,
            counts: None,
            is_text: false,
        };
        let times = kind.strip_prefix("M8[").or(kind.strip_prefix("m8["));
        if let Some(unit) = times.and_then(|unit| unit.strip_suffix(']')) {
            let counts = numpy_times(unit, kind.starts_with('M'));
            header.counts = Some(counts.ok_or_else(other)?);
            return Ok(header);
        }
        if let Some(characters) = kind.strip_prefix('U').filter(|_| header.shape.is_empty()) {
            header.sample = Sample::U32;
            header.shape = vec![characters.parse().map_err(|_| other())?];
            header.is_text = true;
            return Ok(header);
        }
        header.sample = match kind.as_bytes() {
            [b'O', ..] => {
                return Err(Error::unsupported("pickled Python objects", AS_NUMBERS));
            }
            [b'c', ..] => {
                let what = format!("the complex type {}", told());
                let way_out = "save its real part: `numpy.save(path, array.real)`";
                return Err(Error::unsupported(what, way_out));
            }
            [b'V', ..] => return Err(structured(&told())),
            &[kind, bytes @ b'1'..=b'8'] => {
                let sample = Sample::of_kind(kind.into(), usize::from(bytes - b'0'));
                sample.ok_or_else(other)?
            }
            _ => return Err(other()),
        };
        Ok(header)
    }

    /// Bytes of header and samples, where these can be addressed at all.
    pub fn file_len(&self) -> Result<u64> {
        let mut lengths = self.shape.iter();
        let bytes = lengths.try_fold(self.sample.bytes() as u64, |n, &len| n.checked_mul(len));
        let bytes = bytes.filter(|&n| n <= isize::MAX as u64 - PREFIX);
        let bytes = bytes.ok_or_else(|| {
            let found = format!("the shape {:?}", self.shape);
            Error::damaged("the header", "an array that can be addressed", found)
        })?;
        Ok(self.start as u64 + bytes)
    }

    /// That a file of `found` bytes holds this header and its samples, and nothing else.
    pub fn check_len(&self, found: u64) -> Result<()> {
        let expected = self.file_len()?;
        match found.cmp(&expected) {
            Ordering::Less => Err(too_short(expected, found)),
            Ordering::Equal => Ok(()),
            Ordering::Greater => Err(Error::unsupported(
                format!("{} bytes behind the array", found - expected),
                "write one array a file, or several with `numpy.savez`",
            )),
        }
    }

    /// The array as one of a file in which the header is at byte `before`; `None` of one that is unpacked.
    pub fn variable(&self, path: &str, before: Option<u64>) -> Variable {
        let dimensions = self.shape.iter().map(|&len| Dimension::new(len)).collect();
        let mut variable = Variable::new(path, dimensions, self.sample);
        if let Some(counts) = self.counts.clone() {
            variable.attributes.insert_counts(counts);
        }
        variable.place = Place::Strided(Strided {
            start: before.unwrap_or(0).saturating_add(self.start as u64),
            strides: strides(&self.shape, self.sample, self.is_fortran),
            order: self.order,
            is_in_file: before.is_some(),
        });
        variable
    }

    /// The text whose characters these bytes are; NumPy pads it with NULs.
    pub fn text(&self, bytes: &[u8]) -> Result<String> {
        let character = |code: &[u8]| char::from_u32(self.order.unsigned(code) as u32);
        let text: Option<String> = bytes.chunks_exact(4).map(character).collect();
        let text = text.ok_or_else(|| Error::damaged("the text", "characters", "other numbers"))?;
        Ok(text.trim_end_matches('\0').to_owned())
    }
}

pub(crate) fn too_short(expected: u64, found: u64) -> Error {
    let found = format!("{found}: the file is truncated");
    Error::damaged("the array", format!("{expected} bytes"), found)
}

fn structured(descr: &str) -> Error {
    let what = format!("the structured type {descr}");
    Error::unsupported(
        what,
        "save one of its members: `numpy.save(path, array[\"name\"])`",
    )
}

/// Marks of one byte, texts in quotes, and words of letters and digits.
struct Tokens<'a> {
    text: &'a [u8],
    at: usize,
    /// Where the last token begins.
    last: usize,
    text_start: usize,
}

impl<'a> Tokens<'a> {
    /// What follows, empty at the end; a quote that nothing ends is a mark.
    fn next(&mut self) -> &'a [u8] {
        let rest = self.text[self.at..].trim_ascii_start();
        let len = match rest.first() {
            Some(quote @ (b'\'' | b'"')) => {
                let is_end = |byte: &u8| byte == quote || *byte == b'\\';
                let end = rest[1..].iter().position(is_end).map(|end| end + 1);
                end.filter(|end| rest[*end] == *quote)
                    .map_or(1, |end| end + 1)
            }
            Some(byte) if byte.is_ascii_alphanumeric() => {
                let is_word = |byte: &&u8| byte.is_ascii_alphanumeric();
                rest.iter().take_while(is_word).count()
            }
            first => usize::from(first.is_some()),
        };
        self.last = self.text.len() - rest.len();
        self.at = self.last + len;
        &rest[..len]
    }

    fn expect(&mut self, mark: &[u8], expected: &str) -> Result<()> {
        match self.next() == mark {
            true => Ok(()),
            false => Err(self.fault(expected)),
        }
    }

    fn header(mut self, start: usize) -> Result<Header> {
        let (mut descr, mut is_fortran, mut shape) = (None, None, None);
        self.expect(b"{", "{")?;
        loop {
            let token = self.next();
            if token == b"}" {
                break;
            }
            let key = unquoted(token).ok_or_else(|| self.fault("a key in quotes"))?;
            let key_fault = self.fault("the keys descr, fortran_order and shape, each once");
            self.expect(b":", "a colon")?;
            match key {
                b"descr" if descr.is_none() => descr = Some(self.descr()?),
                b"fortran_order" if is_fortran.is_none() => {
                    is_fortran = Some(match self.next() {
                        b"True" => true,
                        b"False" => false,
                        _ => return Err(self.fault("True or False")),
                    });
                }
                b"shape" if shape.is_none() => shape = Some(self.shape()?),
                _ => return Err(key_fault),
            }
            match self.next() {
                b"," => {}
                b"}" => break,
                _ => return Err(self.fault("a comma or }")),
            }
        }
        self.expect(b"", "nothing but blanks after the dictionary")?;
        match (descr, is_fortran, shape) {
            (Some(descr), Some(is_fortran), Some(shape)) => {
                Header::of(descr, is_fortran, shape, start)
            }
            _ => Err(self.fault("the keys descr, fortran_order and shape")),
        }
    }

    fn descr(&mut self) -> Result<&'a [u8]> {
        match self.next() {
            b"[" | b"(" | b"{" => Err(structured(&self.excerpt())),
            token => unquoted(token).ok_or_else(|| self.fault("a type in quotes")),
        }
    }

    /// A tuple of lengths; one beyond `u64` saturates, for [`Header::file_len`] to refuse.
    fn shape(&mut self) -> Result<Vec<u64>> {
        let mut shape = Vec::new();
        self.expect(b"(", "a tuple of lengths")?;
        loop {
            let word = self.next();
            if word == b")" {
                return Ok(shape);
            }
            let digits = word.strip_suffix(b"L").unwrap_or(word);
            let is_number = !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
            // A number of Python has no leading zero.
            if !is_number || digits[0] == b'0' && digits.iter().any(|digit| *digit != b'0') {
                return Err(self.fault("a length without leading zeros"));
            }
            if shape.len() == MOST_DIMENSIONS {
                return Err(self.fault("at most 64 lengths"));
            }
            let length = String::from_utf8_lossy(digits).parse();
            shape.push(length.unwrap_or(u64::MAX));
            match self.next() {
                b"," => {}
                b")" if shape.len() > 1 => return Ok(shape),
                _ => return Err(self.fault("a comma")),
            }
        }
    }

    fn excerpt(&self) -> String {
        let rest = &self.text[self.last..];
        format!(
            "{:?}",
            String::from_utf8_lossy(&rest[..rest.len().min(40)]).trim_end()
        )
    }

    /// What is wrong with the last token.
    fn fault(&self, expected: &str) -> Error {
        let place = format!("header, byte {}", self.text_start + self.last);
        Error::damaged(place, expected, self.excerpt())
    }
}

/// What stands within the quotes of a token.
fn unquoted(token: &[u8]) -> Option<&[u8]> {
    match token {
        [b'\'' | b'"', text @ .., _] => Some(text),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Header> {
        let length = (text.len() as u16).to_le_bytes();
        Header::parse(&[MAGIC, &[1, 0], &length, text.as_bytes()].concat())
    }

    #[test]
    fn keys_come_in_any_order_and_quotes() {
        let text = "{\"shape\": (3,4),'fortran_order':True , 'descr': '>f4'}\n";
        let header = parsed(text).unwrap();
        assert_eq!(header.shape, [3, 4]);
        assert_eq!((header.sample, header.order), (Sample::F32, ByteOrder::Big));
        assert!(header.is_fortran);
        assert_eq!(header.start, 10 + text.len());
        assert_eq!(header.file_len(), Ok(header.start as u64 + 48));
    }

    /// As `numpy.load` of NumPy 2 does.
    #[test]
    fn val_numpy_what_it_would_not_write_is_refused() {
        let with_shape = |shape: &str| {
            format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n")
        };
        for (shape, lengths) in [
            ("(4, 3)", [4, 3]),
            ("( 4,3, )", [4, 3]),
            ("(4L, 3L)", [4, 3]),
            ("(00, 3)", [0, 3]),
        ] {
            assert_eq!(
                parsed(&with_shape(shape)).unwrap().shape,
                lengths,
                "{shape}"
            );
        }
        let shapes = "(04, 3)|(4, 03)|(04L, 3)|(4l, 3)|(4LL, 3)|(,)|(3)|(3, 4|(-3, 4)|[3, 4]|(3, 4) x|\
                      (3, 4), 'shape': (3, 4)|(3, 4), 'more': 1";
        let others = "|{|{}|{'descr': '<f8'}|{'descr': '<f8', 'fortran_order': 0, 'shape': (3, 4)}|\
                      {'descr': '<f8' 'fortran_order': False, 'shape': (3, 4)}|\
                      {'descr': '<f8', 'fortran_order': False, 'shape': (3, 4)} x|\
                      {'de\\scr': '<f8', 'fortran_order': False, 'shape': (3, 4)}";
        let texts = shapes.split('|').map(with_shape);
        for text in texts.chain(others.split('|').map(str::to_owned)) {
            let refused = parsed(&text).unwrap_err().to_string();
            assert!(refused.starts_with("header, byte"), "{text}: {refused}");
        }
    }
}
