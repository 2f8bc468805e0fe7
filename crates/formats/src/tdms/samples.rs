//! Where the samples of a segment lie.

use std::sync::Arc;

use super::description::{Device, Index, WAY_OUT};
use super::segments::Segments;
use crate::rows::Piece;
use crate::{ByteOrder, Error, Result};

/// The samples of a segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Data {
    pub(super) start: u64,
    pub(super) bytes: u64,
    pub(super) order: ByteOrder,
    pub(super) is_interleaved: bool,
    /// Whether the file ends before the segment does.
    pub(super) is_cut: bool,
}

/// Texts of one chunk: ends of all of them, then the characters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Texts {
    pub start: u64,
    pub bytes: u64,
    pub count: u64,
    pub order: ByteOrder,
}

/// Objects with samples, by their place in the list of all.
type Active = [(usize, Arc<Index>)];

/// The samples of an object: their first byte in a chunk, the bytes from one to the next, and how many there are; of the
/// chunk that is cut, their first byte and how many there are.
type Run = (usize, [u64; 3], [u64; 2]);

impl Data {
    fn damaged(&self, expected: impl ToString, found: impl ToString) -> Error {
        let place = format!("the samples at byte {}", self.start);
        Error::damaged(place, expected.to_string(), found.to_string())
    }

    /// A row of one sample of each object is a chunk.
    fn interleaved(
        &self,
        active: &Active,
        path: impl Fn(usize) -> String,
    ) -> Result<(u64, Vec<Run>)> {
        let count = active[0].1.count;
        let (mut width, mut offsets) = (0u64, Vec::new());
        for (object, index) in active {
            let Some(size) = index.size else {
                let found = format!("the texts of {}", path(*object));
                return Err(self.damaged("interleaved numbers", found));
            };
            if index.count != count {
                let expected = format!("{count} samples of {}", path(*object));
                return Err(self.damaged(expected, index.count));
            }
            offsets.push((*object, width));
            width += size;
        }
        let run = |(object, offset)| (object, [offset, width, 1], [0, 0]);
        Ok((width, offsets.into_iter().map(run).collect()))
    }

    /// All samples of an object come one after the other. Texts are none.
    fn contiguous(&self, active: &Active) -> Result<(u64, Vec<Run>)> {
        let sum = |sum: u64, (_, index): &(usize, Arc<Index>)| sum.checked_add(index.bytes);
        let Some(chunk) = active.iter().try_fold(0u64, sum) else {
            return Err(self.damaged("a chunk", "more than 2^64 bytes"));
        };
        // Where texts of a chunk that is cut would lie is not known.
        let has_texts = active.iter().any(|(_, index)| index.size.is_none());
        let rest = if has_texts { 0 } else { self.bytes % chunk };
        let (mut offset, mut in_rest, mut left) = (0, 0, rest);
        let mut runs = Vec::new();
        for (object, index) in active {
            let step = index.size.unwrap_or(0);
            let count = match self.is_cut {
                true => index.count.min(left.checked_div(step).unwrap_or(0)),
                // The writer shortened every channel alike.
                false => (u128::from(index.count) * u128::from(rest) / u128::from(chunk)) as u64,
            };
            if index.size.is_some() {
                runs.push((*object, [offset, step, index.count], [in_rest, count]));
            }
            offset += index.bytes;
            in_rest += count * step;
            left = match self.is_cut && count < index.count {
                true => 0,
                false => left - count * step,
            };
        }
        Ok((chunk, runs))
    }

    /// Samples of a DAQmx device come buffer by buffer, in each of which channels are interleaved.
    fn device(&self, active: &Active) -> Result<(u64, Vec<Run>)> {
        let all = active.iter();
        let all = all.filter_map(|(object, index)| Some((*object, index, index.device.as_ref()?)));
        let widths = all.clone().map(|(_, _, device)| &device.widths).next();
        let widths = widths.map_or(&[][..], |widths| widths);
        if let Some((_, _, other)) = all.clone().find(|(_, _, device)| device.widths != widths) {
            let expected = format!("rows of {widths:?} bytes");
            return Err(self.damaged(expected, format!("{:?}", other.widths)));
        }
        let mut rows = vec![0u64; widths.len()];
        for (_, index, device) in all.clone() {
            rows[device.buffer] = rows[device.buffer].max(index.count);
        }
        let sizes = rows.iter().zip(widths);
        let mut sizes = sizes.map(|(rows, width)| rows.checked_mul(*width));
        let chunk = sizes.try_fold(0u64, |sum, size| sum.checked_add(size?));
        let Some(chunk) = chunk.filter(|chunk| *chunk > 0) else {
            return Err(self.damaged("a chunk", "nothing or more than 2^64 bytes"));
        };
        let (mut left, mut start) = (self.bytes % chunk, 0);
        let mut buffers = Vec::new();
        for (rows, width) in rows.iter().zip(widths) {
            // Buffers of a chunk that is cut follow one another in full.
            let in_rest = left.checked_div(*width).unwrap_or(0).min(*rows);
            left -= (rows * width).min(left);
            buffers.push((start, in_rest));
            start += rows * width;
        }
        let run = |(object, index, device): (usize, &Arc<Index>, &Device)| {
            let (start, in_rest) = buffers[device.buffer];
            let (first, width) = (start + device.offset, widths[device.buffer]);
            let rest = [first, in_rest.min(index.count)];
            (object, [first, width, index.count], rest)
        };
        Ok((chunk, all.map(run).collect()))
    }
}

impl Segments {
    /// Finds the samples of a segment.
    pub(super) fn data(&mut self, data: Data, length: u64) -> Result<()> {
        if data.bytes == 0 {
            return Ok(());
        }
        // Each has a byte of a segment, or shares it with seven digital lines, unless the file is damaged.
        self.work += self.active.len() as u64;
        if self.work > length.saturating_mul(8) {
            let found = format!("{} channels again and again", self.active.len());
            return Err(data.damaged("samples", found));
        }
        let index = |&object: &usize| Some((object, self.objects[object].index.clone()?));
        let active: Vec<_> = self.active.values().filter_map(index).collect();
        let devices = active.iter().filter(|(_, i)| i.device.is_some()).count();
        if active.is_empty() {
            return Err(data.damaged("no samples", format!("{} bytes", data.bytes)));
        }
        if devices > 0 && devices < active.len() {
            let what = "a segment with samples of a DAQmx device and others";
            return Err(Error::unsupported(what, WAY_OUT));
        }
        // A single channel of texts is never interleaved.
        let is_text = active.len() == 1 && active[0].1.size.is_none();
        let path = |object: usize| self.objects.keys().nth(object).cloned().unwrap_or_default();
        let (chunk, runs) = match () {
            _ if devices > 0 => data.device(&active)?,
            _ if data.is_interleaved && !is_text => data.interleaved(&active, path)?,
            _ => {
                self.texts(data, &active)?;
                data.contiguous(&active)?
            }
        };
        let chunks = data.bytes / chunk;
        for (object, [first, step, count], [in_rest, left]) in runs {
            let at = |byte: u64| data.start.saturating_add(byte);
            let whole = Piece {
                chunks,
                stride: chunk,
                ..Piece::of([at(first), step, count], data.order)
            };
            let rest = [at(chunks * chunk).saturating_add(in_rest), step, left];
            for piece in [whole, Piece::of(rest, data.order)] {
                if self.objects[object].pieces.push(piece) {
                    self.budget.take(2 * size_of::<Piece>() as u64)?;
                }
            }
        }
        Ok(())
    }

    /// Finds the texts of all whole chunks.
    fn texts(&mut self, data: Data, active: &Active) -> Result<()> {
        let mut start = data.start;
        let chunk = active.iter().map(|(_, index)| index.bytes);
        let chunk = chunk.fold(0, u64::saturating_add);
        for (object, index) in active {
            let chunks = if index.size.is_none() {
                data.bytes / chunk
            } else {
                0
            };
            for chunk in (0..chunks).map(|i| start + i * chunk) {
                self.budget.take(size_of::<Texts>() as u64)?;
                self.objects[*object].texts.push(Texts {
                    start: chunk,
                    bytes: index.bytes,
                    count: index.count,
                    order: data.order,
                });
            }
            start = start.saturating_add(index.bytes);
        }
        Ok(())
    }
}
