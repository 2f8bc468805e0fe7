//! The pass over the segments of [`super::spacetime()`].

use ndarray::ArrayView2;
use num_complex::Complex;
use rayon::prelude::*;

use super::SpaceTimeRequest;
use super::totals::Totals;
use crate::error::Result;
use crate::estimates::realisations::{
    Averaging, Grid, Portion, Realisations, Records, SegmentScratch, Shot, Shots, Sums, SumsShape,
    TOGETHER,
};
use crate::numeric::lanes::WIDTH;
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

/// A tile of sites in a segment: its samples less their trend, and their transforms under one taper.
#[derive(Default)]
struct Tile {
    samples: Vec<f64>,
    spectra: Vec<Complex<f64>>,
}

/// Working space of one thread.
#[derive(Default)]
struct Scratch {
    space: ComplexScratch<f64>,
    profiles: Vec<Complex<f64>>,
    segments: SegmentScratch,
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
            transforms: space.taper_samples().iter().map(plan).collect(),
            squares: [mean_squares(realisations), mean_squares(&space)],
            pairs: request.pairs(),
            realisations,
            space,
            grid,
        })
    }

    /// The sums over so many records, and the unit of the samples.
    pub fn sum(&self, shots: &Shots<'_>, records: usize) -> Result<(f64, Totals)> {
        let time = self.realisations;
        let bins = time.bins();
        let band = self.rows_at_once(shots.memory)?;
        let portions = time.whole_records(records);
        // Where the field is larger than memory, pages are released behind the reader.
        let bytes = 8 * (time.segments.record * self.grid.sites) as u64;
        let block = (bytes > shots.memory / 4).then_some(TOGETHER);
        let mut sums = Vec::new();
        let (plain, pieces) = (OF_SITES, time.pieces());
        let of_sites = Sums::zeros(SumsShape { plain, pieces });
        let mut sites = vec![of_sites; self.grid.tiles()];
        let mut unit = 1.0;
        for first in (0..bins).step_by(band) {
            let rows = first..bins.min(first + band);
            let zeros = |row: usize| {
                let rows = rows.end.min(row + ROWS) - row;
                let plain = rows * self.grid.sites.div_ceil(WIDTH) * self.pairs;
                Sums::zeros(SumsShape { plain, pieces: 0 })
            };
            let mut groups: Vec<Sums> = rows.clone().step_by(ROWS).map(zeros).collect();
            let mut tiles = Vec::new();
            tiles.resize_with(sites.len(), Tile::default);
            unit = shots.each_portion(block, &portions, |shot, portion| {
                let work = portion.segments.len() as u64;
                shot.observer.stage("segments of all sites", work);
                for segment in portion.segments.clone() {
                    shot.observer.go_on()?;
                    let start = segment * time.segments.hop;
                    let one = Portion {
                        record: portion.record,
                        segments: segment..segment + 1,
                        samples: start..start + time.segments.length,
                        is_whole: false,
                    };
                    let known = (first == 0).then_some(&mut sites[..]);
                    self.read(shot, portion, &one, &mut tiles, known);
                    for taper in 0..time.tapers() {
                        self.along_time(taper, &mut tiles);
                        let add = (shot.scale * shot.scale, taper);
                        self.along_space(add, &rows, &tiles, &mut groups);
                    }
                    let done = start - portion.samples.start;
                    shot.release(done..done + time.segments.hop);
                    shot.observer.advance(1);
                }
                for sums in &mut sites {
                    sums.close(time.reached(), time.about_mean());
                }
                Ok(())
            })?;
            sums.extend(groups);
        }
        Ok((unit, self.totals(records, sums, sites)))
    }

    /// Rows of the result that are summed in one pass over the samples.
    fn rows_at_once(&self, memory: u64) -> Result<usize> {
        let time = self.realisations;
        let (bins, length) = (time.bins(), time.segments.length);
        let sites = self.grid.sites.next_multiple_of(TOGETHER) as u64;
        let threads = rayon::current_num_threads() as u64;
        // A complex row and its sums; then what does not depend on the rows.
        let pairs = self.pairs as u64;
        let row = sites * (16 + 8 * pairs);
        let scratch = ComplexTransform::<f64>::working_bytes(self.grid.sites, self.grid.sites)
            + 16 * ROWS as u64 * sites
            + time.working_bytes()
            + 24 * (TOGETHER * length) as u64;
        let pieces = 8 * (OF_SITES + 2 + 3 * time.pieces()) as u64;
        let fixed = 8 * length as u64 * sites
            + (8 * pairs + 6 * 8) * sites * bins as u64
            + sites * pieces
            + threads * scratch;
        let needed = fixed + ROWS as u64 * row;
        check_memory(
            "the space-time spectrum of this field",
            needed,
            Some(memory),
        )?;
        let rows = ((memory - fixed) / row) as usize / ROWS * ROWS;
        Ok(rows.clamp(ROWS, bins.next_multiple_of(ROWS)))
    }

    /// Reads a segment of all sites, removes its trends, and adds its energies to `sites`, if there are any.
    fn read(
        &self,
        shot: &Shot<'_>,
        portion: &Portion,
        one: &Portion,
        tiles: &mut [Tile],
        sites: Option<&mut [Sums]>,
    ) {
        let (time, start, segment) = (self.realisations, portion.samples.start, one.segments.start);
        let times = one.samples.start - start..one.samples.end - start;
        let read =
            |scratch: &mut Scratch,
             (i, (tile, mut sums)): (usize, (&mut Tile, Option<&mut Sums>))| {
                let from = i * TOGETHER;
                let columns = from..self.grid.sites.min(from + TOGETHER);
                tile.samples.resize(columns.len() * times.len(), 0.0);
                let mark = shot.mark(columns.clone());
                shot.piece(times.clone(), columns, &mut tile.samples);
                if let Some(sums) = &mut sums {
                    let records = Records::one_after_another(&tile.samples, times.len());
                    let pieces = (one, segment, records, shot.scale);
                    time.add_pieces(pieces, mark, &mut scratch.numbers, sums);
                }
                time.remove_trends(&mut tile.samples, &mut scratch.segments);
                let Some([tapered, all]) = sums.map(Sums::plain_mut) else {
                    return;
                };
                let squared = shot.scale * shot.scale;
                for (lane, record) in tile.samples.chunks_exact(times.len()).enumerate() {
                    let weighted = record.iter().zip(&self.squares[0]).map(|(v, w)| v * v * w);
                    scratch.numbers.clear();
                    scratch.numbers.extend(weighted);
                    tapered.0[lane] += squared * crate::numeric::sum(&scratch.numbers);
                    all.0[lane] += squared * crate::numeric::sum_of_squares(record);
                }
            };
        let sites: Vec<Option<&mut Sums>> = match sites {
            Some(sites) => sites.iter_mut().map(Some).collect(),
            None => tiles.iter().map(|_| None).collect(),
        };
        let tiles = tiles.par_iter_mut().zip(sites).enumerate();
        tiles.for_each_init(Scratch::default, read);
    }

    /// Transforms all sites under a taper along time.
    fn along_time(&self, taper: usize, tiles: &mut [Tile]) {
        let transform = |scratch: &mut SegmentScratch, tile: &mut Tile| {
            let found = self.realisations.under_taper(taper, &tile.samples, scratch);
            tile.spectra.clear();
            tile.spectra.extend_from_slice(found);
        };
        let tiles = tiles.par_iter_mut();
        tiles.for_each_init(SegmentScratch::default, transform);
    }

    /// Transforms these rows under all tapers along space, and adds their powers.
    fn along_space(
        &self,
        (squared, taper): (f64, usize),
        rows: &std::ops::Range<usize>,
        tiles: &[Tile],
        groups: &mut [Sums],
    ) {
        let sites = self.grid.sites;
        let blocks = sites.div_ceil(WIDTH);
        let add = |scratch: &mut Scratch, (group, sums): (usize, &mut Sums)| {
            let first = rows.start + group * ROWS;
            let rows = first..rows.end.min(first + ROWS);
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
                let sums = sums.plain_mut().chunks_exact_mut(blocks * self.pairs);
                // Where the sums of this pair begin, if each has its own.
                let pair = (taper * self.transforms.len() + i) % self.pairs;
                for (powers, sums) in powers.chunks_exact(sites).zip(sums) {
                    let sums = sums.iter_mut().skip(pair).step_by(self.pairs);
                    for (powers, sums) in powers.chunks(WIDTH).zip(sums) {
                        for (sum, power) in sums.0.iter_mut().zip(powers) {
                            *sum += squared * power;
                        }
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
    let tapers = realisations.taper_samples();
    let square = |n: usize| tapers.iter().map(|taper| taper[n] * taper[n]).sum::<f64>();
    let samples = 0..realisations.segments.length;
    samples.map(|n| square(n) / tapers.len() as f64).collect()
}
