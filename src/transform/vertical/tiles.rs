//! From arrays to tiles: which columns go together, and through which copies.

use ndarray::{ArrayView2, ArrayViewMut2};
use num_complex::Complex;

use super::fast::{Fast, Order, Tile};
use super::kernels::Kernels;
use super::way::Way;
use super::{ColumnScratch, ColumnTransform, Line, lines, simd, widest};
use crate::transform::Real;

/// Rows a multiple of so many bytes apart share a few places in the caches: what is asked for early
/// is gone before its turn. Such rows are copied first, long pieces of them, into the order of use.
const ALIASED: usize = 4096;
/// What such copies take of the third cache, but for 128 bytes a row at the least.
const STAGED_BYTES: usize = 8 << 20;

impl<T: Real> ColumnTransform<T> {
    /// Transforms all columns tile by tile.
    pub(super) fn tiles(
        &self,
        values: ArrayView2<T>,
        weights: &[T],
        spectra: &mut ArrayViewMut2<Complex<T>>,
        stream: bool,
        scratch: &mut ColumnScratch<T>,
    ) {
        let columns = values.ncols();
        let strides = row_stride(values.strides()).zip(row_stride(spectra.strides()));
        let Some((from_stride, to_stride)) = strides else {
            self.gathered(values, weights, spectra, scratch);
            return;
        };
        let widest = widest(&self.kernels, columns.min(scratch.width));
        let bins = spectra.as_mut_ptr();
        // SAFETY: the tiles' columns are within both views, and so are their rows, by the shapes
        // asserted; `Complex` is two numbers.
        let tile = |start: usize| unsafe {
            let to = bins.add(start).cast::<T>();
            let row = 2 * to_stride * size_of::<T>();
            let aligned = to.addr().is_multiple_of(64) && row.is_multiple_of(64);
            Tile {
                from: values.as_ptr().add(start),
                from_stride,
                rows: order(weights),
                to,
                to_stride: 2 * to_stride,
                stream: stream && aligned,
            }
        };
        let aliased = (from_stride * size_of::<T>()).is_multiple_of(ALIASED);
        let mut done = match (&self.way, aliased) {
            (Way::Fast(fast), true) => self.through_stage(fast, columns, &tile, scratch),
            _ => 0,
        };
        let numbers: &mut [T] = bytemuck::cast_slice_mut(&mut scratch.lines);
        while done < columns {
            let left = columns - done;
            let covers = |k: &&&Kernels<T>| k.width >= left && k.width <= widest.width;
            let kernel = *self.kernels.iter().rev().find(covers).unwrap_or(&widest);
            // The last tile overlaps the one before: the same numbers are written again.
            let start = done.min(columns - kernel.width);
            // SAFETY: as before.
            unsafe { self.way.tile(kernel, tile(start), numbers) };
            done = start + kernel.width;
        }
        simd::finish_streams();
    }

    /// Transforms all whole tiles of `columns` columns through copies of their rows; how many columns they
    /// have.
    fn through_stage(
        &self,
        fast: &Fast<T>,
        columns: usize,
        tile: &dyn Fn(usize) -> Tile<T>,
        scratch: &mut ColumnScratch<T>,
    ) -> usize {
        let kernel = widest(&self.kernels, columns.min(scratch.width));
        let together = tiles_staged::<T>(self.length, kernel.width).min(columns / kernel.width);
        let numbers = self.length * kernel.width;
        if size_of_val(&scratch.copies[..]) < together * numbers * size_of::<T>() {
            scratch.copies = lines::<T>(together * numbers);
        }
        let stage: &mut [T] = bytemuck::cast_slice_mut(&mut scratch.copies);
        let work: &mut [T] = bytemuck::cast_slice_mut(&mut scratch.lines);
        let tiles = columns / kernel.width;
        for first in (0..tiles).step_by(together.max(1)) {
            let count = together.min(tiles - first);
            // SAFETY: the tiles' rows are within the arrays, and the stage has room for so many tiles.
            unsafe {
                let to = (stage.as_mut_ptr(), numbers);
                fast.stage(kernel, count, tile(first * kernel.width), to);
                for t in 0..count {
                    let copied = Tile {
                        from: stage.as_ptr().add(t * numbers),
                        from_stride: kernel.width,
                        rows: Order::Staged,
                        ..tile((first + t) * kernel.width)
                    };
                    fast.tile(kernel, copied, work);
                }
            }
        }
        tiles * kernel.width
    }

    /// Columns that are not neighbours: through copies.
    fn gathered(
        &self,
        values: ArrayView2<T>,
        weights: &[T],
        spectra: &mut ArrayViewMut2<Complex<T>>,
        scratch: &mut ColumnScratch<T>,
    ) {
        let columns = values.ncols();
        let kernel = widest(&self.kernels, columns.min(scratch.width));
        let width = kernel.width;
        let samples = (width * self.length).next_multiple_of(64);
        let numbers = samples + 2 * width * self.bins();
        if size_of_val(&scratch.copies[..]) < numbers * size_of::<T>() {
            scratch.copies = lines::<T>(numbers);
        }
        let copies: &mut [T] = bytemuck::cast_slice_mut(&mut scratch.copies);
        let (rows, bins) = copies.split_at_mut(samples);
        let work: &mut [T] = bytemuck::cast_slice_mut(&mut scratch.lines);
        for done in (0..columns).step_by(width) {
            let start = done.min(columns - width);
            for (row, from) in rows.chunks_exact_mut(width).zip(values.outer_iter()) {
                for (c, to) in row.iter_mut().enumerate() {
                    *to = from[start + c];
                }
            }
            // SAFETY: both copies have as many rows of a tile's width as the plan's length asks
            // for.
            unsafe {
                let tile = Tile {
                    from: rows.as_ptr(),
                    from_stride: width,
                    rows: order(weights),
                    to: bins.as_mut_ptr(),
                    to_stride: 2 * width,
                    stream: false,
                };
                self.way.tile(kernel, tile, work);
            }
            for (row, mut to) in bins.chunks_exact(2 * width).zip(spectra.outer_iter_mut()) {
                for (c, pair) in row.chunks_exact(2).enumerate() {
                    to[start + c] = Complex::new(pair[0], pair[1]);
                }
            }
        }
    }
}

/// Tiles whose rows are copied together: the more, the longer the pieces read, up to 8 cache lines a
/// row; at least two lines, else as many as the third cache has room for.
fn tiles_staged<T>(length: usize, width: usize) -> usize {
    let lines_of_rows = STAGED_BYTES / size_of::<Line>() / length;
    let lines = lines_of_rows.clamp(2, 8);
    (lines * size_of::<Line>() / (width * size_of::<T>())).max(1)
}

/// Rows as they are, or times weights if there are any.
fn order<T>(weights: &[T]) -> Order<T> {
    match weights {
        [] => Order::Plain,
        _ => Order::Weighed(weights.as_ptr()),
    }
}

/// From row to row in memory, where columns are neighbours.
fn row_stride(strides: &[isize]) -> Option<usize> {
    match strides {
        &[row, 1] => usize::try_from(row).ok(),
        _ => None,
    }
}
