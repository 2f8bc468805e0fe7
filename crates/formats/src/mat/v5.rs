//! Versions 5 to 7: elements with a tag of type and length, some of them compressed.

use std::io::Read;
use std::ops::Range;

use flate2::read::ZlibDecoder;
use rayon::prelude::*;

use super::columns::Source;
use super::listing::{Listing, count, rows_of_text};
use crate::{ByteOrder, Error, Result, Sample};

const HEADER: usize = 128;
/// Structs and cells within each other.
const MOST_DEPTH: usize = 32;
/// Members of one array of structs or cells that are listed.
const MOST_MEMBERS: u64 = 4096;
/// As NumPy and more than any field has.
const MOST_DIMENSIONS: usize = 32;
/// Bytes of the name of a field, beyond what MATLAB allows.
const MOST_NAME: usize = 4096;
/// Deflate gives at most 1032 bytes for one.
const MOST_INFLATION: u64 = 1032;

const INT8: u32 = 1;
const UINT8: u32 = 2;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
const UTF8: u32 = 16;
const UTF16: u32 = 17;
const UTF32: u32 = 18;

/// Whether the bytes begin with the header of a file; that of version 7.3 is HDF5.
pub(super) fn is_header(bytes: &[u8]) -> bool {
    let begins = bytes.starts_with(b"MATLAB 5.0 MAT-file");
    bytes.len() >= HEADER && (begins || byte_order(bytes).is_some())
}

fn byte_order(bytes: &[u8]) -> Option<ByteOrder> {
    match bytes.get(124..HEADER)? {
        [0, 1, b'I', b'M'] => Some(ByteOrder::Little),
        [1, 0, b'M', b'I'] => Some(ByteOrder::Big),
        _ => None,
    }
}

/// Lists the variables of a file and returns those that were inflated.
pub(super) fn list(bytes: &[u8], listing: &mut Listing) -> Result<Vec<Vec<u8>>> {
    let Some(order) = byte_order(bytes) else {
        let found = bytes.get(124..HEADER);
        let found = found.map_or("the end of the file".into(), |found| format!("{found:?}"));
        let expected = "version 1 and the mark of the byte order";
        return Err(Error::damaged("byte 124", expected, found));
    };
    let text = String::from_utf8_lossy(&bytes[..116]);
    let text = text.trim_end_matches(['\0', ' ']);
    listing.attributes.insert_text("header", text);

    let file = Part {
        bytes,
        source: Source::File,
        order,
    };
    let elements = file.top_level()?;
    let mut compressed = Vec::new();
    for element in elements.iter().filter(|e| e.kind == COMPRESSED) {
        let deflated = &bytes[element.range.clone()];
        let len = inflated_len(deflated, order, element.range.start)?;
        listing.count("inflating a variable", len)?;
        compressed.push((deflated, len, element.range.start));
    }
    let inflated = compressed
        .par_iter()
        .map(|(deflated, len, at)| inflate(deflated, *len, *at))
        .collect::<Result<Vec<_>>>()?;

    let mut next = 0;
    for element in elements {
        if element.kind == COMPRESSED {
            let part = Part {
                bytes: &inflated[next],
                source: Source::Inflated(next),
                order,
            };
            next += 1;
            part.matrix(8..part.bytes.len(), None, 0, listing)?;
        } else if element.kind == MATRIX {
            file.matrix(element.range, None, 0, listing)?;
        } else {
            let found = format!("an element of type {}", element.kind);
            return Err(file.damaged(element.range.start, "a matrix", found));
        }
    }
    Ok(inflated)
}

/// Bytes of a compressed matrix with its tag.
fn inflated_len(deflated: &[u8], order: ByteOrder, at: usize) -> Result<u64> {
    let mut tag = [0; 8];
    let place = || format!("byte {at}");
    ZlibDecoder::new(deflated)
        .read_exact(&mut tag)
        .map_err(|e| Error::damaged(place(), "a compressed matrix", e.to_string()))?;
    let [kind, len] = [word(order, &tag), word(order, &tag[4..])];
    if kind != MATRIX {
        let found = format!("an element of type {kind}");
        return Err(Error::damaged(place(), "a compressed matrix", found));
    }
    let len = u64::from(len) + 8;
    if len > MOST_INFLATION * deflated.len() as u64 {
        let expected = format!("at most {MOST_INFLATION} bytes for one that is compressed");
        return Err(Error::damaged(place(), expected, format!("{len} bytes")));
    }
    Ok(len)
}

fn inflate(deflated: &[u8], len: u64, at: usize) -> Result<Vec<u8>> {
    let mut out = Vec::new();
    // One more, so that the end of the stream and its checksum are read.
    let reserved = usize::try_from(len + 1)
        .ok()
        .and_then(|len| out.try_reserve_exact(len).ok());
    if reserved.is_none() {
        return Err(Error::Memory {
            what: "inflating a variable".into(),
            needed: len,
            allowed: 0,
        });
    }
    let damaged =
        |found: String| Error::damaged(format!("byte {at}"), format!("{len} bytes"), found);
    let read = ZlibDecoder::new(deflated)
        .take(len + 1)
        .read_to_end(&mut out);
    read.map_err(|e| damaged(e.to_string()))?;
    match out.len() as u64 {
        found if found < len => Err(damaged(found.to_string())),
        found if found > len => Err(damaged("more".into())),
        _ => Ok(out),
    }
}

/// A file or an inflated variable.
#[derive(Clone, Copy)]
struct Part<'a> {
    bytes: &'a [u8],
    source: Source,
    order: ByteOrder,
}

/// An element without its tag.
struct Element {
    kind: u32,
    range: Range<usize>,
}

/// Elements one after another.
struct Elements<'a> {
    part: Part<'a>,
    rest: Range<usize>,
}

/// What the header of a matrix says.
struct Header {
    class: u8,
    is_complex: bool,
    is_logical: bool,
    shape: Vec<u64>,
}

impl<'a> Part<'a> {
    fn damaged(&self, at: usize, expected: impl Into<String>, found: impl Into<String>) -> Error {
        Error::damaged(self.place(at), expected, found)
    }

    fn place(&self, at: usize) -> String {
        match self.source {
            Source::File => format!("byte {at}"),
            Source::Inflated(i) => format!("byte {at} of compressed variable {}", i + 1),
        }
    }

    fn word(&self, at: usize) -> u32 {
        word(self.order, &self.bytes[at..])
    }

    fn top_level(self) -> Result<Vec<Element>> {
        let mut elements = Elements {
            part: self,
            rest: HEADER..self.bytes.len(),
        };
        let mut all = Vec::new();
        while !elements.rest.is_empty() {
            all.push(elements.next("a variable")?);
        }
        Ok(all)
    }

    /// Lists a matrix, or what a struct or cell array holds, under `path`, or under its own name.
    fn matrix(
        self,
        range: Range<usize>,
        path: Option<String>,
        depth: usize,
        listing: &mut Listing,
    ) -> Result<()> {
        let at = range.start;
        let mut elements = Elements {
            part: self,
            rest: range,
        };
        if elements.rest.is_empty() {
            // `[]` in a struct or cell array.
            let place = (self.source, at, self.order);
            return listing.push_numbers(
                path.unwrap_or_default(),
                &[0, 0],
                Sample::F64,
                Sample::F64,
                place,
            );
        }
        let flags = elements.next("flags of an array")?;
        if flags.kind != UINT32 || flags.range.len() != 8 {
            let found = format!("type {}, {} bytes", flags.kind, flags.range.len());
            return Err(self.damaged(flags.range.start, "flags of an array", found));
        }
        let flags = self.word(flags.range.start);
        let class = flags as u8;
        let shape = match class {
            17 => Vec::new(),
            _ => elements.shape()?,
        };
        let header = Header {
            class,
            is_complex: flags & 0x800 != 0,
            is_logical: flags & 0x200 != 0,
            shape,
        };
        let name = elements.text("the name of an array")?;
        let path = path.unwrap_or(name);
        let shape = &header.shape;
        if path.is_empty() {
            // What MATLAB keeps about objects of other variables.
            let path = "__function_workspace__".into();
            return listing.push_other(path, shape, "data of objects".into());
        }
        match class {
            1 => elements.cells(&header, path, depth, listing),
            2 => elements.structs(&header, path, depth, listing),
            3 | 17 => listing.push_other(path, shape, "an object".into()),
            4 => elements.characters(&header, path, listing),
            5 => listing.push_other(path, shape, "a sparse matrix".into()),
            16 => listing.push_other(path, shape, "a function handle".into()),
            6..=15 => elements.numbers(&header, path, listing),
            _ => Err(self.damaged(at, "a class of 1 to 17", class.to_string())),
        }
    }
}

impl Elements<'_> {
    fn next(&mut self, expected: &str) -> Result<Element> {
        let Range { start, end } = self.rest;
        let part = self.part;
        let short = || {
            let found = format!("its end at byte {end}");
            Err(part.damaged(start, expected, found))
        };
        if end - start < 8 {
            return short();
        }
        let tag = part.word(start);
        let (kind, from, len) = match tag >> 16 {
            0 => (tag, start + 8, part.word(start + 4) as usize),
            small if small <= 4 => (tag & 0xffff, start + 4, small as usize),
            small => {
                let found = format!("{small} bytes");
                return Err(part.damaged(start, "at most 4 bytes in a small element", found));
            }
        };
        let room = if tag >> 16 == 0 { end - from } else { 4 };
        if len > room {
            return short();
        }
        // Elements begin at multiples of 8 bytes from the first, but those that are compressed.
        let padded = match kind {
            _ if tag >> 16 != 0 => 4,
            COMPRESSED => len,
            _ => len.next_multiple_of(8),
        };
        self.rest.start = end.min(from + padded);
        Ok(Element {
            kind,
            range: from..from + len,
        })
    }

    fn shape(&mut self) -> Result<Vec<u64>> {
        let lengths = self.next("dimensions of an array")?;
        let part = self.part;
        let at = lengths.range.start;
        let rank = lengths.range.len() / 4;
        let is_whole = lengths.range.len() % 4 == 0 && (2..=MOST_DIMENSIONS).contains(&rank);
        if !matches!(lengths.kind, INT32 | UINT32) || !is_whole {
            let expected = format!("2 to {MOST_DIMENSIONS} lengths of dimensions");
            let found = format!("type {}, {} bytes", lengths.kind, lengths.range.len());
            return Err(part.damaged(at, expected, found));
        }
        let lengths = lengths.range.step_by(4).map(|at| part.word(at));
        let length = |length: u32| match i32::try_from(length) {
            Ok(_) => Ok(u64::from(length)),
            Err(_) => Err(part.damaged(at, "a length of 0 or more", (length as i32).to_string())),
        };
        let shape = lengths.map(length).collect::<Result<Vec<_>>>()?;
        count(&shape, || part.place(at))?;
        Ok(shape)
    }

    fn text(&mut self, expected: &str) -> Result<String> {
        let name = self.next(expected)?;
        if !matches!(name.kind, INT8 | UINT8 | UTF8) {
            let found = format!("an element of type {}", name.kind);
            return Err(self.part.damaged(name.range.start, expected, found));
        }
        Ok(until_zero(&self.part.bytes[name.range]))
    }

    fn member(&mut self, path: String, depth: usize, listing: &mut Listing) -> Result<()> {
        let member = self.next("an array in a struct or cell array")?;
        if member.kind != MATRIX {
            let found = format!("an element of type {}", member.kind);
            return Err(self.part.damaged(member.range.start, "an array", found));
        }
        self.part
            .matrix(member.range, Some(path), depth + 1, listing)
    }

    fn cells(
        mut self,
        header: &Header,
        path: String,
        depth: usize,
        listing: &mut Listing,
    ) -> Result<()> {
        let cells: u64 = header.shape.iter().product();
        if cells > MOST_MEMBERS || depth == MOST_DEPTH {
            let what = format!("a cell array of {cells} arrays");
            return listing.push_other(path, &header.shape, what);
        }
        for i in 1..=cells {
            self.member(format!("{path}{{{i}}}"), depth, listing)?;
        }
        Ok(())
    }

    fn structs(
        mut self,
        header: &Header,
        path: String,
        depth: usize,
        listing: &mut Listing,
    ) -> Result<()> {
        let expected = "the length of names of fields";
        let element = self.next(expected)?;
        let at = element.range.start;
        if element.range.len() != 4 {
            let found = format!("{} bytes", element.range.len());
            return Err(self.part.damaged(at, expected, found));
        }
        let name_len = self.part.word(at) as usize;
        let names = self.next("names of fields")?;
        let names = &self.part.bytes[names.range];
        if !names.is_empty()
            && (name_len == 0 || name_len > MOST_NAME || !names.len().is_multiple_of(name_len))
        {
            let found = format!("{name_len} bytes a name, {} in all", names.len());
            return Err(self.part.damaged(at, expected, found));
        }
        let fields = names.len().checked_div(name_len).unwrap_or(0) as u64;
        let structs: u64 = header.shape.iter().product();
        let members = structs.saturating_mul(fields);
        if members > MOST_MEMBERS || members == 0 || depth == MOST_DEPTH {
            let what = format!("an array of {structs} structs of {fields} fields");
            return listing.push_other(path, &header.shape, what);
        }
        for i in 1..=structs {
            for name in names.chunks_exact(name_len) {
                let name = until_zero(name);
                let path = match structs {
                    1 => format!("{path}.{name}"),
                    _ => format!("{path}({i}).{name}"),
                };
                self.member(path, depth, listing)?;
            }
        }
        Ok(())
    }

    fn characters(mut self, header: &Header, path: String, listing: &mut Listing) -> Result<()> {
        let shape = &header.shape;
        if shape.contains(&0) && self.rest.is_empty() {
            return listing.push_text(path, shape, Vec::new());
        }
        let element = self.next("characters")?;
        let at = element.range.start;
        let bytes = &self.part.bytes[element.range];
        // At worst each character is a `String`.
        listing.count("text", (bytes.len() as u64).saturating_mul(40))?;
        let order = self.part.order;
        let text: Vec<char> = match element.kind {
            INT8 | UTF8 => String::from_utf8_lossy(bytes).chars().collect(),
            UINT8 => bytes.iter().map(|byte| char::from(*byte)).collect(),
            UINT16 | UTF16 => {
                let units = bytes.chunks_exact(2).map(|unit| match order {
                    ByteOrder::Little => u16::from_le_bytes([unit[0], unit[1]]),
                    ByteOrder::Big => u16::from_be_bytes([unit[0], unit[1]]),
                });
                let characters = char::decode_utf16(units);
                characters
                    .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
                    .collect()
            }
            UTF32 | UINT32 => {
                let characters = bytes
                    .chunks_exact(4)
                    .map(|c| char::from_u32(word(order, c)));
                characters
                    .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
                    .collect()
            }
            other => {
                let found = format!("an element of type {other}");
                return Err(self.part.damaged(at, "characters", found));
            }
        };
        let rows = rows_of_text(shape, &text, self.part.place(at))?;
        listing.push_text(path, shape, rows)
    }

    fn numbers(mut self, header: &Header, path: String, listing: &mut Listing) -> Result<()> {
        let shape = &header.shape;
        if header.is_complex {
            return listing.push_other(path, shape, "complex numbers".into());
        }
        let class = match header.class {
            _ if header.is_logical => Sample::Bool,
            6 => Sample::F64,
            7 => Sample::F32,
            8 => Sample::I8,
            9 => Sample::U8,
            10 => Sample::I16,
            11 => Sample::U16,
            12 => Sample::I32,
            13 => Sample::U32,
            14 => Sample::I64,
            _ => Sample::U64,
        };
        let count: u64 = shape.iter().product();
        if count == 0 {
            let place = (self.part.source, self.rest.start, self.part.order);
            return listing.push_numbers(path, shape, class, class, place);
        }
        let element = self.next("numbers")?;
        let start = element.range.start;
        let disk = match element.kind {
            INT8 => Sample::I8,
            UINT8 => Sample::U8,
            3 => Sample::I16,
            UINT16 => Sample::U16,
            INT32 => Sample::I32,
            UINT32 => Sample::U32,
            7 => Sample::F32,
            9 => Sample::F64,
            12 => Sample::I64,
            13 => Sample::U64,
            other => {
                let found = format!("an element of type {other}");
                return Err(self.part.damaged(start, "numbers", found));
            }
        };
        if count.checked_mul(disk.bytes() as u64) != Some(element.range.len() as u64) {
            let expected = format!("{count} numbers of type {}", disk.name());
            let found = format!("{} bytes", element.range.len());
            return Err(self.part.damaged(start, expected, found));
        }
        let is_float = |sample| matches!(sample, Sample::F64 | Sample::F32);
        if is_float(disk) && !is_float(class) && class != Sample::Bool {
            let what = format!("{} stored as {}", class.name(), disk.name());
            return listing.push_other(path, shape, what);
        }
        let place = (self.part.source, start, self.part.order);
        listing.push_numbers(path, shape, class, disk, place)
    }
}

/// The first four bytes as a number.
fn word(order: ByteOrder, bytes: &[u8]) -> u32 {
    let four = [bytes[0], bytes[1], bytes[2], bytes[3]];
    match order {
        ByteOrder::Little => u32::from_le_bytes(four),
        ByteOrder::Big => u32::from_be_bytes(four),
    }
}

fn until_zero(name: &[u8]) -> String {
    let name = name.split(|c| *c == 0).next();
    String::from_utf8_lossy(name.unwrap_or_default()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// A file with a compressed matrix whose tag promises `len` bytes and holds 16 MiB of zeros.
    fn bomb(len: u32) -> Vec<u8> {
        let mut file = vec![b' '; HEADER];
        file[124..].copy_from_slice(&[0, 1, b'I', b'M']);
        let level = flate2::Compression::best();
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), level);
        encoder.write_all(&MATRIX.to_le_bytes()).unwrap();
        encoder.write_all(&len.to_le_bytes()).unwrap();
        encoder.write_all(&vec![0; 16 << 20]).unwrap();
        let deflated = encoder.finish().unwrap();
        file.extend(COMPRESSED.to_le_bytes());
        file.extend((deflated.len() as u32).to_le_bytes());
        file.extend(deflated);
        file
    }

    #[test]
    fn regress_inflation_is_bounded() {
        let refused = |len, memory| list(&bomb(len), &mut Listing::new(memory)).unwrap_err();
        let memory = refused(16 << 20, Some(1 << 20));
        assert!(matches!(memory, Error::Memory { .. }), "{memory}");
        for (len, why) in [(1 << 10, "found more"), (u32::MAX, "at most 1032 bytes")] {
            let damaged = refused(len, None).to_string();
            assert!(damaged.contains(why), "{damaged}");
        }
    }
}
