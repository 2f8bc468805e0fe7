//! Large arrays reduced for the eye, block by block.

use std::borrow::Cow;
use std::ops::Range;

use ndarray::parallel::prelude::*;
use ndarray::{Array2, Array3, ArrayView2, Axis, azip, s};

use super::map::{Keep, MAP_LIMIT, Part, PowerOfTen, block_size};
use crate::numeric::lanes::{Lanes, SimdKernel, widest};
use crate::sheet::{Map, MapAxis, Reduction};

/// Label of an axis, its first coordinate, and the step.
type Side<'a> = (&'a str, f64, f64);

/// Collects blocks of a `(rows, columns)` array into at most `limit` cells a side.
///
/// Largest values do not depend on the order in which blocks come; extremes of equal magnitude
/// and opposite sign go to the positive one.
#[derive(Debug)]
pub(crate) struct MapBuilder {
    /// `(row, number, column)`: the largest value of each cell and, if signs are kept, the largest of minus the values;
    /// minus infinity where there is none.
    cells: Array3<f64>,
    rows: usize,
    columns: usize,
    /// Row and column of the whole at which the first cell begins.
    first: (usize, usize),
    keep: Keep,
}

impl MapBuilder {
    /// Keeps as `keep` has it.
    pub fn new(shape: (usize, usize), limit: (usize, usize), keep: Keep) -> Self {
        let (rows, columns) = block_size(shape, limit);
        let (down, along) = (shape.0.div_ceil(rows), shape.1.div_ceil(columns));
        MapBuilder {
            cells: Array3::from_elem((down, keep.numbers(), along), f64::NEG_INFINITY),
            rows,
            columns,
            first: (0, 0),
            keep,
        }
    }

    /// Adds the block whose first element is `(row, column)` of the whole.
    pub fn add(&mut self, row: usize, column: usize, block: ArrayView2<f64>) {
        let both = [(0, 1.0), (1, -1.0)];
        self.collect(&both[..self.keep.numbers()], (row, column), block);
    }

    /// The largest values of a block times each sign go to the number beside it of the cells.
    fn collect(&mut self, numbers: &[(usize, f64)], at: (usize, usize), block: ArrayView2<f64>) {
        let ((row, column), height, width) = (at, self.rows, self.columns);
        let end = row + block.nrows();
        let (first, last) = (row / height, end.div_ceil(height));
        let mut cells = self.cells.slice_mut(s![first..last, .., ..]);
        let cells = cells.axis_iter_mut(Axis(0)).into_par_iter();
        cells.enumerate().for_each(|(i, mut cells)| {
            let top = ((first + i) * height).max(row);
            let bottom = ((first + i + 1) * height).min(end);
            for &(number, sign) in numbers {
                // Row by row first: that vectorises, and leaves one row to share out.
                let mut largest = vec![f64::NEG_INFINITY; block.ncols()];
                widest(Largest {
                    block: block.slice(s![top - row..bottom - row, ..]),
                    sign,
                    largest: &mut largest,
                });
                let (mut cells, mut at) = (cells.row_mut(number), 0);
                while at < largest.len() {
                    let cell = (column + at) / width;
                    let end = ((cell + 1) * width - column).min(largest.len());
                    let values = largest[at..end].iter();
                    cells[cell] = values.fold(cells[cell], |old, new| larger(*new, old));
                    at = end;
                }
            }
        });
    }

    /// The cells that hold `part`, whole ones, in at most `limit` larger cells a side.
    fn reduced(&self, (rows, columns): &Part, limit: (usize, usize)) -> MapBuilder {
        let cells = |part: &Range<usize>, block: usize, count: usize| {
            let end = part.end.div_ceil(block).min(count);
            (part.start / block).min(end)..end
        };
        let (all_rows, numbers, all_columns) = self.cells.dim();
        let rows = cells(rows, self.rows, all_rows);
        let columns = cells(columns, self.columns, all_columns);
        let mut reduced = MapBuilder::new((rows.len(), columns.len()), limit, self.keep);
        for number in 0..numbers {
            let cells = s![rows.clone(), number, columns.clone()];
            reduced.collect(&[(number, 1.0)], (0, 0), self.cells.slice(cells));
        }
        reduced.first = (rows.start * self.rows, columns.start * self.columns);
        reduced.rows *= self.rows;
        reduced.columns *= self.columns;
        reduced
    }

    /// The value of each cell; NaN for cells without a number.
    fn cells(&self) -> Array2<f64> {
        let mut cells = self.cells.index_axis(Axis(1), 0).to_owned();
        if self.keep == Keep::Extreme {
            azip!((cell in &mut cells, &minus in &self.cells.index_axis(Axis(1), 1)) {
                *cell = if cell.abs() < minus.abs() { -minus } else { *cell };
            });
        }
        cells.mapv_into(|v| if v == f64::NEG_INFINITY { f64::NAN } else { v })
    }

    /// The same in another unit: every cell times `factor`, which is positive.
    pub fn times(mut self, factor: f64) -> Self {
        self.cells.mapv_inplace(|v| v * factor);
        self
    }

    /// The map, with the coordinates of its first row and column and their steps; with a part of it in finer cells where
    /// these show more.
    ///
    /// Cells are shown in single precision; where their size leaves its range, in units of a power
    /// of ten that the label states.
    pub fn finish(self, part: Option<&Part>, label: String, y: Side, x: Side) -> Map {
        let (rows, _, columns) = self.cells.dim();
        let whole = (0..rows * self.rows, 0..columns * self.columns);
        let overview = self.reduced(&whole, MAP_LIMIT);
        let detail = part.map(|part| self.reduced(part, MAP_LIMIT));
        // Cells of the overview beyond the part count, too: it may hold all of them.
        let size = |map: &MapBuilder| (map.rows, map.columns, map.cells.dim());
        let detail = detail.filter(|part| size(part) != size(&overview));
        let sizes = overview.cells.iter().filter(|v| !v.is_infinite());
        let unit = PowerOfTen::of(sizes.fold(0.0, |largest, v| v.abs().max(largest)));
        let label = unit.label(label);
        Map {
            detail: detail.map(|detail| Box::new(detail.map(unit, &label, y, x))),
            ..overview.map(unit, &label, y, x)
        }
    }

    /// The cells as they are, in this unit.
    fn map(&self, unit: PowerOfTen, label: &str, y: Side, x: Side) -> Map {
        let axis = |(label, origin, step): Side, first: usize, length: usize| MapAxis {
            label: label.to_owned(),
            low: origin + (first as f64 - 0.5) * step,
            high: origin + ((first + length) as f64 - 0.5) * step,
        };
        let bound = |number: usize, sign: f64| {
            let cells = self.cells.index_axis(Axis(1), number);
            cells.mapv(|v| match v.is_infinite() {
                true => f32::NAN,
                false => unit.single(sign * v),
            })
        };
        let (rows, columns) = (self.rows, self.columns);
        let (cell_rows, _, cell_columns) = self.cells.dim();
        let has_range = self.keep == Keep::Extreme && rows * columns > 1;
        Map {
            x: axis(x, self.first.1, cell_columns * columns),
            y: axis(y, self.first.0, cell_rows * rows),
            reduction: match self.keep {
                Keep::Largest => Reduction::Max { rows, columns },
                Keep::Extreme => Reduction::Extreme { rows, columns },
            },
            values: self.cells().mapv(|v| unit.single(v)),
            range: has_range.then(|| [bound(1, -1.0), bound(0, 1.0)]),
            label: label.to_owned(),
            detail: None,
        }
    }
}

/// The larger one; `old` if the other is NaN.
#[inline(always)]
fn larger(new: f64, old: f64) -> f64 {
    if new > old { new } else { old }
}

/// The largest value of each column times a sign.
struct Largest<'a> {
    block: ArrayView2<'a, f64>,
    sign: f64,
    largest: &'a mut [f64],
}

impl SimdKernel for Largest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for row in self.block.outer_iter() {
            let stored = row.to_slice().map(Cow::Borrowed);
            let row = stored.unwrap_or_else(|| Cow::Owned(row.to_vec()));
            for (old, &new) in self.largest.iter_mut().zip(&*row) {
                *old = larger(self.sign * new, *old);
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
            let mut builder = MapBuilder::new((1, 2), (2, 2), Keep::Largest);
            builder.add(0, 0, array![[largest, 0.5 * largest]].view());
            let map = builder.finish(None, "S (m)".into(), ("y", 0.0, 1.0), ("x", 0.0, 1.0));
            assert_eq!(map.label, format!("S ({power} m)"));
            assert!((map.values[[0, 0]] / map.values[[0, 1]] - 2.0).abs() < 1e-6);
            assert!((1.0..10.0).contains(&map.values[[0, 0]]));
        }
    }

    #[test]
    fn of_equal_magnitudes_the_positive_stays_and_no_number_is_none() {
        let nan = f64::NAN;
        let mut map = MapBuilder::new((2, 4), (1, 2), Keep::Extreme);
        let values = array![[-2.0, nan, nan, nan], [2.0, 1.0, nan, nan]];
        map.add(0, 0, values.view());
        let cells = map.cells();
        assert_eq!(cells[[0, 0]], 2.0);
        assert!(cells[[0, 1]].is_nan());
    }
}
