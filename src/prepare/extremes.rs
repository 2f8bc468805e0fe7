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
/// not finite.
#[derive(Debug, Clone)]
pub(crate) struct Extremes([Vec<f64>; 5]);

impl Extremes {
    pub fn none(sites: usize) -> Self {
        let (most, least) = (f64::INFINITY, f64::NEG_INFINITY);
        Extremes([most, least, most, least, 0.0].map(|v| vec![v; sites]))
    }

    fn sites(&self) -> usize {
        self.0[0].len()
    }

    /// Adds the samples of neighbouring times; rows are `apart` numbers apart. With `before`, the
    /// first row is the previous time, which was added already.
    pub fn take(&mut self, rows: &[f64], apart: usize, before: bool) {
        let sites = self.sites();
        // A group of rows stays in the cache while its columns are examined.
        let first = usize::from(before);
        let times = (rows.len() - sites) / apart + 1;
        for from in (first..times).step_by(TOGETHER) {
            let start = from - usize::from(from > 0);
            let end = times.min(from + TOGETHER);
            widest(Take {
                seen: &mut *self,
                rows: &rows[start * apart..][..(end - 1 - start) * apart + sites],
                next: rows.get(end * apart..).unwrap_or_default(),
                apart,
                before: from > 0,
            });
        }
    }

    pub fn merged(mut self, other: Extremes) -> Self {
        let merge: [fn(f64, f64) -> f64; 5] = [f64::min, f64::max, f64::min, f64::max, f64::add];
        for ((own, other), merge) in self.0.iter_mut().zip(&other.0).zip(merge) {
            own.iter_mut()
                .zip(other)
                .for_each(|(a, b)| *a = merge(*a, *b));
        }
        self
    }

    /// The scan of each record; `None` if it needs the samples in order: gaps, and extremes held
    /// for more than one sample.
    pub fn scans(&self) -> Vec<Option<ChannelScan>> {
        (0..self.sites()).map(|j| self.scan(j)).collect()
    }

    fn scan(&self, j: usize) -> Option<ChannelScan> {
        let [low, high, low_again, high_again, finite] = self.0.each_ref().map(|seen| seen[j]);
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
            ..ChannelScan::NOTHING
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
        let sites = self.seen.sites();
        let mut seen = self.seen.0.each_mut().map(Vec::as_mut_slice);
        let times = (self.rows.len() - sites) / self.apart + 1;
        if sites < WIDTH {
            // Unused lanes repeat the first one.
            let padded = |samples: &[f64]| {
                let mut padded = [samples[0]; WIDTH];
                padded[..sites].copy_from_slice(&samples[..sites]);
                padded
            };
            let mut rows = [[0.0; WIDTH]; TOGETHER + 1];
            for (row, samples) in rows.iter_mut().zip(self.rows.chunks(self.apart)) {
                *row = padded(samples);
            }
            let mut lanes = seen.each_ref().map(|seen| padded(seen));
            look::<L>(|n| rows.get(n), times, self.before, lanes.each_mut());
            for (lanes, seen) in lanes.iter().zip(seen) {
                seen.copy_from_slice(&lanes[..sites]);
            }
            return;
        }
        for start in (0..sites).step_by(WIDTH) {
            // The last columns overlap those before: a second look changes nothing.
            let at = start.min(sites - WIDTH);
            let lanes = seen.each_mut().map(|seen| seen[at..].first_chunk_mut());
            if let [Some(a), Some(b), Some(c), Some(d), Some(e)] = lanes {
                let profile = |n: usize| {
                    if let Some(sample) = self.next.get(n * self.apart + at) {
                        prefetch(sample);
                    }
                    self.rows.get(n * self.apart + at..)?.first_chunk()
                };
                look::<L>(profile, times, self.before, [a, b, c, d, e]);
            }
        }
    }
}

/// Examines the samples of eight sites, time by time; with `before`, the first time was examined
/// already.
#[inline(always)]
fn look<'a, L: Lanes>(
    profile: impl Fn(usize) -> Option<&'a [f64; WIDTH]>,
    times: usize,
    before: bool,
    seen: [&mut [f64; WIDTH]; 5],
) {
    let [low_at, high_at, low_again_at, high_again_at, finite_at] = seen;
    let (mut low, mut high) = (L::read(low_at), L::read(high_at));
    let (mut low_again, mut high_again) = (L::read(low_again_at), L::read(high_again_at));
    let mut finite = L::read(finite_at);
    let (zero, most) = (L::splat(0.0), L::splat(f64::INFINITY));
    // NaN equals no sample.
    let mut last = L::splat(f64::NAN);
    let mut first = 0;
    if let Some(samples) = profile(0).filter(|_| before) {
        last = L::read(samples);
        first = 1;
    }
    for n in first..times {
        let Some(samples) = profile(n) else { break };
        let v = L::read(samples);
        low = v.least(low);
        high = v.largest(high);
        // A sample that is not finite makes the sum NaN.
        finite = finite + v * zero;
        low_again = v.where_equal(last, most).least(low_again);
        high_again = v.where_equal(last, zero - most).largest(high_again);
        last = v;
    }
    low.write(low_at);
    high.write(high_at);
    low_again.write(low_again_at);
    high_again.write(high_again_at);
    finite.write(finite_at);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(record: &[f64]) -> Option<ChannelScan> {
        // In two parts, merged: the second knows the last sample of the first.
        let (first, _) = record.split_at(record.len() / 2);
        let mut parts = [Extremes::none(1), Extremes::none(1)];
        if !first.is_empty() {
            parts[0].take(first, 1, false);
        }
        parts[1].take(
            &record[first.len().saturating_sub(1)..],
            1,
            !first.is_empty(),
        );
        let [a, b] = parts;
        let one = a.clone().merged(b.clone()).scans()[0];
        assert_eq!(one, b.merged(a).scans()[0]);
        one
    }

    #[test]
    fn what_can_be_told_in_passing_is_what_the_record_says() {
        let tone: Vec<f64> = (0..50).map(|i| (f64::from(i) * 0.3).sin()).collect();
        let mut late = vec![0.0; 50];
        late[49] = -3.0;
        let rests = [vec![0.0; 20], tone.clone(), vec![0.0; 20]].concat();
        for record in [
            tone.clone(),
            late,
            rests,
            vec![4.0; 9],
            vec![0.0; 9],
            vec![7.0],
        ] {
            assert_eq!(scan(&record), Some(ChannelScan::of(&record)), "{record:?}");
        }
        // Held at an extreme, across the middle; a gap; an infinity.
        let mut held = tone.clone();
        (held[24], held[25]) = (2.0, 2.0);
        let (mut early, mut late) = (tone.clone(), tone.clone());
        (early[3], early[4]) = (-2.0, -2.0);
        (late[44], late[45]) = (2.0, 2.0);
        let clipped: Vec<f64> = tone.iter().map(|v| v.clamp(-0.5, 0.5)).collect();
        let mut gap = tone.clone();
        gap[30] = f64::NAN;
        let mut infinite = tone;
        infinite[3] = f64::NEG_INFINITY;
        for record in [held, early, late, clipped, gap, infinite] {
            assert_eq!(scan(&record), None, "{record:?}");
        }
    }

    /// In groups of times that begin anywhere, and columns that overlap.
    #[test]
    fn sites_side_by_side_are_seen_as_each_alone() {
        for sites in [1, 3, 8, 13] {
            let apart = sites + 5;
            let times = 4 * TOGETHER + 3;
            let not_finite = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
            let sample = |n: usize, j: usize| match (n + j) % 11 {
                0 if j % 4 == 1 => not_finite[j / 4 % 3],
                3 | 4 if j % 4 == 2 => 20.0,
                _ => ((n * 7 + j * 3) % 23) as f64 - 11.0,
            };
            let mut rows = vec![f64::NAN; (times - 1) * apart + sites];
            for (n, row) in rows.chunks_mut(apart).enumerate() {
                (0..sites).for_each(|j| row[j] = sample(n, j));
            }
            for split in [1, 2, TOGETHER, 2 * TOGETHER + 1] {
                let mut seen = Extremes::none(sites);
                seen.take(&rows[..(split - 1) * apart + sites], apart, false);
                seen.take(&rows[(split - 1) * apart..], apart, true);
                for (j, found) in seen.scans().into_iter().enumerate() {
                    let record: Vec<f64> = (0..times).map(|n| sample(n, j)).collect();
                    // The second and third of each four have gaps, or hold their extreme.
                    let told = !(1..=2).contains(&(j % 4));
                    let expected = told.then(|| ChannelScan::of(&record));
                    assert_eq!(found, expected, "{sites} sites, {split} times, {j}");
                }
            }
        }
    }
}
