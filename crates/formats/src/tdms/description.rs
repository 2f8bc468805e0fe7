//! The description of a segment, read value by value.

use super::property::{Property, Stamp};
use crate::{ByteOrder, Error, Result, Sample};

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

/// Reads the description of a segment.
pub(super) struct Reader<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
    pub(super) order: ByteOrder,
}

impl<'a> Reader<'a> {
    pub(super) fn take(&mut self, len: u64, expected: &str) -> Result<&'a [u8]> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = usize::try_from(len).ok().and_then(|len| rest.get(..len));
        let Some(taken) = taken else {
            let expected = format!("{expected} ({len} bytes)");
            let found = format!("{} bytes", rest.len());
            return Err(Error::damaged(format!("byte {}", self.at), expected, found));
        };
        self.at += taken.len();
        Ok(taken)
    }

    pub(super) fn u64(&mut self, expected: &str) -> Result<u64> {
        self.number(8, expected)
    }

    pub(super) fn u32(&mut self, expected: &str) -> Result<u32> {
        Ok(self.number(4, expected)? as u32)
    }

    fn number(&mut self, bytes: u64, expected: &str) -> Result<u64> {
        let bytes = self.take(bytes, expected)?.iter();
        let add = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
        Ok(match self.order {
            ByteOrder::Little => bytes.rev().fold(0, add),
            ByteOrder::Big => bytes.fold(0, add),
        })
    }

    pub(super) fn text(&mut self, expected: &str) -> Result<String> {
        let length = self.u32(expected)?;
        let text = self.take(length.into(), expected)?;
        Ok(String::from_utf8_lossy(text).into_owned())
    }

    pub(super) fn index(&mut self, header: u32) -> Result<Index> {
        let at = self.at;
        let kind = self.u32("a type")?;
        let dimensions = self.u32("a number of dimensions")?;
        let count = self.u64("a number of samples")?;
        if dimensions != 1 {
            let place = format!("byte {}", at + 4);
            return Err(Error::damaged(place, "1 dimension", dimensions.to_string()));
        }
        if matches!(header, DEVICE_SAMPLES | DEVICE_LINES) {
            return self.device(header, count);
        }
        let (kind, size) = kind_of(kind, at)?;
        let bytes = match size {
            None => {
                let bytes = self.u64("the length of texts")?;
                // Each has the place of its end.
                count
                    .checked_mul(4)
                    .filter(|least| bytes >= *least)
                    .map(|_| bytes)
            }
            Some(size) => count.checked_mul(size),
        };
        let Some(bytes) = bytes else {
            let found = format!("{count} samples");
            return Err(Error::damaged(format!("byte {at}"), "fewer samples", found));
        };
        // Only objects without samples have type 0.
        if bytes == 0 && count > 0 {
            let found = format!("{count} samples without a type");
            return Err(Error::damaged(format!("byte {at}"), "a type", found));
        }
        Ok(Index {
            kind,
            size,
            count,
            bytes,
            device: None,
        })
    }

    fn device(&mut self, header: u32, count: u64) -> Result<Index> {
        let at = self.at;
        let scalers = self.u32("the number of scalers")?;
        let mut first = None;
        for _ in 0..scalers {
            let kind = self.u32("the type of a scaler")?;
            let buffer = self.u32("the buffer of a scaler")?;
            let offset = self.u32("the offset of a scaler")?;
            let format = if header == DEVICE_LINES { 1 } else { 4 };
            self.take(format, "the format of a scaler")?;
            let scaler = self.u32("the number of a scaler")?;
            first.get_or_insert((kind, buffer, offset, scaler));
        }
        let mut widths = Vec::new();
        let buffers = self.u32("the number of buffers")?;
        if buffers > MOST_BUFFERS {
            let expected = format!("at most {MOST_BUFFERS} buffers");
            return Err(Error::damaged(
                format!("byte {at}"),
                expected,
                buffers.to_string(),
            ));
        }
        for _ in 0..buffers {
            widths.push(u64::from(self.u32("the width of a buffer")?));
        }
        let Some((code, buffer, offset, scaler)) = first else {
            return Err(Error::damaged(format!("byte {at}"), "a scaler", "none"));
        };
        let sample = match code {
            0 => Sample::U8,
            1 => Sample::I8,
            2 => Sample::U16,
            3 => Sample::I16,
            4 => Sample::U32,
            5 => Sample::I32,
            6 => Sample::U64,
            7 => Sample::I64,
            8 => Sample::F32,
            9 => Sample::F64,
            other => {
                let what = format!("a DAQmx scaler of type {other:#x}");
                return Err(Error::unsupported(what, WAY_OUT));
            }
        };
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
            let found = format!("buffer {buffer}, byte {offset}");
            return Err(Error::damaged(format!("byte {at}"), expected, found));
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

    pub(super) fn property(&mut self, name: &str) -> Result<Property> {
        let at = self.at;
        let (kind, size) = kind_of(self.u32("the type of a property")?, at)?;
        let expected = format!("the property {name}");
        let Some(size) = size else {
            return self.text(&expected).map(Property::Text);
        };
        let bytes = self.take(size, &expected)?;
        Ok(match kind {
            Kind::Number(sample) => Property::of_sample(sample, self.order, bytes),
            Kind::Time => Property::Time(Stamp::read(self.order, bytes)),
            _ if size == 0 => Property::Text(String::new()),
            // Complex numbers are the only others.
            _ => {
                let sample = if size == 8 { Sample::F32 } else { Sample::F64 };
                let (re, im) = bytes.split_at(sample.bytes());
                Property::Complex([re, im].map(|part| sample.to_f64(self.order, part)))
            }
        })
    }
}

/// The kind of samples that a code stands for, and the bytes of one; none for texts.
fn kind_of(code: u32, at: usize) -> Result<(Kind, Option<u64>)> {
    let sample = match code {
        1 => Sample::I8,
        2 => Sample::I16,
        3 => Sample::I32,
        4 => Sample::I64,
        5 => Sample::U8,
        6 => Sample::U16,
        7 => Sample::U32,
        8 => Sample::U64,
        9 | 0x19 => Sample::F32,
        10 | 0x1a => Sample::F64,
        0x21 => Sample::Bool,
        0 => return Ok((Kind::Other("no samples"), Some(0))),
        0x20 => return Ok((Kind::Text, None)),
        0x44 => return Ok((Kind::Time, Some(Stamp::BYTES))),
        0x08_000c => return Ok((Kind::Other("complex numbers"), Some(8))),
        0x10_000d => return Ok((Kind::Other("complex numbers"), Some(16))),
        11 | 0x1b => {
            let what = "numbers of extended precision";
            return Err(Error::unsupported(what, "write them as double"));
        }
        0x4f => {
            let what = "fixed-point numbers";
            return Err(Error::unsupported(what, "write them as double"));
        }
        other => {
            let place = format!("byte {at}");
            return Err(Error::damaged(
                place,
                "a type of TDMS",
                format!("{other:#x}"),
            ));
        }
    };
    Ok((Kind::Number(sample), Some(sample.bytes() as u64)))
}
