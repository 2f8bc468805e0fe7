//! The passes that a transform is made of; see [`super`] for how they fit together.
//!
//! A complex number of all columns takes `2 WIDTH` numbers in a row: real parts, imaginary parts.
//! Twiddle factors are tables of pairs.

// Loops over places in registers are unrolled; iterators over several arrays are not, always.
#![allow(clippy::needless_range_loop)]

use super::butterfly::{Butterfly, Complex, Dft};
use super::simd::Lanes;

/// Rows of neighbouring tiles, to be copied.
#[derive(Debug, Clone, Copy)]
pub struct Stage<T> {
    /// Row 0, and how far the next is, in numbers.
    pub from: *const T,
    pub stride: usize,
    /// So many series of so many rows, each row so many rows after that before it as there are series.
    pub series: usize,
    pub length: usize,
    pub tiles: usize,
    pub to: *mut T,
}

/// Copies rows series by series, each tile by itself.
///
/// # Safety
/// The processor has the instructions of L; the places that [`Stage`] names are valid.
#[inline(always)]
pub(super) unsafe fn stage<L: Lanes>(at: &Stage<L::Scalar>) {
    // Rows that are asked for ahead of their use.
    const AHEAD: usize = 12;
    let line = 64 / size_of::<L::Scalar>();
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for j in 0..at.series {
            for i in 0..at.length {
                let row = at.from.add((j + i * at.series) * at.stride);
                let (j_ahead, i_ahead) = match i + AHEAD < at.length {
                    true => (j, i + AHEAD),
                    false => (j + 1, i + AHEAD - at.length),
                };
                let ahead = (j_ahead + i_ahead * at.series) * at.stride;
                for number in (0..at.tiles * L::WIDTH).step_by(line) {
                    L::prefetch(at.from.wrapping_add(ahead + number));
                }
                let to = at.to.add((j * at.length + i) * L::WIDTH);
                for t in 0..at.tiles {
                    let tile = at.series * at.length * L::WIDTH;
                    L::load(row.add(t * L::WIDTH)).store(to.add(t * tile));
                }
            }
        }
    }
}

/// Where real rows lie: of point `i` of butterfly `q` it is row `q * next + i * apart`, and that of the
/// second series `second` further.
#[derive(Debug, Clone, Copy)]
pub struct Rows<T> {
    /// Row 0, and how far the next is, in numbers.
    pub from: *const T,
    pub stride: usize,
    pub next: usize,
    pub apart: usize,
    pub second: usize,
    /// How far ahead to ask for rows, in rows; 0: not at all.
    pub ahead: usize,
    /// Whether to ask for the neighbouring lines too, which the next tile will want: memory gives
    /// two lines for little more than one.
    pub wide: bool,
    /// A factor for each row, where they are weighed.
    pub weights: *const T,
}

/// First pass over real rows, times their weights where `WEIGHED`: two series of the same columns
/// become real and imaginary part.
///
/// # Safety
/// The processor has the instructions of L; `rows` of `count * R` rows are valid, `to` holds as
/// many complex numbers, `twiddles` `count * (R - 1)`.
#[inline(always)]
pub(super) unsafe fn first<L: Lanes, const R: usize, const WEIGHED: bool>(
    rows: &Rows<L::Scalar>,
    to: *mut L::Scalar,
    count: usize,
    twiddles: *const L::Scalar,
) where
    Dft: Butterfly<R>,
{
    let second = rows.second * rows.stride;
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for q in 0..count {
            let mut x = [Complex::<L>::zero(); R];
            for (i, x) in x.iter_mut().enumerate() {
                let n = q * rows.next + i * rows.apart;
                let row = rows.from.add(n * rows.stride);
                *x = Complex {
                    re: L::load(row),
                    im: L::load(row.add(second)),
                };
                if WEIGHED {
                    let weight = rows.weights.add(n);
                    x.re = x.re.mul(L::splat(weight));
                    x.im = x.im.mul(L::splat(weight.add(rows.second)));
                }
                if rows.ahead > 0 {
                    let line = row.wrapping_add(rows.ahead * rows.stride);
                    L::prefetch(line);
                    L::prefetch(line.wrapping_add(second));
                    if rows.wide {
                        L::prefetch(line.wrapping_add(L::WIDTH));
                        L::prefetch(line.wrapping_add(second + L::WIDTH));
                    }
                }
            }
            turned::<L, R>(x, twiddles, q, to.add(q * 2 * L::WIDTH), count);
        }
    }
}

/// Butterfly `q` of a pass: its results, each times its twiddle factor, `count` complex numbers
/// apart.
#[inline(always)]
unsafe fn turned<L: Lanes, const R: usize>(
    x: [Complex<L>; R],
    twiddles: *const L::Scalar,
    q: usize,
    to: *mut L::Scalar,
    count: usize,
) where
    Dft: Butterfly<R>,
{
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        let y = <Dft as Butterfly<R>>::of(x);
        y[0].store(to);
        let factors = twiddles.add(2 * q * (R - 1));
        for i in 1..R {
            let turned = match q {
                0 => y[i],
                _ => y[i].times(factors.add(2 * (i - 1))),
            };
            turned.store(to.add(i * count * 2 * L::WIDTH));
        }
    }
}

/// A pass between the first and the last: `blocks` transforms of `R * count` points each, in
/// place where `from` is `to`.
///
/// # Safety
/// As [`first`]; both hold `blocks * R * count` complex numbers.
#[inline(always)]
pub(super) unsafe fn middle<L: Lanes, const R: usize>(
    from: *const L::Scalar,
    to: *mut L::Scalar,
    blocks: usize,
    count: usize,
    twiddles: *const L::Scalar,
) where
    Dft: Butterfly<R>,
{
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for block in 0..blocks {
            let start = block * R * count;
            for q in 0..count {
                let mut x = [Complex::<L>::zero(); R];
                for (i, x) in x.iter_mut().enumerate() {
                    *x = Complex::load(from.add((start + i * count + q) * 2 * L::WIDTH));
                }
                turned::<L, R>(x, twiddles, q, to.add((start + q) * 2 * L::WIDTH), count);
            }
        }
    }
}

/// Where the split pass finds and leaves its numbers.
#[derive(Debug, Clone, Copy)]
pub struct Split<T> {
    /// `groups * R` complex numbers of the passes before.
    pub from: *const T,
    pub groups: usize,
    /// Where group of low digit `k` starts, in groups.
    pub order: *const u32,
    /// The place of bin 0 of the first series; the second series' is the complex number after it.
    pub to: *mut T,
    /// From bin to bin, in numbers.
    pub next: usize,
    /// Halves of the twiddle factors of both series, bin by bin.
    pub twiddles: *const T,
}

/// Last pass of the first half: the spectra of both real series, each times its twiddle factors.
///
/// # Safety
/// As [`first`], for the places that [`Split`] names.
#[inline(always)]
pub(super) unsafe fn split<L: Lanes, const R: usize>(at: &Split<L::Scalar>)
where
    Dft: Butterfly<R>,
{
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        let m = at.groups;
        let y: [Complex<L>; R] = group(at, 0);
        for s in 0..=R / 2 {
            put(at, m * s, y[s], y[(R - s) % R]);
        }
        for low in 1..m.div_ceil(2) {
            let y: [Complex<L>; R] = group(at, low);
            let z: [Complex<L>; R] = group(at, m - low);
            for s in 0..R {
                let mirror = R - 1 - s;
                if s <= (R - 1) / 2 {
                    put(at, low + m * s, y[s], z[mirror]);
                } else {
                    put(at, m - low + m * mirror, z[mirror], y[s]);
                }
            }
        }
        if m % 2 == 0 {
            let y: [Complex<L>; R] = group(at, m / 2);
            for s in 0..R.div_ceil(2) {
                put(at, m / 2 + m * s, y[s], y[R - 1 - s]);
            }
        }
    }
}

/// The transform of the group of low digit `low`: bins `low + s groups`.
#[inline(always)]
unsafe fn group<L: Lanes, const R: usize>(at: &Split<L::Scalar>, low: usize) -> [Complex<L>; R]
where
    Dft: Butterfly<R>,
{
    // SAFETY: low is a group of the caller's.
    unsafe {
        let start = *at.order.add(low) as usize * R;
        let mut x = [Complex::<L>::zero(); R];
        for (i, x) in x.iter_mut().enumerate() {
            *x = Complex::load(at.from.add((start + i) * 2 * L::WIDTH));
        }
        <Dft as Butterfly<R>>::of(x)
    }
}

/// Bin `k` of both series, from bins k and -k of their complex sum.
#[inline(always)]
unsafe fn put<L: Lanes>(at: &Split<L::Scalar>, k: usize, z: Complex<L>, mirror: Complex<L>) {
    // SAFETY: k is a bin of the caller's.
    unsafe {
        let a = Complex {
            re: z.re.add(mirror.re),
            im: z.im.sub(mirror.im),
        };
        let b = Complex {
            re: z.im.add(mirror.im),
            im: mirror.re.sub(z.re),
        };
        let to = at.to.add(k * at.next);
        let factors = at.twiddles.add(4 * k);
        a.times(factors).store(to);
        b.times(factors.add(2)).store(to.add(2 * L::WIDTH));
    }
}

/// Where the last pass finds and leaves its numbers.
#[derive(Debug, Clone, Copy)]
pub struct Last<T> {
    /// `groups * R` complex numbers of the passes before.
    pub from: *const T,
    pub groups: usize,
    /// The low digit of each group.
    pub digits: *const u32,
    /// Row 0 of the result.
    pub to: *mut T,
    /// From row to row, in numbers.
    pub stride: usize,
    /// Length n of the whole transform.
    pub length: usize,
    /// The result's first bin, and the distance of its bins.
    pub bin: usize,
    pub bins_apart: usize,
    /// Whether bins above n / 2 stand for their mirrors; else they are left out.
    pub mirrored: bool,
}

/// Last pass of the second half: rows of the spectrum.
///
/// # Safety
/// As [`first`], for the places that [`Last`] names; where `STREAM`, rows of the result are aligned
/// to 64 bytes.
#[inline(always)]
pub(super) unsafe fn last<L: Lanes, const R: usize, const STREAM: bool>(at: &Last<L::Scalar>)
where
    Dft: Butterfly<R>,
{
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        let zero = L::of(0.0);
        let step = at.groups * at.bins_apart;
        for group in 0..at.groups {
            let mut x = [Complex::<L>::zero(); R];
            for (i, x) in x.iter_mut().enumerate() {
                *x = Complex::load(at.from.add((group * R + i) * 2 * L::WIDTH));
            }
            let y = <Dft as Butterfly<R>>::of(x);
            let low = at.bin + *at.digits.add(group) as usize * at.bins_apart;
            for (s, y) in y.into_iter().enumerate() {
                let bin = low + s * step;
                if 2 * bin <= at.length {
                    L::store_pairs::<STREAM>(y.re, y.im, at.to.add(bin * at.stride));
                } else if at.mirrored {
                    let row = at.to.add((at.length - bin) * at.stride);
                    L::store_pairs::<STREAM>(y.re, zero.sub(y.im), row);
                }
            }
        }
    }
}

/// Rows of real columns, each times a complex factor, as complex numbers.
///
/// # Safety
/// As [`first`]; of `count` rows, `next` numbers apart, those below `valid` exist, the others count
/// as 0. `factors` has one each of the first, `factors_apart` factors apart.
#[inline(always)]
pub(super) unsafe fn chirp<L: Lanes>(
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
/// As [`first`].
#[inline(always)]
pub(super) unsafe fn collect<L: Lanes>(
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
pub struct Turn<T> {
    pub of: Unordered<T>,
    /// The place of bin 0, and how far the next is, in numbers.
    pub to: *mut T,
    pub next: usize,
    /// A factor for each bin, and how far the next is, in factors.
    pub factors: *const T,
    pub factors_apart: usize,
    /// Bins from here on are left out.
    pub end: usize,
}

/// Last pass of a complex transform: its bins in order, each times its factor; where `MIRROR`, the
/// conjugates of these; where `PAIRS`, as rows of a spectrum.
///
/// # Safety
/// As [`first`], for the places that [`Turn`] names.
#[inline(always)]
pub(super) unsafe fn turn<L: Lanes, const R: usize, const MIRROR: bool, const PAIRS: bool>(
    at: &Turn<L::Scalar>,
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
                if MIRROR {
                    z.im = zero.sub(z.im);
                }
                let to = at.to.add(bin * at.next);
                if PAIRS {
                    L::store_pairs::<false>(z.re, z.im, to);
                } else {
                    z.store(to);
                }
            }
        }
    }
}

/// Last pass of a complex transform: its bins in order. Without factors; see [`turn`] for the rest.
///
/// # Safety
/// As [`first`], for the places that [`Turn`] names.
#[inline(always)]
pub(super) unsafe fn order<L: Lanes, const R: usize>(at: &Turn<L::Scalar>)
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
    /// Row 0, and how far the next is, in numbers.
    pub from: *const T,
    pub stride: usize,
    /// Of row n the partner is row `length - n`.
    pub length: usize,
    /// The rows n wanted.
    pub rows: *const u32,
    pub wanted: usize,
    /// Complex numbers in all; those beyond `wanted` are 0.
    pub count: usize,
    pub to: *mut T,
}

/// Sums and differences of rows n and `length - n`, as real and imaginary part.
///
/// # Safety
/// As [`first`], for the places that [`Fold`] names.
#[inline(always)]
pub(super) unsafe fn fold<L: Lanes>(at: &Fold<L::Scalar>) {
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
/// As [`first`], for the places that [`Blend`] names.
#[inline(always)]
pub(super) unsafe fn blend<L: Lanes>(at: &Blend<L::Scalar>) {
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
    /// Row 0 of the result, and how far the next is, in numbers.
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
/// As [`first`], for the places that [`Scatter`] names; where `STREAM`, rows of the result are aligned
/// to 64 bytes.
#[inline(always)]
pub(super) unsafe fn scatter<L: Lanes, const R: usize, const STREAM: bool>(at: &Scatter<L::Scalar>)
where
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
                L::store_pairs::<STREAM>(y.re.add(constant), y.im.mul(signs[row % 2]), to);
            }
        }
    }
}
