//! A scan of every record before the transforms: range, gaps, dead and clipped channels.

use super::Gaps;

/// A sample that was not finite, and its replacement (raw units).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    pub time: usize,
    pub site: usize,
    pub value: f64,
}

/// What one record holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ChannelScan {
    /// Largest finite magnitude.
    pub largest: f64,
    pub gaps: usize,
    pub first_gap: Option<usize>,
    /// All finite samples are equal.
    pub constant: bool,
    /// Longest run of equal samples on an extreme of the record, if that extreme is of the
    /// record's own size; rests at zero do not count.
    pub clipped_run: usize,
}

impl ChannelScan {
    /// Of a record that is left out.
    pub const NOTHING: ChannelScan = ChannelScan {
        largest: 0.0,
        gaps: 0,
        first_gap: None,
        constant: false,
        clipped_run: 0,
    };

    pub fn of(record: &[f64]) -> ChannelScan {
        let (mut low, mut high, mut gaps) = (f64::INFINITY, f64::NEG_INFINITY, 0);
        for &v in record {
            match v.is_finite() {
                true => (low, high) = (low.min(v), high.max(v)),
                false => gaps += 1,
            }
        }
        let first = || record.iter().position(|v| !v.is_finite());
        let first_gap = if gaps > 0 { first() } else { None };
        let largest = if low <= high { high.max(-low) } else { 0.0 };
        let constant = low >= high;
        let is_extreme = |v: f64| (v == high || v == low) && v.abs() >= 0.5 * largest;
        let clipped_run = match constant {
            true => 0,
            false => longest_run(record, is_extreme),
        };
        ChannelScan {
            largest,
            gaps,
            first_gap,
            constant,
            clipped_run,
        }
    }
}

fn longest_run(record: &[f64], on_extreme: impl Fn(f64) -> bool) -> usize {
    let (mut longest, mut run, mut last) = (0, 0, f64::NAN);
    for &v in record {
        run = match on_extreme(v) {
            true if v == last => run + 1,
            true => 1,
            false => 0,
        };
        last = v;
        longest = longest.max(run);
    }
    longest
}

/// The gaps of `record` with their replacements: what is masked has the mean of the others.
pub(crate) fn fill(record: &[f64], site: usize, gaps: Gaps, into: &mut Vec<Gap>) {
    let finite: Vec<f64> = match gaps {
        Gaps::Mask => record.iter().copied().filter(|v| v.is_finite()).collect(),
        _ => Vec::new(),
    };
    let mean = crate::numeric::sum(&finite) / finite.len().max(1) as f64;
    let mut start = 0;
    while start < record.len() {
        if record[start].is_finite() {
            start += 1;
            continue;
        }
        let run = record[start..].iter().take_while(|v| !v.is_finite());
        let end = start + run.count();
        let before = start.checked_sub(1).map(|n| record[n]);
        let after = record.get(end).copied();
        for time in start..end {
            let value = match (gaps, before, after) {
                (Gaps::Mask, ..) => mean,
                (Gaps::Refuse | Gaps::LeaveOut, ..) | (_, None, None) => 0.0,
                (_, Some(a), Some(b)) => {
                    let weight = (time + 1 - start) as f64 / (end - start + 1) as f64;
                    a * (1.0 - weight) + b * weight
                }
                (_, Some(only), None) | (_, None, Some(only)) => only,
            };
            into.push(Gap { time, site, value });
        }
        start = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_filled_along_the_line_and_held_at_the_ends() {
        let nan = f64::NAN;
        let record = [nan, 2.0, nan, nan, 8.0, f64::NEG_INFINITY];
        let mut gaps = Vec::new();
        fill(&record, 3, Gaps::Interpolate, &mut gaps);
        let got: Vec<_> = gaps.iter().map(|g| (g.time, g.value)).collect();
        assert_eq!(got, [(0, 2.0), (2, 4.0), (3, 6.0), (5, 8.0)]);
        assert!(gaps.iter().all(|g| g.site == 3));
    }

    #[test]
    fn a_clipped_record_is_told_from_one_at_rest() {
        let mut pulse = vec![0.0; 50];
        pulse[20] = 1.0;
        assert_eq!(ChannelScan::of(&pulse).clipped_run, 1);
        let clipped: Vec<f64> = (0..50)
            .map(|i| (f64::from(i) * 0.3).sin().clamp(-0.5, 0.5))
            .collect();
        assert!(ChannelScan::of(&clipped).clipped_run > 4);
        assert!(ChannelScan::of(&[4.0; 9]).constant);
    }
}
