//! The prepared field: any block of it, on demand.

use std::ops::Range;

use rayon::prelude::*;

use super::read_ahead::{ReadAhead, parts};
use super::scan::{ChannelScan, Gap};
use super::trend::Trend;
use super::unit::PowerOfTwo;
use super::{Detrend, Gaps, Preparation};
use crate::error::{Error, Result};
use crate::field::Field;
use crate::numeric::{sum, sum_of_squares};
use crate::observer::Observer;

/// A field with its range, gaps, scale and trends settled; see the [module](super) documentation.
pub(crate) struct Prepared<'a> {
    pub(super) field: &'a Field,
    pub(super) times: Range<usize>,
    pub(super) sites: Range<usize>,
    /// Amplitudes are divided by this power of two, so that their squares stay in range.
    unit: PowerOfTwo,
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
    /// [`Error::NonFinite`] for gaps if they are refused; [`Error::Cancelled`].
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
            unit: PowerOfTwo::ONE,
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
        (prepared.unit, prepared.is_silent) = prepared.unit_of(&scans, preparation, observer)?;

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

    /// The unit of what is transformed, and whether that is 0 everywhere. Samples that no segment reaches do not count, unless they are
    /// transformed along space.
    ///
    /// # Errors
    /// [`Error::Range`] if samples that segments reach vanish in it; [`Error::Cancelled`].
    fn unit_of(
        &self,
        scans: &[ChannelScan],
        preparation: Preparation<'_>,
        observer: &dyn Observer,
    ) -> Result<(PowerOfTwo, bool)> {
        let precision = preparation.precision;
        let largest = scans.iter().fold(0.0, |m: f64, s| m.max(s.largest));
        let reached = self.largest_before(preparation.reached, largest, observer)?;
        let transformed = match preparation.transforms_all {
            true => largest,
            false => reached,
        };
        let unit = PowerOfTwo::near(transformed, precision);
        match unit.loses(reached, precision) {
            true => Err(Error::Range { reached, largest }),
            false => Ok((unit, transformed == 0.0)),
        }
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

    /// The last site of the file that is struck or driven, where the field is a simulated run.
    pub fn struck(&self) -> Option<usize> {
        self.field.struck
    }

    /// Masses of the sites, where the field is a simulated run.
    pub fn masses(&self) -> Option<&[f64]> {
        let masses = self.field.masses.as_deref()?;
        masses.get(self.sites.clone())
    }

    /// Sites of the whole field.
    pub fn sites_in_file(&self) -> usize {
        self.field.n_sites()
    }

    /// Whether all samples that are transformed are 0.
    pub fn is_silent(&self) -> bool {
        self.is_silent
    }

    /// The amplitude that prepared samples count as 1.
    pub fn unit(&self) -> f64 {
        self.unit.value()
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
        let n_times = self.n_times();
        let (times, in_field) = (self.times.clone(), within(&self.sites, &sites));
        match ahead {
            Some(ahead) => ahead.records(in_field, out),
            None => self.field.read_site_major(times, in_field, out),
        }
        let gaps = self.gaps_within(&sites).iter();
        let gaps = gaps.map(|g| ((g.site - sites.start) * n_times + g.time, g.value));
        self.around_gaps(gaps, out, |out| {
            for (j, record) in sites.clone().zip(out.chunks_exact_mut(n_times)) {
                self.unit.divide(record);
                if let Some(mean) = &self.field_mean {
                    record.iter_mut().for_each(|v| *v = mean.remove(*v, 0));
                }
                for (v, trend) in record.iter_mut().zip(&self.space_trends) {
                    *v = trend.remove(*v, j);
                }
                if let Some(trend) = self.time_trends.get(j) {
                    trend.remove_all(record);
                }
                if self.is_left_out(j) {
                    record.fill(0.0);
                }
            }
        });
    }

    /// The records of `sites` at these times, one after the other; those of fields whose trends along time are
    /// left in place.
    pub fn piece(&self, times: Range<usize>, sites: Range<usize>, out: &mut [f64]) {
        let at = (within(&self.times, &times), within(&self.sites, &sites));
        self.field.read_site_major(at.0, at.1, out);
        let gaps = self.gaps_within(&sites).iter();
        let gaps = gaps.filter(|gap| times.contains(&gap.time)).map(|gap| {
            let at = (gap.site - sites.start) * times.len() + gap.time - times.start;
            (at, gap.value)
        });
        self.around_gaps(gaps, out, |out| self.unit.divide(out));
    }

    /// The records of `sites`, interleaved, from `ahead` if they were read ahead.
    pub fn columns(&self, ahead: Option<&ReadAhead>, sites: Range<usize>, out: &mut [f64]) {
        let (times, in_field) = (self.times.clone(), within(&self.sites, &sites));
        match ahead {
            Some(ahead) => ahead.columns(in_field, out),
            None => self.field.read_time_major(times, in_field, out),
        }
        self.prepare_rows((0, sites.clone()), self.gaps_within(&sites), out);
    }

    /// Whole profiles of `times`, one after the other.
    pub fn profiles(&self, times: Range<usize>, out: &mut [f64]) {
        let (in_field, sites) = (within(&self.times, &times), self.sites.clone());
        match self.tiles.ahead {
            Some(_) => self.field.read_releasing(in_field, sites, out),
            None => self.field.read_time_major(in_field, sites, out),
        }
        let before = |end: usize| self.gaps_by_time.partition_point(|gap| gap.time < end);
        let gaps = &self.gaps_by_time[before(times.start)..before(times.end)];
        self.prepare_rows((times.start, 0..self.n_sites()), gaps, out);
    }

    /// Prepares rows of `sites` as they were read, from the time `first` on, with these gaps.
    fn prepare_rows(&self, (first, sites): (usize, Range<usize>), gaps: &[Gap], out: &mut [f64]) {
        let (from, width) = (sites.start, sites.len());
        let place = |g: &Gap| ((g.time - first) * width + g.site - from, g.value);
        self.around_gaps(gaps.iter().map(place), out, |out| {
            if !self.is_as_stored() {
                for (n, row) in (first..).zip(out.chunks_exact_mut(width)) {
                    self.settle(n, from, row);
                }
            }
        });
        for j in sites.filter(|j| self.is_left_out(*j)) {
            let column = out.iter_mut().skip(j - from).step_by(width);
            column.for_each(|v| *v = 0.0);
        }
    }

    /// Replaces gaps, then prepares the samples; masks the gaps where that is asked.
    fn around_gaps(
        &self,
        gaps: impl Iterator<Item = (usize, f64)> + Clone,
        out: &mut [f64],
        prepare: impl FnOnce(&mut [f64]),
    ) {
        gaps.clone().for_each(|(at, value)| out[at] = value);
        prepare(out);
        if self.masked {
            gaps.for_each(|(at, _)| out[at] = 0.0);
        }
    }

    /// Whether the site is left out.
    pub fn is_left_out(&self, site: usize) -> bool {
        self.left_out.get(site) == Some(&true)
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
        self.unit == PowerOfTwo::ONE
            && self.field_mean.is_none()
            && self.space_trends.is_empty()
            && self.time_trends.is_empty()
    }

    /// Removes unit and trends from the samples of time `n` from site `first` on.
    fn settle(&self, n: usize, first: usize, samples: &mut [f64]) {
        self.unit.divide(samples);
        if let Some(mean) = &self.field_mean {
            samples.iter_mut().for_each(|v| *v = mean.remove(*v, 0));
        }
        if let Some(trend) = self.space_trends.get(n) {
            for (j, v) in samples.iter_mut().enumerate() {
                *v = trend.remove(*v, first + j);
            }
        }
        for (v, trend) in samples.iter_mut().zip(self.time_trends.iter().skip(first)) {
            *v = trend.remove(*v, n);
        }
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
        let (n_times, n_sites) = (self.n_times(), self.n_sites());
        in_parts(
            0..n_times,
            self.tiles.times,
            observer,
            |times, block, scratch| {
                block.resize(times.len() * n_sites, 0.0);
                self.profiles(times.clone(), block);
                self.release_times(times.clone());
                let profiles = times.zip(block.chunks_exact(n_sites));
                let trends = profiles
                    .map(|(n, profile)| Trend::fit(profile, kind, |j| self.is_kept(n, j), scratch));
                trends.collect()
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
        let parts_of_all: Vec<Range<usize>> = parts(0..nt, nt.div_ceil(PARTS)).collect();
        let energies: Result<Vec<(Vec<f64>, Vec<f64>)>> = parts_of_all
            .into_par_iter()
            .map(|part| {
                let (mut sites, mut times) = (vec![0.0; nx], Vec::with_capacity(part.len()));
                let mut room = Vec::new();
                for some in parts(part, self.tiles.times) {
                    observer.go_on()?;
                    let profiles = match self.stored_profiles(some.clone()) {
                        Some(stored) => stored,
                        None => {
                            room.resize(some.len() * nx, 0.0);
                            self.profiles(some.clone(), &mut room);
                            &room
                        }
                    };
                    for profile in profiles.chunks_exact(nx) {
                        let squares = sites.iter_mut().zip(profile);
                        squares.for_each(|(energy, v)| *energy += v * v);
                        times.push(sum_of_squares(profile));
                    }
                    self.release_times(some.clone());
                    observer.advance(some.len() as u64);
                }
                Ok((sites, times))
            })
            .collect();
        let (mut sites, mut times) = (vec![0.0; nx], Vec::with_capacity(nt));
        for (part, energies) in energies? {
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
        for sites in parts(0..n_sites, self.tiles.ahead.unwrap_or(n_sites)) {
            if !sites.clone().any(&wanted) {
                observer.advance(sites.len() as u64);
                all.extend(sites.map(|_| None));
                continue;
            }
            let ahead = self.read_ahead(sites.clone(), &mut room);
            let seen = in_parts(sites, self.tiles.sites, observer, |sites, tile, scratch| {
                if !sites.clone().any(&wanted) {
                    return sites.map(|_| None).collect();
                }
                tile.resize(sites.len() * n_times, 0.0);
                self.records(ahead, sites.clone(), tile);
                let records = sites.zip(tile.chunks_exact(n_times));
                records
                    .map(|(j, record)| wanted(j).then(|| look(j, record, scratch)))
                    .collect()
            });
            all.extend(seen?);
            self.release_pages();
        }
        Ok(all)
    }
}

/// Parts of the time axis whose sums are added; a fixed number, so that bits do not depend on threads.
const PARTS: usize = 8;

/// A part of a range, as one of what the range is of.
fn within(range: &Range<usize>, part: &Range<usize>) -> Range<usize> {
    range.start + part.start..range.start + part.end
}

/// What `each` finds in parts of `all`, `length` each, in parallel; in their order. It has two vectors to work in.
fn in_parts<R: Send>(
    all: Range<usize>,
    length: usize,
    observer: &dyn Observer,
    each: impl Fn(Range<usize>, &mut Vec<f64>, &mut Vec<f64>) -> Vec<R> + Sync,
) -> Result<Vec<R>> {
    let parts: Vec<Range<usize>> = parts(all, length).collect();
    let found: Result<Vec<Vec<R>>> = parts
        .into_par_iter()
        .map_init(Default::default, |(room, scratch), part| {
            observer.go_on()?;
            observer.advance(part.len() as u64);
            Ok(each(part, room, scratch))
        })
        .collect();
    Ok(found?.into_iter().flatten().collect())
}
