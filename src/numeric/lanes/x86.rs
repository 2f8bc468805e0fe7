//! Registers of x86-64.
//!
//! Values of these types arise in [`super::widest`] alone, on a processor that has the
//! instructions; that makes every call of an intrinsic below sound. Pointers are those of eight numbers.

use super::{Add, Div, Lanes, Mul, Number, SimdKernel, Sub, WIDTH};
use std::arch::x86_64::*;

#[target_feature(enable = "avx512f")]
pub(super) fn with_avx512<W: SimdKernel>(work: W) -> W::Output {
    work.run::<Avx512>()
}

#[target_feature(enable = "avx2,fma")]
pub(super) fn with_avx2<W: SimdKernel>(work: W) -> W::Output {
    work.run::<Avx2>()
}

#[derive(Clone, Copy)]
pub(super) struct Avx512(__m512d);

#[derive(Clone, Copy)]
pub(super) struct Avx2(__m256d, __m256d);

/// The same instruction for both halves of [`Avx2`].
macro_rules! halves {
    ($instruction:path, $($of:expr),+) => {
        // SAFETY: see the module.
        unsafe { Avx2($instruction($($of.0),+), $instruction($($of.1),+)) }
    };
}

macro_rules! arithmetic {
    ($($operator:ident $method:ident $avx512:ident $avx2:ident)*) => {$(
        impl $operator for Avx512 {
            type Output = Avx512;

            #[inline(always)]
            fn $method(self, other: Avx512) -> Avx512 {
                // SAFETY: see the module.
                Avx512(unsafe { $avx512(self.0, other.0) })
            }
        }

        impl $operator for Avx2 {
            type Output = Avx2;

            #[inline(always)]
            fn $method(self, other: Avx2) -> Avx2 {
                halves!($avx2, self, other)
            }
        }
    )*};
}
arithmetic! {
    Add add _mm512_add_pd _mm256_add_pd
    Sub sub _mm512_sub_pd _mm256_sub_pd
    Mul mul _mm512_mul_pd _mm256_mul_pd
    Div div _mm512_div_pd _mm256_div_pd
}

// Each `unsafe` below: see the module.
impl Number for Avx512 {
    #[inline(always)]
    fn read(from: &[f64; WIDTH]) -> Avx512 {
        Avx512(unsafe { _mm512_loadu_pd(from.as_ptr()) })
    }

    #[inline(always)]
    fn write(self, to: &mut [f64; WIDTH]) {
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn splat(value: f64) -> Avx512 {
        Avx512(unsafe { _mm512_set1_pd(value) })
    }

    #[inline(always)]
    fn sqrt(self) -> Avx512 {
        Avx512(unsafe { _mm512_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn choose(self, yes: Avx512, no: Avx512) -> Avx512 {
        Avx512(unsafe { _mm512_mask_blend_pd(self.positive_mask(), no.0, yes.0) })
    }
}

impl Lanes for Avx512 {
    #[inline(always)]
    fn take_left(self, before: Avx512) -> Avx512 {
        unsafe {
            let (now, before) = (_mm512_castpd_si512(self.0), _mm512_castpd_si512(before.0));
            Avx512(_mm512_castsi512_pd(_mm512_alignr_epi64::<7>(now, before)))
        }
    }

    #[inline(always)]
    fn take_right(self, after: Avx512) -> Avx512 {
        unsafe {
            let (now, after) = (_mm512_castpd_si512(self.0), _mm512_castpd_si512(after.0));
            Avx512(_mm512_castsi512_pd(_mm512_alignr_epi64::<1>(after, now)))
        }
    }

    #[inline(always)]
    fn positive_mask(self) -> u8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, _mm512_setzero_pd()) }
    }

    #[inline(always)]
    fn fused(self, factor: Avx512, term: Avx512) -> Avx512 {
        Avx512(unsafe { _mm512_fmadd_pd(self.0, factor.0, term.0) })
    }
}

impl Avx2 {
    /// All bits of the lanes that are above 0.
    #[inline(always)]
    fn above_zero(self) -> Avx2 {
        halves!(_mm256_cmp_pd::<_CMP_GT_OQ>, self, Avx2::splat(0.0))
    }
}

/// The last of `left`, then the first three of `right`.
#[inline(always)]
fn last_of(left: __m256d, right: __m256d) -> __m256d {
    unsafe { _mm256_shuffle_pd::<0b0101>(_mm256_permute2f128_pd::<0x21>(left, right), right) }
}

/// The last three of `left`, then the first of `right`.
#[inline(always)]
fn first_of(left: __m256d, right: __m256d) -> __m256d {
    unsafe { _mm256_shuffle_pd::<0b0101>(left, _mm256_permute2f128_pd::<0x21>(left, right)) }
}

impl Number for Avx2 {
    #[inline(always)]
    fn read(from: &[f64; WIDTH]) -> Avx2 {
        let start = from.as_ptr();
        unsafe { Avx2(_mm256_loadu_pd(start), _mm256_loadu_pd(start.add(4))) }
    }

    #[inline(always)]
    fn write(self, to: &mut [f64; WIDTH]) {
        let start = to.as_mut_ptr();
        unsafe {
            _mm256_storeu_pd(start, self.0);
            _mm256_storeu_pd(start.add(4), self.1);
        }
    }

    #[inline(always)]
    fn splat(value: f64) -> Avx2 {
        let half = unsafe { _mm256_set1_pd(value) };
        Avx2(half, half)
    }

    #[inline(always)]
    fn sqrt(self) -> Avx2 {
        halves!(_mm256_sqrt_pd, self)
    }

    #[inline(always)]
    fn choose(self, yes: Avx2, no: Avx2) -> Avx2 {
        halves!(_mm256_blendv_pd, no, yes, self.above_zero())
    }
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn take_left(self, before: Avx2) -> Avx2 {
        Avx2(last_of(before.1, self.0), last_of(self.0, self.1))
    }

    #[inline(always)]
    fn take_right(self, after: Avx2) -> Avx2 {
        Avx2(first_of(self.0, self.1), first_of(self.1, after.0))
    }

    #[inline(always)]
    fn positive_mask(self) -> u8 {
        let Avx2(low, high) = self.above_zero();
        unsafe { (_mm256_movemask_pd(low) | _mm256_movemask_pd(high) << 4) as u8 }
    }

    #[inline(always)]
    fn fused(self, factor: Avx2, term: Avx2) -> Avx2 {
        halves!(_mm256_fmadd_pd, self, factor, term)
    }
}
