//! The segments of a file: what they say about its objects, and where samples lie.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::pieces::{Piece, Pieces};
use super::property::{Properties, Property, Stamp};
use crate::{ByteOrder, Error, Options, Result, Sample};

/// Bytes before the description of a segment.
const LEAD: u64 = 28;
const HAS_DESCRIPTION: u32 = 1 << 1;
const IS_NEW_LIST: u32 = 1 << 2;
const IS_INTERLEAVED: u32 = 1 << 5;
const IS_BIG_ENDIAN: u32 = 1 << 6;
const AS_BEFORE: u32 = 0;
const NO_SAMPLES: u32 = u32::MAX;
const DEVICE_SAMPLES: u32 = 0x1269;
const DEVICE_LINES: u32 = 0x126a;
/// One for each card.
const MOST_BUFFERS: u32 = 256;

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

/// The file, a group or a channel.
#[derive(Debug, Default)]
pub(super) struct Object {
    pub path: String,
    pub properties: Properties,
    /// None before the first samples.
    pub kind: Option<Kind>,
    pub pieces: Pieces,
    pub texts: Vec<Texts>,
    /// What the last segment said of its samples.
    index: Option<Arc<Index>>,
    /// Its place in the list of objects, and the number of that list.
    place: Option<(u64, u64)>,
}

/// Texts of one chunk: ends of all of them, then the characters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Texts {
    pub start: u64,
    pub bytes: u64,
    pub count: u64,
    pub order: ByteOrder,
}

/// The samples of an object in each chunk of a segment.
#[derive(Debug, PartialEq)]
struct Index {
    kind: Kind,
    /// Bytes of a sample; none for texts.
    size: Option<u64>,
    count: u64,
    bytes: u64,
    device: Option<Device>,
}

/// Samples among those of other channels of a DAQmx device.
#[derive(Debug, PartialEq)]
struct Device {
    buffer: usize,
    offset: u64,
    /// Bytes of a row of each buffer.
    widths: Vec<u64>,
}

/// All that the segments of a file say.
#[derive(Debug, Default)]
pub(super) struct Segments {
    pub objects: Vec<Object>,
    /// What is not read of a file that was not written to its end.
    pub incomplete: Option<String>,
    places: HashMap<String, usize>,
    /// Objects of the current list that have samples, by their place in it.
    active: BTreeMap<u64, usize>,
    /// Number of the current list, and of its next place.
    list: (u64, u64),
    work: u64,
    used: u64,
    memory: Option<u64>,
}

/// Reads the description of a segment.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    order: ByteOrder,
}

impl Segments {
    pub(super) fn read(bytes: &[u8], options: &Options) -> Result<Segments> {
        let mut segments = Segments {
            memory: options.memory,
            ..Segments::default()
        };
        let length = bytes.len() as u64;
        let mut at = 0;
        while length - at >= LEAD || at == 0 {
            match segments.segment(bytes, at)? {
                Some(next) => at = next,
                None => break,
            }
        }
        if at < length && segments.incomplete.is_none() {
            segments.incomplete = Some(format!("{} bytes behind the last segment", length - at));
        }
        Ok(segments)
    }

    /// Reads the segment at byte `at`; the byte behind it.
    fn segment(&mut self, bytes: &[u8], at: u64) -> Result<Option<u64>> {
        let length = bytes.len() as u64;
        let mut lead = Reader {
            bytes,
            at: at as usize,
            order: ByteOrder::Little,
        };
        let tag = lead.take(4, "TDSm")?;
        if tag == b"TDSh" {
            let what = "an index of a TDMS file, which holds no samples";
            return Err(Error::unsupported(what, "open the .tdms file beside it"));
        }
        if tag != b"TDSm" {
            let found = String::from_utf8_lossy(tag).escape_debug().to_string();
            return Err(Error::damaged(format!("byte {at}"), "TDSm", found));
        }
        let contents = lead.u32("the contents of a segment")?;
        if contents & IS_BIG_ENDIAN != 0 {
            lead.order = ByteOrder::Big;
        }
        let _version = lead.u32("a version")?;
        let next = lead.u64("the length of a segment")?;
        let samples = lead.u64("the length of a description")?;
        let first = at + LEAD;
        let place = |offset: u64| first.checked_add(offset);
        // A writer that was stopped leaves the length open.
        let end = Some(next).filter(|next| *next != u64::MAX).and_then(place);
        let is_cut = end.is_none_or(|end| end > length);
        let end = end.map_or(length, |end| end.min(length));
        let Some(start) = place(samples).filter(|start| *start <= end) else {
            if is_cut {
                let from = format!("the segment at byte {at}, whose description is cut");
                self.incomplete = Some(from);
                return Ok(None);
            }
            let expected = format!("a description of at most {next} bytes");
            return Err(Error::damaged(
                format!("the segment at byte {at}"),
                expected,
                samples.to_string(),
            ));
        };
        if contents & HAS_DESCRIPTION != 0 {
            let mut description = Reader {
                bytes: &bytes[..start as usize],
                ..lead
            };
            self.description(&mut description, contents & IS_NEW_LIST != 0)?;
        } else if at == 0 {
            let found = "none in the first segment";
            return Err(Error::damaged("byte 4", "a description", found));
        }
        let data = Data {
            start,
            bytes: end - start,
            order: lead.order,
            is_interleaved: contents & IS_INTERLEAVED != 0,
            is_cut,
        };
        if is_cut {
            let text = format!("the segment at byte {at}, read as far as it reaches");
            self.incomplete = Some(text);
        }
        self.data(data, length)?;
        Ok(Some(end))
    }

    fn description(&mut self, reader: &mut Reader, is_new: bool) -> Result<()> {
        if is_new {
            self.active.clear();
            self.list = (self.list.0 + 1, 0);
        }
        for _ in 0..reader.u32("the number of objects")? {
            let path = reader.text("the path of an object")?;
            let object = match self.places.get(&path) {
                Some(&object) => object,
                None => {
                    self.count(size_of::<Object>() + 2 * path.len() + 64)?;
                    self.places.insert(path.clone(), self.objects.len());
                    self.objects.push(Object {
                        path,
                        ..Object::default()
                    });
                    self.objects.len() - 1
                }
            };
            self.index(object, reader)?;
            for _ in 0..reader.u32("the number of properties")? {
                let name = reader.text("the name of a property")?;
                let from = reader.at;
                let property = reader.property(&name)?;
                let bytes = 2 * name.len() + 2 * (reader.at - from) + 128;
                if self.objects[object].properties.set(name, property) {
                    self.count(bytes)?;
                }
            }
        }
        Ok(())
    }

    /// Reads what is said about the samples of an object.
    fn index(&mut self, object: usize, reader: &mut Reader) -> Result<()> {
        let at = reader.at;
        let header = reader.u32("the index of an object")?;
        let found = &mut self.objects[object];
        let place = match found.place {
            Some((list, place)) if list == self.list.0 => place,
            _ => {
                found.place = Some(self.list);
                self.list.1 += 1;
                self.list.1 - 1
            }
        };
        match header {
            NO_SAMPLES => {
                self.active.remove(&place);
                return Ok(());
            }
            AS_BEFORE if found.index.is_none() => {
                let expected = "samples in an earlier segment";
                return Err(Error::damaged(format!("byte {at}"), expected, "none"));
            }
            AS_BEFORE => {}
            _ => {
                let index = reader.index(header)?;
                let is_used = found.pieces.len() > 0 || !found.texts.is_empty();
                let earlier = found.kind.filter(|kind| is_used && *kind != index.kind);
                match earlier {
                    Some(earlier) if index.count > 0 => {
                        let place = format!("byte {at}, {}", found.path);
                        let of = |kind| format!("samples of type {kind:?}");
                        return Err(Error::damaged(place, of(earlier), of(index.kind)));
                    }
                    Some(_) => {}
                    None => found.kind = Some(index.kind),
                }
                found.index = Some(Arc::new(index));
            }
        }
        let has_samples = |index: &Arc<Index>| index.count > 0;
        if self.objects[object].index.as_ref().is_some_and(has_samples) {
            self.active.insert(place, object);
        } else {
            self.active.remove(&place);
        }
        Ok(())
    }

    fn count(&mut self, bytes: usize) -> Result<()> {
        self.used = self.used.saturating_add(bytes as u64);
        match self.memory {
            Some(allowed) if self.used > allowed => Err(Error::Memory {
                what: "the description of a TDMS file".into(),
                needed: self.used,
                allowed,
            }),
            _ => Ok(()),
        }
    }

    /// Finds the samples of a segment.
    fn data(&mut self, data: Data, length: u64) -> Result<()> {
        if data.bytes == 0 {
            return Ok(());
        }
        // Each has a sample in each segment, but for damage.
        self.work += self.active.len() as u64;
        let place = || format!("the samples at byte {}", data.start);
        if self.work > length.saturating_mul(16) {
            let found = format!("{} channels again and again", self.active.len());
            return Err(Error::damaged(place(), "samples", found));
        }
        let active: Vec<(usize, Arc<Index>)> = self
            .active
            .values()
            .filter_map(|&object| Some((object, self.objects[object].index.clone()?)))
            .collect();
        let devices = active.iter().filter(|(_, i)| i.device.is_some()).count();
        if active.is_empty() {
            let found = format!("{} bytes", data.bytes);
            return Err(Error::damaged(place(), "no samples", found));
        }
        if devices == active.len() {
            return self.device(data, &active);
        }
        if devices > 0 {
            let what = "a segment with samples of a DAQmx device and others";
            return Err(Error::unsupported(what, WAY_OUT));
        }
        let texts = active.iter().filter(|(_, i)| i.size.is_none()).count();
        // A single channel of texts is never interleaved.
        if data.is_interleaved && !(texts == 1 && active.len() == 1) {
            return self.interleaved(data, &active);
        }
        self.contiguous(data, &active, texts > 0)
    }

    fn interleaved(&mut self, data: Data, active: &[(usize, Arc<Index>)]) -> Result<()> {
        let place = || format!("the samples at byte {}", data.start);
        let count = active[0].1.count;
        let mut width = 0u64;
        for (object, index) in active {
            let Some(size) = index.size else {
                let found = format!("the texts of {}", self.objects[*object].path);
                return Err(Error::damaged(place(), "interleaved numbers", found));
            };
            if index.count != count {
                let expected = format!("{count} samples of {}", self.objects[*object].path);
                return Err(Error::damaged(place(), expected, index.count.to_string()));
            }
            width += size;
        }
        let rows = data.bytes / width;
        let mut start = data.start;
        for (object, index) in active {
            let piece = Piece {
                start,
                step: width,
                count: rows,
                chunks: 1,
                stride: 0,
                order: data.order,
            };
            self.push(*object, piece)?;
            start += index.size.unwrap_or(0);
        }
        Ok(())
    }

    fn contiguous(
        &mut self,
        data: Data,
        active: &[(usize, Arc<Index>)],
        has_texts: bool,
    ) -> Result<()> {
        let sum = |sum: u64, (_, index): &(usize, Arc<Index>)| sum.checked_add(index.bytes);
        let Some(chunk) = active.iter().try_fold(0u64, sum) else {
            let place = format!("the samples at byte {}", data.start);
            return Err(Error::damaged(place, "a chunk", "more than 2^64 bytes"));
        };
        let (chunks, rest) = (data.bytes / chunk, data.bytes % chunk);
        let mut start = data.start;
        for (object, index) in active.iter().filter(|_| chunks > 0) {
            match index.size {
                Some(step) => {
                    let piece = Piece {
                        start,
                        step,
                        count: index.count,
                        chunks,
                        stride: chunk,
                        order: data.order,
                    };
                    self.push(*object, piece)?;
                }
                None => self.texts(*object, index, start, chunks, chunk, data.order)?,
            }
            start += index.bytes;
        }
        // Where texts of a chunk that is cut would lie is not known.
        if rest == 0 || has_texts {
            return Ok(());
        }
        let mut start = data.start + chunks * chunk;
        let mut left = rest;
        for (object, index) in active {
            let Some(step) = index.size else { continue };
            let count = match data.is_cut {
                true => index.count.min(left / step),
                // The writer shortened every channel alike.
                false => (u128::from(index.count) * u128::from(rest) / u128::from(chunk)) as u64,
            };
            let piece = Piece {
                start,
                step,
                count,
                chunks: 1,
                stride: 0,
                order: data.order,
            };
            self.push(*object, piece)?;
            start += count * step;
            left -= count * step;
            if data.is_cut && count < index.count {
                break;
            }
        }
        Ok(())
    }

    fn texts(
        &mut self,
        object: usize,
        index: &Index,
        start: u64,
        chunks: u64,
        stride: u64,
        order: ByteOrder,
    ) -> Result<()> {
        for chunk in 0..chunks {
            self.count(size_of::<Texts>())?;
            self.objects[object].texts.push(Texts {
                start: start + chunk * stride,
                bytes: index.bytes,
                count: index.count,
                order,
            });
        }
        Ok(())
    }

    /// Finds the samples of a DAQmx device: buffer by buffer, in each of which channels are interleaved.
    fn device(&mut self, data: Data, active: &[(usize, Arc<Index>)]) -> Result<()> {
        let place = || format!("the samples at byte {}", data.start);
        let devices = || {
            let device = |(object, index): &'_ (usize, Arc<Index>)| (*object, Arc::clone(index));
            active.iter().map(device)
        };
        let Some(widths) = active[0].1.device.as_ref().map(|d| d.widths.clone()) else {
            return Ok(());
        };
        let mut rows = vec![0u64; widths.len()];
        for (object, index) in devices() {
            let Some(device) = &index.device else {
                continue;
            };
            if device.widths != widths {
                let expected = format!("rows of {widths:?} bytes of {}", self.objects[object].path);
                let found = format!("{:?}", device.widths);
                return Err(Error::damaged(place(), expected, found));
            }
            rows[device.buffer] = rows[device.buffer].max(index.count);
        }
        let sizes = rows
            .iter()
            .zip(&widths)
            .map(|(rows, width)| rows.checked_mul(*width));
        let chunk = sizes.collect::<Option<Vec<u64>>>().and_then(|sizes| {
            sizes
                .iter()
                .try_fold(0u64, |sum, size| sum.checked_add(*size))
        });
        let Some(chunk) = chunk.filter(|chunk| *chunk > 0) else {
            let found = "nothing or more than 2^64 bytes";
            return Err(Error::damaged(place(), "a chunk", found));
        };
        let chunks = data.bytes / chunk;
        let mut left = data.bytes % chunk;
        let mut start = data.start;
        let mut buffers = Vec::new();
        for (rows, width) in rows.iter().zip(&widths) {
            // Buffers of a chunk that is cut follow one another in full.
            let in_rest = if *width > 0 {
                (left / width).min(*rows)
            } else {
                0
            };
            left -= (rows * width).min(left);
            buffers.push((start, in_rest));
            start = start.saturating_add(rows * width);
        }
        for (object, index) in devices() {
            let Some(device) = &index.device else {
                continue;
            };
            let (buffer, in_rest) = buffers[device.buffer];
            let piece = Piece {
                start: buffer.saturating_add(device.offset),
                step: widths[device.buffer],
                count: index.count,
                chunks,
                stride: chunk,
                order: data.order,
            };
            self.push(object, piece)?;
            let rest = Piece {
                start: piece.start.saturating_add(chunks * chunk),
                count: in_rest.min(index.count),
                chunks: 1,
                ..piece
            };
            self.push(object, rest)?;
        }
        Ok(())
    }

    fn push(&mut self, object: usize, piece: Piece) -> Result<()> {
        if self.objects[object].pieces.push(piece) {
            self.count(2 * size_of::<Piece>())?;
        }
        Ok(())
    }
}

pub(super) const WAY_OUT: &str =
    "copy it with `TdmsWriter.defragment` of npTDMS, or export it anew";

/// The samples of a segment.
#[derive(Debug, Clone, Copy)]
struct Data {
    start: u64,
    bytes: u64,
    order: ByteOrder,
    is_interleaved: bool,
    /// Whether the file ends before the segment does.
    is_cut: bool,
}

impl<'a> Reader<'a> {
    fn take(&mut self, len: u64, expected: &str) -> Result<&'a [u8]> {
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

    fn u64(&mut self, expected: &str) -> Result<u64> {
        self.number(8, expected)
    }

    fn u32(&mut self, expected: &str) -> Result<u32> {
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

    fn text(&mut self, expected: &str) -> Result<String> {
        let length = self.u32(expected)?;
        let text = self.take(length.into(), expected)?;
        Ok(String::from_utf8_lossy(text).into_owned())
    }

    fn index(&mut self, header: u32) -> Result<Index> {
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

    fn property(&mut self, name: &str) -> Result<Property> {
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
