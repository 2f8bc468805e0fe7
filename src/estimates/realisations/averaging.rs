//! How one record gives several realisations.

use std::f64::consts::TAU;

use num_complex::Complex;

use super::kept::KeptSegments;
use super::part::Portion;
use super::records::Records;
use super::shots::TOGETHER;
use super::sums::SumsShape;
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
#[derive(Debug)]
pub(crate) struct Realisations {
    pub segments: Segments,
    /// Each with `sum w^2 = 1`.
    pub tapers: Vec<Vec<f64>>,
    /// Share of each taper's energy inside its band; 1 of a window.
    pub concentrations: Vec<f64>,
    transforms: Vec<RecordTransform<f64>>,
    detrend: Detrend,
    /// The segments that are visited, of every record.
    pub(super) kept: KeptSegments,
}

/// Working space of one thread.
#[derive(Default)]
pub(crate) struct SegmentScratch {
    transform: RecordScratch<f64>,
    /// Of a segment without its trends.
    rows: Vec<f64>,
    pub numbers: Vec<f64>,
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
            kept: KeptSegments::without(segments, []),
        })
    }

    /// Segments of a record that are visited.
    pub fn segment_count(&self) -> usize {
        self.kept.count()
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

    /// That of sums of so many blocks.
    pub fn shape(&self, plain: usize) -> SumsShape {
        SumsShape {
            plain,
            segments: self.segments,
            about_mean: self.about_mean(),
        }
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
        let all = self.portion(0, 0..self.segments.count(), self.segments.record);
        self.each_of(&all, records, scratch, visit);
    }

    /// The same of a portion of the segments; `records` with the samples of the portion alone.
    pub fn each_of(
        &self,
        portion: &Portion,
        records: Records<'_>,
        scratch: &mut SegmentScratch,
        mut visit: impl FnMut(usize, &[Complex<f64>]),
    ) {
        let kept = portion.segments.clone();
        let kept = kept.filter(|segment| self.kept.has(*segment));
        let width = records.width();
        for (s, segment) in (portion.segments.start..).zip(kept) {
            let start = segment * self.segments.hop - portion.samples.start;
            let rows = records.rows(start..start + self.segments.length);
            let SegmentScratch {
                rows: room,
                numbers,
                ..
            } = scratch;
            let rows = self.without_trends(rows, width, (room, numbers));
            for (k, taper) in self.transforms.iter().enumerate() {
                let spectra = taper.spectra_of_rows(rows, width, &mut scratch.transform);
                visit(s * self.tapers.len() + k, spectra);
            }
        }
    }

    /// Interleaved segments without their trends.
    pub fn without_trends<'r>(
        &self,
        rows: &'r [f64],
        width: usize,
        (room, numbers): (&'r mut Vec<f64>, &mut Vec<f64>),
    ) -> &'r [f64] {
        match self.detrend {
            Detrend::None => rows,
            kind => Trend::removed_across((rows, width), kind, room, numbers),
        }
    }

    /// The spectra under one taper of interleaved segments without trends: `[bin * width + segment]`.
    pub fn under_taper<'s>(
        &self,
        taper: usize,
        (rows, width): (&[f64], usize),
        scratch: &'s mut SegmentScratch,
    ) -> &'s [Complex<f64>] {
        self.transforms[taper].spectra_of_rows(rows, width, &mut scratch.transform)
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
                let found = transform.spectra_of_rows(&polynomial, 1, &mut scratch);
                let cells = lost.iter_mut().zip(found);
                cells.for_each(|(lost, x)| *lost += x.norm_sqr() / all);
            }
        }
        lost
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
}

/// That there are two realisations at least.
///
/// # Errors
/// [`Error::Request`].
pub(crate) fn check_count(realisations: usize) -> Result<()> {
    let expected = "at least two realisations: shorter segments, or several fields";
    let found = "one segment of one field";
    Error::require(realisations >= 2, "segment", expected, found)
}

/// Where no segment of a site, or of sites that are needed together, is without missing samples.
pub(super) fn no_segment_left(length: usize) -> Error {
    let expected = format!(
        "a segment of {length} samples in which none is missing: shorter segments, or sites left out"
    );
    Error::request("gaps", expected, "missing samples in every segment")
}

impl Averaging {
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
        let expected = "a record of at least 4 samples, for one segment";
        Error::require(record >= 4, "segment", expected, record)?;
        let expected = format!("4 samples to the {record} of the record");
        let fits = (4..=record).contains(&length);
        Error::require(fits, "segment", expected, length)?;
        let overlap = self.overlap.unwrap_or(length / 2);
        let expected = format!("an overlap of 0 to {} samples", length - 1);
        Error::require(overlap < length, "overlap", expected, overlap)?;
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
                let expected = format!("a time-bandwidth product of 1 to below {half}");
                Error::require(nw >= 1.0 && nw < half, "multitaper", expected, nw)?;
                let most = (2.0 * nw - 1.0).floor() as usize;
                let expected = format!("1 to {most} tapers, 2 NW - 1");
                let are_some = (1..=most).contains(&count);
                Error::require(are_some, "multitaper", expected, count)?;
                let found = slepian::sequences(length, nw, count).into_iter();
                let pairs = found.map(|one| (one.samples, one.concentration));
                Ok(pairs.unzip())
            }
        }
    }
}
