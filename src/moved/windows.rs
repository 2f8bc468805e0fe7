//! Spectra of windows that begin at arrivals, and of the noise in them.

use num_complex::Complex;

use super::onset::Onset;
use super::profile::{Grid, add};

use crate::transform::{RecordScratch, RecordTransform, fold};

/// Quiet windows of a record that its noise is taken from.
pub(super) const QUIET: usize = 8;
/// Samples of a quiet window, at least.
const LEAST_QUIET: usize = 8;

/// A spectrum in a window.
#[derive(Debug, Clone)]
pub(super) struct Spectrum {
    /// Energy of each interval, noise subtracted: single values may be negative.
    pub energy: Vec<f64>,
    /// Its variance by the noise.
    pub noise: Vec<f64>,
    /// Energy times group delay, in samples from the start of the window.
    pub delay: Vec<f64>,
}

/// Windows of one length, planned.
pub(super) struct Windows {
    pub samples: usize,
    pub grid: Grid,
    pub transform: RecordTransform<f64>,
    /// Energy of a power, but for bins that count twice.
    scale: f64,
    /// The first bin that is resolved.
    first: usize,
    /// Mean power of noise of unit variance in each bin; empty of no noise.
    noise: Vec<f64>,
}

impl Windows {
    /// `first`: the first bin that is resolved.
    pub fn new(taper: &[f64], padded: usize, first: usize, dt: f64) -> Windows {
        Windows {
            samples: taper.len(),
            grid: Grid::new(padded / 2 + 1, 1.0 / (padded as f64 * dt)),
            transform: RecordTransform::new(taper, padded),
            scale: dt / padded as f64,
            first,
            noise: Vec::new(),
        }
    }

    /// Energies on the grid, from powers of bins that are resolved.
    pub fn energies(&self, power: impl Fn(usize) -> f64) -> Vec<f64> {
        let energy = |m: usize| match m < self.first {
            true => 0.0,
            false => power(m) * fold(m, self.transform.padded()) * self.scale,
        };
        self.grid.sums((0..self.transform.bins()).map(energy))
    }

    pub fn bins(&self, samples: &[f64], scratch: &mut RecordScratch<f64>) -> Vec<Complex<f64>> {
        self.transform.spectra_of_rows(samples, 1, scratch).to_vec()
    }

    /// Mean power of the noise of a record of unit variance in windows as long as these, from shorter ones where quiet parts are
    /// short; `None` where nothing is quiet.
    pub fn quiet(&self, record: &[f64], onset: &Onset) -> Option<Vec<f64>> {
        let mut scratch = RecordScratch::default();
        let longest = onset.quiet.iter().map(|part| part.len()).max();
        let length = longest.unwrap_or(0).min(self.samples);
        let is_known = |noise: &f64| *noise > 0.0 && length >= LEAST_QUIET;
        let noise = onset.noise.filter(is_known)?;
        let starts = onset.quiet.iter().flat_map(|part| {
            let last = (part.end + 1).saturating_sub(length);
            (part.start..last).step_by((length / 2).max(1))
        });
        let mut power = vec![0.0; self.transform.bins()];
        let starts: Vec<usize> = starts.take(QUIET).collect();
        for &start in &starts {
            let part = record[start..start + length].iter();
            let mut once: Vec<f64> = part.map(|v| (v - onset.baseline) / noise).collect();
            once.resize(self.samples, 0.0);
            let weight = self.samples as f64 / (length * starts.len()) as f64;
            for (sum, x) in power.iter_mut().zip(self.bins(&once, &mut scratch)) {
                *sum += weight * x.norm_sqr();
            }
        }
        Some(power)
    }

    /// Takes the noise of these records; white where none is quiet.
    pub fn set_noise(&mut self, powers: Vec<Vec<f64>>) {
        self.noise = vec![0.0; self.transform.bins()];
        powers.iter().for_each(|power| add(&mut self.noise, power));
        match powers.len() {
            0 => self.noise.fill(self.samples as f64),
            count => self.noise.iter_mut().for_each(|p| *p /= count as f64),
        }
    }

    /// The spectrum of as many samples from `start` on, zeros behind the record's end; `is_struck`: without the step of a body that
    /// goes on.
    pub fn spectrum(
        &self,
        record: &[f64],
        start: usize,
        onset: &Onset,
        is_struck: bool,
        scratch: &mut RecordScratch<f64>,
    ) -> Spectrum {
        let end = (start + self.samples).min(record.len());
        let samples = record[start..end].iter().map(|v| v - onset.baseline);
        let mut samples: Vec<f64> = samples.collect();
        if is_struck {
            remove_step(&mut samples);
        }
        let filled = samples.len() as f64 / self.samples as f64;
        samples.resize(self.samples, 0.0);
        let bins = self.bins(&samples, scratch);
        let level = onset.noise.unwrap_or(0.0);
        let noise = |m: usize| level * level * filled * self.noise.get(m).unwrap_or(&0.0);
        let energy = self.energies(|m| bins[m].norm_sqr() - noise(m));
        // Bins of a padded window follow each other.
        let padding = self.transform.padded() as f64 / self.samples as f64;
        let variances = self.energies(noise).into_iter().zip(&energy);
        let variances = variances.map(|(n, e)| padding * n * (2.0 * e.max(0.0) + n));
        // `Re(Y X*)` with the transform Y of `n v_n`; the delay of noise is half the window.
        let weighted = samples.iter().enumerate().map(|(n, v)| n as f64 * v);
        let moments = self.bins(&weighted.collect::<Vec<_>>(), scratch);
        let middle = 0.5 * (self.samples - 1) as f64;
        Spectrum {
            noise: variances.collect(),
            delay: self.energies(|m| (moments[m] * bins[m].conj()).re - noise(m) * middle),
            energy,
        }
    }
}

/// Removes the velocity with which a body goes on behind the pulse, as it rises with the pulse: `v - v_end c`, c the
/// cumulative |dv| over all of it. A jump to `v_end` would leak over all frequencies.
fn remove_step(samples: &mut [f64]) {
    let last = &samples[samples.len() - samples.len().div_ceil(10)..];
    let end = last.iter().sum::<f64>() / last.len() as f64;
    let mut before = 0.0;
    let rises = samples
        .iter()
        .map(|v| (v - std::mem::replace(&mut before, *v)).abs());
    let rises: Vec<f64> = rises.collect();
    let (all, mut rise) = (rises.iter().sum::<f64>().max(f64::MIN_POSITIVE), 0.0);
    for (v, by) in samples.iter_mut().zip(rises) {
        rise += by / all;
        *v -= end * rise;
    }
}
