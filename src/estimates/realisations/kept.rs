//! Segments without missing samples: those that averages keep where samples are missing.

use super::shots::TOGETHER;
use crate::numeric::median;
use crate::transform::Segments;

/// Which segments of a record are kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct KeptSegments(Vec<bool>);

impl KeptSegments {
    /// Those that hold none of the `missing` samples of the record.
    pub fn without(segments: Segments, missing: impl IntoIterator<Item = usize>) -> Self {
        let mut kept = vec![true; segments.count()];
        for time in missing {
            // s hop <= time < s hop + length.
            let before = (time + 1).saturating_sub(segments.length);
            let first = before.div_ceil(segments.hop);
            let end = time / segments.hop + 1;
            let holds = kept.iter_mut().take(end).skip(first);
            holds.for_each(|kept| *kept = false);
        }
        KeptSegments(kept)
    }

    pub fn has(&self, segment: usize) -> bool {
        self.0[segment]
    }

    /// Of up to eight sites 1 for each that has a segment, else 0; `kept` of no site where none are left out.
    pub fn has_each(kept: &[KeptSegments], segment: usize) -> [f64; TOGETHER] {
        std::array::from_fn(|lane| match kept.get(lane) {
            Some(kept) if !kept.has(segment) => 0.0,
            _ => 1.0,
        })
    }

    /// Those that both keep.
    pub fn and(&self, other: &KeptSegments) -> KeptSegments {
        let both = self.0.iter().zip(&other.0);
        KeptSegments(both.map(|(a, b)| *a && *b).collect())
    }

    pub fn count(&self) -> usize {
        self.0.iter().filter(|kept| **kept).count()
    }

    /// How many pairs of kept segments are each distance apart, from 0.
    pub fn pairs(&self, distances: usize) -> Vec<f64> {
        let of = |distance: usize| {
            let pairs = self.0.iter().zip(self.0.iter().skip(distance));
            pairs.filter(|(a, b)| **a && **b).count() as f64
        };
        (0..distances).map(of).collect()
    }
}

/// Pairs of kept segments of several records.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct SegmentPairs {
    /// How many of them are each distance apart, from 0.
    pub pairs: Vec<f64>,
    /// Records of which a segment is kept.
    pub records: usize,
}

impl SegmentPairs {
    /// Adds those of a record.
    pub fn add(&mut self, pairs: Vec<f64>) {
        self.pairs.resize(pairs.len(), 0.0);
        self.records += usize::from(pairs[0] > 0.0);
        self.pairs.iter_mut().zip(pairs).for_each(|(a, b)| *a += b);
    }

    /// Kept segments of all records.
    pub fn segments(&self) -> f64 {
        self.pairs.first().copied().unwrap_or_default()
    }
}

/// What averages of each site have left, where segments with missing samples are left out.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SegmentsLeft {
    /// Segments of all records.
    pub of: usize,
    /// Those that are left, of each site.
    pub left: Vec<usize>,
    /// The effective number of each site's realisations: Welch's sum over the segments that are left.
    pub effective: Vec<f64>,
}

impl SegmentsLeft {
    /// Sites that have lost segments.
    pub fn incomplete(&self) -> usize {
        self.left.iter().filter(|left| **left < self.of).count()
    }

    /// Sites without any segment.
    pub fn empty(&self) -> Vec<usize> {
        let sites = 0..self.left.len();
        sites.filter(|j| self.left[*j] == 0).collect()
    }

    /// The least number of segments of a site that has any, and the median of all sites; 0 for no sites.
    pub fn least_and_median(&self) -> [usize; 2] {
        let mut sorted = self.left.clone();
        sorted.sort_unstable();
        let least = sorted.iter().find(|left| **left > 0);
        [least, sorted.get(sorted.len() / 2)].map(|left| left.copied().unwrap_or_default())
    }

    /// The median of the effective numbers.
    pub(crate) fn median_effective(&self) -> f64 {
        median(self.effective.iter().copied()).unwrap_or(f64::NAN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_that_hold_a_missing_sample_go() {
        let segments = Segments {
            record: 20,
            length: 6,
            hop: 3,
        };
        // Segments 0..6, 3..9, 6..12, 9..15, 12..18.
        let kept = |missing: &[usize]| {
            let kept = KeptSegments::without(segments, missing.iter().copied());
            (0..5).filter(|s| kept.has(*s)).collect::<Vec<_>>()
        };
        assert_eq!(kept(&[]), [0, 1, 2, 3, 4]);
        assert_eq!(kept(&[5]), [2, 3, 4]);
        assert_eq!(kept(&[6]), [0, 3, 4]);
        assert_eq!(kept(&[0, 17]), [1, 2, 3]);
        // Behind the last segment.
        assert_eq!(kept(&[18, 19]), [0, 1, 2, 3, 4]);
        let some = KeptSegments::without(segments, [6]);
        assert_eq!(some.pairs(2), [3.0, 1.0]);
    }
}
