//! The number types of transforms.

mod private {
    use std::sync::Arc;

    use realfft::{ComplexToReal, FftNum, RealFftPlanner, RealToComplex};
    use rustfft::{Fft, FftDirection, FftPlanner};

    /// Kernels exist for these types alone. The planners are called here, for concrete types, so that
    /// no dependent crate compiles their kernels.
    pub trait Sealed: FftNum {
        fn plan_fft_forward(len: usize) -> Arc<dyn RealToComplex<Self>>;
        fn plan_fft_inverse(len: usize) -> Arc<dyn ComplexToReal<Self>>;
        fn plan_fft_complex(len: usize, direction: FftDirection) -> Arc<dyn Fft<Self>>;
    }

    macro_rules! seal {
        ($real:ty) => {
            impl Sealed for $real {
                fn plan_fft_forward(len: usize) -> Arc<dyn RealToComplex<$real>> {
                    RealFftPlanner::new().plan_fft_forward(len)
                }
                fn plan_fft_inverse(len: usize) -> Arc<dyn ComplexToReal<$real>> {
                    RealFftPlanner::new().plan_fft_inverse(len)
                }
                fn plan_fft_complex(len: usize, direction: FftDirection) -> Arc<dyn Fft<$real>> {
                    FftPlanner::new().plan_fft(len, direction)
                }
            }
        };
    }
    seal!(f32);
    seal!(f64);
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
