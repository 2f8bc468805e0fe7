//! Where the samples of a segment lie.

use std::sync::Arc;

use super::description::{Index, WAY_OUT};
use super::pieces::Piece;
use super::segments::Segments;
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

impl Segments {
    /// Finds the samples of a segment.
    pub(super) fn data(&mut self, data: Data, length: u64) -> Result<()> {
        if data.bytes == 0 {
            return Ok(());
        }
        // Each has a byte of a segment, or shares it with seven digital lines, unless the file is damaged.
        self.work += self.active.len() as u64;
        let place = || format!("the samples at byte {}", data.start);
        if self.work > length.saturating_mul(8) {
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
