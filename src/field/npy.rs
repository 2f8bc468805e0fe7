//! The header of NumPy's `.npy` format, versions 1 to 3.
//!
//! The header is a Python dictionary; only the one form that NumPy writes is read: the keys
//! `descr`, `fortran_order` and `shape`, each once, without nesting. Lengths are checked against
//! the bytes there are before anything relies on them.
//!
//! Source: NumPy Enhancement Proposal 1 and `numpy.lib.format`.

use std::sync::Arc;

use super::Layout;
use super::file_bytes::FileBytes;
use wavecascade_formats::{
    Attributes, ByteOrder, Container, Dimension, Format, Place, Sample, SampleType, Variable,
    numpy_times, strides,
};

use crate::error::InputFault;

pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// Header bytes that are read at most; NumPy itself writes 118 and reads 10000.
const TEXT_LIMIT: u64 = 65_536;

/// Bytes that suffice for [`Header::parse`].
pub(crate) const PREFIX_LIMIT: u64 = 12 + TEXT_LIMIT;

const MAX_DIMENSIONS: usize = 64;

/// What an `.npy` header states.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    pub(crate) sample: Sample,
    pub(crate) order: ByteOrder,
    pub(crate) fortran_order: bool,
    pub(crate) shape: Vec<u64>,
    /// Bytes before the first sample.
    pub(crate) data_start: usize,
    /// Of dates and spans of time, their unit and how many of it a number counts.
    pub(crate) counts: Option<(String, f64)>,
}

impl Header {
    /// Reads the header at the start of `bytes`; the first [`PREFIX_LIMIT`] suffice.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Header, InputFault> {
        let stated = HeaderEntries::parse(bytes)?;
        let (sample, order, counts) = parse_descr(stated.descr)?;
        Ok(Header {
            sample,
            order,
            fortran_order: stated.fortran_order,
            shape: stated.shape,
            data_start: stated.data_start,
            counts,
        })
    }

    /// Reads the header of a single text, an array of no dimension (`numpy.array("text")`), as one of the numbers of its
    /// characters.
    pub(crate) fn parse_text(bytes: &[u8]) -> Result<Header, InputFault> {
        let stated = HeaderEntries::parse(bytes)?;
        let (order, kind) = split_order(stated.descr);
        let length = kind.strip_prefix(b"U");
        let length = length.and_then(|digits| str::from_utf8(digits).ok()?.parse().ok());
        let Some(length) = length else {
            let descr = String::from_utf8_lossy(stated.descr).into_owned();
            return Err(InputFault::NoText { descr });
        };
        match stated.shape[..] {
            [] => Ok(Header {
                sample: Sample::U32,
                order,
                fortran_order: false,
                shape: vec![length],
                data_start: stated.data_start,
                counts: None,
            }),
            _ => Err(InputFault::NotOneText {
                shape: stated.shape,
            }),
        }
    }

    /// The text whose characters these bytes are; NumPy pads it with NULs.
    pub(crate) fn text(&self, bytes: &[u8]) -> Result<String, InputFault> {
        let character = |code: &[u8]| {
            let code = self.sample.to_i64(self.order, code);
            let found = "a number that is no character";
            let character = code.and_then(|code| char::from_u32(code.try_into().ok()?));
            character.ok_or(InputFault::Encoding { found })
        };
        let text: Result<String, _> = bytes.chunks_exact(4).map(character).collect();
        Ok(text?.trim_end_matches('\0').to_owned())
    }

    /// Bytes of the samples, where these can be addressed at all.
    pub(crate) fn data_len(&self) -> Result<u64, InputFault> {
        self.shape
            .iter()
            .try_fold(self.sample.bytes() as u64, |n, &len| n.checked_mul(len))
            .filter(|&n| n <= isize::MAX as u64 - PREFIX_LIMIT)
            .ok_or_else(|| InputFault::TooLarge {
                shape: self.shape.clone(),
                sample_bytes: self.sample.bytes(),
            })
    }

    /// Bytes of header and samples.
    pub(crate) fn file_len(&self) -> Result<u64, InputFault> {
        Ok(self.data_start as u64 + self.data_len()?)
    }

    /// That a file of `found` bytes holds this header and its samples, and nothing else.
    pub(crate) fn check_len(&self, found: u64) -> Result<(), InputFault> {
        check_len(self.file_len()?, found)
    }

    /// That there are samples.
    pub(crate) fn check_samples(&self) -> Result<(), InputFault> {
        let shape = || self.shape.clone();
        match self.shape[..] {
            [] => Err(InputFault::Dimensions { shape: shape() }),
            _ if self.shape.contains(&0) => Err(InputFault::NoSamples { shape: shape() }),
            _ => self.data_len().map(|_| ()),
        }
    }

    /// Bytes from one index of each dimension to the next.
    pub(crate) fn strides(&self) -> Vec<u64> {
        strides(&self.shape, self.sample, self.fortran_order)
    }

    /// The lengths of the first two dimensions.
    pub(crate) fn lengths(&self) -> [usize; 2] {
        [0, 1].map(|d| self.shape.get(d).map_or(1, |&len| len as usize))
    }

    /// The array as one of a file.
    pub(super) fn variable(&self, path: String) -> Variable {
        let mut attributes = Attributes::default();
        if let Some(counts) = self.counts.clone() {
            attributes.insert_counts(counts);
        }
        Variable {
            path,
            dimensions: self.shape.iter().map(|&len| Dimension::new(len)).collect(),
            sample_type: SampleType::Number(self.sample),
            attributes,
            place: Place::Strided {
                start: self.data_start as u64,
                strides: self.strides(),
                order: self.order,
            },
        }
    }
}

/// The array of a file.
pub(super) fn container(bytes: &Arc<FileBytes>) -> Result<Container, InputFault> {
    let header = Header::parse(bytes)?;
    if header.counts.is_some() {
        let descr = String::from_utf8_lossy(HeaderEntries::parse(bytes)?.descr).into_owned();
        return Err(InputFault::SampleType { descr });
    }
    header.check_samples()?;
    header.check_len(bytes.len() as u64)?;
    let mut container = Container::new(Format::Npy, &(Arc::clone(bytes) as _));
    container.push(header.variable("array".into()));
    Ok(container)
}

/// Names three dimensions and more: time, y and x; with the layout site-time y, x and time.
pub(super) fn name_dimensions(dimensions: &mut [Dimension], layout: Layout) {
    let Some(last) = dimensions.len().checked_sub(1).filter(|last| *last > 1) else {
        return;
    };
    let time = match layout {
        Layout::TimeSite => 0,
        Layout::SiteTime => last,
    };
    dimensions[time].name = Some("time".into());
    let others = (0..=last).rev().filter(|d| *d != time);
    for (d, name) in others.zip(["x", "y", "z"]) {
        dimensions[d].name = Some(name.into());
    }
}

/// Checks that a file has the length given by its header.
pub(crate) fn check_len(expected: u64, found: u64) -> Result<(), InputFault> {
    match found.cmp(&expected) {
        std::cmp::Ordering::Less => Err(InputFault::Truncated { expected, found }),
        std::cmp::Ordering::Equal => Ok(()),
        std::cmp::Ordering::Greater => Err(InputFault::TrailingBytes { expected, found }),
    }
}

/// What the dictionary of a header states.
struct HeaderEntries<'a> {
    descr: &'a [u8],
    fortran_order: bool,
    shape: Vec<u64>,
    data_start: usize,
}

impl HeaderEntries<'_> {
    fn parse(bytes: &[u8]) -> Result<HeaderEntries<'_>, InputFault> {
        let found = bytes.len() as u64;
        let truncated = |expected: u64| InputFault::Truncated { expected, found };
        if !bytes.starts_with(MAGIC) {
            let found = bytes[..bytes.len().min(MAGIC.len())].to_vec();
            return Err(InputFault::NpyMagic { found });
        }
        let [major, minor] = *bytes[MAGIC.len()..].first_chunk().ok_or(truncated(8))?;
        let (text_start, length) = match (major, minor) {
            (1, 0) => (10, Sample::U16),
            (2 | 3, 0) => (12, Sample::U32),
            _ => return Err(InputFault::NpyVersion { major, minor }),
        };
        let stated = bytes
            .get(8..text_start)
            .ok_or(truncated(text_start as u64))?;
        let text_len = length.to_f64(ByteOrder::Little, stated) as u64;
        if text_len > TEXT_LIMIT {
            return Err(InputFault::NpyHeaderLength {
                found: text_len,
                limit: TEXT_LIMIT,
            });
        }
        let data_start = text_start + text_len as usize;
        let text = bytes
            .get(text_start..data_start)
            .ok_or(truncated(data_start as u64))?;
        let tokens = Tokens {
            text,
            at: 0,
            last: 0,
            text_start,
        };
        tokens.dictionary(data_start)
    }
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

    fn expect(&mut self, mark: &[u8], expected: &'static str) -> Result<(), InputFault> {
        match self.next() == mark {
            true => Ok(()),
            false => Err(self.fault(expected)),
        }
    }

    fn dictionary(mut self, data_start: usize) -> Result<HeaderEntries<'a>, InputFault> {
        let (mut descr, mut fortran_order, mut shape) = (None, None, None);
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
                b"fortran_order" if fortran_order.is_none() => {
                    fortran_order = Some(match self.next() {
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
        Ok(HeaderEntries {
            descr: descr.ok_or_else(|| self.fault("the key descr"))?,
            fortran_order: fortran_order.ok_or_else(|| self.fault("the key fortran_order"))?,
            shape: shape.ok_or_else(|| self.fault("the key shape"))?,
            data_start,
        })
    }

    fn descr(&mut self) -> Result<&'a [u8], InputFault> {
        match self.next() {
            b"[" | b"(" | b"{" => Err(InputFault::StructuredType {
                descr: self.excerpt(),
            }),
            token => unquoted(token).ok_or_else(|| self.fault("a type in quotes")),
        }
    }

    /// A tuple of lengths; one beyond `u64` saturates, for [`Header::data_len`] to refuse.
    fn shape(&mut self) -> Result<Vec<u64>, InputFault> {
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
            if shape.len() == MAX_DIMENSIONS {
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
        String::from_utf8_lossy(&rest[..rest.len().min(40)])
            .trim_end()
            .to_owned()
    }

    /// What is wrong with the last token.
    fn fault(&self, expected: &'static str) -> InputFault {
        InputFault::NpyHeader {
            at: self.text_start + self.last,
            expected,
            found: self.excerpt(),
        }
    }
}

/// What stands within the quotes of a token.
fn unquoted(token: &[u8]) -> Option<&[u8]> {
    match token {
        [b'\'' | b'"', text @ .., _] => Some(text),
        _ => None,
    }
}

/// What a type of samples holds: numbers in an order of bytes, and what times count.
type Kind = (Sample, ByteOrder, Option<(String, f64)>);

/// The byte order of a NumPy type string, and what follows it.
fn split_order(descr: &[u8]) -> (ByteOrder, &[u8]) {
    match descr {
        [b'<', kind @ ..] => (ByteOrder::Little, kind),
        [b'>', kind @ ..] => (ByteOrder::Big, kind),
        [b'|' | b'=', kind @ ..] => (ByteOrder::NATIVE, kind),
        kind => (ByteOrder::NATIVE, kind),
    }
}

/// A NumPy type string: byte order, kind, bytes.
fn parse_descr(descr: &[u8]) -> Result<Kind, InputFault> {
    let (order, kind) = split_order(descr);
    let text = || String::from_utf8_lossy(descr).into_owned();
    let sample = match kind {
        b"f8" => Sample::F64,
        b"f4" => Sample::F32,
        b"f2" => Sample::F16,
        b"i1" => Sample::I8,
        b"i2" => Sample::I16,
        b"i4" => Sample::I32,
        b"i8" => Sample::I64,
        b"u1" => Sample::U8,
        b"u2" => Sample::U16,
        b"u4" => Sample::U32,
        b"u8" => Sample::U64,
        b"b1" => Sample::Bool,
        [kind @ (b'M' | b'm'), b'8', b'[', unit @ .., b']'] => {
            let unit = String::from_utf8_lossy(unit);
            let counts = numpy_times(&unit, *kind == b'M')
                .ok_or_else(|| InputFault::SampleType { descr: text() })?;
            return Ok((Sample::I64, order, Some(counts)));
        }
        [b'O', ..] => return Err(InputFault::PickledObjects),
        [b'c', ..] => return Err(InputFault::ComplexType { descr: text() }),
        [b'V', ..] => return Err(InputFault::StructuredType { descr: text() }),
        _ => return Err(InputFault::SampleType { descr: text() }),
    };
    Ok((sample, order, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn version_1(text: &str) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes
    }

    #[test]
    fn keys_come_in_any_order_and_quotes() {
        let text = "{\"shape\": (3,4),'fortran_order':True , 'descr': '>f4'}\n";
        let header = Header::parse(&version_1(text)).unwrap();
        assert_eq!(header.shape, [3, 4]);
        assert_eq!((header.sample, header.order), (Sample::F32, ByteOrder::Big));
        assert!(header.fortran_order);
        assert_eq!(header.data_start, 10 + text.len());
        assert_eq!(header.data_len(), Ok(48));
    }

    /// As `numpy.load` of NumPy 2 does.
    #[test]
    fn val_numpy_what_it_would_not_write_is_refused() {
        let parsed = |text: &str| Header::parse(&version_1(text)).map(|header| header.shape);
        let with_shape = |shape: &str| {
            format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n")
        };
        for (shape, lengths) in [
            ("(4, 3)", [4, 3]),
            ("( 4,3, )", [4, 3]),
            ("(4L, 3L)", [4, 3]),
            ("(00, 3)", [0, 3]),
        ] {
            assert_eq!(parsed(&with_shape(shape)).unwrap(), lengths, "{shape}");
        }
        let shapes = "(04, 3)|(4, 03)|(04L, 3)|(4l, 3)|(4LL, 3)|(,)|(3)|(3, 4|(-3, 4)|[3, 4]|(3, 4) x|\
                      (3, 4), 'shape': (3, 4)|(3, 4), 'more': 1";
        let others = "|{|{}|{'descr': '<f8'}|{'descr': '<f8', 'fortran_order': 0, 'shape': (3, 4)}|\
                      {'descr': '<f8' 'fortran_order': False, 'shape': (3, 4)}|\
                      {'descr': '<f8', 'fortran_order': False, 'shape': (3, 4)} x|\
                      {'de\\scr': '<f8', 'fortran_order': False, 'shape': (3, 4)}";
        let texts = shapes.split('|').map(with_shape);
        for text in texts.chain(others.split('|').map(str::to_owned)) {
            let found = parsed(&text);
            assert!(matches!(found, Err(InputFault::NpyHeader { .. })), "{text}");
        }
    }
}
