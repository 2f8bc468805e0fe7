//! What moved in frequency along x.

use super::front::{Fronts, Seen};
use super::gain::{self, GainChange, GainStep};
use super::graded::weights;
use super::groups::{FEWEST, Found, NEIGHBOURS, group_size, grouped};
use super::onset::{Envelopes, NoiseShape, Onset, Reading, common_noise};
use super::share::{Group, Spectrum};
use super::speed::{self, Passage};
use super::steady;
use super::windows::{Weights, Windows};
use super::{Evidence, LeftOut, Movement, Part, Place, Reason, Speed, Verdict};
use crate::error::Result;
use crate::observer::Observer;
use crate::prepare::Prepared;
use crate::transform::RecordScratch;

/// Widths of the pulse that a front window is long.
const WIDTHS: f64 = 10.0;
/// Widths that hold a pulse and its lead, and those of a window that is shortened so that more sites have it.
const PULSE: f64 = 4.0;
const ENOUGH: f64 = 5.0;
/// Records whose width is looked for, and groups that are compared, at most.
const LOOKED_AT: usize = 64;
const GROUPS: usize = 80;
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

    pub(super) fn is_simulated(&self) -> bool {
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
    /// Whether arrivals of a measured field run one way, and nothing is seen to come back.
    pub is_one_way: bool,
    /// Whether the front is that of a struck chain.
    pub is_struck: bool,
    /// The site of the file that comes first.
    pub first_site: usize,
    /// Baseline and noise of each site.
    pub levels: Vec<[f64; 2]>,
    /// Arrivals that count, by site.
    pub arrivals: Vec<Option<usize>>,
    /// Of a measured field with fronts: the width of the pulse and the length of the windows, in samples.
    pub window: Option<(f64, usize)>,
    /// Frequency below which half of the energy lies.
    pub median: f64,
    /// Variance of the noise, summed over the sites: of steady records, that of their white floor.
    pub noise: f64,
    pub gain_changes: Vec<GainChange>,
    pub gain_steps: Vec<GainStep>,
    /// Share of the energy that amplitudes which differ from site to site spread over all wavenumbers.
    pub uneven: f64,
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
            is_one_way: false,
            is_struck: false,
            first_site: 0,
            levels: Vec::new(),
            arrivals: Vec::new(),
            window: None,
            median: f64::NAN,
            noise: 0.0,
            gain_changes: Vec::new(),
            gain_steps: Vec::new(),
            uneven: 0.0,
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
            onset.width = Some(envelopes.width(record, onset.baseline, !how.simulated));
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

    if live.iter().filter(|live| **live).count() < 2 && n_sites > 1 {
        let left_out = LeftOut {
            sites: n_sites,
            not_reached: n_sites - 1,
            ..LeftOut::default()
        };
        return Ok(AlongX::untold(Reason::FewWindows { whole: 1, left_out }));
    }
    let is_known = share_noise(prepared, &mut onsets, &live, how.noise, observer)?;
    let (steps, changes) = match options.is_simulated() {
        true => (Vec::new(), Vec::new()),
        false => (
            gain::steps(&onsets, &live),
            gain::changes(&onsets, &live, n_times),
        ),
    };
    let uneven = match options.is_simulated() {
        true => 0.0,
        false => gain::uneven(&onsets),
    };
    let mut fronts = Fronts {
        options,
        common: common_noise(&onsets),
        onsets,
        live,
        n_times,
        every,
        width: f64::NAN,
        lead: 0,
        left_out: LeftOut::default(),
    };
    let eligible = fronts.eligible();
    let along = match is_known && fronts.arrive(&eligible) {
        true => fronts.compare(prepared, &eligible, &shape, observer)?,
        false if !options.is_simulated() && fronts.are_transient() => {
            let reason = match fronts.are_faint() {
                true => Reason::Noise,
                false => Reason::Begins,
            };
            fronts.untold(reason)
        }
        false => {
            let along = steady::along_x(prepared, options, &fronts.onsets, &fronts.live, observer)?;
            AlongX {
                gain_changes: changes,
                ..along
            }
        }
    };
    Ok(AlongX {
        gain_steps: steps,
        uneven,
        ..along
    })
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
        of_live(true)
            .map(|(onset, noise)| noise / onset.peak)
            .collect(),
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
    let arrivals = prepared.each_record_of(
        |j| unknown[j],
        observer,
        |site, record, _| onsets[site].arrives(record, common),
    )?;
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

impl Fronts<'_> {
    /// With windows of the usual length or, if reflections fall into most of them, with the shortest that hold a pulse.
    fn compare(
        mut self,
        prepared: &Prepared,
        eligible: &[usize],
        shape: &NoiseShape,
        observer: &dyn Observer,
    ) -> Result<AlongX> {
        let left_out = self.left_out;
        let usual = self.compare_in(WIDTHS, prepared, eligible, shape, observer)?;
        let is_simulated = self.options.is_simulated();
        let read = eligible.len().min(GROUPS * NEIGHBOURS);
        let is_short = match is_simulated {
            true => matches!(
                usual.movement.reason,
                Some(Reason::ShortChain { .. } | Reason::FewWindows { .. })
            ),
            false => 2 * self.left_out.reflected > read,
        };
        if self.options.window.is_some() || !is_short {
            return Ok(usual);
        }
        self.left_out = left_out;
        let short = self.compare_in(ENOUGH, prepared, eligible, shape, observer)?;
        // Between reflections that lie so close, what seems to move may be one that is not told apart.
        Ok(match short.movement.verdict {
            Verdict::Unchanged => short,
            Verdict::Untold => usual,
            _ if is_simulated => short,
            _ => usual,
        })
    }

    fn compare_in(
        &mut self,
        widths: f64,
        prepared: &Prepared,
        eligible: &[usize],
        shape: &NoiseShape,
        observer: &dyn Observer,
    ) -> Result<AlongX> {
        let options = self.options;
        let by_arrivals = self.sense(eligible);
        let origins = match by_arrivals == 0.0 {
            true => self.origins(eligible),
            false => None,
        };
        let ends = self.ends(eligible, by_arrivals);
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
            .unwrap_or((widths * self.width).round() as usize);
        let is_free = options.window.is_none();
        let goes_on = is_free && wanted > longest && self.width > 0.25 * longest as f64;
        // What nearly all sites have, if it holds a pulse.
        let fitting = sorted[sorted.len() / 20].max((ENOUGH * self.width).round() as usize);
        let window = match (goes_on, is_free && !options.is_simulated()) {
            // Motion that goes on has no pulse: what two thirds of the sites have of it.
            (true, _) => longest,
            (false, true) => wanted.min(fitting.min(longest)).max(SHORTEST),
            (false, false) => wanted.max(SHORTEST),
        };
        if window < SHORTEST {
            let left_out = self.left_out;
            return Ok(self.untold(Reason::FewWindows { whole: 0, left_out }));
        }
        let is_struck = options.is_simulated() && !goes_on;
        let plan = |weights, span| Windows::new(weights, span, options.dt, shape);
        let mut kinds = vec![plan(Weights::Flat, (0, window))];
        kinds[0].has_delays = !options.is_simulated();
        // Checks with windows of half and twice the length, as far as these fit, and as far as half a window holds a pulse.
        let pulse = match goes_on || options.is_simulated() {
            true => 0,
            false => ((PULSE * self.width) as usize).min(window),
        };
        kinds.push(plan(
            Weights::Flat,
            (0, (window / 2).max(SHORTEST).max(pulse)),
        ));
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
        // A window that cuts a pulse cuts it alike everywhere.
        if !options.is_simulated() && (window as f64) < widths * self.width {
            order.retain(|&j| self.arrival(j) >= self.lead);
            self.left_out.entered_late += eligible.len() - order.len();
        }
        let is_reversed = by_arrivals < 0.0 || (by_arrivals == 0.0 && options.toward_minus);
        if is_reversed {
            order.reverse();
        }
        let numbers = kinds.iter().map(|kind| 2 * kind.grid.upper.len()).sum();
        let mut groups = grouped(&order, size, options.most_groups(numbers));
        let mut wanted = vec![false; self.onsets.len()];
        groups.iter().flatten().for_each(|&j| wanted[j] = true);
        let end_of = |site: usize| {
            let at = eligible.binary_search(&site).ok();
            at.map_or(0, |i| ends[i])
        };
        let masses = prepared.masses().filter(|_| is_struck);
        let weights = masses.map(|masses| weights(masses, eligible, &|site| self.arrival(site)));
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
                let weight = weights.as_ref().map_or(1.0, |weights| weights[site]);
                let spectra = kinds.iter().map(|kind| {
                    let levels = (onset.baseline, noise);
                    let steps = options.is_simulated() && kind.after == 0;
                    (start + kind.end() <= end_of(site))
                        .then(|| kind.spectrum(record, start, levels, steps, &mut scratch))
                        .map(|spectrum| spectrum.times(weight))
                });
                Seen {
                    site,
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
        let comes_back = self.drop_reflected(&mut seen, &kinds);
        let lone = |site: usize| seen[site].as_ref();
        let fronts = order.iter().filter_map(|&site| {
            Some(Passage {
                site,
                start: self.start(site),
                spectrum: lone(site)?.spectra[0].as_ref()?,
            })
        });
        let fronts: Vec<Passage> = fronts.collect();
        let scale = options.dx / options.dt;
        let arrival = |front: &Passage| (front.site as f64, self.arrival(front.site) as f64);
        let is_ordered = by_arrivals != 0.0;
        let speed = match options.is_simulated() {
            // A run has no noise, and its front no end.
            true if is_ordered => {
                speed::speed(&fronts.iter().map(arrival).collect::<Vec<_>>(), scale)
            }
            // Group delays of waves that run both ways are those of neither.
            false if is_ordered || (origins.is_none() && !comes_back) => {
                speed::of_windows(&fronts, scale)
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
        // Whole groups alone, by kind of window.
        let of_kind = |kind: usize| -> Vec<Group> {
            let whole = groups.iter().filter_map(|group| {
                let members: Option<Vec<&Spectrum>> = group
                    .iter()
                    .map(|&j| lone(j).and_then(|s| s.spectra[kind].as_ref()))
                    .collect();
                let members = members?;
                let rows = [group[0], group[group.len() - 1]];
                let group =
                    Group::of_neighbours(&members, rows, self.common, options.is_simulated());
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
        if let Some(at) = origins {
            // What is the same on both sides has not moved, whatever its origin.
            let spans = |from: Place, to: Place| {
                let sides = [from, to].map(|place| place.rows[0] < at + options.first_site);
                sides[0] != sides[1]
            };
            let ends = along.movement.from.zip(along.movement.to);
            let differs = Some(Reason::Origins);
            let reason = match (along.movement.verdict, along.movement.reason) {
                (_, Some(Reason::Windows { .. } | Reason::Neighbours { .. })) => differs,
                (Verdict::Untold, _) => None,
                (Verdict::Unchanged, _) if ends.is_some_and(|(from, to)| spans(from, to)) => None,
                (Verdict::Unchanged, _) => Some(Reason::FewWindows {
                    whole: found.groups[0].len() * size,
                    left_out: self.left_out,
                }),
                _ => differs,
            };
            if let Some(reason) = reason {
                along.movement = along.movement.but_untold(reason);
            }
        }
        along.speed = speed;
        along.has_fronts = true;
        along.is_one_way = sense != 0.0 && !comes_back && !options.is_simulated();
        along.window = (!options.is_simulated()).then_some((self.width, window));
        along.is_struck = is_struck;
        along.first_site = options.first_site;
        along.median = found.groups[0][0].quantile(&kinds[0].grid, 0.5);
        Ok(self.with_levels(along))
    }

    fn untold(&self, reason: Reason) -> AlongX {
        let along = AlongX {
            has_fronts: true,
            // A pulse lasts half a period and longer.
            median: 0.5 / (self.width * self.options.dt),
            ..AlongX::untold(reason)
        };
        self.with_levels(along)
    }

    fn with_levels(&self, along: AlongX) -> AlongX {
        AlongX {
            arrivals: self
                .onsets
                .iter()
                .zip(&self.live)
                .map(|(o, live)| o.arrival.filter(|_| *live))
                .collect(),
            noise: self
                .onsets
                .iter()
                .map(|o| o.noise.unwrap_or(0.0).powi(2))
                .sum(),
            levels: self
                .onsets
                .iter()
                .map(|o| [o.baseline, o.noise.unwrap_or(0.0)])
                .collect(),
            ..along
        }
    }
}
