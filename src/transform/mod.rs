//! Transforms of real records and complex profiles: planned once, run many times.
//!
//! # Normalisation and order
//! Forward transforms are unnormalised sums. Along time the kernel is `exp(-2 pi i f t)`, along
//! space `exp(+i k x)`, so that a wave `exp(i (k x - omega t))` with `f > 0`, `k > 0` travels
//! towards +x. What turns `|X|^2` into a spectrum is [`Scale`]; how a one-sided spectrum counts
//! the bins it stands for is [`fold`]; both in one place.
//!
//! # Constant parts
//! A record whose mean is far above its variation loses digits in any fast transform: rounding
//! of the large mean is spread over all bins. Such a record is split, exactly, into mean and
//! rest; the rest is transformed and the mean's known transform added. Other records take the
//! direct way.

mod axes;
mod complex;
mod direct;
mod filter;
mod inverse;
mod records;
mod scale;
mod segments;
mod short_time;
mod spacetime;
mod taper;
pub mod vertical;

use num_complex::Complex;

pub use axes::{frequencies, wavenumbers, wavenumbers_signed};
pub use complex::{ComplexScratch, ComplexTransform};
pub use direct::direct_sums;
pub use filter::{Passband, SpaceTimeFilter, Travelling};
pub use inverse::ColumnInverse;
pub use records::{RecordScratch, RecordTransform};
pub use scale::{Scale, Scaling, fold};
pub use segments::Segments;
pub use short_time::ShortTimeTransform;
pub use spacetime::{SpaceTimeInverse, SpaceTimeTransform};
pub use vertical::ColumnTransform;

/// The number types of transforms.
pub trait Real: realfft::FftNum + bytemuck::Pod + Default + vertical::Kernelled {
    /// From 1 to the next number.
    const EPSILON: f64;

    /// The nearest number of this type.
    fn rounded(x: f64) -> Self;
    fn to_f64(self) -> f64;
}

impl Real for f64 {
    const EPSILON: f64 = f64::EPSILON;

    #[inline(always)]
    fn rounded(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
}

impl Real for f32 {
    const EPSILON: f64 = f32::EPSILON as f64;

    #[inline(always)]
    fn rounded(x: f64) -> f32 {
        x as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

/// `|z|^2` in double precision.
#[inline(always)]
pub fn power<T: Real>(z: Complex<T>) -> f64 {
    let (re, im) = (z.re.to_f64(), z.im.to_f64());
    re * re + im * im
}
