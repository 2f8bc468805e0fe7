//! Lengths 2^a 3^b 5^c 7^d: the steps of [`super`] on tiles of columns.

use super::PREFETCH_BYTES;
use super::kernels::{Kernels, RADICES};
use super::passes::{Last, Prefetch, Rows, Split, Stage};
use crate::Real;
use crate::twiddle::cos_sin_exact;

/// Complex numbers of padding between rows of the intermediate matrix, against cache-set conflicts.
const PADDING: usize = 2;

/// From row to row of the intermediate matrix, in complex numbers.
#[inline]
fn row(second: usize) -> usize {
    second.next_multiple_of(2) + PADDING
}

/// Numbers of scratch for a tile of `width` columns by halves of these lengths: of one series,
/// and of the intermediate matrix.
#[inline]
pub fn scratch_len([first, second]: [usize; 2], width: usize) -> usize {
    2 * width * (first.max(second) + (first / 2 + 1) * row(second))
}

/// A planned transform of one length.
pub struct MixedRadix<T: 'static> {
    length: usize,
    first: Half<T>,
    second: Half<T>,
    /// Halves of `exp(-2 pi i k1 j2 / n)`: by pairs of j2, then k1, then the two of the pair.
    split_twiddles: Vec<T>,
    /// Group of the last pass of the first half by its low digit.
    order: Vec<u32>,
    /// Low digit by group, of the second half.
    digits: Vec<u32>,
}

/// Where a tile's columns are and where their bins go.
#[derive(Debug, Clone, Copy)]
pub struct Tile<T> {
    /// Row 0 of the columns, and the distance to the next, in numbers.
    pub from: *const T,
    pub from_stride: usize,
    pub rows: RowOrder<T>,
    /// Row 0 of the spectra, and the distance to the next, in numbers.
    pub to: *mut T,
    pub to_stride: usize,
    pub store: Store,
}

/// How bins are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Store {
    /// To rows that the caches hold after the first tiles.
    Plain,
    /// To rows that may be in no cache, and are prefetched.
    Prefetched,
    /// By streaming stores, to rows aligned to cache lines.
    Streaming,
}

/// What rows of a tile are, and in which order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RowOrder<T> {
    /// Samples, time by time.
    Plain,
    /// The same, each row to be multiplied by its factor of a window.
    Windowed(*const T),
    /// What [`MixedRadix::stage`] made of them.
    Staged,
}

/// Passes of a transform of `length` points.
pub struct Half<T> {
    pub length: usize,
    radices: Vec<usize>,
    /// Of all passes but the last.
    twiddles: Vec<Vec<T>>,
    /// As [`prefetch_counts`] gives them.
    prefetch_counts: Vec<usize>,
}

impl<T: Real> Half<T> {
    pub fn new(radices: Vec<usize>) -> Self {
        let length = radices.iter().product();
        let mut remaining = length;
        let mut twiddles = Vec::new();
        for &radix in &radices[..radices.len() - 1] {
            let count = remaining / radix;
            let mut table = Vec::with_capacity(2 * count * (radix - 1));
            for q in 0..count {
                for i in 1..radix {
                    let (cos, sin) = cos_sin_exact((q * i) as u64, remaining as u64);
                    table.extend([T::rounded(cos), T::rounded(-sin)]);
                }
            }
            twiddles.push(table);
            remaining = count;
        }
        Half {
            length,
            prefetch_counts: prefetch_counts(&radices),
            radices,
            twiddles,
        }
    }

    /// Radix of the last pass.
    pub fn last(&self) -> usize {
        self.radices[self.radices.len() - 1]
    }

    /// The low digit of each group of the last pass.
    pub fn digits(&self) -> Vec<u32> {
        let mut digits = vec![0];
        let mut factor = 1;
        for &radix in &self.radices[..self.radices.len() - 1] {
            digits = digits
                .iter()
                .flat_map(|d| (0..radix).map(move |i| d + (i * factor) as u32))
                .collect();
            factor *= radix;
        }
        digits
    }
}

/// Rows to prefetch with each butterfly, pass by pass, where a first half has as many rows as points: spread
/// evenly over the passes, together at least all.
fn prefetch_counts(radices: &[usize]) -> Vec<usize> {
    let length: usize = radices.iter().product();
    let last = radices.len() - 1;
    let mut counts: Vec<usize> = radices.iter().map(|radix| length / radix).collect();
    // The last pass does its butterflies in pairs, but for one or two.
    counts[last] = counts[last].div_ceil(2) - 1;
    if last == 0 {
        // The only pass follows a copy of the rows, one by one.
        counts = vec![length];
    }
    let mut passes = counts.iter().filter(|&&count| count > 0).count();
    let mut left = length;
    let each = counts.into_iter().map(|count| {
        if count == 0 {
            return 0;
        }
        let each = match passes {
            1 => left.div_ceil(count),
            _ => (left as f64 / (passes * count) as f64).round() as usize,
        };
        passes -= 1;
        left = left.saturating_sub(each * count);
        each
    });
    each.collect()
}

/// Offset in bytes of a second place to prefetch beside the start of a tile's piece of a row, for rows `apart`
/// bytes apart: the piece's end where pieces may straddle two cache lines; else the other line of the same
/// 128 bytes, which costs little more than one line and which the next tile needs.
fn beside<T>(row: *const T, bytes: usize, apart: usize) -> usize {
    let straddle = !row.addr().is_multiple_of(bytes) || !apart.is_multiple_of(bytes);
    match straddle || row.addr() % 128 < 64 {
        true => bytes,
        false => 0,
    }
}

impl<T: Real> MixedRadix<T> {
    pub fn new(first: Vec<usize>, second: Vec<usize>) -> Self {
        let (first, second) = (Half::<T>::new(first), Half::<T>::new(second));
        let length = first.length * second.length;
        let mut split_twiddles = Vec::new();
        for pair in 0..second.length.div_ceil(2) {
            for k in 0..=first.length / 2 {
                for j in [2 * pair, 2 * pair + 1] {
                    let (cos, sin) = cos_sin_exact((k * j) as u64, length as u64);
                    split_twiddles.extend([T::rounded(0.5 * cos), T::rounded(-0.5 * sin)]);
                }
            }
        }
        let mut order = vec![0; first.length / first.last()];
        for (group, digit) in first.digits().into_iter().enumerate() {
            order[digit as usize] = group as u32;
        }
        MixedRadix {
            length,
            split_twiddles,
            order,
            digits: second.digits(),
            first,
            second,
        }
    }

    fn lengths(&self) -> [usize; 2] {
        [self.first.length, self.second.length]
    }

    /// Copies rows of `tiles` neighbouring tiles from the first one's place on, `next` numbers from tile
    /// to tile, in the order in which [`MixedRadix::tile`] reads them, times the window if there is one.
    ///
    /// # Safety
    /// The kernels are those of this processor; `first` is valid as in [`MixedRadix::tile`] for rows of all
    /// the tiles' width, and not itself a copy; `to` holds all.
    pub unsafe fn stage(
        &self,
        kernels: &Kernels<T>,
        tiles: usize,
        first: Tile<T>,
        (to, next): (*mut T, usize),
    ) {
        let (copy, window) = match first.rows {
            RowOrder::Windowed(window) => (kernels.stage_windowed, window),
            RowOrder::Plain | RowOrder::Staged => (kernels.stage, std::ptr::null()),
        };
        let stage = Stage {
            from: first.from,
            stride: first.from_stride,
            window,
            series: self.second.length,
            length: self.first.length,
            tiles,
            to,
            next,
        };
        // SAFETY: as promised.
        unsafe { copy(&stage) }
    }

    /// Transforms a tile of `kernels.width` columns.
    ///
    /// # Safety
    /// The kernels are those of this processor. `tile.from` is valid for `length` rows of the tile's
    /// width, and the window for as many numbers; `tile.to` for `length / 2 + 1` rows of twice the width,
    /// aligned to 64 bytes where they are [`Store::Streaming`]; `scratch` holds [`scratch_len`] numbers.
    pub unsafe fn tile(&self, kernels: &Kernels<T>, tile: Tile<T>, scratch: &mut [T]) {
        assert!(scratch.len() >= scratch_len(self.lengths(), kernels.width));
        let [n1, n2] = self.lengths();
        let work = scratch.as_mut_ptr();
        // SAFETY: all places are within what the caller promises and `scratch_len` counts; the
        // kernels are those of this processor.
        unsafe {
            let intermediate = work.add(2 * kernels.width * n1.max(n2));
            for j in (0..n2).step_by(2) {
                // Of the series j, where it starts and how far its rows and the next series are.
                let staged = matches!(tile.rows, RowOrder::Staged);
                let (start, next, second) = if staged { (j * n1, 1, n1) } else { (j, n2, 1) };
                let from = tile.from.add(start * tile.from_stride);
                let (window, windowed) = match tile.rows {
                    RowOrder::Windowed(window) => (window.add(j), true),
                    RowOrder::Plain | RowOrder::Staged => (std::ptr::null(), false),
                };
                let rows = Rows {
                    from,
                    stride: tile.from_stride,
                    next,
                    apart: 0,
                    second: if j + 1 < n2 { second } else { 0 },
                    window,
                };
                let prefetch = match staged || j + 2 >= n2 {
                    true => Prefetch::nothing(),
                    false => {
                        self.prefetch(kernels, from.add(2 * tile.from_stride), tile.from_stride)
                    }
                };
                self.first_half(kernels, j, (rows, prefetch), windowed, work, intermediate);
            }
            self.second_half(kernels, intermediate, tile, work);
        }
    }

    /// The rows of two series, from the first one's first row on.
    fn prefetch(&self, kernels: &Kernels<T>, row: *const T, stride: usize) -> Prefetch<T> {
        let apart = self.second.length * stride;
        let bytes = |numbers: usize| numbers * size_of::<T>();
        let beside = |row| beside(row, bytes(kernels.width), bytes(apart));
        Prefetch {
            row,
            apart,
            second: stride,
            more: [row, row.wrapping_add(stride)].map(beside),
            each: 0,
        }
    }

    /// The transforms of series j and j + 1 over the first half, to the intermediate matrix.
    unsafe fn first_half(
        &self,
        kernels: &Kernels<T>,
        j: usize,
        (rows, mut prefetch): (Rows<T>, Prefetch<T>),
        windowed: bool,
        work: *mut T,
        intermediate: *mut T,
    ) {
        let n1 = self.first.length;
        let complex = 2 * kernels.width;
        let radix = self.first.last();
        // SAFETY: as in `tile`.
        unsafe {
            self.first_rows(kernels, (rows, &mut prefetch), windowed, work);
            prefetch.pass(self.first.prefetch_counts[self.first.prefetch_counts.len() - 1]);
            let twiddles = self.split_twiddles.as_ptr();
            let split = Split {
                from: work,
                groups: n1 / radix,
                order: self.order.as_ptr(),
                to: intermediate.add(complex * j),
                next: complex * row(self.second.length),
                fetch: (n1 / 2 + 1) * complex * row(self.second.length)
                    >= PREFETCH_BYTES / size_of::<T>(),
                twiddles: twiddles.add(j / 2 * 4 * (n1 / 2 + 1)),
            };
            kernels.split[index(radix)](&split, prefetch);
        }
    }

    /// The transforms over the second half: rows of the spectrum.
    unsafe fn second_half(
        &self,
        kernels: &Kernels<T>,
        intermediate: *const T,
        tile: Tile<T>,
        work: *mut T,
    ) {
        let (n1, n2) = (self.first.length, self.second.length);
        let row = 2 * kernels.width * row(self.second.length);
        let radix = self.second.last();
        let last = match tile.store {
            Store::Plain => kernels.last,
            Store::Prefetched => kernels.last_prefetching,
            Store::Streaming => kernels.last_streaming,
        }[index(radix)];
        // SAFETY: as in `tile`.
        unsafe {
            for k in 0..=n1 / 2 {
                let source = intermediate.add(row * k);
                last(&Last {
                    from: self.second.all_but_last(kernels, source, work),
                    groups: n2 / radix,
                    digits: self.digits.as_ptr(),
                    to: tile.to,
                    stride: tile.to_stride,
                    length: self.length,
                    bin: k,
                    bins_apart: n1,
                    mirrored: k != 0 && 2 * k != n1,
                });
            }
            if self.length.is_multiple_of(2) {
                let top = tile.to.add(self.length / 2 * tile.to_stride);
                for column in 0..kernels.width {
                    *top.add(2 * column + 1) = T::zero();
                }
            }
        }
    }

    /// All passes of the first half but the last, of one pair of series.
    unsafe fn first_rows(
        &self,
        kernels: &Kernels<T>,
        (mut rows, prefetch): (Rows<T>, &mut Prefetch<T>),
        windowed: bool,
        work: *mut T,
    ) {
        let n1 = self.first.length;
        let radix = self.first.radices[0];
        let (gather, first) = match windowed {
            true => (kernels.gather_windowed, &kernels.first_windowed),
            false => (kernels.gather, &kernels.first),
        };
        prefetch.pass(self.first.prefetch_counts[0]);
        // SAFETY: as in `tile`.
        unsafe {
            if self.first.radices.len() == 1 {
                gather(&rows, prefetch, work, n1, work);
                return;
            }
            rows.apart = n1 / radix * rows.next;
            let twiddles = self.first.twiddles[0].as_ptr();
            first[index(radix)](&rows, prefetch, work, n1 / radix, twiddles);
            self.first.middle(kernels, work, 1, prefetch);
        }
    }
}

impl<T> Half<T> {
    /// All passes but the last; where they left their numbers.
    ///
    /// # Safety
    /// As [`MixedRadix::tile`]; `source` and `work` hold `length` complex numbers, and are the same or
    /// apart.
    pub unsafe fn all_but_last(
        &self,
        kernels: &Kernels<T>,
        source: *const T,
        work: *mut T,
    ) -> *const T {
        if self.radices.len() == 1 {
            return source;
        }
        let radix = self.radices[0];
        let twiddles = self.twiddles[0].as_ptr();
        // SAFETY: as promised.
        unsafe {
            let (count, nothing) = (self.length / radix, &mut Prefetch::nothing());
            kernels.middle[index(radix)](source, work, 1, count, twiddles, nothing);
            self.middle(kernels, work, 1, nothing);
        }
        work
    }

    /// Passes from number `pass` to the last but one, in place.
    unsafe fn middle(
        &self,
        kernels: &Kernels<T>,
        work: *mut T,
        pass: usize,
        prefetch: &mut Prefetch<T>,
    ) {
        let mut blocks: usize = self.radices[..pass].iter().product();
        for (pass, &radix) in self.radices.iter().enumerate().skip(pass) {
            let Some(twiddles) = self.twiddles.get(pass) else {
                return;
            };
            let count = self.length / blocks / radix;
            let twiddles = twiddles.as_ptr();
            prefetch.pass(self.prefetch_counts[pass]);
            let kernel = match prefetch.each {
                0 => kernels.middle[index(radix)],
                _ => kernels.middle_prefetching[index(radix)],
            };
            // SAFETY: as in `MixedRadix::tile`.
            unsafe { kernel(work, work, blocks, count, twiddles, prefetch) };
            blocks *= radix;
        }
    }
}

/// Place of a radix in the tables of kernels.
#[inline]
pub fn index(radix: usize) -> usize {
    RADICES.iter().position(|&r| r == radix).unwrap_or(0)
}
