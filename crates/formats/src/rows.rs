//! Where samples lie, in pieces at even distances, and how they are read.

use std::ops::Range;

use crate::container::{Block, Decoder};
use crate::{ByteOrder, Bytes, Result, Sample, Strided, Variable};

/// From stored to scaled numbers, one polynomial after another; coefficients, that of power 0 first.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Scaling(pub Vec<Vec<f64>>);

impl Scaling {
    /// Slope and intercept, if it has no more.
    pub fn linear(&self) -> Option<[f64; 2]> {
        match &self.0[..] {
            [] => Some([1.0, 0.0]),
            [step] => match step[..] {
                [intercept, slope] => Some([slope, intercept]),
                _ => None,
            },
            _ => None,
        }
    }

    fn apply(&self, sample: f64) -> f64 {
        let polynomial = |x: f64, coefficients: &Vec<f64>| {
            let mut coefficients = coefficients.iter().rev();
            let highest = coefficients.next().copied().unwrap_or(0.0);
            coefficients.fold(highest, |sum, coefficient| sum * x + coefficient)
        };
        self.0.iter().fold(sample, polynomial)
    }
}

impl Piece {
    /// Copies the samples of one chunk, of type `from` to every `along`-th byte of `out`: as they are, or as numbers of type
    /// `to`, which is `f64` where they are scaled.
    ///
    /// # Errors
    /// A number that is none of type `to`.
    pub fn copy(
        &self,
        bytes: &[u8],
        [from, to]: [Sample; 2],
        scaling: &Scaling,
        out: &mut [u8],
        along: usize,
    ) -> std::result::Result<(), f64> {
        let (size, step) = (from.bytes(), self.step as usize);
        let bytes = &bytes[self.start as usize..];
        let is_scaled = !scaling.0.is_empty();
        if !is_scaled && from == to && step == size && along == size {
            let out = &mut out[..self.count as usize * size];
            out.copy_from_slice(&bytes[..out.len()]);
            if self.order != ByteOrder::NATIVE {
                out.chunks_exact_mut(size).for_each(<[u8]>::reverse);
            }
            return Ok(());
        }
        for (i, out) in out.chunks_mut(along).take(self.count as usize).enumerate() {
            let one = &bytes[i * step..][..size];
            if is_scaled {
                let number = scaling.apply(from.to_f64(self.order, one));
                out[..8].copy_from_slice(&number.to_ne_bytes());
            } else {
                to.convert(from, self.order, one, &mut out[..to.bytes()])?;
            }
        }
        Ok(())
    }
}

/// The samples of one record.
#[derive(Debug, Default)]
pub(crate) struct Record {
    pub pieces: Pieces,
    /// Type of the stored numbers.
    pub sample: Option<Sample>,
    pub scaling: Scaling,
    /// Bytes in which the pieces lie; none for those of the file.
    pub held: Option<Vec<u8>>,
}

impl Record {
    /// Numbers that are held in memory.
    pub fn held(values: &[f64]) -> Record {
        let mut pieces = Pieces::default();
        pieces.push(Piece::of([0, 8, values.len() as u64], ByteOrder::NATIVE));
        let bytes = values.iter().flat_map(|value| value.to_ne_bytes());
        Record {
            pieces,
            sample: Some(Sample::F64),
            held: Some(bytes.collect()),
            ..Record::default()
        }
    }
}

/// The records of a variable, all of one length.
pub(crate) struct Rows {
    pub path: String,
    pub file: Bytes,
    pub records: Vec<Record>,
    /// Type of the numbers that are read.
    pub sample: Sample,
    /// Whether time is the first of two dimensions.
    pub is_time_first: bool,
}

impl Rows {
    /// Where the samples lie in the file, if they do at even distances and as numbers of one type. It sets
    /// whether those of one time are closer than those of one record.
    pub fn strided(&mut self) -> Option<Strided> {
        let size = self.sample.bytes() as u64;
        let run = |record: &Record| {
            let is_plain = record.sample == Some(self.sample)
                && record.scaling.0.is_empty()
                && record.held.is_none();
            record.pieces.only_run().filter(|_| is_plain)
        };
        let runs: Vec<Piece> = self.records.iter().map(run).collect::<Option<_>>()?;
        let first = runs[0];
        // A single sample has no step.
        let step = if first.count == 1 { size } else { first.step };
        let alike =
            |run: &Piece| run.order == first.order && (first.count == 1 || run.step == step);
        let across = match runs.get(1) {
            Some(second) => second.start.checked_sub(first.start)?,
            None => size,
        };
        let mut pairs = runs.windows(2);
        let is_even = pairs.all(|pair| pair[1].start.checked_sub(pair[0].start) == Some(across));
        if !is_even || !runs.iter().all(alike) {
            return None;
        }
        self.is_time_first = runs.len() > 1 && across < step;
        let strides = match self.is_time_first {
            true => vec![step, across],
            false => vec![across, step],
        };
        Some(Strided::new(first.start, strides, first.order))
    }
}

impl Decoder for Rows {
    fn read(&self, block: Block, out: &mut [u8]) -> Result<()> {
        let (records, times) = match block {
            [times, records] if self.is_time_first => (records.clone(), times.clone()),
            [records, times] => (records.clone(), times.clone()),
            _ => (0..1, block[0].clone()),
        };
        let size = self.sample.bytes();
        let n_records = (records.end - records.start) as usize;
        let n_times = (times.end - times.start) as usize;
        // From one record to the next, and from one time to the next.
        let (across, along) = match self.is_time_first {
            true => (size, size * n_records),
            false => (size * n_times, size),
        };
        let records = &self.records[records.start as usize..records.end as usize];
        for (place, record) in records.iter().enumerate() {
            let bytes = record.held.as_deref().unwrap_or((*self.file).as_ref());
            let (from, scaling) = (record.sample.unwrap_or(self.sample), &record.scaling);
            let mut at = place * across;
            for run in record.pieces.runs(times.clone()) {
                run.copy(bytes, [from, self.sample], scaling, &mut out[at..], along)
                    .map_err(|number| Variable::misfit(&self.path, self.sample, number))?;
                at += run.count as usize * along;
            }
        }
        Ok(())
    }
}

/// Samples at even distances, in chunks at even distances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Piece {
    /// Byte of the first sample.
    pub start: u64,
    /// Bytes from one sample to the next.
    pub step: u64,
    /// Samples of a chunk.
    pub count: u64,
    pub chunks: u64,
    /// Bytes from one chunk to the next.
    pub stride: u64,
    pub order: ByteOrder,
}

/// All samples of a channel.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Pieces {
    /// Each behind the number of samples before it.
    list: Vec<(u64, Piece)>,
    len: u64,
}

impl Piece {
    /// One chunk: its first byte, the bytes from one sample to the next, and how many there are.
    pub fn of([start, step, count]: [u64; 3], order: ByteOrder) -> Piece {
        Piece {
            start,
            step,
            count,
            chunks: 1,
            stride: 0,
            order,
        }
    }

    /// As one chunk, if all distances are even.
    fn simplified(mut self) -> Piece {
        if self.chunks > 1 && (self.count == 1 || self.stride == self.count * self.step) {
            if self.count == 1 {
                self.step = self.stride;
            }
            self.count *= self.chunks;
            self.chunks = 1;
        }
        self
    }

    /// Both as one, if `next` goes on as this one does.
    fn joined(self, next: Piece) -> Option<Piece> {
        if self.order != next.order {
            return None;
        }
        let distance = next.start.checked_sub(self.start)?;
        if self.chunks == 1 && next.chunks == 1 {
            let step = if self.count == 1 { distance } else { self.step };
            if distance == self.count * step && (next.count == 1 || next.step == step) {
                let count = self.count + next.count;
                return Some(Piece {
                    step,
                    count,
                    ..self
                });
            }
        }
        let stride = match (self.chunks, next.chunks) {
            (1, 1) => distance,
            (1, _) => next.stride,
            _ => self.stride,
        };
        let goes_on = self.count == next.count
            && self.step == next.step
            && distance == self.chunks * stride
            && (next.chunks == 1 || next.stride == stride);
        let chunks = self.chunks + next.chunks;
        goes_on.then_some(Piece {
            stride,
            chunks,
            ..self
        })
    }
}

impl Pieces {
    /// Adds samples behind all others. Whether they take a piece of their own.
    pub fn push(&mut self, piece: Piece) -> bool {
        if piece.count == 0 || piece.chunks == 0 {
            return false;
        }
        let piece = piece.simplified();
        let first = self.len;
        self.len += piece.count * piece.chunks;
        if let Some((_, last)) = self.list.last_mut()
            && let Some(joined) = last.joined(piece)
        {
            *last = joined;
            return false;
        }
        self.list.push((first, piece));
        true
    }

    pub fn len(&self) -> u64 {
        self.len
    }

    /// All samples, if they lie at even distances.
    pub fn only_run(&self) -> Option<Piece> {
        match self.list[..] {
            [(_, piece)] if piece.chunks == 1 => Some(piece),
            _ => None,
        }
    }

    /// Samples of the first chunk, and whether other channels lie between them.
    pub fn first_chunk(&self, size: u64) -> (u64, bool) {
        let first = self.list.first();
        first.map_or((1, false), |(_, piece)| (piece.count, piece.step > size))
    }

    /// The samples of this range, chunk by chunk.
    pub fn runs(&self, range: Range<u64>) -> impl Iterator<Item = Piece> + '_ {
        let mut at = range.start;
        let mut place = self.list.partition_point(|(first, _)| *first <= at);
        place = place.saturating_sub(1);
        std::iter::from_fn(move || {
            if at >= range.end {
                return None;
            }
            let (mut first, mut piece) = *self.list.get(place)?;
            if at - first >= piece.count * piece.chunks {
                place += 1;
                (first, piece) = *self.list.get(place)?;
            }
            let (chunk, within) = ((at - first) / piece.count, (at - first) % piece.count);
            let count = (piece.count - within).min(range.end - at);
            at += count;
            let start = piece.start + chunk * piece.stride + within * piece.step;
            Some(Piece::of([start, piece.step, count], piece.order))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(start: u64, step: u64, count: u64, chunks: u64, stride: u64) -> Piece {
        Piece {
            start,
            step,
            count,
            chunks,
            stride,
            order: ByteOrder::Little,
        }
    }

    /// The bytes of all samples, in every range, are those of the pieces as they were pushed.
    fn check(pushed: &[Piece], expected: usize) {
        let mut pieces = Pieces::default();
        let mut bytes = Vec::new();
        for one in pushed {
            pieces.push(*one);
            for chunk in 0..one.chunks {
                let start = one.start + chunk * one.stride;
                bytes.extend((0..one.count).map(|i| start + i * one.step));
            }
        }
        assert_eq!(pieces.list.len(), expected, "{pieces:?}");
        assert_eq!(pieces.len(), bytes.len() as u64);
        for from in 0..bytes.len() {
            for to in from..=bytes.len() {
                let runs = pieces.runs(from as u64..to as u64);
                let found =
                    runs.flat_map(|run| (0..run.count).map(move |i| run.start + i * run.step));
                assert_eq!(found.collect::<Vec<_>>(), bytes[from..to], "{pieces:?}");
            }
        }
    }

    #[test]
    fn val_definition_pieces_are_joined_and_read() {
        let lone = |start| piece(start, 8, 1, 1, 8);
        let three = |start| piece(start, 8, 3, 1, 24);
        let chunks = |start| piece(start, 8, 3, 2, 62);
        // Chunks that follow one another are one run.
        check(&[piece(28, 8, 3, 4, 24)], 1);
        // Single samples at even distances, in one segment or each in its own.
        check(&[piece(28, 8, 1, 4, 24)], 1);
        check(&[28, 78, 128, 178].map(lone), 1);
        // Equal chunks at even distances.
        check(&[28, 90, 152].map(three), 1);
        check(&[28, 152, 300].map(chunks), 2);
        check(&[three(28), chunks(90), piece(214, 8, 2, 1, 24)], 2);
        check(&[lone(28), three(90), lone(120)], 3);
        check(&[lone(28), three(36)], 1);
    }
}
