//! Where the samples of a channel lie.

use std::ops::Range;

use crate::ByteOrder;

/// Samples at even distances, in chunks at even distances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Piece {
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
pub(super) struct Pieces {
    /// Each behind the number of samples before it.
    list: Vec<(u64, Piece)>,
    len: u64,
}

/// Samples at even distances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    pub start: u64,
    pub step: u64,
    pub count: u64,
    pub order: ByteOrder,
}

impl Piece {
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
    pub(super) fn push(&mut self, piece: Piece) -> bool {
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

    pub(super) fn len(&self) -> u64 {
        self.len
    }

    /// All samples, if they lie at even distances.
    pub(super) fn only_run(&self) -> Option<Run> {
        match self.list[..] {
            [(_, piece)] if piece.chunks == 1 => Some(Run {
                start: piece.start,
                step: piece.step,
                count: piece.count,
                order: piece.order,
            }),
            _ => None,
        }
    }

    /// Samples of the first chunk, and whether other channels lie between them.
    pub(super) fn first_chunk(&self, size: u64) -> (u64, bool) {
        let first = self.list.first();
        first.map_or((1, false), |(_, piece)| (piece.count, piece.step > size))
    }

    /// The samples of this range, run by run.
    pub(super) fn runs(&self, range: Range<u64>) -> impl Iterator<Item = Run> + '_ {
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
            Some(Run {
                start: piece.start + chunk * piece.stride + within * piece.step,
                step: piece.step,
                count,
                order: piece.order,
            })
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
        // Chunks that follow one another are one run.
        check(&[piece(28, 8, 3, 4, 24)], 1);
        // Single samples at even distances, in one segment or each in its own.
        check(&[piece(28, 8, 1, 4, 24)], 1);
        check(&[0, 1, 2, 3].map(|i| piece(28 + 50 * i, 8, 1, 1, 8)), 1);
        // Equal chunks at even distances.
        check(
            &[
                piece(28, 8, 3, 1, 24),
                piece(90, 8, 3, 1, 24),
                piece(152, 8, 3, 1, 24),
            ],
            1,
        );
        check(
            &[
                piece(28, 8, 3, 2, 62),
                piece(152, 8, 3, 2, 62),
                piece(300, 8, 3, 2, 62),
            ],
            2,
        );
        check(
            &[
                piece(28, 8, 3, 1, 24),
                piece(90, 8, 3, 2, 62),
                piece(214, 8, 2, 1, 24),
            ],
            2,
        );
        check(
            &[
                piece(28, 8, 1, 1, 8),
                piece(90, 8, 3, 1, 24),
                piece(120, 8, 1, 1, 8),
            ],
            3,
        );
        check(&[piece(28, 8, 1, 1, 8), piece(36, 8, 3, 1, 24)], 1);
    }
}
