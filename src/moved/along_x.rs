//! What moved in frequency along x.

use super::onset::{Envelopes, NoiseShape, Onset, Reading};
use super::share::{Group, Moved, Spectrum};
use super::steady;
use super::windows::{Weights, Windows};
use super::{Evidence, LeftOut, Movement, Part, Place, Reason, Speed, Verdict, seen};
use crate::error::Result;
use crate::observer::Observer;
use crate::prepare::Prepared;
use crate::transform::RecordScratch;

/// Widths of the pulse that a front window is long.
const WIDTHS: f64 = 10.0;
/// Records whose width is looked for, and groups that are compared, at most.
const LOOKED_AT: usize = 64;
const GROUPS: usize = 80;
/// Sites of a group.
const NEIGHBOURS: usize = 4;
/// Groups without which nothing is compared.
const FEWEST: usize = 2;
/// Ratio of the parts of the energy that windows hold, at the last and the first group, below which a wave spreads out of them.
const SPREADS_OUT: f64 = 0.85;
/// Correlation of arrivals with x from which on they are those of one wave.
const ONE_WAY: f64 = 0.9;
/// Samples of the shortest window.
const SHORTEST: usize = 8;
/// Magnitude, as a part of the largest of the field, below which a site has no energy to speak of.
pub(super) const LIVE: f64 = 1e-3;
/// Part of its first energy that a front holds as long as it is followed.
const FOLLOWED: f64 = 0.3;
/// The kind of window that fades, of those of a struck chain.
const FADING: usize = 3;
/// Times the noise in the leads of others from which on what is quiet behind a peak is none.
const LOUDER: f64 = 3.0;
/// Steadiness of records above which they have no front.
const STEADY: f64 = 0.5;

/// How the answer is found.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Options {
    pub dt: f64,
    pub tolerance: f64,
    /// Samples of a front window.
    pub window: Option<usize>,
    /// Standard deviation of the noise in prepared samples.
    pub noise: Option<f64>,
    /// In a simulated run, the last site that is struck or driven.
    pub struck: Option<usize>,
    /// Whether most of the energy travels towards -x, where no arrivals tell.
    pub toward_minus: bool,
    /// First site and position of the sites: rows of results count in the file.
    pub first_site: usize,
    pub origin: f64,
    pub dx: f64,
    /// Bytes that spectra of windows may take.
    pub most_bytes: u64,
}

impl Options {
    pub(super) fn place(&self, group: &Group) -> Place {
        let [a, b] = group.rows;
        Place {
            rows: [a + self.first_site, b + self.first_site],
            at: self.origin + 0.5 * (a + b) as f64 * self.dx,
        }
    }

    /// Groups of sites, each of whose sites takes so many numbers.
    pub(super) fn most_groups(&self, numbers: usize) -> usize {
        // Once as they are read, once in sums of groups.
        let sites = self.most_bytes as usize / (16 * numbers.max(1));
        (sites / NEIGHBOURS).clamp(8, GROUPS)
    }

    fn is_simulated(&self) -> bool {
        self.struck.is_some()
    }
}

/// What moved along x, and what else is known of the records then.
pub(crate) struct AlongX {
    pub movement: Movement,
    pub launch: Option<Movement>,
    pub front: Option<Part>,
    pub tail: Option<Part>,
    pub evidence: Option<Evidence>,
    pub speed: Option<Speed>,
    /// Whether waves arrive; else the record is steady.
    pub has_fronts: bool,
    /// Whether the front is that of a struck chain.
    pub is_struck: bool,
    /// The site of the file that comes first.
    pub first_site: usize,
    /// Baseline and noise of each site.
    pub levels: Vec<[f64; 2]>,
    /// Arrivals that count, by site.
    pub arrivals: Vec<Option<usize>>,
    /// Frequency below which half of the energy lies.
    pub median: f64,
}

impl AlongX {
    pub(super) fn untold(reason: Reason) -> AlongX {
        AlongX {
            movement: Movement::untold(reason),
            launch: None,
            front: None,
            tail: None,
            evidence: None,
            speed: None,
            has_fronts: false,
            is_struck: false,
            first_site: 0,
            levels: Vec::new(),
            arrivals: Vec::new(),
            median: f64::NAN,
        }
    }
}

/// # Errors
/// [`crate::Error::Cancelled`].
pub(crate) fn along_x(
    prepared: &Prepared,
    options: &Options,
    observer: &dyn Observer,
) -> Result<AlongX> {
    let (n_times, n_sites) = (prepared.n_times(), prepared.n_sites());
    if n_times < 2 * SHORTEST {
        return Ok(AlongX::untold(Reason::ShortRecord { times: n_times }));
    }
    let how = Reading {
        simulated: options.is_simulated(),
        noise: options.noise,
    };
    let every = n_sites.div_ceil(LOOKED_AT);
    let envelopes = Envelopes::new(n_times);
    let pieces = NoiseShape::transform(n_times);
    let measured = !how.simulated && how.noise.is_none();
    let looked = prepared.each_record(observer, |site, record, _| {
        let mut onset = Onset::of(record, how);
        let mut shape = (Vec::new(), 0);
        if site.is_multiple_of(every) && onset.peak > 0.0 {
            onset.width = Some(envelopes.width(record, onset.baseline));
            if measured && onset.noise.is_some_and(|noise| noise > 0.0) {
                shape = NoiseShape::sums(record, &pieces);
            }
        }
        (onset, shape)
    })?;
    let (mut onsets, shapes): (Vec<Onset>, Vec<_>) = looked.into_iter().unzip();
    let shapes: Vec<_> = shapes.into_iter().filter(|(_, count)| *count > 0).collect();
    let shape = NoiseShape::new(&shapes);
    let largest = onsets.iter().fold(0.0f64, |m, o| m.max(o.peak));
    if largest == 0.0 {
        return Ok(AlongX::untold(Reason::NoEnergy));
    }
    let live: Vec<bool> = onsets.iter().map(|o| o.peak > LIVE * largest).collect();

    let is_known = share_noise(prepared, &mut onsets, &live, how.noise, observer)?;
    let mut fronts = Fronts {
        options,
        onsets,
        live,
        n_times,
        every,
        width: f64::NAN,
        left_out: LeftOut::default(),
    };
    let eligible = fronts.eligible();
    if !(is_known && fronts.arrive(&eligible)) {
        return steady::along_x(prepared, options, &fronts.onsets, &fronts.live, observer);
    }
    fronts.compare(prepared, &eligible, &shape, observer)
}

/// Gives records whose noise is not known that of the others; returns whether it is known at most of them. It is not
/// where none is quiet, nor where what is quiet follows the peak and is far louder than the leads of others: the end of the wave.
fn share_noise(
    prepared: &Prepared,
    onsets: &mut [Onset],
    live: &[bool],
    given: Option<f64>,
    observer: &dyn Observer,
) -> Result<bool> {
    let of_live = |has_lead: bool| {
        let all = onsets.iter().zip(live).filter(|(_, live)| **live);
        all.filter(move |(onset, _)| onset.has_lead || !has_lead)
            .filter_map(|(onset, _)| Some((onset, onset.noise?)))
    };
    let [mut leads, mut parts]: [Vec<f64>; 2] = [
        of_live(true).map(|(_, noise)| noise).collect(),
        of_live(true).map(|(onset, noise)| noise / onset.peak).collect(),
    ];
    let (lead, part) = (median(&mut leads), median(&mut parts));
    // Louder by itself and beside its own peak: neither a gain nor a loss of the wave along x.
    let is_tail = |onset: &Onset| {
        let louder = |noise| noise > LOUDER * lead && noise > LOUDER * part * onset.peak;
        given.is_none() && !onset.has_lead && onset.noise.is_some_and(louder)
    };
    let unknown: Vec<bool> = onsets
        .iter()
        .zip(live)
        .map(|(onset, live)| *live && (onset.noise.is_none() || is_tail(onset)))
        .collect();
    let alive = live.iter().filter(|l| **l).count();
    let sites: Vec<usize> = (0..onsets.len()).filter(|j| unknown[*j]).collect();
    if 2 * sites.len() > alive {
        return Ok(false);
    }
    let known = onsets.iter().zip(live).zip(&unknown);
    let known = known.filter(|((_, live), unknown)| **live && !**unknown);
    let mut known: Vec<f64> = known.filter_map(|((onset, _), _)| onset.noise).collect();
    if sites.is_empty() || known.is_empty() {
        return Ok(2 * known.len() >= alive);
    }
    let common = median(&mut known);
    let arrivals = prepared.each_record_of(|j| unknown[j], observer, |site, record, _| {
        onsets[site].arrives(record, common)
    })?;
    for (site, arrival) in sites.into_iter().zip(arrivals) {
        onsets[site].noise = Some(common);
        onsets[site].arrival = arrival;
    }
    Ok(true)
}

pub(super) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Sites in groups of `size`, at most `most` of them, spread evenly.
pub(super) fn grouped(sites: &[usize], size: usize, most: usize) -> Vec<Vec<usize>> {
    let groups: Vec<&[usize]> = sites.chunks_exact(size).collect();
    let count = groups.len().min(most);
    (0..count)
        .map(|i| match count {
            1 => groups[0].to_vec(),
            _ => groups[i * (groups.len() - 1) / (count - 1)].to_vec(),
        })
        .collect()
}

/// Sites of a group, of `sites` that can be compared: a tenth of few.
pub(super) fn group_size(sites: usize, pairs: bool) -> usize {
    match sites / 10 {
        0 | 1 if pairs => 2,
        0 | 1 => 1,
        2 | 3 => 2,
        _ => NEIGHBOURS,
    }
}

struct Fronts<'a> {
    options: &'a Options,
    onsets: Vec<Onset>,
    live: Vec<bool>,
    n_times: usize,
    every: usize,
    /// Of the pulse, in samples.
    width: f64,
    left_out: LeftOut,
}

/// Spectra of a site in each kind of window; `None` where one does not fit.
struct Seen {
    site: usize,
    /// When the front is there, in samples: the centroid of the energy in its window, of a run the arrival.
    centre: f64,
    second: Option<usize>,
    spectra: Vec<Option<Spectrum>>,
}

impl Fronts<'_> {
    fn arrival(&self, site: usize) -> usize {
        self.onsets[site].arrival.unwrap_or(0)
    }

    /// Where windows begin: at the arrival, in measured records a width before it, since noise hides how a wave rises.
    fn start(&self, site: usize) -> usize {
        let lead = match self.options.is_simulated() {
            true => 0,
            false => self.width.round() as usize,
        };
        self.arrival(site).saturating_sub(lead)
    }

    /// Sites at which a wave arrives while the record runs, behind the struck body; finds the width of the pulse.
    fn eligible(&mut self) -> Vec<usize> {
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
    fn arrive(&self, sites: &[usize]) -> bool {
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
    fn sense(&self, sites: &[usize]) -> f64 {
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
    fn ends(&self, sites: &[usize], sense: f64) -> Vec<usize> {
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

    fn compare(
        mut self,
        prepared: &Prepared,
        eligible: &[usize],
        shape: &NoiseShape,
        observer: &dyn Observer,
    ) -> Result<AlongX> {
        let options = self.options;
        let sense = self.sense(eligible);
        let ends = self.ends(eligible, sense);
        let room: Vec<usize> = eligible
            .iter()
            .zip(&ends)
            .map(|(&j, end)| end.saturating_sub(self.start(j)))
            .collect();
        // As long as two thirds of the sites have.
        let mut sorted = room.clone();
        sorted.sort_unstable();
        let longest = sorted[sorted.len() / 3];
        let wanted = options
            .window
            .unwrap_or((WIDTHS * self.width).round() as usize);
        let goes_on =
            options.window.is_none() && wanted > longest && self.width > 0.25 * longest as f64;
        let window = match goes_on {
            // Motion that goes on has no pulse: what two thirds of the sites have of it.
            true => longest,
            false => wanted.max(SHORTEST),
        };
        if window < SHORTEST {
            let left_out = self.left_out;
            return Ok(self.untold(Reason::FewWindows { whole: 0, left_out }));
        }
        let is_struck = options.is_simulated() && !goes_on;
        let plan = |weights, span| Windows::new(weights, span, options.dt, shape);
        let mut kinds = vec![plan(Weights::Flat, (0, window))];
        // Checks with windows of half and twice the length, as far as these fit.
        kinds.push(plan(Weights::Flat, (0, (window / 2).max(SHORTEST))));
        kinds.push(plan(Weights::Flat, (0, 2 * window)));
        if is_struck {
            kinds.push(plan(Weights::Fading, (0, window)));
            kinds.push(plan(Weights::Fading, (0, (window / 2).max(SHORTEST))));
            kinds.push(plan(Weights::Fading, (0, 2 * window)));
        }
        let tail = match is_struck || !goes_on {
            true if longest >= 2 * window => {
                kinds.push(plan(Weights::Flat, (window, longest - window)));
                Some(kinds.len() - 1)
            }
            _ => None,
        };
        let fits = room.iter().filter(|room| **room >= window).count();
        let size = group_size(fits, options.is_simulated());
        let mut order = eligible.to_vec();
        if sense < 0.0 || (sense == 0.0 && options.toward_minus) {
            order.reverse();
        }
        let numbers = kinds.iter().map(|kind| 2 * kind.grid.upper.len()).sum();
        let groups = grouped(&order, size, options.most_groups(numbers));
        let mut wanted = vec![false; self.onsets.len()];
        groups.iter().flatten().for_each(|&j| wanted[j] = true);
        let end_of = |site: usize| {
            let at = eligible.binary_search(&site).ok();
            at.map_or(0, |i| ends[i])
        };
        let read = prepared.each_record_of(
            |j| wanted[j],
            observer,
            |site, record, _| {
                let onset = &self.onsets[site];
                let (arrival, noise) = (self.arrival(site), onset.noise.unwrap_or(0.0));
                let mut scratch = RecordScratch::default();
                let second = match options.is_simulated() {
                    true => None,
                    false => onset.second(record, arrival, noise, self.width),
                };
                let start = self.start(site);
                let spectra = kinds.iter().map(|kind| {
                    let levels = (onset.baseline, noise);
                    let steps = options.is_simulated() && kind.after == 0;
                    (start + kind.end() <= end_of(site))
                        .then(|| kind.spectrum(record, start, levels, steps, &mut scratch))
                });
                // Twice the window, where it fits: what its end cuts off would move the centroid.
                let span = match start + 2 * window <= end_of(site) {
                    true => 2 * window,
                    false => window,
                };
                let behind = record[start..].iter().take(span).enumerate();
                let (energy, moment) = behind.fold((0.0, 0.0), |(energy, moment), (n, v)| {
                    let e = (v - onset.baseline).powi(2) - noise * noise;
                    (energy + e, moment + n as f64 * e)
                });
                Seen {
                    site,
                    centre: match options.is_simulated() {
                        // A run has no noise, and its front no end.
                        true => arrival as f64,
                        false => start as f64 + moment / energy,
                    },
                    second,
                    spectra: spectra.collect(),
                }
            },
        )?;
        let mut seen: Vec<Option<Seen>> = (0..self.onsets.len()).map(|_| None).collect();
        for one in read {
            let site = one.site;
            seen[site] = Some(one);
        }
        self.drop_reflected(&mut seen, &kinds);
        let lone = |site: usize| seen[site].as_ref();
        // Whole groups alone, by kind of window.
        let of_kind = |kind: usize| -> Vec<Group> {
            let whole = groups.iter().filter_map(|group| {
                let members: Option<Vec<&Spectrum>> = group
                    .iter()
                    .map(|&j| lone(j).and_then(|s| s.spectra[kind].as_ref()))
                    .collect();
                let members = members?;
                let rows = [group[0], group[group.len() - 1]];
                let group = Group::of_neighbours(&members, rows, options.is_simulated());
                group.has_energy().then_some(group)
            });
            whole.collect()
        };
        for &site in groups.iter().flatten() {
            let one = lone(site);
            if one.is_some_and(|s| s.spectra[0].is_none()) {
                let late = self.start(site) + window > self.n_times;
                match late {
                    true => self.left_out.cut_off += 1,
                    false => self.left_out.reflected += 1,
                }
            }
        }
        let found = Found {
            options,
            kinds: &kinds,
            groups: (0..kinds.len()).map(of_kind).collect(),
            sense,
        };
        if found.groups[0].len() < FEWEST || found.groups[0].len() * size < 2 {
            let whole = found.groups[0].len() * size;
            let noisy =
                groups.len() >= FEWEST && self.left_out.cut_off + self.left_out.reflected == 0;
            let left_out = self.left_out;
            return Ok(self.untold(match noisy {
                true => Reason::Noise,
                false => Reason::FewWindows { whole, left_out },
            }));
        }
        let mut along = match is_struck {
            true => found.of_struck_chain(tail),
            false => found.of_field(tail),
        };
        let centres = order.iter().filter_map(|&j| {
            let one = lone(j).filter(|one| one.spectra[0].is_some())?;
            Some((j as f64, one.centre))
        });
        along.speed = self.speed(&centres.collect::<Vec<_>>(), sense);
        along.has_fronts = true;
        along.is_struck = is_struck;
        along.first_site = options.first_site;
        along.median = found.groups[0][0].quantile(&kinds[0].grid, 0.5);
        Ok(self.with_levels(along))
    }

    /// Windows into which what comes back falls: a second arrival that travels the other way than the first. Where both fall
    /// together, beside such windows, none can be told apart.
    fn drop_reflected(&self, seen: &mut [Option<Seen>], kinds: &[Windows]) {
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
    fn speed(&self, points: &[(f64, f64)], sense: f64) -> Option<Speed> {
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

    fn untold(self, reason: Reason) -> AlongX {
        let along = AlongX {
            has_fronts: true,
            ..AlongX::untold(reason)
        };
        self.with_levels(along)
    }

    fn with_levels(self, along: AlongX) -> AlongX {
        AlongX {
            arrivals: self
                .onsets
                .iter()
                .zip(&self.live)
                .map(|(o, live)| o.arrival.filter(|_| *live))
                .collect(),
            levels: self
                .onsets
                .iter()
                .map(|o| [o.baseline, o.noise.unwrap_or(0.0)])
                .collect(),
            ..along
        }
    }
}

/// Groups by kind of window: flat ones of the length, its half and its double; of a struck chain the same fading; the tail.
struct Found<'a> {
    options: &'a Options,
    kinds: &'a [Windows],
    groups: Vec<Vec<Group>>,
    sense: f64,
}

impl Found<'_> {
    fn between(&self, kind: usize, a: usize, b: usize) -> Movement {
        let groups = &self.groups[kind];
        let upper = &self.kinds[kind].grid.upper;
        let place = |group: &Group| self.options.place(group);
        Movement::between(
            &groups[a],
            &groups[b],
            upper,
            self.options.tolerance,
            &place,
        )
    }

    fn moved(&self, kind: usize, a: usize, b: usize) -> Moved {
        Moved::between(&self.groups[kind][a], &self.groups[kind][b])
    }

    /// Withdraws what other windows (by kind) do not say.
    fn checked_by_windows(
        &self,
        kind: usize,
        (a, b): (usize, usize),
        others: &[usize],
        movement: Movement,
    ) -> Movement {
        let tolerance = self.options.tolerance;
        let (verdict, groups) = (movement.verdict, &self.groups[kind]);
        if verdict == Verdict::Unchanged && movement.bound > 6.0 * tolerance {
            let bound = movement.bound;
            return movement.but_untold(Reason::Errors { bound });
        }
        for &other in others {
            let at = |rows: [usize; 2]| self.groups[other].iter().position(|g| g.rows == rows);
            let same = at(groups[a].rows).zip(at(groups[b].rows));
            let moved = same.map(|(a, b)| self.moved(other, a, b));
            if let Some(moved) = moved.filter(|moved| !moved.agrees(verdict, tolerance)) {
                let (up, down) = (moved.up.share, moved.down.share);
                return movement.but_untold(Reason::Windows { up, down });
            }
        }
        movement
    }

    /// Withdraws what neither other windows (by kind) nor the groups beside say.
    fn checked(
        &self,
        kind: usize,
        (a, b): (usize, usize),
        others: &[usize],
        movement: Movement,
    ) -> Movement {
        let movement = self.checked_by_windows(kind, (a, b), others, movement);
        let groups = &self.groups[kind];
        if groups.len() < 4 {
            return movement;
        }
        let beside = [
            (a + 1, b),
            (a, b - 1),
            (a.saturating_sub(1), b),
            (a, (b + 1).min(groups.len() - 1)),
        ];
        for (a, b) in beside.into_iter().filter(|(a, b)| a < b) {
            let moved = self.moved(kind, a, b);
            if !moved.agrees(movement.verdict, self.options.tolerance) {
                let (up, down) = (moved.up.share, moved.down.share);
                return movement.but_untold(Reason::Neighbours { up, down });
            }
        }
        movement
    }

    fn evidence(&self, kind: usize, compared: [usize; 2]) -> Evidence {
        let place = |group: &Group| self.options.place(group);
        Evidence::new(
            &self.kinds[kind].grid.upper,
            &self.groups[kind],
            compared,
            &place,
        )
    }

    /// From the first group to the last.
    fn of_field(&self, tail: Option<usize>) -> AlongX {
        let last = self.groups[0].len() - 1;
        let mut movement = self.checked(0, (0, last), &[1, 2], self.between(0, 0, last));
        if self.sense == 0.0 {
            (movement.transfer, movement.energy_ratio) = (None, f64::NAN);
        }
        let moves = !matches!(movement.verdict, Verdict::Unchanged | Verdict::Untold);
        if moves && self.spreads_out() {
            (movement.transfer, movement.lags) = (None, true);
        }
        let mut along = AlongX {
            movement,
            evidence: Some(self.evidence(0, [0, last])),
            ..AlongX::untold(Reason::NoEnergy)
        };
        // Of an array into which waves of several origins run, no part is a tail.
        if let Some(tail) = tail.filter(|_| self.sense != 0.0) {
            self.add_tail(&mut along, (0, 0..last + 1), tail);
        }
        along
    }

    /// Whether windows hold less and less of the energy of those of twice the length (or those of half of theirs, where the
    /// former do not fit): a wave that disperses leaves its window, slow frequencies first, which are not lost.
    fn spreads_out(&self) -> bool {
        let [window, half, twice] = [0, 1, 2].map(|kind| &self.groups[kind]);
        let [short, long] = match twice.len() >= FEWEST {
            true => [window, twice],
            false => [half, window],
        };
        let held = |group: Option<&Group>| {
            let group = group?;
            let same = short.iter().find(|one| one.rows == group.rows)?;
            Some(same.energy / group.energy)
        };
        let ends = held(long.first()).zip(held(long.last()));
        ends.is_some_and(|(first, last)| last < SPREADS_OUT * first)
    }

    fn of_struck_chain(&self, tail: Option<usize>) -> AlongX {
        let tolerance = self.options.tolerance;
        let groups = &self.groups[FADING];
        let last = groups.len() - 1;
        let later = |a: usize| (a + 1..=last).map(move |b| self.moved(FADING, a, b));
        let is_formed = |&a: &usize| later(a).all(|moved| moved.most() < tolerance);
        match (0..last.div_ceil(2))
            .find(is_formed)
            .filter(|&formed| !self.sheds(formed, last))
        {
            Some(formed) => {
                let mut movement = self.between(FADING, formed, last);
                let bound = later(formed).map(|moved| moved.bound()).fold(0.0, f64::max);
                (movement.verdict, movement.transfer) = (Verdict::Unchanged, None);
                movement.bound = bound;
                movement.settled_at = movement.from.map(|place| place.rows[0]);
                // Groups beside have been compared, and those before are the launch.
                let movement = self.checked_by_windows(FADING, (formed, last), &[4, 5], movement);
                let launch = self.between(FADING, 0, formed.max(1));
                let mut along = AlongX {
                    movement,
                    launch: Some(launch),
                    evidence: Some(self.evidence(FADING, [0, formed.max(1)])),
                    ..AlongX::untold(Reason::NoEnergy)
                };
                if let Some(tail) = tail {
                    self.add_tail(&mut along, (0, formed..last + 1), tail);
                }
                along
            }
            None => self.of_unsettled(tail),
        }
    }

    /// Whether a front whose content has settled loses most of its energy to what follows it: half of its own is gone, and a
    /// fifth of that of the window lies behind it.
    fn sheds(&self, formed: usize, last: usize) -> bool {
        let [flat, fading] = [&self.groups[0], &self.groups[FADING]];
        let end = &fading[last];
        let window = flat.iter().find(|group| group.rows == end.rows);
        let behind = window.is_some_and(|window| end.energy < 0.8 * window.energy);
        behind && end.energy < 0.5 * fading[formed].energy
    }

    /// The front never forms: it is followed while it holds three tenths of its energy.
    fn of_unsettled(&self, tail: Option<usize>) -> AlongX {
        let groups = &self.groups[0];
        let held = |group: &Group| group.energy >= FOLLOWED * groups[0].energy;
        let end = (1..groups.len())
            .take_while(|&b| held(&groups[b]))
            .last()
            .unwrap_or(1);
        let mut movement = self.between(0, 0, end);
        if movement.energy_ratio < 0.9 {
            movement.transfer = None;
        }
        let movement = self.checked(0, (0, end), &[1, 2], movement);
        let mut along = AlongX {
            movement,
            evidence: Some(self.evidence(0, [0, end])),
            ..AlongX::untold(Reason::NoEnergy)
        };
        if let Some(tail) = tail {
            self.add_tail(&mut along, (0, end..end + 1), tail);
        }
        along
    }

    /// The front and what it leaves behind, at the groups of `kind` in a range that both have.
    fn add_tail(
        &self,
        along: &mut AlongX,
        (kind, range): (usize, std::ops::Range<usize>),
        tail: usize,
    ) {
        let both = self.groups[kind][range].iter().filter_map(|front| {
            let tail = self.groups[tail]
                .iter()
                .find(|tail| tail.rows == front.rows)?;
            Some((front, tail))
        });
        let both: Vec<(&Group, &Group)> = both.collect();
        // A front in the middle of the range, where it has formed and its tail is long.
        let Some(&(front, behind)) = both.get(both.len() / 2) else {
            return;
        };
        let [fine, coarse] = [&self.kinds[tail].grid, &self.kinds[kind].grid];
        let on_tail = front.on(coarse, fine);
        let against = Moved::between(&on_tail, behind);
        let first = Moved::between(&self.groups[kind][0], front);
        let all = front.energy + behind.energy;
        let part = |group: &Group, grid: &super::share::Grid, moved: &Moved, upper: &[f64]| {
            let at = |share: &super::share::Share| (share.share > 0.0).then(|| upper[share.at]);
            Part {
                energy_share: group.energy / all,
                up: moved.up.share,
                up_at: at(&moved.up),
                down: moved.down.share,
                down_at: at(&moved.down),
                peak_frequency: group.peak(grid),
                band: [group.quantile(grid, 0.1), group.quantile(grid, 0.9)],
            }
        };
        along.front = Some(part(front, coarse, &first, &coarse.upper));
        along.tail = Some(part(behind, fine, &against, &fine.upper));
        if let Some(evidence) = &mut along.evidence {
            let place = |group: &Group| self.options.place(group);
            evidence.tail = Some(seen(&behind.on(fine, coarse), &evidence.upper, &place));
        }
    }
}
