//! Large arrays reduced for the eye, block by block.

use ndarray::{Array2, ArrayView2};

use crate::analyze::{Map, MapAxis, Reduction};

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
    cells: Array2<f32>,
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
        MapBuilder {
            cells: Array2::from_elem(cells, f32::NAN),
            rows,
            columns,
            keep,
        }
    }

    /// Takes in the block whose first element is `(row, column)` of the whole.
    pub fn add(&mut self, row: usize, column: usize, block: ArrayView2<f64>) {
        for (i, line) in block.outer_iter().enumerate() {
            let mut cells = self.cells.row_mut((row + i) / self.rows);
            for (j, &value) in line.iter().enumerate() {
                let cell = &mut cells[(column + j) / self.columns];
                let value = value as f32;
                let better = match self.keep {
                    Keep::Largest => value > *cell,
                    Keep::Extreme => {
                        value.abs() > cell.abs() || (value.abs() == cell.abs() && value > *cell)
                    }
                };
                if better || cell.is_nan() {
                    *cell = value;
                }
            }
        }
    }

    /// The map, with the coordinates of its first row and column and their steps.
    pub fn finish(self, label: String, y: (&str, f64, f64), x: (&str, f64, f64)) -> Map {
        let axis = |(label, first, step): (&str, f64, f64), cells: usize, block: usize| MapAxis {
            label: label.to_owned(),
            low: first - 0.5 * step,
            high: first + ((cells * block) as f64 - 0.5) * step,
        };
        let (rows, columns) = self.cells.dim();
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
            values: self.cells,
            label,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

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
        assert_eq!(once.cells, parts.cells);
        assert_eq!(once.cells, array![[-5.0f32, 2.0], [4.0, 0.5]]);
    }
}
