//! Plans of contiguous records, made by RustFFT and realfft.
//!
//! Their planners are generic, so every crate that calls them compiles all their kernels again. These
//! functions are compiled once, here.

use std::sync::Arc;

use realfft::{ComplexToReal, RealToComplex};
use rustfft::{Fft, FftDirection};

use crate::Real;

/// Real records of `len` samples to their spectra: `X_m = sum_n v_n exp(-2 pi i m n / len)`,
/// `m = 0 ..= len / 2`.
pub fn plan_fft_forward<T: Real>(len: usize) -> Arc<dyn RealToComplex<T>> {
    T::plan_fft_forward(len)
}

/// Spectra to real records of `len` samples: `sum_m X_m exp(+2 pi i m n / len)` over all `m` of both
/// signs, unnormalised.
pub fn plan_fft_inverse<T: Real>(len: usize) -> Arc<dyn ComplexToReal<T>> {
    T::plan_fft_inverse(len)
}

/// Complex records of `len` samples to their spectra, or back, unnormalised.
pub fn plan_fft_complex<T: Real>(len: usize, direction: FftDirection) -> Arc<dyn Fft<T>> {
    T::plan_fft_complex(len, direction)
}
