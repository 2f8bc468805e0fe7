//! Passes of convolutions: columns times a chirp, and last passes of complex transforms, which multiply or order the
//! bins.

// Loops over places in registers are unrolled; iterators over several arrays are not, always.
#![allow(clippy::needless_range_loop)]

use super::super::butterfly::{Butterfly, Complex, Dft};
use super::super::simd::Lanes;

/// Rows of real columns, each times a complex factor, as complex numbers.
///
/// # Safety
/// As [`first`](super::first); of `count` rows, `next` numbers apart, those below `valid` exist, the others count
/// as 0. `factors` has one each of the first, `factors_apart` factors apart.
#[inline(always)]
pub(in super::super) unsafe fn chirp<L: Lanes>(
    from: *const L::Scalar,
    next: usize,
    factors: *const L::Scalar,
    factors_apart: usize,
    valid: usize,
    count: usize,
    to: *mut L::Scalar,
) {
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for i in 0..valid {
            let x = L::load(from.add(i * next));
            let factor = factors.add(2 * i * factors_apart);
            let z = Complex {
                re: x.mul(L::splat(factor)),
                im: x.mul(L::splat(factor.add(1))),
            };
            z.store(to.add(i * 2 * L::WIDTH));
        }
        for i in valid..count {
            Complex::<L>::zero().store(to.add(i * 2 * L::WIDTH));
        }
    }
}

/// Complex numbers `next` numbers apart, to neighbours.
///
/// # Safety
/// As [`first`](super::first).
#[inline(always)]
pub(in super::super) unsafe fn collect<L: Lanes>(
    from: *const L::Scalar,
    next: usize,
    count: usize,
    to: *mut L::Scalar,
) {
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for i in 0..count {
            Complex::<L>::load(from.add(i * next)).store(to.add(i * 2 * L::WIDTH));
        }
    }
}

/// What a complex transform's last pass finds.
#[derive(Debug, Clone, Copy)]
pub struct Unordered<T> {
    /// `groups * R` complex numbers of the passes before.
    pub from: *const T,
    pub groups: usize,
    /// The low digit of each group.
    pub digits: *const u32,
}

impl<T> Unordered<T> {
    /// The bins `low + s groups` of a group, and `low`.
    #[inline(always)]
    unsafe fn bins<L: Lanes<Scalar = T>, const R: usize>(
        &self,
        group: usize,
    ) -> ([Complex<L>; R], usize)
    where
        Dft: Butterfly<R>,
    {
        // SAFETY: a group of the caller's.
        unsafe {
            let mut x = [Complex::<L>::zero(); R];
            for (i, x) in x.iter_mut().enumerate() {
                *x = Complex::load(self.from.add((group * R + i) * 2 * L::WIDTH));
            }
            let low = *self.digits.add(group) as usize;
            (<Dft as Butterfly<R>>::of(x), low)
        }
    }
}

/// Where a complex transform's last pass finds and leaves its numbers.
#[derive(Debug, Clone, Copy)]
pub struct Twiddled<T> {
    pub of: Unordered<T>,
    /// The place of bin 0, and the distance to the next, in numbers.
    pub to: *mut T,
    pub next: usize,
    /// A factor for each bin, and the distance to the next, in factors.
    pub factors: *const T,
    pub factors_apart: usize,
    /// Bins from here on are left out.
    pub end: usize,
}

/// Last pass of a complex transform: its bins in order, each times its factor; where `CONJUGATE`, the
/// conjugates of these; where `INTERLEAVE`, as rows of a spectrum.
///
/// # Safety
/// As [`first`](super::first), for the places that [`Twiddled`] names.
#[inline(always)]
pub(in super::super) unsafe fn twiddle<
    L: Lanes,
    const R: usize,
    const CONJUGATE: bool,
    const INTERLEAVE: bool,
>(
    at: &Twiddled<L::Scalar>,
) where
    Dft: Butterfly<R>,
{
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        let zero = L::of(0.0);
        for group in 0..at.of.groups {
            let (y, low) = at.of.bins::<L, R>(group);
            for (s, y) in y.into_iter().enumerate() {
                let bin = low + s * at.of.groups;
                if bin >= at.end {
                    continue;
                }
                let mut z = y.times(at.factors.add(2 * bin * at.factors_apart));
                if CONJUGATE {
                    z.im = zero.sub(z.im);
                }
                let to = at.to.add(bin * at.next);
                if INTERLEAVE {
                    L::store_interleaved::<false>(z.re, z.im, to);
                } else {
                    z.store(to);
                }
            }
        }
    }
}

/// Last pass of a complex transform: its bins in order. Without factors; see [`twiddle`] for the rest.
///
/// # Safety
/// As [`first`](super::first), for the places that [`Twiddled`] names.
#[inline(always)]
pub(in super::super) unsafe fn order<L: Lanes, const R: usize>(at: &Twiddled<L::Scalar>)
where
    Dft: Butterfly<R>,
{
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for group in 0..at.of.groups {
            let (y, low) = at.of.bins::<L, R>(group);
            for (s, y) in y.into_iter().enumerate() {
                y.store(at.to.add((low + s * at.of.groups) * at.next));
            }
        }
    }
}
