//! Lengths 2^a 3^b 5^c 7^d: the steps of [`super`] on tiles of columns.

use super::ASKED_BYTES;
use super::kernels::{Kernels, RADICES};
use super::passes::{Ahead, Last, Rows, Split, Stage};
use crate::Real;
use crate::twiddle::cos_sin_exact;

/// Complex numbers between rows of the matrix between the halves, so that no two rows share all
/// their places in the caches.
const PADDING: usize = 2;

/// From row to row of the matrix between the halves, in complex numbers.
fn row(second: usize) -> usize {
    second.next_multiple_of(2) + PADDING
}

/// Numbers of scratch for a tile of `width` columns by halves of these lengths: those of the series
/// in hand, and the matrix.
pub fn scratch_len([first, second]: [usize; 2], width: usize) -> usize {
    2 * width * (first.max(second) + (first / 2 + 1) * row(second))
}

/// A planned transform of one length.
pub struct Fast<T: 'static> {
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
    /// Row 0 of the columns, and how far the next is, in numbers.
    pub from: *const T,
    pub from_stride: usize,
    pub rows: Order<T>,
    /// Row 0 of the spectra, and how far the next is, in numbers.
    pub to: *mut T,
    pub to_stride: usize,
    pub writing: Writing,
}

/// How bins are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Writing {
    /// To rows that are soon in the caches, if they are not yet.
    Plain,
    /// To rows that may be in no cache, and are asked for before their turn.
    Asking,
    /// Past the caches, to rows aligned to cache lines.
    Streamed,
}

/// What rows of a tile are, and in which order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order<T> {
    /// Samples, time by time.
    Plain,
    /// The same, each row to be multiplied by a factor.
    Weighed(*const T),
    /// What [`Fast::stage`] made of them.
    Staged,
}

/// Passes of a transform of `length` points.
pub struct Half<T> {
    pub length: usize,
    radices: Vec<usize>,
    /// Of all passes but the last.
    twiddles: Vec<Vec<T>>,
    /// As [`asked`] gives them.
    asked: Vec<usize>,
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
            asked: asked(&radices),
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
        let mut weight = 1;
        for &radix in &self.radices[..self.radices.len() - 1] {
            digits = digits
                .iter()
                .flat_map(|d| (0..radix).map(move |i| d + (i * weight) as u32))
                .collect();
            weight *= radix;
        }
        digits
    }
}

/// Of as many rows as a first half has points, how many to ask for with each butterfly, pass by pass: about
/// as many in one pass as in another, together no fewer than all.
fn asked(radices: &[usize]) -> Vec<usize> {
    let length: usize = radices.iter().product();
    let last = radices.len() - 1;
    let mut counts: Vec<usize> = radices.iter().map(|radix| length / radix).collect();
    // It takes its butterflies two by two, but for one or two.
    counts[last] = counts[last].div_ceil(2) - 1;
    if last == 0 {
        // Rows are gathered before it, one by one.
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

/// From a piece of a row, and from those `apart` bytes further on, to another place to ask for, in bytes: its
/// end, where they may straddle two lines; else what follows in the same 128 bytes, which memory gives
/// for little more than one line, and which the next tile will want.
fn beside<T>(row: *const T, bytes: usize, apart: usize) -> usize {
    let straddle = !row.addr().is_multiple_of(bytes) || !apart.is_multiple_of(bytes);
    match straddle || row.addr() % 128 < 64 {
        true => bytes,
        false => 0,
    }
}

impl<T: Real> Fast<T> {
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
        Fast {
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
    /// to tile, in the order in which [`Fast::tile`] reads them, times their factors if they have any.
    ///
    /// # Safety
    /// The kernels are those of this processor; `first` is valid as in [`Fast::tile`] for rows of all
    /// the tiles' width, and not itself a copy; `to` has room for all.
    pub unsafe fn stage(
        &self,
        kernels: &Kernels<T>,
        tiles: usize,
        first: Tile<T>,
        (to, next): (*mut T, usize),
    ) {
        let (copy, weights) = match first.rows {
            Order::Weighed(weights) => (kernels.stage_weighed, weights),
            Order::Plain | Order::Staged => (kernels.stage, std::ptr::null()),
        };
        let stage = Stage {
            from: first.from,
            stride: first.from_stride,
            weights,
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
    /// width, and weights for as many numbers; `tile.to` for `length / 2 + 1` rows of twice the width,
    /// aligned to 64 bytes where they are [`Writing::Streamed`]; `scratch` holds [`scratch_len`] numbers.
    pub unsafe fn tile(&self, kernels: &Kernels<T>, tile: Tile<T>, scratch: &mut [T]) {
        assert!(scratch.len() >= scratch_len(self.lengths(), kernels.width));
        let [n1, n2] = self.lengths();
        let work = scratch.as_mut_ptr();
        // SAFETY: all places are within what the caller promises and `scratch_len` counts; the
        // kernels are those of this processor.
        unsafe {
            let between = work.add(2 * kernels.width * n1.max(n2));
            for j in (0..n2).step_by(2) {
                // Of the series j, where it starts and how far its rows and the next series are.
                let staged = matches!(tile.rows, Order::Staged);
                let (start, next, second) = if staged { (j * n1, 1, n1) } else { (j, n2, 1) };
                let from = tile.from.add(start * tile.from_stride);
                let (weights, weighed) = match tile.rows {
                    Order::Weighed(weights) => (weights.add(j), true),
                    Order::Plain | Order::Staged => (std::ptr::null(), false),
                };
                let rows = Rows {
                    from,
                    stride: tile.from_stride,
                    next,
                    apart: 0,
                    second: if j + 1 < n2 { second } else { 0 },
                    weights,
                };
                let ahead = match staged || j + 2 >= n2 {
                    true => Ahead::nothing(),
                    false => self.ahead(kernels, from.add(2 * tile.from_stride), tile.from_stride),
                };
                self.first_half(kernels, j, (rows, ahead), weighed, work, between);
            }
            self.second_half(kernels, between, tile, work);
        }
    }

    /// The rows of two series, from the first one's first row on.
    fn ahead(&self, kernels: &Kernels<T>, row: *const T, stride: usize) -> Ahead<T> {
        let apart = self.second.length * stride;
        let bytes = |numbers: usize| numbers * size_of::<T>();
        let beside = |row| beside(row, bytes(kernels.width), bytes(apart));
        Ahead {
            row,
            apart,
            second: stride,
            more: [row, row.wrapping_add(stride)].map(beside),
            each: 0,
        }
    }

    /// The transforms of series j and j + 1 over the first half, to the matrix between.
    unsafe fn first_half(
        &self,
        kernels: &Kernels<T>,
        j: usize,
        (rows, mut ahead): (Rows<T>, Ahead<T>),
        weighed: bool,
        work: *mut T,
        between: *mut T,
    ) {
        let n1 = self.first.length;
        let complex = 2 * kernels.width;
        let radix = self.first.last();
        // SAFETY: as in `tile`.
        unsafe {
            self.first_rows(kernels, (rows, &mut ahead), weighed, work);
            ahead.pass(self.first.asked[self.first.asked.len() - 1]);
            let twiddles = self.split_twiddles.as_ptr();
            let split = Split {
                from: work,
                groups: n1 / radix,
                order: self.order.as_ptr(),
                to: between.add(complex * j),
                next: complex * row(self.second.length),
                fetch: (n1 / 2 + 1) * complex * row(self.second.length)
                    >= ASKED_BYTES / size_of::<T>(),
                twiddles: twiddles.add(j / 2 * 4 * (n1 / 2 + 1)),
            };
            kernels.split[index(radix)](&split, ahead);
        }
    }

    /// The transforms over the second half: rows of the spectrum.
    unsafe fn second_half(
        &self,
        kernels: &Kernels<T>,
        between: *const T,
        tile: Tile<T>,
        work: *mut T,
    ) {
        let (n1, n2) = (self.first.length, self.second.length);
        let row = 2 * kernels.width * row(self.second.length);
        let radix = self.second.last();
        let last = match tile.writing {
            Writing::Plain => kernels.last,
            Writing::Asking => kernels.last_asking,
            Writing::Streamed => kernels.last_streamed,
        }[index(radix)];
        // SAFETY: as in `tile`.
        unsafe {
            for k in 0..=n1 / 2 {
                let source = between.add(row * k);
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
        (mut rows, ahead): (Rows<T>, &mut Ahead<T>),
        weighed: bool,
        work: *mut T,
    ) {
        let n1 = self.first.length;
        let radix = self.first.radices[0];
        let (gather, first) = match weighed {
            true => (kernels.gather_weighed, &kernels.first_weighed),
            false => (kernels.gather, &kernels.first),
        };
        ahead.pass(self.first.asked[0]);
        // SAFETY: as in `tile`.
        unsafe {
            if self.first.radices.len() == 1 {
                gather(&rows, ahead, work, n1, work);
                return;
            }
            rows.apart = n1 / radix * rows.next;
            let twiddles = self.first.twiddles[0].as_ptr();
            first[index(radix)](&rows, ahead, work, n1 / radix, twiddles);
            self.first.middle(kernels, work, 1, ahead);
        }
    }
}

impl<T> Half<T> {
    /// All passes but the last; where they left their numbers.
    ///
    /// # Safety
    /// As [`Fast::tile`]; `source` and `work` hold `length` complex numbers, and are the same or
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
            let (count, nothing) = (self.length / radix, &mut Ahead::nothing());
            kernels.middle[index(radix)](source, work, 1, count, twiddles, nothing);
            self.middle(kernels, work, 1, nothing);
        }
        work
    }

    /// Passes from number `pass` to the last but one, in place.
    unsafe fn middle(&self, kernels: &Kernels<T>, work: *mut T, pass: usize, ahead: &mut Ahead<T>) {
        let mut blocks: usize = self.radices[..pass].iter().product();
        for (pass, &radix) in self.radices.iter().enumerate().skip(pass) {
            let Some(twiddles) = self.twiddles.get(pass) else {
                return;
            };
            let count = self.length / blocks / radix;
            let twiddles = twiddles.as_ptr();
            ahead.pass(self.asked[pass]);
            let kernel = match ahead.each {
                0 => kernels.middle[index(radix)],
                _ => kernels.middle_asking[index(radix)],
            };
            // SAFETY: as in `Fast::tile`.
            unsafe { kernel(work, work, blocks, count, twiddles, ahead) };
            blocks *= radix;
        }
    }
}

/// Place of a radix in the tables; radices come from `choice`.
pub fn index(radix: usize) -> usize {
    RADICES.iter().position(|&r| r == radix).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::asked;

    /// By hand: 256 rows with 32, 32 and 31 butterflies, 64 with 8 and 3; too short for two by two; alone.
    #[test]
    fn all_rows_are_asked_for_evenly() {
        assert_eq!(asked(&[8, 8, 4]), [3, 3, 3]);
        assert_eq!(asked(&[8, 8]), [4, 11]);
        assert_eq!(asked(&[2, 2]), [2, 0]);
        assert_eq!(asked(&[7]), [1]);
    }
}
