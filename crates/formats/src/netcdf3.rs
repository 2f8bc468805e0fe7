//! NetCDF-3: classic, with offsets of 64 bits, with lengths of 64 bits (CDF-5).

use crate::{
    Attributes, ByteOrder, Bytes, Container, Coordinate, Dimension, Error, Format, Options, Place,
    Result, Sample, SampleType, Value, Variable,
};

const DIMENSIONS: u32 = 10;
const VARIABLES: u32 = 11;
const ATTRIBUTES: u32 = 12;
const CHAR: u32 = 2;
/// The limits of the netCDF library.
const MOST_NAME: u64 = 256;
const MOST_DIMENSIONS: u64 = 1024;

/// The format of a file with this extension (lower case) and these bytes, if it is one of this module.
pub(crate) fn detect(_extension: &str, bytes: &[u8]) -> Option<Format> {
    match bytes {
        [b'C', b'D', b'F', 1 | 2 | 5, ..] => Some(Format::NetCdf3),
        _ => None,
    }
}

/// Opens a file of `format`.
pub(crate) fn open(format: Format, bytes: Bytes, options: &Options) -> Result<Container> {
    let found = Header::read((*bytes).as_ref(), options)?;
    let mut container = Container::new(format, bytes, None);
    container.attributes = found.attributes;
    container.variables = found.variables;
    Ok(container)
}

/// What the header of a file says.
struct Header {
    attributes: Attributes,
    variables: Vec<Variable>,
}

/// A variable before the length of a record is known.
struct Entry {
    name: String,
    dimensions: Vec<usize>,
    attributes: Attributes,
    kind: u32,
    begin: u64,
}

/// The bytes of the header that are left.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    version: u8,
    memory: Option<u64>,
    used: u64,
}

impl Header {
    fn read(bytes: &[u8], options: &Options) -> Result<Header> {
        let mut reader = Reader {
            bytes,
            at: 4,
            version: bytes.get(3).copied().unwrap_or_default(),
            memory: options.memory,
            used: 0,
        };
        if detect("", bytes).is_none() {
            let expected = "CDF of version 1, 2 or 5";
            return Err(Error::damaged("byte 0", expected, "something else"));
        }
        let records = reader.length("the number of records")?;
        let is_streaming = match reader.version {
            5 => records == u64::MAX,
            _ => records == u64::from(u32::MAX),
        };
        if is_streaming {
            return Err(Error::unsupported(
                "a NetCDF-3 file whose number of records was left open",
                "copy it with nccopy",
            ));
        }
        let mut dimensions = Vec::new();
        for _ in 0..reader.list(DIMENSIONS, "dimensions")? {
            let name = reader.name()?;
            let len = reader.length("the length of a dimension")?;
            dimensions.push((name, len));
        }
        let attributes = reader.attributes()?;
        let mut entries = Vec::new();
        for _ in 0..reader.list(VARIABLES, "variables")? {
            entries.push(reader.entry(&dimensions)?);
        }
        let variables = variables(bytes.len() as u64, records, &dimensions, entries)?;
        Ok(Header {
            attributes,
            variables,
        })
    }
}

fn variables(
    file: u64,
    records: u64,
    dimensions: &[(String, u64)],
    entries: Vec<Entry>,
) -> Result<Vec<Variable>> {
    // The dimension of length 0 counts records.
    let is_record = |entry: &Entry| {
        let first = entry.dimensions.first();
        first.is_some_and(|first| dimensions[*first].1 == 0)
    };
    let slab = |entry: &Entry| {
        let skipped = usize::from(is_record(entry));
        let mut sizes = entry.dimensions[skipped..].iter().map(|d| dimensions[*d].1);
        let slab = sizes.try_fold(size(entry.kind), u64::checked_mul);
        slab.ok_or_else(|| beyond(&entry.name, "more than 2^64", file))
    };
    let in_records: Vec<&Entry> = entries.iter().filter(|e| is_record(e)).collect();
    let mut record = 0u64;
    for entry in &in_records {
        let bytes = slab(entry)?;
        // A single variable of records is not padded.
        let bytes = match in_records.len() {
            1 => Some(bytes),
            _ => bytes.checked_next_multiple_of(4),
        };
        let sum = bytes.and_then(|bytes| record.checked_add(bytes));
        record = sum.ok_or_else(|| beyond(&entry.name, "more than 2^64", file))?;
    }

    // A variable of one dimension with its name holds the coordinate.
    let mut coordinates = vec![None; dimensions.len()];
    for (i, entry) in entries.iter().enumerate() {
        if let [d] = entry.dimensions[..]
            && entry.kind != CHAR
            && entry.name == dimensions[d].0
        {
            coordinates[d].get_or_insert(i);
        }
    }

    let mut variables = Vec::new();
    for entry in &entries {
        let bytes = slab(entry)?;
        let mut lengths: Vec<u64> = entry.dimensions.iter().map(|d| dimensions[*d].1).collect();
        let mut strides = vec![0; lengths.len()];
        let mut stride = size(entry.kind);
        for (len, slot) in lengths.iter().zip(&mut strides).rev() {
            *slot = stride;
            stride = stride.saturating_mul(*len);
        }
        let mut past = Some(bytes);
        if is_record(entry) {
            lengths[0] = records;
            strides[0] = record;
            past = match records {
                0 => Some(0),
                _ => record
                    .checked_mul(records - 1)
                    .and_then(|n| n.checked_add(bytes)),
            };
        }
        let end = past.and_then(|bytes| bytes.checked_add(entry.begin));
        if lengths
            .iter()
            .try_fold(1u64, |n, len| n.checked_mul(*len))
            .is_none()
        {
            return Err(beyond(&entry.name, "more than 2^64", file));
        }
        match end {
            _ if lengths.contains(&0) => {}
            Some(end) if end <= file => {}
            Some(end) => return Err(beyond(&entry.name, &end.to_string(), file)),
            None => return Err(beyond(&entry.name, "more than 2^64", file)),
        }
        let dimension = |(d, len): (&usize, &u64)| Dimension {
            name: Some(dimensions[*d].0.clone()),
            len: *len,
            coordinate: coordinates[*d].map(Coordinate::Listed),
        };
        variables.push(Variable {
            path: entry.name.clone(),
            dimensions: entry
                .dimensions
                .iter()
                .zip(&lengths)
                .map(dimension)
                .collect(),
            sample_type: match sample(entry.kind) {
                Some(sample) => SampleType::Number(sample),
                None => SampleType::Other("text".into()),
            },
            attributes: entry.attributes.clone(),
            place: Place::Strided {
                start: entry.begin,
                strides,
                order: ByteOrder::Big,
            },
        });
    }
    Ok(variables)
}

fn beyond(name: &str, end: &str, file: u64) -> Error {
    let place = format!("variable {name}");
    Error::damaged(place, format!("{end} bytes"), format!("a file of {file}"))
}

impl<'a> Reader<'a> {
    fn take(&mut self, len: u64, expected: &str) -> Result<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let taken = usize::try_from(len).ok().and_then(|len| rest.get(..len));
        let Some(taken) = taken else {
            let found = format!("{} bytes", rest.len());
            let expected = format!("{expected} ({len} bytes)");
            return Err(Error::damaged(format!("byte {}", self.at), expected, found));
        };
        self.at += taken.len();
        Ok(taken)
    }

    /// The same, with what fills it up to a multiple of 4.
    fn take_padded(&mut self, len: u64, expected: &str) -> Result<&'a [u8]> {
        let taken = self.take(len, expected)?;
        self.take(len.wrapping_neg() % 4, expected)?;
        Ok(taken)
    }

    fn word(&mut self, expected: &str) -> Result<u32> {
        let word = self.take(4, expected)?;
        Ok(word.iter().fold(0, |n, byte| n << 8 | u32::from(*byte)))
    }

    /// A number of 4 bytes, of 8 in CDF-5.
    fn length(&mut self, expected: &str) -> Result<u64> {
        let bytes = if self.version == 5 { 8 } else { 4 };
        let word = self.take(bytes, expected)?;
        Ok(word.iter().fold(0, |n, byte| n << 8 | u64::from(*byte)))
    }

    /// How many entries a list has; each takes 8 bytes or more.
    fn list(&mut self, tag: u32, expected: &str) -> Result<u64> {
        let at = self.at;
        let found = self.word(expected)?;
        let len = self.length(expected)?;
        if found != tag && (found, len) != (0, 0) {
            let expected = format!("the list of {expected}");
            let found = format!("tag {found}, {len} entries");
            return Err(Error::damaged(format!("byte {at}"), expected, found));
        }
        // A listed entry takes more memory than in the file, but no more than this.
        self.count(len.saturating_mul(256))?;
        Ok(len)
    }

    fn count(&mut self, bytes: u64) -> Result<()> {
        self.used = self.used.saturating_add(bytes);
        match self.memory {
            Some(allowed) if self.used > allowed => Err(Error::Memory {
                what: "the header of a NetCDF-3 file".into(),
                needed: self.used,
                allowed,
            }),
            _ => Ok(()),
        }
    }

    fn name(&mut self) -> Result<String> {
        let len = self.length("the length of a name")?;
        if len > MOST_NAME {
            let expected = format!("a name of at most {MOST_NAME} bytes");
            let found = format!("{len} bytes");
            return Err(Error::damaged(format!("byte {}", self.at), expected, found));
        }
        let name = self.take_padded(len, "a name")?;
        Ok(String::from_utf8_lossy(name).into_owned())
    }

    fn kind(&mut self) -> Result<u32> {
        let at = self.at;
        let kind = self.word("a type")?;
        let most = if self.version == 5 { 11 } else { 6 };
        if !(1..=most).contains(&kind) {
            let expected = format!("a type of 1 to {most}");
            return Err(Error::damaged(
                format!("byte {at}"),
                expected,
                kind.to_string(),
            ));
        }
        Ok(kind)
    }

    fn attributes(&mut self) -> Result<Attributes> {
        let mut attributes = Attributes::default();
        for _ in 0..self.list(ATTRIBUTES, "attributes")? {
            let name = self.name()?;
            let kind = self.kind()?;
            let len = self.length("the length of an attribute")?;
            let bytes = len.saturating_mul(size(kind));
            let bytes = self.take_padded(bytes, "an attribute")?;
            self.count((bytes.len() as u64).saturating_mul(8))?;
            attributes.insert(name, value(kind, bytes));
        }
        Ok(attributes)
    }

    fn entry(&mut self, dimensions: &[(String, u64)]) -> Result<Entry> {
        let name = self.name()?;
        let rank = self.length("the number of dimensions")?;
        if rank > MOST_DIMENSIONS {
            let expected = format!("at most {MOST_DIMENSIONS} dimensions");
            return Err(Error::damaged(
                format!("variable {name}"),
                expected,
                rank.to_string(),
            ));
        }
        let mut of = Vec::new();
        for i in 0..rank {
            let at = self.at;
            let d = self.length("the place of a dimension")?;
            let known = usize::try_from(d).ok().filter(|d| *d < dimensions.len());
            // Only the first dimension counts records.
            let known = known.filter(|d| i == 0 || dimensions[*d].1 != 0);
            let Some(d) = known else {
                let expected = format!("one of {} dimensions", dimensions.len());
                return Err(Error::damaged(
                    format!("byte {at}"),
                    expected,
                    d.to_string(),
                ));
            };
            self.count((size_of::<Dimension>() + dimensions[d].0.len()) as u64)?;
            of.push(d);
        }
        let attributes = self.attributes()?;
        let kind = self.kind()?;
        // The size in the file may be too large for its field; it follows from the dimensions.
        self.length("the size of a variable")?;
        let begin = self.take(if self.version == 1 { 4 } else { 8 }, "an offset")?;
        Ok(Entry {
            name,
            dimensions: of,
            attributes,
            kind,
            begin: begin.iter().fold(0, |n, byte| n << 8 | u64::from(*byte)),
        })
    }
}

/// The type of numbers; none for characters.
fn sample(kind: u32) -> Option<Sample> {
    Some(match kind {
        1 => Sample::I8,
        3 => Sample::I16,
        4 => Sample::I32,
        5 => Sample::F32,
        6 => Sample::F64,
        7 => Sample::U8,
        8 => Sample::U16,
        9 => Sample::U32,
        10 => Sample::I64,
        11 => Sample::U64,
        _ => return None,
    })
}

fn size(kind: u32) -> u64 {
    sample(kind).map_or(1, |sample| sample.bytes() as u64)
}

fn value(kind: u32, bytes: &[u8]) -> Value {
    let Some(sample) = sample(kind) else {
        let text = String::from_utf8_lossy(bytes);
        return Value::Text(text.trim_end_matches('\0').to_owned());
    };
    let numbers = || bytes.chunks_exact(sample.bytes());
    let integers = numbers().map(|one| sample.to_i64(ByteOrder::Big, one));
    match integers.collect::<Option<Vec<i64>>>() {
        Some(integers) if !matches!(sample, Sample::F32 | Sample::F64) => Value::Integers(integers),
        _ => {
            let numbers = numbers().map(|one| sample.to_f64(ByteOrder::Big, one));
            Value::Numbers(numbers.collect())
        }
    }
}
