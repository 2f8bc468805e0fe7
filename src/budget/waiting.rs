//! Rows over time that wait to be handed on together.

use ndarray::ArrayView2;
use rayon::prelude::*;

use crate::arrays::{LargeArray, Sink};
use crate::diagnostics::{Keep, MAP_LIMIT, Map, MapBuilder};
use crate::error::Result;
use crate::numeric::pieces;
use crate::observer::Observer;

/// Samples that are computed before they are added up in order, and handed on together.
pub(super) const BATCH: usize = 64;

/// Arrays that were announced to a sink, and their rows from sample `first` on.
pub(super) struct Waiting<'a> {
    sink: &'a dyn Sink,
    arrays: Vec<WaitingRows>,
    first: usize,
}

struct WaitingRows {
    array: LargeArray,
    columns: usize,
    values: Vec<f64>,
    map: Option<MapBuilder>,
}

impl<'a> Waiting<'a> {
    pub(super) fn new(sink: &'a dyn Sink) -> Waiting<'a> {
        Waiting {
            sink,
            arrays: Vec::new(),
            first: 0,
        }
    }

    /// Announces an array, and what of it a map shows; one without columns is left out.
    pub(super) fn reserve(
        &mut self,
        array: LargeArray,
        shape: (usize, usize),
        shown: Option<Keep>,
    ) -> Result<()> {
        if shape.1 > 0 {
            self.sink.reserve(array, shape)?;
            self.arrays.push(WaitingRows {
                array,
                columns: shape.1,
                values: Vec::new(),
                map: shown.map(|keep| MapBuilder::new(shape, MAP_LIMIT, keep)),
            });
        }
        Ok(())
    }

    /// Adds a row of an array that was announced.
    pub(super) fn push(&mut self, array: LargeArray, row: &[f64]) {
        if let Some(rows) = self.arrays.iter_mut().find(|rows| rows.array == array) {
            rows.values.extend_from_slice(row);
        }
    }

    /// Hands on all rows, which are of samples up to `end`.
    pub(super) fn hand_on(&mut self, end: usize) -> Result<()> {
        for rows in &mut self.arrays {
            let shape = (rows.values.len() / rows.columns, rows.columns);
            if let Ok(block) = ArrayView2::from_shape(shape, &rows.values) {
                self.sink.put(rows.array, self.first, 0, block)?;
                if let Some(map) = &mut rows.map {
                    map.add(self.first, 0, block);
                }
            }
            rows.values.clear();
        }
        self.first = end;
        Ok(())
    }

    /// Evaluates every sample on all threads, then keeps it in order; its rows are handed on batch by batch.
    pub(super) fn each_sample<T: Clone + Send, S>(
        &mut self,
        samples: usize,
        observer: &dyn Observer,
        blank: T,
        scratch: impl Fn() -> S + Sync + Send,
        evaluate: impl Fn(&mut S, usize, &mut T) + Sync + Send,
        mut keep: impl FnMut(&mut Self, usize, &T),
    ) -> Result<()> {
        let mut found = vec![blank; BATCH.min(samples)];
        for batch in pieces(samples, BATCH) {
            observer.go_on()?;
            let places = found.par_iter_mut().zip(batch.clone());
            places.for_each_init(&scratch, |scratch, (found, i)| evaluate(scratch, i, found));
            for (found, i) in found.iter().zip(batch.clone()) {
                keep(self, i, found);
            }
            self.hand_on(batch.end)?;
            observer.advance(batch.len() as u64);
        }
        Ok(())
    }

    /// The map of an array, with label, first and step of its axes; an empty one of an array without columns.
    pub(super) fn map(
        &mut self,
        array: LargeArray,
        label: String,
        y: (&str, f64, f64),
        x: (&str, f64, f64),
    ) -> Map {
        let rows = self.arrays.iter_mut().find(|rows| rows.array == array);
        let map = rows.and_then(|rows| rows.map.take());
        map.map_or_else(Map::default, |map| map.finish(None, label, y, x))
    }
}
