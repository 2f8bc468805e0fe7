//! The pass over the segments of [`super::spacetime()`].

use ndarray::ArrayView2;
use num_complex::Complex;
use rayon::prelude::*;

use super::SpaceTimeRequest;
use super::totals::Totals;
use crate::error::Result;
use crate::estimates::realisations::{
    Averaging, Grid, Realisations, Records, SegmentScratch, Shot, Shots, Sums, TOGETHER,
};
use crate::numeric::lanes::{LaneBlock, WIDTH};
use crate::numeric::{interleaved_sums_of_squares, pieces};
use crate::prepare::Detrend;
use crate::system::check_memory;
use crate::transform::{ComplexScratch, ComplexTransform};

/// Rows of the result that are summed together: those that pass through a transform at once.
pub(super) const ROWS: usize = ComplexTransform::<f64>::TOGETHER;

/// Blocks of a tile of sites: the energy under the squares of the tapers along time, and the squares.
pub(super) const OF_SITES: usize = 2;

pub(super) struct Pass<'a> {
    pub realisations: &'a Realisations,
    /// Along space, all sites as one segment.
    pub space: Realisations,
    pub grid: Grid,
    transforms: Vec<ComplexTransform<f64>>,
    /// Pairs of tapers that have sums of their own, taper along time by taper along space.
    pub pairs: usize,
    /// Means over the tapers of their squares, along time and along space.
    pub squares: [Vec<f64>; 2],
}

/// A tile of sites in a segment: its interleaved samples less their trend, and their transforms under one taper.
#[derive(Default)]
struct Tile {
    rows: Vec<f64>,
    spectra: Vec<Complex<f64>>,
}

/// Working space of one thread.
#[derive(Default)]
struct Scratch {
    space: ComplexScratch<f64>,
    profiles: Vec<Complex<f64>>,
    segments: SegmentScratch,
    samples: Vec<f64>,
    rows: Vec<f64>,
    numbers: Vec<f64>,
}

impl<'a> Pass<'a> {
    pub fn new(
        request: &'a SpaceTimeRequest,
        realisations: &'a Realisations,
        grid: Grid,
    ) -> Result<Self> {
        let along_space = Averaging {
            segment: Some(grid.sites),
            overlap: Some(0),
            tapers: request.space.clone(),
            detrend: Detrend::None,
        };
        let space = Realisations::new(&along_space, grid.sites).map_err(|error| {
            error
                .of_option("window", "space-window")
                .of_option("multitaper", "space-multitaper")
        })?;
        let plan = |taper: &Vec<f64>| ComplexTransform::new(taper, grid.sites);
        Ok(Pass {
            transforms: space.tapers.iter().map(plan).collect(),
            squares: [mean_squares(realisations), mean_squares(&space)],
            pairs: request.pairs(),
            realisations,
            space,
            grid,
        })
    }

    /// The sums over so many records.
    ///
    /// # Errors
    /// [`crate::Error::Memory`]; those of [`Shots::each_portion`].
    pub fn sum(&self, shots: &Shots<'_>, records: usize) -> Result<Totals> {
        let (time, blocks) = (self.realisations, self.grid.sites.div_ceil(WIDTH));
        let what = "the space-time spectrum of this field";
        check_memory(what, self.needed(), Some(shots.memory))?;
        // Where the field is larger than memory, pages are released behind the reader.
        let bytes = 8 * (time.segments.record * self.grid.sites) as u64;
        let block = (bytes > shots.memory / 4).then_some(TOGETHER);
        let rows = pieces(time.bins(), ROWS).map(|rows| rows.len());
        let zeros = |rows| vec![LaneBlock::default(); rows * blocks * self.pairs];
        let mut groups: Vec<Vec<LaneBlock>> = rows.map(zeros).collect();
        let mut sites = vec![Sums::zeros(time.shape(OF_SITES)); self.grid.tiles()];
        let mut tiles = Vec::new();
        tiles.resize_with(sites.len(), Tile::default);
        shots.each_portion(block, &time.whole_records(records), |shot| {
            let segments = 0..time.segments.count();
            let stage = "segments of all sites";
            shots.observer.stage(stage, segments.len() as u64);
            for segment in segments {
                shots.observer.go_on()?;
                self.read(shot, segment, &mut tiles, &mut sites);
                for taper in 0..time.tapers() {
                    self.along_time(taper, &mut tiles);
                    self.along_space(taper, &tiles, &mut groups);
                }
                let done = segment * time.segments.hop;
                shot.release(done..done + time.segments.hop);
                shots.observer.advance(1);
            }
            Ok(())
        })?;
        let (pairs, space) = (self.pairs, self.squares[1].clone());
        let count = (records * time.segments.count()) as f64;
        Ok(Totals {
            weighted: (pairs > 1).then(|| self.weighted(&groups, count)),
            groups,
            tiles: sites,
            pairs,
            realisations: count * (time.tapers() * self.space.tapers()) as f64,
            space,
        })
    }

    /// Bytes of a segment of all sites, of the sums and what is made of them, and of the scratch of all threads.
    fn needed(&self) -> u64 {
        let time = self.realisations;
        let (bins, length) = (time.bins() as u64, time.segments.length as u64);
        let sites = self.grid.sites.next_multiple_of(TOGETHER) as u64;
        let scratch = ComplexTransform::<f64>::working_bytes(self.grid.sites, self.grid.sites)
            + 16 * ROWS as u64 * sites
            + time.working_bytes()
            + 24 * TOGETHER as u64 * length;
        let of_cell = 8 * self.pairs as u64 + 6 * 8;
        let sums = time.shape(OF_SITES).bytes() / TOGETHER as u64;
        sites * (8 * length + of_cell * bins + sums) + rayon::current_num_threads() as u64 * scratch
    }

    /// Reads a segment of all sites, removes its trends, and adds its energies to `sites`.
    fn read(&self, shot: &Shot<'_>, segment: usize, tiles: &mut [Tile], sites: &mut [Sums]) {
        let (time, start) = (self.realisations, segment * self.realisations.segments.hop);
        let times = start..start + time.segments.length;
        let read = |scratch: &mut Scratch, (i, (tile, sums)): (usize, (&mut Tile, &mut Sums))| {
            let from = i * TOGETHER;
            let columns = from..self.grid.sites.min(from + TOGETHER);
            let (width, mark) = (columns.len(), shot.mark(columns.clone()));
            let Scratch {
                segments,
                samples,
                rows,
                numbers,
                ..
            } = scratch;
            shot.piece(times.clone(), columns, (samples, rows));
            let of = (shot.portion.record, segment..segment + 1);
            let records = Records::interleaved(rows, width);
            sums.add_samples(of, records, mark, &mut segments.numbers);
            let moving = time.without_trends(rows, width, (samples, numbers));
            tile.rows.clear();
            tile.rows.extend_from_slice(moving);
            numbers.clear();
            let weighted = moving.chunks_exact(width).zip(&self.squares[0]);
            numbers.extend(weighted.flat_map(|(row, w)| row.iter().map(|v| v * w.sqrt())));
            let mut energies = Vec::with_capacity(width);
            for (sums, rows) in sums.plain.iter_mut().zip([&numbers[..], moving]) {
                interleaved_sums_of_squares(rows, width, &mut energies);
                sums.add(energies.iter().copied());
            }
        };
        let tiles = tiles.par_iter_mut().zip(sites).enumerate();
        tiles.for_each_init(Scratch::default, read);
    }

    /// Transforms all sites under a taper along time.
    fn along_time(&self, taper: usize, tiles: &mut [Tile]) {
        let length = self.realisations.segments.length;
        let transform = |scratch: &mut SegmentScratch, tile: &mut Tile| {
            let rows = (&tile.rows[..], tile.rows.len() / length);
            let found = self.realisations.under_taper(taper, rows, scratch);
            tile.spectra.clear();
            tile.spectra.extend_from_slice(found);
        };
        let tiles = tiles.par_iter_mut();
        tiles.for_each_init(SegmentScratch::default, transform);
    }

    /// Transforms all rows under all tapers along space, and adds their powers.
    fn along_space(&self, taper: usize, tiles: &[Tile], groups: &mut [Vec<LaneBlock>]) {
        let sites = self.grid.sites;
        let blocks = sites.div_ceil(WIDTH);
        let add = |scratch: &mut Scratch, (group, sums): (usize, &mut Vec<LaneBlock>)| {
            let first = group * ROWS;
            let rows = first..self.realisations.bins().min(first + ROWS);
            scratch.profiles.clear();
            for row in rows.clone() {
                for (i, tile) in tiles.iter().enumerate() {
                    let width = TOGETHER.min(sites - i * TOGETHER);
                    let cells = &tile.spectra[row * width..][..width];
                    scratch.profiles.extend_from_slice(cells);
                }
            }
            let Ok(profiles) = ArrayView2::from_shape((rows.len(), sites), &scratch.profiles)
            else {
                return;
            };
            for (i, transform) in self.transforms.iter().enumerate() {
                let powers = transform.powers(profiles, &mut scratch.space);
                let sums = sums.chunks_exact_mut(blocks * self.pairs);
                // Where the sums of this pair begin, if each has its own.
                let pair = (taper * self.transforms.len() + i) % self.pairs;
                for (powers, sums) in powers.chunks_exact(sites).zip(sums) {
                    let sums = sums.iter_mut().skip(pair).step_by(self.pairs);
                    for (powers, sums) in powers.chunks(WIDTH).zip(sums) {
                        sums.add(powers.iter().copied());
                    }
                }
            }
        };
        let groups = groups.par_iter_mut().enumerate();
        groups.for_each_init(Scratch::default, add);
    }
}

/// The mean over the tapers of their squares.
fn mean_squares(realisations: &Realisations) -> Vec<f64> {
    let tapers = &realisations.tapers;
    let square = |n: usize| tapers.iter().map(|taper| taper[n] * taper[n]).sum::<f64>();
    let samples = 0..realisations.segments.length;
    samples.map(|n| square(n) / tapers.len() as f64).collect()
}
