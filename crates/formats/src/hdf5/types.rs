//! Types of samples.

use hdf5_reader::error::Result;
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::messages::dataspace::DataspaceType;
use hdf5_reader::object_header::ObjectHeader;
use hdf5_reader::{Dataset, Datatype};

use crate::{ByteOrder, Sample, SampleType};

/// Number of the filter.
pub(super) const LZF: u16 = 32000;
pub(super) const WAY_OUT: &str = "rewrite it with h5repack, with gzip or without compression";

/// Why the samples behind this header cannot be read, whatever their type.
pub(super) fn refusal(header: &ObjectHeader) -> Option<String> {
    header.messages.iter().find_map(|message| match message {
        HdfMessage::ExternalFiles(_) => Some("samples in another file, which is not read".into()),
        HdfMessage::Dataspace(space) if space.dataspace_type == DataspaceType::Null => {
            Some("nothing".into())
        }
        HdfMessage::FilterPipeline(pipeline) => {
            let unknown = pipeline.filters.iter().find(|f| !is_known(f.id))?;
            let id = unknown.id;
            let name = match id {
                32001 => "blosc",
                32008 => "bitshuffle",
                32013 => "zfp",
                32015 => "zstd",
                32017 => "SZ",
                32026 => "blosc2",
                _ => unknown.name.as_deref().unwrap_or("an unknown method"),
            };
            Some(format!(
                "data compressed by {name} (filter {id}), which is not read"
            ))
        }
        _ => None,
    })
}

/// Deflate, shuffle, Fletcher's checksum, szip, n-bit, scale-offset, LZF and LZ4.
fn is_known(filter: u16) -> bool {
    matches!(filter, 1..=6 | LZF | 32004)
}

/// The type and byte order of the samples of a data set.
pub(super) fn read(dataset: &Dataset) -> Result<(SampleType, ByteOrder)> {
    let other = |what: &str| SampleType::Other(what.to_owned());
    let stored = match dataset.dtype() {
        // The bytes say which bits are used, which the parsed type does not.
        Datatype::FixedPoint { .. }
        | Datatype::FloatingPoint { .. }
        | Datatype::Bitfield { .. } => dataset.raw_datatype()?,
        Datatype::Enum { base, members } => {
            let is_bool = matches!(**base, Datatype::FixedPoint { size: 1, .. })
                && members.len() == 2
                && [("FALSE", 0), ("TRUE", 1)].iter().all(|(name, value)| {
                    let mut members = members.iter();
                    members.any(|member| member.name == *name && member.value == [*value])
                });
            let sample_type = match is_bool {
                true => SampleType::Number(Sample::Bool),
                false => other("named values (an enumeration)"),
            };
            return Ok((sample_type, ByteOrder::NATIVE));
        }
        Datatype::String { .. } => return Ok((other("text"), ByteOrder::NATIVE)),
        Datatype::Compound { fields, .. } => {
            let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
            let what = match names[..] {
                ["r", "i"] | ["real", "imag"] | ["re", "im"] => "complex numbers".to_owned(),
                _ => format!("a compound type of {}", names.join(", ")),
            };
            return Ok((SampleType::Other(what), ByteOrder::NATIVE));
        }
        found => {
            let what = match found {
                Datatype::VarLen { kind, .. } => match kind {
                    hdf5_reader::VarLenKind::String => "text",
                    _ => "rows of different lengths",
                },
                Datatype::Reference { .. } => "references",
                Datatype::Array { .. } => "arrays as samples",
                _ => "opaque bytes",
            };
            return Ok((other(what), ByteOrder::NATIVE));
        }
    };
    Ok(number(&stored).unwrap_or_else(|| (other("numbers of an unusual form"), ByteOrder::NATIVE)))
}

/// The type that the bytes of a datatype message of an integer, a float or bits describe, if it is one of
/// the usual ones.
fn number(stored: &[u8]) -> Option<(SampleType, ByteOrder)> {
    let flags = u32::from_le_bytes([stored.get(1).copied()?, *stored.get(2)?, *stored.get(3)?, 0]);
    let size = u32::from_le_bytes(stored.get(4..8)?.try_into().ok()?);
    let u16_at = |at: usize| Some(u16::from_le_bytes(stored.get(at..at + 2)?.try_into().ok()?));
    let order = if flags & 1 == 0 {
        ByteOrder::Little
    } else {
        ByteOrder::Big
    };
    let is_whole = u16_at(8)? == 0 && u32::from(u16_at(10)?) == 8 * size;
    if !is_whole || size > 8 {
        return None;
    }
    let class = stored[0] & 0xf;
    let sample = if class != 1 {
        // Bits count as an unsigned integer: PyTables stores booleans so.
        match (size, class == 0 && flags & 8 != 0) {
            (1, true) => Sample::I8,
            (2, true) => Sample::I16,
            (4, true) => Sample::I32,
            (8, true) => Sample::I64,
            (1, false) => Sample::U8,
            (2, false) => Sample::U16,
            (4, false) => Sample::U32,
            (8, false) => Sample::U64,
            _ => return None,
        }
    } else {
        let bias = u32::from_le_bytes(stored.get(16..20)?.try_into().ok()?);
        // Bit 6 is the byte order of the VAX; the sign is the highest bit; bits 4 and 5 say that the
        // leading bit of the fraction is implied.
        let is_usual =
            flags & 0x40 == 0 && (flags >> 4) & 3 == 2 && (flags >> 8) & 0xff == 8 * size - 1;
        match (size, &stored[12..16], bias) {
            _ if !is_usual => return None,
            (2, [10, 5, 0, 10], 15) => Sample::F16,
            (4, [23, 8, 0, 23], 127) => Sample::F32,
            (8, [52, 11, 0, 52], 1023) => Sample::F64,
            _ => return None,
        }
    };
    Some((SampleType::Number(sample), order))
}
