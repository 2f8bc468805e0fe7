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
    Grid, KeptOfSites, Portion, Realisations, Records, SegmentScratch, SegmentsLeft, Shot, Shots,
    Sums, SumsShape, TOGETHER, a_site, check_count, check_significance,
};
use crate::numeric::lanes::widest;
use crate::numeric::pieces;
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
        let others = realisations.bins() - 1;
        let equal = pieces(others, others.div_ceil(BANDS).max(OF_BAND));
        let equal = equal.map(|band| band.start + 1..band.end + 1);
        Pass {
            request: self,
            realisations,
            grid,
            records,
            bands: std::iter::once(0..1).chain(equal).collect(),
        }
    }
}

pub(in crate::estimates) struct Pass<'a> {
    request: &'a CoherenceRequest,
    realisations: &'a Realisations,
    grid: &'a Grid,
    /// Records of a site.
    records: usize,
    /// Of bins: that of the mean, and equal ones.
    bands: Vec<Range<usize>>,
}

/// Bands of equal width in which it is told how evenly realisations share their power, and bins of one at least.
const BANDS: usize = 8;
const OF_BAND: usize = 8;

/// Blocks of a bin: power of the site, real and imaginary part of the product with the reference; and power of the
/// reference in the segments of the site, where segments are left out.
const BLOCKS: usize = 3;

/// Bytes of a site, and of a frequency, beside the arrays: delays, velocities and what they are found with.
const OF_SITE: u64 = 256;
const OF_BIN: u64 = 192;

/// The conjugate transforms of the reference over a portion.
struct Reference {
    spectra: Vec<Complex<f64>>,
    /// Power of each of them in each band.
    levels: Vec<f64>,
    /// Of the first of them.
    first: usize,
    kept: KeptOfSites,
}

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
        let longest = portions.iter().map(|portion| portion.segments.len());
        let realisations = longest.max().unwrap_or(0) * self.realisations.tapers();
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
        let mut levels = Vec::new();
        let conjugate = |_: usize, found: &[Complex<f64>]| {
            spectra.extend(found.iter().map(|x| x.conj()));
            let power = |band: &Range<usize>| -> f64 {
                found[band.clone()].iter().map(Complex::norm_sqr).sum()
            };
            levels.extend(self.bands.iter().map(power));
        };
        let record = shot.record(site);
        let (record, mut scratch) = (Records::interleaved(&record, 1), SegmentScratch::default());
        self.realisations
            .each_of(&shot.portion, record, &mut scratch, conjugate);
        Reference {
            spectra,
            levels,
            first: segments.start * tapers,
            kept: shot.kept(site..site + 1, self.realisations.segments),
        }
    }

    /// Adds the segments of a tile to its sums.
    fn add(
        &self,
        scratch: &mut SegmentScratch,
        (shot, reference): (&Shot<'_>, &Reference),
        (sites, records): (Range<usize>, Records<'_>),
        sums: &mut Sums,
    ) {
        let (bins, tapers) = (self.realisations.bins(), self.realisations.tapers());
        // The segments that each site keeps with the reference.
        let kept = shot.kept(sites.clone(), self.realisations.segments);
        let kept = kept.with(&reference.kept);
        kept.add_to(&mut sums.left, self.realisations.distances());
        // How steady the reference is, and which sites are marked.
        let mut marks = shot.mark(sites.clone()).into_iter();
        if sites.contains(&self.request.reference) || marks.any(f64::is_nan) {
            self.realisations
                .add_steadiness(shot, (sites, records), scratch, sums);
        }
        let visit = |r: usize, spectra: &[Complex<f64>]| {
            let other = &reference.spectra[(r - reference.first) * bins..][..bins];
            let levels = &reference.levels[(r - reference.first) * self.bands.len()..];
            let has = kept.has(r / tapers);
            let (shared, own) = sums.plain.split_at_mut(self.bands.len());
            let (own, cross) = own.split_at_mut(bins);
            let (re, cross) = cross.split_at_mut(bins);
            let (im, beside) = cross.split_at_mut(bins);
            widest(Products {
                spectra,
                width: records.width(),
                reference: other,
                has: &has,
                sums: [own, re, im],
                bands: (&self.bands, levels, shared),
            });
            for (y, beside) in other.iter().zip(beside) {
                let sums = beside.0.iter_mut().zip(&has);
                sums.for_each(|(sum, has)| *sum += has * y.norm_sqr());
            }
        };
        self.realisations
            .each_of(&shot.portion, records, scratch, visit);
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
        let steadiness = tiles[reference / TOGETHER].steadiness()[reference % TOGETHER];
        let steadiness = steadiness / records as f64;
        let independence = realisations.independence(records, left.as_ref(), steadiness);
        let density = grid.time.step / (records * realisations.count()) as f64;
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
            let block = self.bands.len() + what * bins + m;
            tiles[j / TOGETHER].plain[block].0[j % TOGETHER]
        };
        let of_reference = |m: usize, j: usize| match &left {
            Some(_) => of_tile(BLOCKS, m, j),
            None => of_tile(0, m, reference),
        };
        let cross = |m, j| Complex::new(of_tile(1, m, j), of_tile(2, m, j));
        let coherence = Array2::from_shape_fn(shape, |(m, j)| {
            let (own, beside) = (of_tile(0, m, j), of_reference(m, j));
            match own > 0.0 && beside > 0.0 && !parts[j].is_nan() {
                true => (cross(m, j).norm_sqr() / (beside * own)).min(1.0),
                // 0 / 0 where one of them is still; none where too much was filled.
                false => f64::NAN,
            }
        });
        let phase = Array2::from_shape_fn(shape, |(m, j)| cross(m, j).arg());
        let independent = Array2::from_shape_fn((self.bands.len(), grid.sites), |(b, j)| {
            let own: f64 = self.bands[b].clone().map(|m| of_tile(0, m, j)).sum();
            let beside: f64 = self.bands[b].clone().map(|m| of_reference(m, j)).sum();
            let count = (records * realisations.count()) as f64 / parts[j];
            let shared = tiles[j / TOGETHER].plain[b].0[j % TOGETHER];
            // What is related is uneven together, by chance.
            let band = coherence.slice(ndarray::s![self.bands[b].clone(), j]);
            let related = band.sum() * realisations.shared_bins() / band.len().pow(2) as f64;
            let evenness = own * beside / (count * shared) * (1.0 + related);
            let all = match &left {
                Some(left) if !independence.is_transient() => left.effective[j],
                _ => independence.independent.unwrap_or(f64::NAN),
            };
            match all >= 2.0 {
                // What is still has none.
                true if j != reference && evenness < 1.0 => (all * evenness).max(1.0),
                true => all,
                false => f64::NAN,
            }
        });
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
            bands: self.bands.clone(),
            independent,
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
        SumsShape {
            plain: self.bands.len() + (BLOCKS + usize::from(leaves_out)) * self.realisations.bins(),
            pieces: self.realisations.pieces(),
        }
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
        let mut tiles = vec![None; shots.tiles()];
        shots.each_portion(block, portions, |shot| {
            let reference = self.reference(shot);
            shot.each_tile(
                "cross-spectra",
                &mut tiles,
                |scratch, sites, records, tile| {
                    let sums = tile.get_or_insert_with(|| Sums::zeros(self.shape()));
                    self.add(scratch, (shot, &reference), (sites, records), sums);
                },
            )
        })?;
        Ok(tiles.into_iter().flatten().collect())
    }

    fn combine(&self, sums: Vec<Sums>) -> Result<Combined> {
        check_count(self.records * self.realisations.count())?;
        let found = self.finish(sums)?;
        Ok(Combined::Coherence(Box::new(found)))
    }
}
