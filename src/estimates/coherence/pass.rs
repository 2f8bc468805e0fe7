//! The pass over the records of [`super::coherence()`].

use std::ops::Range;

use ndarray::Array2;
use num_complex::Complex;

use super::delay::DelaySearch;
use super::products::Products;
use super::{Coherence, CoherenceRequest};
use crate::error::{Error, Result};
use crate::estimates::parts::{Combined, Divided};
use crate::estimates::realisations::{
    Grid, KeptOfSites, Portion, Realisations, Records, SegmentPairs, SegmentScratch, SegmentsLeft,
    Shot, Shots, Sums, SumsShape, TOGETHER, check_count, check_significance, check_squares,
};
use crate::prepare::Gaps;
use crate::transform::{fold, frequencies};

impl CoherenceRequest {
    pub(in crate::estimates) fn plan(&self, grid: &Grid) -> Result<Realisations> {
        if self.reference >= grid.sites {
            let expected = format!("a site from 0 to {}", grid.sites.saturating_sub(1));
            return Err(Error::request("reference", expected, self.reference));
        }
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

#[derive(Default)]
struct Scratch {
    segments: SegmentScratch,
    deviations: Vec<f64>,
}

/// Sums of a few sites.
#[derive(Default)]
struct TileSums {
    sums: Option<Sums>,
    /// Where segments with missing samples are left out: what is left of each site.
    left: Vec<SegmentPairs>,
}

/// Blocks of a bin: power of the site, real and imaginary part of the product with the reference; and power of the
/// reference in the segments of the site, where segments are left out.
const BLOCKS: usize = 3;

/// Bytes of a site, and of a frequency, beside the arrays: delays, velocities and what they are found with.
const OF_SITE: u64 = 256;
const OF_BIN: u64 = 192;

/// The conjugate transforms of the reference over a portion.
struct Reference {
    spectra: Vec<Complex<f64>>,
    /// Of the first of them.
    first: usize,
    squared: f64,
    kept: KeptOfSites,
}

impl Pass<'_> {
    pub fn run(&self, shots: &Shots<'_>) -> Result<Coherence> {
        let (unit, tiles) = self.sum(shots, &self.realisations.whole_records(self.records))?;
        self.finish(tiles, unit)
    }

    /// The sums of every tile over these portions, and the unit of the samples.
    fn sum(&self, shots: &Shots<'_>, portions: &[Portion]) -> Result<(f64, Vec<TileSums>)> {
        let held = self.held(shots.longest, portions);
        let block = shots.block("the cross-spectra of this field", held)?;
        let mut tiles = Vec::new();
        tiles.resize_with(shots.tiles(), TileSums::default);
        let unit = shots.each_portion(block, portions, |shot, portion| {
            self.add(shot, portion, &mut tiles)
        })?;
        Ok((unit, tiles))
    }

    fn leaves_out(&self) -> bool {
        self.request.gaps == Gaps::LeaveOut
    }

    /// Bytes that are needed beside the samples, of which so many of a record are read.
    fn held(&self, samples: usize, portions: &[Portion]) -> u64 {
        let samples = samples as u64;
        let sites = self.grid.sites.next_multiple_of(TOGETHER) as u64;
        let bins = self.realisations.bins() as u64;
        let scratch = self.realisations.working_bytes();
        // Of a site.
        let sums = self.shape().bytes() / TOGETHER as u64;
        let longest = portions.iter().map(|portion| portion.segments.len());
        let realisations = longest.max().unwrap_or(0) * self.realisations.tapers();
        let pass = 16 * bins * realisations as u64
            + self.grid.threads() * (8 * TOGETHER as u64 * samples + scratch);
        // Delays are searched once the sums are gone.
        let [result, search] = self.of_results();
        result + (sites * sums + pass).max(search) + self.realisations.bytes()
    }

    /// Bytes of the arrays, and of the search of delays.
    fn of_results(&self) -> [u64; 2] {
        let (bins, sites) = (self.realisations.bins() as u64, self.grid.sites as u64);
        let length = self.realisations.segments.length;
        let of_sites = (4 * 8 * bins + OF_SITE).saturating_mul(sites);
        let result = of_sites.saturating_add(OF_BIN * bins);
        let search = DelaySearch::working_bytes(length, self.grid.threads());
        [result, search]
    }

    /// The transforms of the reference.
    fn reference(&self, shot: &Shot<'_>, portion: &Portion) -> Reference {
        let (bins, tapers) = (self.realisations.bins(), self.realisations.tapers());
        let (site, squared) = (self.request.reference, shot.scale * shot.scale);
        let mut spectra = Vec::with_capacity(portion.segments.len() * tapers * bins);
        let mut scratch = SegmentScratch::default();
        let conjugate = |_: usize, found: &[Complex<f64>]| {
            spectra.extend(found.iter().map(|x| x.conj() * squared));
        };
        let record = shot.record(site);
        let record = Records::interleaved(&record, 1);
        self.realisations
            .each_of(portion, record, &mut scratch, conjugate);
        Reference {
            spectra,
            first: portion.segments.start * tapers,
            squared,
            kept: shot.kept(site..site + 1, self.realisations.segments),
        }
    }

    /// Adds the realisations of a portion of one shot.
    fn add(&self, shot: &Shot<'_>, portion: &Portion, tiles: &mut [TileSums]) -> Result<()> {
        let reference = self.reference(shot, portion);
        shot.each_tile("cross-spectra", tiles, |scratch, sites, records, tile| {
            self.add_tile(scratch, (shot, portion), (sites, records), &reference, tile);
        })
    }

    /// Adds the segments of a tile to its sums.
    fn add_tile(
        &self,
        scratch: &mut Scratch,
        (shot, portion): (&Shot<'_>, &Portion),
        (sites, records): (Range<usize>, Records<'_>),
        reference: &Reference,
        tile: &mut TileSums,
    ) {
        let (bins, tapers) = (self.realisations.bins(), self.realisations.tapers());
        // The segments that each site keeps with the reference.
        let kept = shot.kept(sites.clone(), self.realisations.segments);
        let kept = kept.with(&reference.kept);
        kept.add_to(&mut tile.left, self.realisations.distances());
        let sums = tile.sums.get_or_insert_with(|| Sums::zeros(self.shape()));
        // How steady the reference is, and which sites are marked.
        let mut marks = shot.mark(sites.clone()).into_iter();
        if sites.contains(&self.request.reference) || marks.any(f64::is_nan) {
            let (of, of_sites) = ((shot, portion), (sites, records));
            let room = &mut scratch.deviations;
            self.realisations.add_steadiness(of, of_sites, room, sums);
        }
        let visit = |r: usize, spectra: &[Complex<f64>]| {
            let other = &reference.spectra[(r - reference.first) * bins..][..bins];
            let has = kept.has(r / tapers);
            let (own, cross) = sums.plain_mut().split_at_mut(bins);
            let (re, cross) = cross.split_at_mut(bins);
            let (im, beside) = cross.split_at_mut(bins);
            Products {
                spectra,
                width: records.width(),
                reference: other,
                squared: reference.squared,
                has: &has,
                sums: [own, re, im],
            }
            .add();
            for (y, beside) in other.iter().zip(beside) {
                // The transform of the reference has the square already.
                let power = y.norm_sqr() / reference.squared;
                let sums = beside.0.iter_mut().zip(&has);
                sums.for_each(|(sum, has)| *sum += has * power);
            }
        };
        let segments = &mut scratch.segments;
        self.realisations.each_of(portion, records, segments, visit);
    }

    fn finish(&self, tiles: Vec<TileSums>, unit: f64) -> Result<Coherence> {
        check_squares(unit)?;
        let left = tiles.iter().flat_map(|tile| &tile.left);
        let left = self.realisations.segments_left(self.records, left)?;
        let zeros = || Sums::zeros(self.shape());
        let tiles = tiles.into_iter();
        let tiles: Vec<Sums> = tiles.map(|tile| tile.sums.unwrap_or_else(zeros)).collect();
        let mut found = self.estimate(&tiles, left, unit);
        drop(tiles);
        found.judge(self.realisations);
        Ok(found)
    }

    /// What sums over all realisations say, without intervals, delays and speeds.
    fn estimate(&self, tiles: &[Sums], left: Option<SegmentsLeft>, unit: f64) -> Coherence {
        let (realisations, grid) = (self.realisations, self.grid);
        let (records, length) = (self.records, realisations.segments.length);
        let (bins, reference) = (realisations.bins(), self.request.reference);
        let steadiness = tiles[reference / TOGETHER].steadiness()[reference % TOGETHER];
        let steadiness = steadiness / records as f64;
        let independence = realisations.independence(records, left.as_ref(), steadiness);
        let density = grid.time.step * unit * unit / (records * realisations.count()) as f64;
        // Of a site from which segments are left out.
        let part = |j: usize| match &left {
            None if tiles[j / TOGETHER].steadiness()[j % TOGETHER].is_nan() => f64::NAN,
            None => 1.0,
            // 0 / 0 where none are left.
            Some(left) => left.of as f64 / left.left[j] as f64,
        };
        let parts: Vec<f64> = (0..grid.sites).map(part).collect();
        let shape = (bins, grid.sites);
        // Power, product and, where segments are left out, power of the reference in those that are not.
        let of_tile = |what: usize, m: usize, j: usize| {
            tiles[j / TOGETHER].plain()[what * bins + m].0[j % TOGETHER]
        };
        let cross = |m, j| Complex::new(of_tile(1, m, j), of_tile(2, m, j));
        let coherence = Array2::from_shape_fn(shape, |(m, j)| {
            let own = of_tile(0, m, j);
            let beside = match self.leaves_out() {
                true => of_tile(BLOCKS, m, j),
                false => of_tile(0, m, reference),
            };
            match own > 0.0 && beside > 0.0 && !parts[j].is_nan() {
                true => (cross(m, j).norm_sqr() / (beside * own)).min(1.0),
                // 0 / 0 where one of them is still; none where too much was filled.
                false => f64::NAN,
            }
        });
        let phase = Array2::from_shape_fn(shape, |(m, j)| cross(m, j).arg());
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
        SumsShape {
            plain: (BLOCKS + usize::from(self.leaves_out())) * self.realisations.bins(),
            pieces: self.realisations.pieces(),
        }
    }

    fn result_bytes(&self) -> u64 {
        let [result, search] = self.of_results();
        result.saturating_add(search)
    }

    fn sums(&self, shots: &Shots<'_>, portions: &[Portion]) -> Result<(f64, Vec<Sums>)> {
        let (unit, tiles) = self.sum(shots, portions)?;
        let sums = tiles.into_iter().filter_map(|tile| tile.sums);
        Ok((unit, sums.collect()))
    }

    fn combine(&self, sums: Vec<Sums>, unit: f64) -> Result<Combined> {
        check_count(self.records * self.realisations.count())?;
        let tile = |sums| TileSums {
            sums: Some(sums),
            left: Vec::new(),
        };
        let found = self.finish(sums.into_iter().map(tile).collect(), unit)?;
        Ok(Combined::Coherence(Box::new(found)))
    }
}
