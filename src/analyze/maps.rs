//! Maps finished: the arrays reduced by the passes get their axes and labels.

use super::display::{Display, Extent};
use super::labels::{self, Power};
use super::plan::Plan;
use crate::diagnostics::{Map, MapBuilder};
use crate::field::Field;
use crate::unit;

/// What the labels are made of.
pub(super) struct Maps<'a> {
    pub field: &'a Field,
    pub plan: &'a Plan,
    /// What prepared samples count as 1.
    pub unit: f64,
    /// Powers are stored in units of its square.
    pub power_unit: f64,
    pub display: &'a Display,
}

/// An axis of a map.
#[derive(Clone, Copy)]
enum MapSide {
    Time,
    Space,
    Frequency,
    Wavenumber,
    SignedWavenumber,
}

impl Maps<'_> {
    pub fn field(&self, map: MapBuilder) -> Map {
        let name = labels::quantity(self.field.quantity);
        let label = unit::label(name, self.field.unit.as_deref().unwrap_or_default());
        self.finish(map.times(self.unit), label, MapSide::Time, MapSide::Space)
    }

    pub fn temporal(&self, map: MapBuilder) -> Map {
        let label = self.power().over_frequency(&self.plan.axes);
        self.finish(map, label, MapSide::Frequency, MapSide::Space)
    }

    pub fn spatial(&self, map: MapBuilder) -> Map {
        let label = self.power().over_wavenumber(&self.plan.axes);
        self.finish(map, label, MapSide::Time, MapSide::Wavenumber)
    }

    pub fn spacetime(&self, map: MapBuilder) -> Map {
        let label = self.power().over_both(&self.plan.axes);
        self.finish(map, label, MapSide::Frequency, MapSide::SignedWavenumber)
    }

    pub fn flux(&self, map: MapBuilder) -> Map {
        let label = self.power().flux(&self.plan.axes);
        self.finish(map, label, MapSide::Time, MapSide::Wavenumber)
    }

    fn power(&self) -> Power<'_> {
        Power {
            scaling: self.plan.request.scaling,
            unit: self.field.unit.as_deref(),
            amplitude: self.power_unit,
        }
    }

    fn finish(&self, map: MapBuilder, label: String, y: MapSide, x: MapSide) -> Map {
        let ((y_label, y0, dy), (x_label, x0, dx)) = (self.axis(y), self.axis(x));
        let part = Display::part(self.extent(y), self.extent(x));
        map.finish_with(Some(&part), label, (&y_label, y0, dy), (&x_label, x0, dx))
    }

    fn extent(&self, side: MapSide) -> &Extent {
        match side {
            MapSide::Time => &self.display.time,
            MapSide::Space => &self.display.space,
            MapSide::Frequency => &self.display.frequency,
            MapSide::Wavenumber => &self.display.wavenumber,
            MapSide::SignedWavenumber => &self.display.wavenumber_signed,
        }
    }

    /// Label, first coordinate and step.
    fn axis(&self, side: MapSide) -> (String, f64, f64) {
        let axes = &self.plan.axes;
        let step = |bins: &[f64]| bins.get(1).copied().unwrap_or(1.0);
        match side {
            MapSide::Time => (labels::time(axes), axes.time.origin, axes.time.step),
            MapSide::Space => (labels::position(axes), axes.space.origin, axes.space.step),
            MapSide::Frequency => (labels::frequency(axes), 0.0, step(&axes.frequency)),
            MapSide::Wavenumber => (labels::wavenumber(axes), 0.0, step(&axes.wavenumber)),
            MapSide::SignedWavenumber => (
                labels::wavenumber(axes),
                axes.wavenumber_signed[0],
                step(&axes.wavenumber),
            ),
        }
    }
}
