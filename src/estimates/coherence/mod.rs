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
use crate::estimates::realisations::{
    Averaging, Independence, KeptSegments, Realisations, SegmentPairs, SegmentScratch,
    SegmentsLeft, Shot, Shots, TOGETHER, first_of, no_segment_left, steadiness, steadiness_without,
};
use crate::field::{Axis, Field};
use crate::observer::Observer;
use crate::prepare::Gaps;
use crate::system::threads::in_pool;
use crate::transform::{RecordTransform, fold, frequencies};
use delay::DelaySearch;
use phase::{Phases, least_coherence};

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
    /// Unit of the samples.
    pub unit: Option<String>,
    /// Index of the reference.
    pub reference: usize,
    /// Samples of a segment, and shared by neighbours.
    pub segment: [usize; 2],
    /// Of the site with the median number of segments, where segments with missing samples are left out.
    pub independence: Independence,
    /// What is left of each site with the reference, where segments in which either misses samples are left out;
    /// `None` with other [`CoherenceRequest::gaps`].
    pub segments_left: Option<SegmentsLeft>,
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

    /// The independent realisations of a site with the reference; `None` where no significance can be stated.
    fn independent_at(&self, site: usize) -> Option<f64> {
        match &self.segments_left {
            None => self.independence.independent,
            Some(_) if self.independence.is_transient() => self.independence.independent,
            Some(left) => Some(left.effective[site]).filter(|independent| *independent >= 2.0),
        }
    }

    /// The [level](Self::level) of a site, from which its own segments may be left out.
    pub fn level_at(&self, site: usize) -> Option<f64> {
        let independent = self.independent_at(site);
        let independence = Independence {
            independent,
            ..self.independence
        };
        independence.level(self.alpha)
    }

    /// Share of the cells above the level, of those away from the reference, from 0 and from the Nyquist
    /// frequency; `None` where no significance can be stated.
    pub fn above_level(&self) -> Option<f64> {
        self.level()?;
        let levels: Vec<Option<f64>> = (0..self.coherence.ncols())
            .map(|j| self.level_at(j))
            .collect();
        let inside = 1..self.segment[0].div_ceil(2);
        let rows = self.coherence.slice(ndarray::s![inside, ..]);
        let cells = rows
            .indexed_iter()
            .filter(|((_, j), g)| *j != self.reference && g.is_finite())
            .filter_map(|((_, j), g)| Some((*g, levels[j]?)));
        let (count, above) = cells.fold((0u64, 0u64), |(count, above), (g, level)| {
            (count + 1, above + u64::from(g > level))
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
        let (gaps, memory) = (request.gaps, request.memory);
        let reached = realisations.reached();
        let pass = Pass {
            shots: Shots::new(fields, gaps, memory, reached, observer)?,
            request,
            realisations: &realisations,
        };
        pass.run(first)
    })
}

/// The first of the fields, whose axes all have.
fn check<'a>(fields: &[&'a Field], request: &CoherenceRequest) -> Result<&'a Field> {
    let first = first_of(fields)?;
    let refuse = |option, expected: String, found: String| {
        Err(Error::Request {
            option,
            expected,
            found,
        })
    };
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

struct Pass<'a> {
    shots: Shots<'a>,
    request: &'a CoherenceRequest,
    realisations: &'a Realisations,
}

/// Sums over realisations.
struct Sums {
    tiles: Vec<TileSums>,
    /// Of the reference.
    reference: Vec<f64>,
    steadiness: f64,
}

/// Sums of a few sites, `[bin * width + site]`.
#[derive(Clone)]
struct TileSums {
    own: Vec<f64>,
    cross: Vec<Complex<f64>>,
    /// Where segments with missing samples are left out: of the reference, in the segments of each site; what is
    /// left of each.
    reference: Vec<f64>,
    left: Vec<SegmentPairs>,
}

impl Pass<'_> {
    fn run(&self, first: &Field) -> Result<Coherence> {
        let bins = self.realisations.bins();
        let block = self
            .shots
            .block("the cross-spectra of this field", self.held(first))?;
        let tiles = (0..self.shots.tiles()).map(|tile| self.shots.sites(tile).len() * bins);
        let tiles = tiles.map(|cells| TileSums {
            own: vec![0.0; cells],
            cross: vec![Complex::default(); cells],
            reference: Vec::new(),
            left: Vec::new(),
        });
        let mut sums = Sums {
            tiles: tiles.collect(),
            reference: vec![0.0; bins],
            steadiness: 0.0,
        };
        let unit = self.shots.each(block, |shot| self.add(shot, &mut sums))?;
        if let Some(left) = self.segments_left(&sums)
            && left.left.iter().all(|left| *left == 0)
        {
            return Err(no_segment_left(self.realisations.segments.length));
        }
        Ok(self.finish(first, &sums, unit))
    }

    /// Bytes that are needed beside the samples.
    fn held(&self, field: &Field) -> u64 {
        let (samples, sites) = (field.n_times() as u64, field.n_sites() as u64);
        let bins = self.realisations.bins() as u64;
        let length = self.realisations.segments.length;
        let threads = rayon::current_num_threads() as u64;
        let scratch = RecordTransform::<f64>::working_bytes(length, length, TOGETHER);
        24 * sites * bins
            + 5 * 8 * sites * bins
            + 16 * bins * self.realisations.count() as u64
            + threads * (8 * TOGETHER as u64 * samples + scratch)
    }

    /// Adds the realisations of one shot.
    fn add(&self, shot: &Shot<'_>, sums: &mut Sums) -> Result<()> {
        let bins = self.realisations.bins();
        let record = shot.record(self.request.reference);
        let missing = shot.missing(self.request.reference);
        sums.steadiness += match &missing[..] {
            [] => steadiness(&record),
            missing => steadiness_without(&record, missing),
        };
        let segments = self.realisations.segments;
        let of_reference = shot.kept(self.request.reference, segments);
        let squared = shot.scale * shot.scale;
        // Conjugate transforms of the reference, realisation by realisation.
        let mut reference = Vec::with_capacity(self.realisations.count() * bins);
        let mut scratch = SegmentScratch::default();
        self.realisations.each(&record, &mut scratch, |_, spectra| {
            for (sum, x) in sums.reference.iter_mut().zip(spectra) {
                *sum += x.norm_sqr() * squared;
            }
            reference.extend(spectra.iter().map(|x| x.conj() * squared));
        });
        let add = |scratch: &mut SegmentScratch,
                   sites: Range<usize>,
                   samples: &[f64],
                   sums: &mut TileSums| {
            let width = sites.len();
            if let Some(of_reference) = &of_reference {
                let kept = sites.clone().filter_map(|site| shot.kept(site, segments));
                let kept: Vec<KeptSegments> = kept.map(|kept| kept.and(of_reference)).collect();
                self.add_kept(samples, scratch, (&reference, squared), &kept, sums);
                return;
            }
            self.realisations.each(samples, scratch, |r, spectra| {
                let reference = &reference[r * bins..][..bins];
                let rows = spectra.chunks_exact(width).zip(reference);
                let own = sums.own.chunks_exact_mut(width);
                let sums = own.zip(sums.cross.chunks_exact_mut(width));
                for ((spectra, reference), (own, cross)) in rows.zip(sums) {
                    for ((x, own), cross) in spectra.iter().zip(own).zip(cross) {
                        *own += x.norm_sqr() * squared;
                        *cross += reference * x;
                    }
                }
            });
        };
        shot.each_tile("cross-spectra", &mut sums.tiles, add)
    }

    /// Adds the segments that each site keeps with the reference, whose conjugate transforms are given with the
    /// square that others are multiplied by.
    fn add_kept(
        &self,
        samples: &[f64],
        scratch: &mut SegmentScratch,
        (reference, squared): (&[Complex<f64>], f64),
        kept: &[KeptSegments],
        sums: &mut TileSums,
    ) {
        let (bins, width) = (self.realisations.bins(), kept.len());
        let tapers = self.realisations.tapers();
        let distances = self.realisations.distances();
        sums.reference.resize(sums.own.len(), 0.0);
        sums.left.resize_with(width, SegmentPairs::default);
        let left = sums.left.iter_mut().zip(kept);
        left.for_each(|(left, kept)| left.add(kept, distances));
        self.realisations.each(samples, scratch, |r, spectra| {
            let reference = &reference[r * bins..][..bins];
            for (j, kept) in kept.iter().enumerate() {
                if !kept.has(r / tapers) {
                    continue;
                }
                for (m, y) in reference.iter().enumerate() {
                    let (cell, x) = (m * width + j, spectra[m * width + j]);
                    sums.own[cell] += x.norm_sqr() * squared;
                    sums.cross[cell] += y * x;
                    // The transform of the reference has the square already.
                    sums.reference[cell] += y.norm_sqr() / squared;
                }
            }
        });
    }

    fn segments_left(&self, sums: &Sums) -> Option<SegmentsLeft> {
        let shared = self.realisations.shared();
        let sites = sums.tiles.iter().flat_map(|tile| &tile.left);
        let left: Vec<usize> = sites.clone().map(|site| site.segments() as usize).collect();
        let effective = |site: &SegmentPairs| self.realisations.effective_of(site, &shared);
        (!left.is_empty()).then(|| SegmentsLeft {
            of: self.realisations.segments.count() * self.shots.count(),
            left,
            effective: sites.map(effective).collect(),
        })
    }

    fn finish(&self, field: &Field, sums: &Sums, unit: f64) -> Coherence {
        let realisations = self.realisations;
        let (records, length) = (self.shots.count(), realisations.segments.length);
        let left = self.segments_left(sums);
        let (segments, effective) = match &left {
            None => (realisations.segments.count(), realisations.effective()),
            Some(left) => (
                left.least_and_median()[1] / records,
                left.median_effective() / records as f64,
            ),
        };
        let independence = Independence::new(
            [records, segments, realisations.tapers()],
            effective,
            sums.steadiness / records as f64,
        );
        // The sums of site j at frequency m.
        let of = |m: usize, j: usize| {
            let cell = m * self.shots.sites(j / TOGETHER).len() + j % TOGETHER;
            let tile = &sums.tiles[j / TOGETHER];
            let reference = match tile.reference.get(cell) {
                Some(reference) => *reference,
                None => sums.reference[m],
            };
            (tile.own[cell], tile.cross[cell], reference)
        };
        let shape = (realisations.bins(), field.n_sites());
        let coherence = Array2::from_shape_fn(shape, |(m, j)| match of(m, j) {
            // 0 / 0 where one of them is still.
            (own, cross, reference) if own > 0.0 => (cross.norm_sqr() / (reference * own)).min(1.0),
            _ => f64::NAN,
        });
        let phase = Array2::from_shape_fn(shape, |(m, j)| of(m, j).1.arg());
        let density = field.time.step * unit * unit / (records * realisations.count()) as f64;
        // Of a site from which segments are left out.
        let part = |j: usize| match &left {
            None => 1.0,
            // 0 / 0 where none are left.
            Some(left) => left.of as f64 / left.left[j] as f64,
        };
        let spectrum = Array2::from_shape_fn(shape, |(m, j)| {
            of(m, j).0 * density * fold(m, length) * part(j)
        });
        let mut found = Coherence {
            frequency: frequencies(length, field.time.step),
            time: field.time.clone(),
            space: field.space.clone(),
            unit: field.unit.clone(),
            reference: self.request.reference,
            segment: [length, length - realisations.segments.hop],
            independence,
            segments_left: left,
            alpha: self.request.alpha,
            phase_interval: Array2::from_elem(shape, f64::NAN),
            coherence,
            phase,
            spectrum,
            delays: vec![None; field.n_sites()],
            speeds: Vec::new(),
        };
        found.judge(realisations.shared_bins());
        found
    }
}

impl Coherence {
    /// Intervals, delays and speeds, where the coherence is above the level.
    fn judge(&mut self, shared_bins: f64) {
        let sites = 0..self.coherence.ncols();
        // Of each site, where significance can be stated: NaN is no number to be above.
        let known: Vec<[f64; 2]> = sites
            .map(|j| match (self.level_at(j), self.independent_at(j)) {
                (Some(level), Some(independent)) => [level, independent],
                _ => [f64::NAN; 2],
            })
            .collect();
        if known.iter().all(|[level, _]| level.is_nan()) {
            return;
        }
        let spread = |j: usize| (-self.alpha.ln() / (known[j][1] - 1.0)).exp_m1();
        let spreads: Vec<f64> = (0..known.len()).map(spread).collect();
        let interval = |((_, j), g): ((usize, usize), &f64)| match *g > known[j][0] {
            true => (spreads[j] * (1.0 - g) / g).sqrt().min(1.0).asin(),
            false => f64::NAN,
        };
        let intervals: Vec<f64> = self.coherence.indexed_iter().map(interval).collect();
        self.phase_interval
            .iter_mut()
            .zip(intervals)
            .for_each(|(to, interval)| *to = interval);
        let search = DelaySearch::new(self.segment[0], self.time.step, shared_bins);
        let columns = self.coherence.axis_iter(Along(1)).into_par_iter();
        self.delays = columns
            .zip(self.phase.axis_iter(Along(1)))
            .zip(known.par_iter())
            .map(|((coherence, phase), known)| match known[0].is_nan() {
                true => None,
                false => search.find(&coherence.to_vec(), &phase.to_vec(), *known),
            })
            .collect();
        let position: Vec<f64> = (0..self.coherence.ncols())
            .map(|j| self.space.at(j))
            .collect();
        let least: Vec<f64> = spreads.iter().map(|s| least_coherence(*s)).collect();
        let independent: Vec<f64> = known.iter().map(|known| known[1]).collect();
        let inside = 1..self.segment[0].div_ceil(2);
        let speeds = inside.filter_map(|m| {
            let phases = Phases {
                frequency: self.frequency[m],
                phase: &self.phase.row(m).to_vec(),
                coherence: &self.coherence.row(m).to_vec(),
                position: &position,
                reference: self.reference,
                least: &least,
                independent: &independent,
            };
            phases.speed()
        });
        self.speeds = speeds.collect();
    }
}
