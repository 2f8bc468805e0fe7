//! Passes of convolutions: columns times a chirp or folded about the middle, and last passes of complex
//! transforms, which multiply, order or scatter the bins.

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

/// Which rows of real columns are folded about the middle, and where.
#[derive(Debug, Clone, Copy)]
pub struct Fold<T> {
    /// Row 0, and the distance to the next, in numbers.
    pub from: *const T,
    pub stride: usize,
    /// Of row n the partner is row `length - n`.
    pub length: usize,
    /// The rows n.
    pub rows: *const u32,
    pub wanted: usize,
    /// Complex numbers in all; those beyond `wanted` are 0.
    pub count: usize,
    pub to: *mut T,
}

/// Sums and differences of rows n and `length - n`, as real and imaginary part.
///
/// # Safety
/// As [`first`](super::first), for the places that [`Fold`] names.
#[inline(always)]
pub(in super::super) unsafe fn fold<L: Lanes>(at: &Fold<L::Scalar>) {
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for i in 0..at.wanted {
            let n = *at.rows.add(i) as usize;
            let x = L::load(at.from.add(n * at.stride));
            let y = L::load(at.from.add((at.length - n) * at.stride));
            let z = Complex {
                re: x.add(y),
                im: x.sub(y),
            };
            z.store(at.to.add(i * 2 * L::WIDTH));
        }
        for i in at.wanted..at.count {
            Complex::<L>::zero().store(at.to.add(i * 2 * L::WIDTH));
        }
    }
}

/// Bins k and -k of one complex series, to be multiplied.
#[derive(Debug, Clone, Copy)]
pub struct Blend<T> {
    /// Bin `k`, and those after it.
    pub bins: *mut T,
    /// Its mirror, and those before it.
    pub mirrors: *mut T,
    pub count: usize,
    /// Two factors P and Q a bin k.
    pub factors: *const T,
}

/// `conj(P z_k + Q conj(z_-k))` and `conj(conj(P) z_-k + conj(Q) conj(z_k))` in the places of `z_k`
/// and `z_-k`: real parts by one response, imaginary parts by another, both real.
///
/// # Safety
/// As [`first`](super::first), for the places that [`Blend`] names.
#[inline(always)]
pub(in super::super) unsafe fn blend<L: Lanes>(at: &Blend<L::Scalar>) {
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for i in 0..at.count {
            let bin = at.bins.add(i * 2 * L::WIDTH);
            let mirror = at.mirrors.sub(i * 2 * L::WIDTH);
            let (a, b) = (Complex::<L>::load(bin), Complex::<L>::load(mirror));
            let factors = at.factors.add(4 * i);
            let [p_re, p_im, q_re, q_im] = [0, 1, 2, 3].map(|f| L::splat(factors.add(f)));
            // Real and imaginary part of P a + Q conj(b), the latter negated.
            let re = q_re.mul_add(b.re, q_im.mul(b.im));
            let im = q_re.mul_sub(b.im, q_im.mul(b.re));
            let w = Complex {
                re: p_im.neg_mul_add(a.im, p_re.mul_add(a.re, re)),
                im: p_im.neg_mul_add(a.re, p_re.neg_mul_add(a.im, im)),
            };
            // The same of conj(P) b + conj(Q) conj(a).
            let re = q_im.neg_mul_add(a.im, q_re.mul(a.re));
            let im = q_re.mul_add(a.im, q_im.mul(a.re));
            let v = Complex {
                re: p_im.mul_add(b.im, p_re.mul_add(b.re, re)),
                im: p_im.mul_add(b.re, p_re.neg_mul_add(b.im, im)),
            };
            v.store(mirror);
            w.store(bin);
        }
    }
}

/// Where the last pass of a convolution finds and leaves its numbers.
#[derive(Debug, Clone, Copy)]
pub struct Scatter<T> {
    pub of: Unordered<T>,
    /// Row 0 of the result, and the distance to the next, in numbers.
    pub to: *mut T,
    pub stride: usize,
    /// For each bin twice its row, and 1 more where it is its conjugate.
    pub rows: *const u32,
    /// Bins from here on are left out.
    pub end: usize,
    /// What is added to all.
    pub constant: *const T,
}

/// Last pass of a convolution: a real constant and each bin, to the row where it belongs.
///
/// # Safety
/// As [`first`](super::first), for the places that [`Scatter`] names; where `STREAM`, rows of the result are aligned
/// to 64 bytes.
#[inline(always)]
pub(in super::super) unsafe fn scatter<L: Lanes, const R: usize, const STREAM: bool>(
    at: &Scatter<L::Scalar>,
) where
    Dft: Butterfly<R>,
{
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        let constant = L::load(at.constant);
        let signs = [L::of(1.0), L::of(-1.0)];
        for group in 0..at.of.groups {
            let (y, low) = at.of.bins::<L, R>(group);
            for (s, y) in y.into_iter().enumerate() {
                let bin = low + s * at.of.groups;
                if bin >= at.end {
                    continue;
                }
                let row = *at.rows.add(bin) as usize;
                let to = at.to.add(row / 2 * at.stride);
                L::store_interleaved::<STREAM>(y.re.add(constant), y.im.mul(signs[row % 2]), to);
            }
        }
    }
}
