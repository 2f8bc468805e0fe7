//! Coherence, phase and delay of all sites against a reference.

mod delay;
mod phase;

pub use delay::Delay;
pub use phase::PhaseSpeed;

use std::ops::Range;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, Axis as Along};
use num_complex::Complex;

use crate::error::{Error, Result};
use crate::estimates::parts::Divided;
use crate::estimates::realisations::{
    Averaging, Grid, Independence, Portion, Realisations, RecordTree, SegmentScratch, SegmentTree,
    Shot, Shots, Sums, TOGETHER, TreeNode, first_of, held_at_once,
};
use crate::field::{Axis, Field};
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::threads::in_pool;
use crate::transform::{RecordTransform, fold, frequencies};
use delay::DelaySearch;
use phase::{Phases, least_coherence};

/// All choices of [`coherence`].
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CoherenceRequest {
    /// Index of the site that all others are compared with.
    pub reference: usize,
    pub averaging: Averaging,
    pub gaps: Gaps,
    /// Probability by which the level of significance is exceeded by chance.
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    #[serde(skip)]
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
    #[serde(skip)]
    pub memory: Option<u64>,
}

impl Default for CoherenceRequest {
    fn default() -> Self {
        CoherenceRequest {
            reference: 0,
            averaging: Averaging::default(),
            gaps: Gaps::Refuse,
            alpha: 0.05,
            threads: None,
            memory: None,
        }
    }
}

/// What [`coherence`] finds. Arrays are `(frequency, site)`.
#[derive(Debug, Clone)]
pub struct Coherence {
    /// Frequencies in cycles per unit of time.
    pub frequency: Vec<f64>,
    pub time: Axis,
    pub space: Axis,
    /// Index of the reference.
    pub reference: usize,
    /// Samples of a segment, and shared by neighbours.
    pub segment: [usize; 2],
    pub independence: Independence,
    pub alpha: f64,
    /// Magnitude-squared coherence `|S_rj|^2 / (S_rr S_jj)`, 0 to 1; NaN where a spectrum is 0.
    pub coherence: Array2<f64>,
    /// Phase of `S_rj = <conj(X_r) X_j>`, in rad: `-k (x_j - x_r)` of a wave `exp(i (k x - omega t))`.
    pub phase: Array2<f64>,
    /// Half of the interval of the phase at `1 - alpha`; NaN where the coherence is not above the level.
    pub phase_interval: Array2<f64>,
    /// One-sided power spectral density of each site, in the square of the samples' unit over frequency.
    pub spectrum: Array2<f64>,
    /// Delay of each site behind the reference.
    pub delays: Vec<Option<Delay>>,
    /// Wavenumber and phase velocity, for frequencies at which enough sites are coherent.
    pub speeds: Vec<PhaseSpeed>,
}

impl Coherence {
    /// The coherence that one cell exceeds by chance with probability `alpha`; `None` where no
    /// significance can be stated.
    pub fn level(&self) -> Option<f64> {
        self.independence.level(self.alpha)
    }

    /// Share of the cells above the level, of those away from the reference, from 0 and from the Nyquist
    /// frequency; `None` where no significance can be stated.
    pub fn above_level(&self) -> Option<f64> {
        let level = self.level()?;
        let inside = 1..self.segment[0].div_ceil(2);
        let rows = self.coherence.slice(ndarray::s![inside, ..]);
        let cells = rows
            .indexed_iter()
            .filter(|((_, j), g)| *j != self.reference && g.is_finite());
        let (count, above) = cells.fold((0u64, 0u64), |(count, above), (_, g)| {
            (count + 1, above + u64::from(*g > level))
        });
        (count > 0).then(|| above as f64 / count as f64)
    }

    /// Positions of the sites.
    pub fn positions(&self) -> Vec<f64> {
        (0..self.coherence.ncols())
            .map(|j| self.space.at(j))
            .collect()
    }

    /// Words for the units of time and of length.
    pub fn units(&self) -> (String, String) {
        let word = |axis: &Axis, counted: &str| axis.unit.clone().unwrap_or_else(|| counted.into());
        (word(&self.time, "sample"), word(&self.space, "site"))
    }
}

/// Coherence, phase and delay of every site against a reference.
///
/// # Equation
/// With `X` the transforms of the realisations, `S_ij = <conj(X_i) X_j>` their mean,
///
/// ```text
/// g_j(f) = |S_rj|^2 / (S_rr S_jj),    phase_j(f) = arg S_rj(f).
/// ```
///
/// Of K independent realisations of records without a common part, `g` has the mean `1 / K` and exceeds
/// `1 - alpha^{1/(K-1)}` with probability alpha. The phase deviates by less than
///
/// ```text
/// asin sqrt((alpha^{-1/(K-1)} - 1) (1 - g) / g)
/// ```
///
/// with probability `1 - alpha`; that is below a right angle exactly where `g` is above the level.
///
/// # Shapes
/// Each field is one record of every site (a shot); all have the same axes. Results: `(frequency, site)`.
///
/// # Units
/// Phases in rad, delays in units of time, wavenumbers in rad per unit of length.
///
/// # Errors
/// [`Error::Request`] for fields with different axes, a reference that is no site, segments that do not fit, and
/// fewer than two realisations, with which the coherence is 1 whatever the data are;
/// [`Error::NonFinite`]; [`Error::Memory`]; [`Error::Cancelled`]; [`Error::Threads`].
///
/// # Source
/// J. S. Bendat, A. G. Piersol, "Random Data", 4th ed. (2010), sections 9.2 and 11.2; G. C. Carter, C. H.
/// Knapp, A. H. Nuttall (1973) for the level; L. H. Koopmans, "The Spectral Analysis of Time Series" (1974),
/// section 8.4, for the interval of the phase.
pub fn coherence(
    fields: &[&Field],
    request: &CoherenceRequest,
    observer: &dyn Observer,
) -> Result<Coherence> {
    let grid = Grid::of(first_of(fields)?);
    let realisations = request.plan(&grid)?;
    check_count(fields.len() * realisations.count())?;
    in_pool(request.threads, || {
        let (gaps, memory) = (request.gaps, request.memory);
        let shots = Shots::new(fields, gaps, memory, realisations.reached(), observer)?;
        request
            .pass(&grid, &realisations, fields.len())
            .run(&shots)
    })
}

impl CoherenceRequest {
    fn check(&self, grid: &Grid) -> Result<()> {
        let refuse = |option, expected: String, found: String| {
            Err(Error::Request {
                option,
                expected,
                found,
            })
        };
        if self.reference >= grid.sites {
            let expected = format!("a site from 0 to {}", grid.sites - 1);
            return refuse("reference", expected, self.reference.to_string());
        }
        if !(self.alpha > 0.0 && self.alpha < 1.0) {
            let expected = "a probability between 0 and 1".to_owned();
            return refuse("significance", expected, self.alpha.to_string());
        }
        Ok(())
    }

    fn pass<'a>(
        &'a self,
        grid: &Grid,
        realisations: &'a Realisations,
        records: usize,
    ) -> Pass<'a> {
        Pass {
            request: self,
            realisations,
            grid: grid.clone(),
            records,
        }
    }
}

/// That there are two realisations at least.
fn check_count(realisations: usize) -> Result<()> {
    if realisations >= 2 {
        return Ok(());
    }
    Err(Error::Request {
        option: "segment",
        expected: "at least two realisations: shorter segments, several tapers, or several fields"
            .into(),
        found: "one segment of one field under one taper".into(),
    })
}

struct Pass<'a> {
    request: &'a CoherenceRequest,
    realisations: &'a Realisations,
    grid: Grid,
    /// Records of a site.
    records: usize,
}

#[derive(Default)]
struct Scratch {
    segments: SegmentScratch,
    deviations: Vec<f64>,
    tree: SegmentTree,
}

impl Pass<'_> {
    fn run(&self, shots: &Shots<'_>) -> Result<Coherence> {
        let whole = (0..self.records).map(|record| self.realisations.whole(record));
        let (unit, trees) = self.sum(shots, &whole.collect::<Vec<Portion>>())?;
        Ok(self.finish(trees, unit))
    }

    /// The sums of every tile over these portions, and the unit of the samples.
    fn sum(&self, shots: &Shots<'_>, portions: &[Portion]) -> Result<(f64, Vec<RecordTree>)> {
        let is_all = portions.iter().all(|portion| portion.is_whole);
        let block = shots.block("the cross-spectra of this field", self.held(is_all))?;
        let mut trees = Vec::new();
        trees.resize_with(shots.tiles(), RecordTree::default);
        let unit = shots.each_portion(block, portions, |shot, portion| {
            self.add(shot, portion, &mut trees)
        })?;
        Ok((unit, trees))
    }

    /// Bytes that are needed beside the samples.
    fn held(&self, is_all: bool) -> u64 {
        let samples = self.grid.times as u64;
        let sites = self.grid.sites.next_multiple_of(TOGETHER) as u64;
        let bins = self.realisations.bins() as u64;
        let length = self.realisations.segments.length;
        let threads = rayon::current_num_threads() as u64;
        let scratch = RecordTransform::<f64>::working_bytes(length, length, TOGETHER);
        let sums = 8 * Sums::blocks(self.plain(), self.realisations.pieces()) as u64;
        let of_segments = held_at_once(self.realisations.segments.count());
        let kept = match is_all {
            true => held_at_once(self.records),
            false => 2 * (2 * of_segments + held_at_once(self.records)),
        };
        sites * kept * sums
            + 4 * 8 * sites * bins
            + 16 * bins * self.realisations.count() as u64
            + threads * (TOGETHER as u64 * (8 * samples + of_segments * sums) + scratch)
    }

    /// Blocks of the sums of a tile: of each bin its power, and the real and imaginary part of the product.
    fn plain(&self) -> usize {
        3 * self.realisations.bins()
    }

    fn zeros(&self) -> Sums {
        Sums::zeros(self.plain(), self.realisations.pieces())
    }

    /// Adds the realisations of a portion of one shot.
    fn add(&self, shot: &Shot<'_>, portion: &Portion, trees: &mut [RecordTree]) -> Result<()> {
        let (bins, tapers) = (self.realisations.bins(), self.realisations.tapers());
        let record = shot.record(self.request.reference);
        let squared = shot.scale * shot.scale;
        // Conjugate transforms of the reference, realisation by realisation.
        let mut reference = Vec::with_capacity(portion.segments.len() * tapers * bins);
        let mut scratch = SegmentScratch::default();
        let conjugate = |_: usize, spectra: &[Complex<f64>]| {
            reference.extend(spectra.iter().map(|x| x.conj() * squared));
        };
        self.realisations.each_of(portion, &record, &mut scratch, conjugate);
        let first = portion.segments.start * tapers;
        let tile_of_reference = self.request.reference / TOGETHER * TOGETHER;
        let add = |scratch: &mut Scratch,
                   sites: Range<usize>,
                   samples: &[f64],
                   records: &mut RecordTree| {
            let Scratch {
                segments,
                deviations,
                tree,
            } = scratch;
            let width = sites.len();
            let visit = |r: usize, spectra: &[Complex<f64>]| {
                let (segment, taper) = (r / tapers, r % tapers);
                if taper == 0 {
                    let sums = tree.open(segment, tapers == 1, || self.zeros());
                    if sites.start == tile_of_reference {
                        let pieces = (portion, segment, samples, shot.scale);
                        self.realisations.add_pieces(pieces, deviations, sums);
                    }
                }
                let Some(sums) = tree.current() else {
                    return;
                };
                let reference = &reference[(r - first) * bins..][..bins];
                let (own, cross) = sums.plain_mut().split_at_mut(bins);
                let (re, im) = cross.split_at_mut(bins);
                let rows = spectra.chunks_exact(width).zip(reference);
                for (((row, reference), own), (re, im)) in
                    rows.zip(own).zip(re.iter_mut().zip(im))
                {
                    let cross = own.0.iter_mut().zip(re.0.iter_mut().zip(&mut im.0));
                    for (x, (own, (re, im))) in row.iter().zip(cross) {
                        let product = reference * x;
                        *own += x.norm_sqr() * squared;
                        *re += product.re;
                        *im += product.im;
                    }
                }
                if taper + 1 == tapers {
                    tree.close();
                }
            };
            self.realisations.each_of(portion, samples, segments, visit);
            records.take(tree, portion.record, portion.is_whole, false);
        };
        shot.each_tile("cross-spectra", trees, add)
    }

    fn finish(&self, trees: Vec<RecordTree>, unit: f64) -> Coherence {
        let (realisations, grid) = (self.realisations, &self.grid);
        let (records, length) = (self.records, realisations.segments.length);
        let (bins, reference) = (realisations.bins(), self.request.reference);
        let total = |mut tree: RecordTree| tree.total().unwrap_or_else(|| self.zeros());
        let tiles: Vec<Sums> = trees.into_iter().map(total).collect();
        let steadiness = tiles[reference / TOGETHER].steadiness()[reference % TOGETHER];
        let independence = Independence::new(
            [
                records,
                realisations.segments.count(),
                realisations.tapers(),
            ],
            realisations.effective(),
            steadiness / records as f64,
        );
        // The sums of site j at frequency m.
        let of = |m: usize, j: usize| {
            let (blocks, lane) = (tiles[j / TOGETHER].plain(), j % TOGETHER);
            let [own, re, im] = [m, bins + m, 2 * bins + m].map(|block| blocks[block].0[lane]);
            (own, Complex::new(re, im))
        };
        let shape = (bins, grid.sites);
        let coherence = Array2::from_shape_fn(shape, |(m, j)| match of(m, j) {
            // 0 / 0 where one of them is still.
            (own, cross) if own > 0.0 => (cross.norm_sqr() / (of(m, reference).0 * own)).min(1.0),
            _ => f64::NAN,
        });
        let phase = Array2::from_shape_fn(shape, |(m, j)| of(m, j).1.arg());
        let density = grid.time.step * unit * unit / (records * realisations.count()) as f64;
        let spectrum =
            Array2::from_shape_fn(shape, |(m, j)| of(m, j).0 * density * fold(m, length));
        let mut found = Coherence {
            frequency: frequencies(length, grid.time.step),
            time: grid.time.clone(),
            space: grid.space.clone(),
            reference,
            segment: [length, length - realisations.segments.hop],
            independence,
            alpha: self.request.alpha,
            phase_interval: Array2::from_elem(shape, f64::NAN),
            coherence,
            phase,
            spectrum,
            delays: vec![None; grid.sites],
            speeds: Vec::new(),
        };
        if let (Some(level), Some(independent)) = (found.level(), independence.independent) {
            found.judge(level, independent, realisations.shared_bins());
        }
        found
    }
}

impl Divided for CoherenceRequest {
    type Found = Coherence;

    fn gaps_and_memory(&self) -> (Gaps, Option<u64>) {
        (self.gaps, self.memory)
    }

    fn threads(&self) -> Option<usize> {
        self.threads
    }

    fn plan(&self, grid: &Grid) -> Result<Realisations> {
        self.check(grid)?;
        Realisations::new(&self.averaging, grid.times)
    }

    fn zeros(&self, grid: &Grid, realisations: &Realisations) -> Vec<Sums> {
        let pass = self.pass(grid, realisations, 1);
        vec![pass.zeros(); grid.sites.div_ceil(TOGETHER)]
    }

    fn about_mean(&self) -> bool {
        false
    }

    fn partial(
        &self,
        shots: &Shots<'_>,
        (grid, realisations): (&Grid, &Realisations),
        portions: &[Portion],
    ) -> Result<(f64, Vec<Vec<TreeNode>>)> {
        let (unit, trees) = self
            .pass(grid, realisations, shots.count())
            .sum(shots, portions)?;
        Ok((unit, trees.into_iter().map(RecordTree::into_nodes).collect()))
    }

    fn combine(
        &self,
        (grid, realisations): (&Grid, &Realisations),
        records: usize,
        trees: Vec<RecordTree>,
        unit: f64,
    ) -> Result<Coherence> {
        check_count(records * realisations.count())?;
        Ok(self.pass(grid, realisations, records).finish(trees, unit))
    }
}

impl Coherence {
    /// Intervals, delays and speeds, where the coherence is above the level.
    fn judge(&mut self, level: f64, independent: f64, shared_bins: f64) {
        let spread = (-self.alpha.ln() / (independent - 1.0)).exp_m1();
        self.phase_interval = self.coherence.mapv(|g| match g > level {
            true => (spread * (1.0 - g) / g).sqrt().min(1.0).asin(),
            false => f64::NAN,
        });
        let known = [level, independent, shared_bins];
        let search = DelaySearch::new(self.segment[0], self.time.step, known);
        let columns = self.coherence.axis_iter(Along(1)).into_par_iter();
        self.delays = columns
            .zip(self.phase.axis_iter(Along(1)))
            .map(|(coherence, phase)| search.find(&coherence.to_vec(), &phase.to_vec()))
            .collect();
        let position: Vec<f64> = (0..self.coherence.ncols())
            .map(|j| self.space.at(j))
            .collect();
        let inside = 1..self.segment[0].div_ceil(2);
        let speeds = inside.filter_map(|m| {
            let phases = Phases {
                frequency: self.frequency[m],
                phase: &self.phase.row(m).to_vec(),
                coherence: &self.coherence.row(m).to_vec(),
                position: &position,
                reference: self.reference,
                least: least_coherence(spread),
                independent,
            };
            phases.speed()
        });
        self.speeds = speeds.collect();
    }
}
