//! The pass over the records of [`super::bicoherence()`].

use rayon::prelude::*;

use super::along::{self, TileSums};
use super::bicoherence::{Bicoherence, BicoherenceMap, BicoherenceRequest, check_count};
use super::products::{TripleSums, blocks, order, sum_products, working_bytes};
use super::spectra::{Spectra, last_bin};
use super::triples::Triples;
use crate::error::Result;
use crate::estimates::parts::{Divided, Finishing, Orders};
use crate::estimates::realisations::{
    Grid, Independence, Portion, Realisations, RecordTree, Records, SegmentScratch, SegmentTree,
    Shot, Shots, Sums, SumsShape, TOGETHER, TreeNode, held_at_once, nodes_of, nodes_within,
    steadiness_without,
};
use crate::prepare::{Detrend, Gaps};
use crate::transform::{RecordTransform, frequencies};

/// Bytes of a bin, and of a site, beside the arrays: rows of triples, and trees.
const OF_BIN: u64 = 512;
const OF_SITE: u64 = 256;

pub(super) struct Pass<'a> {
    pub request: &'a BicoherenceRequest,
    pub grid: &'a Grid,
    pub realisations: &'a Realisations,
    /// Records of a site.
    records: usize,
    /// Of the map.
    triples: Triples,
    /// Of a site by itself.
    pub own: Triples,
}

/// Working space of one thread.
#[derive(Default)]
pub(super) struct Scratch {
    pub segments: SegmentScratch,
    deviations: Vec<f64>,
    tree: SegmentTree,
    /// Sums of a site that are no longer used.
    pub free: Vec<Sums>,
}

/// How steady the records of up to eight sites are.
#[derive(Default)]
pub(super) struct Steadiness {
    tree: RecordTree,
    /// Where segments with missing samples are left out: the sum over records, and that of the least steady one.
    without: [f64; TOGETHER],
    least_without: f64,
}

impl Steadiness {
    /// Of one record of zeros.
    pub fn silent() -> Steadiness {
        Steadiness {
            tree: RecordTree::default(),
            without: [1.0; TOGETHER],
            least_without: 1.0,
        }
    }

    /// The sum over records of the least steady site.
    pub fn of_least(mut self) -> f64 {
        match self.tree.total() {
            Some(total) => total.least_steadiness(),
            None => self.least_without,
        }
    }

    /// The sum over records, of each site.
    pub fn of_sites(mut self) -> [f64; TOGETHER] {
        match self.tree.total() {
            Some(total) => total.steadiness(),
            None => self.without,
        }
    }
}

/// Sums over realisations.
struct AllSums {
    /// Of the sites of the map, or of its one site.
    steadiness: Steadiness,
    map: RecordTree,
    tiles: Vec<TileSums>,
}

impl<'a> Pass<'a> {
    pub fn new(
        request: &'a BicoherenceRequest,
        grid: &'a Grid,
        realisations: &'a Realisations,
        records: usize,
    ) -> Pass<'a> {
        let last = last_bin(realisations.segments.length);
        let least = realisations.least_distance();
        Pass {
            request,
            grid,
            realisations,
            records,
            triples: match request.site == request.output() {
                true => Triples::of_one(last, least),
                false => Triples::of_two(last, least),
            },
            own: Triples::of_one(last, least),
        }
    }

    pub fn run(&self, shots: &Shots<'_>) -> Result<Bicoherence> {
        let whole = (0..self.records).map(|record| self.realisations.whole(record));
        let sums = self.sum(shots, &whole.collect::<Vec<Portion>>(), true)?.1;
        Ok(self.finish(sums))
    }

    /// The sums over these portions, and the unit of the samples. Those of tiles are gathered where nothing follows.
    fn sum(
        &self,
        shots: &Shots<'_>,
        portions: &[Portion],
        gathers: bool,
    ) -> Result<(f64, AllSums)> {
        let held = self.held(shots.longest(), portions, gathers);
        let block = shots.block("the bispectra of this field", held)?;
        let mut tiles = Vec::new();
        tiles.resize_with(shots.tiles(), TileSums::default);
        let mut sums = AllSums {
            steadiness: Steadiness::default(),
            map: RecordTree::default(),
            tiles,
        };
        let mut left = portions.len();
        let unit = shots.each_portion(block, portions, |shot, portion| {
            left -= 1;
            let mut scratch = Scratch::default();
            self.add_map(&mut scratch, (shot, portion), &mut sums);
            if self.request.along.is_empty() {
                return Ok(());
            }
            shot.each_tile(
                "bispectra",
                &mut sums.tiles,
                |scratch, sites, records, tile| {
                    self.add_tile(scratch, (shot, portion), (sites, records), tile);
                    if gathers && left == 0 {
                        scratch.free.extend(tile.gather(self));
                    }
                },
            )
        })?;
        Ok((unit, sums))
    }

    /// Bytes that are needed beside the samples, of which so many of a record are read.
    fn held(&self, samples: usize, portions: &[Portion], gathers: bool) -> u64 {
        let length = self.realisations.segments.length;
        let segments = portions.iter().map(|portion| portion.segments.len());
        let count = segments.max().unwrap_or(0);
        let spectra = Spectra::bytes(length, count);
        let (threads, together) = (rayon::current_num_threads() as u64, TOGETHER as u64);
        let nodes = match gathers {
            true => held_at_once(self.records) + 1,
            false => 2 * nodes_of(portions),
        };
        let chosen = self.request.along.len() as u64;
        // Those that have a tile; the map has one.
        let tiles = threads.min(self.chosen_by_tile().count().max(1) as u64);
        let along = match self.records == 1 && gathers {
            true => (tiles * together).min(chosen),
            false => chosen * nodes + tiles,
        };
        let scratch = RecordTransform::<f64>::working_bytes(length, length, TOGETHER);
        let of_triples = [&self.triples, &self.own].map(|triples| working_bytes(triples, count));
        let tile = together * (16 * samples as u64 + spectra) + scratch;
        let results = 96 * chosen * self.realisations.bins() as u64;
        nodes * TripleSums::bytes(&self.triples)
            + 40 * self.triples.cells() as u64
            + 2 * spectra
            + along * TripleSums::bytes(&self.own)
            + results
            + tiles * tile
            + threads * of_triples[0].max(of_triples[1])
    }

    /// Adds a portion of a shot to the map.
    fn add_map(
        &self,
        scratch: &mut Scratch,
        (shot, portion): (&Shot<'_>, &Portion),
        sums: &mut AllSums,
    ) {
        let sites = [self.request.site, self.request.output()];
        let sites = match sites[0] == sites[1] {
            true => &sites[..1],
            false => &sites[..],
        };
        let records: Vec<f64> = sites.iter().flat_map(|site| shot.record(*site)).collect();
        let records = Records::one_after_another(&records, records.len() / sites.len());
        let of = (shot, portion);
        self.add_steadiness(scratch, of, (sites, records), &mut sums.steadiness);
        let segments = &mut scratch.segments;
        let spectra = Spectra::of(self.realisations, portion, records, shot.scale, segments);
        let (Some(x), Some(z)) = (spectra.first(), spectra.last()) else {
            return;
        };
        self.add_products(
            &self.triples,
            portion,
            [x, z],
            (&mut sums.map, &mut Vec::new()),
            true,
        );
    }

    /// Adds the products of a portion to those of a tree, in place of free sums where there are any.
    pub fn add_products(
        &self,
        triples: &Triples,
        portion: &Portion,
        [x, z]: [&Spectra; 2],
        (tree, free): (&mut RecordTree, &mut Vec<Sums>),
        is_parallel: bool,
    ) {
        let mut segments = SegmentTree::default();
        let mut empty = || free.pop().unwrap_or_else(|| TripleSums::zeros(triples));
        if portion.is_whole {
            // The sum of all in place of nodes that would be added.
            let mut sums = empty();
            sum_products(triples, x, z, &(0..x.count()), (&mut sums, is_parallel));
            segments.push(0, 0, sums);
        } else {
            let first = portion.segments.start;
            for (level, index) in nodes_within(portion.segments.clone()) {
                let start = (index << level) - first;
                let mut sums = empty();
                let range = start..start + (1 << level);
                sum_products(triples, x, z, &range, (&mut sums, is_parallel));
                segments.push(level, index, sums);
            }
        }
        tree.take(
            &mut segments,
            portion.record,
            portion.is_whole,
            self.request.about_mean(),
        );
    }

    /// Adds how steady the records of a portion are.
    pub fn add_steadiness(
        &self,
        scratch: &mut Scratch,
        (shot, portion): (&Shot<'_>, &Portion),
        (sites, records): (&[usize], Records<'_>),
        into: &mut Steadiness,
    ) {
        if self.request.gaps == Gaps::LeaveOut {
            let mut least = 1.0_f64;
            for (lane, (sum, site)) in into.without.iter_mut().zip(sites).enumerate() {
                let one = steadiness_without(
                    &records.record(lane),
                    &shot.missing(*site),
                    self.request.about_mean(),
                );
                *sum += one;
                least = least.min(one);
            }
            into.least_without += least;
            return;
        }
        let Scratch {
            deviations, tree, ..
        } = scratch;
        let pieces = self.realisations.pieces();
        let mark = shot.mark(sites.iter().copied());
        for segment in portion.segments.clone() {
            let sums = tree.open(segment, true, || Sums::zeros(0, pieces));
            let of = (portion, segment, records, shot.scale);
            self.realisations.add_pieces(of, mark, deviations, sums);
            tree.close();
        }
        into.tree.take(
            tree,
            portion.record,
            portion.is_whole,
            self.request.about_mean(),
        );
    }

    pub fn total(&self, mut tree: RecordTree, triples: &Triples) -> Sums {
        tree.total().unwrap_or_else(|| TripleSums::zeros(triples))
    }

    /// The number of independent realisations of records whose steadiness has this sum.
    pub fn independence(&self, steadiness: f64) -> Independence {
        let realisations = self.realisations;
        Independence::new(
            [self.records, realisations.segment_count(), 1],
            realisations.effective_products(3),
            steadiness / self.records as f64,
        )
    }

    fn finish(&self, sums: AllSums) -> Bicoherence {
        let total = self.total(sums.map, &self.triples);
        let products = TripleSums::of(&self.triples, &total);
        let scale = products.scale();
        let cells = self.triples.bins().enumerate();
        let cells = cells.map(|(cell, bins)| products.cell(cell, bins, &scale));
        self.estimate(cells, sums.steadiness, sums.tiles)
    }

    /// The estimate of records of zeros, counted as steady.
    fn silent(&self) -> Bicoherence {
        let cells = std::iter::repeat_n((f64::NAN, f64::NAN), self.triples.cells());
        let tiles = self.chosen_by_tile();
        let tiles = tiles.map(|chosen| TileSums::silent(chosen.len()));
        self.estimate(cells, Steadiness::silent(), tiles.collect())
    }

    /// The estimate of the bicoherence and the biphase of the map's cells, and of the sites along x.
    fn estimate(
        &self,
        cells: impl Iterator<Item = (f64, f64)>,
        steadiness: Steadiness,
        tiles: Vec<TileSums>,
    ) -> Bicoherence {
        let segments = self.realisations.segments;
        let count = self.triples.cells();
        let mut bins = Vec::with_capacity(count);
        bins.extend(self.triples.bins());
        let [mut bicoherence, mut biphase] = [(); 2].map(|()| Vec::with_capacity(count));
        for (value, phase) in cells {
            bicoherence.push(value);
            biphase.push(phase);
        }
        // Of two the less steady one, in each record.
        let steadiness = steadiness.of_least();
        Bicoherence {
            frequency: frequencies(segments.length, self.grid.time.step),
            time: self.grid.time.clone(),
            space: self.grid.space.clone(),
            site: self.request.site,
            output: self.request.output(),
            segment: [segments.length, segments.length - segments.hop],
            independence: self.independence(steadiness),
            alpha: self.request.alpha,
            map: BicoherenceMap {
                bins,
                bicoherence,
                biphase,
            },
            along: self.along(tiles),
        }
    }

    /// The chosen sites of each tile that has some.
    pub fn chosen_by_tile(&self) -> impl Iterator<Item = &[usize]> {
        let along = &self.request.along;
        along.chunk_by(|a, b| a / TOGETHER == b / TOGETHER)
    }
}

/// Index of the tile of the map.
const MAP: usize = 1;

/// Tiles are, in this order: how steady the map's records are, the map; and of each tile of sites, some of which are
/// chosen, how steady their records are, and each of them.
impl Divided for BicoherenceRequest {
    type Found = Bicoherence;

    fn gaps_and_memory(&self) -> (Gaps, Option<u64>) {
        (self.gaps, self.memory)
    }

    fn threads(&self) -> Option<usize> {
        self.threads
    }

    fn plan(&self, grid: &Grid) -> Result<Realisations> {
        self.realisations(grid)
    }

    fn tiles(&self, grid: &Grid, realisations: &Realisations) -> Vec<(SumsShape, usize)> {
        let pass = Pass::new(self, grid, realisations, 1);
        let steadiness = SumsShape {
            plain: 0,
            pieces: realisations.pieces(),
        };
        let own = TripleSums::shape(&pass.own);
        let mut tiles = vec![(steadiness, 1), (TripleSums::shape(&pass.triples), 1)];
        for chosen in pass.chosen_by_tile() {
            tiles.extend([(steadiness, 1), (own, chosen.len())]);
        }
        tiles
    }

    fn finishing(&self, (grid, realisations): (&Grid, &Realisations)) -> Finishing {
        let pass = Pass::new(self, grid, realisations, 1);
        let [arrays, found] = along::bytes(realisations, self.along.len());
        let (bins, sites) = (realisations.bins() as u64, grid.sites as u64);
        Finishing {
            result: (40 * pass.triples.cells() as u64 + arrays + OF_BIN * bins)
                .saturating_add(OF_SITE.saturating_mul(sites)),
            averages: found,
            later: 0,
        }
    }

    fn silent(&self, (grid, realisations): (&Grid, &Realisations)) -> Result<Bicoherence> {
        check_count(realisations.count())?;
        Ok(Pass::new(self, grid, realisations, 1).silent())
    }

    fn about_mean(&self) -> bool {
        self.averaging.detrend != Detrend::None
    }

    fn orders(&self, (grid, realisations): (&Grid, &Realisations)) -> Orders {
        let pass = Pass::new(self, grid, realisations, 1);
        let [map, own] = [&pass.triples, &pass.own].map(blocks);
        Box::new(move |tile, block| order(if tile == MAP { map } else { own }, block))
    }

    fn partial(
        &self,
        shots: &Shots<'_>,
        (grid, realisations): (&Grid, &Realisations),
        portions: &[Portion],
    ) -> Result<(f64, Vec<Vec<TreeNode>>)> {
        let pass = Pass::new(self, grid, realisations, shots.count());
        let (unit, sums) = pass.sum(shots, portions, false)?;
        let mut trees = vec![sums.steadiness.tree, sums.map];
        for tile in sums.tiles {
            if !tile.products.is_empty() {
                trees.push(tile.steadiness.tree);
                trees.extend(tile.products);
            }
        }
        Ok((
            unit,
            trees.into_iter().map(RecordTree::into_nodes).collect(),
        ))
    }

    fn combine(
        &self,
        (grid, realisations): (&Grid, &Realisations),
        records: usize,
        trees: Vec<RecordTree>,
        _unit: f64,
    ) -> Result<Bicoherence> {
        check_count(records * realisations.count())?;
        let pass = Pass::new(self, grid, realisations, records);
        let mut trees = trees.into_iter();
        let mut next = || trees.next().unwrap_or_default();
        let of_records = |tree| Steadiness {
            tree,
            ..Steadiness::default()
        };
        let (steadiness, map) = (of_records(next()), next());
        let mut tiles: Vec<TileSums> = Vec::new();
        for chosen in pass.chosen_by_tile() {
            let mut tile = TileSums::default();
            tile.steadiness = of_records(next());
            tile.products = chosen.iter().map(|_| next()).collect();
            tiles.push(tile);
        }
        tiles.par_iter_mut().for_each(|tile| {
            tile.gather(&pass);
        });
        Ok(pass.finish(AllSums {
            steadiness,
            map,
            tiles,
        }))
    }
}
