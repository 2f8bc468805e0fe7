//! Refined minima and maxima of the leak of simulated pulses.

use rayon::prelude::*;

use super::leak::{Leak, LeakScan, minima};
use crate::Result;
use crate::numeric::GoldenSection;
use crate::observer::Observer;

/// A local minimum or maximum of the leak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeakExtremum {
    pub ratio: f64,
    /// Relative uncertainty of the ratio, as bracketed by the simulated chains.
    pub error: f64,
    /// Leak per cell at that ratio.
    pub leak: f64,
}

/// The leaks of a scan with their extrema.
#[derive(Debug, Clone, PartialEq)]
pub struct LeakCurve {
    pub leaks: Vec<Leak>,
    /// In ascending order of the ratio.
    pub minima: Vec<LeakExtremum>,
    /// The largest leak between each minimum and the next.
    pub maxima: Vec<LeakExtremum>,
}

impl LeakScan {
    /// The leaks at the given ratios, sorted, and their refined extrema.
    ///
    /// Near a localized wave the leak falls to zero as `|ratio - exact|^q` with q a little above 2,
    /// more steeply on one side than on the other. The vertex of a parabola through three leaks is
    /// therefore off by a tenth of their spacing. High orders have a second, shallower minimum a
    /// fraction of a percent below, which can be mistaken for the first. Each minimum is therefore
    /// resampled at a closer spacing. Each minimum found there is refined by golden-section search,
    /// which needs only a leak that falls and then rises. The search ends early where the leak is
    /// at rounding level, or flat, as on chains too short for the transients of the impact to fade.
    /// The smallest leak is the result. Its error extends to the nearest ratios beyond which every
    /// leak exceeds four times the smallest.
    ///
    /// # Errors
    /// As [`LeakScan::run`].
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

    /// The smallest leak near the middle one of three leaks.
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

    /// Golden-section search between the first and the last of three leaks in `seen`, to the
    /// relative width `enough`. Appends every measured leak to `seen`. Returns the best leak and
    /// the remaining relative width.
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

    /// A leak at the level of rounding.
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
    // A leak that is NaN is never the maximum.
    let size = |i: usize| match leaks[i].per_cell {
        x if x.is_nan() => f64::NEG_INFINITY,
        x => x,
    };
    move |a, b| size(*a).total_cmp(&size(*b))
}

/// Relative distance from the best ratio to the nearest ratios beyond which every leak exceeds
/// `bound`; the larger of both sides.
fn uncertainty(mut seen: Vec<Leak>, best: &Leak, bound: f64) -> f64 {
    seen.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
    let small = |leak: &Leak| leak.per_cell.is_nan() || leak.per_cell <= bound;
    let first = seen.iter().position(small).unwrap_or(0);
    let last = seen.iter().rposition(small).unwrap_or(seen.len() - 1);
    let distance = |i: usize| (seen[i].ratio / best.ratio - 1.0).abs();
    distance(first.saturating_sub(1)).max(distance((last + 1).min(seen.len() - 1)))
}

/// Relative spacing of ratios that resolves the two minima of a high order.
const NEAR: f64 = 1e-3;
/// Ratios at that spacing on either side of a minimum.
const CLOSER: i32 = 12;
/// Relative width of a bracket at which the search ends.
const FINEST: f64 = 1e-8;
