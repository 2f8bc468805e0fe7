//! Complex profiles to their spectrum over wavenumbers of both signs.

use std::sync::Arc;

use num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use super::Real;
use super::real::{Scratch, dominant_mean_of};

/// `X_m = sum_j w_j u_j exp(+2 pi i m j / N)` of a complex profile, `m` ascending from
/// `-(N / 2)`, so that positive m travels towards +x.
pub struct ComplexTransform<T: Real> {
    plan: Arc<dyn Fft<T>>,
    window: Vec<f64>,
    mean_response: Vec<Complex<f64>>,
}

impl<T: Real> ComplexTransform<T> {
    /// Plans transforms of `window.len()` samples padded to `padded`.
    ///
    /// # Panics
    /// If there are no samples or `padded` is shorter than the window.
    pub fn new(window: &[f64], padded: usize) -> Self {
        assert!(!window.is_empty() && padded >= window.len());
        let plan = FftPlanner::<T>::new().plan_fft_inverse(padded);
        let mut mean_response: Vec<Complex<f64>> =
            window.iter().map(|&w| Complex::new(w, 0.0)).collect();
        mean_response.resize(padded, Complex::default());
        if padded == window.len() && window.iter().all(|&w| w == 1.0) {
            mean_response.fill(Complex::default());
            mean_response[0].re = padded as f64;
        } else {
            FftPlanner::<f64>::new()
                .plan_fft_inverse(padded)
                .process(&mut mean_response);
        }
        ComplexTransform {
            plan,
            window: window.to_vec(),
            mean_response,
        }
    }

    /// Length N of the transform.
    pub fn padded(&self) -> usize {
        self.plan.len()
    }

    /// Adds `|X_m|^2` of `profile` to `sum`, ascending in m.
    ///
    /// # Panics
    /// If `profile` is not as long as the window or `sum` not as long as the transform.
    pub fn add_power(&self, profile: &[Complex<T>], scratch: &mut Scratch<T>, sum: &mut [f64]) {
        assert_eq!(profile.len(), self.window.len());
        assert_eq!(sum.len(), self.padded());
        let mean = dominant_mean(profile);
        let Scratch { spectrum, work, .. } = scratch;
        spectrum.clear();
        spectrum.extend(profile.iter().zip(&self.window).map(|(u, &w)| {
            Complex::new(
                T::rounded((u.re.to_f64() - mean.re) * w),
                T::rounded((u.im.to_f64() - mean.im) * w),
            )
        }));
        spectrum.resize(self.padded(), Complex::default());
        work.resize(self.plan.get_inplace_scratch_len(), Complex::default());
        self.plan.process_with_scratch(spectrum, work);
        if mean != Complex::default() {
            for (x, response) in spectrum.iter_mut().zip(&self.mean_response) {
                let added = mean * response;
                x.re = T::rounded(x.re.to_f64() + added.re);
                x.im = T::rounded(x.im.to_f64() + added.im);
            }
        }
        // Bins come as m = 0, 1, .., -1; ascending they start at the first negative one.
        let (from_zero, negative) = spectrum.split_at(self.padded() - self.padded() / 2);
        for (s, &x) in sum.iter_mut().zip(negative.iter().chain(from_zero)) {
            *s += super::power(x);
        }
    }
}

impl<T: Real> std::fmt::Debug for ComplexTransform<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ComplexTransform")
            .field("samples", &self.window.len())
            .field("padded", &self.padded())
            .finish_non_exhaustive()
    }
}

/// The mean of a profile whose every sample lies within a quarter of it, else 0; part by part.
fn dominant_mean<T: Real>(profile: &[Complex<T>]) -> Complex<f64> {
    Complex::new(
        dominant_mean_of(profile.iter().map(|u| u.re.to_f64())),
        dominant_mean_of(profile.iter().map(|u| u.im.to_f64())),
    )
}
