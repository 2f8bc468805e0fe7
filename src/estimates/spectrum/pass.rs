//! The pass over the records of [`super::spectrum()`].

use std::ops::Range;

use num_complex::Complex;
use rayon::prelude::*;

use super::lines::{LINE_BLOCKS, Line, OFFSETS, TaperSums};
use super::noise::LeadIn;
use super::{LeftOutEach, SpectrumAxis, SpectrumEstimate, SpectrumRequest};
use crate::error::Result;
use crate::estimates::parts::{Combined, Divided};
use crate::estimates::realisations::{
    Average, Grid, Independence, LeftOut, Portion, Realisations, Records, SegmentPairs,
    SegmentScratch, Shot, Shots, Sums, SumsShape, TOGETHER, Weights, WithoutOne,
};
use crate::numeric::lanes::{LaneBlock, widest};
use crate::transform::fold;

/// Bytes of a site, and of a bin, beside the spectra.
const OF_SITE: u64 = 256;
const OF_BIN: u64 = 64;
/// Numbers of a cell of a site: spectrum, degrees, both ends of the interval, jackknife, for which the sums give way.
const NUMBERS: u64 = 5;
/// Those of lines with their lists.
const OF_LINES: u64 = 7;

pub(super) struct Pass<'a> {
    pub request: &'a SpectrumRequest,
    pub realisations: &'a Realisations,
    pub grid: &'a Grid,
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
    /// Of each bin, see [`LINE_BLOCKS`].
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

/// The records of a few sites.
type Sites<'r> = (&'r Range<usize>, Records<'r>);

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
        grid: &'a Grid,
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
        let held = self.held(shots.longest, false);
        let block = shots.block("the spectra of this field", held)?;
        let whole = self.realisations.whole_records(self.records);
        let mut left_out = LeftOutEach::Realisation;
        let (unit, mut tiles) = self.sum(shots, block, &whole, self.records == 1)?;
        if self.records > 1 {
            tiles.par_iter_mut().for_each(|tile| self.average(tile));
            left_out = self.what_is_left_out(&tiles);
            if self.request.has_jackknife {
                shots.each(block, |shot| {
                    shot.each_tile("jackknife", &mut tiles, |scratch, sites, records, tile| {
                        self.leave_out(scratch, shot, (&sites, records), left_out, tile);
                    })
                })?;
            }
        }
        self.finish(tiles, left_out, (unit, true))
    }

    /// Bytes that are needed beside the samples, of which so many of a record are read; of a part, or of all.
    fn held(&self, samples: usize, is_part: bool) -> u64 {
        let (samples, bins) = (samples as u64, self.realisations.bins() as u64);
        let sites = self.grid.sites.next_multiple_of(TOGETHER) as u64;
        let (threads, together) = (self.grid.threads(), TOGETHER as u64);
        let transform = self.realisations.working_bytes();
        let energies = 8 * bins * self.weights.tapers() as u64;
        // Of a site.
        let sums = self.shape().bytes() / together;
        let scratch = together * (16 * samples + 2 * energies + 48 * bins + sums);
        // In the sums and in the results.
        let cells = 8 * bins * (NUMBERS + if self.tests_lines() { OF_LINES } else { 0 });
        let kept = match (is_part, self.records) {
            (false, 1) => cells,
            (false, _) => cells + sums,
            (true, _) => 2 * sums,
        };
        sites * kept + threads * (scratch + transform)
    }

    /// Whether there is a test for lines.
    pub fn tests_lines(&self) -> bool {
        self.weights.tapers() > 1
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

    /// The sums of every tile over these portions, or the averages of one record, which is read once; and the unit of the samples.
    fn sum(
        &self,
        shots: &Shots<'_>,
        block: Option<usize>,
        portions: &[Portion],
        is_one: bool,
    ) -> Result<(f64, Vec<TileSums>)> {
        let mut tiles = Vec::new();
        tiles.resize_with(shots.tiles(), TileSums::default);
        let unit = shots.each_portion(block, portions, |shot, portion| {
            shot.each_tile("spectra", &mut tiles, |scratch, sites, records, tile| {
                self.add(scratch, (shot, portion), (&sites, records), tile);
                if is_one {
                    self.average(tile);
                    let left_out = LeftOutEach::Realisation;
                    self.leave_out(scratch, shot, (&sites, records), left_out, tile);
                    tile.energies = Vec::new();
                }
            })
        })?;
        Ok((unit, tiles))
    }

    /// Adds the realisations of a portion of a shot.
    fn add(
        &self,
        scratch: &mut Scratch,
        (shot, portion): (&Shot<'_>, &Portion),
        (sites, records): Sites<'_>,
        tile: &mut TileSums,
    ) {
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        let squared = shot.scale * shot.scale;
        let kept = shot.kept(sites.clone(), self.realisations.segments);
        kept.add_to(&mut tile.left, self.realisations.distances());
        let may_lead_in = portion.is_whole && self.request.along == SpectrumAxis::Time;
        for (lane, site) in sites.clone().enumerate() {
            tile.filled[lane] += squared * shot.left_by_filling(site, || records.record(lane));
            if may_lead_in && shot.missing(site).is_empty() {
                records.copy(lane, 0..records.length(), &mut scratch.record);
                tile.lead_ins[lane].add(&scratch.record, squared);
            }
        }
        let lines = if self.tests_lines() { bins } else { 0 };
        scratch.tapers.clear();
        scratch.tapers.resize(lines, TaperSums::default());
        let sums = tile.sums.get_or_insert_with(|| Sums::zeros(self.shape()));
        let (of, of_sites) = ((shot, portion), (sites.clone(), records));
        let room = &mut scratch.deviations;
        self.realisations.add_steadiness(of, of_sites, room, sums);
        let visit = |r: usize, spectra: &[Complex<f64>]| {
            let (taper, squared) = (r % tapers, kept.has(r / tapers).map(|has| has * squared));
            let (energies, lines) = sums.plain_mut().split_at_mut(bins * tapers);
            add_powers((spectra, sites.len()), &squared, energies, (taper, tapers));
            let rows = spectra.chunks_exact(sites.len());
            for (row, sums) in rows.zip(&mut scratch.tapers) {
                sums.add(&self.taper_transforms[taper], row);
            }
            if taper + 1 == tapers {
                for (within, sums) in scratch.tapers.iter_mut().zip(lines.as_chunks_mut().0) {
                    within.take_into(sums, &self.gains, &squared);
                }
            }
        };
        let segments = &mut scratch.segments;
        self.realisations.each_of(portion, records, segments, visit);
    }

    /// The average of all realisations.
    fn average(&self, tile: &mut TileSums) {
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        let zeros = || Sums::zeros(self.shape());
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
        shot: &Shot<'_>,
        (sites, records): Sites<'_>,
        left_out: LeftOutEach,
        tile: &mut TileSums,
    ) {
        if !self.request.has_jackknife || self.count() * self.weights.tapers() as f64 <= 1.0 {
            return;
        }
        let (width, count) = (sites.len(), self.counts(tile));
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        let squared = shot.scale * shot.scale;
        let kept = shot.kept(sites.clone(), self.realisations.segments);
        if tile.deviations.is_empty() {
            tile.deviations = vec![LaneBlock::default(); bins];
            tile.squares = vec![LaneBlock::default(); bins];
        }
        let mut without = |left_out: LeftOut<'_>| {
            widest(WithoutOne {
                average: &self.weights,
                energies: &tile.energies,
                count,
                variance: tile.variance,
                spectrum: &tile.spectrum,
                left_out,
                sum: &mut tile.deviations,
                squares: &mut tile.squares,
            });
        };
        let Scratch { segments, left, .. } = scratch;
        let is_record = left_out == LeftOutEach::Record;
        let blocks = if is_record { bins * tapers } else { bins };
        left.clear();
        left.resize(blocks, LaneBlock::default());
        self.realisations.each(records, segments, |r, spectra| {
            let (taper, squared) = (r % tapers, kept.has(r / tapers).map(|has| has * squared));
            if is_record {
                add_powers((spectra, width), &squared, left, (taper, tapers));
                return;
            }
            if squared[..width].iter().all(|squared| *squared == 0.0) {
                return;
            }
            left.fill(LaneBlock::default());
            add_powers((spectra, width), &squared, left, (0, 1));
            let has = squared.map(|squared| f64::from(squared > 0.0));
            without(LeftOut::Realisation(taper, has, left));
        });
        if is_record {
            let all = self.realisations.segments.count();
            without(LeftOut::Record(kept.counts(all), left));
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
        self.realisations
            .independence(self.records, None, steadiness)
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

/// Adds the powers of so many sites, times what squares of each are multiplied by, to the sums of one of the tapers.
fn add_powers(
    (spectra, width): (&[Complex<f64>], usize),
    squared: &[f64; TOGETHER],
    sums: &mut [LaneBlock],
    (taper, tapers): (usize, usize),
) {
    let rows = spectra.chunks_exact(width);
    for (row, sums) in rows.zip(sums.chunks_exact_mut(tapers)) {
        let sums = sums[taper].0.iter_mut().zip(squared);
        for (x, (sum, squared)) in row.iter().zip(sums) {
            *sum += squared * x.norm_sqr();
        }
    }
}

impl Divided for Pass<'_> {
    /// Blocks of each taper, and of lines.
    fn shape(&self) -> SumsShape {
        let of_lines = if self.tests_lines() { LINE_BLOCKS } else { 0 };
        SumsShape {
            plain: self.realisations.bins() * (self.weights.tapers() + of_lines),
            pieces: self.realisations.pieces(),
        }
    }

    fn result_bytes(&self) -> u64 {
        let bins = self.realisations.bins() as u64;
        let sites = (self.grid.sites as u64).saturating_add(TOGETHER as u64 - 1);
        // Spectrum, shape, lines; spectrum, degrees, ends of two intervals, statistic.
        let (blocks, arrays) = match self.tests_lines() {
            true => (2 + LINE_BLOCKS as u64, 6),
            false => (2, 5),
        };
        // If there is a line in every band of the tapers: a list that grows to twice of what it holds, and what it was before.
        let of_lines = match self.request.averaging.tapers.half_bandwidth() {
            Some(nw) => 3 * size_of::<Line>() as u64 / (nw.ceil() as u64 + 1),
            None => 0,
        };
        let of_site = bins * (8 * (arrays + blocks) + of_lines) + OF_SITE;
        of_site.saturating_mul(sites).saturating_add(OF_BIN * bins)
    }

    fn sums(&self, shots: &Shots<'_>, portions: &[Portion]) -> Result<(f64, Vec<Sums>)> {
        let held = self.held(shots.longest, true);
        let block = shots.block("the spectra of this part", held)?;
        let (unit, tiles) = self.sum(shots, block, portions, false)?;
        let sums = tiles.into_iter().filter_map(|tile| tile.sums);
        Ok((unit, sums.collect()))
    }

    fn combine(&self, sums: Vec<Sums>, unit: f64) -> Result<Combined> {
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
        let found = self.finish(tiles, left_out, (unit, false))?;
        Ok(Combined::Spectrum(Box::new(found)))
    }
}
