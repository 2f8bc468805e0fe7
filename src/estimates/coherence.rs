//! Coherence, phase and delay of all sites against a reference.

use std::ops::Range;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, Axis as Along};
use num_complex::Complex;

use super::averaging::{Averaging, Realisations, SegmentScratch};
use super::delay::{Delay, DelaySearch};
use super::ensemble::{Independence, steadiness};
use super::phase::{PhaseSpeed, Phases, least_coherence};
use crate::arrays::Precision;
use crate::error::{Error, Result};
use crate::field::{Axis, Field};
use crate::observer::Observer;
use crate::prepare::{Detrend, Gaps, Preparation, Prepared, ReadAhead, Tiles};
use crate::system::memory::half_of_free_memory;
use crate::system::threads::in_pool;
use crate::transform::{RecordTransform, fold, frequencies};

/// All choices of [`coherence`].
#[derive(Debug, Clone, PartialEq)]
pub struct CoherenceRequest {
    /// Index of the site that all others are compared with.
    pub reference: usize,
    pub averaging: Averaging,
    pub gaps: Gaps,
    /// Probability by which the level of significance is exceeded by chance.
    pub alpha: f64,
    /// Worker threads; `None`: one a core.
    pub threads: Option<usize>,
    /// Bytes of working memory; `None`: half of the free memory.
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
    let first = check(fields, request)?;
    let realisations = Realisations::new(&request.averaging, first.n_times())?;
    let all = fields.len() * realisations.count();
    if all < 2 {
        return Err(Error::Request {
            option: "segment",
            expected:
                "at least two realisations: shorter segments, several tapers, or several fields"
                    .into(),
            found: "one segment of one field under one taper".into(),
        });
    }
    in_pool(request.threads, || {
        let pass = Pass {
            fields,
            request,
            realisations: &realisations,
            observer,
        };
        pass.run(first)
    })
}

/// The first of the fields, whose axes all have.
fn check<'a>(fields: &[&'a Field], request: &CoherenceRequest) -> Result<&'a Field> {
    let refuse = |option, expected: String, found: String| {
        Err(Error::Request {
            option,
            expected,
            found,
        })
    };
    let Some((first, others)) = fields.split_first() else {
        return refuse("field", "at least one field".into(), "none".into());
    };
    let axes = |field: &Field| {
        let (time, space) = (&field.time, &field.space);
        let steps = (time.step, space.origin, space.step);
        let words = (time.unit.clone(), space.unit.clone(), field.unit.clone());
        ((field.n_times(), field.n_sites()), steps, words)
    };
    if let Some(other) = others.iter().find(|other| axes(other) != axes(first)) {
        let expected = format!(
            "fields with the axes of {}, {} times by {} sites",
            first.name,
            first.n_times(),
            first.n_sites()
        );
        let found = format!(
            "{} times by {} sites in {}, or another step or unit",
            other.n_times(),
            other.n_sites(),
            other.name
        );
        return refuse("field", expected, found);
    }
    if request.reference >= first.n_sites() {
        let expected = format!("a site from 0 to {}", first.n_sites() - 1);
        return refuse("reference", expected, request.reference.to_string());
    }
    if !(request.alpha > 0.0 && request.alpha < 1.0) {
        let expected = "a probability between 0 and 1".to_owned();
        return refuse("significance", expected, request.alpha.to_string());
    }
    Ok(first)
}

/// Sites that are transformed together.
const TOGETHER: usize = 8;

struct Pass<'a> {
    fields: &'a [&'a Field],
    request: &'a CoherenceRequest,
    realisations: &'a Realisations,
    observer: &'a dyn Observer,
}

/// Sums over realisations; a row a site.
struct Sums {
    own: Array2<f64>,
    cross: Array2<Complex<f64>>,
    /// Of the reference.
    reference: Vec<f64>,
    steadiness: f64,
}

impl Pass<'_> {
    fn run(&self, first: &Field) -> Result<Coherence> {
        let (n_sites, bins) = (first.n_sites(), self.realisations.bins());
        let block = self.block(first)?;
        let mut sums = Sums {
            own: Array2::zeros((n_sites, bins)),
            cross: Array2::zeros((n_sites, bins)),
            reference: vec![0.0; bins],
            steadiness: 0.0,
        };
        let mut unit = None;
        for field in self.fields {
            let prepared = self.prepared(field, block)?;
            let unit = *unit.get_or_insert(prepared.unit());
            self.add(&prepared, prepared.unit() / unit, block, &mut sums)?;
        }
        Ok(self.finish(first, &sums, unit.unwrap_or(1.0)))
    }

    /// Sites that are read at once; `None` for a field that fits into memory as it is.
    ///
    /// # Errors
    /// [`Error::Memory`].
    fn block(&self, field: &Field) -> Result<Option<usize>> {
        let (samples, sites) = (field.n_times() as u64, field.n_sites() as u64);
        let bins = self.realisations.bins() as u64;
        let length = self.realisations.segments.length;
        let threads = rayon::current_num_threads() as u64;
        let together = TOGETHER as u64;
        let scratch = RecordTransform::<f64>::working_bytes(length, length, TOGETHER);
        let tile = together * (8 * samples + 24 * bins) + scratch;
        let held = 24 * sites * bins
            + 4 * 8 * sites * bins
            + 16 * bins * self.realisations.count() as u64
            + threads * tile;
        let allowed = self.request.memory.unwrap_or_else(half_of_free_memory);
        let least = held + 8 * samples * together;
        if least > allowed {
            return Err(Error::Memory {
                what: "the cross-spectra of this field",
                needed: least,
                allowed,
            });
        }
        let mapped = 8 * samples * sites;
        if mapped <= (allowed - held).min(allowed / 4) {
            return Ok(None);
        }
        let sites = ((allowed - held) / (8 * samples)) as usize;
        Ok(Some((sites / TOGETHER * TOGETHER).max(TOGETHER)))
    }

    fn prepared<'f>(&self, field: &'f Field, block: Option<usize>) -> Result<Prepared<'f>> {
        let segments = self.realisations.segments;
        let preparation = Preparation {
            gaps: self.request.gaps,
            precision: Precision::F64,
            reached: segments.record - segments.left_over(),
            transforms_all: false,
            detrend_field_mean: false,
            detrend_space: Detrend::None,
            detrend_time: Detrend::None,
        };
        let tiles = Tiles {
            sites: TOGETHER,
            times: 32,
            ahead: block,
            memory: self.request.memory.unwrap_or_else(half_of_free_memory) / 4,
        };
        let (times, sites) = (0..field.n_times(), 0..field.n_sites());
        let prepared = Prepared::new(field, times, sites, preparation, tiles, self.observer);
        prepared.map(|(prepared, _)| prepared)
    }

    /// Adds the realisations of one field, whose samples count `scale` times.
    fn add(
        &self,
        prepared: &Prepared<'_>,
        scale: f64,
        block: Option<usize>,
        sums: &mut Sums,
    ) -> Result<()> {
        let (n_sites, bins) = (prepared.n_sites(), self.realisations.bins());
        let mut record = vec![0.0; prepared.n_times()];
        prepared.record(self.request.reference, &mut record);
        sums.steadiness += steadiness(&record);
        let mut reference = Vec::with_capacity(self.realisations.count() * bins);
        let mut scratch = SegmentScratch::default();
        self.realisations.each(&record, &mut scratch, |_, spectra| {
            for (sum, x) in sums.reference.iter_mut().zip(spectra) {
                *sum += x.norm_sqr() * scale * scale;
            }
            reference.extend(spectra.iter().map(|x| x.conj() * scale * scale));
        });
        self.observer.stage("cross-spectra", n_sites as u64);
        let block = block.unwrap_or(n_sites);
        let mut room = ReadAhead::default();
        for from in (0..n_sites).step_by(block) {
            let sites = from..n_sites.min(from + block);
            let ahead = prepared.read_ahead(sites.clone(), &mut room);
            let tile = Tile {
                pass: self,
                prepared,
                ahead,
                reference: &reference,
                scale,
            };
            let rows = ndarray::s![sites.clone(), ..];
            let (mut own, mut cross) = (sums.own.slice_mut(rows), sums.cross.slice_mut(rows));
            own.axis_chunks_iter_mut(Along(0), TOGETHER)
                .into_par_iter()
                .zip(cross.axis_chunks_iter_mut(Along(0), TOGETHER))
                .enumerate()
                .try_for_each_init(
                    TileScratch::default,
                    |scratch, (i, (mut own, mut cross))| {
                        if self.observer.cancelled() {
                            return Err(Error::Cancelled);
                        }
                        let first = sites.start + i * TOGETHER;
                        let sites = first..first + own.nrows();
                        self.observer.advance(sites.len() as u64);
                        tile.sum(sites, scratch);
                        for (c, mut row) in own.outer_iter_mut().enumerate() {
                            let width = cross.nrows();
                            for (m, sum) in row.iter_mut().enumerate() {
                                *sum += scratch.own[m * width + c];
                            }
                        }
                        let width = cross.nrows();
                        for (c, mut row) in cross.outer_iter_mut().enumerate() {
                            for (m, sum) in row.iter_mut().enumerate() {
                                *sum += scratch.cross[m * width + c];
                            }
                        }
                        Ok(())
                    },
                )?;
            prepared.release_pages();
        }
        Ok(())
    }

    fn finish(&self, field: &Field, sums: &Sums, unit: f64) -> Coherence {
        let realisations = self.realisations;
        let (records, length) = (self.fields.len(), realisations.segments.length);
        let independence = Independence::new(
            [
                records,
                realisations.segments.count(),
                realisations.tapers(),
            ],
            realisations.effective(),
            sums.steadiness / records as f64,
        );
        let of_cell = |j: usize, m: usize| {
            let product = sums.reference[m] * sums.own[[j, m]];
            // 0 / 0 where one of them is still.
            (sums.cross[[j, m]].norm_sqr() / product).min(1.0)
        };
        let shape = (realisations.bins(), field.n_sites());
        let coherence = Array2::from_shape_fn(shape, |(m, j)| match sums.own[[j, m]] > 0.0 {
            true => of_cell(j, m),
            false => f64::NAN,
        });
        let phase = Array2::from_shape_fn(shape, |(m, j)| sums.cross[[j, m]].arg());
        let density = field.time.step * unit * unit / (records * realisations.count()) as f64;
        let spectrum =
            Array2::from_shape_fn(shape, |(m, j)| sums.own[[j, m]] * density * fold(m, length));
        let mut found = Coherence {
            frequency: frequencies(length, field.time.step),
            time: field.time.clone(),
            space: field.space.clone(),
            reference: self.request.reference,
            segment: [length, length - realisations.segments.hop],
            independence,
            alpha: self.request.alpha,
            phase_interval: Array2::from_elem(shape, f64::NAN),
            coherence,
            phase,
            spectrum,
            delays: vec![None; field.n_sites()],
            speeds: Vec::new(),
        };
        if let (Some(level), Some(independent)) = (found.level(), independence.independent) {
            found.judge(level, independent, realisations.shared_bins());
        }
        found
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

/// What all tiles of a block read.
struct Tile<'t> {
    pass: &'t Pass<'t>,
    prepared: &'t Prepared<'t>,
    ahead: Option<&'t ReadAhead>,
    /// Conjugate transforms of the reference, realisation by realisation, times the square of `scale`.
    reference: &'t [Complex<f64>],
    scale: f64,
}

#[derive(Default)]
struct TileScratch {
    segments: SegmentScratch,
    samples: Vec<f64>,
    own: Vec<f64>,
    cross: Vec<Complex<f64>>,
}

impl Tile<'_> {
    /// Sums of a few sites, `[bin * width + site]`.
    fn sum(&self, sites: Range<usize>, scratch: &mut TileScratch) {
        let TileScratch {
            segments,
            samples,
            own,
            cross,
        } = scratch;
        let (width, bins) = (sites.len(), self.pass.realisations.bins());
        samples.resize(width * self.prepared.n_times(), 0.0);
        self.prepared.records(self.ahead, sites, samples);
        own.clear();
        own.resize(width * bins, 0.0);
        cross.clear();
        cross.resize(width * bins, Complex::default());
        let squared = self.scale * self.scale;
        self.pass
            .realisations
            .each(samples, segments, |r, spectra| {
                let reference = &self.reference[r * bins..][..bins];
                let rows = spectra.chunks_exact(width).zip(reference);
                let sums = own
                    .chunks_exact_mut(width)
                    .zip(cross.chunks_exact_mut(width));
                for ((spectra, reference), (own, cross)) in rows.zip(sums) {
                    for ((x, own), cross) in spectra.iter().zip(own).zip(cross) {
                        *own += x.norm_sqr() * squared;
                        *cross += reference * x;
                    }
                }
            });
    }
}
