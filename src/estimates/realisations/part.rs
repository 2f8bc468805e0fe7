//! A part of all realisations: a contiguous range of the segments of all records.

use std::fmt;
use std::ops::Range;

use super::averaging::{Realisations, SegmentScratch};
use super::ensemble::PARTS;
use super::records::Records;
use super::shots::{Shot, TOGETHER};
use super::sums::Sums;
use crate::error::{Error, Result};
use crate::transform::Segments;

/// One of several parts of the realisations of an estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Part {
    /// From 1 on.
    pub number: usize,
    pub of: usize,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl Part {
    /// # Errors
    /// [`Error::Request`] unless `1 <= number <= of`.
    pub fn new(number: usize, of: usize) -> Result<Part> {
        let (part, is_one) = (Part { number, of }, (1..=of).contains(&number));
        let expected = "a part and their number, as 3/64: from 1/64 to 64/64";
        Error::require(is_one, "part", expected, part).map(|()| part)
    }

    /// Its share of `realisations`, all parts alike but for one.
    ///
    /// # Errors
    /// [`Error::Request`] for more parts than realisations.
    pub(crate) fn range(self, realisations: usize) -> Result<Range<usize>> {
        let expected = format!("at most as many parts as segments of all records, {realisations}");
        Error::require(self.of <= realisations, "part", expected, self)?;
        let end = |part: usize| (part as u128 * realisations as u128 / self.of as u128) as usize;
        Ok(end(self.number - 1)..end(self.number))
    }
}

/// The segments of one record that belong to a part, and the samples that they reach.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Portion {
    pub record: usize,
    pub segments: Range<usize>,
    /// Of the record; the last portion has those behind the last segment, too.
    pub samples: Range<usize>,
    pub is_whole: bool,
}

impl Realisations {
    /// The portion of a block of one record: the segments that lie in it.
    ///
    /// # Errors
    /// [`Error::Request`] for a block that is not in the record, or holds no segment.
    pub fn portion_of_block(&self, samples: Range<usize>) -> Result<Portion> {
        let Segments {
            record,
            length,
            hop,
        } = self.segments;
        let from = samples.start.div_ceil(hop);
        let end = (samples.end + hop).saturating_sub(length) / hop;
        let end = end.min(self.segments.count());
        let expected = format!(
            "a block of the {record} samples of a record that holds a segment: {length} samples from a multiple of {hop} \
             on"
        );
        let last = samples.end.max(1) - 1;
        let found = format!("samples {} to {last}", samples.start);
        let is_one = samples.end <= record && from < end;
        Error::require(is_one, "first", expected, found)?;
        Ok(self.portion(0, from..end, samples.end))
    }

    /// These segments of a record, and the samples up to the last one, or to this one behind all segments.
    fn portion(&self, record: usize, segments: Range<usize>, end: usize) -> Portion {
        let (count, Segments { length, hop, .. }) = (self.segments.count(), self.segments);
        let last = match segments.end == count {
            true => end,
            false => (segments.end - 1) * hop + length,
        };
        Portion {
            record,
            samples: segments.start * hop..last,
            is_whole: segments.len() == count,
            segments,
        }
    }

    /// The portions of a range of the segments of all records.
    pub fn portions(&self, range: Range<usize>) -> Vec<Portion> {
        let segments = self.segments.count();
        let records = range.start / segments..range.end.div_ceil(segments);
        let portion = |record: usize| {
            let first = record * segments;
            let from = range.start.max(first) - first;
            let end = range.end.min(first + segments) - first;
            self.portion(record, from..end, self.segments.record)
        };
        records.map(portion).collect()
    }

    /// All segments of a record.
    pub fn whole(&self, record: usize) -> Portion {
        self.portion(record, 0..self.segments.count(), self.segments.record)
    }

    /// So many records, each as one portion.
    pub fn whole_records(&self, records: usize) -> Vec<Portion> {
        (0..records).map(|record| self.whole(record)).collect()
    }

    /// Pieces of a record whose energies are compared, and what they leave over.
    pub fn pieces(&self) -> usize {
        self.reached() / self.piece_length() + 1
    }

    fn piece_length(&self) -> usize {
        (self.reached() / PARTS).max(1)
    }

    /// Adds how steady the records of a shot's portion are, of up to eight sites: where segments are left out, by the samples that
    /// are there.
    pub fn add_steadiness(
        &self,
        shot: &Shot<'_>,
        (sites, records): (impl Iterator<Item = usize> + Clone, Records<'_>),
        scratch: &mut SegmentScratch,
        sums: &mut Sums,
    ) {
        if shot.leaves_out() {
            sums.add_record(shot.steadiness(sites, records, self.about_mean()));
            return;
        }
        let (portion, mark) = (&shot.portion, shot.mark(sites));
        for segment in portion.segments.clone() {
            let start = segment * self.segments.hop - portion.samples.start;
            self.add_pieces(shot, (segment, start), records, (mark, scratch), sums);
        }
        sums.close(self.reached(), self.about_mean());
    }

    /// Adds the samples of up to eight `records` from the start of a segment, in row `start`, to that of the next. A `mark`
    /// of NaN makes their steadiness NaN.
    pub fn add_pieces(
        &self,
        shot: &Shot<'_>,
        (segment, start): (usize, usize),
        records: Records<'_>,
        (mark, scratch): ([f64; TOGETHER], &mut SegmentScratch),
        sums: &mut Sums,
    ) {
        let (length, last) = (self.piece_length(), self.pieces() - 1);
        let first = segment * self.segments.hop;
        let end = match segment + 1 == self.segments.count() {
            true => self.reached(),
            false => first + self.segments.hop,
        };
        let piece_of = |sample: usize| (sample / length).min(last);
        for piece in piece_of(first)..=piece_of(end - 1) {
            let from = first.max(piece * length);
            let to = match piece == last {
                true => end,
                false => end.min((piece + 1) * length),
            };
            let rows = start + from - first..start + to - first;
            let count = rows.len() as f64;
            let [means, squares] = records.mean_and_squares(rows, &mut scratch.numbers);
            let squares = std::array::from_fn(|lane| squares[lane] + mark[lane]);
            sums.add_piece((shot.portion.record, piece), count, means, squares);
        }
    }
}
