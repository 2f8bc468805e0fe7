//! The noise of each site: a white floor, found where nothing else moves.

use std::ops::Range;

use super::SpectrumEstimate;
use crate::error::{Error, Result};
use crate::estimates::realisations::{SIGNIFICANCE, interval_factors};
use crate::numeric::{LineFit, chi_square_level, median, sum_of_squares};
use crate::transform::fold;

/// Where the noise of a site was found.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case", tag = "found_in")]
pub enum NoiseSource {
    /// In the samples before the motion arrives, of all records together.
    LeadIn { samples: usize },
    /// Where the spectrum is flat: from this frequency to the Nyquist frequency.
    Top { from: f64 },
}

/// White noise of a site.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SiteNoise {
    /// One-sided power spectral density, that of the variance `density / (2 dt)`.
    pub density: f64,
    /// Ends of the interval by the chi-square distribution.
    pub low: f64,
    pub high: f64,
    /// Degrees of freedom.
    pub degrees: f64,
    pub source: NoiseSource,
}

/// The noise of all sites.
///
/// Of a transient, the variance of the samples before the motion arrives, if these are white. Of a steady record
/// the mean of the spectrum from half or five eighths of the axis on, if it is flat there: the spectra of all
/// sites together, in 16 bands, change by less than 0.3 in `ln S` over that part, by 97.5 %, and no band stands
/// out. Lines are left out. A spectrum that still falls there has no floor that can be told.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NoiseFloor {
    pub sites: Vec<Option<SiteNoise>>,
    /// What was subtracted; `None` where nothing was.
    pub subtracted: Option<SubtractedNoise>,
}

/// What is left of the bias where noise is subtracted, one value a site; 0 where it has no noise that is known.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct SubtractedNoise {
    /// Bins with less power than the noise, which were set to 0.
    pub clipped_bins: Vec<usize>,
    /// What that added to the mean square.
    pub clipped_power: Vec<f64>,
    /// Half of the interval of the noise's own mean square: how much too little or too much may be subtracted.
    pub uncertain_power: Vec<f64>,
}

impl NoiseFloor {
    /// Sites whose noise was found.
    pub fn known(&self) -> usize {
        self.sites.iter().flatten().count()
    }

    /// The median density of the sites of which it was found.
    pub fn median(&self) -> Option<SiteNoise> {
        let mut known: Vec<SiteNoise> = self.sites.iter().flatten().copied().collect();
        known.sort_by(|a, b| a.density.total_cmp(&b.density));
        known.get(known.len() / 2).copied()
    }
}

impl SiteNoise {
    fn new(density: f64, degrees: f64, alpha: f64, source: NoiseSource) -> SiteNoise {
        let [low, high] = interval_factors(degrees, alpha);
        SiteNoise {
            density,
            low: low * density,
            high: high * density,
            degrees,
            source,
        }
    }
}

/// Where noise is to be subtracted and none is known.
pub(crate) fn no_noise() -> Error {
    let expected = "a site that is quiet before the motion arrives, or whose spectrum is flat below the Nyquist \
                    frequency";
    let found = "neither, so that the noise is not known";
    Error::request("subtract-noise", expected, found)
}

/// Samples before the motion arrives.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LeadIn {
    /// Sum of the squared deviations from their mean.
    squares: f64,
    degrees: f64,
    samples: usize,
    /// Records that have one.
    records: usize,
}

/// Parts of a record of which those at its beginning are compared, at most; samples of a part, at least.
const PARTS: usize = 64;
const LEAST_PART: usize = 16;
/// Parts of a lead-in, at least, and how much louder the motion is.
const LEAST_PARTS: usize = 4;
const LOUDER: f64 = 10.0;
/// Standard deviations by which noise may differ from itself by chance.
const BY_CHANCE: f64 = 4.0;
/// Amplitude of rounding, over the largest.
const ROUNDING: f64 = 1e-13;

impl LeadIn {
    /// Adds that of another record.
    pub fn add(&mut self, record: &[f64]) {
        if let Some(quiet) = lead_in(record) {
            self.squares += sum_of_squares(&about_mean(quiet, quiet));
            self.degrees += (quiet.len() - 1) as f64;
            self.samples += quiet.len();
            self.records += 1;
        }
    }

    /// The noise, if each of `records` has a lead-in; `density` makes a variance a density of one side.
    fn noise(&self, records: usize, alpha: f64, density: f64) -> Option<SiteNoise> {
        (self.records == records && records > 0).then(|| {
            let (samples, degrees) = (self.samples, self.degrees);
            let value = density * self.squares / degrees;
            SiteNoise::new(value, degrees, alpha, NoiseSource::LeadIn { samples })
        })
    }
}

/// The beginning of a record that is as loud as white noise throughout, before something ten times as loud.
fn lead_in(record: &[f64]) -> Option<&[f64]> {
    let length = (record.len() / PARTS).max(LEAST_PART);
    let centred = about_mean(record, record.get(..LEAST_PARTS * length)?);
    let parts: Vec<f64> = centred.chunks_exact(length).map(power).collect();
    let most = parts.iter().fold(0.0, |m: f64, p| m.max(*p));
    let by_chance = 1.0 + (BY_CHANCE + 1.0) * (2.0 / length as f64).sqrt();
    let mut sum: f64 = parts[..LEAST_PARTS].iter().sum();
    let is_louder = |count: &usize| {
        let usual = sum / *count as f64;
        sum += parts[*count];
        parts[*count] > usual * by_chance
    };
    let louder = (LEAST_PARTS..parts.len()).find(is_louder);
    // The motion may begin in the last one.
    let counts = std::iter::successors(Some(louder.unwrap_or(parts.len()) - 1), |n| Some(n / 2));
    let mut counts = counts.take_while(|count| count + 1 >= LEAST_PARTS);
    let is_quiet = |count: &usize| {
        let quiet = &centred[..count * length];
        let [quiet_power, least] = [power(quiet), ROUNDING.powi(2) * most];
        LOUDER * quiet_power < most && quiet_power > least && is_white(quiet)
    };
    counts.find(is_quiet).map(|count| &record[..count * length])
}

/// Samples less the mean of some.
fn about_mean(samples: &[f64], some: &[f64]) -> Vec<f64> {
    let mean = crate::numeric::sum(some) / some.len() as f64;
    samples.iter().map(|v| v - mean).collect()
}

fn power(samples: &[f64]) -> f64 {
    sum_of_squares(samples) / samples.len() as f64
}

/// Whether neighbours are independent, and both halves as loud.
fn is_white(samples: &[f64]) -> bool {
    let (moving, n) = (about_mean(samples, samples), samples.len() as f64);
    let products: f64 = moving.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let (a, b) = moving.split_at(moving.len() / 2);
    // Variance of the logarithm of a mean square of n / 2: 4 / n.
    let ratio = (power(a) / power(b)).ln();
    let correlation = products / sum_of_squares(&moving);
    correlation.abs() < BY_CHANCE / n.sqrt() && ratio.abs() < BY_CHANCE * (8.0 / n).sqrt()
}

/// Where the floor may begin, over the Nyquist frequency.
const FROM: [f64; 2] = [0.5, 0.625];
/// Bands of the part that may be flat.
const BANDS: usize = 16;
/// Change of `ln S` over the part: 0.69 and 0.47 of `1 / f`, 0.37 of a sampled random walk over the shorter one.
const MOST_CHANGE: f64 = 0.3;
/// Scatter of `ln S` of the bands about a line, over that by chance, and what counts as none.
const MOST_SCATTER: f64 = 2.0;
const NO_SCATTER: f64 = 0.05;
/// Share of the bins of noise that are taken for lines.
const LINES: f64 = 1e-3;
/// Bins that a line takes; a tenth of all may be lines.
const LINE_BINS: usize = 4;

impl SpectrumEstimate {
    /// Finds the noise of all sites, along time. `density` makes a variance a density of one side; an average shares so many bins.
    pub(super) fn find_noise(&mut self, lead_ins: &[LeadIn], density: f64, shared_bins: f64) {
        let records = self.independence.records;
        let of_site = |lead_in: &LeadIn| lead_in.noise(records, self.alpha, density);
        let mut sites: Vec<Option<SiteNoise>> = lead_ins.iter().map(of_site).collect();
        // A lead-in decides where there is one.
        let steady: Vec<usize> = (0..sites.len()).filter(|j| sites[*j].is_none()).collect();
        let mut floors = FROM.iter();
        if let Some(found) = floors.find_map(|from| self.floor(*from, &steady, shared_bins)) {
            for (j, noise) in steady.into_iter().zip(found) {
                sites[j] = noise;
            }
        }
        self.noise = Some(NoiseFloor {
            sites,
            subtracted: None,
        });
    }

    /// Subtracts the noise that was found. The intervals of both are independent, and are added as the roots of their squares.
    ///
    /// # Errors
    /// [`Error::Request`] where none is known.
    pub(super) fn subtract_noise(&mut self) -> Result<()> {
        let noise = self.noise.as_mut().filter(|noise| noise.known() > 0);
        let noise = noise.ok_or_else(no_noise)?;
        // Logarithms of differences have another spread.
        self.jackknife.fill(f64::NAN);
        let [spectrum, low, high] = [&mut self.spectrum, &mut self.low, &mut self.high];
        let (length, df, mut left) = (self.segment[0], self.bins[1], SubtractedNoise::default());
        for (j, noise) in noise.sites.iter().enumerate() {
            let (mut bins, mut power) = (0, 0.0);
            if let Some(noise) = noise {
                for m in usize::from(self.mean_is_removed)..spectrum.nrows() {
                    let part = fold(m, length) / 2.0;
                    let cell = [m, j];
                    let ends = [
                        (spectrum[cell] - low[cell]).hypot(part * (noise.high - noise.density)),
                        (high[cell] - spectrum[cell]).hypot(part * (noise.density - noise.low)),
                    ];
                    let rest = spectrum[cell] - part * noise.density;
                    if rest < 0.0 {
                        bins += 1;
                        power -= rest * df;
                    }
                    spectrum[cell] = rest.max(0.0);
                    // `max` would make a number of what is unknown.
                    let at_least_0 = |value: f64| if value < 0.0 { 0.0 } else { value };
                    low[cell] = at_least_0(rest - ends[0]);
                    high[cell] = at_least_0(rest + ends[1]);
                }
            }
            left.clipped_bins.push(bins);
            left.clipped_power.push(power);
            let nyquist = 0.5 * length as f64 * df;
            let half = noise.map_or(0.0, |noise| 0.5 * (noise.high - noise.low));
            left.uncertain_power.push(half * nyquist);
        }
        noise.subtracted = Some(left);
        Ok(())
    }

    /// The floors of sites from a part of the axis on; `None` where the part is not flat.
    fn floor(
        &self,
        from: f64,
        sites: &[usize],
        shared_bins: f64,
    ) -> Option<Vec<Option<SiteNoise>>> {
        let end = self.segment[0].div_ceil(2);
        let first = (from * self.segment[0] as f64 / 2.0).ceil() as usize;
        let width = end.saturating_sub(first) / BANDS;
        if width == 0 {
            return None;
        }
        // Whole bands up to the Nyquist frequency, which is none of them.
        let first = end - BANDS * width;
        let part = |j: &usize| self.part(*j, first..end, shared_bins);
        let parts: Vec<Option<Part>> = sites.iter().map(part).collect();
        let known: Vec<&Part> = parts.iter().flatten().collect();
        // Where most sites have something else at the top, so may the others.
        if 2 * known.len() <= sites.len() {
            return None;
        }
        let mut pooled = [0.0; BANDS];
        for part in &known {
            let sums = pooled.iter_mut().zip(&part.bands);
            sums.for_each(|(sum, band)| *sum += band / part.mean / known.len() as f64);
        }
        let degrees: f64 = known.iter().map(|part| part.degrees).sum();
        let change = |bands: &[f64; BANDS], degrees: f64| change(bands, degrees, (first, width));
        let [value, half] = change(&pooled, degrees)?;
        if value + half > MOST_CHANGE {
            return None;
        }
        // A site that differs from the others has another spectrum.
        let from = self.bins[first];
        let floor = |part: &Part| {
            let [value, half] = change(&part.bands, part.degrees)?;
            let source = NoiseSource::Top { from };
            let noise = SiteNoise::new(part.mean, part.degrees, self.alpha, source);
            (value - half <= MOST_CHANGE).then_some(noise)
        };
        let floors = parts.iter().map(|part| part.as_ref().and_then(floor));
        Some(floors.collect())
    }

    /// The bands of a site, without lines; `None` where its degrees of freedom are not known.
    fn part(&self, j: usize, bins: Range<usize>, shared_bins: f64) -> Option<Part> {
        let degrees = self.degrees[[bins.start, j]];
        let values: Vec<f64> = bins.clone().map(|m| self.spectrum[[m, j]]).collect();
        let total: f64 = bins.map(|m| self.degrees[[m, j]]).sum();
        let largest = self.spectrum.column(j).fold(0.0, |m: f64, v| m.max(*v));
        let is_above = |v: &f64| *v > ROUNDING.powi(2) * largest;
        if !(total > 0.0 && values.iter().all(is_above)) {
            return None;
        }
        // The median of the spectrum is that of noise up to its skewness, less than a half.
        let median = median(values.iter().copied())?;
        let middle = degrees * (1.0 - 2.0 / (9.0 * degrees)).powi(3);
        let usual = median * degrees / middle;
        let highest = usual * chi_square_level(LINES / values.len() as f64, degrees) / degrees;
        // Mean and number of what are no lines.
        let rest_of = |values: &[f64]| {
            let rest = values.iter().copied().filter(|v| *v <= highest);
            let rest: Vec<f64> = rest.collect();
            (crate::numeric::sum(&rest) / rest.len() as f64, rest.len())
        };
        let (mean, rest) = rest_of(&values);
        let width = values.len() / BANDS;
        let bands = std::array::from_fn(|i| rest_of(&values[i * width..][..width]).0);
        // More are no lines: the spectrum rises there.
        if values.len() - rest > LINE_BINS.max(values.len() / 10)
            || bands.iter().any(|band: &f64| band.is_nan())
        {
            return None;
        }
        let share = rest as f64 / values.len() as f64;
        Some(Part {
            mean,
            bands,
            degrees: (total * share / shared_bins).max(1.0),
        })
    }
}

/// The top of the spectrum of a site.
struct Part {
    mean: f64,
    bands: [f64; BANDS],
    degrees: f64,
}

/// By how much `ln S` changes from the first band to the Nyquist frequency, by a power law, with half of the interval at 95 %.
/// `None` where bands scatter about the law by more than chance.
fn change(bands: &[f64; BANDS], degrees: f64, (first, width): (usize, usize)) -> Option<[f64; 2]> {
    let point = |(i, band): (usize, &f64)| {
        let middle = first as f64 + (i as f64 + 0.5) * width as f64;
        (middle.ln(), band.ln())
    };
    let points: Vec<(f64, f64)> = bands.iter().enumerate().map(point).collect();
    let line = LineFit::through(&points)?;
    let span = ((first + BANDS * width) as f64 / first as f64).ln();
    let scatter = (line.squares / (BANDS - 2) as f64).sqrt();
    let by_chance = (2.0 * BANDS as f64 / degrees).sqrt();
    let is_even = scatter < (MOST_SCATTER * by_chance).max(NO_SCATTER);
    is_even.then(|| [line.slope.abs(), line.half_interval(SIGNIFICANCE)].map(|of| of * span))
}
