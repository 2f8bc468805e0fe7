//! A part of all realisations: a contiguous range of the segments of all records.

use std::fmt;
use std::ops::Range;

use super::averaging::Realisations;
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
        match (1..=of).contains(&number) {
            true => Ok(Part { number, of }),
            false => {
                let expected = "a part and their number, as 3/64: from 1/64 to 64/64";
                Err(Error::request("part", expected, format!("{number}/{of}")))
            }
        }
    }

    /// Its share of `realisations`, all parts alike but for one.
    ///
    /// # Errors
    /// [`Error::Request`] for more parts than realisations.
    pub(crate) fn range(self, realisations: usize) -> Result<Range<usize>> {
        if self.of > realisations {
            let expected =
                format!("at most as many parts as segments of all records, {realisations}");
            return Err(Error::request("part", expected, self));
        }
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
        let (record, Segments { length, hop, .. }) = (self.segments.record, self.segments);
        let refuse = |expected: String| {
            let last = samples.end.max(1) - 1;
            let found = format!("samples {} to {last}", samples.start);
            Err(Error::request("first", expected, found))
        };
        if samples.end > record {
            return refuse(format!("a block of the {record} samples of a record"));
        }
        let from = samples.start.div_ceil(hop);
        let is_long = samples.len() >= length;
        let end = is_long.then(|| ((samples.end - length) / hop + 1).min(self.segments.count()));
        let end = end.unwrap_or(0);
        if end <= from {
            let holds = format!("{length} samples from a multiple of {hop} on");
            return refuse(format!("a block that holds a segment: {holds}"));
        }
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

    /// Adds how steady the records of a portion of a shot are, of up to eight sites: where segments are left out, by the samples that
    /// are there.
    pub fn add_steadiness(
        &self,
        (shot, portion): (&Shot<'_>, &Portion),
        (sites, records): (impl Iterator<Item = usize> + Clone, Records<'_>),
        scratch: &mut Vec<f64>,
        sums: &mut Sums,
    ) {
        if shot.leaves_out {
            sums.add_record(shot.steadiness(sites, records, self.about_mean()));
            return;
        }
        let mark = shot.mark(sites);
        for segment in portion.segments.clone() {
            let of = (portion, segment, records, shot.scale);
            self.add_pieces(of, mark, scratch, sums);
        }
        sums.close(self.reached(), self.about_mean());
    }

    /// Adds the samples of up to eight `records`, those of a portion, times `scale`, from the start of a segment
    /// to that of the next. A `mark` of NaN makes their steadiness NaN.
    pub fn add_pieces(
        &self,
        (portion, segment, records, scale): (&Portion, usize, Records<'_>, f64),
        mark: [f64; TOGETHER],
        scratch: &mut Vec<f64>,
        sums: &mut Sums,
    ) {
        let (length, last) = (self.piece_length(), self.pieces() - 1);
        let mut from = segment * self.segments.hop;
        let end = match segment + 1 == self.segments.count() {
            true => self.reached(),
            false => from + self.segments.hop,
        };
        while from < end {
            let piece = (from / length).min(last);
            let to = match piece == last {
                true => end,
                false => end.min((piece + 1) * length),
            };
            let samples = from - portion.samples.start..to - portion.samples.start;
            let count = samples.len() as f64;
            let [means, squares] = records.mean_and_squares(samples, scratch);
            let means = means.map(|mean| mean * scale);
            let squares = std::array::from_fn(|lane| squares[lane] * (scale * scale) + mark[lane]);
            sums.add_piece((portion.record, piece), count, means, squares);
            from = to;
        }
    }
}
