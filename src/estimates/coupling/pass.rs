//! The pass over the records of [`super::bicoherence()`].

use super::along::TileSums;
use super::bicoherence::{Bicoherence, BicoherenceMap, BicoherenceRequest};
use super::products::{TripleSums, sum_products, working_bytes};
use super::spectra::{Spectra, last_bin};
use super::triples::Triples;
use crate::error::Result;
use crate::estimates::realisations::{
    Grid, Independence, Portion, Realisations, Records, SegmentScratch, Shot, Shots, Sums,
    SumsShape, TOGETHER,
};

use crate::transform::{Segments, frequencies};

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
    /// Sums of a site that are no longer used.
    pub free: Vec<Sums>,
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
        let portions = self.realisations.whole_records(self.records);
        let held = self.held(shots.longest);
        let block = shots.block("the bispectra of this field", held)?;
        let (mut steadiness, mut map) = (None, None);
        let mut tiles = Vec::new();
        tiles.resize_with(shots.tiles(), TileSums::default);
        let mut left = portions.len();
        shots.each_portion(block, &portions, |shot, portion| {
            left -= 1;
            let mut scratch = Scratch::default();
            self.add_map(&mut scratch, (shot, portion), (&mut steadiness, &mut map));
            if self.request.along.is_empty() {
                return Ok(());
            }
            shot.each_tile("bispectra", &mut tiles, |scratch, sites, records, tile| {
                self.add_tile(scratch, (shot, portion), (sites, records), tile);
                if left == 0 {
                    scratch.free.extend(tile.gather(self));
                }
            })
        })?;
        Ok(self.finish(steadiness, map, tiles))
    }

    /// Bytes that are needed beside the samples, of which so many of a record are read.
    fn held(&self, samples: usize) -> u64 {
        let Segments { length, .. } = self.realisations.segments;
        let count = self.realisations.segments.count();
        let spectra = Spectra::bytes(length, count);
        let (threads, together) = (rayon::current_num_threads() as u64, TOGETHER as u64);
        // Sums of a record are apart until they are added.
        let nodes = 1 + u64::from(self.records > 1);
        let chosen = self.request.along.len() as u64;
        // Those that have a tile; the map has one.
        let tiles = threads.min(self.chosen_by_tile().count().max(1) as u64);
        let along = match self.records {
            1 => (tiles * together).min(chosen),
            _ => chosen * nodes + tiles,
        };
        let scratch = self.realisations.working_bytes();
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
        (steadiness, map): (&mut Option<Sums>, &mut Option<Sums>),
    ) {
        let sites = [self.request.site, self.request.output()];
        let sites = match sites[0] == sites[1] {
            true => &sites[..1],
            false => &sites[..],
        };
        let records: Vec<f64> = sites.iter().flat_map(|site| shot.record(*site)).collect();
        let records = Records::one_after_another(&records, records.len() / sites.len());
        let of = (shot, portion);
        self.add_steadiness(scratch, of, (sites, records), steadiness);
        let segments = &mut scratch.segments;
        let spectra = Spectra::of(self.realisations, records, shot.scale, segments);
        let (Some(x), Some(z)) = (spectra.first(), spectra.last()) else {
            return;
        };
        self.add_products(&self.triples, [x, z], (map, &mut Vec::new()), true);
    }

    /// Adds the products of a portion to those of a tree, in place of free sums where there are any.
    pub fn add_products(
        &self,
        triples: &Triples,
        [x, z]: [&Spectra; 2],
        (total, free): (&mut Option<Sums>, &mut Vec<Sums>),
        is_parallel: bool,
    ) {
        let mut sums = free.pop().unwrap_or_else(|| TripleSums::zeros(triples));
        sum_products(triples, x, z, &(0..x.count()), (&mut sums, is_parallel));
        match total {
            Some(total) => {
                total.add(&sums);
                free.push(sums);
            }
            None => *total = Some(sums),
        }
    }

    /// Adds how steady the records of a portion are.
    pub fn add_steadiness(
        &self,
        scratch: &mut Scratch,
        of: (&Shot<'_>, &Portion),
        (sites, records): (&[usize], Records<'_>),
        into: &mut Option<Sums>,
    ) {
        let pieces = self.realisations.pieces();
        let sums = into.get_or_insert_with(|| Sums::zeros(SumsShape { plain: 0, pieces }));
        let (sites, room) = (sites.iter().copied(), &mut scratch.deviations);
        self.realisations
            .add_steadiness(of, (sites, records), room, sums);
    }

    /// The number of independent realisations of records whose steadiness has this sum.
    pub fn independence(&self, steadiness: f64) -> Independence {
        let realisations = self.realisations;
        Independence::new(
            [self.records, realisations.segment_count(), 1],
            realisations.effective_products(3),
            steadiness / self.records as f64,
        )
        .of_samples(self.realisations.segments.record)
    }

    fn finish(
        &self,
        steadiness: Option<Sums>,
        map: Option<Sums>,
        tiles: Vec<TileSums>,
    ) -> Bicoherence {
        let total = map.unwrap_or_else(|| TripleSums::zeros(&self.triples));
        let products = TripleSums::of(&self.triples, &total);
        let scale = products.scale();
        let segments = self.realisations.segments;
        let mut bins = Vec::with_capacity(self.triples.cells());
        bins.extend(self.triples.bins());
        let cells = bins.iter().enumerate();
        let (bicoherence, biphase) = cells
            .map(|(cell, bins)| products.cell(cell, *bins, &scale))
            .unzip();
        // Of two the less steady one, in each record.
        let steadiness = steadiness.map_or(0.0, |sums| sums.least_steadiness());
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
