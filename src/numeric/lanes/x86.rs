//! Registers of x86-64.
//!
//! Values of these types arise in [`super::widest`] alone, on a processor that has the
//! instructions; that makes every call of an intrinsic below sound. Pointers are those of whole,
//! aligned blocks.

use num_complex::Complex;

use super::{Add, Div, LaneBlock, Lanes, Mul, Number, SimdKernel, Sub, WIDTH};
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
                // SAFETY: see the module.
                unsafe { Avx2($avx2(self.0, other.0), $avx2(self.1, other.1)) }
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

/// Lane by lane, through memory.
macro_rules! map3 {
    () => {
        #[inline(always)]
        fn map3(self, b: Self, c: Self, f: impl Fn(f64, f64, f64) -> f64) -> Self {
            self.at_each(0, b, c, |_, a, b, c| f(a, b, c))
        }

        #[inline(always)]
        fn at_each(
            self,
            at: usize,
            b: Self,
            c: Self,
            f: impl Fn(usize, f64, f64, f64) -> f64,
        ) -> Self {
            let mut blocks = [LaneBlock::default(); 3];
            for (lanes, block) in [self, b, c].into_iter().zip(&mut blocks) {
                lanes.store(block);
            }
            let [a, b, c] = blocks.map(|block| block.0);
            Self::load(&LaneBlock(std::array::from_fn(|l| {
                f(at + l, a[l], b[l], c[l])
            })))
        }
    };
}

// Each `unsafe` below: see the module; pointers are those of whole, aligned blocks.
impl Number for Avx512 {
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
        unsafe {
            let above = _mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, _mm512_setzero_pd());
            Avx512(_mm512_mask_blend_pd(above, no.0, yes.0))
        }
    }

    #[inline(always)]
    fn positive(self) -> Avx512 {
        Avx512(unsafe { _mm512_max_pd(self.0, _mm512_setzero_pd()) })
    }

    map3!();
}

impl Lanes for Avx512 {
    #[inline(always)]
    fn load(block: &LaneBlock) -> Avx512 {
        Avx512(unsafe { _mm512_load_pd(block.0.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, block: &mut LaneBlock) {
        unsafe { _mm512_store_pd(block.0.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn read(from: &[f64; WIDTH]) -> Avx512 {
        Avx512(unsafe { _mm512_loadu_pd(from.as_ptr()) })
    }

    #[inline(always)]
    fn write(self, to: &mut [f64; WIDTH]) {
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), self.0) }
    }

    // For equal numbers and for NaN these return the second operand.
    #[inline(always)]
    fn least(self, old: Avx512) -> Avx512 {
        Avx512(unsafe { _mm512_min_pd(self.0, old.0) })
    }

    #[inline(always)]
    fn largest(self, old: Avx512) -> Avx512 {
        Avx512(unsafe { _mm512_max_pd(self.0, old.0) })
    }

    #[inline(always)]
    fn where_equal(self, other: Avx512, no: Avx512) -> Avx512 {
        unsafe {
            let equal = _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(self.0, other.0);
            Avx512(_mm512_mask_blend_pd(equal, no.0, self.0))
        }
    }

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
    fn parts(from: &[Complex<f64>; WIDTH]) -> [Avx512; 2] {
        let start = from.as_ptr().cast::<f64>();
        unsafe {
            let (low, high) = (_mm512_loadu_pd(start), _mm512_loadu_pd(start.add(WIDTH)));
            let even = _mm512_setr_epi64(0, 2, 4, 6, 8, 10, 12, 14);
            let odd = _mm512_setr_epi64(1, 3, 5, 7, 9, 11, 13, 15);
            let re = _mm512_permutex2var_pd(low, even, high);
            let im = _mm512_permutex2var_pd(low, odd, high);
            [Avx512(re), Avx512(im)]
        }
    }

    #[inline(always)]
    fn fused(self, factor: Avx512, term: Avx512) -> Avx512 {
        Avx512(unsafe { _mm512_fmadd_pd(self.0, factor.0, term.0) })
    }
}

impl Number for Avx2 {
    #[inline(always)]
    fn splat(value: f64) -> Avx2 {
        unsafe { Avx2(_mm256_set1_pd(value), _mm256_set1_pd(value)) }
    }

    #[inline(always)]
    fn sqrt(self) -> Avx2 {
        unsafe { Avx2(_mm256_sqrt_pd(self.0), _mm256_sqrt_pd(self.1)) }
    }

    #[inline(always)]
    fn choose(self, yes: Avx2, no: Avx2) -> Avx2 {
        unsafe {
            let zero = _mm256_setzero_pd();
            let low = _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, zero);
            let high = _mm256_cmp_pd::<_CMP_GT_OQ>(self.1, zero);
            Avx2(
                _mm256_blendv_pd(no.0, yes.0, low),
                _mm256_blendv_pd(no.1, yes.1, high),
            )
        }
    }

    #[inline(always)]
    fn positive(self) -> Avx2 {
        unsafe {
            let zero = _mm256_setzero_pd();
            Avx2(_mm256_max_pd(self.0, zero), _mm256_max_pd(self.1, zero))
        }
    }

    map3!();
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

/// From 0, 2, 1, 3 to 0, 1, 2, 3.
#[inline(always)]
fn in_turn(lanes: __m256d) -> __m256d {
    unsafe { _mm256_permute4x64_pd::<0b11_01_10_00>(lanes) }
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn load(block: &LaneBlock) -> Avx2 {
        let start = block.0.as_ptr();
        unsafe { Avx2(_mm256_load_pd(start), _mm256_load_pd(start.add(WIDTH / 2))) }
    }

    #[inline(always)]
    fn store(self, block: &mut LaneBlock) {
        let start = block.0.as_mut_ptr();
        unsafe {
            _mm256_store_pd(start, self.0);
            _mm256_store_pd(start.add(WIDTH / 2), self.1);
        }
    }

    #[inline(always)]
    fn read(from: &[f64; WIDTH]) -> Avx2 {
        let start = from.as_ptr();
        unsafe {
            Avx2(
                _mm256_loadu_pd(start),
                _mm256_loadu_pd(start.add(WIDTH / 2)),
            )
        }
    }

    #[inline(always)]
    fn write(self, to: &mut [f64; WIDTH]) {
        let start = to.as_mut_ptr();
        unsafe {
            _mm256_storeu_pd(start, self.0);
            _mm256_storeu_pd(start.add(WIDTH / 2), self.1);
        }
    }

    #[inline(always)]
    fn least(self, old: Avx2) -> Avx2 {
        unsafe { Avx2(_mm256_min_pd(self.0, old.0), _mm256_min_pd(self.1, old.1)) }
    }

    #[inline(always)]
    fn largest(self, old: Avx2) -> Avx2 {
        unsafe { Avx2(_mm256_max_pd(self.0, old.0), _mm256_max_pd(self.1, old.1)) }
    }

    #[inline(always)]
    fn where_equal(self, other: Avx2, no: Avx2) -> Avx2 {
        unsafe {
            let low = _mm256_cmp_pd::<_CMP_EQ_OQ>(self.0, other.0);
            let high = _mm256_cmp_pd::<_CMP_EQ_OQ>(self.1, other.1);
            Avx2(
                _mm256_blendv_pd(no.0, self.0, low),
                _mm256_blendv_pd(no.1, self.1, high),
            )
        }
    }

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
        unsafe {
            let zero = _mm256_setzero_pd();
            let low = _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, zero);
            let high = _mm256_cmp_pd::<_CMP_GT_OQ>(self.1, zero);
            (_mm256_movemask_pd(low) | _mm256_movemask_pd(high) << 4) as u8
        }
    }

    #[inline(always)]
    fn parts(from: &[Complex<f64>; WIDTH]) -> [Avx2; 2] {
        let start = from.as_ptr().cast::<f64>();
        unsafe {
            let (a, b) = (_mm256_loadu_pd(start), _mm256_loadu_pd(start.add(4)));
            let (c, d) = (
                _mm256_loadu_pd(start.add(8)),
                _mm256_loadu_pd(start.add(12)),
            );
            let re = Avx2(
                in_turn(_mm256_unpacklo_pd(a, b)),
                in_turn(_mm256_unpacklo_pd(c, d)),
            );
            let im = Avx2(
                in_turn(_mm256_unpackhi_pd(a, b)),
                in_turn(_mm256_unpackhi_pd(c, d)),
            );
            [re, im]
        }
    }

    #[inline(always)]
    fn fused(self, factor: Avx2, term: Avx2) -> Avx2 {
        unsafe {
            Avx2(
                _mm256_fmadd_pd(self.0, factor.0, term.0),
                _mm256_fmadd_pd(self.1, factor.1, term.1),
            )
        }
    }
}
