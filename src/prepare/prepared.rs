//! The prepared field: any block of it, on demand.

use std::ops::Range;

use rayon::prelude::*;

use super::read_ahead::ReadAhead;
use super::scan::{ChannelScan, Gap};
use super::trend::Trend;
use super::{Detrend, Gaps, Preparation, unit};
use crate::error::{Error, Fault, Result};
use crate::field::Field;
use crate::numeric::{pieces, sum, sum_of_squares};
use crate::observer::Observer;

/// A field with its range, gaps, scale and trends settled; see the [module](super) documentation.
pub(crate) struct Prepared<'a> {
    pub field: &'a Field,
    pub(super) times: Range<usize>,
    pub(super) sites: Range<usize>,
    /// Amplitudes are divided by this power of two, so that their squares stay in range.
    unit: f64,
    is_silent: bool,
    /// By site, then time; indices are those of the range.
    pub(super) gaps: Vec<Gap>,
    /// The same by time, then site.
    pub(super) gaps_by_time: Vec<Gap>,
    masked: bool,
    /// Whether each site of the range is left out; empty if none is.
    pub(super) left_out: Vec<bool>,
    field_mean: Option<Trend>,
    /// One a time, or none at all.
    space_trends: Vec<Trend>,
    /// One a site, or none at all.
    time_trends: Vec<Trend>,
    pub(super) tiles: Tiles,
}

/// How many records or profiles are read at once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tiles {
    pub sites: usize,
    pub times: usize,
    /// Records read ahead of the tiles, where the field is larger than memory.
    pub ahead: Option<usize>,
    /// Largest size of the list of gaps in bytes.
    pub memory: u64,
}

impl<'a> Prepared<'a> {
    /// Examines every sample and determines its preparation.
    ///
    /// # Errors
    /// [`Error::NonFinite`] for gaps if they are refused; [`Error::Unresolved`] if samples that segments reach vanish in the unit;
    /// [`Error::Cancelled`].
    pub fn new(
        field: &'a Field,
        times: Range<usize>,
        sites: Range<usize>,
        preparation: Preparation<'_>,
        tiles: Tiles,
        observer: &dyn Observer,
    ) -> Result<(Self, Vec<ChannelScan>)> {
        let left_out = match preparation.left_out {
            [] => Vec::new(),
            left_out => sites.clone().map(|j| left_out.contains(&j)).collect(),
        };
        let mut prepared = Prepared {
            field,
            left_out,
            times,
            sites,
            unit: 1.0,
            is_silent: false,
            gaps: Vec::new(),
            gaps_by_time: Vec::new(),
            masked: preparation.gaps == Gaps::LeaveOut
                || preparation.gaps == Gaps::Mask && !preparation.masks_by_mean,
            field_mean: None,
            space_trends: Vec::new(),
            time_trends: Vec::new(),
            tiles,
        };
        let scans = prepared.scan(preparation.gaps, observer)?;
        // Samples that no segment reaches do not count, unless they are transformed along space.
        let precision = preparation.precision;
        let largest = scans.iter().fold(0.0, |m: f64, s| m.max(s.largest));
        let reached = prepared.largest_before(preparation.reached, largest, observer)?;
        let transformed = match preparation.transforms_all {
            true => largest,
            false => reached,
        };
        prepared.is_silent = transformed == 0.0;
        prepared.unit = unit::near(transformed, precision);
        if unit::loses(prepared.unit, reached, precision) {
            let expected = "the samples that segments reach in the range of the precision";
            let found = format!("them up to {reached:.3e} beside others up to {largest:.3e}");
            let advice = "leave the large samples out with `--times`, or ask for spectra along time alone: `--only temporal`";
            return Err(Error::Unresolved(Fault::expected(expected, found, advice)));
        }
        if preparation.detrend_field_mean {
            prepared.field_mean = Some(prepared.mean(observer)?);
        }
        if preparation.detrend_space != Detrend::None {
            prepared.space_trends = prepared.fit_space(preparation.detrend_space, observer)?;
        }
        if preparation.detrend_time != Detrend::None {
            prepared.time_trends = prepared.fit_time(preparation.detrend_time, observer)?;
        }
        Ok((prepared, scans))
    }

    /// The largest magnitude of the first `reached` samples of all records, of which `largest` is
    /// that of all samples.
    fn largest_before(&self, reached: usize, largest: f64, observer: &dyn Observer) -> Result<f64> {
        let of = |samples: &[f64]| samples.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let mut profile = vec![0.0; self.n_sites()];
        let is_behind = (reached..self.n_times()).any(|n| {
            self.profiles(n..n + 1, &mut profile);
            of(&profile) >= largest
        });
        if !is_behind {
            return Ok(largest);
        }
        let before = self.each_record(observer, |_, record, _| of(&record[..reached]))?;
        Ok(of(&before))
    }

    pub fn n_times(&self) -> usize {
        self.times.len()
    }

    pub fn n_sites(&self) -> usize {
        self.sites.len()
    }

    /// Masses of the sites, where the field is a simulated run.
    pub fn masses(&self) -> Option<&[f64]> {
        let masses = self.field.masses.as_deref()?;
        masses.get(self.sites.clone())
    }

    /// Whether all samples that are transformed are 0.
    pub fn is_silent(&self) -> bool {
        self.is_silent
    }

    /// The amplitude that prepared samples count as 1.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// The samples of `site` that are masked, in order of time.
    pub fn masked(&self, site: usize) -> &[Gap] {
        if self.masked { self.gaps_of(site) } else { &[] }
    }

    /// The same, and those that were filled.
    pub fn gaps_of(&self, site: usize) -> &[Gap] {
        self.gaps_within(&(site..site + 1))
    }

    fn gaps_within(&self, sites: &Range<usize>) -> &[Gap] {
        let before = |end: usize| self.gaps.partition_point(|gap| gap.site < end);
        &self.gaps[before(sites.start)..before(sites.end)]
    }

    /// The record of one site.
    pub fn record(&self, site: usize, out: &mut [f64]) {
        let mut ahead = ReadAhead::default();
        let ahead = self.read_ahead(site..site + 1, &mut ahead);
        self.records(ahead, site..site + 1, out);
    }

    /// The first site without a finite sample at this time.
    pub fn gap_at(&self, time: usize) -> Option<usize> {
        let first = self.gaps_by_time.partition_point(|gap| gap.time < time);
        let gap = self.gaps_by_time.get(first)?;
        (gap.time == time).then_some(gap.site)
    }

    /// Lets go of the field's pages, where it is larger than memory.
    pub fn release_pages(&self) {
        if self.tiles.ahead.is_some() {
            self.field.release_pages();
        }
    }

    /// The same of the pages that hold profiles.
    pub fn release_times(&self, times: Range<usize>) {
        if self.tiles.ahead.is_some() {
            let in_field = within(&self.times, &times);
            self.field.release_block(in_field, self.sites.clone());
        }
    }

    /// Reads the raw records of `sites` into `room` in one pass over the file, so that a field
    /// larger than memory is not read again for every tile; `None` if the tiles read by themselves.
    pub fn read_ahead<'r>(
        &self,
        sites: Range<usize>,
        room: &'r mut ReadAhead,
    ) -> Option<&'r ReadAhead> {
        self.tiles.ahead?;
        let in_field = within(&self.sites, &sites);
        room.read(self.field, self.times.clone(), in_field, self.tiles.sites);
        Some(room)
    }

    /// Whole records of `sites`, one after the other, from `ahead` where they were read.
    pub fn records(&self, ahead: Option<&ReadAhead>, sites: Range<usize>, out: &mut [f64]) {
        match ahead {
            Some(ahead) => ahead.records(within(&self.sites, &sites), out),
            None => return self.piece(0..self.n_times(), sites, out),
        }
        self.prepare(0..self.n_times(), sites, true, out);
    }

    /// The records of `sites` at these times, one after the other.
    pub fn piece(&self, times: Range<usize>, sites: Range<usize>, out: &mut [f64]) {
        let at = (within(&self.times, &times), within(&self.sites, &sites));
        self.field.read_site_major(at.0, at.1, out);
        self.prepare(times, sites, true, out);
    }

    /// The records of `sites`, interleaved, from `ahead` if they were read ahead.
    pub fn columns(&self, ahead: Option<&ReadAhead>, sites: Range<usize>, out: &mut [f64]) {
        let (times, in_field) = (self.times.clone(), within(&self.sites, &sites));
        match ahead {
            Some(ahead) => ahead.columns(in_field, out),
            None => self.field.read_time_major(times, in_field, out),
        }
        self.prepare(0..self.n_times(), sites, false, out);
    }

    /// Whole profiles of `times`, one after the other.
    pub fn profiles(&self, times: Range<usize>, out: &mut [f64]) {
        let (in_field, sites) = (within(&self.times, &times), self.sites.clone());
        match self.tiles.ahead {
            Some(_) => self.field.read_releasing(in_field, sites, out),
            None => self.field.read_time_major(in_field, sites, out),
        }
        self.prepare(times, 0..self.n_sites(), false, out);
    }

    /// Prepares samples as they were read, records or profiles one after the other: replaces gaps, removes unit and trends; masks the
    /// gaps where that is asked.
    fn prepare(
        &self,
        times: Range<usize>,
        sites: Range<usize>,
        are_records: bool,
        out: &mut [f64],
    ) {
        let gaps = match sites.len() == self.n_sites() {
            true => {
                let before = |end: usize| self.gaps_by_time.partition_point(|gap| gap.time < end);
                &self.gaps_by_time[before(times.start)..before(times.end)]
            }
            false => self.gaps_within(&sites),
        };
        let (height, width) = (times.len(), sites.len());
        // From one time, and from one site, to the next.
        let (later, beside) = if are_records { (1, height) } else { (width, 1) };
        let place =
            |gap: &Gap| (gap.time - times.start) * later + (gap.site - sites.start) * beside;
        let gaps = gaps.iter().filter(|gap| times.contains(&gap.time));
        gaps.clone().for_each(|gap| out[place(gap)] = gap.value);
        if !self.is_as_stored() {
            let length = if are_records { height } else { width };
            for (i, line) in out.chunks_exact_mut(length).enumerate() {
                let (n, j) = if are_records { (0, i) } else { (i, 0) };
                self.settle((times.start + n, sites.start + j), are_records, line);
            }
        }
        if self.masked {
            gaps.for_each(|gap| out[place(gap)] = 0.0);
        }
        for j in sites.clone().filter(|j| self.is_left_out(*j)) {
            let record = out.iter_mut().skip((j - sites.start) * beside);
            record.step_by(later).take(height).for_each(|v| *v = 0.0);
        }
    }

    /// Removes unit and trends from samples along time or along space, the first at the time `n` and the site `j`.
    fn settle(&self, (n, j): (usize, usize), is_along_time: bool, samples: &mut [f64]) {
        if self.unit != 1.0 {
            samples.iter_mut().for_each(|v| *v /= self.unit);
        }
        if let Some(mean) = &self.field_mean {
            samples.iter_mut().for_each(|v| *v = mean.remove(*v, 0));
        }
        for (trends, own, place, is_along) in [
            (&self.space_trends, n, j, !is_along_time),
            (&self.time_trends, j, n, is_along_time),
        ] {
            let trends = trends.get(own..).unwrap_or_default();
            match trends.first().filter(|_| is_along) {
                Some(trend) => trend.remove_all(place, samples),
                None => {
                    for (v, trend) in samples.iter_mut().zip(trends) {
                        *v = trend.remove(*v, place);
                    }
                }
            }
        }
    }

    /// Whether the site is left out.
    pub fn is_left_out(&self, site: usize) -> bool {
        self.left_out.get(site) == Some(&true)
    }

    /// Whole snapshots of `times`: of the field where preparation does not change them, else prepared in `room`.
    pub fn snapshots<'s>(&'s self, times: Range<usize>, room: &'s mut [f64]) -> &'s [f64] {
        self.stored_profiles(times.clone()).unwrap_or_else(|| {
            self.profiles(times, room);
            room
        })
    }

    /// Whole snapshots of `times` as a slice of the field, if preparation does not change them.
    pub fn stored_profiles(&self, times: Range<usize>) -> Option<&[f64]> {
        let whole = self.sites == (0..self.field.n_sites());
        let stays = self.tiles.ahead.is_none();
        let unchanged = self.gaps.is_empty() && self.left_out.is_empty() && self.is_as_stored();
        let stored = || self.field.stored_profiles(within(&self.times, &times));
        (whole && stays && unchanged).then(stored).flatten()
    }

    /// Whether preparation leaves all samples but gaps unchanged.
    fn is_as_stored(&self) -> bool {
        self.unit == 1.0
            && self.field_mean.is_none()
            && self.space_trends.is_empty()
            && self.time_trends.is_empty()
    }

    /// Whether trends are fitted to a sample.
    fn is_kept(&self, time: usize, site: usize) -> bool {
        let place = |gap: &Gap| (gap.site, gap.time);
        let is_gap = || self.gaps.binary_search_by_key(&(site, time), place).is_ok();
        !(self.masked && is_gap())
    }

    fn mean(&self, observer: &dyn Observer) -> Result<Trend> {
        observer.stage("finding the mean", 2 * self.n_sites() as u64);
        let count = self.n_times() * self.n_sites() - if self.masked { self.gaps.len() } else { 0 };
        if count == 0 {
            return Ok(Trend::default());
        }
        let mean_less = |offset: f64| -> Result<f64> {
            let sums = self.each_record(observer, |j, record, values| {
                let kept = (0..record.len()).filter(|n| self.is_kept(*n, j));
                values.clear();
                values.extend(kept.map(|n| record[n] - offset));
                sum(values)
            })?;
            Ok(sum(&sums) / count as f64)
        };
        let high = mean_less(0.0)?;
        let low = mean_less(high)?;
        Ok(Trend {
            high,
            low,
            ..Trend::default()
        })
    }

    fn fit_time(&self, kind: Detrend, observer: &dyn Observer) -> Result<Vec<Trend>> {
        observer.stage("fitting trends along time", self.n_sites() as u64);
        self.each_record(observer, |j, record, scratch| {
            Trend::fit(record, kind, |n| self.is_kept(n, j), scratch)
        })
    }

    fn fit_space(&self, kind: Detrend, observer: &dyn Observer) -> Result<Vec<Trend>> {
        observer.stage("fitting trends along space", self.n_times() as u64);
        let n_sites = self.n_sites();
        in_parts(
            self.n_times(),
            self.tiles.times,
            observer,
            |times, block, scratch| {
                block.resize(times.len() * n_sites, 0.0);
                self.profiles(times.clone(), block);
                self.release_times(times.clone());
                let profiles = times.zip(block.chunks_exact(n_sites));
                let trends = profiles
                    .map(|(n, profile)| Trend::fit(profile, kind, |j| self.is_kept(n, j), scratch));
                Ok(trends.collect())
            },
        )
    }

    /// `sum_n v^2` of each site and `sum_j v^2` of each time, of the samples as prepared.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn energies(&self, observer: &dyn Observer) -> Result<(Vec<f64>, Vec<f64>)> {
        let (nt, nx) = (self.n_times(), self.n_sites());
        observer.stage("finding the reference", nt as u64);
        let energies = in_parts(nt, nt.div_ceil(PARTS), observer, |part, room, _| {
            let (mut sites, mut times) = (vec![0.0; nx], Vec::with_capacity(part.len()));
            for some in pieces(part.len(), self.tiles.times) {
                observer.go_on()?;
                let some = within(&part, &some);
                room.resize(some.len() * nx, 0.0);
                for profile in self.snapshots(some.clone(), room).chunks_exact(nx) {
                    let squares = sites.iter_mut().zip(profile);
                    squares.for_each(|(energy, v)| *energy += v * v);
                    times.push(sum_of_squares(profile));
                }
                self.release_times(some);
            }
            Ok(vec![(sites, times)])
        })?;
        let (mut sites, mut times) = (vec![0.0; nx], Vec::with_capacity(nt));
        for (part, energies) in energies {
            sites.iter_mut().zip(part).for_each(|(all, v)| *all += v);
            times.extend(energies);
        }
        self.release_pages();
        Ok((sites, times))
    }

    /// `look` at every record as prepared so far, in parallel; the results in order of sites.
    pub(crate) fn each_record<R: Send>(
        &self,
        observer: &dyn Observer,
        look: impl Fn(usize, &[f64], &mut Vec<f64>) -> R + Sync,
    ) -> Result<Vec<R>> {
        let seen = self.each_record_of(|_| true, observer, look)?;
        Ok(seen.into_iter().flatten().collect())
    }

    /// The same at the `wanted` records; `None` at others.
    pub(crate) fn each_record_of<R: Send>(
        &self,
        wanted: impl Fn(usize) -> bool + Sync,
        observer: &dyn Observer,
        look: impl Fn(usize, &[f64], &mut Vec<f64>) -> R + Sync,
    ) -> Result<Vec<Option<R>>> {
        let (n_times, n_sites) = (self.n_times(), self.n_sites());
        let mut all = Vec::with_capacity(n_sites);
        let mut room = ReadAhead::default();
        let has_wanted = |sites: &Range<usize>| sites.clone().any(&wanted);
        for sites in pieces(n_sites, self.tiles.ahead.unwrap_or(n_sites)) {
            let ahead = match has_wanted(&sites) {
                true => self.read_ahead(sites.clone(), &mut room),
                false => None,
            };
            let seen = in_parts(
                sites.len(),
                self.tiles.sites,
                observer,
                |part, tile, scratch| {
                    let sites = within(&sites, &part);
                    if !has_wanted(&sites) {
                        return Ok(sites.map(|_| None).collect());
                    }
                    tile.resize(sites.len() * n_times, 0.0);
                    self.records(ahead, sites.clone(), tile);
                    let records = sites.zip(tile.chunks_exact(n_times));
                    let seen =
                        records.map(|(j, record)| wanted(j).then(|| look(j, record, scratch)));
                    Ok(seen.collect())
                },
            );
            all.extend(seen?);
            self.release_pages();
        }
        Ok(all)
    }
}

/// Parts of the time axis whose sums are added; a fixed number, so that bits do not depend on threads.
const PARTS: usize = 8;

/// A part of a range, as one of what the range is of.
pub(super) fn within(range: &Range<usize>, part: &Range<usize>) -> Range<usize> {
    range.start + part.start..range.start + part.end
}

/// What `each` finds in parts of `0..all`, `length` each, in parallel; in their order. It has two vectors to work in.
fn in_parts<R: Send>(
    all: usize,
    length: usize,
    observer: &dyn Observer,
    each: impl Fn(Range<usize>, &mut Vec<f64>, &mut Vec<f64>) -> Result<Vec<R>> + Sync,
) -> Result<Vec<R>> {
    let parts: Vec<Range<usize>> = pieces(all, length).collect();
    let found: Result<Vec<Vec<R>>> = parts
        .into_par_iter()
        .map_init(Default::default, |(room, scratch), part| {
            observer.go_on()?;
            observer.advance(part.len() as u64);
            each(part, room, scratch)
        })
        .collect();
    Ok(found?.into_iter().flatten().collect())
}
