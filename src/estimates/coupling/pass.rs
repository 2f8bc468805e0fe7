//! The pass over the records of [`super::bicoherence()`].

use super::along::TileSums;
use super::bicoherence::{Bicoherence, BicoherenceMap, BicoherenceRequest};
use super::products::{TripleSums, add_products};
use super::spectra::{Evenness, Spectra, last_bin};
use super::triples::Triples;
use crate::error::Result;
use crate::estimates::realisations::{
    Grid, Independence, Realisations, Records, SegmentScratch, Shot, Shots, Sums, SumsShape,
    TOGETHER, interleave,
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
        let mut steadiness = self.steadiness();
        let mut map = TripleSums::zeros(&self.triples);
        let mut evenness = self.evenness();
        let mut tiles = Vec::new();
        tiles.resize_with(shots.tiles(), TileSums::default);
        shots.each_portion(block, &portions, |shot| {
            self.add_map(shot, (&mut steadiness, &mut evenness), &mut map);
            if self.request.along.is_empty() {
                return Ok(());
            }
            shot.each_tile("bispectra", &mut tiles, |scratch, sites, records, tile| {
                self.add_tile(scratch, shot, (sites, records), tile);
                if shot.portion.record + 1 == self.records {
                    tile.gather(self);
                }
            })
        })?;
        Ok(self.finish((&steadiness, &evenness), &map, tiles))
    }

    /// Bytes that are needed beside the samples, of which so many of a record are read.
    fn held(&self, samples: usize) -> u64 {
        let Segments { length, .. } = self.realisations.segments;
        let count = self.realisations.segments.count();
        let spectra = Spectra::bytes(length, count);
        let (threads, together) = (rayon::current_num_threads() as u64, TOGETHER as u64);
        let chosen = self.request.along.len() as u64;
        // Those that have a tile; the map has one.
        let tiles = threads.min(self.chosen_by_tile().count().max(1) as u64);
        let along = match self.records {
            1 => (tiles * together).min(chosen),
            _ => chosen,
        };
        let scratch = self.realisations.working_bytes();
        let tile = together * (16 * samples as u64 + spectra) + scratch;
        let results = 96 * chosen * self.realisations.bins() as u64;
        TripleSums::bytes(&self.triples)
            + 40 * self.triples.cells() as u64
            + 2 * spectra
            + along * TripleSums::bytes(&self.own)
            + results
            + tiles * tile
    }

    /// Adds a shot to the map.
    fn add_map(
        &self,
        shot: &Shot<'_>,
        (steadiness, evenness): (&mut Sums, &mut Evenness),
        map: &mut TripleSums,
    ) {
        let mut sites = vec![self.request.site, self.request.output()];
        sites.dedup();
        let (mut rows, mut scratch) = (Vec::new(), SegmentScratch::default());
        let records: Vec<f64> = sites.iter().flat_map(|site| shot.record(*site)).collect();
        interleave(&records, records.len() / sites.len(), &mut rows);
        let records = Records::interleaved(&rows, sites.len());
        let of_sites = (sites.into_iter(), records);
        self.realisations
            .add_steadiness(shot, of_sites, &mut scratch, steadiness);
        let spectra = Spectra::of(self.realisations, records, &mut scratch);
        if let (Some(x), Some(z)) = (spectra.first(), spectra.last()) {
            add_products(&self.triples, [x, z], map, true);
            evenness.add(x, z);
        }
    }

    /// Sums of how steady records are.
    pub fn steadiness(&self) -> Sums {
        let pieces = self.realisations.pieces();
        Sums::zeros(SumsShape { plain: 0, pieces })
    }

    /// Of no realisations.
    pub fn evenness(&self) -> Evenness {
        Evenness::zeros(self.realisations.segments.length)
    }

    /// The number of independent realisations of records whose steadiness has this sum, which share what is `least` even.
    pub fn independence(&self, steadiness: f64, least: f64) -> Independence {
        let realisations = self.realisations;
        let counts = [self.records, realisations.segment_count(), 1];
        let (effective, steadiness) = (
            realisations.effective_products(3),
            steadiness / self.records as f64,
        );
        let samples = realisations.segments.record;
        Independence::new(counts, effective, steadiness, samples).of_uneven(least)
    }

    fn finish(
        &self,
        (steadiness, evenness): (&Sums, &Evenness),
        map: &TripleSums,
        tiles: Vec<TileSums>,
    ) -> Bicoherence {
        let is_one_site = self.request.site == self.request.output();
        let evenness = evenness.least(self.realisations.shared_bins(), is_one_site);
        let least = map.least();
        let segments = self.realisations.segments;
        let mut bins = Vec::with_capacity(self.triples.cells());
        bins.extend(self.triples.bins());
        let cells = bins.iter().enumerate();
        let (bicoherence, biphase) = cells
            .map(|(cell, bins)| match map.bicoherence(cell, *bins, least) {
                none if none.is_nan() => (none, none),
                found => (found, map.biphase(cell)),
            })
            .unzip();
        Bicoherence {
            frequency: frequencies(segments.length, self.grid.time.step),
            time: self.grid.time.clone(),
            space: self.grid.space.clone(),
            site: self.request.site,
            output: self.request.output(),
            segment: [segments.length, segments.length - segments.hop],
            // Of two the less steady one, in each record.
            independence: self.independence(steadiness.least_steadiness(), evenness),
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
