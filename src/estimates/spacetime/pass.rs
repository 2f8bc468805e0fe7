//! The pass over the segments of [`super::spacetime()`].

use ndarray::ArrayView2;
use num_complex::Complex;
use rayon::prelude::*;

use super::SpaceTimeRequest;
use crate::error::{Error, Result};
use crate::estimates::parts::Finishing;
use crate::estimates::realisations::{
    Average, Averaging, Grid, Portion, Realisations, RecordTree, Records, SegmentScratch,
    SegmentTree, Shot, Shots, Sums, SumsShape, TOGETHER, Weights, bytes_of_tapers, held_at_once,
    nodes_of, steadiness_of_sites,
};
use crate::numeric::lanes::{LaneBlock, WIDTH, widest};
use crate::prepare::Detrend;
use crate::transform::{ComplexScratch, ComplexTransform, fold};

/// Rows of the result that are summed together: those that pass through a transform at once.
const ROWS: usize = ComplexTransform::<f64>::TOGETHER;

/// Bytes of a site beside the spectra.
const OF_SITE: u64 = 128;

/// Blocks of a tile of sites: the energy under the squares of the tapers along time, and the squares.
const OF_SITES: usize = 2;

pub(super) struct Pass<'a> {
    request: &'a SpaceTimeRequest,
    pub realisations: &'a Realisations,
    /// Along space, all sites as one segment.
    pub space: Realisations,
    pub grid: Grid,
    transforms: Vec<ComplexTransform<f64>>,
    /// Pairs of tapers that have sums of their own, taper along time by taper along space.
    pairs: usize,
    /// Means over the tapers of their squares, along time and along space.
    squares: [Vec<f64>; 2],
}

/// Blocks of the tiles of the result: groups of rows, the last of which may have fewer, then tiles of sites.
pub(super) fn tiles(
    grid: &Grid,
    realisations: &Realisations,
    pairs: usize,
) -> Vec<(SumsShape, usize)> {
    let bins = realisations.bins();
    let of_rows = |rows: usize| SumsShape {
        plain: rows * grid.sites.div_ceil(WIDTH) * pairs,
        pieces: 0,
    };
    let of_sites = SumsShape {
        plain: OF_SITES,
        pieces: realisations.pieces(),
    };
    vec![
        (of_rows(ROWS), bins / ROWS),
        (
            of_rows(bins % ROWS),
            usize::from(!bins.is_multiple_of(ROWS)),
        ),
        (of_sites, grid.sites.div_ceil(TOGETHER)),
    ]
}

/// Bytes of the result, and of the averages of all pairs of tapers.
pub(super) fn finishing(grid: &Grid, realisations: &Realisations, pairs: [usize; 2]) -> Finishing {
    let [tapers_along_space, with_sums] = pairs;
    let (bins, sites) = (realisations.bins() as u64, grid.sites as u64);
    let blocks = sites.next_multiple_of(WIDTH as u64);
    let arrays = 4 * 8 * bins + OF_SITE;
    Finishing {
        result: arrays.saturating_mul(sites)
            + 8 * bins
            + bytes_of_tapers(tapers_along_space, grid.sites),
        // The average, and the shape of its distribution.
        averages: match with_sums {
            1 => 0,
            _ => (2 * 8 * bins).saturating_mul(blocks),
        },
        later: 0,
    }
}

/// What is summed of one tile.
#[derive(Default)]
struct Unit {
    segments: SegmentTree,
    records: RecordTree,
}

/// A tile of sites in a segment: its samples less their trend, and their transforms under one taper.
#[derive(Default)]
struct Tile {
    samples: Vec<f64>,
    spectra: Vec<Complex<f64>>,
}

#[derive(Default)]
struct Scratch {
    space: ComplexScratch<f64>,
    profiles: Vec<Complex<f64>>,
}

#[derive(Default)]
struct TimeScratch {
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
        let space = Realisations::new(&along_space, grid.sites).map_err(of_space)?;
        let plan = |taper: &Vec<f64>| ComplexTransform::new(taper, grid.sites);
        Ok(Pass {
            transforms: space.taper_samples().iter().map(plan).collect(),
            squares: [mean_squares(realisations), mean_squares(&space)],
            pairs: request.pairs(),
            request,
            realisations,
            space,
            grid,
        })
    }

    /// The sums of every tile over these portions, and the unit of the samples. `is_all`: there are no others.
    pub fn sum(
        &self,
        shots: &Shots<'_>,
        portions: &[Portion],
        is_all: bool,
    ) -> Result<(f64, Vec<RecordTree>)> {
        let bins = self.realisations.bins();
        let band = self.rows_at_once(shots.memory(), portions, is_all)?;
        // Where the field is larger than memory, pages are released behind the reader.
        let longest = portions.iter().map(|portion| portion.samples.len());
        let bytes = 8 * (longest.max().unwrap_or(0) * self.grid.sites) as u64;
        let block = (bytes > shots.memory() / 4).then_some(TOGETHER);
        let mut trees = Vec::new();
        let mut sites = units(self.grid.sites.div_ceil(TOGETHER));
        let mut unit = 1.0;
        for first in (0..bins).step_by(band) {
            let rows = first..bins.min(first + band);
            let mut groups = units(rows.len().div_ceil(ROWS));
            let mut tiles = Vec::new();
            tiles.resize_with(sites.len(), Tile::default);
            unit = shots.each_portion(block, portions, |shot, portion| {
                let work = portion.segments.len() as u64;
                shot.observer.stage("segments of all sites", work);
                for segment in portion.segments.clone() {
                    if shot.observer.cancelled() {
                        return Err(Error::Cancelled);
                    }
                    let one = self.one(portion, segment);
                    let known = (first == 0).then_some(&mut sites[..]);
                    self.read(shot, portion, &one, &mut tiles, known);
                    for taper in 0..self.realisations.tapers() {
                        self.along_time(taper, &mut tiles);
                        let add = (shot.scale * shot.scale, segment, taper);
                        self.along_space(add, &rows, &tiles, &mut groups);
                    }
                    let done = one.samples.start - portion.samples.start;
                    shot.release(done..done + self.realisations.segments.hop);
                    shot.observer.advance(1);
                }
                let of_sites = sites.iter_mut().filter(|_| first == 0);
                for unit in groups.iter_mut().chain(of_sites) {
                    let Unit { segments, records } = unit;
                    records.take(
                        segments,
                        portion.record,
                        portion.is_whole,
                        self.about_mean(),
                    );
                }
                Ok(())
            })?;
            trees.extend(
                groups
                    .into_iter()
                    .map(|group| settled(group.records, is_all)),
            );
        }
        trees.extend(sites.into_iter().map(|tile| settled(tile.records, is_all)));
        Ok((unit, trees))
    }

    fn about_mean(&self) -> bool {
        self.request.averaging.detrend != Detrend::None
    }

    /// A segment by itself.
    fn one(&self, portion: &Portion, segment: usize) -> Portion {
        let start = segment * self.realisations.segments.hop;
        Portion {
            record: portion.record,
            segments: segment..segment + 1,
            samples: start..start + self.realisations.segments.length,
            is_whole: false,
        }
    }

    /// Rows of the result that are summed in one pass over the samples.
    fn rows_at_once(&self, memory: u64, portions: &[Portion], is_all: bool) -> Result<usize> {
        let (bins, length) = (self.realisations.bins(), self.realisations.segments.length);
        let sites = self.grid.sites.next_multiple_of(TOGETHER) as u64;
        let threads = rayon::current_num_threads() as u64;
        let segments = held_at_once(self.realisations.segments.count());
        let records = held_at_once(portions.len());
        // A complex row, its sums in the trees, and those that stay; then what does not depend on the rows.
        let stay = match is_all {
            true => 1,
            false => 2 * nodes_of(portions, segments, records),
        };
        let pairs = self.pairs as u64;
        let row = sites * (16 + 8 * pairs * (segments + records + 1));
        let scratch = ComplexTransform::<f64>::working_bytes(self.grid.sites, self.grid.sites)
            + 16 * ROWS as u64 * sites
            + crate::transform::RecordTransform::<f64>::working_bytes(length, length, TOGETHER)
            + 24 * (TOGETHER * length) as u64;
        let pieces = 8 * Sums::blocks(OF_SITES, self.realisations.pieces()) as u64;
        let fixed = 8 * length as u64 * sites
            + (8 * pairs * stay + 6 * 8) * sites * bins as u64
            + sites * pieces * (segments + records + 1)
            + threads * scratch;
        let needed = fixed + ROWS as u64 * row;
        if needed > memory {
            return Err(Error::Memory {
                what: "the space-time spectrum of this field",
                needed,
                allowed: memory,
            });
        }
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
        sites: Option<&mut [Unit]>,
    ) {
        let (start, segment) = (portion.samples.start, one.segments.start);
        let times = one.samples.start - start..one.samples.end - start;
        let read =
            |scratch: &mut TimeScratch, i: usize, tile: &mut Tile, sums: Option<&mut Unit>| {
                let from = i * TOGETHER;
                let columns = from..self.grid.sites.min(from + TOGETHER);
                tile.samples.resize(columns.len() * times.len(), 0.0);
                shot.piece(times.clone(), columns, &mut tile.samples);
                let Some(unit) = sums else {
                    self.realisations
                        .remove_trends(&mut tile.samples, &mut scratch.segments);
                    return;
                };
                let sums = unit.segments.open(segment, true, || {
                    Sums::zeros(OF_SITES, self.realisations.pieces())
                });
                let records = Records::one_after_another(&tile.samples, times.len());
                let pieces = (one, segment, records, shot.scale);
                self.realisations
                    .add_pieces(pieces, &mut scratch.numbers, sums);
                self.realisations
                    .remove_trends(&mut tile.samples, &mut scratch.segments);
                let squared = shot.scale * shot.scale;
                let records = tile.samples.chunks_exact(times.len()).enumerate();
                for (lane, record) in records {
                    let weighted = record.iter().zip(&self.squares[0]).map(|(v, w)| v * v * w);
                    scratch.numbers.clear();
                    scratch.numbers.extend(weighted);
                    let [tapered, all] = sums.plain_mut() else {
                        return;
                    };
                    tapered.0[lane] += squared * crate::numeric::sum(&scratch.numbers);
                    all.0[lane] += squared * crate::numeric::sum_of_squares(record);
                }
                unit.segments.close();
            };
        match sites {
            Some(sites) => tiles.par_iter_mut().zip(sites).enumerate().for_each_init(
                TimeScratch::default,
                |scratch, (i, (tile, unit))| {
                    read(scratch, i, tile, Some(unit));
                },
            ),
            None => tiles.par_iter_mut().enumerate().for_each_init(
                TimeScratch::default,
                |scratch, (i, tile)| {
                    read(scratch, i, tile, None);
                },
            ),
        }
    }

    /// Transforms all sites under a taper along time.
    fn along_time(&self, taper: usize, tiles: &mut [Tile]) {
        tiles
            .par_iter_mut()
            .for_each_init(TimeScratch::default, |scratch, tile| {
                let Tile { samples, spectra } = tile;
                let found = self
                    .realisations
                    .under_taper(taper, samples, &mut scratch.segments);
                spectra.clear();
                spectra.extend_from_slice(found);
            });
    }

    /// Transforms these rows under all tapers along space, and adds their powers.
    fn along_space(
        &self,
        (squared, segment, taper): (f64, usize, usize),
        rows: &std::ops::Range<usize>,
        tiles: &[Tile],
        groups: &mut [Unit],
    ) {
        let sites = self.grid.sites;
        let blocks = sites.div_ceil(WIDTH);
        let is_one = self.realisations.tapers() * self.transforms.len() == self.pairs;
        let add = |scratch: &mut Scratch, (group, unit): (usize, &mut Unit)| {
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
            if taper == 0 {
                let zeros = || Sums::zeros(rows.len() * blocks * self.pairs, 0);
                unit.segments.open(segment, is_one, zeros);
            }
            let shape = (rows.len(), sites);
            let profiles = ArrayView2::from_shape(shape, &scratch.profiles);
            let (Some(sums), Ok(profiles)) = (unit.segments.current(), profiles) else {
                return;
            };
            for (i, transform) in self.transforms.iter().enumerate() {
                let powers = transform.powers(profiles, &mut scratch.space);
                let sums = sums.plain_mut().chunks_exact_mut(blocks * self.pairs);
                // With sums of its own, where those of this pair begin.
                let pair = match self.pairs {
                    1 => 0,
                    _ => taper * self.transforms.len() + i,
                };
                for (powers, sums) in powers.chunks_exact(sites).zip(sums) {
                    let sums = sums.iter_mut().skip(pair).step_by(self.pairs);
                    for (powers, sums) in powers.chunks(WIDTH).zip(sums) {
                        for (sum, power) in sums.0.iter_mut().zip(powers) {
                            *sum += squared * power;
                        }
                    }
                }
            }
            if taper + 1 == self.realisations.tapers() {
                unit.segments.close();
            }
        };
        groups
            .par_iter_mut()
            .enumerate()
            .for_each_init(Scratch::default, add);
    }

    /// The sums of all `records`.
    pub fn totals(&self, records: usize, trees: Vec<RecordTree>) -> Totals {
        let groups = self.realisations.bins().div_ceil(ROWS);
        let shapes = tiles(&self.grid, self.realisations, self.pairs);
        let shapes = shapes.into_iter();
        let shapes = shapes.flat_map(|(shape, count)| std::iter::repeat_n(shape, count));
        let total = |(mut tree, shape): (RecordTree, SumsShape)| {
            tree.total().unwrap_or_else(|| shape.zeros())
        };
        let mut groups_and_tiles = trees.into_iter().zip(shapes).map(total);
        let groups = groups_and_tiles.by_ref().take(groups);
        let groups: Vec<Vec<LaneBlock>> = groups.map(Sums::into_plain).collect();
        let tiles = groups_and_tiles.collect();
        let pairs = self.realisations.tapers() * self.space.tapers();
        let count = (records * self.realisations.segments.count()) as f64;
        let weighted = (self.pairs > 1).then(|| self.weighted(&groups, count));
        Totals {
            groups,
            weighted,
            tiles,
            sites: self.grid.sites,
            pairs: self.pairs,
            realisations: count * pairs as f64,
            space: self.squares[1].clone(),
        }
    }

    /// Those of records of zeros, counted as steady: nothing is held.
    pub fn silence(&self) -> Totals {
        Totals {
            groups: Vec::new(),
            weighted: None,
            tiles: Vec::new(),
            sites: self.grid.sites,
            pairs: self.pairs,
            realisations: 1.0,
            space: self.squares[1].clone(),
        }
    }

    /// Averages over the pairs of tapers, of which each has `count` realisations, by adaptive weights.
    fn weighted(&self, groups: &[Vec<LaneBlock>], count: f64) -> Weighted {
        // Concentrations that round to 1 would leave nothing to weigh cells without energy by.
        let [time, space] = [
            &self.realisations.concentrations,
            &self.space.concentrations,
        ];
        let products = time.iter().flat_map(|a| space.iter().map(move |b| a * b));
        let concentrations: Vec<f64> = products.map(|l| l.min(1.0 - f64::EPSILON)).collect();
        let variance = self.variance(groups, &concentrations, count);
        let weights = Weights::new(&concentrations, true);
        let of_group = |energies: &Vec<LaneBlock>| {
            let cells = energies.len() / self.pairs;
            let mut spectrum = vec![LaneBlock::default(); cells];
            let mut shape = vec![LaneBlock::default(); cells];
            widest(Average {
                weights: &weights,
                energies,
                count: [count; WIDTH],
                variance: [variance; WIDTH],
                spectrum: &mut spectrum,
                shape: &mut shape,
            });
            [spectrum, shape]
        };
        Weighted(groups.par_iter().map(of_group).collect())
    }

    /// Mean square of the tapered samples, pairs of tapers weighted by the squares of their concentrations; 1
    /// of still fields.
    fn variance(&self, groups: &[Vec<LaneBlock>], concentrations: &[f64], count: f64) -> f64 {
        let length = self.realisations.segments.length;
        let of_row = self.grid.sites.div_ceil(WIDTH) * self.pairs;
        let rows = groups.iter().flat_map(|group| group.chunks_exact(of_row));
        let mut sum = 0.0;
        for (m, row) in rows.enumerate() {
            for cell in row.chunks_exact(self.pairs) {
                for (energy, concentration) in cell.iter().zip(concentrations) {
                    let weight = fold(m, length) * concentration * concentration;
                    sum += weight * energy.0.iter().sum::<f64>();
                }
            }
        }
        let weights: f64 = concentrations.iter().map(|l| l * l).sum();
        match sum > 0.0 {
            true => sum / (weights * (length * self.grid.sites) as f64 * count),
            false => 1.0,
        }
    }
}

fn units(count: usize) -> Vec<Unit> {
    let mut units = Vec::new();
    units.resize_with(count, Unit::default);
    units
}

/// The total in place of its nodes, where no other part follows.
fn settled(mut tree: RecordTree, is_all: bool) -> RecordTree {
    if is_all {
        tree.settle();
    }
    tree
}

/// An error of the tapers along space, with its option.
fn of_space(error: Error) -> Error {
    match error {
        Error::Request {
            option,
            expected,
            found,
        } => Error::Request {
            option: match option {
                "window" => "space-window",
                "multitaper" => "space-multitaper",
                option => option,
            },
            expected,
            found,
        },
        error => error,
    }
}

/// The mean over the tapers of their squares.
fn mean_squares(realisations: &Realisations) -> Vec<f64> {
    let tapers = realisations.taper_samples();
    let square = |n: usize| tapers.iter().map(|taper| taper[n] * taper[n]).sum::<f64>();
    (0..realisations.segments.length)
        .map(|n| square(n) / tapers.len() as f64)
        .collect()
}

/// Averages by adaptive weights, and half of the degrees of freedom of one realisation of each pair of tapers;
/// of each group of rows, `[row * blocks + block]`.
struct Weighted(Vec<[Vec<LaneBlock>; 2]>);

/// Sums over all realisations; 0 where there are none.
pub(super) struct Totals {
    /// `[(row * blocks + block) * pairs + pair]`.
    groups: Vec<Vec<LaneBlock>>,
    weighted: Option<Weighted>,
    tiles: Vec<Sums>,
    sites: usize,
    pairs: usize,
    /// Of all pairs.
    realisations: f64,
    /// Mean of the squares of the tapers along space.
    space: Vec<f64>,
}

impl Totals {
    fn cell(&self, row: usize, column: usize) -> usize {
        row % ROWS * self.sites.div_ceil(WIDTH) + column / WIDTH
    }

    /// The mean of `|X|^2` of a cell, by adaptive weights if there are any.
    pub fn mean(&self, row: usize, column: usize) -> f64 {
        match &self.weighted {
            None => self.equal(row, column),
            Some(Weighted(groups)) => {
                groups[row / ROWS][0][self.cell(row, column)].0[column % WIDTH]
            }
        }
    }

    /// The mean of `|X|^2` of a cell, by equal weights.
    pub fn equal(&self, row: usize, column: usize) -> f64 {
        let Some(group) = self.groups.get(row / ROWS) else {
            return 0.0;
        };
        let pairs = &group[self.cell(row, column) * self.pairs..][..self.pairs];
        pairs.iter().map(|sum| sum.0[column % WIDTH]).sum::<f64>() / self.realisations
    }

    /// Degrees of freedom of a cell over those with equal weights.
    pub fn share(&self, row: usize, column: usize) -> f64 {
        match &self.weighted {
            None => 1.0,
            Some(Weighted(groups)) => {
                let shape = &groups[row / ROWS][1][self.cell(row, column)];
                shape.0[column % WIDTH] / self.pairs as f64
            }
        }
    }

    fn of_site(&self, what: usize) -> impl Iterator<Item = f64> + '_ {
        let lane = move |j: usize| {
            let tile = self.tiles.get(j / TOGETHER);
            tile.map_or(0.0, |tile| tile.plain()[what].0[j % TOGETHER])
        };
        (0..self.sites).map(lane)
    }

    /// Energy under the squares of the tapers, of all segments.
    pub fn tapered(&self) -> f64 {
        let weighted = self.of_site(0).zip(&self.space).map(|(e, w)| e * w);
        crate::numeric::sum(&weighted.collect::<Vec<f64>>())
    }

    /// Squares of the samples of all segments.
    pub fn square(&self) -> f64 {
        crate::numeric::sum(&self.of_site(1).collect::<Vec<f64>>())
    }

    /// Roots of the energies of the sites.
    pub fn site_amplitudes(&self) -> Vec<f64> {
        self.of_site(1).map(f64::sqrt).collect()
    }

    /// The steadiness of the site at which half of the energy lies at sites that are less steady.
    pub fn steadiness(&self, records: usize) -> f64 {
        let of = |j: usize| {
            let tile = self.tiles.get(j / TOGETHER);
            tile.map_or(1.0, |tile| tile.steadiness()[j % TOGETHER] / records as f64)
        };
        let energies = self.of_site(1).enumerate();
        steadiness_of_sites(energies.map(|(j, energy)| (of(j), energy)).collect())
    }
}
