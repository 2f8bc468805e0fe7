//! The number types of transforms.

mod private {
    /// Kernels exist for these types alone.
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// Numbers that are transformed: `f32` and `f64`. No other type can implement this trait.
pub trait Real: realfft::FftNum + bytemuck::Pod + Default + private::Sealed {
    /// The distance from 1 to the next number.
    const EPSILON: f64;

    /// The nearest number of this type.
    fn rounded(x: f64) -> Self;

    /// The same number in double precision.
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
