//! Sites at which a wave arrives, which way it goes, and what comes back.

use super::along_x::{Options, median};
use super::onset::Onset;
use crate::numeric::LineFit;

/// Correlation of arrivals with x from which on they are those of one wave.
const ONE_WAY: f64 = 0.9;
/// Steadiness of records above which they have no front, and below which they are no steady motion either.
const STEADY: f64 = 0.5;
const TRANSIENT: f64 = 0.35;
/// Widths of the pulse within which arrivals are at once, those before an arrival at which a window begins, and those by which what
/// comes back differs from site to site.
const AT_ONCE: f64 = 2.0;
const LEAD: f64 = 2.0;
const OFF: f64 = 3.0;
/// One of so many sites may have moved before its window could begin.
const EARLY: usize = 10;
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

    pub fn live(&self) -> impl Iterator<Item = &Onset> {
        self.onsets.iter().filter(|onset| onset.is_live)
    }

    fn median_of(&self, sites: &[usize], of: impl Fn(&Onset) -> f64) -> f64 {
        median(sites.iter().map(|&j| of(&self.onsets[j])))
    }

    /// Where windows begin.
    pub fn start(&self, site: usize) -> usize {
        self.arrival(site).saturating_sub(self.lead)
    }

    /// Sites at which a wave arrives while the record runs, behind the struck body; finds the width of the pulse, and where windows
    /// begin: at the arrival; in measured records two widths before it, since noise hides how a wave rises, or as long as nearly
    /// all records have run before theirs.
    pub fn eligible(&mut self) -> Vec<usize> {
        let behind = self.options.struck.map_or(0, |site| site + 1);
        let arrives =
            |&site: &usize| self.onsets[site].is_live && self.onsets[site].arrival > Some(2);
        let sites: Vec<usize> = (behind..self.onsets.len()).filter(arrives).collect();
        let width = median(sites.iter().filter_map(|&j| self.onsets[j].width));
        let others = median(self.onsets.iter().filter_map(|o| o.width));
        self.width = if width.is_nan() { others } else { width }.max(1.0);
        let mut before: Vec<usize> = sites.iter().map(|&j| self.arrival(j)).collect();
        before.sort_unstable();
        if !self.options.is_simulated() && !before.is_empty() {
            let most = (LEAD * self.width).round() as usize;
            self.lead = before[before.len() / EARLY].min(most);
        }
        sites
    }

    /// Whether waves arrive: at enough sites, behind a quiet lead, and records are not steady.
    pub fn arrive(&self, sites: &[usize]) -> bool {
        let are_many = sites.len() >= 2 && 4 * sites.len() >= self.live().count();
        if !are_many || self.options.is_simulated() {
            return are_many;
        }
        let steady = self.median_of(sites, |onset| onset.steadiness);
        let lead = self.median_of(sites, |onset| onset.arrival.unwrap_or(0) as f64);
        steady < STEADY
            && !self.is_irregular(sites)
            && lead >= self.width.min(0.1 * self.n_times as f64)
    }

    /// Whether motion comes and goes, though no arrival says when it came: its records are no realisations of steady motion.
    pub fn are_transient(&self) -> bool {
        median(self.live().map(|onset| onset.steadiness)) < TRANSIENT
    }

    /// Whether all of the motion is in the records, quiet at both ends: then the sites where it is.
    pub fn pass(&self) -> Option<Vec<usize>> {
        let passes = |&site: &usize| {
            let levels = self.onsets[site].levels.iter();
            let levels: Vec<f64> = levels.map(|level| f64::from(*level).exp()).collect();
            let largest = levels.iter().fold(0.0, |m, level| level.max(m));
            self.onsets[site].is_live && levels[0].max(levels[levels.len() - 1]) < STILL * largest
        };
        let sites: Vec<usize> = (0..self.onsets.len()).filter(passes).collect();
        (PASSED * sites.len() > self.live().count()).then_some(sites)
    }

    /// Pearson's, of arrivals with x.
    fn correlation(&self, sites: &[usize]) -> f64 {
        let points = sites.iter().map(|&j| (j as f64, self.arrival(j) as f64));
        let points: Vec<(f64, f64)> = points.collect();
        match LineFit::through(&points) {
            Some(of) => {
                of.slope
                    / of.slope
                        .hypot(of.slope_error * (of.points as f64 - 2.0).sqrt())
            }
            None => (points[points.len() - 1].1 - points[0].1).signum(),
        }
    }

    /// +1 where arrivals rise with x, -1 where they fall, 0 for both.
    pub fn sense(&self, sites: &[usize]) -> f64 {
        match self.correlation(sites) {
            correlation if correlation.abs() >= ONE_WAY && !self.is_whole => correlation.signum(),
            _ => 0.0,
        }
    }

    /// Whether arrivals are those of no wave: neither along the array, nor from two origins, nor at once.
    fn is_irregular(&self, sites: &[usize]) -> bool {
        let arrival = |onset: &Onset| onset.arrival.unwrap_or(0) as f64;
        let middle = self.median_of(sites, arrival);
        self.sense(sites) == 0.0
            && self.origins(sites).is_none()
            && self.median_of(sites, |onset| (arrival(onset) - middle).abs()) > AT_ONCE * self.width
    }

    /// Where waves of two origins meet: arrivals rise along the array up to this site, and fall from it on, or the other way round.
    pub fn origins(&self, sites: &[usize]) -> Option<usize> {
        let side = (sites.len() / SIDE).max(SIDE_SITES);
        let places = side..(sites.len() + 1).saturating_sub(side);
        let apart = places.filter_map(|at| {
            let [a, b] = [&sites[..at], &sites[at..]].map(|part| self.correlation(part));
            (a * b < 0.0).then_some((sites[at], a.abs().min(b.abs())))
        });
        let best = apart.max_by(|(_, a), (_, b)| a.total_cmp(b));
        best.filter(|(_, least)| *least >= ONE_WAY)
            .map(|(site, _)| site)
    }

    /// What the arrival of a front and that of its reflection from the far end of a run add up to.
    pub fn reflected(&self, sense: f64) -> Option<f64> {
        let far = [0, self.onsets.len() - 1][usize::from(sense > 0.0)];
        let is_seen = self.options.is_simulated() && self.onsets[far].is_live && sense != 0.0;
        let at_end = self.onsets[far].arrival.filter(|_| is_seen)?;
        Some(2.0 * at_end as f64)
    }

    /// The same of what is seen to come back at sites whose second arrivals are `seconds`: sums differ less from site to site than
    /// differences do, those of what follows.
    pub fn back(&self, sites: &[usize], seconds: &[Option<usize>]) -> Option<f64> {
        let both = sites.iter().zip(seconds);
        let both =
            both.filter_map(|(&j, second)| Some((self.arrival(j) as f64, (*second)? as f64)));
        let usual = |sign: f64| {
            let values = both
                .clone()
                .map(move |(first, second)| second + sign * first);
            let middle = median(values.clone());
            let far = |off: &f64| *off < OFF * self.width;
            let off = values.map(move |value| (value - middle).abs());
            (middle, off.clone().filter(far).count(), median(off))
        };
        let ((sum, same, off), (_, _, following)) = (usual(1.0), usual(-1.0));
        (3 * same > sites.len() && off < following).then_some(sum)
    }

    /// When what comes back is at a site; the end of the record where nothing does.
    pub fn end(&self, site: usize, sum: Option<f64>) -> usize {
        let back = |sum: f64| (sum - self.arrival(site) as f64).max(0.0) as usize;
        sum.map_or(self.n_times, |sum| back(sum).min(self.n_times))
    }
}
