//! Spectra of windows that begin at arrivals, and of the noise in them.

use num_complex::Complex;

use super::onset::Onset;
use super::profile::{Grid, add};
use super::quick;
use crate::transform::{RecordScratch, RecordTransform, fold};

/// Part of the largest magnitude from which on a body that keeps moving is taken for a step.
const STEP: f64 = 0.02;
/// Draws of the noise, sites that they are taken from, and quiet windows of each.
pub(super) const DRAWS: usize = 16;
pub(super) const DRAWN_SITES: usize = 16;
const QUIET: usize = 8;

/// A spectrum in a window.
#[derive(Debug, Clone)]
pub(super) struct Spectrum {
    /// Energy of each interval, noise subtracted: single values may be negative.
    pub energy: Vec<f64>,
    /// Energy of the noise.
    pub noise: Vec<f64>,
    /// Energy with draws of the noise added.
    pub again: Vec<Vec<f64>>,
    /// Energy times group delay, in samples from the start of the window; empty where it is not requested.
    pub delay: Vec<f64>,
}

/// Windows of one length, planned.
pub(super) struct Windows {
    pub samples: usize,
    pub grid: Grid,
    /// Bins of the padded window that count as one, since the padding makes them follow each other.
    pub padding: f64,
    transform: RecordTransform<f64>,
    /// Energy of a power, but for bins that count twice.
    scale: f64,
    /// The first bin that is resolved.
    first: usize,
    noise: Noise,
}

/// Noise of unit variance in a window, as quiet parts of the records have it: of any colour, and with what sites have in common.
#[derive(Debug, Clone, Default)]
pub(super) struct Noise {
    /// Mean power in each bin; empty of no noise.
    power: Vec<f64>,
    /// Spectra of quiet windows of some sites, each over its standard deviation: those of one index are of the same times.
    drawn: Vec<Vec<Vec<Complex<f32>>>>,
}

/// Powers of the quiet windows of one record.
pub(super) struct QuietWindows {
    power: Vec<f64>,
    count: usize,
    spectra: Vec<Vec<Complex<f32>>>,
}

impl Windows {
    pub fn new(samples: usize, dt: f64) -> Windows {
        let padded = quick(2 * samples);
        let bins = padded / 2 + 1;
        Windows {
            samples,
            grid: Grid::new(bins, 1.0 / (padded as f64 * dt)),
            padding: padded as f64 / samples as f64,
            transform: RecordTransform::new(&vec![1.0; samples], padded),
            scale: dt / padded as f64,
            first: padded.div_ceil(samples),
            noise: Noise::default(),
        }
    }

    /// The noise of a record in windows as long as these; of shorter ones, repeated, where quiet parts are short.
    pub fn quiet(&self, record: &[f64], onset: &Onset, keeps: bool) -> QuietWindows {
        let mut scratch = RecordScratch::default();
        let mut found = QuietWindows {
            power: vec![0.0; self.transform.bins()],
            count: 0,
            spectra: Vec::new(),
        };
        let longest = onset.quiet.iter().map(|part| part.len()).max();
        let length = longest.unwrap_or(0).min(self.samples);
        let Some(noise) = onset.noise.filter(|noise| *noise > 0.0 && length >= 8) else {
            return found;
        };
        let starts = onset.quiet.iter().flat_map(|part| {
            let last = (part.end + 1).saturating_sub(length);
            (part.start..last).step_by((length / 2).max(1))
        });
        let mut bins = |samples: &[f64]| {
            let (bins, _) = self
                .transform
                .transform(std::iter::once(samples), &mut scratch);
            bins.to_vec()
        };
        for start in starts.take(QUIET) {
            let part = &record[start..start + length];
            let drawn = part.iter().cycle().take(self.samples);
            let drawn: Vec<f64> = drawn.map(|v| (v - onset.baseline) / noise).collect();
            // Repeated parts have lines that the noise has not.
            let mut once = drawn.clone();
            once[length..].fill(0.0);
            let weight = self.samples as f64 / length as f64;
            let power: Vec<f64> = bins(&once).iter().map(|x| weight * x.norm_sqr()).collect();
            add(&mut found.power, &power);
            found.count += 1;
            if keeps {
                let narrow = |x: &Complex<f64>| Complex::new(x.re as f32, x.im as f32);
                found
                    .spectra
                    .push(bins(&drawn).iter().map(narrow).collect());
            }
        }
        found
    }

    /// Takes the noise of these records; white where none is quiet.
    pub fn set_noise(&mut self, quiet: Vec<QuietWindows>) {
        let count: usize = quiet.iter().map(|of| of.count).sum();
        let mut power = vec![0.0; self.transform.bins()];
        quiet.iter().for_each(|of| add(&mut power, &of.power));
        match count {
            0 => power.fill(self.samples as f64),
            count => power.iter_mut().for_each(|p| *p /= count as f64),
        }
        let drawn = quiet.into_iter().map(|of| of.spectra);
        self.noise = Noise {
            power,
            drawn: drawn.filter(|of| !of.is_empty()).collect(),
        };
    }

    /// Draws there are of the noise.
    pub fn draws(&self) -> usize {
        if self.noise.drawn.is_empty() {
            0
        } else {
            DRAWS
        }
    }

    /// The spectrum of as many samples from `start` on, zeros behind the record's end. `rank`: of the site among those read.
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
        let mut samples: Vec<f64> = record[start..end]
            .iter()
            .map(|v| v - onset.baseline)
            .collect();
        if is_simulated {
            remove_step(&mut samples);
        }
        let filled = samples.len() as f64 / self.samples as f64;
        samples.resize(self.samples, 0.0);
        let (bins, _) = self
            .transform
            .transform(std::iter::once(&samples[..]), scratch);
        let bins = bins.to_vec();
        let level = onset.noise.unwrap_or(0.0);
        let factor = |m: usize| fold(m, self.transform.padded()) * self.scale;
        let noise = |m: usize| match self.noise.power.get(m) {
            Some(power) => level * level * power * factor(m) * filled,
            None => 0.0,
        };
        let resolved = |m: usize, value: f64| if m < self.first { 0.0 } else { value };
        let power = |m: usize| bins[m].norm_sqr() * factor(m);
        let sums =
            |of: &dyn Fn(usize) -> f64| self.grid.sums((0..bins.len()).map(|m| resolved(m, of(m))));
        let mut spectrum = Spectrum {
            energy: sums(&|m| power(m) - noise(m)),
            noise: sums(&noise),
            again: Vec::new(),
            delay: Vec::new(),
        };
        if let Some(rank) = rank {
            let draws = 0..self.draws();
            let of_draw = |r: usize| {
                let z = self.noise.draw(rank, r);
                let sign = if r.is_multiple_of(2) { level } else { -level };
                sums(&|m| {
                    let z = Complex::new(f64::from(z[m].re), f64::from(z[m].im));
                    (bins[m] + sign * z).norm_sqr() * factor(m) - 2.0 * noise(m)
                })
            };
            spectrum.again = draws.map(of_draw).collect();
        }
        if rank.is_some() {
            // `Re(Y X*)` with the transform Y of `n v_n`; the delay of noise is half the window.
            for (n, v) in samples.iter_mut().enumerate() {
                *v *= n as f64;
            }
            let middle = 0.5 * (self.samples - 1) as f64;
            let (moments, _) = self
                .transform
                .transform(std::iter::once(&samples[..]), scratch);
            spectrum.delay =
                sums(&|m| (moments[m] * bins[m].conj()).re * factor(m) - noise(m) * middle);
        }
        spectrum
    }
}

impl Noise {
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
