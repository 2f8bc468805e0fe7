//! The pass over the records of [`super::spectrum()`].

use num_complex::Complex;
use rayon::prelude::*;

use super::lines::{LINE_BLOCKS, Line, OFFSETS, TaperSums};
use super::noise::LeadIn;
use super::{LeftOutEach, SpectrumEstimate, SpectrumRequest};
use crate::error::Result;
use crate::estimates::FieldAxis;
use crate::estimates::parts::{Combined, Divided};
use crate::estimates::realisations::{
    Average, Grid, Independence, KeptSegments, Portion, Realisations, SegmentScratch, Shot, Shots,
    Sums, SumsShape, TOGETHER, Tile, Weights, WithoutOne,
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

pub(in crate::estimates) struct Pass<'a> {
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
pub(in crate::estimates) struct TileSums {
    /// Energies over segments and records, `[bin * tapers + taper]`, which are dropped once the average is known; then of
    /// each bin, see [`LINE_BLOCKS`].
    pub sums: Sums,
    pub(super) lead_ins: [LeadIn; TOGETHER],
    variance: [f64; TOGETHER],
    pub spectrum: Vec<LaneBlock>,
    pub shape: Vec<LaneBlock>,
    /// Of the jackknife: deviations of the logarithms, and their squares.
    pub deviations: Vec<LaneBlock>,
    pub squares: Vec<LaneBlock>,
}

impl TileSums {
    fn of(sums: Sums) -> TileSums {
        TileSums {
            sums,
            lead_ins: Default::default(),
            variance: [0.0; TOGETHER],
            spectrum: Vec::new(),
            shape: Vec::new(),
            deviations: Vec::new(),
            squares: Vec::new(),
        }
    }
}

#[derive(Default)]
struct Scratch {
    segments: SegmentScratch,
    tapers: Vec<TaperSums>,
    /// Realisations that are left out, and their energies.
    counts: Vec<LaneBlock>,
    left: Vec<LaneBlock>,
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
        let mut tiles = self.sum(shots, block, &whole, self.records == 1)?;
        if self.records > 1 {
            tiles.par_iter_mut().for_each(|tile| self.average(tile));
            left_out = self.what_is_left_out(&tiles);
            if self.request.has_jackknife {
                shots.each(block, |shot| {
                    shot.each_tile("jackknife", &mut tiles, |scratch, sites, records, tile| {
                        self.leave_out(scratch, shot, (sites, records), left_out, tile);
                    })
                })?;
            }
        }
        self.finish(tiles, left_out, true)
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
        std::array::from_fn(|lane| match tile.sums.left.get(lane) {
            Some(left) => left.segments().max(1.0),
            None => self.count(),
        })
    }

    /// The sums of every tile over these portions, or the averages of one record, which is read once.
    fn sum(
        &self,
        shots: &Shots<'_>,
        block: Option<usize>,
        portions: &[Portion],
        is_one: bool,
    ) -> Result<Vec<TileSums>> {
        shots.sum(
            ("spectra", block, shots.tiles()),
            portions,
            || TileSums::of(Sums::zeros(self.shape())),
            |_| (),
            |(shot, ()), scratch, sites, tile| {
                self.add(scratch, shot, sites.clone(), tile);
                if is_one {
                    self.average(tile);
                    self.leave_out(scratch, shot, sites, LeftOutEach::Realisation, tile);
                    self.drop_energies(tile);
                }
            },
        )
    }

    /// Adds the realisations of a portion of a shot.
    fn add(
        &self,
        scratch: &mut Scratch,
        shot: &Shot<'_>,
        (sites, records): Tile<'_>,
        tile: &mut TileSums,
    ) {
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        let is_whole = shot.portion.segments.len() == self.realisations.segments.count();
        let may_lead_in = is_whole && self.request.along == FieldAxis::Time;
        for (lane, site) in sites.clone().enumerate() {
            if may_lead_in && shot.missing(site).is_empty() {
                tile.lead_ins[lane].add(&records.record(lane));
            }
        }
        let lines = if self.tests_lines() { bins } else { 0 };
        scratch.tapers.clear();
        scratch.tapers.resize(lines, TaperSums::default());
        let (width, segments) = (sites.len(), (None, &mut scratch.segments));
        let add = |sums: &mut [LaneBlock], r: usize, spectra: &[Complex<f64>], has: &_| {
            let taper = r % tapers;
            let (energies, lines) = sums.split_at_mut(bins * tapers);
            add_powers((spectra, width), has, energies, (taper, tapers));
            let rows = spectra.chunks_exact(width);
            for (row, sums) in rows.zip(&mut scratch.tapers) {
                sums.add(&self.taper_transforms[taper], row);
            }
            if taper + 1 == tapers {
                for (within, sums) in scratch.tapers.iter_mut().zip(lines.as_chunks_mut().0) {
                    within.take_into(sums, &self.gains, has);
                }
            }
        };
        let sums = &mut tile.sums;
        shot.add(self.realisations, (sites, records), segments, sums, add);
    }

    /// The average of all realisations.
    fn average(&self, tile: &mut TileSums) {
        let bins = self.realisations.bins();
        let count = self.counts(tile);
        let energies = self.energies(&tile.sums);
        let length = self.realisations.segments.length;
        let cells = energies.chunks_exact(self.weights.tapers()).enumerate();
        let cells = cells.map(|(m, energies)| (fold(m, length), energies));
        let energy = self.weights.energy(cells);
        // Mean square of the samples; 1 for still sites.
        tile.variance = std::array::from_fn(|lane| match energy[lane] > 0.0 {
            true => energy[lane] / (length as f64 * count[lane]),
            false => 1.0,
        });
        tile.spectrum = vec![LaneBlock::default(); bins];
        tile.shape = vec![LaneBlock::default(); bins];
        widest(Average {
            weights: &self.weights,
            energies,
            count,
            variance: tile.variance,
            spectrum: &mut tile.spectrum,
            shape: &mut tile.shape,
        });
    }

    fn energies<'s>(&self, sums: &'s Sums) -> &'s [LaneBlock] {
        &sums.plain[..self.realisations.bins() * self.weights.tapers()]
    }

    /// Leaves the sums of lines.
    fn drop_energies(&self, tile: &mut TileSums) {
        let count = self.energies(&tile.sums).len();
        tile.sums.plain = tile.sums.plain.split_off(count);
    }

    /// Adds what each of a shot's realisations, or the shot, changes if it is left out.
    fn leave_out(
        &self,
        scratch: &mut Scratch,
        shot: &Shot<'_>,
        (sites, records): Tile<'_>,
        left_out: LeftOutEach,
        tile: &mut TileSums,
    ) {
        if !self.request.has_jackknife || self.count() * self.weights.tapers() as f64 <= 1.0 {
            return;
        }
        let (width, count) = (sites.len(), self.counts(tile));
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        let kept = shot.kept(sites, self.realisations.segments);
        if tile.deviations.is_empty() {
            tile.deviations = vec![LaneBlock::default(); bins];
            tile.squares = vec![LaneBlock::default(); bins];
        }
        let mut without = |left_out: (&[LaneBlock], &[LaneBlock])| {
            widest(WithoutOne {
                average: &self.weights,
                energies: self.energies(&tile.sums),
                count,
                variance: tile.variance,
                spectrum: &tile.spectrum,
                left_out,
                sum: &mut tile.deviations,
                squares: &mut tile.squares,
            });
        };
        let Scratch {
            segments,
            counts,
            left,
            ..
        } = scratch;
        let zero = LaneBlock::default();
        for (blocks, count) in [(&mut *counts, tapers), (&mut *left, bins * tapers)] {
            blocks.clear();
            blocks.resize(count, zero);
        }
        let is_record = left_out == LeftOutEach::Record;
        self.realisations.each(records, segments, |r, spectra| {
            let (taper, has) = (r % tapers, KeptSegments::has_each(&kept, r / tapers));
            add_powers((spectra, width), &has, left, (taper, tapers));
            counts[taper].add(has);
            if !is_record {
                without((&counts[..], &left[..]));
                counts[taper] = zero;
                let of_taper = left.iter_mut().skip(taper).step_by(tapers);
                of_taper.for_each(|block| *block = zero);
            }
        });
        if is_record {
            without((&counts[..], &left[..]));
        }
    }

    pub fn steadiness(&self, tiles: &[TileSums], site: usize) -> f64 {
        tiles[site / TOGETHER].sums.steadiness(site) / self.records as f64
    }

    /// What filled samples leave at a site, of the mean record.
    pub fn filled(&self, tiles: &[TileSums], site: usize) -> [f64; 2] {
        let filled = tiles[site / TOGETHER].sums.filled(site);
        filled.map(|sum| sum / self.records as f64)
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

/// Adds the powers of so many sites, each times 1 or 0, to the sums of one of the tapers.
fn add_powers(
    (spectra, width): (&[Complex<f64>], usize),
    has: &[f64; TOGETHER],
    sums: &mut [LaneBlock],
    (taper, tapers): (usize, usize),
) {
    let rows = spectra.chunks_exact(width);
    for (row, sums) in rows.zip(sums.chunks_exact_mut(tapers)) {
        let powers = row.iter().zip(has).map(|(x, has)| has * x.norm_sqr());
        sums[taper].add(powers);
    }
}

impl Divided for Pass<'_> {
    /// Blocks of each taper, and of lines.
    fn shape(&self) -> SumsShape {
        let of_lines = if self.tests_lines() { LINE_BLOCKS } else { 0 };
        let of_bin = self.weights.tapers() + of_lines;
        self.realisations.shape(self.realisations.bins() * of_bin)
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

    fn sums(&self, shots: &Shots<'_>, portions: &[Portion]) -> Result<Vec<Sums>> {
        let held = self.held(shots.longest, true);
        let block = shots.block("the spectra of this part", held)?;
        let tiles = self.sum(shots, block, portions, false)?;
        Ok(tiles.into_iter().map(|tile| tile.sums).collect())
    }

    fn combine(&self, sums: Vec<Sums>) -> Result<Combined> {
        let of_sums = |sums| {
            let mut tile = TileSums::of(sums);
            self.average(&mut tile);
            self.drop_energies(&mut tile);
            tile
        };
        let tiles: Vec<TileSums> = sums.into_par_iter().map(of_sums).collect();
        let left_out = match self.records {
            1 => LeftOutEach::Realisation,
            _ => self.what_is_left_out(&tiles),
        };
        let found = self.finish(tiles, left_out, false)?;
        Ok(Combined::Spectrum(Box::new(found)))
    }
}
