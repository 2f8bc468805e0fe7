//! Large arrays reduced for the eye, block by block.

use std::borrow::Cow;
use std::ops::Range;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayView2, Axis, azip, s};

use super::map::{Keep, MAP_LIMIT, Map, MapAxis, Part, PowerOfTen, Reduction, block_size};
use crate::numeric::lanes::{Lanes, SimdKernel, WIDTH, widest};

/// Collects blocks of a `(rows, columns)` array into at most `limit` cells a side.
///
/// Largest values do not depend on the order in which blocks come; extremes of equal magnitude
/// and opposite sign go to the positive one.
#[derive(Debug)]
pub(crate) struct MapBuilder {
    /// The largest value of each cell; minus infinity where there is none.
    high: Array2<f64>,
    /// The least, if it is kept; infinity where there is none.
    low: Array2<f64>,
    rows: usize,
    columns: usize,
    /// Row and column of the whole at which the first cell begins.
    first: (usize, usize),
    keep: Keep,
}

impl MapBuilder {
    /// Keeps the largest value of each block.
    pub fn largest(shape: (usize, usize), limit: (usize, usize)) -> Self {
        Self::new(shape, limit, Keep::Largest)
    }

    /// Keeps the value of largest magnitude, with its sign.
    pub fn extreme(shape: (usize, usize), limit: (usize, usize)) -> Self {
        Self::new(shape, limit, Keep::Extreme)
    }

    /// Keeps as `keep` has it.
    pub fn new(shape: (usize, usize), limit: (usize, usize), keep: Keep) -> Self {
        let (rows, columns) = block_size(shape, limit);
        let cells = (shape.0.div_ceil(rows), shape.1.div_ceil(columns));
        let kept = match keep {
            Keep::Largest => (cells.0, 0),
            Keep::Extreme => cells,
        };
        MapBuilder {
            high: Array2::from_elem(cells, f64::NEG_INFINITY),
            low: Array2::from_elem(kept, f64::INFINITY),
            rows,
            columns,
            first: (0, 0),
            keep,
        }
    }

    /// Adds the block whose first element is `(row, column)` of the whole.
    pub fn add(&mut self, row: usize, column: usize, block: ArrayView2<f64>) {
        let (height, width) = (self.rows, self.columns);
        let end = row + block.nrows();
        let (first, last) = (row / height, end.div_ceil(height));
        let cells = s![first..last, ..];
        let (mut high, mut low) = (self.high.slice_mut(cells), self.low.slice_mut(cells));
        let high = high.axis_iter_mut(Axis(0)).into_par_iter();
        high.zip(low.axis_iter_mut(Axis(0)))
            .enumerate()
            .for_each(|(i, (mut high, mut low))| {
                let top = ((first + i) * height).max(row);
                let bottom = ((first + i + 1) * height).min(end);
                let block = block.slice(s![top - row..bottom - row, ..]);
                let columns = column..column + block.ncols();
                let kept = if low.is_empty() {
                    0..0
                } else {
                    columns.clone()
                };
                if width == 1
                    && let (Some(high), Some(low)) = (high.as_slice_mut(), low.as_slice_mut())
                {
                    let (largest, least) = (&mut high[columns], &mut low[kept]);
                    widest(Reduce {
                        block,
                        largest,
                        least,
                    });
                    return;
                }
                // Row by row first: that vectorises, and leaves one row to share out.
                let mut largest = vec![f64::NEG_INFINITY; columns.len()];
                let mut least = vec![f64::INFINITY; kept.len()];
                widest(Reduce {
                    block,
                    largest: &mut largest,
                    least: &mut least,
                });
                share_out(&largest, column, width, |cell, value| {
                    high[cell] = larger(value, high[cell]);
                });
                share_out(&least, column, width, |cell, value| {
                    low[cell] = smaller(value, low[cell]);
                });
            });
    }

    /// The cells that hold `part`, whole ones, in at most `limit` larger cells a side.
    fn reduced(&self, (rows, columns): &Part, limit: (usize, usize)) -> MapBuilder {
        let cells = |part: &Range<usize>, block: usize, count: usize| {
            let end = part.end.div_ceil(block).min(count);
            (part.start / block).min(end)..end
        };
        let rows = cells(rows, self.rows, self.high.nrows());
        let columns = cells(columns, self.columns, self.high.ncols());
        let shape = (rows.len(), columns.len());
        let of = |cells: &Array2<f64>| {
            let mut of = MapBuilder::new(shape, limit, self.keep);
            of.add(0, 0, cells.slice(s![rows.clone(), columns.clone()]));
            of
        };
        let mut reduced = of(&self.high);
        if self.keep == Keep::Extreme {
            reduced.low = of(&self.low).low;
        }
        reduced.first = (rows.start * self.rows, columns.start * self.columns);
        reduced.rows *= self.rows;
        reduced.columns *= self.columns;
        reduced
    }

    /// The value of each cell; NaN for cells without a number.
    fn cells(&self) -> Array2<f64> {
        let mut cells = self.high.clone();
        if self.keep == Keep::Extreme {
            azip!((cell in &mut cells, &low in &self.low) {
                *cell = if cell.abs() < low.abs() { low } else { *cell };
            });
        }
        cells.mapv_into(|v| if v == f64::NEG_INFINITY { f64::NAN } else { v })
    }

    /// The same in another unit: every cell times `factor`.
    pub fn times(mut self, factor: f64) -> Self {
        self.high.mapv_inplace(|v| v * factor);
        self.low.mapv_inplace(|v| v * factor);
        self
    }

    /// The map, with the coordinates of its first row and column and their steps.
    ///
    /// Cells are shown in single precision; where their size leaves its range, in units of a power
    /// of ten that the label states.
    pub fn finish(self, label: String, y: (&str, f64, f64), x: (&str, f64, f64)) -> Map {
        self.finish_with(None, label, y, x)
    }

    /// The same, with a part of it in finer cells where these show more.
    pub fn finish_with(
        self,
        part: Option<&Part>,
        label: String,
        y: (&str, f64, f64),
        x: (&str, f64, f64),
    ) -> Map {
        let (rows, columns) = self.high.dim();
        let whole = (0..rows * self.rows, 0..columns * self.columns);
        let overview = self.reduced(&whole, MAP_LIMIT);
        let detail = part.map(|part| self.reduced(part, MAP_LIMIT));
        // Cells of the overview beyond the part count, too: it may hold all of them.
        let detail = detail.filter(|part| {
            (part.rows, part.columns) != (overview.rows, overview.columns)
                || part.high.dim() != overview.high.dim()
        });
        let ends = overview.high.iter().chain(&overview.low);
        let sizes = ends.filter(|v| !v.is_infinite()).map(|v| v.abs());
        let unit = PowerOfTen::of(sizes.fold(0.0, f64::max));
        let label = unit.label(label);
        Map {
            detail: detail.map(|detail| Box::new(detail.map(unit, &label, y, x))),
            ..overview.map(unit, &label, y, x)
        }
    }

    /// The cells as they are, in this unit.
    fn map(&self, unit: PowerOfTen, label: &str, y: (&str, f64, f64), x: (&str, f64, f64)) -> Map {
        let axis = |(label, origin, step): (&str, f64, f64), first: usize, length: usize| MapAxis {
            label: label.to_owned(),
            low: origin + (first as f64 - 0.5) * step,
            high: origin + ((first + length) as f64 - 0.5) * step,
        };
        let cells = self.high.dim();
        let bound = |bounds: &Array2<f64>| {
            bounds.mapv(|v| match v.is_infinite() {
                true => f32::NAN,
                false => unit.single(v),
            })
        };
        let (rows, columns) = (self.rows, self.columns);
        let has_range = self.keep == Keep::Extreme && rows * columns > 1;
        Map {
            x: axis(x, self.first.1, cells.1 * columns),
            y: axis(y, self.first.0, cells.0 * rows),
            reduction: match self.keep {
                Keep::Largest => Reduction::Max { rows, columns },
                Keep::Extreme => Reduction::Extreme { rows, columns },
            },
            values: self.cells().mapv(|v| unit.single(v)),
            range: has_range.then(|| [bound(&self.low), bound(&self.high)]),
            label: label.to_owned(),
            detail: None,
        }
    }
}

/// Each of `values`, the first of column `column`, to its cell of `width` columns.
fn share_out(values: &[f64], column: usize, width: usize, mut to: impl FnMut(usize, f64)) {
    let (first, before) = (column / width, column % width);
    let (head, rest) = values.split_at((width - before).min(values.len()));
    head.iter().for_each(|&value| to(first, value));
    for (cell, values) in (first + 1..).zip(rest.chunks(width)) {
        values.iter().for_each(|&value| to(cell, value));
    }
}

/// The larger one; `old` if the other is NaN.
#[inline(always)]
fn larger(new: f64, old: f64) -> f64 {
    if new > old { new } else { old }
}

#[inline(always)]
fn smaller(new: f64, old: f64) -> f64 {
    if new < old { new } else { old }
}

/// The largest and the least value of each column; `least` is empty where they are not wanted.
struct Reduce<'a> {
    block: ArrayView2<'a, f64>,
    largest: &'a mut [f64],
    least: &'a mut [f64],
}

impl SimdKernel for Reduce<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for row in self.block.outer_iter() {
            let stored = row.to_slice().map(Cow::Borrowed);
            let row = stored.unwrap_or_else(|| Cow::Owned(row.to_vec()));
            let (news, rest) = row.as_chunks();
            let done = WIDTH * news.len();
            let (olds, rest_old) = self.largest.as_chunks_mut();
            for (old, new) in olds.iter_mut().zip(news) {
                L::read(new).largest(L::read(old)).write(old);
            }
            for (old, &new) in rest_old.iter_mut().zip(rest) {
                *old = larger(new, *old);
            }
            let Some(least) = self.least.get_mut(..done) else {
                continue;
            };
            for (old, new) in least.as_chunks_mut().0.iter_mut().zip(news) {
                L::read(new).least(L::read(old)).write(old);
            }
            for (old, &new) in self.least[done..].iter_mut().zip(rest) {
                *old = smaller(new, *old);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn sizes_beyond_single_precision_are_shown_in_a_stated_unit() {
        for (largest, power) in [(2e-47, "10⁻⁴⁷"), (3e250, "10²⁵⁰"), (4e-300, "10⁻³⁰⁰")]
        {
            let mut builder = MapBuilder::largest((1, 2), (2, 2));
            builder.add(0, 0, array![[largest, 0.5 * largest]].view());
            let map = builder.finish("S (m)".into(), ("y", 0.0, 1.0), ("x", 0.0, 1.0));
            assert_eq!(map.label, format!("S ({power} m)"));
            assert!((map.values[[0, 0]] / map.values[[0, 1]] - 2.0).abs() < 1e-6);
            assert!((1.0..10.0).contains(&map.values[[0, 0]]));
        }
    }

    #[test]
    fn of_equal_magnitudes_the_positive_stays_and_no_number_is_none() {
        let nan = f64::NAN;
        let mut map = MapBuilder::extreme((2, 4), (1, 2));
        map.add(
            0,
            0,
            array![[-2.0, nan, nan, nan], [2.0, 1.0, nan, nan]].view(),
        );
        let cells = map.cells();
        assert_eq!(cells[[0, 0]], 2.0);
        assert!(cells[[0, 1]].is_nan());
    }

    /// Widths beyond a register, cells of several columns, blocks that begin inside of one; NaN,
    /// infinities and zeros of both signs.
    #[test]
    fn wide_blocks_give_what_a_plain_loop_gives() {
        let value = |i: usize, j: usize| match (7 * i + 3 * j) % 13 {
            0 => f64::NAN,
            1 => -0.0,
            2 if j % 9 == 4 => f64::NEG_INFINITY,
            3 if j % 9 == 5 => f64::INFINITY,
            m => (m as f64 - 6.5) * (1.0 + (i + j) as f64),
        };
        for (columns, limit) in [(8, 8), (13, 13), (40, 14), (40, 4), (17, 1)] {
            let whole = Array2::from_shape_fn((6, columns), |(i, j)| value(i, j));
            for keep in [MapBuilder::largest, MapBuilder::extreme] {
                let mut map = keep((6, columns), (3, limit));
                for split in [0..columns / 3, columns / 3..columns] {
                    map.add(0, split.start, whole.slice(s![.., split]));
                }
                let cells = map.cells();
                let width = columns.div_ceil(limit);
                for ((r, c), &found) in cells.indexed_iter() {
                    let of = whole.slice(s![
                        2 * r..2 * r + 2,
                        c * width..columns.min((c + 1) * width)
                    ]);
                    let numbers = || of.iter().copied().filter(|v| !v.is_nan());
                    let (low, high) = (
                        numbers().fold(f64::INFINITY, f64::min),
                        numbers().fold(f64::NEG_INFINITY, f64::max),
                    );
                    let right = match map.keep {
                        Keep::Extreme if high.abs() < low.abs() => low,
                        _ => high,
                    };
                    // Minus infinity marks a cell without numbers.
                    let none = right == f64::NEG_INFINITY;
                    assert!(
                        found == right || none && found.is_nan(),
                        "{columns} {r} {c}: {found} {right}"
                    );
                }
            }
        }
    }
}
