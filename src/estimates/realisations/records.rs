//! Records of a few sites, interleaved or one after another.

use std::ops::Range;

use super::shots::TOGETHER;
use crate::numeric::{squares_across, sum, sum_of_squares, sums_across};

/// Records of the same length.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Records<'r> {
    samples: &'r [f64],
    width: usize,
    /// Whether a row holds one sample of each.
    is_interleaved: bool,
}

impl<'r> Records<'r> {
    /// A row of `width` samples for each time.
    pub fn interleaved(samples: &'r [f64], width: usize) -> Self {
        Records {
            samples,
            width,
            is_interleaved: true,
        }
    }

    /// Of `length` samples each.
    pub fn one_after_another(samples: &'r [f64], length: usize) -> Self {
        Records {
            samples,
            width: samples.len() / length,
            is_interleaved: false,
        }
    }

    /// Number of records.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Samples of a record.
    pub fn length(&self) -> usize {
        self.samples.len() / self.width
    }

    /// Samples of one record, in `out` in place of what was there.
    pub fn copy(&self, record: usize, times: Range<usize>, out: &mut Vec<f64>) {
        out.clear();
        match self.is_interleaved {
            true => {
                let rows = &self.samples[times.start * self.width..times.end * self.width];
                out.extend(rows.iter().skip(record).step_by(self.width));
            }
            false => out.extend_from_slice(&self.samples[record * self.length()..][times]),
        }
    }

    /// A whole record.
    pub fn record(&self, record: usize) -> Vec<f64> {
        let mut samples = Vec::with_capacity(self.length());
        self.copy(record, 0..self.length(), &mut samples);
        samples
    }

    /// Rows of one sample of each record, put together in `room` where they are not.
    pub fn rows<'s>(&self, times: Range<usize>, room: &'s mut Vec<f64>) -> &'s [f64]
    where
        'r: 's,
    {
        if self.is_interleaved || self.width == 1 {
            return &self.samples[times.start * self.width..times.end * self.width];
        }
        room.resize(times.len() * self.width, 0.0);
        for (record, samples) in self.samples.chunks_exact(self.length()).enumerate() {
            let column = room.iter_mut().skip(record).step_by(self.width);
            let column = column.zip(&samples[times.clone()]);
            column.for_each(|(to, v)| *to = *v);
        }
        room
    }

    /// The mean of each record at these times, and the sum of the squares of the deviations from it.
    pub fn mean_and_squares(
        &self,
        times: Range<usize>,
        room: &mut Vec<f64>,
    ) -> [[f64; TOGETHER]; 2] {
        let count = times.len() as f64;
        if self.is_interleaved && self.width == TOGETHER {
            let rows = &self.samples[times.start * TOGETHER..times.end * TOGETHER];
            let (rows, _) = rows.as_chunks();
            let means = sums_across(rows, &[0.0; TOGETHER]).map(|sum| sum / count);
            return [means, squares_across(rows, &means)];
        }
        let [mut means, mut squares] = [[0.0; TOGETHER]; 2];
        let found = means.iter_mut().zip(&mut squares);
        for (record, (mean, squares)) in found.enumerate().take(self.width) {
            self.copy(record, times.clone(), room);
            *mean = sum(room) / count;
            room.iter_mut().for_each(|v| *v -= *mean);
            *squares = sum_of_squares(room);
        }
        [means, squares]
    }

    /// The sum of the squares of each record at these times.
    pub fn squares(&self, times: Range<usize>, room: &mut Vec<f64>) -> [f64; TOGETHER] {
        if self.is_interleaved && self.width == TOGETHER {
            let rows = &self.samples[times.start * TOGETHER..times.end * TOGETHER];
            return squares_across(rows.as_chunks().0, &[0.0; TOGETHER]);
        }
        let mut found = [0.0; TOGETHER];
        for (record, squares) in found.iter_mut().enumerate().take(self.width) {
            self.copy(record, times.clone(), room);
            *squares = sum_of_squares(room);
        }
        found
    }
}
