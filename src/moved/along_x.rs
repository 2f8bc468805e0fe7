//! What moved in frequency along x.

use super::found::{Found, Seen};
use super::front::Fronts;
use super::onset::{Onset, REACHED};
use super::profile::add;
use super::speed::{self, Passage};
use super::windows::Windows;
use super::{Answer, ArrivalWindows, Place, Reason, Verdict, chain, steady};
use crate::error::Result;
use crate::observer::Observer;
use crate::prepare::Prepared;
use crate::transform::{RecordScratch, quick};

/// Widths of the pulse that a front window is long, but for its lead; those in a run, whose pulses have one sign and low frequencies;
/// and those of one that is shortened so that more sites have it.
const WIDTHS: f64 = 10.0;
const OF_RUN: f64 = 8.0;
const ENOUGH: f64 = 5.0;
/// Periods of the frequency below which half of the energy lies that it is long at least: a pulse of one sign is shorter than one.
const PERIODS: f64 = 5.0;
/// Times that a window grows at least, to be read again.
const LONGER: f64 = 1.2;
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
const LIVE: f64 = 1e-3;
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

    pub(super) fn is_simulated(&self) -> bool {
        self.struck.is_some()
    }

    /// Sites in groups of neighbours: a tenth of few, pairs of the cells of a chain; spread evenly, as many as the memory holds
    /// whose sites take so many numbers. `sites`: those that can be compared.
    pub(super) fn grouped(&self, order: &[usize], sites: usize, numbers: usize) -> Vec<Vec<usize>> {
        let least = if self.is_simulated() { 2 } else { 1 };
        let size = (sites / 10).clamp(least, NEIGHBOURS);
        // Once as they are read, once in sums of groups.
        let room = self.most_bytes as usize / (16 * numbers.max(1));
        let groups: Vec<&[usize]> = order.chunks_exact(size).collect();
        let count = groups.len().min((room / NEIGHBOURS).clamp(8, GROUPS));
        let spread = |i: usize| i * (groups.len() - 1) / (count - 1).max(1);
        (0..count).map(|i| groups[spread(i)].to_vec()).collect()
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
    if n_times < 2 * SHORTEST {
        return Ok(Answer::untold(Reason::ShortRecord));
    }
    let is_simulated = options.is_simulated();
    // Of a run, other pulses follow the front.
    let times = if is_simulated { 2 } else { 4 };
    let mut onsets = prepared.each_record(observer, |site, record, _| {
        let mut onset = Onset::of(record, options);
        let is_looked_at = site.is_multiple_of(n_sites.div_ceil(LOOKED_AT)) && onset.peak > 0.0;
        onset.width = is_looked_at.then(|| onset.width_of(record, times));
        onset
    })?;
    let largest = onsets.iter().fold(0.0f64, |m, o| m.max(o.peak));
    for onset in &mut onsets {
        onset.is_live = onset.peak > LIVE * largest;
        onset.arrival = onset.arrival.filter(|_| onset.is_live);
    }
    let live: Vec<&Onset> = onsets.iter().filter(|o| o.is_live).collect();
    match live.len() {
        0 => return Ok(Answer::untold(Reason::NoEnergy)),
        1 => return Ok(Answer::untold(Reason::FewSites)),
        _ => {}
    }
    let is_known = 2 * live.iter().filter(|o| o.noise.is_some()).count() >= live.len();
    let mut fronts = Fronts {
        options,
        onsets,
        n_times,
        width: f64::NAN,
        lead: 0,
        is_whole: false,
    };
    let eligible = fronts.eligible();
    if is_known && fronts.arrive(&eligible) {
        return fronts.compare(prepared, &eligible, observer);
    }
    if is_simulated || !fronts.are_transient() {
        return steady::along_x(prepared, options, fronts.onsets, observer);
    }
    if let Some(sites) = fronts.pass() {
        (fronts.is_whole, fronts.lead) = (true, n_times);
        return fronts.compare(prepared, &sites, observer);
    }
    // What noise hides has no beginning.
    let above = median(fronts.live().filter_map(|of| Some(of.peak / of.noise?)));
    Ok(fronts.untold(match above <= REACHED {
        true => Reason::Noise { bound: 1.0 },
        false => Reason::ShortRecord,
    }))
}

/// NaN of none; the upper of two in the middle.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> f64 {
    crate::numeric::median(values).unwrap_or(f64::NAN)
}

impl Fronts<'_> {
    /// Samples of a window, and whether the motion is one that goes on; `room`: those from its start on that each site has.
    fn window(&self, mut room: Vec<usize>) -> (usize, bool) {
        room.sort_unstable();
        // As long as two thirds of the sites have.
        let longest = room[room.len() / 3];
        let widths = |widths: f64| (widths * self.width).round() as usize;
        let wanted = match self.options.is_simulated() {
            true => widths(OF_RUN),
            false => widths(WIDTHS) + self.lead,
        };
        match self.options.window {
            _ if self.is_whole => (self.n_times, false),
            Some(window) => (window, false),
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
        let by_arrivals = self.sense(eligible);
        let has_origins = !self.is_whole && by_arrivals == 0.0 && self.origins(eligible).is_some();
        let reflected = self.reflected(by_arrivals);
        let room = |&j: &usize| self.end(j, reflected).saturating_sub(self.start(j));
        let room: Vec<usize> = eligible.iter().map(room).collect();
        let (samples, goes_on) = self.window(room.clone());
        if samples < SHORTEST {
            return Ok(self.untold(Reason::ShortRecord));
        }
        let padded = quick(2 * samples);
        // As long as the unpadded window is.
        let first = padded.div_ceil(samples);
        let mut window = Windows::new(&vec![1.0; samples], padded, first, options.dt);
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
        let numbers = 6 * window.grid.upper.len();
        let mut groups = options.grouped(&order, fits, numbers);
        let mut sites: Vec<usize> = groups.iter().flatten().copied().collect();
        sites.sort_unstable();
        let is_read = |site: usize| sites.binary_search(&site).is_ok();
        if sites.iter().any(|&j| self.onsets[j].noise > Some(0.0)) {
            let quiet = |site: usize, record: &[f64]| window.quiet(record, &self.onsets[site]);
            let quiet = prepared.each_record_of(is_read, observer, |j, of, _| quiet(j, of))?;
            window.set_noise(quiet.into_iter().flatten().flatten().collect());
        }
        let look = |site: usize, record: &[f64]| {
            let onset = &self.onsets[site];
            let mut scratch = RecordScratch::default();
            let (start, end) = (self.start(site), self.end(site, reflected));
            let mut spectrum = |from, run| window.spectrum(record, from, onset, run, &mut scratch);
            // In a run, before what the front leaves behind comes back.
            let fits = start + if is_simulated { 2 * samples } else { samples } <= end;
            let whole = fits.then(|| spectrum(start, is_simulated));
            let mut rest = vec![0.0; window.grid.upper.len()];
            let follows = (start + samples..end).step_by(samples);
            follows.for_each(|from| add(&mut rest, &spectrum(from, false).energy));
            let sums = onset.energies(record);
            let last = end.saturating_sub(samples / 4).max(start);
            let held = start..(start + samples).min(end);
            let moments = held.clone().map(|n| n as f64 * (sums[n + 1] - sums[n]));
            let energy = sums[held.end] - sums[held.start];
            Seen {
                second: onset
                    .second(record, self.arrival(site), self.width)
                    .filter(|_| !is_simulated && !self.is_whole),
                spectrum: whole,
                rest,
                energy,
                centre: moments.sum::<f64>() / energy,
                weight: 1.0,
                last: spectrum(last, false).energy,
            }
        };
        let mut seen =
            prepared.each_record_of(is_read, observer, |j, record, _| look(j, record))?;
        let seconds: Vec<Option<usize>> = seen.iter().flatten().map(|one| one.second).collect();
        let back = self.back(&sites, &seconds);
        let mut mixes = 0;
        for &site in sites.iter().filter(|_| back.is_some()) {
            let is_mixed = self.end(site, back) < self.start(site) + samples;
            if let Some(one) = seen[site].as_mut() {
                mixes += usize::from(is_mixed);
                one.spectrum.take_if(|_| is_mixed);
                one.rest.fill(0.0);
            }
        }
        let scale = options.dx / options.dt;
        let speed = match is_simulated {
            // A run has no noise, and its front no end.
            true => {
                let at = |&site: &usize| (site as f64, self.arrival(site) as f64);
                let points: Vec<(f64, f64)> = order.iter().map(at).collect();
                speed::speed(&points, scale).filter(|_| by_arrivals != 0.0)
            }
            // Group delays of waves that run both ways are those of neither.
            false if by_arrivals == 0.0 && (has_origins || back.is_some()) => None,
            false => {
                let passages = order.iter().filter_map(|&site| {
                    Some(Passage {
                        site,
                        start: self.start(site),
                        spectrum: seen[site].as_ref()?.spectrum.as_ref()?,
                    })
                });
                speed::of_windows(&passages.collect::<Vec<_>>(), scale)
            }
        };
        // Arrivals that noise scatters by more than they lie apart have no order; group delays have.
        let sense = match speed {
            Some(speed) if by_arrivals == 0.0 => (speed.value * scale).signum(),
            _ => by_arrivals,
        };
        if sense != 0.0 && (sense < 0.0) != is_reversed {
            groups.reverse();
            groups.iter_mut().for_each(|group| group.reverse());
        }
        if is_simulated {
            let centre = |site: usize| seen[site].as_ref().map_or(f64::NAN, |seen| seen.centre);
            let weights = chain::weights(prepared.masses(), &sites, &centre);
            let each = sites.iter().zip(weights);
            each.for_each(|(&j, weight)| seen[j].iter_mut().for_each(|one| one.weight = weight));
        }
        let found = Found {
            options,
            groups,
            seen,
            upper: &window.grid.upper,
        };
        let profile = found.profile(false);
        if profile.len() < 2 {
            let is_noise = found.groups.len() > 1 && mixes == 0 && 2 * fits > eligible.len();
            return Ok(self.untold(match 2 * mixes > sites.len() {
                true => Reason::Mixed,
                false if is_noise => Reason::Noise { bound: 1.0 },
                false => Reason::ShortRecord,
            }));
        }
        let period = 1.0 / profile.quantile(0, 0.5);
        let needs = PERIODS * period / options.dt / WIDTHS;
        let is_short = needs > LONGER * self.width && !is_simulated && !self.is_whole;
        if is_short && options.window.is_none() {
            // The memory is stated for one.
            drop((profile, found));
            drop(window);
            self.width = needs;
            return self.compare(prepared, eligible, observer);
        }
        let is_struck = is_simulated && !goes_on;
        let mut along = match is_struck {
            true => chain::along_x(&found, &profile),
            false => found.along_x(&profile, sense),
        };
        // Waves of two origins differ where they meet.
        if has_origins && along.frequency.verdict != Verdict::Unchanged {
            along.frequency = along.frequency.but_untold(Reason::Mixed);
        }
        let bodies = profile.rows(profile.len() - 1)[1].abs_diff(profile.rows(0)[0]);
        if is_simulated && bodies < LAUNCH {
            along.frequency = along.frequency.but_untold(Reason::FewSites);
        }
        along.windows = (!is_simulated).then(|| ArrivalWindows {
            arrivals: self.onsets.iter().map(|onset| onset.arrival).collect(),
            width: self.width,
            samples,
        });
        along.speed = speed;
        along.is_one_way = sense != 0.0 && back.is_none() && !is_simulated;
        along.is_struck = is_struck;
        along.period = period;
        Ok(self.with_levels(along))
    }

    fn untold(&mut self, reason: Reason) -> Answer {
        self.with_levels(Answer {
            // A pulse lasts half a period and longer.
            period: 2.0 * self.width * self.options.dt,
            ..Answer::untold(reason)
        })
    }

    fn with_levels(&mut self, along: Answer) -> Answer {
        let onsets = std::mem::take(&mut self.onsets);
        Answer {
            has_fronts: true,
            noise: onsets.iter().map(|o| o.noise.unwrap_or(0.0).powi(2)).sum(),
            onsets,
            ..along
        }
    }
}
