//! Overlapping segments of a record.

/// Starts of the segments of `length` samples, `hop` apart, that fit in `record` samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Segments {
    pub record: usize,
    pub length: usize,
    pub hop: usize,
}

impl Segments {
    /// The whole record as one segment.
    pub fn whole(record: usize) -> Segments {
        Segments {
            record,
            length: record,
            hop: record,
        }
    }

    pub fn count(&self) -> usize {
        1 + (self.record - self.length) / self.hop
    }

    pub fn starts(&self) -> impl ExactSizeIterator<Item = usize> + use<> {
        let hop = self.hop;
        (0..self.count()).map(move |s| s * hop)
    }

    /// Samples at the end that no segment reaches.
    pub fn left_over(&self) -> usize {
        self.record - ((self.count() - 1) * self.hop + self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_scipy_welch_segment_count() {
        // scipy.signal.welch: (900 - 64) // (128 - 64) segments
        let s = Segments {
            record: 900,
            length: 128,
            hop: 64,
        };
        assert_eq!((s.count(), s.left_over()), (13, 4));
        assert_eq!(Segments::whole(7).count(), 1);
    }
}
