//! Real records to the non-negative half of their spectrum.

use std::sync::Arc;

use num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

use super::Real;
use crate::sum::{sum, sum_of_squares, sums_of_squares_across};

/// `X_m = sum_n w_n v_n exp(-+ 2 pi i m n / N)`, `m = 0 ..= N / 2`, of a real record of up to N
/// samples (the rest is zero). Both signs give the same `|X|^2`; the result is that of time.
pub struct RealTransform<T: Real> {
    plan: Arc<dyn RealToComplex<T>>,
    taper: Taper,
}

/// Working space of one thread; grows once.
#[derive(Debug, Clone, Default)]
pub struct Scratch<T> {
    tapered: Vec<f64>,
    input: Vec<T>,
    pub(super) spectrum: Vec<Complex<T>>,
    pub(super) work: Vec<Complex<T>>,
}

impl<T: Real> RealTransform<T> {
    /// Plans transforms of `window.len()` samples padded to `padded`; all weights 1 mean no taper.
    ///
    /// # Panics
    /// If there are no samples or `padded` is shorter than the window.
    pub fn new(window: &[f64], padded: usize) -> Self {
        assert!(!window.is_empty() && padded >= window.len());
        RealTransform {
            plan: RealFftPlanner::<T>::new().plan_fft_forward(padded),
            taper: Taper::new(window, padded),
        }
    }

    /// Length N of the transform.
    pub fn padded(&self) -> usize {
        self.plan.len()
    }

    /// Bins of the result, `N / 2 + 1`.
    pub fn bins(&self) -> usize {
        self.padded() / 2 + 1
    }

    /// The spectrum of `record`, in `scratch`, and the energy `sum (w v)^2` of what went in.
    ///
    /// # Panics
    /// If `record` is not as long as the window.
    pub fn transform<'s>(
        &self,
        record: &[f64],
        scratch: &'s mut Scratch<T>,
    ) -> (&'s [Complex<T>], f64) {
        assert_eq!(record.len(), self.taper.samples);
        let Scratch {
            tapered,
            input,
            spectrum,
            work,
        } = scratch;
        input.clear();
        let (mean, energy) = self.taper.look(record, tapered);
        self.taper.weigh(record, mean, input);
        input.resize(self.padded(), T::zero());
        spectrum.resize(self.bins(), Complex::default());
        work.resize(self.plan.get_scratch_len(), Complex::default());
        // The lengths are the plan's own, so this cannot fail.
        let _ = self.plan.process_with_scratch(input, spectrum, work);
        self.taper.add_mean(mean, spectrum.iter_mut());
        (spectrum, energy)
    }
}

impl<T: Real> std::fmt::Debug for RealTransform<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RealTransform")
            .field("samples", &self.taper.samples)
            .field("padded", &self.padded())
            .finish_non_exhaustive()
    }
}

/// The window of a transform, and what becomes of a record's mean.
#[derive(Debug)]
pub(super) struct Taper {
    /// `None`: no taper.
    window: Option<Vec<f64>>,
    pub(super) samples: usize,
    /// Transform of the window itself, for records that are split into mean and rest.
    mean_response: Vec<Complex<f64>>,
}

impl Taper {
    pub(super) fn new(window: &[f64], padded: usize) -> Self {
        let tapered = window.iter().any(|&w| w != 1.0);
        let mut mean_response = vec![Complex::default(); padded / 2 + 1];
        if !tapered && padded == window.len() {
            mean_response[0].re = padded as f64;
        } else {
            let mut response_in = window.to_vec();
            response_in.resize(padded, 0.0);
            let response = RealFftPlanner::<f64>::new().plan_fft_forward(padded);
            // The lengths are the plan's own, so this cannot fail.
            let _ = response.process(&mut response_in, &mut mean_response);
        }
        Taper {
            window: tapered.then(|| window.to_vec()),
            samples: window.len(),
            mean_response,
        }
    }

    /// The mean of `record` that is split off (mostly 0), and the energy `sum (w v)^2`.
    pub(super) fn look(&self, record: &[f64], tapered: &mut Vec<f64>) -> (f64, f64) {
        let energy = match &self.window {
            None => sum_of_squares(record),
            Some(window) => {
                tapered.clear();
                tapered.extend(record.iter().zip(window).map(|(&v, &w)| v * w));
                sum_of_squares(tapered)
            }
        };
        (dominant_mean(record), energy)
    }

    /// Each sample of `record` less `mean`, times its weight.
    pub(super) fn weigh<T: Real>(&self, record: &[f64], mean: f64, input: &mut Vec<T>) {
        match &self.window {
            None => input.extend(record.iter().map(|&v| T::rounded(v - mean))),
            Some(window) => {
                let weighted = record.iter().zip(window);
                input.extend(weighted.map(|(&v, &w)| T::rounded((v - mean) * w)));
            }
        }
    }

    /// [`Taper::look`] at each of `width` records that lie side by side, with the same bits.
    pub(super) fn look_across(
        &self,
        values: &[f64],
        width: usize,
        tapered: &mut Vec<f64>,
        (means, energies): (&mut Vec<f64>, &mut Vec<f64>),
    ) {
        if width == 1 {
            let (mean, energy) = self.look(values, tapered);
            *means = vec![mean];
            *energies = vec![energy];
            return;
        }
        match &self.window {
            None => sums_of_squares_across(values, width, energies),
            Some(window) => {
                tapered.clear();
                for (row, w) in values.chunks_exact(width).zip(window) {
                    tapered.extend(row.iter().map(|v| v * w));
                }
                sums_of_squares_across(tapered, width, energies);
            }
        }
        means.clear();
        means.resize(width, 0.0);
        for c in one_sided(values, width) {
            let record: Vec<f64> = values.iter().skip(c).step_by(width).copied().collect();
            means[c] = dominant_mean(&record);
        }
    }

    /// [`Taper::weigh`] of records side by side; what is in `input` already stays.
    pub(super) fn weigh_across<T: Real>(&self, values: &[f64], means: &[f64], input: &mut Vec<T>) {
        for (n, row) in values.chunks_exact(means.len()).enumerate() {
            let weight = self.window.as_ref().map_or(1.0, |window| window[n]);
            let weighed = row
                .iter()
                .zip(means)
                .map(|(v, mean)| T::rounded((v - mean) * weight));
            input.extend(weighed);
        }
    }

    /// Whether records go into the transform as they are.
    pub(super) fn is_plain(&self) -> bool {
        self.window.is_none()
    }

    /// Puts back what [`Taper::look`] split off.
    pub(super) fn add_mean<'a, T: Real>(
        &self,
        mean: f64,
        spectrum: impl Iterator<Item = &'a mut Complex<T>>,
    ) {
        if mean == 0.0 {
            return;
        }
        for (x, response) in spectrum.zip(&self.mean_response) {
            x.re = T::rounded(x.re.to_f64() + mean * response.re);
            x.im = T::rounded(x.im.to_f64() + mean * response.im);
        }
    }
}

/// The mean of a record that lies within a quarter of it, else 0.
///
/// Then every `v - mean` is exact (Sterbenz' lemma: the two are within a factor 2).
fn dominant_mean(record: &[f64]) -> f64 {
    if crosses_zero(record.iter().copied()) {
        return 0.0;
    }
    let mean = sum(record) / record.len() as f64;
    let apart = record
        .iter()
        .fold(0.0, |m: f64, &v| m.max((v - mean).abs()));
    if apart < 0.25 * mean.abs() { mean } else { 0.0 }
}

/// The same for one part of a complex profile.
pub(super) fn dominant_mean_of(part: impl ExactSizeIterator<Item = f64> + Clone) -> f64 {
    if crosses_zero(part.clone()) {
        return 0.0;
    }
    dominant_mean(&part.collect::<Vec<_>>())
}

/// Which of `width` records side by side do not cross zero; others have no dominant mean.
fn one_sided(values: &[f64], width: usize) -> Vec<usize> {
    let (mut low, mut high) = (vec![f64::INFINITY; width], vec![f64::NEG_INFINITY; width]);
    let sided = |low: &[f64], high: &[f64]| -> Vec<usize> {
        (0..width)
            .filter(|&c| low[c] > 0.0 || high[c] < 0.0)
            .collect()
    };
    for stretch in values.chunks(64 * width) {
        for row in stretch.chunks_exact(width) {
            for ((&v, low), high) in row.iter().zip(&mut low).zip(&mut high) {
                *low = if v < *low { v } else { *low };
                *high = if v > *high { v } else { *high };
            }
        }
        if sided(&low, &high).is_empty() {
            break;
        }
    }
    sided(&low, &high)
}

/// Most records vary about zero, and their first samples say so.
fn crosses_zero(samples: impl Iterator<Item = f64>) -> bool {
    let (mut below, mut above) = (false, false);
    for v in samples.take(64) {
        below |= v <= 0.0;
        above |= v >= 0.0;
    }
    below && above
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_a_billion_times_the_signal_costs_no_digits() {
        let n = 1000;
        let tone = |i: usize| (std::f64::consts::TAU * 37.0 * i as f64 / n as f64).cos();
        // What the offset samples hold of the signal once stored.
        let stored: Vec<f64> = (0..n).map(|i| (1e9 + tone(i)) - 1e9).collect();
        let offset: Vec<f64> = stored.iter().map(|v| 1e9 + v).collect();
        let plan = RealTransform::<f64>::new(&vec![1.0; n], n);
        let (mut a, mut b) = (Scratch::default(), Scratch::default());
        let (plain, _) = plan.transform(&stored, &mut a);
        let (shifted, _) = plan.transform(&offset, &mut b);
        for m in 1..plan.bins() {
            let error = (shifted[m] - plain[m]).norm() / (n as f64 / 2.0);
            assert!(error < 1e-15, "{m}: {error:e}");
        }
        assert!((shifted[0].re - plain[0].re - 1e12).abs() < 1e-3);
    }

    /// Padded and tapered, the mean's part is that of the window: against direct sums.
    #[test]
    fn val_direct_sums_of_a_tapered_padded_offset() {
        let n = 600;
        let window: Vec<f64> = (0..n).map(|i| (i as f64 * 5e-3).sin()).collect();
        let record: Vec<f64> = (0..n).map(|i| 50.0 + (i as f64 * 0.7).cos()).collect();
        let plan = RealTransform::<f64>::new(&window, 1000);
        let mut scratch = Scratch::default();
        let (fast, _) = plan.transform(&record, &mut scratch);
        let mut tapered: Vec<f64> = record.iter().zip(&window).map(|(v, w)| v * w).collect();
        tapered.resize(1000, 0.0);
        let bins: Vec<usize> = (0..plan.bins()).collect();
        let direct = super::super::direct_sums(&tapered, &bins);
        for (m, (x, z)) in fast.iter().zip(direct).enumerate() {
            let error = (x - z).norm() / fast[0].norm();
            assert!(error < 3e-16, "{m}: {error:e}");
        }
    }
}
