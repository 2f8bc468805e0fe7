//! The passes that a transform is made of; see [`super`] for how they fit together.
//!
//! A complex number of all columns takes `2 WIDTH` numbers in a row: real parts, imaginary parts.
//! Twiddle factors are tables of pairs.

// Loops over places in registers are unrolled; iterators over several arrays are not, always.
#![allow(clippy::needless_range_loop)]

mod convolution;

pub(super) use convolution::{Twiddled, Unordered, chirp, collect, order, twiddle};

use super::butterfly::{Butterfly, Complex, Dft};
use super::simd::Lanes;
use crate::columns::LINE;

/// Rows of neighbouring tiles, to be copied.
#[derive(Debug, Clone, Copy)]
pub struct Stage<T> {
    /// Row 0, and the distance to the next, in numbers.
    pub from: *const T,
    pub stride: usize,
    /// A factor for each row, where there is a window.
    pub window: *const T,
    /// `series` series of `length` rows; series j has the rows `j + i series`.
    pub series: usize,
    pub length: usize,
    pub tiles: usize,
    /// Where the first tile goes, and the distance to the next, in numbers.
    pub to: *mut T,
    pub next: usize,
}

/// Copies rows series by series, tile by tile, times the window where `WINDOWED`.
///
/// # Safety
/// The processor has the instructions of L; the places that [`Stage`] names are valid.
#[inline(always)]
pub(super) unsafe fn stage<L: Lanes, const WINDOWED: bool>(at: &Stage<L::Scalar>) {
    // Distance of prefetches in rows, at most a series.
    const AHEAD: usize = 40;
    let further = AHEAD.min(at.length);
    let line = LINE / size_of::<L::Scalar>();
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for j in 0..at.series {
            for i in 0..at.length {
                let n = j + i * at.series;
                let row = at.from.add(n * at.stride);
                // The row that many further on, in this series or in the next.
                let (j_ahead, i_ahead) = match i + further < at.length {
                    true => (j, i + further),
                    false => (j + 1, i + further - at.length),
                };
                let prefetch = (j_ahead + i_ahead * at.series) * at.stride;
                for number in (0..at.tiles * L::WIDTH).step_by(line) {
                    L::prefetch(at.from.wrapping_add(prefetch + number));
                }
                let to = at.to.add((j * at.length + i) * L::WIDTH);
                for t in 0..at.tiles {
                    let mut x = L::load(row.add(t * L::WIDTH));
                    if WINDOWED {
                        x = x.mul(L::splat(at.window.add(n)));
                    }
                    x.store(to.add(t * at.next));
                }
            }
        }
    }
}

/// Prefetches of the rows of the next pair of series, issued while this pair is transformed, a few with each
/// butterfly: a core has a limited number of outstanding cache misses, and a pass that prefetched all
/// rows at once would stall.
#[derive(Debug, Clone, Copy)]
pub struct Prefetch<T> {
    /// The next row of the first series, the distance to the one after it and to the second series' row, in
    /// numbers.
    pub row: *const T,
    pub apart: usize,
    pub second: usize,
    /// Of each series, offset of a second line to prefetch, in bytes; 0 where there is none.
    pub more: [usize; 2],
    /// Rows to prefetch with each butterfly of the current pass.
    pub each: usize,
}

impl<T> Prefetch<T> {
    pub fn nothing() -> Self {
        Prefetch {
            row: std::ptr::null(),
            apart: 0,
            second: 0,
            more: [0; 2],
            each: 0,
        }
    }

    /// Starts a pass that prefetches `each` rows with each butterfly.
    pub fn pass(&mut self, each: usize) {
        if !self.row.is_null() {
            self.each = each;
        }
    }

    #[inline(always)]
    unsafe fn issue<L: Lanes<Scalar = T>>(&mut self) {
        for _ in 0..self.each {
            let second = self.row.wrapping_add(self.second);
            let [more, more_second] = self.more;
            // SAFETY: the processor has the instructions of L, by the caller's word; a prefetch
            // of any address is harmless.
            unsafe {
                L::prefetch(self.row);
                L::prefetch(second);
                L::prefetch(self.row.wrapping_byte_add(more));
                L::prefetch(second.wrapping_byte_add(more_second));
            }
            self.row = self.row.wrapping_add(self.apart);
        }
    }
}

/// Where real rows lie: of point `i` of butterfly `q` it is row `q * next + i * apart`, and that of the
/// second series `second` further.
#[derive(Debug, Clone, Copy)]
pub struct Rows<T> {
    /// Row 0, and the distance to the next, in numbers.
    pub from: *const T,
    pub stride: usize,
    pub next: usize,
    pub apart: usize,
    pub second: usize,
    /// A factor for each row, where there is a window.
    pub window: *const T,
}

/// First pass over real rows, times the window where `WINDOWED`: two series of the same columns
/// become real and imaginary part.
///
/// # Safety
/// The processor has the instructions of L; `rows` of `count * R` rows are valid, `to` holds as
/// many complex numbers, `twiddles` `count * (R - 1)`.
#[inline(always)]
pub(super) unsafe fn first<L: Lanes, const R: usize, const WINDOWED: bool>(
    rows: &Rows<L::Scalar>,
    prefetch: &mut Prefetch<L::Scalar>,
    to: *mut L::Scalar,
    count: usize,
    twiddles: *const L::Scalar,
) where
    Dft: Butterfly<R>,
{
    let [next, apart, second] =
        [rows.next, rows.apart, rows.second].map(|count| count * rows.stride);
    let mut prefetching = *prefetch;
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for q in 0..count {
            prefetching.issue::<L>();
            let mut x = [Complex::<L>::zero(); R];
            for (i, x) in x.iter_mut().enumerate() {
                let row = rows.from.add(q * next + i * apart);
                *x = Complex {
                    re: L::load(row),
                    im: L::load(row.add(second)),
                };
                if WINDOWED {
                    let factor = rows.window.add(q * rows.next + i * rows.apart);
                    x.re = x.re.mul(L::splat(factor));
                    x.im = x.im.mul(L::splat(factor.add(rows.second)));
                }
            }
            twiddled::<L, R>(x, twiddles, q, to.add(q * 2 * L::WIDTH), count);
        }
    }
    *prefetch = prefetching;
}

/// Butterfly `q` of a pass: its results, each times its twiddle factor, `count` complex numbers
/// apart.
#[inline(always)]
unsafe fn twiddled<L: Lanes, const R: usize>(
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
            let product = match q {
                0 => y[i],
                _ => y[i].times(factors.add(2 * (i - 1))),
            };
            product.store(to.add(i * count * 2 * L::WIDTH));
        }
    }
}

/// A pass between the first and the last: `blocks` transforms of `R * count` points each, in
/// place where `from` is `to`; rows of the next pair are prefetched where `PREFETCH`.
///
/// # Safety
/// As [`first`]; both hold `blocks * R * count` complex numbers.
#[inline(always)]
pub(super) unsafe fn middle<L: Lanes, const R: usize, const PREFETCH: bool>(
    from: *const L::Scalar,
    to: *mut L::Scalar,
    blocks: usize,
    count: usize,
    twiddles: *const L::Scalar,
    prefetch: &mut Prefetch<L::Scalar>,
) where
    Dft: Butterfly<R>,
{
    let mut prefetching = *prefetch;
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        for block in 0..blocks {
            let start = block * R * count;
            for q in 0..count {
                if PREFETCH {
                    prefetching.issue::<L>();
                }
                let mut x = [Complex::<L>::zero(); R];
                for (i, x) in x.iter_mut().enumerate() {
                    *x = Complex::load(from.add((start + i * count + q) * 2 * L::WIDTH));
                }
                twiddled::<L, R>(x, twiddles, q, to.add((start + q) * 2 * L::WIDTH), count);
            }
        }
    }
    *prefetch = prefetching;
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
    /// Whether to prefetch the places of the next pair of series: a matrix larger than L2 has left it since the
    /// last tile.
    pub fetch: bool,
    /// Halves of the twiddle factors of both series, bin by bin.
    pub twiddles: *const T,
}

/// Last pass of the first half: the spectra of both real series, each times its twiddle factors.
///
/// # Safety
/// As [`first`], for the places that [`Split`] names.
#[inline(always)]
pub(super) unsafe fn split<L: Lanes, const R: usize>(
    at: &Split<L::Scalar>,
    mut prefetch: Prefetch<L::Scalar>,
) where
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
            prefetch.issue::<L>();
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
        if at.fetch {
            let line = LINE / size_of::<L::Scalar>();
            for number in (0..4 * L::WIDTH).step_by(line) {
                L::prefetch(to.wrapping_add(4 * L::WIDTH + number));
            }
        }
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

/// Last pass of the second half: rows of the spectrum. Where `PREFETCH`, the rows beside them, which come
/// next, are prefetched.
///
/// # Safety
/// As [`first`], for the places that [`Last`] names; where `STREAM`, rows of the result are aligned
/// to 64 bytes.
#[inline(always)]
pub(super) unsafe fn last<L: Lanes, const R: usize, const STREAM: bool, const PREFETCH: bool>(
    at: &Last<L::Scalar>,
) where
    Dft: Butterfly<R>,
{
    // SAFETY: offsets are those of the caller's promise.
    unsafe {
        let zero = L::of(0.0);
        let step = at.groups * at.bins_apart;
        let prefetch = |row: *mut L::Scalar| {
            // Every line of the piece, which may begin and end within one.
            let line = LINE / size_of::<L::Scalar>();
            for number in (0..2 * L::WIDTH).step_by(line) {
                L::prefetch(row.wrapping_add(number));
            }
            L::prefetch(row.wrapping_add(2 * L::WIDTH - 1));
        };
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
                    let row = at.to.add(bin * at.stride);
                    L::store_interleaved::<STREAM>(y.re, y.im, row);
                    if PREFETCH {
                        prefetch(row.wrapping_add(at.stride));
                    }
                } else if at.mirrored {
                    let row = at.to.add((at.length - bin) * at.stride);
                    L::store_interleaved::<STREAM>(y.re, zero.sub(y.im), row);
                    if PREFETCH {
                        prefetch(row.wrapping_sub(at.stride));
                    }
                }
            }
        }
    }
}
