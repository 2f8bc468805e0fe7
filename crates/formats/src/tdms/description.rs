//! The description of a segment, read value by value.

use super::property::Stamp;
use crate::cursor::Cursor;
use crate::{Error, Result, Sample, Value};

const DEVICE_SAMPLES: u32 = 0x1269;
const DEVICE_LINES: u32 = 0x126a;
/// One for each card.
const MOST_BUFFERS: u32 = 256;

pub(super) const WAY_OUT: &str =
    "copy it with `TdmsWriter.defragment` of npTDMS, or export it anew";

/// What the samples of a channel are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Number(Sample),
    /// Numbers of a DAQmx device and the scaler that they go through.
    Device(Sample, u32),
    Time,
    Text,
    /// What is not read.
    Other(&'static str),
}

/// The samples of an object in each chunk of a segment.
#[derive(Debug, PartialEq)]
pub(super) struct Index {
    pub(super) kind: Kind,
    /// Bytes of a sample; none for texts.
    pub(super) size: Option<u64>,
    pub(super) count: u64,
    pub(super) bytes: u64,
    pub(super) device: Option<Device>,
}

/// Samples among those of other channels of a DAQmx device.
#[derive(Debug, PartialEq)]
pub(super) struct Device {
    pub(super) buffer: usize,
    pub(super) offset: u64,
    /// Bytes of a row of each buffer.
    pub(super) widths: Vec<u64>,
}

pub(super) fn text(cursor: &mut Cursor, expected: &str) -> Result<String> {
    let length = cursor.u32(expected)?;
    let text = cursor.take(length.into(), expected)?;
    Ok(String::from_utf8_lossy(text).into_owned())
}

pub(super) fn index(cursor: &mut Cursor, header: u32) -> Result<Index> {
    let at = *cursor;
    let code = cursor.u32("a type")?;
    let dimensions = cursor.u32("a number of dimensions")?;
    let count = cursor.number(8, "a number of samples")?;
    if dimensions != 1 {
        return Err(at.damaged("samples of 1 dimension", dimensions));
    }
    if matches!(header, DEVICE_SAMPLES | DEVICE_LINES) {
        return device(cursor, header, count);
    }
    let (kind, size) = kind_of(code, &at)?;
    // Each text has the place of its end.
    let least = count.checked_mul(size.unwrap_or(4));
    let bytes = match size {
        None => {
            Some(cursor.number(8, "the length of texts")?).filter(|bytes| Some(*bytes) >= least)
        }
        Some(_) => least,
    };
    let bytes = bytes.filter(|_| least.is_some());
    // Only objects without samples have type 0.
    let bytes = bytes.filter(|bytes| *bytes > 0 || count == 0);
    let bytes = bytes.ok_or_else(|| {
        let expected = "a type and a number of samples that fit together";
        at.damaged(expected, format!("{count} samples of type {code:#x}"))
    })?;
    Ok(Index {
        kind,
        size,
        count,
        bytes,
        device: None,
    })
}

fn device(cursor: &mut Cursor, header: u32, count: u64) -> Result<Index> {
    use Sample::*;
    const SAMPLES: [Sample; 10] = [U8, I8, U16, I16, U32, I32, U64, I64, F32, F64];
    let at = *cursor;
    let scalers = cursor.u32("the number of scalers")?;
    let mut first = None;
    for _ in 0..scalers {
        let kind = cursor.u32("the type of a scaler")?;
        let buffer = cursor.u32("the buffer of a scaler")?;
        let offset = cursor.u32("the offset of a scaler")?;
        let format = if header == DEVICE_LINES { 1 } else { 4 };
        cursor.take(format, "the format of a scaler")?;
        let scaler = cursor.u32("the number of a scaler")?;
        first.get_or_insert((kind, buffer, offset, scaler));
    }
    let buffers = cursor.u32("the number of buffers")?;
    if buffers > MOST_BUFFERS {
        return Err(at.damaged(format!("at most {MOST_BUFFERS} buffers"), buffers));
    }
    let width = |_| cursor.number(4, "the width of a buffer");
    let widths = (0..buffers).map(width).collect::<Result<Vec<u64>>>()?;
    let (code, buffer, offset, scaler) = first.ok_or_else(|| at.damaged("a scaler", "none"))?;
    let sample = SAMPLES.get(code as usize).copied().ok_or_else(|| {
        let what = format!("a DAQmx scaler of type {code:#x}");
        Error::unsupported(what, WAY_OUT)
    })?;
    let (kind, offset) = match header {
        DEVICE_LINES => (Kind::Other("digital lines of a DAQmx device"), offset / 8),
        _ if scalers > 1 => (Kind::Other("samples of several DAQmx scalers"), offset),
        _ => (Kind::Device(sample, scaler), offset),
    };
    let size = sample.bytes() as u64;
    let (buffer, offset) = (buffer as usize, u64::from(offset));
    if widths
        .get(buffer)
        .is_none_or(|width| offset + size > *width)
    {
        let expected = format!("a scaler within rows of {widths:?} bytes");
        return Err(at.damaged(expected, format!("buffer {buffer}, byte {offset}")));
    }
    Ok(Index {
        kind,
        size: Some(size),
        count,
        bytes: 0,
        device: Some(Device {
            buffer,
            offset,
            widths,
        }),
    })
}

pub(super) fn property(cursor: &mut Cursor, name: &str) -> Result<Value> {
    let at = *cursor;
    let (kind, size) = kind_of(cursor.u32("the type of a property")?, &at)?;
    let expected = format!("the property {name}");
    let Some(size) = size else {
        return text(cursor, &expected).map(Value::Text);
    };
    let bytes = cursor.take(size, &expected)?;
    let sample = match (kind, size) {
        (Kind::Time, _) => return Ok(Value::Text(Stamp::read(cursor.order, bytes).text())),
        (_, 0) => return Ok(Value::Text(String::new())),
        (Kind::Number(sample), _) => sample,
        // Complex numbers are the only others.
        (_, 8) => Sample::F32,
        _ => Sample::F64,
    };
    Ok(Value::of_samples(sample, cursor.order, bytes))
}

/// The kind of samples that a code stands for, and the bytes of one; none for texts.
fn kind_of(code: u32, at: &Cursor) -> Result<(Kind, Option<u64>)> {
    use Sample::*;
    const SAMPLES: [Sample; 10] = [I8, I16, I32, I64, U8, U16, U32, U64, F32, F64];
    let refused = |what: &str| Err(Error::unsupported(what, "write them as double"));
    let sample = match code {
        1..=10 => SAMPLES[code as usize - 1],
        0x19 => F32,
        0x1a => F64,
        0x21 => Bool,
        0 => return Ok((Kind::Other("no samples"), Some(0))),
        0x20 => return Ok((Kind::Text, None)),
        0x44 => return Ok((Kind::Time, Some(Stamp::BYTES))),
        0x08_000c => return Ok((Kind::Other("complex numbers"), Some(8))),
        0x10_000d => return Ok((Kind::Other("complex numbers"), Some(16))),
        11 | 0x1b => return refused("numbers of extended precision"),
        0x4f => return refused("fixed-point numbers"),
        other => return Err(at.damaged("a type of TDMS", format!("{other:#x}"))),
    };
    Ok((Kind::Number(sample), Some(sample.bytes() as u64)))
}
