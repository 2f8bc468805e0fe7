//! The pass over the records of [`super::coherence()`].

use ndarray::Array2;
use num_complex::Complex;

use super::delay::DelaySearch;
use super::products::Products;
use super::{Coherence, CoherenceRequest};
use crate::error::{Error, Result};
use crate::estimates::parts::{Combined, Divided};
use crate::estimates::realisations::{
    Grid, KeptSegments, Portion, Realisations, Records, SegmentScratch, SegmentsLeft, Shot, Shots,
    Sums, SumsShape, TOGETHER, Tile, a_site, check_count, check_significance, share_that_counts,
};
use crate::numeric::lanes::{LaneBlock, widest};
use crate::prepare::Gaps;
use crate::transform::{fold, frequencies};

impl CoherenceRequest {
    pub(in crate::estimates) fn plan(&self, grid: &Grid) -> Result<Realisations> {
        let (site, expected) = (self.reference, a_site(grid.sites));
        Error::require(site < grid.sites, "reference", expected, site)?;
        check_significance(self.alpha)?;
        Realisations::new(&self.averaging, grid.times)
    }

    pub(in crate::estimates) fn pass<'a>(
        &'a self,
        realisations: &'a Realisations,
        grid: &'a Grid,
        records: usize,
    ) -> Pass<'a> {
        Pass {
            request: self,
            realisations,
            grid,
            records,
        }
    }
}

pub(in crate::estimates) struct Pass<'a> {
    request: &'a CoherenceRequest,
    realisations: &'a Realisations,
    grid: &'a Grid,
    /// Records of a site.
    records: usize,
}

/// Blocks of a bin: power of the site, real and imaginary part of the product with the reference; and power of the
/// reference in the segments of the site, where segments are left out.
const BLOCKS: usize = 3;

/// Bytes of a site, and of a frequency, beside the arrays: delays, velocities and what they are found with.
const OF_SITE: u64 = 256;
const OF_BIN: u64 = 192;

/// The conjugate transforms of the reference over a portion, and the segments that it keeps where some are left out.
type Reference = (Vec<Complex<f64>>, Option<KeptSegments>);

impl Pass<'_> {
    pub fn run(&self, shots: &Shots<'_>) -> Result<Coherence> {
        let tiles = self.sums(shots, &self.realisations.whole_records(self.records))?;
        self.finish(tiles)
    }

    /// Bytes that are needed beside the samples, of which so many of a record are read.
    fn held(&self, samples: usize, portions: &[Portion]) -> u64 {
        let samples = samples as u64;
        let sites = self.grid.sites.next_multiple_of(TOGETHER) as u64;
        let bins = self.realisations.bins() as u64;
        let scratch = self.realisations.working_bytes();
        // Of a site.
        let sums = self.shape().bytes() / TOGETHER as u64;
        let longest = portions.iter().map(|portion| portion.segments.len()).max();
        let realisations = longest.unwrap_or(0) * self.realisations.tapers();
        let pass = 16 * bins * realisations as u64
            + self.grid.threads() * (8 * TOGETHER as u64 * samples + scratch);
        // Delays are searched once the sums are gone.
        let beyond = (sites * sums + pass).saturating_sub(self.search_bytes());
        self.result_bytes() + beyond + self.realisations.bytes()
    }

    fn search_bytes(&self) -> u64 {
        let length = self.realisations.segments.length;
        DelaySearch::working_bytes(length, self.grid.threads())
    }

    /// The transforms of the reference.
    fn reference(&self, shot: &Shot<'_>) -> Reference {
        let (bins, tapers) = (self.realisations.bins(), self.realisations.tapers());
        let site = self.request.reference;
        let segments = &shot.portion.segments;
        let mut spectra = Vec::with_capacity(segments.len() * tapers * bins);
        let conjugate = |_: usize, found: &[Complex<f64>]| {
            spectra.extend(found.iter().map(|x| x.conj()));
        };
        let record = shot.record(site);
        let (record, mut scratch) = (Records::interleaved(&record, 1), SegmentScratch::default());
        self.realisations
            .each_of(&shot.portion, record, &mut scratch, conjugate);
        let kept = shot.kept(site..site + 1, self.realisations.segments);
        (spectra, kept.into_iter().next())
    }

    /// Adds the segments of a tile to its sums.
    fn add(
        &self,
        (shot, (reference, kept)): (&Shot<'_>, &Reference),
        scratch: &mut SegmentScratch,
        tile: Tile<'_>,
        sums: &mut Sums,
    ) {
        let (bins, tapers) = (self.realisations.bins(), self.realisations.tapers());
        let (width, first) = (tile.1.width(), shot.portion.segments.start * tapers);
        let add =
            |sums: &mut [LaneBlock], r: usize, spectra: &[Complex<f64>], has: &[f64; TOGETHER]| {
                let other = &reference[(r - first) * bins..][..bins];
                let (own, cross) = sums.split_at_mut(bins);
                let (re, cross) = cross.split_at_mut(bins);
                let (im, beside) = cross.split_at_mut(bins);
                widest(Products {
                    spectra,
                    width,
                    reference: other,
                    has,
                    sums: [own, re, im],
                });
                for (y, beside) in other.iter().zip(beside) {
                    beside.add(has.map(|has| has * y.norm_sqr()));
                }
            };
        let scratch = (kept.as_ref(), scratch);
        shot.add(self.realisations, tile, scratch, sums, add);
    }

    fn finish(&self, tiles: Vec<Sums>) -> Result<Coherence> {
        let left = tiles.iter().flat_map(|tile| &tile.left);
        let left = self.realisations.segments_left(self.records, left)?;
        let mut found = self.estimate(&tiles, left);
        drop(tiles);
        found.judge(self.realisations);
        Ok(found)
    }

    /// What sums over all realisations say, without intervals, delays and speeds.
    fn estimate(&self, tiles: &[Sums], left: Option<SegmentsLeft>) -> Coherence {
        let (realisations, grid) = (self.realisations, self.grid);
        let (records, length) = (self.records, realisations.segments.length);
        let (bins, reference) = (realisations.bins(), self.request.reference);
        let steadiness = tiles[reference / TOGETHER].steadiness(reference);
        let steadiness = steadiness / records as f64;
        let density = grid.time.step / (records * realisations.count()) as f64;
        // Of a site from which segments are left out.
        let part = |j: usize| match &left {
            None if tiles[j / TOGETHER].steadiness(j).is_nan() => f64::NAN,
            None => 1.0,
            // 0 / 0 where none are left.
            Some(left) => left.of as f64 / left.left[j] as f64,
        };
        let parts: Vec<f64> = (0..grid.sites).map(part).collect();
        let shape = (bins, grid.sites);
        // Power, product and, where segments are left out, power of the reference in those that are not.
        let of_tile = |what: usize, m: usize, j: usize| {
            tiles[j / TOGETHER].plain[what * bins + m].0[j % TOGETHER]
        };
        let cross = |m, j| Complex::new(of_tile(1, m, j), of_tile(2, m, j));
        let coherence = Array2::from_shape_fn(shape, |(m, j)| {
            let own = of_tile(0, m, j);
            let beside = match &left {
                Some(_) => of_tile(BLOCKS, m, j),
                None => of_tile(0, m, reference),
            };
            match own > 0.0 && beside > 0.0 && !parts[j].is_nan() {
                true => (cross(m, j).norm_sqr() / (beside * own)).min(1.0),
                // 0 / 0 where one of them is still; none where too much was filled.
                false => f64::NAN,
            }
        });
        let phase = Array2::from_shape_fn(shape, |(m, j)| cross(m, j).arg());
        let of_reference = (1..bins).map(|m| of_tile(0, m, reference));
        let samples = realisations.segments.record;
        let counting = share_that_counts(steadiness, samples, (of_reference, length));
        let independence = realisations.independence(records, left.as_ref(), steadiness);
        let independence = independence.of_uneven(counting);
        let spectrum = Array2::from_shape_fn(shape, |(m, j)| {
            let scale = density * fold(m, length);
            of_tile(0, m, j) * scale * parts[j]
        });
        Coherence {
            frequency: frequencies(length, grid.time.step),
            time: grid.time.clone(),
            space: grid.space.clone(),
            unit: grid.unit.clone(),
            reference,
            segment: [length, length - realisations.segments.hop],
            independence,
            segments_left: left,
            alpha: self.request.alpha,
            phase_interval: Array2::from_elem(shape, f64::NAN),
            coherence,
            phase,
            spectrum,
            is_coherent: vec![false; grid.sites],
            is_both_ways: false,
            delays: vec![None; grid.sites],
            speeds: Vec::new(),
            velocity: None,
        }
    }
}

impl Divided for Pass<'_> {
    fn shape(&self) -> SumsShape {
        let leaves_out = self.request.gaps == Gaps::LeaveOut;
        let blocks = BLOCKS + usize::from(leaves_out);
        self.realisations.shape(blocks * self.realisations.bins())
    }

    fn result_bytes(&self) -> u64 {
        let (bins, sites) = (self.realisations.bins() as u64, self.grid.sites as u64);
        let of_sites = (4 * 8 * bins + OF_SITE).saturating_mul(sites);
        // Delays are searched in the arrays.
        of_sites.saturating_add(OF_BIN * bins + self.search_bytes())
    }

    fn sums(&self, shots: &Shots<'_>, portions: &[Portion]) -> Result<Vec<Sums>> {
        let held = self.held(shots.longest, portions);
        let block = shots.block("the cross-spectra of this field", held)?;
        shots.sum(
            ("cross-spectra", block, shots.tiles()),
            portions,
            || Sums::zeros(self.shape()),
            |shot| self.reference(shot),
            |shot, scratch, tile, sums| self.add(shot, scratch, tile, sums),
        )
    }

    fn combine(&self, sums: Vec<Sums>) -> Result<Combined> {
        check_count(self.records * self.realisations.count())?;
        let found = self.finish(sums)?;
        Ok(Combined::Coherence(Box::new(found)))
    }
}
