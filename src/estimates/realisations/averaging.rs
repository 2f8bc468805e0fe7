//! How one record gives several realisations.

use std::f64::consts::TAU;

use ndarray::{Array2, ArrayView1};
use num_complex::Complex;

use super::ensemble::Independence;
use super::kept::{KeptSegments, SegmentPairs, SegmentsLeft};
use super::part::Portion;
use super::records::Records;
use super::shots::TOGETHER;
use crate::error::{Error, Result};
use crate::prepare::{Detrend, Trend, Window, WindowError, slepian};
use crate::transform::{RecordScratch, RecordTransform, Segments};

/// The tapers of a segment.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tapers {
    /// One window: Welch's method.
    Window(Window),
    /// The first `count` Slepian sequences of time-bandwidth product `nw`: Thomson's multitaper method.
    /// At most `2 nw - 1` of them keep their energy inside the band.
    Slepian { nw: f64, count: usize },
}

impl Tapers {
    pub fn count(&self) -> usize {
        match self {
            Tapers::Window(_) => 1,
            Tapers::Slepian { count, .. } => *count,
        }
    }

    /// Half of the width that a line is spread over, in bins; `None` of a window.
    pub(crate) fn half_bandwidth(&self) -> Option<f64> {
        match self {
            Tapers::Window(_) => None,
            Tapers::Slepian { nw, .. } => Some(*nw),
        }
    }
}

/// How one record gives several realisations: overlapping segments, each under one or more tapers.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Averaging {
    /// Samples a segment; `None`: the whole record under several tapers, else the power of two at or
    /// below an eighth of it.
    pub segment: Option<usize>,
    /// Samples that neighbouring segments share; `None`: half a segment.
    pub overlap: Option<usize>,
    pub tapers: Tapers,
    /// Removed from each segment.
    pub detrend: Detrend,
}

impl Default for Averaging {
    fn default() -> Self {
        Averaging {
            segment: None,
            overlap: None,
            tapers: Tapers::Window(Window::USUAL),
            detrend: Detrend::Mean,
        }
    }
}

/// The realisations of a record of a certain length, planned.
pub(crate) struct Realisations {
    pub segments: Segments,
    /// Each with `sum w^2 = 1`.
    tapers: Vec<Vec<f64>>,
    /// Share of each taper's energy inside its band; 1 of a window.
    pub concentrations: Vec<f64>,
    transforms: Vec<RecordTransform<f64>>,
    detrend: Detrend,
    /// The segments that are visited, of every record; `None`: all.
    kept: Option<KeptSegments>,
}

/// Working space of one thread.
#[derive(Default)]
pub(crate) struct SegmentScratch {
    transform: RecordScratch<f64>,
    /// Of a segment, and without trends.
    rows: Vec<f64>,
    segments: Vec<f64>,
    trend: Vec<f64>,
}

impl Realisations {
    /// # Errors
    /// [`Error::Request`] for segments or tapers that do not fit a record of `n_times` samples.
    pub fn new(averaging: &Averaging, n_times: usize) -> Result<Self> {
        let segments = averaging.segments(n_times)?;
        let (tapers, concentrations) = averaging.weights(segments.length)?;
        let plan = |taper: &Vec<f64>| RecordTransform::new(taper, segments.length);
        let transforms = tapers.iter().map(plan).collect();
        Ok(Realisations {
            segments,
            tapers,
            concentrations,
            transforms,
            detrend: averaging.detrend,
            kept: None,
        })
    }

    /// Of every record the kept segments alone, which then count as if they followed one another.
    ///
    /// # Errors
    /// [`Error::Request`] where none is kept.
    pub fn keeping(mut self, kept: KeptSegments) -> Result<Self> {
        if kept.count() == 0 {
            return Err(no_segment_left(self.segments.length));
        }
        self.kept = Some(kept);
        Ok(self)
    }

    /// Segments of a record that are visited.
    pub fn segment_count(&self) -> usize {
        match &self.kept {
            Some(kept) => kept.count(),
            None => self.segments.count(),
        }
    }

    /// Realisations of a record.
    pub fn count(&self) -> usize {
        self.segment_count() * self.tapers.len()
    }

    pub fn tapers(&self) -> usize {
        self.tapers.len()
    }

    /// Whether an offset is not what moves.
    pub fn about_mean(&self) -> bool {
        self.detrend != Detrend::None
    }

    pub fn bins(&self) -> usize {
        self.segments.length / 2 + 1
    }

    /// `sum_n w_k(n)` of each taper, the transform at the frequency of a line; 0 of odd ones.
    pub fn taper_sums(&self) -> Vec<f64> {
        self.tapers.iter().map(|w| crate::numeric::sum(w)).collect()
    }

    /// Bytes of the tapers and of the plans of their transforms, at most: a sample has a weight, a copy of it in the plan, half
    /// a value of its transform and factors of the plan.
    pub fn bytes(&self) -> u64 {
        const OF_PLAN: usize = 16 << 10;
        let of_taper = 64 * self.segments.length + OF_PLAN;
        (self.tapers.len() as u64).saturating_mul(of_taper as u64)
    }

    /// Bytes of the scratch of one thread that transforms a tile.
    pub fn working_bytes(&self) -> u64 {
        let length = self.segments.length;
        RecordTransform::<f64>::working_bytes(length, length, TOGETHER)
    }

    /// Samples of a record that segments reach.
    pub fn reached(&self) -> usize {
        self.segments.record - self.segments.left_over()
    }

    /// Visits every realisation of `records`: its number and its spectra, `[bin * width + record]`. With samples `v`
    /// and spacing `dt`, `|X|^2 dt` is the power spectral density of one side.
    pub fn each(
        &self,
        records: Records<'_>,
        scratch: &mut SegmentScratch,
        visit: impl FnMut(usize, &[Complex<f64>]),
    ) {
        self.each_of(&self.whole(0), records, scratch, visit);
    }

    /// The same of a portion of the segments; `records` with the samples of the portion alone.
    pub fn each_of(
        &self,
        portion: &Portion,
        records: Records<'_>,
        scratch: &mut SegmentScratch,
        mut visit: impl FnMut(usize, &[Complex<f64>]),
    ) {
        let is_kept = |s: &usize| self.kept.as_ref().is_none_or(|kept| kept.has(*s));
        let kept = portion.segments.clone().filter(is_kept);
        for (s, segment) in (portion.segments.start..).zip(kept) {
            let start = segment * self.segments.hop - portion.samples.start;
            self.of_segment((s, start), records, scratch, &mut visit);
        }
    }

    /// Visits a segment from the start on.
    fn of_segment(
        &self,
        (s, start): (usize, usize),
        records: Records<'_>,
        scratch: &mut SegmentScratch,
        visit: &mut impl FnMut(usize, &[Complex<f64>]),
    ) {
        let (width, segments) = (records.width(), &mut scratch.segments);
        let rows = records.rows(start..start + self.segments.length, &mut scratch.rows);
        let rows = match self.detrend {
            Detrend::None => rows,
            kind => Trend::removed_across((rows, width), kind, segments, &mut scratch.trend),
        };
        for (k, taper) in self.transforms.iter().enumerate() {
            let spectra = taper.spectra_of_rows(rows, width, &mut scratch.transform);
            visit(s * self.tapers.len() + k, spectra);
        }
    }

    /// Removes the trends of segments that follow one another.
    pub fn remove_trends(&self, segments: &mut [f64], scratch: &mut SegmentScratch) {
        for segment in segments.chunks_exact_mut(self.segments.length) {
            Trend::remove_from(segment, self.detrend, |_| true, &mut scratch.trend);
        }
    }

    /// The spectra under one taper of segments that follow one another, without their trends: `[bin * width +
    /// segment]`.
    pub fn under_taper<'s>(
        &self,
        taper: usize,
        segments: &[f64],
        scratch: &'s mut SegmentScratch,
    ) -> &'s [Complex<f64>] {
        let segments = segments.chunks_exact(self.segments.length);
        let taper = &self.transforms[taper];
        taper.transform(segments, &mut scratch.transform).0
    }

    /// Share of the power of white noise that detrending takes of each bin: of each polynomial that is removed, with a sum of
    /// squares of 1, its power under the tapers.
    pub fn lost(&self) -> Vec<f64> {
        let (length, mut lost) = (self.segments.length, vec![0.0; self.bins()]);
        let removed = match self.detrend {
            Detrend::None => 0,
            Detrend::Mean => 1,
            Detrend::Linear => 2,
        };
        let mut scratch = RecordScratch::default();
        for degree in 0..removed {
            let centred = |n: usize| n as f64 - 0.5 * (length as f64 - 1.0);
            let polynomial: Vec<f64> = (0..length).map(|n| centred(n).powi(degree)).collect();
            let all = crate::numeric::sum_of_squares(&polynomial) * self.tapers.len() as f64;
            for transform in &self.transforms {
                let polynomial = std::iter::once(&polynomial[..]);
                let found = transform.transform(polynomial, &mut scratch).0;
                let cells = lost.iter_mut().zip(found);
                cells.for_each(|(lost, x)| *lost += x.norm_sqr() / all);
            }
        }
        lost
    }

    /// The tapers, each with `sum w^2 = 1`.
    pub fn taper_samples(&self) -> &[Vec<f64>] {
        &self.tapers
    }

    /// `sum_n w_k(n) exp(2 pi i d n / N)` of each taper, what a line that is `d` bins above a bin has there.
    pub fn taper_transforms<const D: usize>(&self, offsets: &[f64; D]) -> Vec<[Complex<f64>; D]> {
        let length = self.segments.length as f64;
        let transform = |taper: &Vec<f64>, offset: f64| -> Complex<f64> {
            let turn = |n: usize| TAU * offset * n as f64 / length;
            let term = |(n, w): (usize, &f64)| Complex::from_polar(*w, turn(n));
            taper.iter().enumerate().map(term).sum()
        };
        let of = |taper: &Vec<f64>| offsets.map(|offset| transform(taper, offset));
        self.tapers.iter().map(of).collect()
    }

    /// How many independent realisations of white noise have the variance of this average,
    ///
    /// ```text
    /// K = R^2 / sum_{r r'} |sum_n w_r(n) w_r'(n)|^2,
    /// ```
    ///
    /// with the tapers of all segments in their places. Source: Welch (1967), eq. 12, for one window;
    /// the same sum for several.
    pub fn effective(&self) -> f64 {
        self.effective_products(2)
    }

    /// The same of means of products of `order` transforms, whose phases cancel: the sums of shared tapers
    /// to that power. Neighbouring products of three have less in common than powers.
    pub fn effective_products(&self, order: i32) -> f64 {
        let shared = shared_products(&self.tapers, self.segments, order);
        effective_number(self.tapers.len(), &self.pairs(), &shared)
    }

    /// Pairs of visited segments that overlap, by their distance.
    fn pairs(&self) -> Vec<f64> {
        let distances = self.distances();
        let count = self.segments.count();
        match &self.kept {
            Some(kept) => kept.pairs(distances),
            None => (0..distances).map(|j| (count - j) as f64).collect(),
        }
    }

    /// Distances, in segments, at which segments overlap, 0 among them.
    pub fn distances(&self) -> usize {
        let Segments { length, hop, .. } = self.segments;
        length.div_ceil(hop).min(self.segments.count())
    }

    /// What is left of each site of so many records; `None` where no segments are left out.
    ///
    /// # Errors
    /// [`Error::Request`] where no site has any.
    pub fn segments_left<'p>(
        &self,
        records: usize,
        sites: impl Iterator<Item = &'p SegmentPairs> + Clone,
    ) -> Result<Option<SegmentsLeft>> {
        let left: Vec<usize> = sites.clone().map(|site| site.segments() as usize).collect();
        if left.is_empty() {
            return Ok(None);
        }
        if left.iter().all(|left| *left == 0) {
            return Err(no_segment_left(self.segments.length));
        }
        let shared = shared_products(&self.tapers, self.segments, 2);
        let effective = |pairs: &SegmentPairs| match pairs.segments() > 0.0 {
            true => effective_number(self.tapers.len(), pairs.by_distance(), &shared),
            false => 0.0,
        };
        Ok(Some(SegmentsLeft {
            of: self.segments.count() * records,
            left,
            effective: sites.map(effective).collect(),
        }))
    }

    /// How many of the realisations of so many records are independent; `left`: of these segments, where some are left out.
    pub fn independence(
        &self,
        records: usize,
        left: Option<&SegmentsLeft>,
        steadiness: f64,
    ) -> Independence {
        let (segments, effective) = match left {
            None => (self.segment_count(), self.effective()),
            Some(left) => {
                let effective = left.median_effective() / records as f64;
                (left.least_and_median()[1] / records, effective)
            }
        };
        Independence::new([records, segments, self.tapers()], effective, steadiness)
            .of_samples(self.segments.record)
    }

    /// The same as [`Self::effective`] of the parts of the transforms along a line and beside it: along `u_k`, the direction of the
    /// tapers' sums, and at right angles to it.
    ///
    /// ```text
    /// K_1 = S^2 / sum_{s s'} (u^T G u)^2,    K_2 = ((K - 1) S)^2 / sum_{s s'} |P G P|^2,
    /// ```
    ///
    /// over S segments, with `G_kk' = sum_n w_k(n) w_k'(n)` of tapers in the places of both segments and `P` the
    /// projection at right angles to u. Source: the sum of [`Self::effective`], of linear combinations of tapers.
    /// `pairs` of segments by their distance, by default of all.
    pub fn effective_beside_lines(
        &self,
        pairs: Option<&SegmentPairs>,
        shared: &[[f64; 2]],
    ) -> [f64; 2] {
        let pairs = pairs.map_or_else(|| self.pairs(), |pairs| pairs.by_distance().to_vec());
        let (count, tapers) = (pairs[0], self.tapers.len());
        let mut all = [count, count * (tapers - 1) as f64];
        let wanted = all.map(|all| all * all);
        for (pairs, shared) in pairs.iter().zip(shared).skip(1) {
            all[0] += 2.0 * pairs * shared[0];
            all[1] += 2.0 * pairs * shared[1];
        }
        [wanted[0] / all[0], wanted[1] / all[1]]
    }

    /// What pairs of segments of a distance have in common along a line, and beside it.
    pub fn shared_beside_lines(&self) -> Vec<[f64; 2]> {
        let sums = self.taper_sums();
        let norm = sums.iter().map(|u| u * u).sum::<f64>().sqrt();
        let direction: Vec<f64> = sums.iter().map(|u| u / norm).collect();
        let hop = self.segments.hop;
        let of = |j: usize| {
            let shared = |(k, i): (usize, usize)| -> f64 {
                let overlapping = self.tapers[k][j * hop..].iter().zip(&self.tapers[i]);
                overlapping.map(|(v, w)| v * w).sum()
            };
            let matrix = Array2::from_shape_fn((sums.len(), sums.len()), shared);
            let dot = |values: ArrayView1<'_, f64>| -> f64 {
                values.iter().zip(&direction).map(|(v, u)| v * u).sum()
            };
            let right: Vec<f64> = matrix.rows().into_iter().map(dot).collect();
            let left: Vec<f64> = matrix.columns().into_iter().map(dot).collect();
            let along = dot(ArrayView1::from(&right));
            let beside = |((k, i), g): ((usize, usize), &f64)| {
                let (u, v) = (direction[k], direction[i]);
                (g - right[k] * v - u * left[i] + along * u * v).powi(2)
            };
            [along * along, matrix.indexed_iter().map(beside).sum()]
        };
        (0..self.distances()).map(of).collect()
    }

    /// Neighbouring bins that an average shares, in bins: 1 without a taper, 1.94 of a Hann window.
    ///
    /// `B = N sum_n (sum_k w_k(n)^2)^2 / K`, the sum of the squared correlations of a bin with all others.
    pub fn shared_bins(&self) -> f64 {
        let length = self.segments.length;
        let weight = |n: usize| -> f64 { self.tapers.iter().map(|w| w[n] * w[n]).sum() };
        let squares: f64 = (0..length).map(|n| weight(n).powi(2)).sum();
        length as f64 * squares / self.tapers.len() as f64
    }

    /// `sum_k sum_n w_k(n) w_k(n + lag)`, by which averages over tapers multiply a correlation at a lag, in samples.
    pub fn autocorrelation(&self, lag: usize) -> f64 {
        let shared = |w: &Vec<f64>| -> f64 {
            let later = w.iter().skip(lag);
            later.zip(w).map(|(a, b)| a * b).sum()
        };
        self.tapers.iter().map(shared).sum()
    }

    /// What coefficients of products of two transforms are multiplied by to be those of products of Fourier
    /// coefficients: `N sum w^4 / sum w^3` under the first taper, since a product has it twice.
    pub fn quadratic_scale(&self) -> f64 {
        let taper = self.tapers[0].iter();
        let [cubes, fourths] =
            [3, 4].map(|order| taper.clone().map(|w| w.powi(order)).sum::<f64>());
        self.segments.length as f64 * fourths / cubes
    }

    /// Bins from which on two are nearly independent under the window: 1 without a taper, 2 of a Hann window.
    pub fn least_distance(&self) -> usize {
        let is_far = |distance: &usize| self.bin_correlation(*distance) < 0.1;
        (1..self.bins()).find(is_far).unwrap_or(self.bins())
    }

    /// Correlation of the power of a bin with that of the bin `lag` beside it, of white noise under the first
    /// taper.
    pub fn bin_correlation(&self, lag: usize) -> f64 {
        let length = self.segments.length;
        let term = |(n, w): (usize, &f64)| {
            let turn = TAU * (n * lag % length) as f64 / length as f64;
            Complex::from_polar(w * w, turn)
        };
        let sum: Complex<f64> = self.tapers[0].iter().enumerate().map(term).sum();
        sum.norm_sqr()
    }
}

/// Sums of the shared parts of tapers with `sum w^2 = 1`, to a power, by the distance of two segments.
fn shared_products(tapers: &[Vec<f64>], segments: Segments, order: i32) -> Vec<f64> {
    let Segments { length, hop, .. } = segments;
    let shared = |lag: usize| -> f64 {
        let pairs = tapers
            .iter()
            .flat_map(|a| tapers.iter().map(move |b| (a, b)));
        let product = |(a, b): (&Vec<f64>, &Vec<f64>)| -> f64 {
            let overlapping = a[lag..].iter().zip(b);
            let shared: f64 = overlapping.map(|(v, w)| v * w).sum();
            shared.abs().powi(order)
        };
        pairs.map(product).sum()
    };
    let overlap = (0..segments.count()).take_while(|j| j * hop < length);
    overlap.map(|j| shared(j * hop)).collect()
}

/// See [`Realisations::effective_products`], of pairs of segments by their distance.
fn effective_number(tapers: usize, pairs: &[f64], shared: &[f64]) -> f64 {
    let terms = pairs.iter().zip(shared);
    let beside: f64 = terms.skip(1).map(|(pairs, shared)| pairs * shared).sum();
    let all = pairs[0] * tapers as f64;
    all.powi(2) / (pairs[0] * shared[0] + 2.0 * beside)
}

/// That there are two realisations at least.
///
/// # Errors
/// [`Error::Request`].
pub(crate) fn check_count(realisations: usize) -> Result<()> {
    if realisations >= 2 {
        return Ok(());
    }
    let expected = "at least two realisations: shorter segments, several tapers, or several fields";
    let found = "one segment of one field under one taper";
    Err(Error::request("segment", expected, found))
}

/// Where no segment of a site, or of sites that are needed together, is without missing samples.
pub(crate) fn no_segment_left(length: usize) -> Error {
    let expected = format!(
        "a segment of {length} samples in which none is missing: shorter segments, or sites left out"
    );
    Error::request("gaps", expected, "missing samples in every segment")
}

/// How many independent segments of white noise have the variance of the average over all `segments` under a
/// window.
pub(crate) fn effective_segments(window: &[f64], segments: Segments) -> f64 {
    let power = crate::numeric::sum_of_squares(window);
    let scaled = window.iter().map(|w| w / power.sqrt()).collect();
    let count = segments.count();
    let shared = shared_products(&[scaled], segments, 2);
    let pairs: Vec<f64> = (0..shared.len()).map(|j| (count - j) as f64).collect();
    effective_number(1, &pairs, &shared)
}

impl Averaging {
    /// The segments of a record of `n_times` samples, and how many independent realisations of white noise
    /// their average has the variance of: those of Welch (1967), eq. 12.
    ///
    /// # Errors
    /// [`Error::Request`] for segments or tapers that do not fit.
    pub(crate) fn independent(&self, n_times: usize) -> Result<(Segments, f64)> {
        let realisations = Realisations::new(self, n_times)?;
        let effective = realisations.effective();
        Ok((realisations.segments, effective))
    }

    /// The same with segments of so many samples, where none are stated.
    pub(crate) fn with_segment(&self, length: usize) -> Averaging {
        Averaging {
            segment: self.segment.or(Some(length)),
            ..self.clone()
        }
    }

    /// The realisations of a record of `times` samples, which is one segment where `is_whole`, whatever is stated.
    ///
    /// # Errors
    /// [`Error::Request`] for segments or tapers that do not fit.
    pub(crate) fn planned(&self, is_whole: bool, times: usize) -> Result<Realisations> {
        let mut averaging = self.clone();
        if is_whole {
            (averaging.segment, averaging.overlap) = (Some(times), None);
        }
        Realisations::new(&averaging, times)
    }

    /// The whole record as one segment, where none is stated: shots of transients, whose segments are not independent, show
    /// no delay beyond one. The usual window, which would move them, is left out.
    pub(crate) fn of_whole_shots(&self, record: usize) -> Option<Averaging> {
        let whole = Averaging {
            segment: Some(record),
            overlap: None,
            tapers: match &self.tapers {
                Tapers::Window(Window::USUAL) => Tapers::Window(Window::None),
                other => other.clone(),
            },
            detrend: self.detrend,
        };
        self.segment.is_none().then_some(whole)
    }

    fn segments(&self, record: usize) -> Result<Segments> {
        let length = match (self.segment, &self.tapers) {
            (Some(length), _) => length,
            (None, Tapers::Slepian { .. }) => record,
            (None, Tapers::Window(_)) => match record / 8 {
                0..4 => record.min(4),
                part => 1 << part.ilog2(),
            },
        };
        if record < 4 {
            let expected = "a record of at least 4 samples, for one segment";
            return Err(Error::request("segment", expected, record));
        }
        if length < 4 || length > record {
            let expected = format!("4 samples to the {record} of the record");
            return Err(Error::request("segment", expected, length));
        }
        let overlap = self.overlap.unwrap_or(length / 2);
        if overlap >= length {
            let expected = format!("an overlap of 0 to {} samples", length - 1);
            return Err(Error::request("overlap", expected, overlap));
        }
        Ok(Segments {
            record,
            length,
            hop: length - overlap,
        })
    }

    /// The tapers over `length` samples, with `sum w^2 = 1`, and the concentration of each.
    fn weights(&self, length: usize) -> Result<(Vec<Vec<f64>>, Vec<f64>)> {
        match self.tapers {
            Tapers::Window(window) => {
                let refused = |why: WindowError| Error::request("window", why.expected, why.found);
                window.validate(length).map_err(refused)?;
                let samples = window.samples(length);
                let power = crate::numeric::sum_of_squares(&samples);
                let scaled = samples.iter().map(|w| w / power.sqrt()).collect();
                Ok((vec![scaled], vec![1.0]))
            }
            Tapers::Slepian { nw, count } => {
                let half = length as f64 / 2.0;
                if !(nw >= 1.0 && nw < half) {
                    let expected = format!("a time-bandwidth product of 1 to below {half}");
                    return Err(Error::request("multitaper", expected, nw));
                }
                let most = (2.0 * nw - 1.0).floor() as usize;
                if count == 0 || count > most {
                    let expected = format!("1 to {most} tapers, 2 NW - 1");
                    return Err(Error::request("multitaper", expected, count));
                }
                let found = slepian::sequences(length, nw, count).into_iter();
                let pairs = found.map(|one| (one.samples, one.concentration));
                Ok(pairs.unzip())
            }
        }
    }
}
