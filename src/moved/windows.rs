//! Spectra of windows that begin at arrivals, and of the noise in them.

use num_complex::Complex;

use super::onset::Onset;
use super::profile::{Grid, add};

use crate::transform::{RecordScratch, RecordTransform, fold, quick};

/// Part of the largest magnitude from which on a body that keeps moving is taken for a step.
const STEP: f64 = 0.02;
/// Draws of the noise, sites that they are taken from, and quiet windows of each.
pub(super) const DRAWS: usize = 16;
pub(super) const DRAWN_SITES: usize = 16;
const QUIET: usize = 8;
/// Samples of a quiet window, at least.
const LEAST_QUIET: usize = 8;

/// A spectrum in a window.
#[derive(Debug, Clone)]
pub(super) struct Spectrum {
    /// Energy of each interval, noise subtracted: single values may be negative.
    pub energy: Vec<f64>,
    /// Its standard error by the noise.
    pub error: Vec<f64>,
    /// Energy with draws of the noise added.
    pub again: Vec<Vec<f64>>,
    /// Energy times group delay, in samples from the start of the window; empty in a run.
    pub delay: Vec<f64>,
}

/// Windows of one length, planned.
pub(super) struct Windows {
    pub samples: usize,
    pub grid: Grid,
    transform: RecordTransform<f64>,
    /// Energy of a power, but for bins that count twice.
    scale: f64,
    /// The first bin that is resolved.
    first: usize,
    /// Mean power of noise of unit variance in each bin; empty of no noise.
    noise: Vec<f64>,
    /// Noise of unit variance as quiet parts of some sites have it, of any colour: windows of one index are of the same times.
    drawn: Vec<Vec<Noise>>,
}

/// Spectrum of a quiet window over its standard deviation.
pub(super) type Noise = Vec<Complex<f32>>;

impl Windows {
    pub fn new(samples: usize, dt: f64) -> Windows {
        let padded = quick(2 * samples);
        Windows {
            samples,
            grid: Grid::new(padded / 2 + 1, 1.0 / (padded as f64 * dt)),
            transform: RecordTransform::new(&vec![1.0; samples], padded),
            scale: dt / padded as f64,
            first: padded.div_ceil(samples),
            noise: Vec::new(),
            drawn: Vec::new(),
        }
    }

    fn bins(&self, samples: &[f64], scratch: &mut RecordScratch<f64>) -> Vec<Complex<f64>> {
        let (bins, _) = self.transform.transform(std::iter::once(samples), scratch);
        bins.to_vec()
    }

    /// The noise of a record in windows as long as these, its mean power and, if it `keeps` them, spectra; of shorter ones,
    /// repeated, where quiet parts are short.
    pub fn quiet(&self, record: &[f64], onset: &Onset, keeps: bool) -> (Vec<f64>, Vec<Noise>) {
        let mut scratch = RecordScratch::default();
        let longest = onset.quiet.iter().map(|part| part.len()).max();
        let length = longest.unwrap_or(0).min(self.samples);
        let Some(noise) = onset
            .noise
            .filter(|noise| *noise > 0.0 && length >= LEAST_QUIET)
        else {
            return Default::default();
        };
        let starts = onset.quiet.iter().flat_map(|part| {
            let last = (part.end + 1).saturating_sub(length);
            (part.start..last).step_by((length / 2).max(1))
        });
        let (mut power, mut spectra) = (vec![0.0; self.transform.bins()], Vec::new());
        let starts: Vec<usize> = starts.take(QUIET).collect();
        for &start in &starts {
            let part = record[start..start + length].iter();
            let mut once: Vec<f64> = part.map(|v| (v - onset.baseline) / noise).collect();
            let narrow = |x: &Complex<f64>| Complex::new(x.re as f32, x.im as f32);
            let drawn: Vec<f64> = once.iter().cycle().take(self.samples).copied().collect();
            let drawn = keeps.then(|| self.bins(&drawn, &mut scratch));
            spectra.extend(drawn.map(|bins| bins.iter().map(narrow).collect()));
            // Repeated parts have lines that the noise has not.
            once.resize(self.samples, 0.0);
            let weight = self.samples as f64 / (length * starts.len()) as f64;
            for (sum, x) in power.iter_mut().zip(self.bins(&once, &mut scratch)) {
                *sum += weight * x.norm_sqr();
            }
        }
        (power, spectra)
    }

    /// Takes the noise of these records; white where none is quiet.
    pub fn set_noise(&mut self, quiet: Vec<(Vec<f64>, Vec<Noise>)>) {
        self.noise = vec![0.0; self.transform.bins()];
        let powers = quiet.iter().map(|(power, _)| power);
        let powers: Vec<&Vec<f64>> = powers.filter(|power| !power.is_empty()).collect();
        powers.iter().for_each(|power| add(&mut self.noise, power));
        match powers.len() {
            0 => self.noise.fill(self.samples as f64),
            count => self.noise.iter_mut().for_each(|p| *p /= count as f64),
        }
        let drawn = quiet.into_iter().map(|(_, spectra)| spectra);
        self.drawn = drawn.filter(|of| !of.is_empty()).collect();
    }

    /// The spectrum of as many samples from `start` on, zeros behind the record's end. `rank`: of the site among those read, with
    /// draws of the noise.
    pub fn spectrum(
        &self,
        record: &[f64],
        start: usize,
        onset: &Onset,
        rank: Option<usize>,
        is_simulated: bool,
        scratch: &mut RecordScratch<f64>,
    ) -> Spectrum {
        let end = (start + self.samples).min(record.len());
        let samples = record[start..end].iter().map(|v| v - onset.baseline);
        let mut samples: Vec<f64> = samples.collect();
        if is_simulated {
            remove_step(&mut samples);
        }
        let filled = samples.len() as f64 / self.samples as f64;
        samples.resize(self.samples, 0.0);
        let bins = self.bins(&samples, scratch);
        let level = onset.noise.unwrap_or(0.0);
        let noise = |m: usize| level * level * filled * self.noise.get(m).unwrap_or(&0.0);
        let sums = |power: &dyn Fn(usize) -> f64| {
            let energy = |m: usize| match m < self.first {
                true => 0.0,
                false => power(m) * fold(m, self.transform.padded()) * self.scale,
            };
            self.grid.sums((0..bins.len()).map(energy))
        };
        let draws = rank.filter(|_| !self.drawn.is_empty()).map_or(0, |_| DRAWS);
        let again = (0..draws).map(|r| {
            let z = self.draw(rank.unwrap_or(0), r);
            let sign = if r.is_multiple_of(2) { level } else { -level };
            sums(&|m| {
                let z = Complex::new(f64::from(z[m].re), f64::from(z[m].im));
                (bins[m] + sign * z).norm_sqr() - 2.0 * noise(m)
            })
        });
        let (again, energy) = (again.collect(), sums(&|m| bins[m].norm_sqr() - noise(m)));
        // Bins of a padded window follow each other.
        let padding = self.transform.padded() as f64 / self.samples as f64;
        let error = sums(&noise).into_iter().zip(&energy);
        let error = error.map(|(n, e)| (padding * n * (2.0 * e.max(0.0) + n)).sqrt());
        let error = error.collect();
        let mut delay = Vec::new();
        if rank.is_some() {
            // `Re(Y X*)` with the transform Y of `n v_n`; the delay of noise is half the window.
            let weighted = samples.iter().enumerate().map(|(n, v)| n as f64 * v);
            let moments = self.bins(&weighted.collect::<Vec<_>>(), scratch);
            let middle = 0.5 * (self.samples - 1) as f64;
            delay = sums(&|m| (moments[m] * bins[m].conj()).re - noise(m) * middle);
        }
        Spectrum {
            energy,
            error,
            again,
            delay,
        }
    }

    /// Draw r of the site of this rank: sites of one draw have the noise of other sites, of the same times.
    fn draw(&self, rank: usize, r: usize) -> &[Complex<f32>] {
        let site = &self.drawn[(rank + r / 2) % self.drawn.len()];
        &site[(r / 2) % site.len()]
    }
}
/// Removes the velocity with which a body goes on behind the pulse, as it rises with the pulse: `v - v_end c`, c the
/// cumulative |dv| over all of it. A jump to `v_end` would leak over all frequencies.
fn remove_step(samples: &mut [f64]) {
    let n = samples.len();
    let last = &samples[n - (n / 10).max(1)..];
    let end = last.iter().sum::<f64>() / last.len() as f64;
    let largest = samples.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    if end.abs() <= STEP * largest {
        return;
    }
    let mut before = 0.0;
    let mut sum = 0.0;
    let rises = samples.iter().map(|v| {
        sum += (v - before).abs();
        before = *v;
        sum
    });
    let rises: Vec<f64> = rises.collect();
    let all = rises[n - 1];
    for (v, rise) in samples.iter_mut().zip(rises) {
        *v -= end * rise / all;
    }
}
