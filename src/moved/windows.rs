//! Spectra of windows that begin at arrivals.

use num_complex::Complex;

use super::onset::NoiseShape;
use super::quick;
use super::share::{Grid, Spectrum};
use crate::numeric::sum_of_squares;
use crate::transform::{RecordScratch, RecordTransform, fold};

/// Part of the largest magnitude from which on a body that keeps moving is taken for a step.
const STEP: f64 = 0.02;

/// How the samples of a window count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Weights {
    Flat,
    /// The square of half a cosine, from 1 to 0.
    Fading,
}

/// Windows of one length, planned.
pub(super) struct Windows {
    /// Samples from the arrival to the first sample, and samples.
    pub after: usize,
    pub samples: usize,
    pub grid: Grid,
    transform: RecordTransform<f64>,
    /// Energy of a power, but for bins that count twice.
    scale: f64,
    /// The first bin that is resolved.
    first: usize,
    padding: f64,
    /// Noise of unit variance in each bin, as energy.
    noise: Vec<f64>,
    /// Whether group delays are requested.
    pub has_delays: bool,
}

impl Windows {
    pub fn new(
        weights: Weights,
        (after, samples): (usize, usize),
        dt: f64,
        shape: &NoiseShape,
    ) -> Windows {
        let half = |n: usize| 0.5 + 0.5 * (std::f64::consts::PI * n as f64 / samples as f64).cos();
        let fading = |n: usize| half(n).powi(2);
        let of_sample: Vec<f64> = match weights {
            Weights::Flat => vec![1.0; samples],
            Weights::Fading => (0..samples).map(fading).collect(),
        };
        let padded = quick(2 * samples);
        let step = 1.0 / (padded as f64 * dt);
        let bins = padded / 2 + 1;
        let scale = dt / padded as f64;
        let energy = sum_of_squares(&of_sample);
        let noise = (0..bins).map(|m| {
            let share = m as f64 / (bins - 1).max(1) as f64;
            energy * scale * fold(m, padded) * shape.at(share)
        });
        Windows {
            after,
            samples,
            grid: Grid::new(bins, step),
            transform: RecordTransform::new(&of_sample, padded),
            noise: noise.collect(),
            has_delays: false,
            scale,
            first: padded.div_ceil(samples),
            padding: padded as f64 / samples as f64,
        }
    }

    /// Samples from the arrival to the end.
    pub fn end(&self) -> usize {
        self.after + self.samples
    }

    /// The spectrum of the window behind `arrival`, which lies in the record.
    pub fn spectrum(
        &self,
        record: &[f64],
        arrival: usize,
        (baseline, noise): (f64, f64),
        removes_steps: bool,
        scratch: &mut RecordScratch<f64>,
    ) -> Spectrum {
        let from = arrival + self.after;
        let mut samples: Vec<f64> = record[from..from + self.samples]
            .iter()
            .map(|v| v - baseline)
            .collect();
        if removes_steps {
            remove_step(&mut samples);
        }
        let (bins, _) = self
            .transform
            .transform(std::iter::once(&samples[..]), scratch);
        let padded = self.transform.padded();
        let power = bins.iter().enumerate();
        let power = power.map(|(m, x)| x.norm_sqr() * fold(m, padded) * self.scale);
        let variance = noise * noise;
        let noise = self.noise.iter().map(|of_unit| of_unit * variance);
        let mut spectrum =
            Spectrum::new(&self.grid, power, noise.clone(), self.first, self.padding);
        if self.has_delays {
            let bins = bins.to_vec();
            spectrum.delay = self.delay(&bins, &mut samples, noise, scratch);
        }
        spectrum
    }

    /// `|X|^2` times the group delay, `Re(Y X*)` with the transform Y of `n v_n`; that of noise is half the window.
    fn delay(
        &self,
        bins: &[Complex<f64>],
        samples: &mut [f64],
        noise: impl Iterator<Item = f64>,
        scratch: &mut RecordScratch<f64>,
    ) -> Vec<f64> {
        for (n, v) in samples.iter_mut().enumerate() {
            *v *= n as f64;
        }
        let (moments, _) = self
            .transform
            .transform(std::iter::once(&*samples), scratch);
        let middle = 0.5 * (self.samples - 1) as f64;
        let padded = self.transform.padded();
        let products = moments.iter().zip(bins).zip(noise).enumerate();
        let products = products.map(|(m, ((y, x), noise))| match m < self.first {
            true => 0.0,
            false => (y * x.conj()).re * fold(m, padded) * self.scale - noise * middle,
        });
        self.grid.sums(products)
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

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: fn() -> NoiseShape = || NoiseShape::new(&[]);

    /// A sine of amplitude 1 over a whole window has the energy T / 2, all of it at its frequency.
    #[test]
    fn val_a_sine_in_a_window() {
        let (n, dt) = (1000, 0.5);
        let windows = Windows::new(Weights::Flat, (0, n), dt, &WHITE());
        let sine: Vec<f64> = (0..2 * n)
            .map(|n| (std::f64::consts::TAU * 0.1 * n as f64).sin())
            .collect();
        let spectrum = windows.spectrum(&sine, 100, (0.0, 0.0), false, &mut Default::default());
        let all: f64 = spectrum.energy.iter().sum();
        assert!((all / 250.0 - 1.0).abs() < 1e-3, "{all}");
        let near = windows.grid.below(0.198)..windows.grid.below(0.203);
        let near: f64 = spectrum.energy[near].iter().sum();
        // The main lobe, 2 bins wide, holds 0.903 of it.
        assert!((0.9..1.0).contains(&(near / all)), "{near} {all}");
    }

    /// Noise of known variance leaves nothing on average.
    #[test]
    fn val_noise_is_subtracted() {
        let mut random = crate::numeric::Random::new(5);
        let windows = Windows::new(Weights::Fading, (3, 400), 0.1, &WHITE());
        let mut sum = 0.0;
        let tries = 400;
        for _ in 0..tries {
            let record: Vec<f64> = (0..500).map(|_| 0.3 * random.normal()).collect();
            let s = windows.spectrum(&record, 5, (0.0, 0.3), false, &mut Default::default());
            sum += s.energy.iter().sum::<f64>();
        }
        // The mean of cos^8 over a quarter of its period is 35 / 128.
        let part = sum / f64::from(tries) / (0.09 * 40.0 * 35.0 / 128.0);
        assert!(part.abs() < 0.02, "{part}");
    }
}
