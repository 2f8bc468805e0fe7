//! Where the samples of a segment lie.

use std::sync::Arc;

use super::description::{Index, WAY_OUT};
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

impl Data {
    fn damaged(&self, expected: impl ToString, found: impl ToString) -> Error {
        let place = format!("the samples at byte {}", self.start);
        Error::damaged(place, expected.to_string(), found.to_string())
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
        if devices == active.len() {
            return self.device(data, &active);
        }
        if devices > 0 {
            let what = "a segment with samples of a DAQmx device and others";
            return Err(Error::unsupported(what, WAY_OUT));
        }
        // A single channel of texts is never interleaved.
        let is_text = active.len() == 1 && active[0].1.size.is_none();
        match data.is_interleaved && !is_text {
            true => self.interleaved(data, &active),
            false => self.contiguous(data, &active),
        }
    }

    fn interleaved(&mut self, data: Data, active: &Active) -> Result<()> {
        let count = active[0].1.count;
        let mut width = 0u64;
        for (object, index) in active {
            let path = || {
                self.objects
                    .keys()
                    .nth(*object)
                    .cloned()
                    .unwrap_or_default()
            };
            let Some(size) = index.size else {
                let found = format!("the texts of {}", path());
                return Err(data.damaged("interleaved numbers", found));
            };
            if index.count != count {
                let expected = format!("{count} samples of {}", path());
                return Err(data.damaged(expected, index.count));
            }
            width += size;
        }
        let rows = data.bytes / width;
        let mut start = data.start;
        for (object, index) in active {
            self.push(*object, Piece::of([start, width, rows], data.order))?;
            start += index.size.unwrap_or(0);
        }
        Ok(())
    }

    fn contiguous(&mut self, data: Data, active: &Active) -> Result<()> {
        let sum = |sum: u64, (_, index): &(usize, Arc<Index>)| sum.checked_add(index.bytes);
        let Some(chunk) = active.iter().try_fold(0u64, sum) else {
            return Err(data.damaged("a chunk", "more than 2^64 bytes"));
        };
        let (chunks, rest) = (data.bytes / chunk, data.bytes % chunk);
        let mut start = data.start;
        for (object, index) in active.iter().filter(|_| chunks > 0) {
            match index.size {
                Some(step) => {
                    let piece = Piece {
                        chunks,
                        stride: chunk,
                        ..Piece::of([start, step, index.count], data.order)
                    };
                    self.push(*object, piece)?;
                }
                None => {
                    for chunk in (0..chunks).map(|i| start + i * chunk) {
                        self.budget.take(size_of::<Texts>() as u64)?;
                        self.objects[*object].texts.push(Texts {
                            start: chunk,
                            bytes: index.bytes,
                            count: index.count,
                            order: data.order,
                        });
                    }
                }
            }
            start += index.bytes;
        }
        // Where texts of a chunk that is cut would lie is not known.
        let has_texts = active.iter().any(|(_, index)| index.size.is_none());
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
            self.push(*object, Piece::of([start, step, count], data.order))?;
            start += count * step;
            left -= count * step;
            if data.is_cut && count < index.count {
                break;
            }
        }
        Ok(())
    }

    /// Finds the samples of a DAQmx device: buffer by buffer, in each of which channels are interleaved.
    fn device(&mut self, data: Data, active: &Active) -> Result<()> {
        let device = |(object, index): &'_ (usize, Arc<Index>)| {
            let device = index.device.as_ref()?;
            Some((*object, index.count, device.buffer, device.offset))
        };
        let widths =
            |(_, index): &'_ (usize, Arc<Index>)| Some(index.device.as_ref()?.widths.clone());
        let mut all = active.iter().filter_map(widths);
        let widths = all.next().unwrap_or_default();
        if let Some(others) = all.find(|others| *others != widths) {
            let expected = format!("rows of {widths:?} bytes");
            return Err(data.damaged(expected, format!("{others:?}")));
        }
        let mut rows = vec![0u64; widths.len()];
        for (_, count, buffer, _) in active.iter().filter_map(device) {
            rows[buffer] = rows[buffer].max(count);
        }
        let mut sizes = rows
            .iter()
            .zip(&widths)
            .map(|(rows, width)| rows.checked_mul(*width));
        let chunk = sizes.try_fold(0u64, |sum, size| sum.checked_add(size?));
        let Some(chunk) = chunk.filter(|chunk| *chunk > 0) else {
            return Err(data.damaged("a chunk", "nothing or more than 2^64 bytes"));
        };
        let chunks = data.bytes / chunk;
        let mut left = data.bytes % chunk;
        let mut start = data.start;
        let mut buffers = Vec::new();
        for (rows, width) in rows.iter().zip(&widths) {
            // Buffers of a chunk that is cut follow one another in full.
            let in_rest = left.checked_div(*width).unwrap_or(0).min(*rows);
            left -= (rows * width).min(left);
            buffers.push((start, in_rest));
            start = start.saturating_add(rows * width);
        }
        for (object, count, buffer, offset) in active.iter().filter_map(device) {
            let (start, in_rest) = buffers[buffer];
            let (start, width) = (start.saturating_add(offset), widths[buffer]);
            let whole = Piece {
                chunks,
                stride: chunk,
                ..Piece::of([start, width, count], data.order)
            };
            self.push(object, whole)?;
            let rest = [
                start.saturating_add(chunks * chunk),
                width,
                in_rest.min(count),
            ];
            self.push(object, Piece::of(rest, data.order))?;
        }
        Ok(())
    }

    fn push(&mut self, object: usize, piece: Piece) -> Result<()> {
        match self.objects[object].pieces.push(piece) {
            true => self.budget.take(2 * size_of::<Piece>() as u64),
            false => Ok(()),
        }
    }
}
