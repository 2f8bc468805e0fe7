//! From arrays to tiles: which columns go together, and through which copies.

use num_complex::Complex;

use super::algorithm::Decomposition;
use super::fallback::Fallback;
use super::kernels::Kernels;
use super::mixed_radix::{MixedRadix, RowOrder, Store, Tile};
use super::plan::TilePlan;
use super::{
    InstructionSet, LINE, PREFETCH_BYTES, RealToComplexColumns, kernels_for, scratch, simd, widest,
    width_for,
};
use crate::{Columns, ColumnsMut, Real};

/// A critical stride in bytes: rows a multiple of it apart share a few cache sets, so that prefetched lines are
/// evicted before their use. Such rows are copied first, in long pieces, into the order of use.
const CRITICAL_STRIDE: usize = 4096;
/// Bytes of such copies, which L3 holds; but at least 128 bytes a row.
const STAGED_BYTES: usize = 8 << 20;

/// What decides on copies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Columns are neighbours in both arrays.
    Rows,
    /// The same, and rows of samples are a critical stride apart.
    CriticalRows,
    /// Columns of an array are not neighbours.
    Strided,
}

impl Layout {
    /// Of neighbouring columns, with rows of samples `row_bytes` apart.
    pub fn of_rows(row_bytes: usize) -> Layout {
        match row_bytes.is_multiple_of(CRITICAL_STRIDE) {
            true => Layout::CriticalRows,
            false => Layout::Rows,
        }
    }

    /// Of an array of samples whose spectra's columns are neighbours.
    pub fn of_input<T>(values: &Columns<T>) -> Layout {
        match row_stride(values.strides()) {
            Some(stride) => Layout::of_rows(stride * size_of::<T>()),
            None => Layout::Strided,
        }
    }

    pub fn of<T>(values: &Columns<T>, spectra: &ColumnsMut<Complex<T>>) -> Layout {
        match row_stride(spectra.strides()) {
            Some(_) => Layout::of_input(values),
            None => Layout::Strided,
        }
    }
}

/// Numbers of scratch: of the plan, and of copies.
fn parts<T>(
    decomposition: &Decomposition,
    (length, columns, width): (usize, usize, usize),
    layout: Layout,
) -> [usize; 2] {
    let copies = match (layout, decomposition) {
        (Layout::CriticalRows, Decomposition::MixedRadix(_)) => {
            tiles_together::<T>(length, columns, width) * length * width
        }
        (Layout::Strided, _) => gathered(length, width) + 2 * width * (length / 2 + 1),
        _ => 0,
    };
    [decomposition.scratch_len(width), copies]
}

/// Whether columns of `length` samples take a window in passing.
pub fn windows_in_passing(length: usize) -> bool {
    matches!(Decomposition::of(length), Decomposition::MixedRadix(_))
}

/// Complex numbers of scratch to transform columns of `length` samples, known before there is a plan.
pub fn scratch_len<T: Real>(length: usize, columns: usize, layout: Layout) -> usize {
    let decomposition = Decomposition::of(length);
    if matches!(decomposition, Decomposition::Fallback) {
        return Fallback::<T>::new(length).scratch_len();
    }
    let width = width_for(
        &kernels_for::<T>(InstructionSet::best(), &decomposition),
        columns,
    );
    scratch::complex_len::<T>(parts::<T>(&decomposition, (length, columns, width), layout))
}

impl<T: Real> RealToComplexColumns<T> {
    /// Complex numbers of scratch.
    pub(crate) fn scratch_len_in(&self, columns: usize, layout: Layout) -> usize {
        if let TilePlan::Fallback(fallback) = &self.plan {
            return fallback.scratch_len();
        }
        let width = width_for(&self.kernels, columns);
        let shape = (self.length, columns, width);
        scratch::complex_len::<T>(parts::<T>(&self.decomposition, shape, layout))
    }

    /// Transforms all columns tile by tile.
    pub(super) fn tiles(
        &self,
        values: Columns<T>,
        window: &[T],
        spectra: &mut ColumnsMut<Complex<T>>,
        stream: bool,
        scratch: &mut [Complex<T>],
    ) {
        let columns = values.columns();
        let widest = widest(&self.kernels, columns);
        let first = self.decomposition.scratch_len(widest.width);
        let (work, copies) = scratch::divide(scratch, first);
        let strides = row_stride(values.strides()).zip(row_stride(spectra.strides()));
        let Some((from_stride, to_stride)) = strides else {
            self.gathered(values, window, spectra, (work, copies));
            return;
        };
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
        let mut done = match (&self.plan, critical) {
            (TilePlan::MixedRadix(plan), true) => {
                self.through_stage(plan, columns, &tile, (&mut *work, copies))
            }
            _ => 0,
        };
        while done < columns {
            let left = columns - done;
            let covers = |k: &&&Kernels<T>| k.width >= left && k.width <= widest.width;
            let kernel = *self.kernels.iter().rev().find(covers).unwrap_or(&widest);
            // The last tile overlaps the one before: the same numbers are written again.
            let start = done.min(columns - kernel.width);
            // SAFETY: as before.
            unsafe { self.plan.tile(kernel, tile(start), work) };
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
        (work, copies): (&mut [T], &mut [T]),
    ) -> usize {
        let kernel = widest(&self.kernels, columns);
        let together = tiles_together::<T>(self.length, columns, kernel.width);
        let numbers = self.length * kernel.width;
        let stage = &mut copies[..together * numbers];
        let tiles = columns / kernel.width;
        for first in (0..tiles).step_by(together.max(1)) {
            let count = together.min(tiles - first);
            // SAFETY: the tiles' rows are within the arrays, and the stage holds `together` tiles.
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
        values: Columns<T>,
        window: &[T],
        spectra: &mut ColumnsMut<Complex<T>>,
        (work, copies): (&mut [T], &mut [T]),
    ) {
        let columns = values.columns();
        let kernel = widest(&self.kernels, columns);
        let width = kernel.width;
        let (rows, bins) = copies.split_at_mut(gathered(self.length, width));
        let (rows, bins) = (
            &mut rows[..width * self.length],
            &mut bins[..2 * width * self.bins()],
        );
        for done in (0..columns).step_by(width) {
            let start = done.min(columns - width);
            for (n, row) in rows.chunks_exact_mut(width).enumerate() {
                for (c, to) in row.iter_mut().enumerate() {
                    *to = values.at(n, start + c);
                }
            }
            // SAFETY: the copies hold `length` and `bins` rows of a tile's width.
            unsafe {
                let tile = Tile {
                    from: rows.as_ptr(),
                    from_stride: width,
                    rows: order(window),
                    to: bins.as_mut_ptr(),
                    to_stride: 2 * width,
                    store: self.through_caches(2 * width * size_of::<T>()),
                };
                self.plan.tile(kernel, tile, work);
            }
            for (m, row) in bins.chunks_exact(2 * width).enumerate() {
                for (c, pair) in row.chunks_exact(2).enumerate() {
                    spectra.set(m, start + c, Complex::new(pair[0], pair[1]));
                }
            }
        }
    }
}

/// Numbers of a copy of a tile's samples, in whole cache lines.
fn gathered(length: usize, width: usize) -> usize {
    (width * length).next_multiple_of(64)
}

/// Tiles whose rows are copied together: the more, the longer the pieces read, up to 8 cache lines a
/// row; at least two lines, else as many as L3 holds. No more than there are.
fn tiles_together<T>(length: usize, columns: usize, width: usize) -> usize {
    let lines_of_rows = STAGED_BYTES / LINE / length;
    let lines = lines_of_rows.clamp(2, 8);
    let tiles = lines * LINE / (width * size_of::<T>());
    tiles.max(1).min(columns / width)
}

/// Rows as they are, or times a window if there is one.
fn order<T>(window: &[T]) -> RowOrder<T> {
    match window {
        [] => RowOrder::Plain,
        _ => RowOrder::Windowed(window.as_ptr()),
    }
}

/// From row to row in memory, where columns are neighbours.
fn row_stride(strides: [isize; 2]) -> Option<usize> {
    match strides {
        [row, 1] => usize::try_from(row).ok(),
        _ => None,
    }
}
