//! The loop of all passes: blocks of two arrays, filled tile by tile in parallel.

use std::ops::Range;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayViewMut2, Axis, s};

use crate::error::Result;
use crate::numeric::pieces;
use crate::observer::Observer;
use crate::system::scratch_pool::ScratchPool;

/// Fills two arrays that hold the rows (or columns, by `axis`) `of`, in parallel: `tile` computes at most `size` of them with a
/// thread's scratch. Returns what it found at each, in order.
pub(super) fn fill<A: Send + Sync, B: Send + Sync, S: Default + Send, F: Send>(
    (of, size, axis): (Range<usize>, usize, Axis),
    (mut first, mut second): (ArrayViewMut2<A>, ArrayViewMut2<B>),
    (pool, observer): (&ScratchPool<S>, &dyn Observer),
    tile: impl Fn(Range<usize>, (ArrayViewMut2<A>, ArrayViewMut2<B>), &mut S) -> Result<Vec<F>> + Sync,
) -> Result<Vec<F>> {
    let tiles = first.axis_chunks_iter_mut(axis, size).into_par_iter();
    let tiles = tiles.zip(second.axis_chunks_iter_mut(axis, size));
    let found: Result<Vec<Vec<F>>> = tiles
        .enumerate()
        .map_init(
            || pool.take(|_| true, S::default),
            |room, (i, arrays)| {
                observer.go_on()?;
                let from = of.start + i * size;
                let range = from..of.end.min(from + size);
                observer.advance(range.len() as u64);
                tile(range, arrays, room)
            },
        )
        .collect();
    Ok(found?.into_iter().flatten().collect())
}

/// A pass that computes rows of two arrays.
pub(super) trait RowPass: Send + Sync {
    /// What is found at a row.
    type Found: Send;
    type Scratch: Default + Send;

    /// Makes ready what these rows are computed from.
    fn begin(&mut self, rows: Range<usize>) -> Result<()>;

    /// Computes a few rows of both arrays, one after the other.
    fn tile(
        &self,
        rows: Range<usize>,
        arrays: [&mut [f64]; 2],
        scratch: &mut Self::Scratch,
    ) -> Vec<Self::Found>;
}

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

impl RowBlocks<'_> {
    /// All blocks in order: `take` gets the first row of one, what was found at each, and the arrays, while the next is
    /// computed.
    pub fn each<P: RowPass>(
        &self,
        pass: &mut P,
        mut take: impl FnMut(usize, Vec<P::Found>, [ArrayViewMut2<f64>; 2]) -> Result<()> + Send,
    ) -> Result<()> {
        let room = || {
            self.columns
                .map(|columns| Array2::zeros((self.block, columns)))
        };
        let (mut computed, mut next) = (room(), room());
        let pool = ScratchPool::default();
        let mut last: Option<(usize, Vec<P::Found>)> = None;
        for rows in pieces(self.rows, self.block).map(Some).chain([None]) {
            let (handed_on, found) = rayon::join(
                || match last.take() {
                    None => Ok(()),
                    Some((from, found)) => {
                        let count = found.len();
                        take(
                            from,
                            found,
                            computed.each_mut().map(|a| a.slice_mut(s![..count, ..])),
                        )
                    }
                },
                || match &rows {
                    None => Ok(None),
                    Some(rows) => self.block(pass, rows.clone(), &mut next, &pool).map(Some),
                },
            );
            handed_on?;
            last = rows.map(|rows| rows.start).zip(found?);
            std::mem::swap(&mut computed, &mut next);
        }
        Ok(())
    }

    fn block<P: RowPass>(
        &self,
        pass: &mut P,
        rows: Range<usize>,
        arrays: &mut [Array2<f64>; 2],
        pool: &ScratchPool<P::Scratch>,
    ) -> Result<Vec<P::Found>> {
        pass.begin(rows.clone())?;
        let pass = &*pass;
        // Several tiles per thread if the block is large enough.
        let [step, most] = self.tile;
        let size = rows.len().div_ceil(4 * rayon::current_num_threads());
        let size = size.next_multiple_of(step).min(most);
        let [first, second] = arrays.each_mut().map(|a| a.slice_mut(s![..rows.len(), ..]));
        let of = (rows, size, Axis(0));
        fill(
            of,
            (first, second),
            (pool, self.observer),
            |rows, (mut first, mut second), room| {
                let both = [&mut first, &mut second];
                let both = both.map(|rows| rows.as_slice_mut().expect("whole rows"));
                Ok(pass.tile(rows, both, room))
            },
        )
    }
}
