//! Records of a few sites, interleaved.

use std::ops::Range;

use super::shots::TOGETHER;
use crate::numeric::{squares_across, sums_across};

/// Records of the same length: a row of one sample of each for each time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Records<'r> {
    samples: &'r [f64],
    width: usize,
}

impl<'r> Records<'r> {
    pub fn interleaved(samples: &'r [f64], width: usize) -> Self {
        Records { samples, width }
    }

    /// Number of records.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Samples of a record.
    pub fn length(&self) -> usize {
        self.samples.len() / self.width
    }

    /// A whole record.
    pub fn record(&self, record: usize) -> Vec<f64> {
        let samples = self.samples.iter().skip(record).step_by(self.width);
        samples.copied().collect()
    }

    pub fn rows(&self, times: Range<usize>) -> &'r [f64] {
        &self.samples[times.start * self.width..times.end * self.width]
    }

    /// The mean of each record at these times, and the sum of the squares of the deviations from it; 0 beyond the last.
    pub fn mean_and_squares(
        &self,
        times: Range<usize>,
        room: &mut Vec<f64>,
    ) -> [[f64; TOGETHER]; 2] {
        let count = times.len() as f64;
        let mut rows = self.rows(times);
        if self.width < TOGETHER {
            room.clear();
            for row in rows.chunks_exact(self.width) {
                room.extend_from_slice(row);
                room.resize(room.len().next_multiple_of(TOGETHER), 0.0);
            }
            rows = room;
        }
        let (rows, _) = rows.as_chunks();
        let means = sums_across(rows, &[0.0; TOGETHER]).map(|sum| sum / count);
        [means, squares_across(rows, &means)]
    }
}

/// Interleaves records of `length` samples that lie one after another.
pub(crate) fn interleave(records: &[f64], length: usize, rows: &mut Vec<f64>) {
    rows.resize(records.len(), 0.0);
    let width = records.len() / length;
    for (record, samples) in records.chunks_exact(length).enumerate() {
        let column = rows.iter_mut().skip(record).step_by(width);
        column.zip(samples).for_each(|(to, v)| *to = *v);
    }
}
