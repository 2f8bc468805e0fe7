//! Registers of AArch64.

use std::arch::aarch64::*;

use super::Lanes;

#[derive(Debug, Clone, Copy)]
pub(in crate::columns) struct Neon64(float64x2_t);
#[derive(Debug, Clone, Copy)]
pub(in crate::columns) struct Neon32(float32x4_t);

macro_rules! lanes {
    ($name:ident, $scalar:ty, $width:literal, $load:ident, $store:ident, $set:ident, $neg:ident,
     $add:ident, $sub:ident, $mul:ident, $fma:ident, $fms:ident, $low:ident, $high:ident) => {
        // SAFETY of every block: that of the trait's functions, which is the caller's to keep.
        impl Lanes for $name {
            type Scalar = $scalar;
            const WIDTH: usize = $width;

            #[inline(always)]
            unsafe fn load(from: *const $scalar) -> Self {
                $name(unsafe { $load(from) })
            }

            #[inline(always)]
            unsafe fn store(self, to: *mut $scalar) {
                unsafe { $store(to, self.0) }
            }

            #[inline(always)]
            unsafe fn splat(from: *const $scalar) -> Self {
                $name(unsafe { $set(*from) })
            }

            #[inline(always)]
            unsafe fn of(value: f64) -> Self {
                $name(unsafe { $set(value as $scalar) })
            }

            #[inline(always)]
            unsafe fn add(self, other: Self) -> Self {
                $name(unsafe { $add(self.0, other.0) })
            }

            #[inline(always)]
            unsafe fn sub(self, other: Self) -> Self {
                $name(unsafe { $sub(self.0, other.0) })
            }

            #[inline(always)]
            unsafe fn mul(self, other: Self) -> Self {
                $name(unsafe { $mul(self.0, other.0) })
            }

            #[inline(always)]
            unsafe fn mul_add(self, factor: Self, term: Self) -> Self {
                $name(unsafe { $fma(term.0, self.0, factor.0) })
            }

            #[inline(always)]
            unsafe fn mul_sub(self, factor: Self, term: Self) -> Self {
                $name(unsafe { $fma($neg(term.0), self.0, factor.0) })
            }

            #[inline(always)]
            unsafe fn neg_mul_add(self, factor: Self, term: Self) -> Self {
                $name(unsafe { $fms(term.0, self.0, factor.0) })
            }

            #[inline(always)]
            unsafe fn store_interleaved<const STREAM: bool>(re: Self, im: Self, to: *mut $scalar) {
                unsafe {
                    $store(to, $low(re.0, im.0));
                    $store(to.add($width), $high(re.0, im.0));
                }
            }

            #[inline(always)]
            unsafe fn prefetch(_: *const $scalar) {}
        }
    };
}

lanes!(
    Neon64,
    f64,
    2,
    vld1q_f64,
    vst1q_f64,
    vdupq_n_f64,
    vnegq_f64,
    vaddq_f64,
    vsubq_f64,
    vmulq_f64,
    vfmaq_f64,
    vfmsq_f64,
    vzip1q_f64,
    vzip2q_f64
);
lanes!(
    Neon32,
    f32,
    4,
    vld1q_f32,
    vst1q_f32,
    vdupq_n_f32,
    vnegq_f32,
    vaddq_f32,
    vsubq_f32,
    vmulq_f32,
    vfmaq_f32,
    vfmsq_f32,
    vzip1q_f32,
    vzip2q_f32
);
