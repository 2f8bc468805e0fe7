//! How one record gives several realisations.

use num_complex::Complex;

use crate::error::{Error, Result};
use crate::prepare::{Detrend, Trend, Window, slepian};
use crate::transform::{RecordScratch, RecordTransform, Segments};

/// The tapers of a segment.
#[derive(Debug, Clone, PartialEq)]
pub enum Tapers {
    /// One window: Welch's method.
    Window(Window),
    /// The first `count` Slepian sequences of time-bandwidth product `nw`: Thomson's multitaper method,
    /// with equal weights. At most `2 nw - 1` of them keep their energy inside the band.
    Slepian { nw: f64, count: usize },
}

/// How one record gives several realisations: overlapping segments, each under one or more tapers.
#[derive(Debug, Clone, PartialEq)]
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
            tapers: Tapers::Window(Window::Hann),
            detrend: Detrend::Mean,
        }
    }
}

/// The realisations of a record of a certain length, planned.
pub(super) struct Realisations {
    pub segments: Segments,
    /// Each with `sum w^2 = 1`.
    tapers: Vec<Vec<f64>>,
    transforms: Vec<RecordTransform<f64>>,
    detrend: Detrend,
}

/// Working space of one thread.
#[derive(Default)]
pub(super) struct SegmentScratch {
    transform: RecordScratch<f64>,
    segments: Vec<f64>,
    trend: Vec<f64>,
}

impl Realisations {
    /// # Errors
    /// [`Error::Request`] for segments or tapers that do not fit a record of `n_times` samples.
    pub fn new(averaging: &Averaging, n_times: usize) -> Result<Self> {
        let segments = averaging.segments(n_times)?;
        let tapers = averaging.weights(segments.length)?;
        let plan = |taper: &Vec<f64>| RecordTransform::new(taper, segments.length);
        let transforms = tapers.iter().map(plan).collect();
        Ok(Realisations {
            segments,
            tapers,
            transforms,
            detrend: averaging.detrend,
        })
    }

    /// Realisations of a record.
    pub fn count(&self) -> usize {
        self.segments.count() * self.tapers.len()
    }

    pub fn tapers(&self) -> usize {
        self.tapers.len()
    }

    pub fn bins(&self) -> usize {
        self.segments.length / 2 + 1
    }

    /// Samples of a record that segments reach.
    pub fn reached(&self) -> usize {
        self.segments.record - self.segments.left_over()
    }

    /// Visits every realisation of `records`, which follow one another: its number and its spectra,
    /// `[bin * width + record]`. With samples `v` and spacing `dt`, `|X|^2 dt` is the power spectral
    /// density of one side.
    pub fn each(
        &self,
        records: &[f64],
        scratch: &mut SegmentScratch,
        mut visit: impl FnMut(usize, &[Complex<f64>]),
    ) {
        let Segments { record, length, .. } = self.segments;
        let SegmentScratch {
            transform,
            segments,
            trend,
        } = scratch;
        for (s, start) in self.segments.starts().enumerate() {
            segments.clear();
            for record in records.chunks_exact(record) {
                segments.extend_from_slice(&record[start..start + length]);
            }
            for segment in segments.chunks_exact_mut(length) {
                Trend::remove_from(segment, self.detrend, |_| true, trend);
            }
            for (k, taper) in self.transforms.iter().enumerate() {
                let (spectra, _) = taper.transform(segments.chunks_exact(length), transform);
                visit(s * self.tapers.len() + k, spectra);
            }
        }
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
        let Segments { length, hop, .. } = self.segments;
        let count = self.segments.count();
        let shared = |lag: usize| -> f64 {
            let pairs = self
                .tapers
                .iter()
                .flat_map(|a| self.tapers.iter().map(move |b| (a, b)));
            let product = |(a, b): (&Vec<f64>, &Vec<f64>)| -> f64 {
                let overlapping = a[lag..].iter().zip(b);
                overlapping.map(|(v, w)| v * w).sum::<f64>().powi(2)
            };
            pairs.map(product).sum()
        };
        let neighbours = (1..count).take_while(|j| j * hop < length);
        let beside: f64 = neighbours
            .map(|j| (count - j) as f64 * shared(j * hop))
            .sum();
        (self.count() as f64).powi(2) / (count as f64 * shared(0) + 2.0 * beside)
    }

    /// Neighbouring bins that an average shares, in bins: 1 without a taper, 1.94 of a Hann window.
    ///
    /// `B = N sum_n (sum_k w_k(n)^2)^2 / K`, the sum of the squared correlations of a bin with all others.
    pub fn shared_bins(&self) -> f64 {
        let length = self.segments.length;
        let weight = |n: usize| {
            self.tapers
                .iter()
                .map(|taper| taper[n] * taper[n])
                .sum::<f64>()
        };
        let squares: f64 = (0..length).map(|n| weight(n).powi(2)).sum();
        length as f64 * squares / self.tapers.len() as f64
    }
}

impl Averaging {
    fn segments(&self, record: usize) -> Result<Segments> {
        let refuse = |option, expected: String, found: usize| Error::Request {
            option,
            expected,
            found: found.to_string(),
        };
        let length = match (self.segment, &self.tapers) {
            (Some(length), _) => length,
            (None, Tapers::Slepian { .. }) => record,
            (None, Tapers::Window(_)) => match record / 8 {
                0..4 => record.min(4),
                part => 1 << part.ilog2(),
            },
        };
        if length < 4 || length > record {
            let expected = format!("a segment of 4 to {record} samples, the record");
            return Err(refuse("segment", expected, length));
        }
        let overlap = self.overlap.unwrap_or(length / 2);
        if overlap >= length {
            let expected = format!("an overlap of 0 to {} samples", length - 1);
            return Err(refuse("overlap", expected, overlap));
        }
        Ok(Segments {
            record,
            length,
            hop: length - overlap,
        })
    }

    /// The tapers over `length` samples, with `sum w^2 = 1`.
    fn weights(&self, length: usize) -> Result<Vec<Vec<f64>>> {
        let refuse = |expected: String, found: String| Error::Request {
            option: "multitaper",
            expected,
            found,
        };
        match self.tapers {
            Tapers::Window(window) => {
                window.validate(length).map_err(|error| Error::Request {
                    option: "window",
                    expected: error.expected,
                    found: error.found,
                })?;
                let samples = window.samples(length);
                let power = crate::numeric::sum_of_squares(&samples);
                Ok(vec![samples.iter().map(|w| w / power.sqrt()).collect()])
            }
            Tapers::Slepian { nw, count } => {
                let half = length as f64 / 2.0;
                if !(nw >= 1.0 && nw < half) {
                    let expected = format!("a time-bandwidth product of 1 to below {half}");
                    return Err(refuse(expected, nw.to_string()));
                }
                let most = (2.0 * nw - 1.0).floor() as usize;
                if count == 0 || count > most {
                    let expected = format!("1 to {most} tapers, 2 NW - 1");
                    return Err(refuse(expected, count.to_string()));
                }
                let found = slepian::sequences(length, nw, count);
                Ok(found.into_iter().map(|one| one.samples).collect())
            }
        }
    }
}
