//! Sites at which a wave arrives, which way it goes, and what comes back.

use super::LeftOut;
use super::along_x::{Options, median};
use super::onset::{Onset, REACHED};
use super::share::Spectrum;
use super::windows::Windows;

/// Correlation of arrivals with x from which on they are those of one wave.
const ONE_WAY: f64 = 0.9;
/// Steadiness of records above which they have no front, and below which they are no steady motion either.
const STEADY: f64 = 0.5;
const TRANSIENT: f64 = 0.35;
/// Widths of the pulse by which an arrival is later than that of what comes back.
const LATER: f64 = 3.0;
/// Widths of the pulse within which arrivals are at once.
const AT_ONCE: f64 = 2.0;
/// One of so many sites may have moved before its window could begin.
const EARLY: usize = 10;
/// Root mean square of records, over their quiet parts, below which these are none where the motion lasts.
const LASTS: f64 = 0.25;
const ABOVE: f64 = 5.0;
/// Part of the sites, and sites at least, on each side of the place where waves from two ends meet.
const SIDE: usize = 5;
const SIDE_SITES: usize = 4;

pub(super) struct Fronts<'a> {
    pub options: &'a Options,
    /// Correlation of the noise of neighbours.
    pub common: f64,
    pub onsets: Vec<Onset>,
    pub live: Vec<bool>,
    pub n_times: usize,
    pub every: usize,
    /// Of the pulse, in samples.
    pub width: f64,
    /// Samples before its arrival at which a window begins.
    pub lead: usize,
    pub left_out: LeftOut,
}

/// Spectra of a site in each kind of window; `None` where one does not fit.
pub(super) struct Seen {
    pub site: usize,
    pub second: Option<usize>,
    pub spectra: Vec<Option<Spectrum>>,
}

impl Fronts<'_> {
    pub fn arrival(&self, site: usize) -> usize {
        self.onsets[site].arrival.unwrap_or(0)
    }

    /// Where windows begin.
    pub fn start(&self, site: usize) -> usize {
        self.arrival(site).saturating_sub(self.lead)
    }

    /// At the arrival; in measured records a width before it, since noise hides how a wave rises, or as long as nearly all
    /// records have run before theirs.
    fn lead(&self, sites: &[usize]) -> usize {
        if self.options.is_simulated() || sites.is_empty() {
            return 0;
        }
        let mut before: Vec<usize> = sites.iter().map(|&j| self.arrival(j)).collect();
        before.sort_unstable();
        before[before.len() / EARLY].min(self.width.round() as usize)
    }

    /// Sites at which a wave arrives while the record runs, behind the struck body; finds the width of the pulse.
    pub fn eligible(&mut self) -> Vec<usize> {
        let behind = self.options.struck.map_or(0, |site| site + 1);
        let n_sites = self.onsets.len();
        let mut left = LeftOut {
            sites: n_sites,
            ..LeftOut::default()
        };
        let mut sites = Vec::new();
        for site in 0..n_sites {
            match self.onsets[site].arrival {
                _ if !self.live[site] => left.not_reached += 1,
                None => left.not_reached += 1,
                Some(0..=2) => left.entered_late += 1,
                Some(_) if site < behind => {}
                Some(_) => sites.push(site),
            }
        }
        self.left_out = left;
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
        let alive = self.live.iter().filter(|l| **l).count();
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
        let live = self.onsets.iter().zip(&self.live).filter(|(_, l)| **l);
        let mut steadiness: Vec<f64> = live.map(|(onset, _)| onset.steadiness).collect();
        median(&mut steadiness) < TRANSIENT
    }

    /// Whether noise that is known hides when the motion comes.
    pub fn are_faint(&self) -> bool {
        let live = self.onsets.iter().zip(&self.live).filter(|(_, l)| **l);
        let known = live.filter_map(|(onset, _)| Some(onset.peak / onset.noise?));
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
            (true, Some(at_end)) if self.live[far] => {
                let back = |&j: &usize| (2 * at_end).saturating_sub(self.arrival(j)).min(n);
                sites.iter().map(back).collect()
            }
            _ => vec![n; sites.len()],
        }
    }

    /// Windows into which what comes back falls: a second arrival that travels the other way than the first. Where both fall
    /// together, beside such windows, none can be told apart. Returns whether something is seen to come back.
    pub fn drop_reflected(&self, seen: &mut [Option<Seen>], kinds: &[Windows]) -> bool {
        let sites: Vec<usize> = (0..seen.len()).filter(|&j| seen[j].is_some()).collect();
        let seconds: Vec<Option<usize>> = seen.iter().map(|s| s.as_ref()?.second).collect();
        let second = |j: usize| seconds[j];
        let sum = |j: usize| Some(seconds[j]? as f64 + self.arrival(j) as f64);
        let is_back = |pair: &[usize]| {
            let [a, b] = [pair[0], pair[1]];
            let later = second(b)? as f64 - second(a)? as f64;
            let first = self.arrival(b) as f64 - self.arrival(a) as f64;
            (later * first != 0.0).then_some((later * first < 0.0).then(|| sum(a)).flatten())
        };
        let pairs: Vec<Option<f64>> = sites.windows(2).filter_map(is_back).collect();
        // The two arrivals of what comes back add up to the same everywhere. Where the second merges with the first, the next
        // arrival is that of a later passage: then fewer than half of the sites see it.
        let mut sums: Vec<f64> = pairs.iter().copied().flatten().collect();
        let near = LATER * self.width;
        let common = median(&mut sums);
        let same = sums
            .iter()
            .filter(|sum| (**sum - common).abs() < near)
            .count();
        let is_seen =
            2 * sums.len() > pairs.len() || (3 * same > pairs.len() && 4 * same > 3 * sums.len());
        if pairs.len() < 3 || !is_seen {
            return false;
        }
        let back = |j: usize| {
            let back = common - self.arrival(j) as f64;
            (back > self.arrival(j) as f64 - near).then_some(back.max(0.0) as usize)
        };
        let second = |j: usize| match (second(j), back(j)) {
            (Some(second), Some(back)) if second as f64 > back as f64 + near => Some(back),
            (second, _) => second,
        };
        for (k, kind) in kinds.iter().enumerate() {
            let mut state: Vec<Option<bool>> = sites
                .iter()
                .map(|&j| second(j).map(|second| second < self.start(j) + kind.end()))
                .collect();
            // Between two such sites, or from one to the end of the array, a missing second arrival is one that merges.
            let mut i = 0;
            while i < state.len() {
                if state[i].is_some() {
                    i += 1;
                    continue;
                }
                let end = (i..state.len())
                    .find(|&n| state[n].is_some())
                    .unwrap_or(state.len());
                let before = i.checked_sub(1).and_then(|n| state[n]);
                let after = state.get(end).copied().flatten();
                let merges = match (before, after) {
                    (Some(a), Some(b)) => a && b,
                    (Some(a), None) => a,
                    (None, Some(b)) => b,
                    (None, None) => false,
                };
                state[i..end].fill(Some(merges));
                i = end;
            }
            for (&j, reflected) in sites.iter().zip(&state) {
                if let (Some(true), Some(one)) = (reflected, seen[j].as_mut()) {
                    one.spectra[k] = None;
                }
            }
        }
        true
    }
}
