//! The loop of all passes: blocks of two arrays, filled tile by tile in parallel.

use std::ops::Range;
use std::sync::Mutex;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayViewMut2, Axis, s};

use crate::error::Result;
use crate::numeric::pieces;
use crate::observer::Observer;
use crate::prepare::Prepared;
use crate::system::lock;

/// Fills two arrays that hold the rows (or columns, by `axis`) `of`, in parallel: `tile` computes at most `size` of them with one of
/// the rooms that threads hand on: new memory costs a fault a page. Returns what it found at each, in order.
pub(super) fn fill<A: Send + Sync, B: Send + Sync, S: Default + Send, F: Send>(
    (of, size, axis): (Range<usize>, usize, Axis),
    (mut first, mut second): (ArrayViewMut2<A>, ArrayViewMut2<B>),
    (rooms, observer): (&Mutex<Vec<S>>, &dyn Observer),
    tile: impl Fn(Range<usize>, (ArrayViewMut2<A>, ArrayViewMut2<B>), &mut S) -> Result<Vec<F>> + Sync,
) -> Result<Vec<F>> {
    let tiles = first.axis_chunks_iter_mut(axis, size).into_par_iter();
    let tiles = tiles.zip(second.axis_chunks_iter_mut(axis, size));
    let found: Result<Vec<Vec<F>>> = tiles
        .enumerate()
        .map(|(i, arrays)| {
            observer.go_on()?;
            let from = of.start + i * size;
            let range = from..of.end.min(from + size);
            observer.advance(range.len() as u64);
            let mut room = lock(rooms).pop().unwrap_or_default();
            let found = tile(range, arrays, &mut room);
            lock(rooms).push(room);
            found
        })
        .collect();
    Ok(found?.into_iter().flatten().collect())
}

/// How rows of two arrays are computed.
pub(super) struct RowBlocks<'a> {
    pub rows: usize,
    /// Rows of a block.
    pub block: usize,
    pub columns: [usize; 2],
    /// Rows of a tile: a multiple of so many, and at most so many.
    pub tile: [usize; 2],
    /// Of the field that blocks are computed from, if they are: pages that are mapped for one are let go once it is there.
    pub pages: Option<&'a Prepared<'a>>,
    pub observer: &'a dyn Observer,
}

impl RowBlocks<'_> {
    /// All blocks in order: `begin` makes ready what one is computed from, and `tile` computes a few rows of both arrays, one
    /// after the other. `take` gets its first row, what was found at each, and the arrays, while the next is computed.
    pub fn each<S: Default + Send, F: Send>(
        &self,
        mut begin: impl FnMut(Range<usize>) -> Result<()> + Send,
        tile: impl Fn(Range<usize>, [&mut [f64]; 2], &mut S) -> Vec<F> + Sync,
        mut take: impl FnMut(usize, Vec<F>, [ArrayViewMut2<f64>; 2]) -> Result<()> + Send,
    ) -> Result<()> {
        let ([step, most], block) = (self.tile, self.block);
        let room = || self.columns.map(|columns| Array2::zeros((block, columns)));
        let (mut computed, mut next) = (room(), room());
        let rooms = Mutex::default();
        let mut compute = |rows: Range<usize>, arrays: &mut [Array2<f64>; 2]| {
            begin(rows.clone())?;
            // Several tiles per thread if the block is large enough.
            let size = rows.len().div_ceil(4 * rayon::current_num_threads());
            let [first, second] = first_rows(arrays, rows.len());
            let of = (rows, size.next_multiple_of(step).min(most), Axis(0));
            let with = (&rooms, self.observer);
            let found = fill(of, (first, second), with, |rows, (mut a, mut b), room| {
                let both = [&mut a, &mut b].map(|rows| rows.as_slice_mut().expect("whole rows"));
                Ok(tile(rows, both, room))
            });
            if let Some(prepared) = self.pages {
                prepared.release_pages();
            }
            found
        };
        let mut last: Option<(Range<usize>, Vec<F>)> = None;
        for rows in pieces(self.rows, block).map(Some).chain([None]) {
            let (handed_on, found) = rayon::join(
                || match last.take() {
                    Some((of, found)) => take(of.start, found, first_rows(&mut computed, of.len())),
                    None => Ok(()),
                },
                || {
                    rows.clone()
                        .map(|rows| compute(rows, &mut next))
                        .transpose()
                },
            );
            handed_on?;
            last = rows.zip(found?);
            std::mem::swap(&mut computed, &mut next);
        }
        Ok(())
    }
}

fn first_rows(arrays: &mut [Array2<f64>; 2], count: usize) -> [ArrayViewMut2<'_, f64>; 2] {
    let arrays = arrays.each_mut();
    arrays.map(|all| all.slice_mut(s![..count, ..]))
}
