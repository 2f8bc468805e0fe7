//! One number: a lone column, to the bits of a lane.

use super::Lanes;

/// One lane. `FUSED` for kernels with fused multiply-add switched on; else it would be emulated.
#[derive(Debug, Clone, Copy)]
pub(in crate::columns) struct Single<T, const FUSED: bool>(T);

macro_rules! single {
    ($scalar:ty) => {
        // SAFETY of every block: that of the trait's functions, which is the caller's to keep.
        impl<const FUSED: bool> Lanes for Single<$scalar, FUSED> {
            type Scalar = $scalar;
            const WIDTH: usize = 1;

            #[inline(always)]
            unsafe fn load(from: *const $scalar) -> Self {
                Single(unsafe { *from })
            }

            #[inline(always)]
            unsafe fn store(self, to: *mut $scalar) {
                unsafe { *to = self.0 }
            }

            #[inline(always)]
            unsafe fn splat(from: *const $scalar) -> Self {
                Single(unsafe { *from })
            }

            #[inline(always)]
            unsafe fn of(value: f64) -> Self {
                Single(value as $scalar)
            }

            #[inline(always)]
            unsafe fn add(self, other: Self) -> Self {
                Single(self.0 + other.0)
            }

            #[inline(always)]
            unsafe fn sub(self, other: Self) -> Self {
                Single(self.0 - other.0)
            }

            #[inline(always)]
            unsafe fn mul(self, other: Self) -> Self {
                Single(self.0 * other.0)
            }

            #[inline(always)]
            unsafe fn mul_add(self, factor: Self, term: Self) -> Self {
                Single(match FUSED {
                    true => self.0.mul_add(factor.0, term.0),
                    false => self.0 * factor.0 + term.0,
                })
            }

            #[inline(always)]
            unsafe fn mul_sub(self, factor: Self, term: Self) -> Self {
                Single(match FUSED {
                    true => self.0.mul_add(factor.0, -term.0),
                    false => self.0 * factor.0 - term.0,
                })
            }

            #[inline(always)]
            unsafe fn neg_mul_add(self, factor: Self, term: Self) -> Self {
                Single(match FUSED {
                    true => (-self.0).mul_add(factor.0, term.0),
                    false => term.0 - self.0 * factor.0,
                })
            }

            #[inline(always)]
            unsafe fn store_interleaved<const STREAM: bool>(re: Self, im: Self, to: *mut $scalar) {
                unsafe {
                    *to = re.0;
                    *to.add(1) = im.0;
                }
            }

            #[inline(always)]
            unsafe fn prefetch(_: *const $scalar) {}
        }
    };
}
single!(f64);
single!(f32);
