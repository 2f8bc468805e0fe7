//! The pass over the records of [`super::spectrum()`].

use std::ops::Range;

use num_complex::Complex;
use rayon::prelude::*;

use super::lines::{OFFSETS, TaperSums};
use super::memory::{shape, tests_lines};
use super::noise::LeadIn;
use super::{LeftOutEach, SpectrumAxis, SpectrumEstimate, SpectrumRequest};
use crate::error::Result;
use crate::estimates::realisations::{
    Average, Grid, Independence, KeptSegments, LeftOut, Portion, Realisations, Records,
    SegmentPairs, SegmentScratch, Shot, Shots, Sums, TOGETHER, Weights, WithoutOne,
};
use crate::numeric::lanes::{LaneBlock, widest};
use crate::prepare::{Detrend, Gaps};
use crate::transform::{RecordTransform, Segments, fold};

/// Numbers of a cell of a site: spectrum, degrees, both ends of the interval, jackknife, for which the sums give way; and both
/// ends of its interval, which are written.
const NUMBERS: u64 = 7;
/// Those of lines with their lists.
const OF_LINES: u64 = 7;

pub(super) struct Pass<'a> {
    pub request: &'a SpectrumRequest,
    pub realisations: &'a Realisations,
    pub grid: Grid,
    /// Records of a site.
    pub records: usize,
    pub weights: Weights,
    /// Transforms of the tapers at the offsets of lines, and the sums of their squares.
    taper_transforms: Vec<[Complex<f64>; OFFSETS.len()]>,
    pub gains: [f64; OFFSETS.len()],
    /// Effective realisations of one record over the number of tapers.
    pub effective_segments: f64,
}

/// Sums of a few sites; a block a bin, and a site a lane.
#[derive(Default)]
pub(super) struct TileSums {
    sums: Option<Sums>,
    /// Over segments and records, `[bin * tapers + taper]`; dropped once the average is known.
    energies: Vec<LaneBlock>,
    /// Of each bin, see [`LINE_BLOCKS`](super::lines::LINE_BLOCKS).
    pub lines: Vec<LaneBlock>,
    /// Of all records.
    steadiness: [f64; TOGETHER],
    /// Of each site, where segments with missing samples are left out; else empty.
    pub left: Vec<SegmentPairs>,
    pub lead_ins: [LeadIn; TOGETHER],
    /// White power that filled samples leave, of all records.
    filled: [f64; TOGETHER],
    variance: [f64; TOGETHER],
    pub spectrum: Vec<LaneBlock>,
    pub shape: Vec<LaneBlock>,
    /// Of the jackknife: deviations of the logarithms, and their squares.
    pub deviations: Vec<LaneBlock>,
    pub squares: Vec<LaneBlock>,
}

/// A few sites of one shot.
struct SiteShot {
    width: usize,
    scale: f64,
    /// Where segments with missing samples are left out: those of each site, and the times of the samples.
    kept: Vec<KeptSegments>,
    missing: Vec<Vec<usize>>,
    /// Where segments are left out, by the samples that are there.
    steadiness: Option<[f64; TOGETHER]>,
    mark: [f64; TOGETHER],
    filled: [f64; TOGETHER],
}

impl SiteShot {
    fn new(
        shot: &Shot<'_>,
        (sites, records): (Range<usize>, Records<'_>),
        (segments, about_mean): (Segments, bool),
    ) -> SiteShot {
        let kept = sites.clone().map_while(|site| shot.kept(site, segments));
        let kept: Vec<KeptSegments> = kept.collect();
        let steadiness = || shot.steadiness(sites.clone(), records, about_mean);
        SiteShot {
            width: sites.len(),
            scale: shot.scale,
            steadiness: (!kept.is_empty()).then(steadiness),
            kept,
            missing: sites.clone().map(|site| shot.missing(site)).collect(),
            mark: shot.mark(sites.clone()),
            filled: std::array::from_fn(|lane| match sites.clone().nth(lane) {
                Some(site) if shot.has_filled(site) => {
                    shot.left_by_filling(site, &records.record(lane)) * shot.scale.powi(2)
                }
                _ => 0.0,
            }),
        }
    }

    /// What squares of transforms of a segment are multiplied by: 0 where it is left out.
    fn squared(&self, segment: usize) -> [f64; TOGETHER] {
        let squared = self.scale * self.scale;
        std::array::from_fn(|lane| match self.kept.get(lane) {
            Some(kept) if !kept.has(segment) => 0.0,
            _ => squared,
        })
    }

    /// Segments of each site.
    fn segments(&self, all: usize) -> [f64; TOGETHER] {
        std::array::from_fn(|lane| match self.kept.get(lane) {
            Some(kept) => kept.count() as f64,
            None => all as f64,
        })
    }
}

#[derive(Default)]
struct Scratch {
    segments: SegmentScratch,
    record: Vec<f64>,
    tapers: Vec<TaperSums>,
    left: Vec<LaneBlock>,
    deviations: Vec<f64>,
}

impl<'a> Pass<'a> {
    pub fn new(
        request: &'a SpectrumRequest,
        realisations: &'a Realisations,
        grid: Grid,
        records: usize,
    ) -> Self {
        let taper_transforms = realisations.taper_transforms(&OFFSETS);
        let gain = |d: usize| -> f64 { taper_transforms.iter().map(|u| u[d].norm_sqr()).sum() };
        Pass {
            gains: std::array::from_fn(gain),
            request,
            realisations,
            grid,
            records,
            weights: Weights::new(&realisations.concentrations, request.is_adaptive),
            taper_transforms,
            effective_segments: realisations.effective() / realisations.tapers() as f64,
        }
    }

    pub fn run(&self, shots: &Shots<'_>) -> Result<SpectrumEstimate> {
        let held = self.held(shots.longest(), false);
        let block = shots.block("the spectra of this field", held)?;
        let whole: Vec<Portion> = (0..self.records)
            .map(|record| self.realisations.whole(record))
            .collect();
        let mut tiles = Vec::new();
        tiles.resize_with(shots.tiles(), TileSums::default);
        let mut left_out = LeftOutEach::Realisation;
        let unit = if self.records == 1 {
            shots.each_portion(block, &whole, |shot, portion| {
                let visit = |scratch: &mut Scratch,
                             sites: Range<usize>,
                             records: Records<'_>,
                             tile: &mut TileSums| {
                    let of = self.site_shot(shot, (sites, records));
                    self.add(scratch, &of, (portion, records), tile);
                    self.average(tile);
                    self.leave_out(scratch, &of, records, left_out, tile);
                    tile.energies = Vec::new();
                };
                shot.each_tile("spectra", &mut tiles, visit)
            })?
        } else {
            let unit = self.sum(shots, block, &whole, &mut tiles)?;
            tiles.par_iter_mut().for_each(|tile| self.average(tile));
            left_out = self.what_is_left_out(&tiles);
            if self.request.has_jackknife {
                shots.each(block, |shot| {
                    let visit = |scratch: &mut Scratch,
                                 sites: Range<usize>,
                                 records: Records<'_>,
                                 tile: &mut TileSums| {
                        let of = self.site_shot(shot, (sites, records));
                        self.leave_out(scratch, &of, records, left_out, tile);
                    };
                    shot.each_tile("jackknife", &mut tiles, visit)
                })?;
            }
            unit
        };
        self.finish(tiles, left_out, (unit, true))
    }

    /// The sums of every tile over these portions, and the unit of the samples.
    pub fn sums(&self, shots: &Shots<'_>, portions: &[Portion]) -> Result<(f64, Vec<Sums>)> {
        let held = self.held(shots.longest(), true);
        let block = shots.block("the spectra of this part", held)?;
        let mut tiles = Vec::new();
        tiles.resize_with(shots.tiles(), TileSums::default);
        let unit = self.sum(shots, block, portions, &mut tiles)?;
        let sums = tiles.into_iter().filter_map(|tile| tile.sums);
        Ok((unit, sums.collect()))
    }

    /// The spectra of the sums of all parts.
    pub fn combine(&self, sums: Vec<Sums>, unit: f64) -> Result<SpectrumEstimate> {
        let of_sums = |sums| {
            let mut tile = TileSums {
                sums: Some(sums),
                ..TileSums::default()
            };
            self.average(&mut tile);
            tile.energies = Vec::new();
            tile
        };
        let tiles: Vec<TileSums> = sums.into_par_iter().map(of_sums).collect();
        let left_out = match self.records {
            1 => LeftOutEach::Realisation,
            _ => self.what_is_left_out(&tiles),
        };
        self.finish(tiles, left_out, (unit, false))
    }

    /// Bytes that are needed beside the samples, of of which so many of a record are read; of a part, or of all.
    fn held(&self, samples: usize, is_part: bool) -> u64 {
        let (samples, bins) = (samples as u64, self.realisations.bins() as u64);
        let sites = self.grid.sites.next_multiple_of(TOGETHER) as u64;
        let length = self.realisations.segments.length;
        // Those that have a tile.
        let tiles = self.grid.sites.div_ceil(TOGETHER);
        let threads = tiles.min(rayon::current_num_threads()) as u64;
        let together = TOGETHER as u64;
        let transform = RecordTransform::<f64>::working_bytes(length, length, TOGETHER);
        let energies = 8 * bins * self.weights.tapers() as u64;
        // Of a site.
        let sums = shape(self.realisations).bytes() / together;
        let scratch = together * (16 * samples + 2 * energies + 48 * bins + sums);
        let kept = match (is_part, self.records) {
            (false, 1) => bins * self.bytes_of_cell(),
            (false, _) => bins * self.bytes_of_cell() + sums,
            (true, _) => 2 * sums,
        };
        sites * kept + threads * (scratch + transform)
    }

    /// Bytes of a cell of a site in the sums and in the results.
    fn bytes_of_cell(&self) -> u64 {
        let lines = if self.tests_lines() { OF_LINES } else { 0 };
        8 * (NUMBERS + lines)
    }

    /// Whether an offset is not what moves.
    pub fn about_mean(&self) -> bool {
        self.request.averaging.detrend != Detrend::None
    }

    /// Whether there is a test for lines.
    pub fn tests_lines(&self) -> bool {
        tests_lines(self.realisations)
    }

    /// Realisations of each taper, at sites without missing samples.
    pub fn count(&self) -> f64 {
        (self.realisations.segments.count() * self.records) as f64
    }

    /// Realisations of each taper at the sites of a tile; at least 1, so that nothing is divided by 0.
    pub fn counts(&self, tile: &TileSums) -> [f64; TOGETHER] {
        std::array::from_fn(|lane| match tile.left.get(lane) {
            Some(left) => left.segments().max(1.0),
            None => self.count(),
        })
    }

    fn sum(
        &self,
        shots: &Shots<'_>,
        block: Option<usize>,
        portions: &[Portion],
        tiles: &mut [TileSums],
    ) -> Result<f64> {
        shots.each_portion(block, portions, |shot, portion| {
            let visit = |scratch: &mut Scratch,
                         sites: Range<usize>,
                         records: Records<'_>,
                         tile: &mut TileSums| {
                let of = self.site_shot(shot, (sites, records));
                self.add(scratch, &of, (portion, records), tile);
            };
            shot.each_tile("spectra", tiles, visit)
        })
    }

    fn site_shot(&self, shot: &Shot<'_>, sites: (Range<usize>, Records<'_>)) -> SiteShot {
        SiteShot::new(shot, sites, (self.realisations.segments, self.about_mean()))
    }

    /// Adds the realisations of a portion of a shot.
    fn add(
        &self,
        scratch: &mut Scratch,
        of: &SiteShot,
        (portion, records): (&Portion, Records<'_>),
        tile: &mut TileSums,
    ) {
        let width = of.width;
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        let leaves_out = self.request.gaps == Gaps::LeaveOut;
        let filled = tile.filled.iter_mut().zip(of.filled);
        filled.for_each(|(sum, one)| *sum += one);
        if leaves_out {
            tile.left.resize_with(width, SegmentPairs::default);
            let distances = self.realisations.distances();
            let sites = tile.left.iter_mut().zip(&of.kept);
            sites.for_each(|(left, kept)| left.add(kept, distances));
        }
        if portion.is_whole && self.request.along == SpectrumAxis::Time {
            for (lane, lead_in) in tile.lead_ins.iter_mut().enumerate().take(width) {
                if of.missing.get(lane).is_none_or(Vec::is_empty) {
                    records.copy(lane, 0..records.length(), &mut scratch.record);
                    lead_in.add(&scratch.record, of.scale * of.scale);
                }
            }
        }
        let lines = if self.tests_lines() { bins } else { 0 };
        scratch.tapers.clear();
        scratch.tapers.resize(lines, TaperSums::default());
        let Scratch {
            segments,
            deviations,
            tapers: within,
            ..
        } = scratch;
        let sums = tile
            .sums
            .get_or_insert_with(|| Sums::zeros(shape(self.realisations)));
        if let Some(steadiness) = of.steadiness {
            sums.add_record(steadiness);
        }
        let visit = |r: usize, spectra: &[Complex<f64>]| {
            let (segment, taper) = (r / tapers, r % tapers);
            let squared = of.squared(segment);
            if taper == 0 && !leaves_out {
                let pieces = (portion, segment, records, of.scale);
                self.realisations
                    .add_pieces(pieces, of.mark, deviations, sums);
            }
            let (energies, lines) = sums.plain_mut().split_at_mut(bins * tapers);
            let rows = spectra.chunks_exact(width);
            for (row, sums) in rows.clone().zip(energies.chunks_exact_mut(tapers)) {
                let sums = sums[taper].0.iter_mut().zip(&squared);
                for (x, (sum, squared)) in row.iter().zip(sums) {
                    *sum += squared * x.norm_sqr();
                }
            }
            for (row, sums) in rows.zip(within.iter_mut()) {
                sums.add(&self.taper_transforms[taper], row);
            }
            if taper + 1 == tapers {
                for (within, sums) in within.iter_mut().zip(lines.as_chunks_mut().0) {
                    within.take_into(sums, &self.gains, &squared);
                }
            }
        };
        self.realisations.each_of(portion, records, segments, visit);
        sums.close(self.realisations.reached(), self.about_mean());
    }

    /// The average of all realisations.
    fn average(&self, tile: &mut TileSums) {
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        let zeros = || Sums::zeros(shape(self.realisations));
        let total = tile.sums.take().unwrap_or_else(zeros);
        tile.steadiness = total.steadiness();
        tile.energies = total.into_plain();
        tile.lines = tile.energies.split_off(bins * tapers);
        let count = self.counts(tile);
        tile.variance = self.variance(&tile.energies, &count);
        tile.spectrum = vec![LaneBlock::default(); bins];
        tile.shape = vec![LaneBlock::default(); bins];
        debug_assert_eq!(tile.energies.len(), bins * tapers);
        widest(Average {
            weights: &self.weights,
            energies: &tile.energies,
            count,
            variance: tile.variance,
            spectrum: &mut tile.spectrum,
            shape: &mut tile.shape,
        });
    }

    /// Mean square of the tapered samples, tapers weighted by the squares of their concentrations; 1 for
    /// still sites.
    fn variance(&self, energies: &[LaneBlock], count: &[f64; TOGETHER]) -> [f64; TOGETHER] {
        let length = self.realisations.segments.length;
        let concentrations = &self.realisations.concentrations;
        let mut sums = [0.0; TOGETHER];
        for (m, energies) in energies.chunks_exact(concentrations.len()).enumerate() {
            for (energy, concentration) in energies.iter().zip(concentrations) {
                let weight = fold(m, length) * concentration * concentration;
                for (sum, energy) in sums.iter_mut().zip(energy.0) {
                    *sum += weight * energy;
                }
            }
        }
        let weights: f64 = concentrations.iter().map(|c| c * c).sum();
        let all = |lane: usize| weights * length as f64 * count[lane];
        std::array::from_fn(|lane| match sums[lane] > 0.0 {
            true => sums[lane] / all(lane),
            false => 1.0,
        })
    }

    /// Adds what each of a shot's realisations, or the shot, changes if it is left out.
    fn leave_out(
        &self,
        scratch: &mut Scratch,
        of: &SiteShot,
        records: Records<'_>,
        left_out: LeftOutEach,
        tile: &mut TileSums,
    ) {
        if !self.request.has_jackknife || self.count() * self.weights.tapers() as f64 <= 1.0 {
            return;
        }
        let (width, count) = (of.width, self.counts(tile));
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        if tile.deviations.is_empty() {
            tile.deviations = vec![LaneBlock::default(); bins];
            tile.squares = vec![LaneBlock::default(); bins];
        }
        let Scratch { segments, left, .. } = scratch;
        let (energies, spectrum, variance) = (&tile.energies, &tile.spectrum, tile.variance);
        let (deviations, squares) = (&mut tile.deviations, &mut tile.squares);
        let mut without = |left_out: LeftOut<'_>| {
            widest(WithoutOne {
                average: &self.weights,
                energies,
                count,
                variance,
                spectrum,
                left_out,
                sum: deviations,
                squares,
            });
        };
        left.clear();
        match left_out {
            LeftOutEach::Realisation => {
                left.resize(bins, LaneBlock::default());
                self.realisations.each(records, segments, |r, spectra| {
                    let squared = of.squared(r / tapers);
                    if squared[..width].iter().all(|squared| *squared == 0.0) {
                        return;
                    }
                    for (row, left) in spectra.chunks_exact(width).zip(left.iter_mut()) {
                        let left = left.0.iter_mut().zip(&squared);
                        for (x, (left, squared)) in row.iter().zip(left) {
                            *left = squared * x.norm_sqr();
                        }
                    }
                    let has = squared.map(|squared| f64::from(squared > 0.0));
                    without(LeftOut::Realisation(r % tapers, has, left));
                });
            }
            LeftOutEach::Record => {
                left.resize(bins * tapers, LaneBlock::default());
                self.realisations.each(records, segments, |r, spectra| {
                    let squared = of.squared(r / tapers);
                    let rows = spectra.chunks_exact(width);
                    for (row, left) in rows.zip(left.chunks_exact_mut(tapers)) {
                        let left = left[r % tapers].0.iter_mut().zip(&squared);
                        for (x, (left, squared)) in row.iter().zip(left) {
                            *left += squared * x.norm_sqr();
                        }
                    }
                });
                let all = self.realisations.segments.count();
                without(LeftOut::Record(of.segments(all), left));
            }
        }
    }

    pub fn steadiness(&self, tiles: &[TileSums], site: usize) -> f64 {
        let sum = tiles[site / TOGETHER].steadiness[site % TOGETHER];
        sum / self.records as f64
    }

    /// Mean square of the white noise that filled samples leave at a site.
    pub fn filled(&self, tiles: &[TileSums], site: usize) -> f64 {
        tiles[site / TOGETHER].filled[site % TOGETHER] / self.records as f64
    }

    pub fn independence(&self, steadiness: f64) -> Independence {
        self.independence_of(
            self.realisations.segments.count(),
            self.realisations.effective(),
            steadiness,
        )
    }

    pub fn independence_of(
        &self,
        segments: usize,
        effective: f64,
        steadiness: f64,
    ) -> Independence {
        let counts = [self.records, segments, self.weights.tapers()];
        Independence::new(counts, effective, steadiness)
            .of_samples(self.realisations.segments.record)
    }

    fn what_is_left_out(&self, tiles: &[TileSums]) -> LeftOutEach {
        let sites = self.grid.sites;
        let is_transient = |j: &usize| self.independence(self.steadiness(tiles, *j)).is_transient();
        match 2 * (0..sites).filter(is_transient).count() > sites {
            true => LeftOutEach::Record,
            false => LeftOutEach::Realisation,
        }
    }
}
