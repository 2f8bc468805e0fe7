//! Rows of two arrays in blocks: one is handed on while the next is computed.

use std::ops::Range;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayViewMut2, Axis, s};

use crate::error::Result;
use crate::observer::Observer;
use crate::system::scratch_pool::ScratchPool;

/// How rows of two arrays are computed.
pub(super) struct RowBlocks<'a> {
    pub rows: usize,
    /// Rows of a block.
    pub block: usize,
    pub columns: [usize; 2],
    /// Rows of a tile: a multiple of so many, and at most so many.
    pub tile: [usize; 2],
    pub observer: &'a dyn Observer,
}

/// Neighbouring rows.
pub(super) struct Block<F> {
    from: usize,
    arrays: [Array2<f64>; 2],
    /// One a row; none once it was handed on.
    seen: Vec<F>,
}

impl<F> Block<F> {
    fn rows(&mut self, count: usize) -> [ArrayViewMut2<'_, f64>; 2] {
        let arrays = self.arrays.each_mut();
        arrays.map(|all| all.slice_mut(s![..count, ..]))
    }
}

impl RowBlocks<'_> {
    /// All blocks in order: `fill` computes one, and `take` gets its first row, what was found at each, and the
    /// arrays.
    pub fn each<F: Send>(
        &self,
        mut fill: impl FnMut(Range<usize>, &mut Block<F>) -> Result<()> + Send,
        mut take: impl FnMut(usize, Vec<F>, [ArrayViewMut2<f64>; 2]) -> Result<()> + Send,
    ) -> Result<()> {
        let room = || Block {
            from: 0,
            arrays: self
                .columns
                .map(|columns| Array2::zeros((self.block, columns))),
            seen: Vec::new(),
        };
        let (mut computed, mut next) = (room(), room());
        let starts = (0..self.rows).step_by(self.block);
        for from in starts.map(Some).chain([None]) {
            let seen = std::mem::take(&mut computed.seen);
            let (handed_on, filled) = rayon::join(
                || match seen.len() {
                    0 => Ok(()),
                    count => take(computed.from, seen, computed.rows(count)),
                },
                || {
                    from.map_or(Ok(()), |from| {
                        fill(from..self.rows.min(from + self.block), &mut next)
                    })
                },
            );
            handed_on?;
            filled?;
            std::mem::swap(&mut computed, &mut next);
        }
        Ok(())
    }

    /// Fills `block` with `rows`, in parallel: `tile` computes a few in both arrays, row by row.
    pub fn fill<S: Default + Send, F: Send>(
        &self,
        rows: Range<usize>,
        block: &mut Block<F>,
        pool: &ScratchPool<S>,
        tile: impl Fn(Range<usize>, [&mut [f64]; 2], &mut S) -> Vec<F> + Sync,
    ) -> Result<()> {
        let [step, most] = self.tile;
        // Several tiles per thread if the block is large enough.
        let size = rows.len().div_ceil(4 * rayon::current_num_threads());
        let size = size.next_multiple_of(step).min(most);
        let [mut first, mut second] = block.rows(rows.len());
        let seen: Result<Vec<Vec<F>>> = first
            .axis_chunks_iter_mut(Axis(0), size)
            .into_par_iter()
            .zip(second.axis_chunks_iter_mut(Axis(0), size))
            .enumerate()
            .map_init(
                || pool.take(|_| true, S::default),
                |room, (i, (mut first, mut second))| {
                    self.observer.go_on()?;
                    let (from, count) = (rows.start + i * size, first.nrows());
                    self.observer.advance(count as u64);
                    // Bands of whole rows of standard arrays are contiguous.
                    let both = first.as_slice_mut().zip(second.as_slice_mut());
                    let seen = both.map(|(a, b)| tile(from..from + count, [a, b], room));
                    Ok(seen.unwrap_or_default())
                },
            )
            .collect();
        block.from = rows.start;
        block.seen = seen?.into_iter().flatten().collect();
        Ok(())
    }
}
