//! A first look at all records at once, time by time, as they lie in most files.

use super::scan::ChannelScan;
use crate::chain::lanes::{Lanes, Work, widest};

/// What is seen of each site's samples in passing; order does not matter, so parts may be merged.
#[derive(Debug, Clone)]
pub(crate) struct Extremes {
    low: Vec<f64>,
    high: Vec<f64>,
    /// The least and the largest of the samples that equal the one before.
    low_again: Vec<f64>,
    high_again: Vec<f64>,
    /// 0, or NaN once a sample was not finite.
    finite: Vec<f64>,
}

impl Extremes {
    pub fn none(sites: usize) -> Self {
        Extremes {
            low: vec![f64::INFINITY; sites],
            high: vec![f64::NEG_INFINITY; sites],
            low_again: vec![f64::INFINITY; sites],
            high_again: vec![f64::NEG_INFINITY; sites],
            finite: vec![0.0; sites],
        }
    }

    /// Takes in the samples of one time; `before` are those of the time before, if there is one.
    pub fn take(&mut self, profile: &[f64], before: Option<&[f64]>) {
        let seen = &mut *self;
        widest(Take {
            seen,
            profile,
            before,
        });
    }

    pub fn merged(mut self, other: Extremes) -> Self {
        let least =
            |a: &mut [f64], b: &[f64]| a.iter_mut().zip(b).for_each(|(a, b)| *a = a.min(*b));
        let largest =
            |a: &mut [f64], b: &[f64]| a.iter_mut().zip(b).for_each(|(a, b)| *a = a.max(*b));
        least(&mut self.low, &other.low);
        least(&mut self.low_again, &other.low_again);
        largest(&mut self.high, &other.high);
        largest(&mut self.high_again, &other.high_again);
        for (a, b) in self.finite.iter_mut().zip(other.finite) {
            *a += b;
        }
        self
    }

    /// The scan of each record; `None` where only its own samples in order can tell: gaps, and
    /// extremes that were held for more than one sample.
    pub fn scans(&self) -> Vec<Option<ChannelScan>> {
        (0..self.low.len()).map(|j| self.scan(j)).collect()
    }

    fn scan(&self, j: usize) -> Option<ChannelScan> {
        let (low, high) = (self.low[j], self.high[j]);
        let largest = high.max(-low);
        let held = |extreme: f64, again: f64| extreme == again && extreme.abs() >= 0.5 * largest;
        let constant = low >= high;
        let is_held = held(low, self.low_again[j]) || held(high, self.high_again[j]);
        if self.finite[j].is_nan() || (is_held && !constant) {
            return None;
        }
        Some(ChannelScan {
            largest,
            gaps: 0,
            first_gap: None,
            constant,
            clipped_run: usize::from(!constant),
        })
    }
}

struct Take<'a> {
    seen: &'a mut Extremes,
    profile: &'a [f64],
    before: Option<&'a [f64]>,
}

impl Work for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Take {
            seen,
            profile,
            before,
        } = self;
        let extremes = seen.low.iter_mut().zip(&mut seen.high);
        for ((&v, finite), (low, high)) in profile.iter().zip(&mut seen.finite).zip(extremes) {
            *low = if v < *low { v } else { *low };
            *high = if v > *high { v } else { *high };
            // Times 0, what is not finite becomes NaN, and stays it.
            *finite += v * 0.0;
        }
        let Some(before) = before else { return };
        let again = seen.low_again.iter_mut().zip(&mut seen.high_again);
        for ((&v, &last), (low, high)) in profile.iter().zip(before).zip(again) {
            let least = if v == last { v } else { f64::INFINITY };
            let largest = if v == last { v } else { f64::NEG_INFINITY };
            *low = if least < *low { least } else { *low };
            *high = if largest > *high { largest } else { *high };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(record: &[f64]) -> Option<ChannelScan> {
        // In two parts, merged: the second knows the last sample of the first.
        let (first, second) = record.split_at(record.len() / 2);
        let mut parts = [Extremes::none(1), Extremes::none(1)];
        for (n, v) in first.iter().enumerate() {
            parts[0].take(&[*v], n.checked_sub(1).map(|b| &first[b..n]));
        }
        for (n, v) in second.iter().enumerate() {
            let at = first.len() + n;
            parts[1].take(&[*v], at.checked_sub(1).map(|b| &record[b..at]));
        }
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
}
