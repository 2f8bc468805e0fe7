//! What moved in frequency along x.

use super::found::{Found, Seen};
use super::front::Fronts;
use super::onset::{Envelopes, Onset, Reading};
use super::profile::add;
use super::speed::{self, Passage};
use super::windows::{DRAWN_SITES, DRAWS, Windows};
use super::{Answer, ArrivalWindows, Movement, Place, Reason, Verdict, chain, steady};
use crate::error::Result;
use crate::observer::Observer;
use crate::prepare::Prepared;
use crate::transform::RecordScratch;

/// Widths of the pulse that a front window is long, but for its lead, and those of one that is shortened so that more sites
/// have it.
const WIDTHS: f64 = 10.0;
const ENOUGH: f64 = 5.0;
/// Records whose width is looked for, and groups that are compared, at most.
const LOOKED_AT: usize = 64;
const GROUPS: usize = 80;
/// Sites of a group.
const NEIGHBOURS: usize = 4;
/// Bodies of a chain over which the launch and what follows it are not told apart.
const LAUNCH: usize = 40;
/// Samples of the shortest window.
const SHORTEST: usize = 8;
/// Magnitude, as a part of the largest of the field, below which a site has no energy to speak of.
pub(super) const LIVE: f64 = 1e-3;
/// Times the noise in the leads of others from which on what is quiet behind a peak is none.
const LOUDER: f64 = 3.0;
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
    pub(super) fn place(&self, [a, b]: [usize; 2]) -> Place {
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

    pub(super) fn is_simulated(&self) -> bool {
        self.struck.is_some()
    }
}

/// What moved along x, and what else is known of the records then.
///
/// # Errors
/// [`crate::Error::Cancelled`].
pub(crate) fn along_x(
    prepared: &Prepared,
    options: &Options,
    observer: &dyn Observer,
) -> Result<Answer> {
    let (n_times, n_sites) = (prepared.n_times(), prepared.n_sites());
    let short = Reason::ShortRecord {
        whole: 0,
        sites: n_sites,
    };
    if n_times < 2 * SHORTEST {
        return Ok(Answer::untold(short));
    }
    let is_simulated = options.is_simulated();
    let how = Reading {
        simulated: is_simulated,
        noise: options.noise,
    };
    let every = n_sites.div_ceil(LOOKED_AT);
    let envelopes = Envelopes::new(n_times);
    let mut onsets = prepared.each_record(observer, |site, record, _| {
        let mut onset = Onset::of(record, how);
        if site.is_multiple_of(every) && onset.peak > 0.0 {
            onset.width = Some(envelopes.width(record, onset.baseline, !is_simulated));
        }
        onset
    })?;
    let largest = onsets.iter().fold(0.0f64, |m, o| m.max(o.peak));
    if largest == 0.0 {
        return Ok(Answer::untold(Reason::NoEnergy));
    }
    onsets
        .iter_mut()
        .for_each(|o| o.is_live = o.peak > LIVE * largest);
    let alive = onsets.iter().filter(|o| o.is_live).count();
    if alive < 2 {
        return Ok(Answer::untold(Reason::FewSites { sites: alive }));
    }
    let is_known = share_noise(prepared, &mut onsets, how.noise, observer)?;
    let mut fronts = Fronts {
        options,
        onsets,
        n_times,
        every,
        width: f64::NAN,
        lead: 0,
        is_whole: false,
    };
    let eligible = fronts.eligible();
    match is_known && fronts.arrive(&eligible) {
        true => fronts.compare(prepared, &eligible, observer),
        false if !is_simulated && fronts.are_transient() => match fronts.pass() {
            Some(sites) => {
                fronts.is_whole = true;
                fronts.compare(prepared, &sites, observer)
            }
            None if fronts.are_faint() => Ok(fronts.untold(Reason::Noise { bound: 1.0 })),
            None => Ok(fronts.untold(short)),
        },
        false => steady::along_x(prepared, options, fronts.onsets, observer),
    }
}

/// Gives records whose noise is not known that of the others; returns whether it is known at most of them. It is not
/// where none is quiet, nor where what is quiet follows the peak and is far louder than the leads of others: the end of the wave.
fn share_noise(
    prepared: &Prepared,
    onsets: &mut [Onset],
    given: Option<f64>,
    observer: &dyn Observer,
) -> Result<bool> {
    let of_leads = |of: fn(&Onset, f64) -> f64| {
        let leads = onsets.iter().filter(|o| o.is_live && o.has_lead);
        let mut values: Vec<f64> = leads.filter_map(|o| Some(of(o, o.noise?))).collect();
        median(&mut values)
    };
    let (lead, part) = (
        of_leads(|_, noise| noise),
        of_leads(|o, noise| noise / o.peak),
    );
    // Louder by itself and beside its own peak: neither a gain nor a loss of the wave along x.
    let is_tail = |o: &Onset, noise: f64| {
        let is_louder = noise > LOUDER * lead && noise > LOUDER * part * o.peak;
        given.is_none() && !o.has_lead && is_louder
    };
    let sites = (0..onsets.len()).filter(|&j| onsets[j].is_live);
    let is_known = |&j: &usize| {
        onsets[j]
            .noise
            .is_some_and(|noise| !is_tail(&onsets[j], noise))
    };
    let (known, unknown): (Vec<usize>, Vec<usize>) = sites.partition(is_known);
    if known.len() < unknown.len() || known.is_empty() || unknown.is_empty() {
        return Ok(!known.is_empty() && unknown.is_empty());
    }
    let noises = known.iter().filter_map(|&j| onsets[j].noise);
    let common = median(&mut noises.collect::<Vec<_>>());
    let arrivals = prepared.each_record_of(
        |j| unknown.binary_search(&j).is_ok(),
        observer,
        |site, record, _| onsets[site].arrives(record, common),
    )?;
    for (site, arrival) in unknown.into_iter().zip(arrivals) {
        (onsets[site].noise, onsets[site].arrival) = (Some(common), arrival);
    }
    Ok(true)
}

pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Sites of a group, of `sites` that can be compared: a tenth of few; pairs of the cells of a chain.
pub(super) fn group_size(sites: usize, pairs: bool) -> usize {
    match sites / 10 {
        0 | 1 if pairs => 2,
        0 | 1 => 1,
        2 | 3 => 2,
        _ => NEIGHBOURS,
    }
}

/// Sites in groups of `size`, at most `most` of them, spread evenly.
pub(super) fn grouped(sites: &[usize], size: usize, most: usize) -> Vec<Vec<usize>> {
    let groups: Vec<&[usize]> = sites.chunks_exact(size).collect();
    let count = groups.len().min(most);
    (0..count)
        .map(|i| groups[i * (groups.len() - 1) / (count - 1).max(1)].to_vec())
        .collect()
}

/// What waves of two origins, which meet at a site, say: what is the same on both sides has not moved.
fn mixed(movement: Movement, at: usize) -> Movement {
    let sides = [movement.from, movement.to].map(|place| place.map(|place| place.rows[0] < at));
    match movement.verdict {
        Verdict::Untold => movement,
        Verdict::Unchanged if sides[0] != sides[1] => movement,
        _ => movement.but_untold(Reason::Mixed),
    }
}

impl Fronts<'_> {
    /// Samples of a window, and whether the motion is one that goes on; `room`: those from its start on that each site has.
    fn window(&self, mut room: Vec<usize>) -> (usize, bool) {
        room.sort_unstable();
        // As long as two thirds of the sites have.
        let longest = room[room.len() / 3];
        let widths = |widths: f64| (widths * self.width).round() as usize;
        let wanted = self.options.window.unwrap_or(widths(WIDTHS) + self.lead);
        match self.options.window {
            _ if self.is_whole => (self.n_times, false),
            Some(_) => (wanted, false),
            // Motion that goes on has no pulse: what two thirds of the sites have of it.
            None if wanted > longest && self.width > 0.25 * longest as f64 => (longest, true),
            None if self.options.is_simulated() => (wanted, false),
            // What nearly all sites have, if it holds a pulse.
            None => {
                let fitting = room[room.len() / 20].max(widths(ENOUGH));
                (wanted.min(fitting.min(longest)), false)
            }
        }
    }

    fn compare(
        &mut self,
        prepared: &Prepared,
        eligible: &[usize],
        observer: &dyn Observer,
    ) -> Result<Answer> {
        let options = self.options;
        let is_simulated = options.is_simulated();
        let (by_arrivals, origins) = match self.is_whole {
            true => (0.0, None),
            false => (self.sense(eligible), self.origins(eligible)),
        };
        let origins = origins.filter(|_| by_arrivals == 0.0);
        let ends = self.ends(eligible, by_arrivals);
        let room = eligible.iter().zip(&ends);
        let room = room.map(|(&j, end)| end.saturating_sub(self.start(j)));
        let room: Vec<usize> = room.collect();
        let (samples, goes_on) = self.window(room.clone());
        let short = |whole| Reason::ShortRecord {
            whole,
            sites: eligible.len(),
        };
        if samples < SHORTEST {
            return Ok(self.untold(short(0)));
        }
        let mut window = Windows::new(samples, options.dt);
        // A pulse, without what it has left behind.
        let pulse = Windows::new((samples / 2).max(SHORTEST), options.dt);
        let mut order = eligible.to_vec();
        // A window that cuts a pulse cuts it alike everywhere.
        if !self.is_whole && (samples as f64) < WIDTHS * self.width {
            order.retain(|&j| self.arrival(j) >= self.lead);
        }
        let is_reversed = by_arrivals < 0.0 || (by_arrivals == 0.0 && options.toward_minus);
        if is_reversed {
            order.reverse();
        }
        let fits = room.iter().filter(|room| **room >= samples).count();
        let size = group_size(fits, is_simulated);
        let most = options.most_groups((2 * DRAWS + 6) * window.grid.upper.len());
        let mut groups = grouped(&order, size, most);
        let mut ranks: Vec<Option<usize>> = vec![None; self.onsets.len()];
        for (rank, &site) in groups.iter().flatten().enumerate() {
            ranks[site] = Some(rank);
        }
        let sites: Vec<usize> = (0..ranks.len()).filter(|&j| ranks[j].is_some()).collect();
        let is_noisy = |&j: &usize| self.onsets[j].noise.is_some_and(|noise| noise > 0.0);
        if sites.iter().any(is_noisy) {
            let every = sites.len().div_ceil(DRAWN_SITES);
            let quiet = prepared.each_record_of(
                |j| ranks[j].is_some(),
                observer,
                |site, record, _| {
                    let keeps = ranks[site].is_some_and(|rank| rank.is_multiple_of(every));
                    window.quiet(record, &self.onsets[site], keeps)
                },
            )?;
            window.set_noise(quiet);
        }
        let end_of = |site: usize| eligible.binary_search(&site).map_or(0, |i| ends[i]);
        let look = |site: usize, record: &[f64]| {
            let onset = &self.onsets[site];
            let mut scratch = RecordScratch::default();
            let (start, end) = (self.start(site), end_of(site));
            let rank = ranks[site].filter(|_| !is_simulated);
            let spectrum = (start + samples <= end)
                .then(|| window.spectrum(record, start, onset, rank, is_simulated, &mut scratch));
            let of_pulse = (is_simulated && start + pulse.samples <= end).then(|| {
                pulse
                    .spectrum(record, start, onset, None, true, &mut scratch)
                    .energy
            });
            let mut energy = |from| {
                window
                    .spectrum(record, from, onset, None, false, &mut scratch)
                    .energy
            };
            let mut rest = vec![0.0; window.grid.upper.len()];
            let follows = (start + samples..end).step_by(samples);
            for from in follows.filter(|_| !self.is_whole) {
                add(&mut rest, &energy(from));
            }
            let last = energy(end.saturating_sub(samples / 4).max(start));
            let squares = record
                .iter()
                .enumerate()
                .take(end.min(start + pulse.samples))
                .skip(start);
            let squares = squares.map(|(n, v)| (n as f64, v * v));
            let (moment, energy) = squares.fold((0.0, 0.0), |(m, e), (n, v)| (m + n * v, e + v));
            Seen {
                second: match is_simulated || self.is_whole {
                    true => None,
                    false => onset.second(record, self.arrival(site), self.width),
                },
                spectrum,
                pulse: of_pulse,
                rest,
                last,
                energy,
                centre: moment / energy,
            }
        };
        let read = prepared.each_record_of(
            |j| ranks[j].is_some(),
            observer,
            |j, record, _| look(j, record),
        )?;
        let mut seen: Vec<Option<Seen>> = (0..self.onsets.len()).map(|_| None).collect();
        for (&site, one) in sites.iter().zip(read) {
            seen[site] = Some(one);
        }
        let seconds: Vec<Option<usize>> = sites.iter().map(|&j| seen[j].as_ref()?.second).collect();
        let back = self.back(&sites, &seconds);
        let comes_back = back.is_some();
        let mut reflected = 0;
        for (&site, second) in sites.iter().zip(back.into_iter().flatten()) {
            if let (Some(second), Some(one)) = (second, seen[site].as_mut()) {
                if second < self.start(site) + samples {
                    one.spectrum = None;
                    reflected += 1;
                }
                one.rest.fill(0.0);
            }
        }
        let passages = order.iter().filter_map(|&site| {
            Some(Passage {
                site,
                start: self.start(site),
                spectrum: seen[site].as_ref()?.spectrum.as_ref()?,
                padding: window.padding,
            })
        });
        let passages: Vec<Passage> = passages.collect();
        let scale = options.dx / options.dt;
        let is_ordered = by_arrivals != 0.0;
        let speed = match is_simulated {
            // A run has no noise, and its front no end.
            true if is_ordered => {
                let arrivals = passages
                    .iter()
                    .map(|of| (of.site as f64, self.arrival(of.site) as f64));
                speed::speed(&arrivals.collect::<Vec<_>>(), scale)
            }
            // Group delays of waves that run both ways are those of neither.
            false if is_ordered || (origins.is_none() && !comes_back) => {
                speed::of_windows(&passages, scale)
            }
            _ => None,
        };
        // Arrivals that noise scatters by more than they lie apart have no order; group delays have.
        let sense = match speed {
            Some(speed) if !is_ordered => (speed.value * scale).signum(),
            _ => by_arrivals,
        };
        if sense != 0.0 && (sense < 0.0) != is_reversed {
            groups.reverse();
            groups.iter_mut().for_each(|group| group.reverse());
        }
        if is_simulated {
            let equal = vec![1.0; self.onsets.len()];
            let masses = prepared.masses().unwrap_or(&equal);
            let centre = |site: usize| seen[site].as_ref().map_or(f64::NAN, |seen| seen.centre);
            let weights = chain::weights(masses, &sites, &centre);
            for (one, weight) in seen.iter_mut().zip(weights) {
                one.iter_mut().for_each(|one| one.weigh(weight));
            }
        }
        let found = Found {
            options,
            groups,
            seen,
            upper: &window.grid.upper,
        };
        let profile = found.profile(false);
        if profile.len() < 2 {
            let is_noise = found.groups.len() > 1 && reflected == 0 && 2 * fits > eligible.len();
            return Ok(self.untold(match 2 * reflected > sites.len() {
                true => Reason::Mixed,
                false if is_noise => Reason::Noise { bound: 1.0 },
                false => short(profile.len() * size),
            }));
        }
        let is_struck = is_simulated && !goes_on;
        let mut along = match is_struck {
            true => chain::along_x(&found, &profile, &found.of_pulses(&pulse.grid.upper)),
            false => found.along_x(&profile, sense),
        };
        if let Some(at) = origins {
            along.frequency = mixed(along.frequency, at + options.first_site);
        }
        let bodies = profile.rows(profile.len() - 1)[1].abs_diff(profile.rows(0)[0]);
        if is_simulated && bodies < LAUNCH {
            let reason = Reason::FewSites { sites: bodies };
            along.frequency = along.frequency.but_untold(reason);
        }
        along.speed = speed;
        along.has_fronts = true;
        along.is_one_way = sense != 0.0 && !comes_back && !is_simulated;
        along.windows = (!is_simulated).then(|| ArrivalWindows {
            arrivals: self
                .onsets
                .iter()
                .map(|o| o.arrival.filter(|_| o.is_live))
                .collect(),
            width: self.width,
            samples,
        });
        along.is_struck = is_struck;
        along.period = 1.0 / profile.quantile(0, 0.5);
        Ok(self.with_levels(along))
    }

    fn untold(&mut self, reason: Reason) -> Answer {
        let untold = Answer {
            has_fronts: true,
            // A pulse lasts half a period and longer.
            period: 2.0 * self.width * self.options.dt,
            ..Answer::untold(reason)
        };
        self.with_levels(untold)
    }

    fn with_levels(&mut self, along: Answer) -> Answer {
        let mut onsets = std::mem::take(&mut self.onsets);
        onsets
            .iter_mut()
            .filter(|o| !o.is_live)
            .for_each(|o| o.arrival = None);
        Answer {
            noise: onsets.iter().map(|o| o.noise.unwrap_or(0.0).powi(2)).sum(),
            onsets,
            ..along
        }
    }
}
