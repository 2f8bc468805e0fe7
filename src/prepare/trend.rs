//! Trends: the mean or the least-squares line of a record.

use super::Detrend;
use crate::numeric::lanes::{WIDTH, on_lines};
use crate::numeric::{sum, sums_across};
use crate::transform::less_means;

/// A trend `high + low + slope (i - (n - 1) / 2)` over the indices of a record.
///
/// The mean is kept as an unevaluated sum of two doubles: for an offset far above the signal,
/// `v - high` is exact, and only then is what `high` lacks of the mean removed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Trend {
    pub high: f64,
    pub low: f64,
    pub slope: f64,
    pub centre: f64,
}

impl Trend {
    /// The trend of `record`, over samples for which `keep` holds; 0 where none does.
    pub fn fit(
        record: &[f64],
        kind: Detrend,
        keep: impl Fn(usize) -> bool,
        scratch: &mut Vec<f64>,
    ) -> Trend {
        if kind == Detrend::None {
            return Trend::default();
        }
        let centre = (record.len() as f64 - 1.0) / 2.0;
        let kept = |i: &usize| keep(*i);
        let mut total = |value: &dyn Fn(usize) -> f64| {
            scratch.clear();
            scratch.extend((0..record.len()).filter(kept).map(value));
            (sum(scratch), scratch.len() as f64)
        };
        let (first, count) = total(&|i| record[i]);
        if count == 0.0 {
            return Trend::default();
        }
        let high = first / count;
        let low = total(&|i| record[i] - high).0 / count;
        let mut trend = Trend {
            high,
            low,
            slope: 0.0,
            centre,
        };
        if kind == Detrend::Linear {
            // Gaps shift the mean of the indices off the centre, so it is found anew.
            let mean = total(&|i| i as f64 - centre).0 / count;
            let place = |i: usize| i as f64 - centre - mean;
            let (spread, _) = total(&|i| place(i).powi(2));
            if spread > 0.0 {
                let (covariance, _) = total(&|i| place(i) * ((record[i] - high) - low));
                trend.slope = covariance / spread;
                trend.low -= trend.slope * mean;
            }
        }
        trend
    }

    /// `value` at index `i` without the trend.
    #[inline(always)]
    pub fn remove(&self, value: f64, i: usize) -> f64 {
        (value - self.high) - (self.low + self.slope * (i as f64 - self.centre))
    }

    /// Removes the trend from `samples`, the first at the index `from`.
    pub fn remove_all(&self, from: usize, samples: &mut [f64]) {
        for (v, i) in samples.iter_mut().zip(from..) {
            *v = self.remove(*v, i);
        }
    }

    /// Removes the trend of the samples for which `keep` holds from `record`.
    pub fn remove_from(
        record: &mut [f64],
        kind: Detrend,
        keep: impl Fn(usize) -> bool,
        scratch: &mut Vec<f64>,
    ) {
        if kind != Detrend::None {
            Trend::fit(record, kind, keep, scratch).remove_all(0, record);
        }
    }

    /// Records that are interleaved, `width` to a row, each without its trend, with the bits of
    /// [`Self::remove_from`]; in `room`.
    pub fn removed_across<'r>(
        (rows, width): (&[f64], usize),
        kind: Detrend,
        room: &'r mut Vec<f64>,
        scratch: &mut Vec<f64>,
    ) -> &'r [f64] {
        let out = on_lines(room, rows.len());
        if width == WIDTH && kind == Detrend::Mean {
            let (rows, out) = (rows.as_chunks().0, out.as_chunks_mut().0);
            let mean = |less: &_| sums_across(rows, less).map(|sum| sum / rows.len() as f64);
            let high = mean(&[0.0; WIDTH]);
            less_means(rows, [high, mean(&high)], std::iter::repeat(1.0), out);
        } else {
            let mut record = Vec::with_capacity(rows.len() / width);
            for column in 0..width {
                record.clear();
                record.extend(rows.iter().skip(column).step_by(width));
                Trend::remove_from(&mut record, kind, |_| true, scratch);
                let places = out.iter_mut().skip(column).step_by(width);
                places.zip(&record).for_each(|(to, v)| *to = *v);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_with_gaps_is_removed() {
        let mut record: Vec<f64> = (0..64).map(|i| 3.0 - 0.25 * f64::from(i)).collect();
        (record[5], record[63]) = (f64::NAN, f64::INFINITY);
        let line = |record: &[f64]| {
            let is_kept = |i: usize| record[i].is_finite();
            Trend::fit(record, Detrend::Linear, is_kept, &mut vec![])
        };
        let trend = line(&record);
        for (i, &v) in record.iter().enumerate().filter(|(_, v)| v.is_finite()) {
            assert!(trend.remove(v, i).abs() < 1e-14);
        }
        let alone = line(&[7.0]);
        assert_eq!((alone.high, alone.slope), (7.0, 0.0));
        assert_eq!(line(&[]), Trend::default());
    }
}
