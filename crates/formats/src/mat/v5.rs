//! Versions 5 to 7: elements with a tag of type and length, some of them compressed.

use std::io::Read;
use std::ops::Range;
use std::sync::Arc;

use flate2::read::ZlibDecoder;
use rayon::prelude::*;

use super::listing::{Listing, Part};
use super::until_zero;
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

/// Numbers of the classes from 6 to 15, and the types of elements that hold such numbers.
const CLASSES: [Sample; 10] = {
    use Sample::*;
    [F64, F32, I8, U8, I16, U16, I32, U32, I64, U64]
};
const TYPES: [u32; 10] = [9, 7, INT8, UINT8, 3, UINT16, INT32, UINT32, 12, 13];

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
    for (_, range) in elements.iter().filter(|(kind, _)| *kind == COMPRESSED) {
        let len = inflated_len(&file, range)?;
        listing.budget.take(len)?;
        compressed.push((range, len));
    }
    let inflated = compressed.par_iter();
    let inflated = inflated.map(|(range, len)| inflate(&file, range, *len));
    let inflated = inflated.collect::<Result<Vec<Bytes>>>()?;

    let mut inflated = inflated.iter().zip(1..);
    for (kind, range) in &elements {
        let (part, range) = match kind {
            &MATRIX => (file, range.clone()),
            &COMPRESSED => {
                let (own, number) = inflated.next().expect("as many as are compressed");
                let bytes = (**own).as_ref();
                let inflated = Some((own, number));
                let part = Part {
                    bytes,
                    inflated,
                    ..file
                };
                (part, 8..bytes.len())
            }
            other => return Err(file.other(range.start, "a matrix", *other)),
        };
        list_array(part, range, None, 0, listing)?;
    }
    Ok(())
}

/// Bytes of a compressed matrix with its tag.
fn inflated_len(file: &Part, range: &Range<usize>) -> Result<u64> {
    let deflated = &file.bytes[range.clone()];
    let mut tag = [0; 8];
    let read = ZlibDecoder::new(deflated).read_exact(&mut tag);
    read.map_err(|error| file.damaged(range.start, "a compressed matrix", error))?;
    let [kind, len] = [word(file.order, &tag), word(file.order, &tag[4..])];
    if kind != MATRIX {
        return Err(file.other(range.start, "a compressed matrix", kind));
    }
    let len = u64::from(len) + 8;
    if len > MAX_INFLATION * deflated.len() as u64 {
        let expected = format!("at most {MAX_INFLATION} bytes for one that is compressed");
        return Err(file.damaged(range.start, expected, format!("{len} bytes")));
    }
    Ok(len)
}

fn inflate(file: &Part, range: &Range<usize>, len: u64) -> Result<Bytes> {
    let mut out = Vec::new();
    // One more, so that the end of the stream and its checksum are read.
    let most = usize::try_from(len + 1).unwrap_or(usize::MAX);
    out.try_reserve_exact(most).map_err(|_| Error::Memory {
        what: "inflating a variable".into(),
        needed: len,
        allowed: 0,
    })?;
    let decoder = ZlibDecoder::new(&file.bytes[range.clone()]);
    let found = match decoder.take(len + 1).read_to_end(&mut out) {
        Err(error) => error.to_string(),
        Ok(found) if found as u64 == len => return Ok(Arc::new(out)),
        Ok(found) if found as u64 > len => "more".into(),
        Ok(found) => found.to_string(),
    };
    Err(file.damaged(range.start, format!("{len} bytes"), found))
}

/// Elements one after another, each with a tag of its type and length.
struct Elements<'a> {
    part: Part<'a>,
    rest: Range<usize>,
}

impl Part<'_> {
    /// What is wrong with an element of this type.
    fn other(&self, at: usize, expected: &str, kind: u32) -> Error {
        self.damaged(at, expected, format!("an element of type {kind}"))
    }
}

impl Elements<'_> {
    /// The type of the next element, and where it is.
    fn next(&mut self, expected: &str) -> Result<(u32, Range<usize>)> {
        let Range { start, end } = self.rest;
        let part = self.part;
        let short = || {
            let found = format!("its end at byte {end}");
            Err(part.damaged(start, expected, found))
        };
        if end - start < 8 {
            return short();
        }
        let tag = word(part.order, &part.bytes[start..]);
        let (kind, from, len, room) = match tag >> 16 {
            0 => {
                let len = word(part.order, &part.bytes[start + 4..]) as usize;
                (tag, start + 8, len, end - start - 8)
            }
            small if small <= 4 => (tag & 0xffff, start + 4, small as usize, 4),
            small => {
                let found = format!("{small} bytes");
                return Err(part.damaged(start, "at most 4 bytes in a small element", found));
            }
        };
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
        Ok((kind, from..from + len))
    }

    /// The next element, which is of one of these types.
    fn next_of(&mut self, kinds: &[u32], expected: &str) -> Result<Range<usize>> {
        let (kind, range) = self.next(expected)?;
        match kinds.contains(&kind) {
            true => Ok(range),
            false => Err(self.part.other(range.start, expected, kind)),
        }
    }

    /// The next element as numbers of four bytes.
    fn words(&mut self, expected: &str) -> Result<(usize, Vec<u32>)> {
        let range = self.next_of(&[INT32, UINT32], expected)?;
        let words = self.part.bytes[range.clone()].chunks(4);
        let order = self.part.order;
        match range.len() % 4 {
            0 => Ok((range.start, words.map(|one| word(order, one)).collect())),
            _ => {
                let found = format!("{} bytes", range.len());
                Err(self.part.damaged(range.start, expected, found))
            }
        }
    }

    fn shape(&mut self) -> Result<Vec<u64>> {
        let (at, lengths) = self.words("dimensions of an array")?;
        if !(2..=MOST_DIMENSIONS).contains(&lengths.len()) {
            let expected = format!("2 to {MOST_DIMENSIONS} lengths of dimensions");
            return Err(self.part.damaged(at, expected, lengths.len()));
        }
        let lengths = lengths.into_iter().map(u64::from);
        let shape: Vec<u64> = lengths.collect();
        let count = shape.iter().try_fold(1u64, |n, len| n.checked_mul(*len));
        let is_long = |len: &u64| i32::try_from(*len).is_err();
        match count.is_none() || shape.iter().any(is_long) {
            true => {
                let expected = "lengths of dimensions from 0 to 2^31";
                Err(self.part.damaged(at, expected, format!("{shape:?}")))
            }
            false => Ok(shape),
        }
    }
}

/// An array behind its header.
struct Array<'a> {
    elements: Elements<'a>,
    path: String,
    shape: Vec<u64>,
    /// How many structs and cells hold it.
    depth: usize,
    listing: &'a mut Listing,
}

/// Lists an array, or what a struct or cell array holds, under `path`, or under its own name.
fn list_array(
    part: Part,
    range: Range<usize>,
    path: Option<String>,
    depth: usize,
    listing: &mut Listing,
) -> Result<()> {
    let at = range.start;
    let mut elements = Elements { part, rest: range };
    if elements.rest.is_empty() {
        // `[]` in a struct or cell array.
        let path = path.unwrap_or_default();
        return listing.push_numbers(path, &[0, 0], [Sample::F64; 2], part, at);
    }
    let (at_flags, flags) = elements.words("flags of an array")?;
    let [flags, _] = flags[..] else {
        return Err(part.damaged(at_flags, "two words of flags of an array", flags.len()));
    };
    let (class, is_complex, is_logical) = (flags as u8, flags & 0x800 != 0, flags & 0x200 != 0);
    let shape = match class {
        17 => Vec::new(),
        _ => elements.shape()?,
    };
    let name = elements.next_of(&[INT8, UINT8, UTF8], "the name of an array")?;
    let mut array = Array {
        elements,
        path: path.unwrap_or_else(|| until_zero(&part.bytes[name])),
        shape,
        depth,
        listing,
    };
    if array.path.is_empty() {
        // What MATLAB keeps about objects of other variables.
        array.path = "__function_workspace__".into();
        return array.other("data of objects");
    }
    match class {
        1 => array.cells(),
        2 => array.structs(),
        3 | 17 => array.other("an object"),
        4 => array.characters(),
        5 => array.other("a sparse matrix"),
        16 => array.other("a function handle"),
        6..=15 if is_complex => array.other("complex numbers"),
        6..=15 if is_logical => array.numbers(Sample::Bool),
        6..=15 => array.numbers(CLASSES[usize::from(class) - 6]),
        _ => Err(part.damaged(at, "a class of 1 to 17", class)),
    }
}

impl Array<'_> {
    /// Lists what holds no numbers.
    fn other(self, what: &str) -> Result<()> {
        self.listing.push_other(self.path, &self.shape, what)
    }

    fn member(&mut self, path: String) -> Result<()> {
        let expected = "an array in a struct or cell array";
        let range = self.elements.next_of(&[MATRIX], expected)?;
        let (part, depth) = (self.elements.part, self.depth + 1);
        list_array(part, range, Some(path), depth, self.listing)
    }

    fn cells(mut self) -> Result<()> {
        let cells: u64 = self.shape.iter().product();
        if cells > MOST_MEMBERS || self.depth == MOST_DEPTH {
            return self.other(&format!("a cell array of {cells} arrays"));
        }
        for i in 1..=cells {
            self.member(format!("{}{{{i}}}", self.path))?;
        }
        Ok(())
    }

    fn structs(mut self) -> Result<()> {
        let part = self.elements.part;
        let (at, name_len) = self.elements.words("the length of names of fields")?;
        let (_, names) = self.elements.next("names of fields")?;
        let (name_len, names) = (name_len.first().copied(), &part.bytes[names]);
        let name_len = name_len.map_or(0, |len| len as usize);
        let is_whole = (1..=MOST_NAME).contains(&name_len) && names.len().is_multiple_of(name_len);
        if !names.is_empty() && !is_whole {
            let found = format!("{name_len} bytes a name, {} in all", names.len());
            return Err(part.damaged(at, "the length of names of fields", found));
        }
        let fields = names.len().checked_div(name_len).unwrap_or(0) as u64;
        let structs: u64 = self.shape.iter().product();
        let members = structs.saturating_mul(fields);
        if members > MOST_MEMBERS || members == 0 || self.depth == MOST_DEPTH {
            return self.other(&format!("an array of {structs} structs of {fields} fields"));
        }
        for i in 1..=structs {
            for name in names.chunks_exact(name_len).map(until_zero) {
                self.member(match structs {
                    1 => format!("{}.{name}", self.path),
                    _ => format!("{}({i}).{name}", self.path),
                })?;
            }
        }
        Ok(())
    }

    fn characters(mut self) -> Result<()> {
        let part = self.elements.part;
        let (at, text) = match self.shape.contains(&0) && self.elements.rest.is_empty() {
            true => (self.elements.rest.start, String::new()),
            false => {
                let (kind, range) = self.elements.next("characters")?;
                let bytes = &part.bytes[range.clone()];
                // At worst each character is a `String`.
                let most = (bytes.len() as u64).saturating_mul(40);
                self.listing.budget.take(most)?;
                let text = text(kind, part.order, bytes);
                let text = text.ok_or_else(|| part.other(range.start, "characters", kind))?;
                (range.start, text)
            }
        };
        self.listing
            .push_text(self.path, &self.shape, text, (part, at))
    }

    fn numbers(mut self, class: Sample) -> Result<()> {
        let (part, shape) = (self.elements.part, &self.shape);
        let count: u64 = shape.iter().product();
        let (disk, start) = match count {
            0 => (class, self.elements.rest.start),
            _ => {
                let (kind, range) = self.elements.next("numbers")?;
                let known = TYPES.iter().position(|known| *known == kind);
                let disk = known.map(|known| CLASSES[known]);
                let disk = disk.ok_or_else(|| part.other(range.start, "numbers", kind))?;
                if count.checked_mul(disk.bytes() as u64) != Some(range.len() as u64) {
                    let expected = format!("{count} numbers of type {}", disk.name());
                    let found = format!("{} bytes", range.len());
                    return Err(part.damaged(range.start, expected, found));
                }
                (disk, range.start)
            }
        };
        if disk.is_float() && !class.is_float() && class != Sample::Bool {
            return self.other(&format!("{} stored as {}", class.name(), disk.name()));
        }
        self.listing
            .push_numbers(self.path, shape, [class, disk], part, start)
    }
}

/// Characters of an element of type `kind`; none of other types.
fn text(kind: u32, order: ByteOrder, bytes: &[u8]) -> Option<String> {
    const UNKNOWN: char = char::REPLACEMENT_CHARACTER;
    Some(match kind {
        INT8 | UTF8 => String::from_utf8_lossy(bytes).into_owned(),
        UINT8 => bytes.iter().map(|byte| char::from(*byte)).collect(),
        UINT16 | UTF16 => {
            let units = bytes.chunks_exact(2);
            let units = units.map(|unit| order.unsigned(unit) as u16);
            let characters = char::decode_utf16(units);
            characters.map(|c| c.unwrap_or(UNKNOWN)).collect()
        }
        UTF32 | UINT32 => {
            let codes = bytes.chunks_exact(4).map(|code| word(order, code));
            let characters = codes.map(char::from_u32);
            characters.map(|c| c.unwrap_or(UNKNOWN)).collect()
        }
        _ => return None,
    })
}

/// The first four bytes as a number.
fn word(order: ByteOrder, bytes: &[u8]) -> u32 {
    order.unsigned(&bytes[..4]) as u32
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
