//! A first pass over all records, time by time, in the memory order of most files.

use std::ops::Add;

use super::scan::ChannelScan;
use crate::numeric::lanes::{Lanes, SimdKernel, WIDTH, widest};
use crate::system::prefetch::prefetch;

/// Times per group; a group is examined before the next sites.
const TOGETHER: usize = 8;

/// Statistics of each site's samples that do not depend on order, so that parts may be merged.
///
/// The least and the largest sample, the same of the samples that equal the one before, and 0, or NaN once a sample was
/// not finite; of eight sites at a time.
#[derive(Debug, Clone)]
pub(crate) struct Extremes {
    sites: usize,
    blocks: Vec<[[f64; WIDTH]; 5]>,
}

impl Extremes {
    pub fn none(sites: usize) -> Self {
        let (most, least) = (f64::INFINITY, f64::NEG_INFINITY);
        let block = [most, least, most, least, 0.0].map(|v| [v; WIDTH]);
        let blocks = vec![block; sites.div_ceil(WIDTH)];
        Extremes { sites, blocks }
    }

    /// Adds the samples of neighbouring times; rows are `apart` numbers apart. With `before`, the
    /// first row is the previous time, which was added already.
    pub fn take(&mut self, rows: &[f64], apart: usize, before: bool) {
        // A group of rows stays in the cache while its columns are examined.
        let first = usize::from(before);
        let times = (rows.len() - self.sites) / apart + 1;
        for from in (first..times).step_by(TOGETHER) {
            let start = from - usize::from(from > 0);
            let end = times.min(from + TOGETHER);
            widest(Take {
                rows: &rows[start * apart..][..(end - 1 - start) * apart + self.sites],
                seen: &mut *self,
                next: rows.get(end * apart..).unwrap_or_default(),
                apart,
                before: from > 0,
            });
        }
    }

    pub fn merged(mut self, other: Extremes) -> Self {
        let merge: [fn(f64, f64) -> f64; 5] = [f64::min, f64::max, f64::min, f64::max, f64::add];
        let merge = merge.iter().cycle();
        let both = self.blocks.as_flattened_mut().iter_mut();
        for ((own, other), merge) in both.zip(other.blocks.as_flattened()).zip(merge) {
            *own = std::array::from_fn(|lane| merge(own[lane], other[lane]));
        }
        self
    }

    /// The scan of each record; `None` if it needs the samples in order: gaps, and extremes held
    /// for more than one sample.
    pub fn scans(&self) -> Vec<Option<ChannelScan>> {
        (0..self.sites).map(|j| self.scan(j)).collect()
    }

    fn scan(&self, j: usize) -> Option<ChannelScan> {
        let block = &self.blocks[j / WIDTH];
        let [low, high, low_again, high_again, finite] = block.map(|seen| seen[j % WIDTH]);
        let largest = high.max(-low);
        let held = |extreme: f64, again: f64| extreme == again && extreme.abs() >= 0.5 * largest;
        let constant = low >= high;
        let is_held = held(low, low_again) || held(high, high_again);
        if finite.is_nan() || (is_held && !constant) {
            return None;
        }
        Some(ChannelScan {
            largest,
            constant,
            clipped_run: usize::from(!constant),
            ..ChannelScan::default()
        })
    }
}

struct Take<'a> {
    seen: &'a mut Extremes,
    rows: &'a [f64],
    /// The next samples, to be prefetched.
    next: &'a [f64],
    apart: usize,
    before: bool,
}

impl SimdKernel for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let [zero, most] = [0.0, f64::INFINITY].map(L::splat);
        for (block, at) in self.seen.blocks.iter_mut().zip((0..).step_by(WIDTH)) {
            let start = block.each_ref().map(|seen| L::read(seen));
            let [mut low, mut high, mut low_again, mut high_again, mut finite] = start;
            let mut last = zero;
            for (n, row) in self.rows.chunks(self.apart).enumerate() {
                if let Some(sample) = self.next.get(n * self.apart + at) {
                    prefetch(sample);
                }
                // Lanes beyond the last site are not read.
                let v = match row[at..].first_chunk() {
                    Some(samples) => L::read(samples),
                    None => {
                        let mut samples = [0.0; WIDTH];
                        samples[..row.len() - at].copy_from_slice(&row[at..]);
                        L::read(&samples)
                    }
                };
                if n > 0 || !self.before {
                    (low, high) = (low.min(v), high.max(v));
                    // A sample that is not finite makes the sum NaN.
                    finite = finite + v * zero;
                }
                if n > 0 {
                    let change = (v - last).abs();
                    low_again = low_again.min(change.choose(most, v));
                    high_again = high_again.max(change.choose(zero - most, v));
                }
                last = v;
            }
            let found = [low, high, low_again, high_again, finite];
            let seen = found.into_iter().zip(block);
            seen.for_each(|(found, seen)| found.write(seen));
        }
    }
}
