//! Registers of x86-64.

use std::arch::x86_64::*;

use super::Lanes;

#[derive(Debug, Clone, Copy)]
pub(in crate::columns) struct X512f64(__m512d);
#[derive(Debug, Clone, Copy)]
pub(in crate::columns) struct X512f32(__m512);
#[derive(Debug, Clone, Copy)]
pub(in crate::columns) struct X256f64(__m256d);
#[derive(Debug, Clone, Copy)]
pub(in crate::columns) struct X256f32(__m256);

/// `interleave` gives the lower and the upper half of `re, im, re, im, ..`.
macro_rules! lanes {
    ($name:ident, $scalar:ty, $width:literal, $load:ident, $store:ident, $stream:ident, $set:ident,
     $add:ident, $sub:ident, $mul:ident, $fma:ident, $fms:ident, $fnma:ident, $interleave:ident) => {
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
                $name(unsafe { $fma(self.0, factor.0, term.0) })
            }

            #[inline(always)]
            unsafe fn mul_sub(self, factor: Self, term: Self) -> Self {
                $name(unsafe { $fms(self.0, factor.0, term.0) })
            }

            #[inline(always)]
            unsafe fn neg_mul_add(self, factor: Self, term: Self) -> Self {
                $name(unsafe { $fnma(self.0, factor.0, term.0) })
            }

            #[inline(always)]
            unsafe fn store_interleaved<const STREAM: bool>(re: Self, im: Self, to: *mut $scalar) {
                unsafe {
                    let (low, high) = $interleave(re.0, im.0);
                    if STREAM {
                        $stream(to, low);
                        $stream(to.add($width), high);
                    } else {
                        $store(to, low);
                        $store(to.add($width), high);
                    }
                }
            }

            #[inline(always)]
            unsafe fn prefetch(at: *const $scalar) {
                unsafe { _mm_prefetch::<_MM_HINT_T1>(at.cast()) }
            }
        }
    };
}

lanes!(
    X512f64,
    f64,
    8,
    _mm512_loadu_pd,
    _mm512_storeu_pd,
    _mm512_stream_pd,
    _mm512_set1_pd,
    _mm512_add_pd,
    _mm512_sub_pd,
    _mm512_mul_pd,
    _mm512_fmadd_pd,
    _mm512_fmsub_pd,
    _mm512_fnmadd_pd,
    interleave_512_f64
);
lanes!(
    X512f32,
    f32,
    16,
    _mm512_loadu_ps,
    _mm512_storeu_ps,
    _mm512_stream_ps,
    _mm512_set1_ps,
    _mm512_add_ps,
    _mm512_sub_ps,
    _mm512_mul_ps,
    _mm512_fmadd_ps,
    _mm512_fmsub_ps,
    _mm512_fnmadd_ps,
    interleave_512_f32
);
lanes!(
    X256f64,
    f64,
    4,
    _mm256_loadu_pd,
    _mm256_storeu_pd,
    _mm256_stream_pd,
    _mm256_set1_pd,
    _mm256_add_pd,
    _mm256_sub_pd,
    _mm256_mul_pd,
    _mm256_fmadd_pd,
    _mm256_fmsub_pd,
    _mm256_fnmadd_pd,
    interleave_256_f64
);
lanes!(
    X256f32,
    f32,
    8,
    _mm256_loadu_ps,
    _mm256_storeu_ps,
    _mm256_stream_ps,
    _mm256_set1_ps,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_fmadd_ps,
    _mm256_fmsub_ps,
    _mm256_fnmadd_ps,
    interleave_256_f32
);

#[inline(always)]
unsafe fn interleave_512_f64(re: __m512d, im: __m512d) -> (__m512d, __m512d) {
    unsafe {
        let low = _mm512_set_epi64(11, 3, 10, 2, 9, 1, 8, 0);
        let high = _mm512_set_epi64(15, 7, 14, 6, 13, 5, 12, 4);
        (
            _mm512_permutex2var_pd(re, low, im),
            _mm512_permutex2var_pd(re, high, im),
        )
    }
}

#[inline(always)]
unsafe fn interleave_512_f32(re: __m512, im: __m512) -> (__m512, __m512) {
    unsafe {
        let low = _mm512_set_epi32(23, 7, 22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0);
        let high = _mm512_set_epi32(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9, 24, 8);
        (
            _mm512_permutex2var_ps(re, low, im),
            _mm512_permutex2var_ps(re, high, im),
        )
    }
}

#[inline(always)]
unsafe fn interleave_256_f64(re: __m256d, im: __m256d) -> (__m256d, __m256d) {
    unsafe {
        let even = _mm256_unpacklo_pd(re, im);
        let odd = _mm256_unpackhi_pd(re, im);
        (
            _mm256_permute2f128_pd::<0x20>(even, odd),
            _mm256_permute2f128_pd::<0x31>(even, odd),
        )
    }
}

#[inline(always)]
unsafe fn interleave_256_f32(re: __m256, im: __m256) -> (__m256, __m256) {
    unsafe {
        let even = _mm256_unpacklo_ps(re, im);
        let odd = _mm256_unpackhi_ps(re, im);
        (
            _mm256_permute2f128_ps::<0x20>(even, odd),
            _mm256_permute2f128_ps::<0x31>(even, odd),
        )
    }
}
