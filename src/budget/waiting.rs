//! Rows over time that wait to be handed on together.

use ndarray::ArrayView2;

use crate::arrays::{LargeArray, Sink};
use crate::diagnostics::{MAP_LIMIT, Map, MapBuilder};
use crate::error::Result;

/// Arrays that were announced to a sink.
#[derive(Default)]
pub(super) struct Waiting(Vec<WaitingRows>);

struct WaitingRows {
    array: LargeArray,
    columns: usize,
    values: Vec<f64>,
    map: Option<MapBuilder>,
}

/// The part of an array that is kept for pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ShownArray {
    Not,
    Largest,
    Extreme,
}

impl Waiting {
    /// Announces an array; one without columns is left out.
    pub(super) fn reserve(
        &mut self,
        sink: &dyn Sink,
        array: LargeArray,
        shape: (usize, usize),
        shown: ShownArray,
    ) -> Result<()> {
        if shape.1 > 0 {
            sink.reserve(array, shape)?;
            self.0.push(WaitingRows {
                array,
                columns: shape.1,
                values: Vec::new(),
                map: match shown {
                    ShownArray::Not => None,
                    ShownArray::Largest => Some(MapBuilder::largest(shape, MAP_LIMIT)),
                    ShownArray::Extreme => Some(MapBuilder::extreme(shape, MAP_LIMIT)),
                },
            });
        }
        Ok(())
    }

    /// Adds a row of an array that was announced.
    pub(super) fn push(&mut self, array: LargeArray, row: &[f64]) {
        if let Some(rows) = self.0.iter_mut().find(|rows| rows.array == array) {
            rows.values.extend_from_slice(row);
        }
    }

    /// Hands all rows on, the first of them that of sample `first`.
    pub(super) fn hand_on(&mut self, sink: &dyn Sink, first: usize) -> Result<()> {
        for rows in &mut self.0 {
            let shape = (rows.values.len() / rows.columns, rows.columns);
            if let Ok(block) = ArrayView2::from_shape(shape, &rows.values) {
                sink.put(rows.array, first, 0, block)?;
                if let Some(map) = &mut rows.map {
                    map.add(first, 0, block);
                }
            }
            rows.values.clear();
        }
        Ok(())
    }

    /// The map of an array, with label, first and step of its axes.
    pub(super) fn map(
        &mut self,
        array: LargeArray,
        label: String,
        y: (&str, f64, f64),
        x: (&str, f64, f64),
    ) -> Option<Map> {
        let rows = self.0.iter_mut().find(|rows| rows.array == array)?;
        Some(rows.map.take()?.finish(label, y, x))
    }
}
