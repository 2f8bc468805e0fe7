//! Lanes for any processor: loops that the compiler vectorises.

use super::Lanes;
use crate::Real;

/// `N` numbers; products and sums round one by one.
#[derive(Debug, Clone, Copy)]
pub(in crate::columns) struct Portable<T, const N: usize>([T; N]);

impl<T: Real, const N: usize> Portable<T, N> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        let mut out = self.0;
        let mut lane = 0;
        // Iterators here would be a fifth of the crate's build.
        while lane < N {
            out[lane] = f(out[lane], other.0[lane]);
            lane += 1;
        }
        Portable(out)
    }
}

impl<T: Real, const N: usize> Lanes for Portable<T, N> {
    type Scalar = T;
    const WIDTH: usize = N;

    #[inline(always)]
    unsafe fn load(from: *const T) -> Self {
        // SAFETY: the caller's pointer is valid for N numbers.
        Portable(unsafe { from.cast::<[T; N]>().read_unaligned() })
    }

    #[inline(always)]
    unsafe fn store(self, to: *mut T) {
        // SAFETY: as for `load`.
        unsafe { to.cast::<[T; N]>().write_unaligned(self.0) }
    }

    #[inline(always)]
    unsafe fn splat(from: *const T) -> Self {
        // SAFETY: the caller's pointer is valid.
        Portable([unsafe { *from }; N])
    }

    #[inline(always)]
    unsafe fn of(value: f64) -> Self {
        Portable([T::rounded(value); N])
    }

    #[inline(always)]
    unsafe fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    #[inline(always)]
    unsafe fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }

    #[inline(always)]
    unsafe fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }

    #[inline(always)]
    unsafe fn mul_add(self, factor: Self, term: Self) -> Self {
        self.zip(factor, |a, b| a * b).zip(term, |p, t| p + t)
    }

    #[inline(always)]
    unsafe fn mul_sub(self, factor: Self, term: Self) -> Self {
        self.zip(factor, |a, b| a * b).zip(term, |p, t| p - t)
    }

    #[inline(always)]
    unsafe fn neg_mul_add(self, factor: Self, term: Self) -> Self {
        self.zip(factor, |a, b| a * b).zip(term, |p, t| t - p)
    }

    #[inline(always)]
    unsafe fn store_interleaved<const STREAM: bool>(re: Self, im: Self, to: *mut T) {
        for (l, (re, im)) in re.0.into_iter().zip(im.0).enumerate() {
            // SAFETY: the caller's pointer is valid for 2 N numbers.
            unsafe {
                to.add(2 * l).write(re);
                to.add(2 * l + 1).write(im);
            }
        }
    }

    #[inline(always)]
    unsafe fn prefetch(_: *const T) {}
}
