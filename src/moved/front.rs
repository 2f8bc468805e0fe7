//! Sites at which a wave arrives, which way it goes, and what comes back.

use super::along_x::{Options, median};
use super::onset::Onset;
use super::share::Spectrum;
use super::windows::Windows;
use super::{LeftOut, Speed};

/// Correlation of arrivals with x from which on they are those of one wave.
const ONE_WAY: f64 = 0.9;
/// Steadiness of records above which they have no front.
const STEADY: f64 = 0.5;

pub(super) struct Fronts<'a> {
    pub options: &'a Options,
    pub onsets: Vec<Onset>,
    pub live: Vec<bool>,
    pub n_times: usize,
    pub every: usize,
    /// Of the pulse, in samples.
    pub width: f64,
    pub left_out: LeftOut,
}

/// Spectra of a site in each kind of window; `None` where one does not fit.
pub(super) struct Seen {
    pub site: usize,
    /// When the front is there, in samples: the centroid of the energy in its window, of a run the arrival.
    pub centre: f64,
    pub second: Option<usize>,
    pub spectra: Vec<Option<Spectrum>>,
}

impl Fronts<'_> {
    pub fn arrival(&self, site: usize) -> usize {
        self.onsets[site].arrival.unwrap_or(0)
    }

    /// Where windows begin: at the arrival, in measured records a width before it, since noise hides how a wave rises.
    pub fn start(&self, site: usize) -> usize {
        let lead = match self.options.is_simulated() {
            true => 0,
            false => self.width.round() as usize,
        };
        self.arrival(site).saturating_sub(lead)
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
        4 * sites.len() >= alive
            && median(&mut steadiness) < STEADY
            && median(&mut leads) >= self.width.min(0.1 * self.n_times as f64)
    }

    /// +1 where arrivals rise with x, -1 where they fall, 0 for both: waves of several origins.
    pub fn sense(&self, sites: &[usize]) -> f64 {
        let n = sites.len() as f64;
        let points = sites.iter().map(|&j| (j as f64, self.arrival(j) as f64));
        let (sx, st) = points
            .clone()
            .fold((0.0, 0.0), |(a, b), (x, t)| (a + x, b + t));
        let moments = points.map(|(x, t)| (x - sx / n, t - st / n));
        let [xx, tt, xt] = moments.fold([0.0; 3], |[xx, tt, xt], (x, t)| {
            [xx + x * x, tt + t * t, xt + x * t]
        });
        match xt / (xx * tt).sqrt() {
            correlation if correlation.abs() >= ONE_WAY => correlation.signum(),
            _ => 0.0,
        }
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
    /// together, beside such windows, none can be told apart.
    pub fn drop_reflected(&self, seen: &mut [Option<Seen>], kinds: &[Windows]) {
        let sites: Vec<usize> = (0..seen.len()).filter(|&j| seen[j].is_some()).collect();
        let seconds: Vec<Option<usize>> = seen.iter().map(|s| s.as_ref()?.second).collect();
        let second = |j: usize| seconds[j];
        let pairs = sites.windows(2).filter_map(|pair| {
            let [a, b] = [pair[0], pair[1]];
            let later = second(b)? as f64 - second(a)? as f64;
            let first = self.arrival(b) as f64 - self.arrival(a) as f64;
            (later * first != 0.0).then_some(later * first < 0.0)
        });
        let pairs: Vec<bool> = pairs.collect();
        let opposite = pairs.iter().filter(|back| **back).count();
        if pairs.len() < 3 || 2 * opposite <= pairs.len() {
            return;
        }
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
    }

    /// The slope of the energy's centroid in front windows over x by least squares, with its 95 % interval. What is left follows
    /// its neighbours: it counts by its correlation from site to site.
    pub fn speed(&self, points: &[(f64, f64)], sense: f64) -> Option<Speed> {
        if sense == 0.0 || points.len() < 4 {
            return None;
        }
        let n = points.len() as f64;
        let (sx, st) = points
            .iter()
            .fold((0.0, 0.0), |(a, b), (x, t)| (a + x, b + t));
        let (mx, mt) = (sx / n, st / n);
        let (xx, xt) = points.iter().fold((0.0, 0.0), |(a, b), (x, t)| {
            (a + (x - mx).powi(2), b + (x - mx) * (t - mt))
        });
        let slowness = xt / xx;
        let left: Vec<f64> = points
            .iter()
            .map(|(x, t)| t - mt - slowness * (x - mx))
            .collect();
        let squares: f64 = left.iter().map(|r| r * r).sum();
        let products: f64 = left.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let follows = match squares > 0.0 {
            true => (products / squares).clamp(0.0, 0.95),
            false => 0.0,
        };
        let error = (squares / (n - 2.0) / xx * (1.0 + follows) / (1.0 - follows)).sqrt();
        let bound = crate::numeric::student_two_sided(0.05, n - 2.0) * error;
        // A tenth of a sample over the array is not told.
        let bound = bound.max(0.1 / xx.sqrt() / n.sqrt());
        if slowness.abs() <= 2.0 * bound || !slowness.is_finite() {
            return None;
        }
        let scale = self.options.dx / self.options.dt;
        Some(Speed {
            value: scale / slowness,
            error: scale * bound / (slowness * slowness),
        })
    }
}
