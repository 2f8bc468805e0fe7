//! Refined minima and maxima of the leak of simulated pulses.

use rayon::prelude::*;

use super::leak::{Leak, LeakScan, minima};
use super::vertex::Bracket;
use crate::Result;
use crate::observer::Observer;

/// A local minimum or maximum of the leak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeakExtremum {
    pub ratio: f64,
    /// Relative uncertainty of the ratio, as bracketed by the simulated chains: of a maximum about 1e-3, and
    /// 5e-2 where the pulse loses more than 1 % a cell, so that leaks are ragged.
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
    /// Contact forces computed in all.
    pub forces: u64,
}

impl LeakScan {
    /// The leaks at the given ratios, sorted, and their refined extrema.
    ///
    /// Near a localized wave the leak falls to zero as `|ratio - exact|^q` with q a little above 2,
    /// more steeply on one side than on the other. Its square root, the amplitude of what is left behind,
    /// is close to a line on either side, and the two lines meet at the minimum. The search ends where
    /// the leak is at rounding level, or flat, as on chains too short for the transients of the impact
    /// to fade. High orders have a second, shallower minimum a fraction of a percent below, which can
    /// be mistaken for the first. Unless the leak found is at rounding level and its neighbours far above
    /// it, the minimum is therefore resampled at a closer spacing, and each minimum found there is refined.
    /// The smallest leak is the result. Its error extends to the nearest ratios beyond which every
    /// leak exceeds four times the smallest; two more chains tell these apart.
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
        let each = |indices: &[usize], find: fn(&mut Around) -> Result<LeakExtremum>| {
            let found = indices.par_iter().map(|&i| {
                let mut around = Around {
                    scan: self,
                    observer,
                    leaks: [leaks[i - 1], leaks[i], leaks[i + 1]],
                    seen: Vec::new(),
                };
                let found = find(&mut around)?;
                observer.advance(1);
                let forces = around.seen.iter().map(|leak| leak.forces);
                Ok((found, forces.sum::<u64>()))
            });
            found.collect::<Result<(Vec<LeakExtremum>, Vec<u64>)>>()
        };
        let (minima, for_minima) = each(&least, |around| around.least())?;
        let (maxima, for_maxima) = each(&most, |around| around.most())?;
        let forces = leaks.iter().map(|leak| leak.forces);
        Ok(LeakCurve {
            forces: forces.chain(for_minima).chain(for_maxima).sum(),
            minima,
            maxima,
            leaks,
        })
    }

    /// A leak at the level of rounding.
    fn rounding(&self) -> f64 {
        2e-13 / self.cells as f64
    }
}

/// Three leaks of which the middle one is the least or the largest, and those measured between them.
struct Around<'a> {
    scan: &'a LeakScan,
    observer: &'a dyn Observer,
    leaks: [Leak; 3],
    seen: Vec<Leak>,
}

impl Around<'_> {
    /// The smallest leak near the middle one.
    fn least(&mut self) -> Result<LeakExtremum> {
        let (leaks, rounding) = (self.leaks, self.scan.rounding());
        let mut best = self.descend(leaks)?;
        let beside = leaks[0].per_cell.min(leaks[2].per_cell);
        let is_alone = best.per_cell < rounding && beside > DISTINCT * rounding;
        if !is_alone {
            let closer = (-CLOSER..=CLOSER).map(|j| match j {
                0 => Ok(best),
                j => {
                    let ratio = best.ratio * (1.0 + NEAR * f64::from(j));
                    self.measure(&leaks, ratio, best.per_cell)
                }
            });
            let closer: Vec<Leak> = closer.collect::<Result<_>>()?;
            for i in minima(&closer) {
                let found = self.descend([closer[i - 1], closer[i], closer[i + 1]])?;
                if found.per_cell < best.per_cell {
                    best = found;
                }
            }
        }
        let bound = 4.0 * best.per_cell.max(rounding);
        for side in [-1.0, 1.0] {
            self.look_beside(&best, side, bound)?;
        }
        Ok(LeakExtremum {
            ratio: best.ratio,
            error: self.uncertainty(&best, bound),
            leak: best.per_cell,
        })
    }

    /// Closes in on the smallest leak between the first and the last of three.
    fn descend(&mut self, leaks: [Leak; 3]) -> Result<Leak> {
        let mut bracket = Bracket::new(leaks.map(|leak| point(leak, 1.0)));
        let mut best = leaks[1];
        for _ in 0..MOST_LEAKS {
            let least = bracket.best().1;
            let flat = bracket.ends().iter().all(|end| end.1 < 2.0 * least);
            if least < self.scan.rounding() || flat || bracket.width() <= FINEST {
                break;
            }
            let ratio = bracket.next_of_amplitudes().exp();
            let leak = self.measure(&leaks, ratio, least)?;
            if bracket.narrow(point(leak, 1.0)) {
                best = leak;
            }
        }
        Ok(best)
    }

    /// Measures leaks on one side of the smallest, the first about where four times the bound is reached,
    /// until one exceeds the bound.
    fn look_beside(&mut self, best: &Leak, side: f64, bound: f64) -> Result<()> {
        let leaks = self.leaks;
        let distance = |leak: &Leak| side * (leak.ratio / best.ratio - 1.0);
        let nearest = (self.seen.iter().chain(&leaks))
            .filter(|leak| distance(leak) > 0.0 && leak.per_cell > bound)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let Some(nearest) = nearest else {
            return Ok(());
        };
        let reached = distance(nearest);
        let mut aside = reached * (4.0 * bound / nearest.per_cell).sqrt();
        while aside < 0.5 * reached {
            let ratio = best.ratio * (1.0 + side * aside);
            if self.measure(&leaks, ratio, bound)?.per_cell > bound {
                break;
            }
            aside *= 2.0;
        }
        Ok(())
    }

    /// Relative distance from the best ratio to the nearest ratios beyond which every leak exceeds
    /// `bound`; the larger of both sides.
    fn uncertainty(&self, best: &Leak, bound: f64) -> f64 {
        let mut seen = [&self.seen[..], &self.leaks].concat();
        seen.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
        let small = |leak: &Leak| leak.per_cell.is_nan() || leak.per_cell <= bound;
        let first = seen.iter().position(small).unwrap_or(0);
        let last = seen.iter().rposition(small).unwrap_or(seen.len() - 1);
        let distance = |i: usize| (seen[i].ratio / best.ratio - 1.0).abs();
        distance(first.saturating_sub(1)).max(distance((last + 1).min(seen.len() - 1)))
    }

    /// The largest leak near the middle one.
    ///
    /// Where pulses lose much, waves that catch up make the leak ragged, and there are several humps between
    /// the three: two more leaks choose one.
    fn most(&mut self) -> Result<LeakExtremum> {
        let (leaks, size) = (self.leaks, self.leaks[1].per_cell);
        let [low, high] = [leaks[0], leaks[2]].map(|leak| leak.ratio.ln());
        let mut known = leaks.to_vec();
        for share in HUMPS {
            known.push(self.measure(&leaks, (low + share * (high - low)).exp(), size)?);
        }
        known.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
        let highest = (1..known.len() - 1).max_by(by_leak(&known)).unwrap_or(1);
        let near = [known[highest - 1], known[highest], known[highest + 1]];
        let mut bracket = Bracket::new(near.map(|leak| point(leak, -1.0)));
        let mut best = near[1];
        for _ in 0..MOST_LEAKS {
            if bracket.width() <= NEAR {
                break;
            }
            let ratio = bracket.next_of_parabola(NEAR / 3.0).exp();
            let leak = self.measure(&leaks, ratio, size)?;
            if bracket.narrow(point(leak, -1.0)) {
                best = leak;
            }
        }
        let humped = if best.per_cell > RAGGED { HUMPED } else { 0.0 };
        Ok(LeakExtremum {
            ratio: best.ratio,
            error: self.top_width(&bracket).max(humped),
            leak: best.per_cell,
        })
    }

    /// Relative uncertainty of the ratio of the largest leak: leaks beside it that fall short of it by more than
    /// the curvature between the outer leaks explains are ragged, and so is the top.
    fn top_width(&self, bracket: &Bracket) -> f64 {
        let (top, most) = bracket.best();
        let fall = (bracket.ends().iter()).fold(0.0, |fall: f64, end| fall.max(end.1 - most));
        let outer = [self.leaks[0], self.leaks[2]].map(|leak| point(leak, -1.0));
        let curvature = outer.map(|(at, leak)| (leak - most) / (at - top).powi(2));
        let width = 2.0 * (fall / curvature[0].min(curvature[1])).sqrt();
        let farthest = (outer[1].0 - top).max(top - outer[0].0);
        // Also where it is not a number.
        let ragged = if width < farthest { width } else { farthest };
        bracket.width().max(ragged)
    }

    /// A leak of about this size at a ratio near those of three leaks, through whose times of arrival a
    /// parabola gives that of this one.
    fn measure(&mut self, leaks: &[Leak; 3], ratio: f64, size: f64) -> Result<Leak> {
        let at = leaks.map(|leak| leak.ratio.ln());
        let x = ratio.ln();
        let arrival = (0..3).map(|i| {
            let others = (0..3).filter(|&j| j != i);
            let weight: f64 = others.map(|j| (x - at[j]) / (at[i] - at[j])).product();
            weight * leaks[i].arrival
        });
        let leak = (self.scan).leak(ratio, size, Some(arrival.sum()), self.observer)?;
        self.seen.push(leak);
        Ok(leak)
    }
}

/// Logarithm of the ratio, and the leak times a sign; one that could not be measured is the worst.
fn point(leak: Leak, sign: f64) -> (f64, f64) {
    let measured = Some(sign * leak.per_cell).filter(|leak| !leak.is_nan());
    (leak.ratio.ln(), measured.unwrap_or(f64::INFINITY))
}

fn by_leak(leaks: &[Leak]) -> impl Fn(&usize, &usize) -> std::cmp::Ordering {
    // A leak that is NaN is never the maximum.
    let size = |i: usize| leaks[i].per_cell.max(f64::NEG_INFINITY);
    move |a, b| size(*a).total_cmp(&size(*b))
}

/// Relative spacing of ratios that resolves the two minima of a high order.
const NEAR: f64 = 1e-3;
/// Ratios at that spacing on either side of a minimum.
const CLOSER: i32 = 12;
/// Relative width of a bracket at which the search ends.
const FINEST: f64 = 1e-8;
/// Leaks beside a minimum above this many times rounding tell the two minima of a high order apart: the
/// shallower leak is then far above rounding.
const DISTINCT: f64 = 1e6;
/// Leak a cell above which the pulse is overtaken by the waves that it sheds, and the relative range over which
/// humps of the leak then differ by less than their order changes with the length of the chain.
const RAGGED: f64 = 1e-2;
const HUMPED: f64 = 5e-2;
/// Where a bracket is looked at first for its highest hump: golden sections.
const HUMPS: [f64; 2] = [0.381_966, 0.618_034];
/// Most leaks measured in a bracket.
const MOST_LEAKS: usize = 50;
