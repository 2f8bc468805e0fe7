//! NetCDF-3: classic, with offsets of 64 bits, with lengths of 64 bits (CDF-5).

use crate::container::assign_coordinates;
use crate::cursor::{Budget, Cursor, beginning};
use crate::{
    Attributes, ByteOrder, Bytes, Container, Dimension, Error, Format, Options, Place, Result,
    Sample, Value, Variable, strides,
};

const DIMENSIONS: u32 = 10;
const VARIABLES: u32 = 11;
const ATTRIBUTES: u32 = 12;
const CHAR: u32 = 2;
/// The limits of the netCDF library.
const MOST_NAME: u64 = 256;
const MOST_DIMENSIONS: u64 = 1024;

/// The format of these bytes, if it is the one of this module.
pub(crate) fn detect(bytes: &[u8]) -> Option<Format> {
    match bytes {
        [b'C', b'D', b'F', 1 | 2 | 5, ..] => Some(Format::NetCdf3),
        _ => None,
    }
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let mut container = Container::new(format, &bytes);
    let bytes = (*bytes).as_ref();
    if detect(bytes).is_none() {
        let expected = "CDF of version 1, 2 or 5";
        return Err(Error::damaged("byte 0", expected, beginning(bytes)));
    }
    let cursor = Cursor {
        bytes,
        at: 4,
        order: ByteOrder::Big,
    };
    let mut header = Header {
        cursor,
        version: bytes[3],
        budget: Budget::new("the header of a NetCDF-3 file", options),
    };
    let records = header.length("the number of records")?;
    if records == u64::MAX >> if header.version == 5 { 0 } else { 32 } {
        let what = "a NetCDF-3 file whose number of records was left open";
        return Err(Error::unsupported(what, "copy it with nccopy"));
    }
    let mut dimensions = Vec::new();
    for _ in 0..header.list(DIMENSIONS, "dimensions")? {
        let name = header.name()?;
        dimensions.push((name, header.length("the length of a dimension")?));
    }
    container.attributes = header.attributes()?;
    let mut entries = Vec::new();
    for _ in 0..header.list(VARIABLES, "variables")? {
        entries.push(header.entry(&dimensions)?);
    }
    // A single variable of records is not padded.
    let of_records = || entries.iter().filter(|entry| entry.is_record);
    let padded = if of_records().count() == 1 { 1 } else { 4 };
    let mut slabs =
        of_records().map(|entry| entry.slab(&dimensions)?.checked_next_multiple_of(padded));
    let record = slabs.try_fold(0u64, |sum, slab| sum.checked_add(slab?));
    let record = record.unwrap_or(u64::MAX);
    for entry in entries {
        let of = entry.dimensions.iter().map(|d| &dimensions[*d]);
        let of = of.map(|(name, len)| Dimension::new(*len).named(name.clone()));
        let mut of: Vec<Dimension> = of.collect();
        let shape: Vec<u64> = of.iter().map(|d| d.len).collect();
        let mut strides = strides(&shape, sample(entry.kind).unwrap_or(Sample::U8), false);
        let mut end = entry.slab(&dimensions);
        if entry.is_record {
            of[0].len = records;
            strides[0] = record;
            let before = record.checked_mul(records.saturating_sub(1));
            end = end.and_then(|slab| slab.checked_add(before?));
        }
        let end = end.and_then(|bytes| bytes.checked_add(entry.begin));
        let mut variable = match sample(entry.kind) {
            Some(sample) => Variable::new(entry.name, of, sample),
            None => Variable::other(entry.name, of, "text"),
        };
        let end = end.filter(|_| variable.count().is_some());
        if variable.count() != Some(0) && end.is_none_or(|end| end > bytes.len() as u64) {
            let expected = format!("{} bytes", end.map_or("2^64".into(), |end| end.to_string()));
            return Err(variable.damaged(expected, format!("a file of {}", bytes.len())));
        }
        variable.attributes = entry.attributes;
        variable.place = Place::in_file(entry.begin, strides, ByteOrder::Big);
        container.push(variable);
    }
    assign_coordinates(&mut container.variables);
    Ok(container)
}

/// A variable before the length of a record is known.
struct Entry {
    name: String,
    dimensions: Vec<usize>,
    /// Whether its first dimension counts records, as that of length 0 does.
    is_record: bool,
    attributes: Attributes,
    kind: u32,
    begin: u64,
}

impl Entry {
    /// Bytes of one record, or of all samples; none beyond a `u64`.
    fn slab(&self, dimensions: &[(String, u64)]) -> Option<u64> {
        let within = &self.dimensions[usize::from(self.is_record)..];
        let mut sizes = within.iter().map(|d| dimensions[*d].1);
        sizes.try_fold(size(self.kind), u64::checked_mul)
    }
}

/// The header while it is read.
struct Header<'a> {
    cursor: Cursor<'a>,
    version: u8,
    budget: Budget,
}

impl<'a> Header<'a> {
    /// Bytes with what fills them up to a multiple of 4.
    fn padded(&mut self, len: u64, expected: &str) -> Result<&'a [u8]> {
        let taken = self.cursor.take(len, expected)?;
        self.cursor.take(len.wrapping_neg() % 4, expected)?;
        Ok(taken)
    }

    /// A number of 4 bytes, of 8 in CDF-5.
    fn length(&mut self, expected: &str) -> Result<u64> {
        let bytes = if self.version == 5 { 8 } else { 4 };
        self.cursor.number(bytes, expected)
    }

    /// A number that is not too large.
    fn length_to(&mut self, most: u64, expected: &str) -> Result<u64> {
        let at = self.cursor;
        let found = self.length(expected)?;
        match found <= most {
            true => Ok(found),
            false => Err(at.damaged(format!("{expected}, at most {most}"), found)),
        }
    }

    /// How many entries a list has; each takes 8 bytes or more.
    fn list(&mut self, tag: u32, expected: &str) -> Result<u64> {
        let at = self.cursor;
        let found = self.cursor.u32(expected)?;
        let len = self.length(expected)?;
        if found != tag && (found, len) != (0, 0) {
            let found = format!("tag {found}, {len} entries");
            return Err(at.damaged(format!("the list of {expected}"), found));
        }
        // A listed entry takes more memory than in the file, but no more than this.
        self.budget.take(len.saturating_mul(256))?;
        Ok(len)
    }

    fn name(&mut self) -> Result<String> {
        let len = self.length_to(MOST_NAME, "the length of a name")?;
        let name = self.padded(len, "a name")?;
        Ok(String::from_utf8_lossy(name).into_owned())
    }

    fn kind(&mut self) -> Result<u32> {
        let at = self.cursor;
        let kind = self.cursor.u32("a type")?;
        let most = if self.version == 5 { 11 } else { 6 };
        match (1..=most).contains(&kind) {
            true => Ok(kind),
            false => Err(at.damaged(format!("a type of 1 to {most}"), kind)),
        }
    }

    fn attributes(&mut self) -> Result<Attributes> {
        let mut attributes = Attributes::default();
        for _ in 0..self.list(ATTRIBUTES, "attributes")? {
            let name = self.name()?;
            let kind = self.kind()?;
            let len = self.length("the length of an attribute")?;
            let bytes = self.padded(len.saturating_mul(size(kind)), "an attribute")?;
            self.budget.take((bytes.len() as u64).saturating_mul(8))?;
            let value = match sample(kind) {
                Some(sample) => Value::of_samples(sample, ByteOrder::Big, bytes),
                None => {
                    let text = String::from_utf8_lossy(bytes);
                    Value::Text(text.trim_end_matches('\0').to_owned())
                }
            };
            attributes.insert(name, value);
        }
        Ok(attributes)
    }

    fn entry(&mut self, dimensions: &[(String, u64)]) -> Result<Entry> {
        let name = self.name()?;
        let mut of = Vec::new();
        for i in 0..self.length_to(MOST_DIMENSIONS, "the number of dimensions")? {
            let at = self.cursor;
            let d = self.length("the place of a dimension")?;
            let known = usize::try_from(d).ok().filter(|d| *d < dimensions.len());
            // Only the first dimension counts records.
            let known = known.filter(|d| i == 0 || dimensions[*d].1 != 0);
            let expected = || format!("one of {} dimensions", dimensions.len());
            let d = known.ok_or_else(|| at.damaged(expected(), d))?;
            let bytes = size_of::<Dimension>() + dimensions[d].0.len();
            self.budget.take(bytes as u64)?;
            of.push(d);
        }
        let attributes = self.attributes()?;
        let kind = self.kind()?;
        // The size in the file may be too large for its field; it follows from the dimensions.
        self.length("the size of a variable")?;
        let offset = if self.version == 1 { 4 } else { 8 };
        Ok(Entry {
            name,
            is_record: of.first().is_some_and(|first| dimensions[*first].1 == 0),
            dimensions: of,
            attributes,
            kind,
            begin: self.cursor.number(offset, "an offset")?,
        })
    }
}

/// The type of numbers; none for characters.
fn sample(kind: u32) -> Option<Sample> {
    use Sample::*;
    const SAMPLES: [Sample; 11] = [I8, I8, I16, I32, F32, F64, U8, U16, U32, I64, U64];
    let sample = SAMPLES.get((kind as usize).checked_sub(1)?);
    sample.copied().filter(|_| kind != CHAR)
}

fn size(kind: u32) -> u64 {
    sample(kind).map_or(1, |sample| sample.bytes() as u64)
}
