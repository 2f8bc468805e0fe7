//! The large arrays of an analysis.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use ndarray::ArrayView2;

use super::axes::{Axes, Side};
use super::display::Display;
use super::plan::Plan;
use super::request::Results;
use crate::arrays::{LargeArray, Sink};
use crate::diagnostics::{Keep, Map, MapBuilder};
use crate::error::Result;
use crate::system::lock;

/// Arrays of an analysis.
impl LargeArray {
    /// `(time, site)`: the field, of which there is a map alone.
    pub const SAMPLES: LargeArray = LargeArray::new("samples", ["time", "position"]);
    /// `(frequency, site)`
    pub const TEMPORAL_SPECTRUM: LargeArray =
        LargeArray::new("temporal_spectrum", ["frequency", "position"]);
    /// `(time, wavenumber)`
    pub const SPATIAL_SPECTRUM: LargeArray =
        LargeArray::new("spatial_spectrum", ["time", "wavenumber"]);
    /// `(frequency, signed wavenumber)`
    pub const SPACETIME_SPECTRUM: LargeArray =
        LargeArray::new("spacetime_spectrum", ["frequency", "wavenumber_signed"]);
    /// `(time, wavenumber)`
    pub const KINETIC_FLUX_SURROGATE: LargeArray =
        LargeArray::new("kinetic_flux_surrogate", ["time", "wavenumber"]);

    /// Those of an analysis.
    pub(crate) const OF_ANALYSES: [LargeArray; 4] = [
        LargeArray::TEMPORAL_SPECTRUM,
        LargeArray::SPATIAL_SPECTRUM,
        LargeArray::SPACETIME_SPECTRUM,
        LargeArray::KINETIC_FLUX_SURROGATE,
    ];
}

impl Results {
    pub(super) fn has(self, array: LargeArray) -> bool {
        match array {
            LargeArray::TEMPORAL_SPECTRUM => self.temporal,
            LargeArray::SPATIAL_SPECTRUM => self.spatial,
            LargeArray::SPACETIME_SPECTRUM => self.spacetime,
            _ => self.flux_surrogate,
        }
    }
}

/// The large arrays that are wanted on their way to the sink, block by block, with their maps.
pub(super) struct Outputs<'a> {
    sink: &'a dyn Sink,
    /// None where no maps are wanted.
    maps: BTreeMap<LargeArray, Mutex<MapBuilder>>,
}

impl<'a> Outputs<'a> {
    pub fn new(plan: &Plan, sink: &'a dyn Sink) -> Result<Self> {
        for &(array, shape) in &plan.arrays {
            sink.reserve(array, shape)?;
        }
        let map = |(array, shape)| {
            let (limit, keep) = (plan.map_limit(array, shape), keep(array));
            (array, Mutex::new(MapBuilder::new(shape, limit, keep)))
        };
        let maps = plan.mapped().map(map).collect();
        Ok(Outputs { sink, maps })
    }

    /// Passes on the block whose first number is that of this row and column.
    pub fn put(
        &self,
        array: LargeArray,
        (row, column): (usize, usize),
        block: ArrayView2<f64>,
    ) -> Result<()> {
        self.show(array, (row, column), block);
        self.sink.put(array, row, column, block)
    }

    /// Adds a block to its map alone. Blocks of an array come one at a time, so that nobody waits for it.
    pub fn show(&self, array: LargeArray, (row, column): (usize, usize), block: ArrayView2<f64>) {
        if let Some(map) = self.maps.get(&array) {
            lock(map).add(row, column, block);
        }
    }

    /// The maps with the parts of them that are shown; `label` says what they hold, and `unit` is that of the samples.
    pub fn finish(
        self,
        axes: &Axes,
        display: &Display,
        label: impl Fn(LargeArray) -> String,
        unit: f64,
    ) -> BTreeMap<LargeArray, Map> {
        let finish = |(array, map): (LargeArray, Mutex<MapBuilder>)| {
            let map = map.into_inner().unwrap_or_else(PoisonError::into_inner);
            let map = match array == LargeArray::SAMPLES {
                true => map.times(unit),
                false => map,
            };
            let sides = Side::of(array);
            let [rows, columns] = sides.map(|side| display.part(side).bins.clone());
            let labels = sides.map(|side| side.label(axes));
            let along = |n: usize| {
                let grid = sides[n].grid(axes);
                (&*labels[n], grid.first, grid.step)
            };
            let part = Some(&(rows, columns));
            let map = map.finish(part, label(array), along(0), along(1));
            (array, map)
        };
        self.maps.into_iter().map(finish).collect()
    }
}

/// What maps of an array show: of what has signs, the extremes.
pub(super) fn keep(array: LargeArray) -> Keep {
    match array {
        LargeArray::SAMPLES | LargeArray::KINETIC_FLUX_SURROGATE => Keep::Extreme,
        _ => Keep::Largest,
    }
}
