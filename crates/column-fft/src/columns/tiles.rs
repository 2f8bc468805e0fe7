//! From arrays to tiles: which columns go together, and through which copies.

use ndarray::{ArrayView2, ArrayViewMut2};
use num_complex::Complex;

use super::algorithm::Decomposition;
use super::fallback::Fallback;
use super::kernels::Kernels;
use super::mixed_radix::{MixedRadix, RowOrder, Store, Tile};
use super::plan::TilePlan;
use super::{
    ColumnScratch, ColumnTransform, InstructionSet, Line, PREFETCH_BYTES, kernels_for, lines,
    lines_of, simd, widest, width_for,
};
use crate::Real;
use crate::columns::LINE;

/// A critical stride in bytes: rows a multiple of it apart share a few cache sets, so that prefetched lines are
/// evicted before their use. Such rows are copied first, in long pieces, into the order of use.
const CRITICAL_STRIDE: usize = 4096;
/// Bytes of such copies, which L3 holds; but at least 128 bytes a row.
const STAGED_BYTES: usize = 8 << 20;

impl<T: Real> ColumnTransform<T> {
    /// Bytes of working space that a thread needs at most to transform columns of `length` samples, in
    /// an array of `columns` neighbouring ones whose rows are `row_bytes` apart: what a plan for this
    /// processor takes, known before there is one.
    pub fn working_bytes(length: usize, columns: usize, row_bytes: usize) -> u64 {
        let decomposition = Decomposition::of(length);
        let kernels = kernels_for::<T>(InstructionSet::best(), &decomposition);
        let width = width_for(&kernels, columns);
        let copied = match decomposition {
            Decomposition::Fallback => return Fallback::<T>::new(length).room().bytes(),
            Decomposition::MixedRadix(_) if row_bytes.is_multiple_of(CRITICAL_STRIDE) => {
                tiles_together::<T>(length, columns, width) * length * width
            }
            _ => 0,
        };
        let lines = [decomposition.scratch_len(width), copied].map(lines_of::<T>);
        (lines.iter().sum::<usize>() * size_of::<Line>()) as u64
    }

    /// Transforms all columns tile by tile.
    pub(super) fn tiles(
        &self,
        values: ArrayView2<T>,
        window: &[T],
        spectra: &mut ArrayViewMut2<Complex<T>>,
        stream: bool,
        scratch: &mut ColumnScratch<T>,
    ) {
        let columns = values.ncols();
        let strides = row_stride(values.strides()).zip(row_stride(spectra.strides()));
        let Some((from_stride, to_stride)) = strides else {
            self.gathered(values, window, spectra, scratch);
            return;
        };
        let widest = widest(&self.kernels, columns.min(scratch.width));
        let bins = spectra.as_mut_ptr();
        // SAFETY: the tiles' columns are within both views, and so are their rows, by the shapes
        // asserted; `Complex` is two numbers.
        let tile = |start: usize| unsafe {
            let to = bins.add(start).cast::<T>();
            let row = 2 * to_stride * size_of::<T>();
            let aligned = to.addr().is_multiple_of(LINE) && row.is_multiple_of(LINE);
            Tile {
                from: values.as_ptr().add(start),
                from_stride,
                rows: order(window),
                to,
                to_stride: 2 * to_stride,
                store: match stream && aligned {
                    true => Store::Streaming,
                    false => self.through_caches(row),
                },
            }
        };
        let critical = (from_stride * size_of::<T>()).is_multiple_of(CRITICAL_STRIDE);
        let mut done = match (&self.way, critical) {
            (TilePlan::MixedRadix(plan), true) => self.through_stage(plan, columns, &tile, scratch),
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
        plan: &MixedRadix<T>,
        columns: usize,
        tile: &dyn Fn(usize) -> Tile<T>,
        scratch: &mut ColumnScratch<T>,
    ) -> usize {
        let kernel = widest(&self.kernels, columns.min(scratch.width));
        let together = tiles_together::<T>(self.length, columns, kernel.width);
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
                plan.stage(kernel, count, tile(first * kernel.width), to);
                for t in 0..count {
                    let copied = Tile {
                        from: stage.as_ptr().add(t * numbers),
                        from_stride: kernel.width,
                        rows: RowOrder::Staged,
                        ..tile((first + t) * kernel.width)
                    };
                    plan.tile(kernel, copied, work);
                }
            }
        }
        tiles * kernel.width
    }

    /// How to store rows `row` bytes apart without streaming stores.
    fn through_caches(&self, row: usize) -> Store {
        match self.bins() * row >= PREFETCH_BYTES {
            true => Store::Prefetched,
            false => Store::Plain,
        }
    }

    /// Columns that are not neighbours, through copies.
    fn gathered(
        &self,
        values: ArrayView2<T>,
        window: &[T],
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
            // SAFETY: both copies have as many rows of a tile's width as the plan's length prefetching
            // for.
            unsafe {
                let tile = Tile {
                    from: rows.as_ptr(),
                    from_stride: width,
                    rows: order(window),
                    to: bins.as_mut_ptr(),
                    to_stride: 2 * width,
                    store: self.through_caches(2 * width * size_of::<T>()),
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
/// row; at least two lines, else as many as L3 holds. No more than there are.
fn tiles_together<T>(length: usize, columns: usize, width: usize) -> usize {
    let lines_of_rows = STAGED_BYTES / size_of::<Line>() / length;
    let lines = lines_of_rows.clamp(2, 8);
    let tiles = lines * size_of::<Line>() / (width * size_of::<T>());
    tiles.max(1).min(columns / width)
}

/// Rows as they are, or times window if there are any.
fn order<T>(window: &[T]) -> RowOrder<T> {
    match window {
        [] => RowOrder::Plain,
        _ => RowOrder::Windowed(window.as_ptr()),
    }
}

/// From row to row in memory, where columns are neighbours.
fn row_stride(strides: &[isize]) -> Option<usize> {
    match strides {
        &[row, 1] => usize::try_from(row).ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;

    /// What a thread holds once it has transformed an array in rows of `stride` numbers.
    fn held<T: Real>(length: usize, columns: usize, stride: usize) -> u64 {
        let plan = ColumnTransform::<T>::new(length);
        let values = Array2::from_elem((length, stride), T::zero());
        let values = values.slice(ndarray::s![.., ..columns]);
        let mut spectra = Array2::default((plan.bins(), columns));
        let mut scratch = plan.scratch(columns);
        plan.transform(values, spectra.view_mut(), &mut scratch);
        let lines = scratch.lines.len() + scratch.copies.len();
        (lines * size_of::<Line>()) as u64 + scratch.by_column.bytes()
    }

    #[test]
    fn working_space_is_known_before_it_is_taken() {
        for (length, columns, stride) in [
            (4096, 512, 512),
            (4096, 30, 512),
            (4096, 512, 513),
            (4096, 3, 512),
            (1000, 40, 1024),
            (251, 40, 512),
            (253, 40, 512),
            (7, 40, 512),
        ] {
            let (single, double) = (
                ColumnTransform::<f32>::working_bytes(length, columns, 4 * stride),
                ColumnTransform::<f64>::working_bytes(length, columns, 8 * stride),
            );
            assert_eq!(single, held::<f32>(length, columns, stride), "{length}");
            assert_eq!(double, held::<f64>(length, columns, stride), "{length}");
        }
    }

    /// By hand: 4096 = 64 x 64, so a tile of w columns takes 2 w (64 + 33 (64 + 2)) numbers. Copies of
    /// rows 4096 bytes apart are of 8 lines a row; of 2 ^ 17 rows only of 2.
    #[test]
    fn val_working_space_by_hand() {
        let bytes = |length| {
            let of = |row_bytes| ColumnTransform::<f64>::working_bytes(length, 512, row_bytes);
            (of(4096), of(4104))
        };
        let width = ColumnTransform::<f64>::new(4096).width() as u64;
        let scratch = 2 * width * (64 + 33 * 66) * 8;
        assert_eq!(bytes(4096), (scratch + (2 << 20), scratch));
        let (copied, not) = bytes(1 << 17);
        assert_eq!(copied - not, 128 << 17);
    }
}
