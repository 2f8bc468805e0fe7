//! Named large arrays, and the sinks they go to block by block.

use std::collections::BTreeMap;
use std::sync::Mutex;

use ndarray::{Array2, ArrayView2, s};

use crate::error::Result;
use crate::system::lock;

/// A named array too large to be held twice. The names belong to those that compute the arrays:
/// [`mod@crate::analyze`] and [`mod@crate::budget`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct LargeArray {
    name: &'static str,
    axes: [&'static str; 2],
}

impl LargeArray {
    pub(crate) const fn new(name: &'static str, axes: [&'static str; 2]) -> LargeArray {
        LargeArray { name, axes }
    }

    /// Name in files and messages.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// What its rows and columns count: the names of the arrays that hold their coordinates.
    pub fn axes(self) -> [&'static str; 2] {
        self.axes
    }
}

/// Number type of transforms and of the arrays written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    #[default]
    F64,
    F32,
}

/// Takes the large arrays in blocks: memory ([`Arrays`]) or a file ([`crate::report::Archive`],
/// [`crate::report::NetCdf`]).
pub trait Sink: Sync {
    /// Announces an array and its shape, before its first block.
    ///
    /// # Errors
    /// If there is no room for it.
    fn reserve(&self, array: LargeArray, shape: (usize, usize)) -> Result<()>;

    /// Takes the block whose first element is `(row, column)`.
    ///
    /// # Errors
    /// If it cannot be written.
    fn put(
        &self,
        array: LargeArray,
        row: usize,
        column: usize,
        block: ArrayView2<f64>,
    ) -> Result<()>;
}

/// Writes a block whose first element is `(row, column)` of an array of `columns` columns, in runs that are
/// contiguous there: `write` takes the index of the first element and the samples.
///
/// # Errors
/// Those of `write`.
pub(crate) fn in_runs(
    block: ArrayView2<f64>,
    (row, column): (usize, usize),
    columns: usize,
    mut write: impl FnMut(usize, &[f64]) -> Result<()>,
) -> Result<()> {
    if let Some(rows) = block.as_slice().filter(|_| block.ncols() == columns) {
        return write(row * columns, rows);
    }
    for (i, line) in block.outer_iter().enumerate() {
        let first = (row + i) * columns + column;
        match line.as_slice() {
            Some(values) => write(first, values)?,
            None => write(first, &line.to_vec())?,
        }
    }
    Ok(())
}

/// Large arrays in memory.
pub type Arrays = BTreeMap<LargeArray, Array2<f64>>;

/// Collects [`Arrays`].
#[derive(Debug, Default)]
pub(crate) struct Collect(Mutex<Arrays>);

impl Collect {
    pub fn into_arrays(self) -> Arrays {
        std::mem::take(&mut *lock(&self.0))
    }
}

impl Sink for Collect {
    fn reserve(&self, array: LargeArray, shape: (usize, usize)) -> Result<()> {
        lock(&self.0).insert(array, Array2::zeros(shape));
        Ok(())
    }

    fn put(
        &self,
        array: LargeArray,
        row: usize,
        column: usize,
        block: ArrayView2<f64>,
    ) -> Result<()> {
        if let Some(whole) = lock(&self.0).get_mut(&array) {
            let (rows, columns) = block.dim();
            whole
                .slice_mut(s![row..row + rows, column..column + columns])
                .assign(&block);
        }
        Ok(())
    }
}

/// A sink that keeps nothing, for results without their large arrays.
#[derive(Debug, Clone, Copy, Default)]
pub struct Nowhere;

impl Sink for Nowhere {
    fn reserve(&self, _: LargeArray, _: (usize, usize)) -> Result<()> {
        Ok(())
    }

    fn put(&self, _: LargeArray, _: usize, _: usize, _: ArrayView2<f64>) -> Result<()> {
        Ok(())
    }
}
