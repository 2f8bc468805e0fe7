//! The header of NumPy's `.npy` format, versions 1 to 3.
//!
//! The header is a Python dictionary; only the one form that NumPy writes is read: the keys
//! `descr`, `fortran_order` and `shape`, each once, without nesting. Lengths are checked against
//! the bytes there are before anything relies on them.
//!
//! Source: NumPy Enhancement Proposal 1 and `numpy.lib.format`.

use super::Layout;
use super::storage::{Arrangement, ByteOrder, SampleType};
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
    pub(crate) sample: SampleType,
    pub(crate) order: ByteOrder,
    pub(crate) fortran_order: bool,
    pub(crate) shape: Vec<u64>,
    /// Bytes before the first sample.
    pub(crate) data_start: usize,
}

impl Header {
    /// Reads the header at the start of `bytes`; the first [`PREFIX_LIMIT`] suffice.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Header, InputFault> {
        let HeaderEntries {
            kind: (sample, order),
            fortran_order,
            shape,
            data_start,
        } = HeaderEntries::parse(bytes, parse_descr)?;
        Ok(Header {
            sample,
            order,
            fortran_order,
            shape,
            data_start,
        })
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

    /// The lengths `(first, second)` of the two axes; one dimension is one column.
    fn dimensions(&self) -> Result<(usize, usize), InputFault> {
        self.check_samples()?;
        match self.shape[..] {
            [first] => Ok((first as usize, 1)),
            [first, second] => Ok((first as usize, second as usize)),
            _ => Err(InputFault::Dimensions {
                shape: self.shape.clone(),
            }),
        }
    }

    /// Names of the dimensions: of three, time, y and x; with the layout site-time y, x and time.
    pub(crate) fn names(&self, layout: Layout) -> Vec<String> {
        let n = self.shape.len();
        let space = ["z", "y", "x"];
        let number = |i: usize| match (n - 1).checked_sub(space.len()) {
            Some(beyond) if i < beyond => format!("{i}"),
            Some(beyond) => space[i - beyond].to_owned(),
            None => space[space.len() - (n - 1) + i].to_owned(),
        };
        let mut names: Vec<String> = (0..n - 1).map(number).collect();
        let time = match layout {
            Layout::TimeSite => 0,
            Layout::SiteTime => n - 1,
        };
        names.insert(time, "time".into());
        names
    }

    /// Bytes from one index of each dimension to the next.
    pub(crate) fn strides(&self) -> Vec<u64> {
        let mut next = self.sample.bytes() as u64;
        let mut strides = vec![0; self.shape.len()];
        let mut of = |i: usize| {
            strides[i] = next;
            next *= self.shape[i];
        };
        match self.fortran_order {
            true => (0..self.shape.len()).for_each(&mut of),
            false => (0..self.shape.len()).rev().for_each(&mut of),
        }
        strides
    }

    /// The lengths `(times, sites)`; one dimension is the record of one site.
    pub(crate) fn field_lengths(&self, layout: Layout) -> Result<(usize, usize), InputFault> {
        let (first, second) = self.dimensions()?;
        match layout {
            Layout::SiteTime if self.shape.len() == 2 => Ok((second, first)),
            _ => Ok((first, second)),
        }
    }

    /// The layout of the samples in bytes; the first sample is at `start`.
    pub(crate) fn arrangement(
        &self,
        start: usize,
        layout: Layout,
    ) -> Result<Arrangement, InputFault> {
        let (first, second) = self.dimensions()?;
        let is_record = self.shape.len() == 1;
        let first_is_slow = !(is_record || self.fortran_order);
        Ok(Arrangement {
            sample: self.sample,
            order: self.order,
            start,
            row_len: if first_is_slow { second } else { first },
            rows_are_times: first_is_slow == (is_record || layout == Layout::TimeSite),
        })
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

/// A single text, as an array of no dimension (`numpy.array("text")`).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TextHeader {
    /// Characters, of four bytes each.
    pub(crate) length: u64,
    pub(crate) order: ByteOrder,
    pub(crate) data_start: usize,
}

impl TextHeader {
    /// Reads the header at the start of `bytes`.
    pub(crate) fn parse(bytes: &[u8]) -> Result<TextHeader, InputFault> {
        let stated = HeaderEntries::parse(bytes, parse_text_descr)?;
        let (length, order) = stated.kind;
        match stated.shape[..] {
            [] => Ok(TextHeader {
                length,
                order,
                data_start: stated.data_start,
            }),
            _ => Err(InputFault::NotOneText {
                shape: stated.shape,
            }),
        }
    }

    /// Bytes of header and characters.
    pub(crate) fn file_len(&self) -> u64 {
        self.length
            .saturating_mul(4)
            .saturating_add(self.data_start as u64)
    }

    /// The text in the characters' bytes; NumPy pads it with NULs.
    pub(crate) fn decode(&self, bytes: &[u8]) -> Result<String, InputFault> {
        let (characters, _) = bytes.as_chunks::<4>();
        let character = |bytes: &[u8; 4]| {
            let code = match self.order {
                ByteOrder::Little => u32::from_le_bytes(*bytes),
                ByteOrder::Big => u32::from_be_bytes(*bytes),
            };
            let found = "a number that is no character";
            char::from_u32(code).ok_or(InputFault::Encoding { found })
        };
        let text: String = characters.iter().map(character).collect::<Result<_, _>>()?;
        Ok(text.trim_end_matches('\0').to_owned())
    }
}

/// What the dictionary of a header states, `kind` being what its `descr` was read as.
struct HeaderEntries<K> {
    kind: K,
    fortran_order: bool,
    shape: Vec<u64>,
    data_start: usize,
}

impl<K> HeaderEntries<K> {
    fn parse(
        bytes: &[u8],
        kind_of: fn(&[u8]) -> Result<K, InputFault>,
    ) -> Result<HeaderEntries<K>, InputFault> {
        let found = bytes.len() as u64;
        let truncated = |expected: u64| InputFault::Truncated { expected, found };
        if !bytes.starts_with(MAGIC) {
            let found = bytes[..bytes.len().min(MAGIC.len())].to_vec();
            return Err(InputFault::NpyMagic { found });
        }
        let [major, minor] = *bytes[MAGIC.len()..].first_chunk().ok_or(truncated(8))?;
        let (text_start, text_len) = match (major, minor) {
            (1, 0) => {
                let length = bytes[8..].first_chunk().ok_or(truncated(10))?;
                (10, u64::from(u16::from_le_bytes(*length)))
            }
            (2 | 3, 0) => {
                let length = bytes[8..].first_chunk().ok_or(truncated(12))?;
                (12, u64::from(u32::from_le_bytes(*length)))
            }
            _ => return Err(InputFault::NpyVersion { major, minor }),
        };
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
        let cursor = Cursor {
            text,
            at: 0,
            text_start,
        };
        cursor.dictionary(data_start, kind_of)
    }
}

struct Cursor<'a> {
    text: &'a [u8],
    at: usize,
    text_start: usize,
}

impl<'a> Cursor<'a> {
    fn dictionary<K>(
        mut self,
        data_start: usize,
        kind_of: fn(&[u8]) -> Result<K, InputFault>,
    ) -> Result<HeaderEntries<K>, InputFault> {
        let (mut kind, mut fortran_order, mut shape) = (None, None, None);
        self.expect(b'{', "{")?;
        while !self.accept(b'}') {
            let start = self.at;
            let key = self.string("a key in quotes")?;
            self.expect(b':', "a colon")?;
            match key {
                b"descr" if kind.is_none() => kind = Some(self.kind(kind_of)?),
                b"fortran_order" if fortran_order.is_none() => {
                    fortran_order = Some(self.boolean()?);
                }
                b"shape" if shape.is_none() => shape = Some(self.shape()?),
                _ => {
                    self.at = start;
                    return Err(self.fault("the keys descr, fortran_order and shape, each once"));
                }
            }
            if !self.accept(b',') {
                self.expect(b'}', "a comma or }")?;
                break;
            }
        }
        self.skip_blanks();
        if self.at < self.text.len() {
            return Err(self.fault("nothing but blanks after the dictionary"));
        }
        Ok(HeaderEntries {
            kind: kind.ok_or_else(|| self.fault("the key descr"))?,
            fortran_order: fortran_order.ok_or_else(|| self.fault("the key fortran_order"))?,
            shape: shape.ok_or_else(|| self.fault("the key shape"))?,
            data_start,
        })
    }

    fn kind<K>(&mut self, kind_of: fn(&[u8]) -> Result<K, InputFault>) -> Result<K, InputFault> {
        if matches!(self.peek(), Some(b'[' | b'(' | b'{')) {
            return Err(InputFault::StructuredType {
                descr: self.excerpt(),
            });
        }
        let descr = self.string("a type in quotes")?;
        kind_of(descr)
    }

    fn boolean(&mut self) -> Result<bool, InputFault> {
        self.skip_blanks();
        for (word, value) in [(&b"True"[..], true), (b"False", false)] {
            if self.text[self.at..].starts_with(word) {
                self.at += word.len();
                return Ok(value);
            }
        }
        Err(self.fault("True or False"))
    }

    fn shape(&mut self) -> Result<Vec<u64>, InputFault> {
        let mut shape = Vec::new();
        self.expect(b'(', "a tuple of lengths")?;
        while !self.accept(b')') {
            if shape.len() == MAX_DIMENSIONS {
                return Err(self.fault("at most 64 lengths"));
            }
            shape.push(self.length()?);
            let comma = self.accept(b',');
            if !comma && (shape.len() == 1 || self.peek() != Some(b')')) {
                return Err(self.fault("a comma"));
            }
        }
        Ok(shape)
    }

    /// A length; one beyond `u64` saturates, for [`Header::data_len`] to refuse.
    fn length(&mut self) -> Result<u64, InputFault> {
        self.skip_blanks();
        let digits = self.text[self.at..]
            .iter()
            .take_while(|byte| byte.is_ascii_digit());
        let mut length = 0u64;
        let mut count = 0;
        for digit in digits {
            length = length
                .saturating_mul(10)
                .saturating_add(u64::from(digit - b'0'));
            count += 1;
        }
        if count == 0 {
            return Err(self.fault("a length"));
        }
        // A number of Python has no leading zero.
        if length > 0 && self.text[self.at] == b'0' {
            return Err(self.fault("a length without leading zeros"));
        }
        self.at += count;
        if self.text.get(self.at) == Some(&b'L') {
            self.at += 1;
        }
        Ok(length)
    }

    fn string(&mut self, expected: &'static str) -> Result<&'a [u8], InputFault> {
        let quote = match self.peek() {
            Some(quote @ (b'\'' | b'"')) => quote,
            _ => return Err(self.fault(expected)),
        };
        let rest = &self.text[self.at + 1..];
        let end = rest
            .iter()
            .position(|&byte| byte == quote || byte == b'\\')
            .filter(|&end| rest[end] == quote)
            .ok_or_else(|| self.fault(expected))?;
        self.at += end + 2;
        Ok(&rest[..end])
    }

    fn skip_blanks(&mut self) {
        let blanks = self.text[self.at..]
            .iter()
            .take_while(|byte| byte.is_ascii_whitespace());
        self.at += blanks.count();
    }

    fn peek(&mut self) -> Option<u8> {
        self.skip_blanks();
        self.text.get(self.at).copied()
    }

    fn accept(&mut self, byte: u8) -> bool {
        let there = self.peek() == Some(byte);
        self.at += usize::from(there);
        there
    }

    fn expect(&mut self, byte: u8, expected: &'static str) -> Result<(), InputFault> {
        if self.accept(byte) {
            Ok(())
        } else {
            Err(self.fault(expected))
        }
    }

    fn excerpt(&self) -> String {
        let rest = &self.text[self.at..];
        String::from_utf8_lossy(&rest[..rest.len().min(40)])
            .trim_end()
            .to_owned()
    }

    fn fault(&self, expected: &'static str) -> InputFault {
        InputFault::NpyHeader {
            at: self.text_start + self.at,
            expected,
            found: self.excerpt(),
        }
    }
}

/// A NumPy type string: byte order, kind, bytes.
fn parse_descr(descr: &[u8]) -> Result<(SampleType, ByteOrder), InputFault> {
    let (order, kind) = match descr {
        [b'<', kind @ ..] => (ByteOrder::Little, kind),
        [b'>', kind @ ..] => (ByteOrder::Big, kind),
        [b'|' | b'=', kind @ ..] => (ByteOrder::NATIVE, kind),
        kind => (ByteOrder::NATIVE, kind),
    };
    let text = || String::from_utf8_lossy(descr).into_owned();
    let sample = match kind {
        b"f8" => SampleType::F64,
        b"f4" => SampleType::F32,
        b"f2" => SampleType::F16,
        b"i1" => SampleType::I8,
        b"i2" => SampleType::I16,
        b"i4" => SampleType::I32,
        b"i8" => SampleType::I64,
        b"u1" => SampleType::U8,
        b"u2" => SampleType::U16,
        b"u4" => SampleType::U32,
        b"u8" => SampleType::U64,
        b"b1" => SampleType::Bool,
        [b'O', ..] => return Err(InputFault::PickledObjects),
        [b'c', ..] => return Err(InputFault::ComplexType { descr: text() }),
        [b'V', ..] => return Err(InputFault::StructuredType { descr: text() }),
        _ => return Err(InputFault::SampleType { descr: text() }),
    };
    Ok((sample, order))
}

/// The type string of texts, `<U12`: order and characters.
fn parse_text_descr(descr: &[u8]) -> Result<(u64, ByteOrder), InputFault> {
    let text = String::from_utf8_lossy(descr);
    let (order, rest) = match text.strip_prefix('>') {
        Some(rest) => (ByteOrder::Big, rest),
        None => (ByteOrder::Little, text.strip_prefix('<').unwrap_or(&text)),
    };
    let length = rest
        .strip_prefix('U')
        .and_then(|digits| digits.parse().ok());
    match length {
        Some(length) => Ok((length, order)),
        None => Err(InputFault::NoText {
            descr: text.into_owned(),
        }),
    }
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
        assert_eq!(
            (header.sample, header.order),
            (SampleType::F32, ByteOrder::Big)
        );
        assert!(header.fortran_order);
        assert_eq!(header.data_start, 10 + text.len());
        assert_eq!(header.data_len(), Ok(48));
    }

    #[test]
    fn what_numpy_would_not_write_is_refused() {
        for text in [
            "",
            "{",
            "{}",
            "{'descr': '<f8'}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (-3, 4)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), 'shape': (3, 4)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), 'more': 1}",
            "{'descr': '<f8', 'fortran_order': 0, 'shape': (3, 4)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': [3, 4]}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4)} x",
            "{'descr': '<f8' 'fortran_order': False, 'shape': (3, 4)}",
            "{'de\\scr': '<f8', 'fortran_order': False, 'shape': (3, 4)}",
        ] {
            let fault = Header::parse(&version_1(text)).unwrap_err();
            assert!(
                matches!(fault, InputFault::NpyHeader { .. }),
                "{text}: {fault}"
            );
        }
    }

    /// As `numpy.load` of NumPy 2 does.
    #[test]
    fn val_lengths_are_numbers_of_python() {
        let parsed = |shape: &str| {
            let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
            Header::parse(&version_1(&text)).map(|header| header.shape)
        };
        for (shape, lengths) in [
            ("(4, 3)", [4, 3]),
            ("( 4,3, )", [4, 3]),
            ("(4L, 3L)", [4, 3]),
            ("(00, 3)", [0, 3]),
        ] {
            assert_eq!(parsed(shape).unwrap(), lengths, "{shape}");
        }
        for shape in [
            "(04, 3)", "(4, 03)", "(04L, 3)", "(4l, 3)", "(4LL, 3)", "(,)",
        ] {
            let fault = parsed(shape).unwrap_err();
            assert!(matches!(fault, InputFault::NpyHeader { .. }), "{shape}");
        }
    }
}
