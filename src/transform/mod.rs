//! Transforms of real records and complex profiles: planned once, run many times.
//!
//! # Normalisation and order
//! Forward transforms are unnormalised sums. Along time the kernel is `exp(-2 pi i f t)`, along
//! space `exp(+i k x)`, so that a wave `exp(i (k x - omega t))` with `f > 0`, `k > 0` travels
//! towards +x. [`Scale`] normalizes `|X|^2` to a spectrum; [`fold`] counts the two-sided bins of a
//! one-sided bin.
//!
//! # Constant parts
//! A record whose mean is far above its variation loses digits in any fast transform: rounding of
//! the large mean is spread over all bins. Such a record is split, exactly, into mean and rest; the
//! rest is transformed and the mean's known transform added. Other records are transformed
//! directly.

mod axes;
mod complex;
mod direct;
mod filter;
mod records;
mod scale;
mod segments;
mod taper;

use num_complex::Complex;

pub use column_fft::Real;

pub use axes::{frequencies, wavenumbers, wavenumbers_signed};
pub use complex::{ComplexScratch, ComplexTransform};
pub use direct::direct_sums;
pub use filter::{Passband, Travelling};
pub(crate) use filter::{space_time_filter, space_time_filter_bytes};
pub(crate) use records::quick;
pub use records::{RecordScratch, RecordTransform};
pub use scale::{Scale, Scaling, fold};
pub use segments::Segments;
pub(crate) use taper::less_means;

/// `|z|^2` in double precision.
#[inline(always)]
pub fn power<T: Real>(z: Complex<T>) -> f64 {
    let (re, im) = (z.re.to_f64(), z.im.to_f64());
    re * re + im * im
}
