//! A scan of every record before the transforms: range, gaps, dead and clipped channels.

use super::Gaps;

/// A sample that was not finite, and its replacement (raw units).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    pub time: usize,
    pub site: usize,
    pub value: f64,
}

/// What one record holds; by default one that is left out.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
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
        let runs = record.chunk_by(|a, b| a == b);
        let held = runs.filter(|run| !constant && is_extreme(run[0]));
        ChannelScan {
            largest,
            gaps,
            first_gap,
            constant,
            clipped_run: held.map(<[f64]>::len).max().unwrap_or(0),
        }
    }
}

/// The gaps of `record` with their replacements: what is masked has the mean of the others.
pub(crate) fn fill(record: &[f64], site: usize, gaps: Gaps) -> Vec<Gap> {
    let finite = record.iter().copied().filter(|v| v.is_finite());
    let finite: Vec<f64> = finite.filter(|_| gaps == Gaps::Mask).collect();
    let mean = crate::numeric::sum(&finite) / finite.len().max(1) as f64;
    let (mut filled, mut end) = (Vec::new(), 0);
    for run in record.chunk_by(|a, b| a.is_finite() == b.is_finite()) {
        let start = end;
        end += run.len();
        if run[0].is_finite() {
            continue;
        }
        let before = start.checked_sub(1).map(|n| record[n]);
        let after = record.get(end).copied();
        filled.extend((start..end).map(|time| {
            let value = match (gaps, before, after) {
                (Gaps::Mask, ..) => mean,
                (Gaps::Interpolate, Some(a), Some(b)) => {
                    let weight = (time + 1 - start) as f64 / (end - start + 1) as f64;
                    a * (1.0 - weight) + b * weight
                }
                (Gaps::Interpolate, only, None) | (Gaps::Interpolate, None, only) => {
                    only.unwrap_or(0.0)
                }
                (Gaps::Refuse | Gaps::LeaveOut, ..) => 0.0,
            };
            Gap { time, site, value }
        }));
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_filled_along_the_line_and_held_at_the_ends() {
        let nan = f64::NAN;
        let record = [nan, 2.0, nan, nan, 8.0, f64::NEG_INFINITY];
        let gaps = fill(&record, 3, Gaps::Interpolate);
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
