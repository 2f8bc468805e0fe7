//! A part of all realisations: a contiguous range of the segments of all records.

use std::fmt;
use std::ops::Range;

use super::averaging::Realisations;
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
    pub(super) fn portion(&self, record: usize, segments: Range<usize>, end: usize) -> Portion {
        let (count, Segments { length, hop, .. }) = (self.segments.count(), self.segments);
        let last = match segments.end == count {
            true => end,
            false => (segments.end - 1) * hop + length,
        };
        Portion {
            record,
            samples: segments.start * hop..last,
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

    /// So many records, each as one portion.
    pub fn whole_records(&self, records: usize) -> Vec<Portion> {
        self.portions(0..records * self.segments.count())
    }
}
