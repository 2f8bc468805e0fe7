//! The pass over the records of [`super::spectrum()`].

use std::ops::Range;

use num_complex::Complex;
use rayon::prelude::*;

use super::adaptive::{Average, LeftOut, Weights, WithoutOne};
use super::lines::{LINE_BLOCKS, OFFSETS, TaperSums};
use super::{LeftOutEach, SpectrumEstimate, SpectrumRequest};
use crate::error::Result;
use crate::estimates::realisations::{
    Grid, Portion, Realisations, RecordTree, SegmentScratch, SegmentTree, Shots, Sums, TOGETHER,
    TreeNode, held_at_once,
};
use crate::numeric::lanes::{LaneBlock, widest};
use crate::prepare::Detrend;
use crate::transform::{RecordTransform, fold};

/// Bytes of a cell of a site in the sums and in the results.
const HELD: u64 = 8 * (4 + 5 + 7);

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
    tree: RecordTree,
    /// Over segments and records, `[bin * tapers + taper]`; dropped once the average is known.
    energies: Vec<LaneBlock>,
    /// Of each bin, see [`LINE_BLOCKS`].
    pub lines: Vec<LaneBlock>,
    /// Of all records.
    pub steadiness: [f64; TOGETHER],
    variance: [f64; TOGETHER],
    pub spectrum: Vec<LaneBlock>,
    pub shape: Vec<LaneBlock>,
    /// Of the jackknife: deviations of the logarithms, and their squares.
    pub deviations: Vec<LaneBlock>,
    pub squares: Vec<LaneBlock>,
}

#[derive(Default)]
struct Scratch {
    segments: SegmentScratch,
    deviations: Vec<f64>,
    tapers: Vec<TaperSums>,
    left: Vec<LaneBlock>,
    tree: SegmentTree,
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
        let block = shots.block("the spectra of this field", self.held(true))?;
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
                             samples: &[f64],
                             tile: &mut TileSums| {
                    self.add(scratch, portion, sites.len(), samples, shot.scale, tile);
                    self.average(tile);
                    self.leave_out(scratch, sites.len(), samples, shot.scale, left_out, tile);
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
                    let visit =
                        |scratch: &mut Scratch,
                         sites: Range<usize>,
                         samples: &[f64],
                         tile: &mut TileSums| {
                            let width = sites.len();
                            self.leave_out(scratch, width, samples, shot.scale, left_out, tile);
                        };
                    shot.each_tile("jackknife", &mut tiles, visit)
                })?;
            }
            unit
        };
        Ok(self.finish(&tiles, left_out, unit))
    }

    /// The nodes of every tile over these portions, and the unit of the samples.
    pub fn partial(
        &self,
        shots: &Shots<'_>,
        portions: &[Portion],
    ) -> Result<(f64, Vec<Vec<TreeNode>>)> {
        let block = shots.block("the spectra of this part", self.held(false))?;
        let mut tiles = Vec::new();
        tiles.resize_with(shots.tiles(), TileSums::default);
        let unit = self.sum(shots, block, portions, &mut tiles)?;
        let nodes = tiles.into_iter().map(|tile| tile.tree.into_nodes());
        Ok((unit, nodes.collect()))
    }

    /// The spectra of the sums of all parts.
    pub fn combine(&self, trees: Vec<RecordTree>, unit: f64) -> SpectrumEstimate {
        let of_tree = |tree| {
            let mut tile = TileSums {
                tree,
                ..TileSums::default()
            };
            self.average(&mut tile);
            tile.energies = Vec::new();
            tile
        };
        let tiles: Vec<TileSums> = trees.into_par_iter().map(of_tree).collect();
        let left_out = match self.records {
            1 => LeftOutEach::Realisation,
            _ => self.what_is_left_out(&tiles),
        };
        self.finish(&tiles, left_out, unit)
    }

    /// Bytes that are needed beside the samples.
    fn held(&self, is_all: bool) -> u64 {
        let (samples, bins) = (self.grid.times as u64, self.realisations.bins() as u64);
        let sites = self.grid.sites.next_multiple_of(TOGETHER) as u64;
        let length = self.realisations.segments.length;
        let threads = rayon::current_num_threads() as u64;
        let together = TOGETHER as u64;
        let transform = RecordTransform::<f64>::working_bytes(length, length, TOGETHER);
        let energies = 8 * bins * self.weights.tapers() as u64;
        let sums = 8 * Sums::blocks(self.plain(), self.realisations.pieces()) as u64;
        let of_segments = held_at_once(self.realisations.segments.count());
        let of_records = held_at_once(self.records);
        let scratch = together * (16 * samples + 2 * energies + 48 * bins + of_segments * sums);
        let kept = match (is_all, self.records) {
            (true, 1) => bins * HELD,
            (true, _) => bins * HELD + of_records * sums,
            (false, _) => 2 * (2 * of_segments + of_records) * sums,
        };
        sites * kept + threads * (scratch + transform)
    }

    /// Blocks of the sums of a tile.
    fn plain(&self) -> usize {
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        bins * tapers + if self.tests_lines() { bins * LINE_BLOCKS } else { 0 }
    }

    /// Zeros of a tile.
    pub fn zeros(&self) -> Sums {
        Sums::zeros(self.plain(), self.realisations.pieces())
    }

    /// Whether an offset is not what moves.
    pub fn about_mean(&self) -> bool {
        self.request.averaging.detrend != Detrend::None
    }

    /// Whether there is a test for lines.
    pub fn tests_lines(&self) -> bool {
        self.weights.tapers() > 1
    }

    /// Realisations of each taper.
    pub fn count(&self) -> f64 {
        (self.realisations.segments.count() * self.records) as f64
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
                         samples: &[f64],
                         tile: &mut TileSums| {
                self.add(scratch, portion, sites.len(), samples, shot.scale, tile);
            };
            shot.each_tile("spectra", tiles, visit)
        })
    }

    /// Adds the realisations of a portion of a shot.
    fn add(
        &self,
        scratch: &mut Scratch,
        portion: &Portion,
        width: usize,
        samples: &[f64],
        scale: f64,
        tile: &mut TileSums,
    ) {
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        let squared = scale * scale;
        let lines = if self.tests_lines() { bins } else { 0 };
        scratch.tapers.clear();
        scratch.tapers.resize(lines, TaperSums::default());
        let Scratch {
            segments,
            deviations,
            tapers: within,
            tree,
            ..
        } = scratch;
        let visit = |r: usize, spectra: &[Complex<f64>]| {
            let (segment, taper) = (r / tapers, r % tapers);
            if taper == 0 {
                // Each taper has sums of its own.
                let sums = tree.open(segment, true, || self.zeros());
                let pieces = (portion, segment, samples, scale);
                self.realisations.add_pieces(pieces, deviations, sums);
            }
            let Some(sums) = tree.current() else {
                return;
            };
            let (energies, lines) = sums.plain_mut().split_at_mut(bins * tapers);
            let rows = spectra.chunks_exact(width);
            for (row, sums) in rows.clone().zip(energies.chunks_exact_mut(tapers)) {
                for (x, sum) in row.iter().zip(&mut sums[taper].0) {
                    *sum += squared * x.norm_sqr();
                }
            }
            for (row, sums) in rows.zip(within.iter_mut()) {
                sums.add(&self.taper_transforms[taper], row);
            }
            if taper + 1 == tapers {
                for (within, sums) in within.iter_mut().zip(lines.as_chunks_mut().0) {
                    within.take_into(sums, &self.gains, squared);
                }
                tree.close();
            }
        };
        self.realisations.each_of(portion, samples, segments, visit);
        let about_mean = self.about_mean();
        tile.tree.take(tree, portion.record, portion.is_whole, about_mean);
    }

    /// The average of all realisations.
    fn average(&self, tile: &mut TileSums) {
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        let total = tile.tree.total().unwrap_or_else(|| self.zeros());
        tile.steadiness = total.steadiness();
        tile.energies = total.into_plain();
        tile.lines = tile.energies.split_off(bins * tapers);
        tile.variance = self.variance(&tile.energies);
        tile.spectrum = vec![LaneBlock::default(); bins];
        tile.shape = vec![LaneBlock::default(); bins];
        debug_assert_eq!(tile.energies.len(), bins * tapers);
        widest(Average {
            weights: &self.weights,
            energies: &tile.energies,
            count: self.count(),
            variance: tile.variance,
            spectrum: &mut tile.spectrum,
            shape: &mut tile.shape,
        });
    }

    /// Mean square of the tapered samples, tapers weighted by the squares of their concentrations; 1 for
    /// still sites.
    fn variance(&self, energies: &[LaneBlock]) -> [f64; TOGETHER] {
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
        let all = weights * length as f64 * self.count();
        sums.map(|sum| if sum > 0.0 { sum / all } else { 1.0 })
    }

    /// Adds what each of a shot's realisations, or the shot, changes if it is left out.
    fn leave_out(
        &self,
        scratch: &mut Scratch,
        width: usize,
        samples: &[f64],
        scale: f64,
        left_out: LeftOutEach,
        tile: &mut TileSums,
    ) {
        let count = self.count();
        if !self.request.has_jackknife || count * self.weights.tapers() as f64 <= 1.0 {
            return;
        }
        let (bins, tapers) = (self.realisations.bins(), self.weights.tapers());
        if tile.deviations.is_empty() {
            tile.deviations = vec![LaneBlock::default(); bins];
            tile.squares = vec![LaneBlock::default(); bins];
        }
        let squared = scale * scale;
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
                self.realisations.each(samples, segments, |r, spectra| {
                    for (row, left) in spectra.chunks_exact(width).zip(left.iter_mut()) {
                        for (x, left) in row.iter().zip(&mut left.0) {
                            *left = squared * x.norm_sqr();
                        }
                    }
                    without(LeftOut::Realisation(r % tapers, left));
                });
            }
            LeftOutEach::Record => {
                left.resize(bins * tapers, LaneBlock::default());
                self.realisations.each(samples, segments, |r, spectra| {
                    let rows = spectra.chunks_exact(width);
                    for (row, left) in rows.zip(left.chunks_exact_mut(tapers)) {
                        for (x, left) in row.iter().zip(&mut left[r % tapers].0) {
                            *left += squared * x.norm_sqr();
                        }
                    }
                });
                let count = self.realisations.segments.count() as f64;
                without(LeftOut::Record(count, left));
            }
        }
    }
}
