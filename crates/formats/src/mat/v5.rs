//! Versions 5 to 7: elements with a tag of type and length, some of them compressed.

use std::io::Read;
use std::ops::Range;
use std::sync::Arc;

use flate2::read::ZlibDecoder;
use rayon::prelude::*;

use super::listing::{Listing, Part, count, rows_of_text};
use crate::container::MAX_INFLATION;
use crate::cursor::beginning;
use crate::{ByteOrder, Bytes, Error, Result, Sample};

const HEADER: usize = 128;
/// Structs and cells within each other.
const MOST_DEPTH: usize = 32;
/// Members of one array of structs or cells that are listed.
const MOST_MEMBERS: u64 = 4096;
/// As NumPy and more than any field has.
const MOST_DIMENSIONS: usize = 32;
/// Bytes of the name of a field, beyond what MATLAB allows.
const MOST_NAME: usize = 4096;

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

/// Lists the variables of a file.
pub(super) fn list(bytes: &[u8], listing: &mut Listing) -> Result<()> {
    let Some(order) = byte_order(bytes) else {
        let expected = "version 1 of MATLAB 5 and the mark of the byte order";
        return Err(Error::damaged("byte 124", expected, beginning(bytes)));
    };
    let text = String::from_utf8_lossy(&bytes[..116]);
    let text = text.trim_end_matches(['\0', ' ']);
    listing.container.attributes.insert_text("header", text);

    let file = Part {
        bytes,
        order,
        inflated: None,
    };
    let mut all = Elements {
        part: file,
        rest: HEADER..bytes.len(),
    };
    let mut elements = Vec::new();
    while !all.rest.is_empty() {
        elements.push(all.next("a variable")?);
    }
    let mut compressed = Vec::new();
    for element in elements.iter().filter(|e| e.kind == COMPRESSED) {
        let deflated = &bytes[element.range.clone()];
        let len = inflated_len(deflated, order, element.range.start)?;
        listing.budget.take(len)?;
        compressed.push((deflated, len, element.range.start));
    }
    let inflated = compressed
        .par_iter()
        .map(|(deflated, len, at)| inflate(deflated, *len, *at))
        .collect::<Result<Vec<Bytes>>>()?;

    let mut inflated = inflated.iter().zip(1..);
    for element in elements {
        match element.kind {
            MATRIX => file.matrix(element.range, None, 0, listing)?,
            COMPRESSED => {
                let Some((own, number)) = inflated.next() else {
                    continue;
                };
                let part = Part {
                    bytes: (**own).as_ref(),
                    inflated: Some((own, number)),
                    ..file
                };
                part.matrix(8..part.bytes.len(), None, 0, listing)?;
            }
            other => {
                let found = format!("an element of type {other}");
                return Err(file.damaged(element.range.start, "a matrix", found));
            }
        }
    }
    Ok(())
}

/// Bytes of a compressed matrix with its tag.
fn inflated_len(deflated: &[u8], order: ByteOrder, at: usize) -> Result<u64> {
    let mut tag = [0; 8];
    let damaged = |expected: String, found: String| {
        Err(Error::damaged(format!("byte {at}"), expected, found))
    };
    let read = ZlibDecoder::new(deflated).read_exact(&mut tag);
    let [kind, len] = [word(order, &tag), word(order, &tag[4..])];
    match read {
        Err(error) => return damaged("a compressed matrix".into(), error.to_string()),
        Ok(()) if kind != MATRIX => {
            let found = format!("an element of type {kind}");
            return damaged("a compressed matrix".into(), found);
        }
        Ok(()) => {}
    }
    let len = u64::from(len) + 8;
    if len > MAX_INFLATION * deflated.len() as u64 {
        let expected = format!("at most {MAX_INFLATION} bytes for one that is compressed");
        return damaged(expected, format!("{len} bytes"));
    }
    Ok(len)
}

fn inflate(deflated: &[u8], len: u64, at: usize) -> Result<Bytes> {
    let mut out = Vec::new();
    // One more, so that the end of the stream and its checksum are read.
    let most = usize::try_from(len + 1).unwrap_or(usize::MAX);
    out.try_reserve_exact(most).map_err(|_| Error::Memory {
        what: "inflating a variable".into(),
        needed: len,
        allowed: 0,
    })?;
    let read = ZlibDecoder::new(deflated)
        .take(len + 1)
        .read_to_end(&mut out);
    let found = match (read, out.len() as u64) {
        (Err(error), _) => error.to_string(),
        (_, found) if found == len => return Ok(Arc::new(out)),
        (_, found) if found > len => "more".into(),
        (_, found) => found.to_string(),
    };
    Err(Error::damaged(
        format!("byte {at}"),
        format!("{len} bytes"),
        found,
    ))
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

impl Part<'_> {
    fn word(&self, at: usize) -> u32 {
        word(self.order, &self.bytes[at..])
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
            let path = path.unwrap_or_default();
            return listing.push_numbers(path, &[0, 0], [Sample::F64; 2], self, at);
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
            return listing.push_other(path, shape, "data of objects");
        }
        match class {
            1 => elements.cells(&header, path, depth, listing),
            2 => elements.structs(&header, path, depth, listing),
            3 | 17 => listing.push_other(path, shape, "an object"),
            4 => elements.characters(&header, path, listing),
            5 => listing.push_other(path, shape, "a sparse matrix"),
            16 => listing.push_other(path, shape, "a function handle"),
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
        match count(&shape) {
            Some(_) => Ok(shape),
            None => Err(part.damaged(at, "lengths of dimensions", format!("{shape:?}"))),
        }
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
            return listing.push_other(path, &header.shape, &what);
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
            return listing.push_other(path, &header.shape, &what);
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
        listing
            .budget
            .take((bytes.len() as u64).saturating_mul(40))?;
        let order = self.part.order;
        let text: String = match element.kind {
            INT8 | UTF8 => String::from_utf8_lossy(bytes).into_owned(),
            UINT8 => bytes.iter().map(|byte| char::from(*byte)).collect(),
            UINT16 | UTF16 => {
                let units = bytes
                    .chunks_exact(2)
                    .map(|unit| order.unsigned(unit) as u16);
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
        let text: Vec<char> = text.chars().collect();
        let found = format!("{} characters", text.len());
        let rows = rows_of_text(shape, &text);
        let rows = rows.map_err(|expected| self.part.damaged(at, expected, found))?;
        listing.push_text(path, shape, rows)
    }

    fn numbers(mut self, header: &Header, path: String, listing: &mut Listing) -> Result<()> {
        use Sample::*;
        /// Of the classes from 6 to 15.
        const CLASSES: [Sample; 10] = [F64, F32, I8, U8, I16, U16, I32, U32, I64, U64];
        /// By the types of elements.
        const TYPES: [Option<Sample>; 14] = [
            None,
            Some(I8),
            Some(U8),
            Some(I16),
            Some(U16),
            Some(I32),
            Some(U32),
            Some(F32),
            None,
            Some(F64),
            None,
            None,
            Some(I64),
            Some(U64),
        ];
        let shape = &header.shape;
        if header.is_complex {
            return listing.push_other(path, shape, "complex numbers");
        }
        let class = match header.is_logical {
            true => Bool,
            false => CLASSES[usize::from(header.class) - 6],
        };
        let count: u64 = shape.iter().product();
        if count == 0 {
            return listing.push_numbers(path, shape, [class; 2], self.part, self.rest.start);
        }
        let element = self.next("numbers")?;
        let start = element.range.start;
        let disk = TYPES.get(element.kind as usize).copied().flatten();
        let Some(disk) = disk else {
            let found = format!("an element of type {}", element.kind);
            return Err(self.part.damaged(start, "numbers", found));
        };
        if count.checked_mul(disk.bytes() as u64) != Some(element.range.len() as u64) {
            let expected = format!("{count} numbers of type {}", disk.name());
            let found = format!("{} bytes", element.range.len());
            return Err(self.part.damaged(start, expected, found));
        }
        if disk.is_float() && !class.is_float() && class != Bool {
            let what = format!("{} stored as {}", class.name(), disk.name());
            return listing.push_other(path, shape, &what);
        }
        listing.push_numbers(path, shape, [class, disk], self.part, start)
    }
}

/// The first four bytes as a number.
fn word(order: ByteOrder, bytes: &[u8]) -> u32 {
    order.unsigned(&bytes[..4]) as u32
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
        let refused = |len, memory| {
            let file: Bytes = Arc::new(bomb(len));
            let options = crate::Options { memory };
            crate::mat::open(crate::Format::Mat5, file, &options).unwrap_err()
        };
        let memory = refused(16 << 20, Some(1 << 20));
        assert!(matches!(memory, Error::Memory { .. }), "{memory}");
        for (len, why) in [(1 << 10, "found more"), (u32::MAX, "at most 1032 bytes")] {
            let damaged = refused(len, None).to_string();
            assert!(damaged.contains(why), "{damaged}");
        }
    }
}
