//! Sites at which a wave arrives, which way it goes, and what comes back.

use super::along_x::{Options, median};
use super::onset::{Onset, REACHED};

/// Correlation of arrivals with x from which on they are those of one wave.
const ONE_WAY: f64 = 0.9;
/// Steadiness of records above which they have no front, and below which they are no steady motion either.
const STEADY: f64 = 0.5;
const TRANSIENT: f64 = 0.35;
/// Widths of the pulse by which an arrival is later than that of what comes back.
const LATER: f64 = 3.0;
/// Widths of the pulse within which arrivals are at once, and those before an arrival at which a window begins.
const AT_ONCE: f64 = 2.0;
const LEAD: f64 = 2.0;
/// One of so many sites may have moved before its window could begin.
const EARLY: usize = 10;
/// Root mean square of records, over their quiet parts, below which these are none where the motion lasts.
const LASTS: f64 = 0.25;
const ABOVE: f64 = 5.0;
/// Part of the sites, and sites at least, on each side of the place where waves from two ends meet.
const SIDE: usize = 5;
const SIDE_SITES: usize = 4;
/// Energy of the first and the last pieces of a record over that of its largest, below which all of the motion is in it; and
/// one of so many sites that are such.
const STILL: f64 = 0.02;
const PASSED: usize = 3;

pub(super) struct Fronts<'a> {
    pub options: &'a Options,
    pub onsets: Vec<Onset>,
    pub n_times: usize,
    pub every: usize,
    /// Of the pulse, in samples.
    pub width: f64,
    /// Samples before its arrival at which a window begins.
    pub lead: usize,
    /// Whether the window is the record.
    pub is_whole: bool,
}

impl Fronts<'_> {
    pub fn arrival(&self, site: usize) -> usize {
        self.onsets[site].arrival.unwrap_or(0)
    }

    fn live(&self) -> impl Iterator<Item = &Onset> {
        self.onsets.iter().filter(|onset| onset.is_live)
    }

    /// Where windows begin.
    pub fn start(&self, site: usize) -> usize {
        match self.is_whole {
            true => 0,
            false => self.arrival(site).saturating_sub(self.lead),
        }
    }

    /// At the arrival; in measured records two widths before it, since noise hides how a wave rises, or as long as nearly all
    /// records have run before theirs.
    fn lead(&self, sites: &[usize]) -> usize {
        if self.options.is_simulated() || sites.is_empty() {
            return 0;
        }
        let mut before: Vec<usize> = sites.iter().map(|&j| self.arrival(j)).collect();
        before.sort_unstable();
        before[before.len() / EARLY].min((LEAD * self.width).round() as usize)
    }

    /// Sites at which a wave arrives while the record runs, behind the struck body; finds the width of the pulse.
    pub fn eligible(&mut self) -> Vec<usize> {
        let behind = self.options.struck.map_or(0, |site| site + 1);
        let arrives = |&site: &usize| {
            self.onsets[site].is_live
                && self.onsets[site].arrival.is_some_and(|arrival| arrival > 2)
        };
        let mut sites: Vec<usize> = (behind..self.onsets.len()).filter(arrives).collect();
        let widths = sites.iter().filter_map(|&j| self.onsets[j].width);
        let mut widths: Vec<f64> = widths.collect();
        if widths.is_empty() {
            let others = self.onsets.iter().step_by(self.every);
            widths = others.filter_map(|o| o.width).collect();
        }
        self.width = median(&mut widths).max(1.0);
        // A glitch ahead of the wave is no arrival: those far from their neighbours' are left out.
        let near = 3.0 * self.width;
        let arrivals: Vec<f64> = sites.iter().map(|&j| self.arrival(j) as f64).collect();
        let is_regular = |i: usize| {
            let around = i.saturating_sub(2)..(i + 3).min(arrivals.len());
            let mut beside = arrivals[around].to_vec();
            (arrivals[i] - median(&mut beside)).abs() <= near
        };
        let regular: Vec<bool> = (0..sites.len()).map(is_regular).collect();
        // Waves from both ends cross in a jump; an array of jumps is as it is.
        if 4 * regular.iter().filter(|r| !**r).count() < sites.len() {
            let mut keep = regular.into_iter();
            sites.retain(|_| keep.next() == Some(true));
        }
        self.lead = self.lead(&sites);
        sites
    }

    /// Whether waves arrive: at enough sites, behind a quiet lead, and records are not steady.
    pub fn arrive(&self, sites: &[usize]) -> bool {
        let alive = self.live().count();
        if sites.len() < 2 || (self.options.is_simulated() && 4 * sites.len() < alive) {
            return false;
        }
        if self.options.is_simulated() {
            return true;
        }
        let mut steadiness: Vec<f64> = sites.iter().map(|&j| self.onsets[j].steadiness).collect();
        let mut leads: Vec<f64> = sites.iter().map(|&j| self.arrival(j) as f64).collect();
        let steady = median(&mut steadiness);
        // What is louder by a few times from some time on has not arrived then.
        let above = |&j: &usize| {
            let onset = &self.onsets[j];
            onset.sizes[0].exp() / onset.noise.unwrap_or(0.0)
        };
        let mut above: Vec<f64> = sites.iter().map(above).collect();
        let goes_on = steady > LASTS && median(&mut above) < ABOVE;
        4 * sites.len() >= alive
            && steady < STEADY
            && !goes_on
            && !self.is_irregular(sites)
            && median(&mut leads) >= self.width.min(0.1 * self.n_times as f64)
    }

    /// Whether motion comes and goes, though no arrival says when it came: its records are no realisations of steady motion.
    pub fn are_transient(&self) -> bool {
        let mut steadiness: Vec<f64> = self.live().map(|onset| onset.steadiness).collect();
        median(&mut steadiness) < TRANSIENT
    }

    /// Whether all of the motion is in the records, quiet at both ends: then the sites where it is.
    pub fn pass(&self) -> Option<Vec<usize>> {
        let passes = |&site: &usize| {
            let level = |i: usize| f64::from(self.onsets[site].levels[i]).exp();
            let all = self.onsets[site].levels.len();
            let largest = (0..all).map(level).fold(0.0, f64::max);
            self.onsets[site].is_live && level(0).max(level(all - 1)) < STILL * largest
        };
        let sites: Vec<usize> = (0..self.onsets.len()).filter(passes).collect();
        let alive = self.live().count();
        (PASSED * sites.len() > alive).then_some(sites)
    }

    /// Whether noise that is known hides when the motion comes.
    pub fn are_faint(&self) -> bool {
        let known = self
            .live()
            .filter_map(|onset| Some(onset.peak / onset.noise?));
        let mut above: Vec<f64> = known.collect();
        median(&mut above) <= REACHED
    }

    fn correlation(&self, sites: &[usize]) -> f64 {
        let n = sites.len() as f64;
        let points = sites.iter().map(|&j| (j as f64, self.arrival(j) as f64));
        let (sx, st) = points
            .clone()
            .fold((0.0, 0.0), |(a, b), (x, t)| (a + x, b + t));
        let moments = points.map(|(x, t)| (x - sx / n, t - st / n));
        let [xx, tt, xt] = moments.fold([0.0; 3], |[xx, tt, xt], (x, t)| {
            [xx + x * x, tt + t * t, xt + x * t]
        });
        xt / (xx * tt).sqrt()
    }

    /// +1 where arrivals rise with x, -1 where they fall, 0 for both.
    pub fn sense(&self, sites: &[usize]) -> f64 {
        match self.correlation(sites) {
            correlation if correlation.abs() >= ONE_WAY => correlation.signum(),
            _ => 0.0,
        }
    }

    /// Whether arrivals are those of no wave: neither along the array, nor from two origins, nor at once.
    fn is_irregular(&self, sites: &[usize]) -> bool {
        let mut arrivals: Vec<f64> = sites.iter().map(|&j| self.arrival(j) as f64).collect();
        let middle = median(&mut arrivals);
        let mut off: Vec<f64> = arrivals.iter().map(|a| (a - middle).abs()).collect();
        self.sense(sites) == 0.0
            && self.origins(sites).is_none()
            && median(&mut off) > AT_ONCE * self.width
    }

    /// Where waves of two origins meet: arrivals rise along the array up to this site, and fall from it on, or the other way round.
    pub fn origins(&self, sites: &[usize]) -> Option<usize> {
        let side = (sites.len() / SIDE).max(SIDE_SITES);
        let places = side..(sites.len() + 1).saturating_sub(side);
        let apart = |at: &usize| {
            let [a, b] = [&sites[..*at], &sites[*at..]].map(|part| self.correlation(part));
            (a * b < 0.0).then_some(a.abs().min(b.abs()))
        };
        let apart = places.filter_map(|at| Some((at, apart(&at)?)));
        let best = apart.max_by(|(_, a), (_, b)| a.total_cmp(b));
        best.filter(|(_, least)| *least >= ONE_WAY)
            .map(|(at, _)| sites[at])
    }

    /// The last sample before a reflection from the far end of a run is back at each site.
    pub fn ends(&self, sites: &[usize], sense: f64) -> Vec<usize> {
        let n = self.n_times;
        let far = match sense {
            s if s > 0.0 => self.onsets.len() - 1,
            s if s < 0.0 => 0,
            _ => return vec![n; sites.len()],
        };
        match (self.options.is_simulated(), self.onsets[far].arrival) {
            (true, Some(at_end)) if self.onsets[far].is_live => {
                let back = |&j: &usize| (2 * at_end).saturating_sub(self.arrival(j)).min(n);
                sites.iter().map(back).collect()
            }
            _ => vec![n; sites.len()],
        }
    }

    /// The sample at which what comes back falls into the records of these sites, whose second arrivals are `seconds`: it travels the
    /// other way than the first. Where both fall together, beside such sites, none can be told apart. `None` where nothing is seen
    /// to come back.
    pub fn back(&self, sites: &[usize], seconds: &[Option<usize>]) -> Option<Vec<Option<usize>>> {
        let sum = |i: usize| Some(seconds[i]? as f64 + self.arrival(sites[i]) as f64);
        let is_back = |i: usize| {
            let later = seconds[i + 1]? as f64 - seconds[i]? as f64;
            let first = self.arrival(sites[i + 1]) as f64 - self.arrival(sites[i]) as f64;
            (later * first != 0.0).then_some((later * first < 0.0).then(|| sum(i)).flatten())
        };
        let pairs = 0..sites.len().saturating_sub(1);
        let pairs: Vec<Option<f64>> = pairs.filter_map(is_back).collect();
        // The two arrivals of what comes back add up to the same everywhere. Where the second merges with the first, the next
        // arrival is that of a later passage: then fewer than half of the sites see it.
        let mut sums: Vec<f64> = pairs.iter().copied().flatten().collect();
        let near = LATER * self.width;
        let common = median(&mut sums);
        let same = sums.iter().filter(|sum| (**sum - common).abs() < near);
        let same = same.count();
        let is_seen =
            2 * sums.len() > pairs.len() || (3 * same > pairs.len() && 4 * same > 3 * sums.len());
        if pairs.len() < 3 || !is_seen {
            return None;
        }
        let back = |i: usize| {
            let arrival = self.arrival(sites[i]) as f64;
            let back = common - arrival;
            let merged = (back > arrival - near).then_some(back.max(0.0) as usize);
            match (seconds[i], merged) {
                (Some(second), Some(back)) if second as f64 > back as f64 + near => Some(back),
                (second, _) => second,
            }
        };
        let mut found: Vec<Option<usize>> = (0..sites.len()).map(back).collect();
        // Between two such sites, or from one to the end of the array, a missing second arrival is one that merges.
        let mut i = 0;
        while i < found.len() {
            let end = (i..found.len()).find(|&n| found[n].is_some());
            let end = end.unwrap_or(found.len());
            if end > i {
                let beside = [i.checked_sub(1), Some(end)];
                let beside = beside.map(|n| n.and_then(|n| found.get(n).copied().flatten()));
                let merges = match beside {
                    [Some(a), Some(b)] => Some(a.max(b)),
                    [a, b] => a.or(b),
                };
                found[i..end].fill(merges);
            }
            i = end + 1;
        }
        Some(found)
    }
}
