//! Repeated records of the same sites, read a few sites at a time in the memory allowed.

use std::ops::Range;

use num_complex::Complex;
use rayon::prelude::*;

use super::averaging::{Realisations, SegmentScratch, no_segment_left};
use super::ensemble::steadiness_without;
use super::kept::{KeptSegments, SegmentPairs};
use super::part::Portion;
use super::records::{Records, interleave};
use super::sums::Sums;
use crate::arrays::Precision;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::numeric::lanes::{LaneBlock, on_lines};
use crate::observer::Observer;
use crate::prepare::{Detrend, Gaps, Preparation, Prepared, ReadAhead, Tiles};
use crate::system::check_memory;
use crate::system::memory::half_of_free_memory;
use crate::transform::Segments;

/// Sites that are read and transformed together: a tile.
pub(crate) const TOGETHER: usize = 8;

/// Share of a record's samples that may be filled: more, and intervals do not hold.
pub(crate) const FILLED: f64 = 0.05;

/// Fields with the same axes, one record of every site each.
pub(crate) struct Shots<'a> {
    fields: &'a [&'a Field],
    first: &'a Field,
    gaps: Gaps,
    /// The samples of each record that the fields hold.
    held: Range<usize>,
    /// Samples of a record.
    record: usize,
    /// Samples of a record that are used.
    reached: usize,
    /// Samples of a record that are read at once.
    pub longest: usize,
    /// Bytes of working memory.
    pub memory: u64,
    pub observer: &'a dyn Observer,
}

/// Amplitudes from and up to which fourth powers of transforms are numbers.
const AMPLITUDES: &str =
    "amplitudes from 1e-60 to 1e60, whose fourth powers are numbers: another unit";

/// One of the [`Shots`], open for reading.
pub(crate) struct Shot<'s> {
    /// What is read of it.
    pub portion: Portion,
    prepared: Prepared<'s>,
    block: Option<usize>,
    shots: &'s Shots<'s>,
}

/// Sites that are next to one another, and their records.
pub(crate) type Tile<'r> = (Range<usize>, Records<'r>);

impl<'a> Shots<'a> {
    /// `memory`: bytes of working memory, by default half of the free memory. `reached`: samples of a
    /// record that are used.
    ///
    /// # Errors
    /// [`Error::Request`] for no field, and for fields with different axes.
    pub fn new(
        fields: &'a [&'a Field],
        gaps: Gaps,
        memory: Option<u64>,
        reached: usize,
        observer: &'a dyn Observer,
    ) -> Result<Self> {
        let first = first_of(fields)?;
        Ok(Shots {
            fields,
            first,
            gaps,
            held: 0..first.n_times(),
            record: first.n_times(),
            reached,
            longest: first.n_times(),
            memory: memory.unwrap_or_else(half_of_free_memory),
            observer,
        })
    }

    pub fn count(&self) -> usize {
        self.fields.len()
    }

    /// The same for [`Self::each_portion`] of these, of fields that hold the samples of records of `record` samples from the one at
    /// `first` on.
    #[must_use]
    pub fn in_portions(self, portions: &[Portion], first: usize, record: usize) -> Self {
        let lengths = portions.iter().map(|portion| portion.samples.len());
        Shots {
            held: first..first + self.first.n_times(),
            record,
            longest: lengths.max().unwrap_or(0),
            ..self
        }
    }

    /// Tiles of all sites.
    pub fn tiles(&self) -> usize {
        self.first.n_sites().div_ceil(TOGETHER)
    }

    /// Sites that are read at once, where `held` bytes are needed beside the samples, those of all threads
    /// included; `None` for a field that fits into memory as it is.
    ///
    /// # Errors
    /// [`Error::Memory`], of `what`.
    pub fn block(&self, what: &'static str, held: u64) -> Result<Option<usize>> {
        let (samples, sites) = (self.longest as u64, self.first.n_sites() as u64);
        let least = held + 8 * samples * TOGETHER as u64;
        check_memory(what, least, Some(self.memory))?;
        let left = self.memory - held;
        if 8 * samples * sites <= left.min(self.memory / 4) {
            return Ok(None);
        }
        let sites = (left / (8 * samples)) as usize;
        Ok(Some((sites / TOGETHER * TOGETHER).max(TOGETHER)))
    }

    /// Visits all shots in their order, with the blocks that [`Self::block`] found.
    ///
    /// # Errors
    /// [`Error::NonFinite`]; [`Error::Cancelled`]; [`Error::Request`] for amplitudes whose fourth powers are no numbers; those of `visit`.
    pub fn each(
        &self,
        block: Option<usize>,
        visit: impl FnMut(&Shot<'_>) -> Result<()>,
    ) -> Result<()> {
        let whole = |record| Portion {
            record,
            segments: 0..0,
            samples: self.held.clone(),
        };
        let whole: Vec<Portion> = (0..self.count()).map(whole).collect();
        self.each_portion(block, &whole, visit)
    }

    /// Visits portions of the shots in their order, whose samples alone are read.
    ///
    /// # Errors
    /// Those of [`Self::each`]; [`Error::Request`] for interpolated gaps that reach into another portion.
    pub fn each_portion(
        &self,
        block: Option<usize>,
        portions: &[Portion],
        mut visit: impl FnMut(&Shot<'_>) -> Result<()>,
    ) -> Result<()> {
        for portion in portions {
            let prepared = self.prepared(portion.record, portion.samples.clone(), block)?;
            let shot = Shot {
                portion: portion.clone(),
                prepared,
                block,
                shots: self,
            };
            self.check_cuts(&shot)?;
            visit(&shot)?;
        }
        Ok(())
    }

    /// What the first `tiles` of sites add up to over portions of the shots, from `zeros` on. `before`: what all tiles of a
    /// portion need; `add` adds a tile.
    ///
    /// # Errors
    /// Those of [`Self::each_portion`].
    pub fn sum<T: Send, C: Sync, S: Default>(
        &self,
        (stage, block, tiles): (&'static str, Option<usize>, usize),
        portions: &[Portion],
        zeros: impl Fn() -> T + Sync,
        mut before: impl FnMut(&Shot<'_>) -> C,
        add: impl Fn((&Shot<'_>, &C), &mut S, Tile<'_>, &mut T) + Sync,
    ) -> Result<Vec<T>> {
        let mut all: Vec<Option<T>> = Vec::new();
        all.resize_with(tiles, || None);
        self.each_portion(block, portions, |shot| {
            let before = before(shot);
            shot.each_tile(stage, &mut all, |scratch, sites, records, tile| {
                let sums = tile.get_or_insert_with(&zeros);
                add((shot, &before), scratch, (sites, records), sums);
            })
        })?;
        Ok(all.into_iter().flatten().collect())
    }

    /// That no gap at the ends of a portion was filled from one side alone.
    fn check_cuts(&self, shot: &Shot<'_>) -> Result<()> {
        let Range { start, end } = shot.portion.samples;
        let ends = [
            (start > 0).then_some(start),
            (end < self.record).then(|| end - 1),
        ];
        let gap = |time: usize| Some((time, shot.prepared.gap_at(time - start)?));
        match ends.into_iter().flatten().find_map(gap) {
            Some((time, site)) if self.gaps == Gaps::Interpolate => {
                let expected = "finite samples where this part ends, since it reads no others: other parts, or \
                                gaps that are masked";
                let name = &self.fields[shot.portion.record].name;
                let found = format!("none at time row {time}, site {site} of {name}");
                Err(Error::request("gaps", expected, found))
            }
            _ => Ok(()),
        }
    }

    /// Of all segments those in which no sample of the sites is missing in any shot, `lag` samples later at each of them;
    /// all where missing samples are no reason to leave segments out.
    ///
    /// # Errors
    /// [`Error::Request`] where none is left; [`Error::Cancelled`]; [`Error::Memory`].
    pub fn keeping(&self, mut all: Realisations, sites: &[(usize, usize)]) -> Result<Realisations> {
        let segments = all.segments;
        if self.gaps != Gaps::LeaveOut {
            return Ok(all);
        }
        for record in 0..self.count() {
            let prepared = self.prepared(record, self.held.clone(), None)?;
            for (site, lag) in sites {
                let missing = prepared.masked(*site).iter();
                let missing = missing.filter_map(|gap| gap.time.checked_sub(*lag));
                all.kept = all.kept.and(&KeptSegments::without(segments, missing));
            }
        }
        match all.kept.count() {
            0 => Err(no_segment_left(segments.length)),
            _ => Ok(all),
        }
    }

    /// These samples of a record, which are `times` behind its beginning.
    fn prepared(
        &self,
        record: usize,
        times: Range<usize>,
        block: Option<usize>,
    ) -> Result<Prepared<'a>> {
        let field: &'a Field = self.fields[record];
        let preparation = Preparation {
            gaps: self.gaps,
            masks_by_mean: true,
            left_out: &[],
            precision: Precision::F64,
            reached: self.reached.min(times.end) - times.start,
            transforms_all: false,
            detrend_field_mean: false,
            detrend_space: Detrend::None,
            detrend_time: Detrend::None,
        };
        let tiles = Tiles {
            sites: TOGETHER,
            times: 32,
            ahead: block,
            memory: self.memory / 4,
        };
        let sites = 0..field.n_sites();
        let before = self.held.start;
        let rows = times.start - before..times.end - before;
        let prepared = Prepared::new(field, rows, sites, preparation, tiles, self.observer);
        let (prepared, _) = prepared.map_err(|error| error.later(before))?;
        let found = format!("amplitudes near {:.0e}", prepared.unit());
        Error::require(prepared.unit() == 1.0, "field", AMPLITUDES, found)?;
        Ok(prepared)
    }
}

impl Shot<'_> {
    /// Whether segments with missing samples are left out.
    pub fn leaves_out(&self) -> bool {
        self.shots.gaps == Gaps::LeaveOut
    }

    /// Times of a site's missing samples, where segments that hold them are left out.
    pub fn missing(&self, site: usize) -> Vec<usize> {
        let missing = self.prepared.masked(site).iter();
        let missing = missing.filter(|_| self.leaves_out());
        missing.map(|gap| gap.time).collect()
    }

    /// Of up to eight sites, NaN where so many samples were filled or masked that statistics of the record do not hold,
    /// else 0: added to sums, it marks them.
    pub fn mark(&self, sites: impl IntoIterator<Item = usize>) -> [f64; TOGETHER] {
        let mut marks = [0.0; TOGETHER];
        let most = (FILLED * self.prepared.n_times() as f64) as usize;
        for (mark, site) in marks.iter_mut().zip(sites) {
            if !self.leaves_out() && self.prepared.gaps_of(site).len() > most {
                *mark = f64::NAN;
            }
        }
        marks
    }

    /// Adds what the records of up to eight sites are like: how steady, by the samples that are there, and what filling leaves.
    pub fn look_at(
        &self,
        (sites, records): (impl Iterator<Item = usize> + Clone, Records<'_>),
        room: &mut Vec<f64>,
        sums: &mut Sums,
    ) {
        let portion = &self.portion;
        // Of the record, of which this may be a part.
        let part = records.length() as f64 / sums.shape.segments.record as f64;
        for (lane, site) in sites.clone().enumerate() {
            let left = self.left_by_filling(site, || records.record(lane));
            sums.add_filled(lane, left.map(|left| part * left));
        }
        if !self.leaves_out() {
            let mark = self.mark(sites);
            let segments = (portion.record, portion.segments.clone());
            return sums.add_samples(segments, records, mark, room);
        }
        // Without a site, 1.
        let mut found = [1.0; TOGETHER];
        for (lane, (found, site)) in found.iter_mut().zip(sites).enumerate() {
            let (missing, mut record) = (self.missing(site), records.record(lane));
            missing.iter().for_each(|n| record[*n] = 0.0);
            *found = steadiness_without(&record, &missing, sums.shape.about_mean);
        }
        sums.add_record(found);
    }

    /// Adds the realisations of a tile, and what its records are like. `add`: what a realisation of this number with these
    /// spectra, `[bin * width + site]`, adds to the blocks of the estimate, times 1 for each site, or 0 where it does not count.
    /// `beside`: a site without whose segments the others have none, either.
    pub fn add(
        &self,
        realisations: &Realisations,
        (sites, records): Tile<'_>,
        (beside, scratch): (Option<&KeptSegments>, &mut SegmentScratch),
        sums: &mut Sums,
        mut add: impl FnMut(&mut [LaneBlock], usize, &[Complex<f64>], &[f64; TOGETHER]),
    ) {
        let mut kept = self.kept(sites.clone(), realisations.segments);
        if let Some(beside) = beside {
            kept.iter_mut().for_each(|kept| *kept = kept.and(beside));
        }
        sums.left.resize_with(kept.len(), SegmentPairs::default);
        for (sums, kept) in sums.left.iter_mut().zip(&kept) {
            sums.add(kept.pairs(realisations.distances()));
        }
        self.look_at((sites, records), &mut scratch.numbers, sums);
        let visit = |r: usize, spectra: &[Complex<f64>]| {
            let has = KeptSegments::has_each(&kept, r / realisations.tapers());
            add(&mut sums.plain, r, spectra, &has);
        };
        realisations.each_of(&self.portion, records, scratch, visit);
    }

    /// White power that filled samples leave in the record of a site, as a mean square: their share times that of the
    /// error, which is what the same would have left of samples that are known. Masked ones have the mean of the record;
    /// of interpolated ones, gaps of their mean length are made at all others. Beside it the share of the power that is lost: of
    /// masked samples twice their share, as transforms lose it.
    fn left_by_filling(&self, site: usize, record: impl FnOnce() -> Vec<f64>) -> [f64; 2] {
        let gaps = self.prepared.gaps_of(site);
        if self.leaves_out() || gaps.is_empty() {
            return [0.0; 2];
        }
        let record = record();
        let runs = gaps.chunk_by(|a, b| a.time + 1 == b.time).count();
        let reach = (gaps.len() / runs).div_ceil(2).max(1);
        let mean = record.iter().sum::<f64>() / record.len() as f64;
        let share = gaps.len() as f64 / record.len() as f64;
        let (squares, lost): (f64, f64) = match self.shots.gaps {
            Gaps::Interpolate => {
                let around = record.windows(2 * reach + 1);
                let apart = around.map(|v| v[reach] - 0.5 * (v[0] + v[2 * reach]));
                (apart.map(|e| e * e).sum(), 0.0)
            }
            _ => (record.iter().map(|v| (v - mean).powi(2)).sum(), 2.0 * share),
        };
        [share * squares / record.len() as f64, lost]
    }

    /// The segments without missing samples of each of these sites; none where no segments are left out.
    pub fn kept(&self, sites: Range<usize>, segments: Segments) -> Vec<KeptSegments> {
        let sites = sites.filter(|_| self.leaves_out());
        sites
            .map(|site| KeptSegments::without(segments, self.missing(site)))
            .collect()
    }

    /// The record of a site.
    pub fn record(&self, site: usize) -> Vec<f64> {
        let mut record = vec![0.0; self.prepared.n_times()];
        self.prepared.record(site, &mut record);
        record
    }

    /// Part of the records of neighbouring sites, interleaved.
    pub fn piece(
        &self,
        times: Range<usize>,
        sites: Range<usize>,
        (room, rows): (&mut Vec<f64>, &mut Vec<f64>),
    ) {
        room.resize(times.len() * sites.len(), 0.0);
        self.prepared.piece(times.clone(), sites, room);
        interleave(room, times.len(), rows);
    }

    /// Samples at these times are not read again soon.
    pub fn release(&self, times: Range<usize>) {
        self.prepared.release_times(times);
    }

    /// Visits the first tiles in parallel, as many as there are results: its scratch, its sites, their records interleaved, its result.
    /// A result is visited by one thread, so its bits depend neither on threads nor on blocks.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn each_tile<S: Default, T: Send>(
        &self,
        stage: &'static str,
        results: &mut [T],
        visit: impl Fn(&mut S, Range<usize>, Records<'_>, &mut T) + Sync,
    ) -> Result<()> {
        let n_sites = self.prepared.n_sites().min(results.len() * TOGETHER);
        if n_sites == 0 {
            return Ok(());
        }
        let observer = self.shots.observer;
        observer.stage(stage, n_sites as u64);
        let block = self.block.unwrap_or(n_sites);
        let mut space = ReadAhead::default();
        for from in (0..n_sites).step_by(block) {
            let sites = from..n_sites.min(from + block);
            let ahead = self.prepared.read_ahead(sites.clone(), &mut space);
            let tiles = from / TOGETHER..sites.end.div_ceil(TOGETHER);
            let of_tile =
                |(room, scratch): &mut (Vec<f64>, S), (i, result): (usize, &mut T)| -> Result<()> {
                    observer.go_on()?;
                    let first = from + i * TOGETHER;
                    let sites = first..sites.end.min(first + TOGETHER);
                    let width = sites.len();
                    let samples = on_lines(room, width * self.prepared.n_times());
                    self.prepared.columns(ahead, sites.clone(), samples);
                    observer.advance(width as u64);
                    visit(scratch, sites, Records::interleaved(samples, width), result);
                    Ok(())
                };
            let results = results[tiles].par_iter_mut().enumerate();
            results.try_for_each_init(Default::default, of_tile)?;
            self.prepared.release_pages();
        }
        Ok(())
    }
}

/// # Errors
/// [`Error::Request`] where segments with missing samples would be left out, of an estimate `what` that cannot.
pub(crate) fn refuse_left_out(gaps: Gaps, what: &str) -> Result<()> {
    let expected = format!("refuse, interpolate or mask: {what} needs samples without gaps");
    Error::require(gaps != Gaps::LeaveOut, "gaps", expected, "leave-out")
}

/// # Errors
/// [`Error::Request`] for a significance that is no probability.
pub(crate) fn check_significance(alpha: f64) -> Result<()> {
    let expected = "a probability between 0 and 1";
    Error::require(alpha > 0.0 && alpha < 1.0, "significance", expected, alpha)
}

/// What is expected of the index of a site.
pub(crate) fn a_site(n_sites: usize) -> String {
    format!("a site from 0 to {}", n_sites.saturating_sub(1))
}

/// The first of the fields, whose axes all have.
///
/// # Errors
/// [`Error::Request`].
pub(crate) fn first_of<'a>(fields: &[&'a Field]) -> Result<&'a Field> {
    let Some((first, others)) = fields.split_first() else {
        return Err(Error::request("field", "at least one field", "none"));
    };
    first.check_axes()?;
    let axes = |field: &Field| {
        let (time, space) = (&field.time, &field.space);
        let steps = (time.step, space.origin, space.step);
        let words = (time.unit.clone(), space.unit.clone(), field.unit.clone());
        ((field.n_times(), field.n_sites()), steps, words)
    };
    let Some(other) = others.iter().find(|other| axes(other) != axes(first)) else {
        return Ok(first);
    };
    let of = |field: &Field| format!("{} times by {} sites", field.n_times(), field.n_sites());
    let expected = format!("fields with the axes of {}, {}", first.name, of(first));
    let found = format!("{} in {}, or another step or unit", of(other), other.name);
    Err(Error::request("field", expected, found))
}
