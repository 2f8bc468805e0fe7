//! Maps as data: values over two axes.

use std::ops::Range;

use ndarray::{Array2, ArrayView2};
use serde::Serialize;

/// What an axis counts; picks on a page are shared between axes that count the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    Time,
    Position,
    Frequency,
    Wavenumber,
}

impl Role {
    /// Name and symbol.
    pub(crate) fn words(self) -> [&'static str; 2] {
        match self {
            Role::Time => ["time", "t"],
            Role::Position => ["position", "x"],
            Role::Frequency => ["frequency", "f"],
            Role::Wavenumber => ["wavenumber", "k"],
        }
    }
}

/// What the colours of a map reach over.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Colors {
    /// Linear between two values; if these are symmetric about 0, the colours diverge from it.
    Between(Range<f64>),
    /// As the area sine from `-limit` to `limit`: logarithmic both ways over this many decades.
    Signed { limit: f64, decades: f64 },
    /// Logarithmic, down from the largest value.
    #[default]
    Powers,
}

/// A dashed line over a map, broken where its points are not finite.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// Empty for one that goes on with the one before.
    pub label: String,
    pub points: Vec<(f64, f64)>,
}

impl Colors {
    /// Linear out to `limit`, both ways.
    pub fn about_zero(limit: f64) -> Colors {
        let limit = if limit > 0.0 { limit } else { 1.0 };
        Colors::Between(-limit..limit)
    }
}

/// The largest magnitude in maps when one in two hundred of those that are not 0 is left out; 0 for none.
pub fn ordinary<'m>(maps: impl Iterator<Item = &'m Map>) -> f64 {
    let sizes = maps.flat_map(|map| map.values.iter().map(|value| f64::from(value.abs())));
    let mut sizes: Vec<f64> = sizes.filter(|s| *s > 0.0 && s.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    let kept = (0.995 * sizes.len() as f64).ceil() as usize;
    sizes[..kept].last().copied().unwrap_or(0.0)
}

/// Least positive and largest magnitude of maps.
pub fn magnitudes<'m>(maps: impl Iterator<Item = &'m Map>) -> [f64; 2] {
    let sizes = maps.flat_map(|map| map.values.iter().map(|value| f64::from(value.abs())));
    let sizes = sizes.filter(|size| *size > 0.0 && size.is_finite());
    sizes.fold([f64::INFINITY, 0.0], |[low, high], size| {
        [low.min(size), high.max(size)]
    })
}

/// A large array reduced by blocks for the eye: no sample is dropped.
#[derive(Debug, Clone, Default, PartialEq)]
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
    /// The part within the display limits in finer cells, in the same units; `None` where the map
    /// itself is as fine and ends there.
    pub detail: Option<Box<Map>>,
}

impl Map {
    /// What figures show: the part within the display limits.
    pub fn shown(&self) -> &Map {
        self.detail.as_deref().unwrap_or(self)
    }
}

/// An axis of a [`Map`]: cell edges from `low` to `high`, evenly divided.
#[derive(Debug, Clone, Default, PartialEq)]
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

impl Default for Reduction {
    fn default() -> Self {
        Reduction::Extreme {
            rows: 1,
            columns: 1,
        }
    }
}

impl Reduction {
    /// What of its samples a cell shows.
    #[cfg(feature = "figures")]
    pub(crate) fn shows(self) -> &'static str {
        match self {
            Reduction::Max { .. } => "largest value",
            Reduction::Extreme { .. } => "value of largest magnitude",
        }
    }

    /// Rows and columns of samples in a cell.
    pub fn samples(self) -> (usize, usize) {
        let (Reduction::Max { rows, columns } | Reduction::Extreme { rows, columns }) = self;
        (rows, columns)
    }
}

/// The value of largest magnitude of each block, at most `most_rows` by `most_columns` of them.
///
/// Blocks are as even as whole samples allow; one is NaN only where all its values are.
pub(crate) fn block_extremes<T>(
    values: ArrayView2<T>,
    (most_rows, most_columns): (usize, usize),
) -> Array2<f64>
where
    T: Copy + Into<f64>,
{
    let (rows, columns) = values.dim();
    let shape = (rows.min(most_rows), columns.min(most_columns));
    blocks_of(values, shape, f64::NAN, |most: f64, value| {
        let value: f64 = value.into();
        match most.is_nan() || value.abs() > most.abs() {
            true => value,
            false => most,
        }
    })
}

/// The range of an axis whose cells have these centres.
pub(crate) fn range(centres: &[f64]) -> Range<f64> {
    match centres {
        [] => 0.0..1.0,
        [only] => only - 0.5..only + 0.5,
        [first, second, ..] => {
            let half = (second - first) / 2.0;
            first - half..centres[centres.len() - 1] + half
        }
    }
}

/// A fold over each of so many blocks, row by row.
pub(crate) fn blocks_of<T: Copy, R: Copy>(
    values: ArrayView2<T>,
    shape: (usize, usize),
    start: R,
    fold: impl Fn(R, T) -> R,
) -> Array2<R> {
    let (rows, columns) = values.dim();
    let spans: Vec<Range<usize>> = (0..shape.1).map(|j| block(j, columns, shape.1)).collect();
    let mut out = Array2::from_elem(shape, start);
    for (i, mut cells) in out.rows_mut().into_iter().enumerate() {
        for row in block(i, rows, shape.0) {
            let row = values.row(row);
            for (cell, span) in cells.iter_mut().zip(&spans) {
                *cell = span.clone().fold(*cell, |found, j| fold(found, row[j]));
            }
        }
    }
    out
}

/// Indices of the values of block `index` of `blocks`, as even as whole values allow.
fn block(index: usize, values: usize, blocks: usize) -> Range<usize> {
    index * values / blocks..(index + 1) * values / blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_keep_the_extremes() {
        let values = ndarray::array![[1.0, -5.0, f64::NAN], [2.0, 3.0, f64::NAN]];
        assert_eq!(
            block_extremes(values.view(), (1, 2)),
            ndarray::array![[2.0, -5.0]]
        );
        assert!(block_extremes(values.view(), (2, 3))[[1, 2]].is_nan());
    }
}
