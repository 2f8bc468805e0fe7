//! Types of samples.

use hdf5_reader::error::Result;
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::messages::dataspace::DataspaceType;
use hdf5_reader::object_header::ObjectHeader;
use hdf5_reader::{Dataset, Datatype};

use crate::{ByteOrder, Sample};

/// Number of the filter.
pub(super) const LZF: u16 = 32000;
pub(super) const WAY_OUT: &str = "rewrite it with h5repack, with gzip or without compression";

/// Why the samples behind this header cannot be read, whatever their type.
fn refusal(header: &ObjectHeader) -> Option<String> {
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
            let what = format!("data compressed by {name} (filter {id})");
            Some(format!("{what}, which is not read"))
        }
        _ => None,
    })
}

/// Deflate, shuffle, Fletcher's checksum, szip, n-bit, scale-offset, LZF and LZ4.
fn is_known(filter: u16) -> bool {
    matches!(filter, 1..=6 | LZF | 32004)
}

/// The type and byte order of the samples of a data set, or what they are instead.
pub(super) fn read(
    dataset: &Dataset,
    header: &ObjectHeader,
) -> Result<std::result::Result<(Sample, ByteOrder), String>> {
    if let Some(other) = refusal(header) {
        return Ok(Err(other));
    }
    let other = match dataset.dtype() {
        // The bytes say which bits are used, which the parsed type does not.
        Datatype::FixedPoint { .. }
        | Datatype::FloatingPoint { .. }
        | Datatype::Bitfield { .. } => {
            let found = number(&dataset.raw_datatype()?);
            return Ok(found.ok_or_else(|| "numbers of an unusual form".into()));
        }
        Datatype::Enum { base, members } => {
            let has = |(name, value): (&str, u8)| {
                let mut members = members.iter();
                members.any(|member| member.name == name && member.value == [value])
            };
            let is_byte = matches!(**base, Datatype::FixedPoint { size: 1, .. });
            if is_byte && members.len() == 2 && has(("FALSE", 0)) && has(("TRUE", 1)) {
                return Ok(Ok((Sample::Bool, ByteOrder::NATIVE)));
            }
            "named values (an enumeration)"
        }
        Datatype::Compound { fields, .. } => {
            let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
            match names[..] {
                ["r", "i"] | ["real", "imag"] | ["re", "im"] => "complex numbers",
                _ => return Ok(Err(format!("a compound type of {}", names.join(", ")))),
            }
        }
        Datatype::String { .. }
        | Datatype::VarLen {
            kind: hdf5_reader::VarLenKind::String,
            ..
        } => "text",
        Datatype::VarLen { .. } => "rows of different lengths",
        Datatype::Reference { .. } => "references",
        Datatype::Array { .. } => "arrays as samples",
        _ => "opaque bytes",
    };
    Ok(Err(other.into()))
}

/// The type that the bytes of a datatype message of an integer, a float or bits describe, if it is one of
/// the usual ones.
fn number(stored: &[u8]) -> Option<(Sample, ByteOrder)> {
    let flags = u32::from_le_bytes([stored.get(1).copied()?, *stored.get(2)?, *stored.get(3)?, 0]);
    let size = u32::from_le_bytes(stored.get(4..8)?.try_into().ok()?);
    let u16_at = |at: usize| Some(u16::from_le_bytes(stored.get(at..at + 2)?.try_into().ok()?));
    let order = [ByteOrder::Little, ByteOrder::Big][flags as usize & 1];
    let is_whole = u16_at(8)? == 0 && u32::from(u16_at(10)?) == 8 * size;
    if !is_whole || size > 8 {
        return None;
    }
    let kind = match stored[0] & 0xf {
        1 => {
            let bias = u32::from_le_bytes(stored.get(16..20)?.try_into().ok()?);
            // Bit 6 is the byte order of the VAX; the sign is the highest bit; bits 4 and 5 say that the
            // leading bit of the fraction is implied.
            let is_usual =
                flags & 0x40 == 0 && (flags >> 4) & 3 == 2 && (flags >> 8) & 0xff == 8 * size - 1;
            let is_ieee = matches!(
                (size, &stored[12..16], bias),
                (2, [10, 5, 0, 10], 15) | (4, [23, 8, 0, 23], 127) | (8, [52, 11, 0, 52], 1023)
            );
            (is_usual && is_ieee).then_some('f')?
        }
        0 if flags & 8 != 0 => 'i',
        // Bits count as an unsigned integer: PyTables stores booleans so.
        _ => 'u',
    };
    Some((Sample::of_kind(kind, size as usize)?, order))
}
