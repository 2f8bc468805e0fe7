//! Ratios at which simulated pulses lose least, and most, narrowed down.

use rayon::prelude::*;

use super::leak::{Leak, LeakScan, minima};
use crate::Result;
use crate::numeric::GoldenSection;
use crate::observer::Observer;

/// A ratio at which the leak is least or most among its neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeakExtremum {
    pub ratio: f64,
    /// How far off the ratio may be, relative to it: what the chains at hand leave open.
    pub error: f64,
    /// Leak per cell there.
    pub leak: f64,
}

/// The leaks of a scan with their extremes.
#[derive(Debug, Clone, PartialEq)]
pub struct LeakCurve {
    pub leaks: Vec<Leak>,
    /// In ascending order.
    pub minima: Vec<LeakExtremum>,
    /// The largest leak between each minimum and the next.
    pub maxima: Vec<LeakExtremum>,
}

impl LeakScan {
    /// The leaks at ascending ratios, and from these on the extremes.
    ///
    /// Near a localized wave the leak falls to nothing as `|ratio - exact|^q`, q a little above 2,
    /// more steeply on one side than on the other, so that a parabola through three leaks has its
    /// vertex a tenth of their distance off. High orders have a second minimum a part of a
    /// percent below, shallow but deep enough to be taken for the first. So the ratios
    /// about a minimum are looked at more closely, and each minimum seen there is narrowed down by
    /// golden sections, which need only that the leak falls and rises, to where the leak is that of
    /// rounding, or is flat, as on chains too short for the transients of the impact to fade. The
    /// least counts. Its error reaches to the ratios on both sides beyond which four times its leak
    /// was measured.
    ///
    /// # Errors
    /// As [`LeakScan::run`]. Ratios that do not ascend are sorted.
    pub fn curve(&self, ratios: &[f64], observer: &dyn Observer) -> Result<LeakCurve> {
        let mut ratios = ratios.to_vec();
        ratios.sort_by(f64::total_cmp);
        let leaks = self.run(&ratios, observer)?;
        let least = minima(&leaks);
        let most: Vec<usize> = (least.windows(2))
            .filter_map(|pair| (pair[0] + 1..pair[1]).max_by(by_leak(&leaks)))
            .collect();
        observer.stage("extremes", (least.len() + most.len()) as u64);
        let each = |indices: &[usize], find: &(dyn Fn(usize) -> Result<LeakExtremum> + Sync)| {
            (indices.par_iter())
                .map(|&i| {
                    let extreme = find(i);
                    observer.advance(1);
                    extreme
                })
                .collect::<Result<Vec<LeakExtremum>>>()
        };
        let around = |i: usize| [leaks[i - 1], leaks[i], leaks[i + 1]];
        let minima = each(&least, &|i| self.least(around(i), observer))?;
        let maxima = each(&most, &|i| {
            let mut seen = around(i).to_vec();
            let (best, width) =
                self.narrow([0, 1, 2], &mut seen, ExtremumKind::Most, NEAR, observer)?;
            Ok(extreme(&best, width))
        })?;
        Ok(LeakCurve {
            leaks,
            minima,
            maxima,
        })
    }

    /// The least leak near the middle one of three that were seen.
    fn least(&self, around: [Leak; 3], observer: &dyn Observer) -> Result<LeakExtremum> {
        let mut seen = around.to_vec();
        let (near, _) = self.narrow([0, 1, 2], &mut seen, ExtremumKind::Least, NEAR, observer)?;
        let parts = (-CLOSER..=CLOSER).map(|j| near.ratio * (1.0 + NEAR * f64::from(j)));
        let closer: Result<Vec<Leak>> = parts.map(|ratio| self.leak(ratio, observer)).collect();
        let mut closer = closer?;
        let mut best = near;
        for i in minima(&closer) {
            let around = [i - 1, i, i + 1];
            let (found, _) =
                self.narrow(around, &mut closer, ExtremumKind::Least, FINEST, observer)?;
            if found.per_cell < best.per_cell {
                best = found;
            }
        }
        seen.extend(closer);
        let error = uncertainty(seen, &best, 4.0 * best.per_cell.max(self.rounding()));
        Ok(extreme(&best, error))
    }

    /// Golden sections between the first and the last one of three leaks that were seen, to which
    /// all that were measured are added, to a relative width that is enough; the best one, and the
    /// width that is left.
    fn narrow(
        &self,
        around: [usize; 3],
        seen: &mut Vec<Leak>,
        sense: ExtremumKind,
        enough: f64,
        observer: &dyn Observer,
    ) -> Result<(Leak, f64)> {
        let better = |a: &Leak, b: &Leak| match sense {
            ExtremumKind::Least => a.per_cell < b.per_cell,
            ExtremumKind::Most => a.per_cell > b.per_cell,
        };
        let [mut low, mut best, mut high] = around.map(|i| seen[i]);
        let mut at = |log: f64| {
            let leak = self.leak(log.exp(), observer)?;
            seen.push(leak);
            Ok::<Leak, crate::Error>(leak)
        };
        let logs = [low, high].map(|leak: Leak| leak.ratio.ln());
        let mut search = GoldenSection::new(logs, &mut at)?;
        while high.ratio / low.ratio - 1.0 > enough {
            let [left, right] = search.inner.map(|(_, leak)| leak);
            for found in [left, right] {
                if better(&found, &best) {
                    best = found;
                }
            }
            let flat = |end: &Leak| end.per_cell < 2.0 * best.per_cell;
            let told = best.per_cell < self.rounding() || (flat(&low) && flat(&high));
            if sense == ExtremumKind::Least && told {
                break;
            }
            let left_is_better = better(&left, &right);
            match left_is_better {
                true => high = right,
                false => low = left,
            }
            search.narrow(left_is_better, &mut at)?;
        }
        Ok((best, high.ratio / low.ratio - 1.0))
    }

    /// A leak that is that of rounding, or near it.
    fn rounding(&self) -> f64 {
        2e-13 / self.cells as f64
    }
}

fn extreme(leak: &Leak, error: f64) -> LeakExtremum {
    LeakExtremum {
        ratio: leak.ratio,
        error,
        leak: leak.per_cell,
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ExtremumKind {
    Least,
    Most,
}

fn by_leak(leaks: &[Leak]) -> impl Fn(&usize, &usize) -> std::cmp::Ordering {
    // What cannot be told is no maximum.
    let size = |i: usize| match leaks[i].per_cell {
        x if x.is_nan() => f64::NEG_INFINITY,
        x => x,
    };
    move |a, b| size(*a).total_cmp(&size(*b))
}

/// Relative distance from the best ratio to the nearer ones beyond which every leak seen is larger
/// than `bound`.
fn uncertainty(mut seen: Vec<Leak>, best: &Leak, bound: f64) -> f64 {
    seen.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let small = |leak: &Leak| leak.per_cell.is_nan() || leak.per_cell <= bound;
    let first = seen.iter().position(small).unwrap_or(0);
    let last = seen.iter().rposition(small).unwrap_or(seen.len() - 1);
    let distance = |i: usize| (seen[i].ratio / best.ratio - 1.0).abs();
    distance(first.saturating_sub(1)).max(distance((last + 1).min(seen.len() - 1)))
}

/// Relative distance of ratios that tells the two minima of a high order apart.
const NEAR: f64 = 1e-3;
/// As many of these to each side of a minimum are looked at.
const CLOSER: i32 = 12;
/// Relative width of a bracket that needs no narrowing.
const FINEST: f64 = 1e-8;
