//! Large arrays reduced for the eye, block by block.

use std::borrow::Cow;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, ArrayView2, Axis, azip, s};

use crate::numeric::lanes::{Lanes, SimdKernel, WIDTH, widest};

/// Largest number of cells of a map, `(rows, columns)`: the resolution of a page.
pub(crate) const MAP_LIMIT: (usize, usize) = (400, 300);

/// A large array reduced by blocks for the eye: no sample is dropped.
#[derive(Debug, Clone)]
pub struct Map {
    /// `(rows, columns)`; row 0 is the lowest value of `y`.
    pub values: Array2<f32>,
    pub x: MapAxis,
    pub y: MapAxis,
    pub reduction: Reduction,
    /// Least and largest value of each cell, if a cell is of more than one signed sample.
    pub range: Option<[Array2<f32>; 2]>,
    /// What the values are, with unit, for the colour scale's label.
    pub label: String,
}

/// An axis of a [`Map`]: cell edges from `low` to `high`, evenly divided.
#[derive(Debug, Clone)]
pub struct MapAxis {
    pub label: String,
    pub low: f64,
    pub high: f64,
}

/// How many samples share a cell, and what of them is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reduction {
    /// The largest value of each block.
    Max { rows: usize, columns: usize },
    /// The value of largest magnitude of each block, with its sign.
    Extreme { rows: usize, columns: usize },
}

/// What of a block is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Keep {
    Largest,
    Extreme,
}

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

    fn new(shape: (usize, usize), limit: (usize, usize), keep: Keep) -> Self {
        let rows = shape.0.div_ceil(limit.0).max(1);
        let columns = shape.1.div_ceil(limit.1).max(1);
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
        high.axis_iter_mut(Axis(0))
            .into_par_iter()
            .zip(low.axis_iter_mut(Axis(0)))
            .enumerate()
            .for_each(|(i, (mut high, mut low))| {
                let top = ((first + i) * height).max(row);
                let bottom = ((first + i + 1) * height).min(end);
                // Row by row first: that vectorises, and leaves one row to share out.
                let mut largest = vec![f64::NEG_INFINITY; block.ncols()];
                let mut least = vec![f64::INFINITY; if low.is_empty() { 0 } else { block.ncols() }];
                widest(Reduce {
                    block: block.slice(s![top - row..bottom - row, ..]),
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
        let axis = |(label, first, step): (&str, f64, f64), cells: usize, block: usize| MapAxis {
            label: label.to_owned(),
            low: first - 0.5 * step,
            high: first + ((cells * block) as f64 - 0.5) * step,
        };
        let cells = self.cells();
        let (rows, columns) = cells.dim();
        let largest = cells.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let fits = largest == 0.0 || (1e-20..1e20).contains(&largest);
        let (factors, label) = if fits || !largest.is_finite() {
            ((1.0, 1.0), label)
        } else {
            let exponent = largest.log10().floor() as i32;
            // In two steps, since 10^-exponent may be out of range.
            let half = -exponent / 2;
            let factors = (10f64.powi(half), 10f64.powi(-exponent - half));
            (factors, format!("{label} × 1e{exponent}"))
        };
        let single = |v: f64| (v * factors.0 * factors.1) as f32;
        let bound = |bounds: &Array2<f64>| {
            bounds.mapv(|v| if v.is_infinite() { f32::NAN } else { single(v) })
        };
        let range = (self.keep == Keep::Extreme && self.rows * self.columns > 1)
            .then(|| [bound(&self.low), bound(&self.high)]);
        Map {
            x: axis(x, columns, self.columns),
            y: axis(y, rows, self.rows),
            reduction: match self.keep {
                Keep::Largest => Reduction::Max {
                    rows: self.rows,
                    columns: self.columns,
                },
                Keep::Extreme => Reduction::Extreme {
                    rows: self.rows,
                    columns: self.columns,
                },
            },
            values: cells.mapv(single),
            range,
            label,
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
            let row = row
                .to_slice()
                .map_or_else(|| Cow::Owned(row.to_vec()), Cow::Borrowed);
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
        for (largest, unit) in [(2e-47, "× 1e-47"), (3e250, "× 1e250"), (4e-300, "× 1e-300")] {
            let mut builder = MapBuilder::largest((1, 2), (2, 2));
            builder.add(0, 0, array![[largest, 0.5 * largest]].view());
            let map = builder.finish("S".into(), ("y", 0.0, 1.0), ("x", 0.0, 1.0));
            assert_eq!(map.label, format!("S {unit}"));
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

    #[test]
    fn blocks_in_any_order_give_the_same_map() {
        let whole = array![[1.0, -5.0, 2.0], [0.0, 3.0, -2.0], [4.0, 0.0, 0.5]];
        let mut once = MapBuilder::extreme((3, 3), (2, 2));
        once.add(0, 0, whole.view());
        let mut parts = MapBuilder::extreme((3, 3), (2, 2));
        for (row, column) in [
            (2, 2),
            (0, 1),
            (1, 0),
            (2, 0),
            (0, 0),
            (1, 2),
            (2, 1),
            (1, 1),
            (0, 2),
        ] {
            let part = whole.slice(ndarray::s![row..=row, column..=column]);
            parts.add(row, column, part);
        }
        assert_eq!(once.cells(), parts.cells());
        assert_eq!(once.cells(), array![[-5.0, 2.0], [4.0, 0.5]]);
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
