//! Maps finished: the arrays reduced by the passes get their axes and labels.

use super::display::{Display, Extent};
use super::labels::{self, Power};
use super::plan::Plan;
use crate::diagnostics::{Map, MapBuilder};
use crate::field::Field;
use crate::unit;

/// The maps that the passes have collected; none where they are not wanted.
pub(super) struct Maps<M> {
    pub field: Option<M>,
    pub temporal: Option<M>,
    pub spatial: Option<M>,
    pub spacetime: Option<M>,
    pub flux: Option<M>,
}

impl Maps<MapBuilder> {
    /// With their axes; prepared samples count `unit` as 1, and powers are stored in units of the square of `power_unit`.
    pub fn finished(
        self,
        field: &Field,
        plan: &Plan,
        [unit, power_unit]: [f64; 2],
        display: &Display,
    ) -> Maps<Map> {
        let axes = &plan.axes;
        let power = Power::new(
            axes,
            plan.request.scaling,
            field.unit.as_deref(),
            power_unit,
        );
        let name = field.quantity.in_words();
        let samples = unit::label(name, field.unit.as_deref().unwrap_or_default());
        let [df, dk] =
            [&axes.frequency, &axes.wavenumber].map(|bins| bins.get(1).copied().unwrap_or(1.0));
        // Label, first coordinate, step, and the part that is shown.
        type Side<'a> = (&'a str, f64, f64, &'a Extent);
        let [t, x] = [labels::time(axes), labels::position(axes)];
        let [f, k] = [labels::frequency(axes), labels::wavenumber(axes)];
        let time: Side = (&t, axes.time.origin, axes.time.step, &display.time);
        let space: Side = (&x, axes.space.origin, axes.space.step, &display.space);
        let frequency: Side = (&f, 0.0, df, &display.frequency);
        let wavenumber: Side = (&k, 0.0, dk, &display.wavenumber);
        let lowest = axes.wavenumber_signed[0];
        let signed: Side = (&k, lowest, dk, &display.wavenumber_signed);
        let finish = |map: MapBuilder, label: String, y: Side, x: Side| {
            let part = (y.3.bins.clone(), x.3.bins.clone());
            map.finish_with(Some(&part), label, (y.0, y.1, y.2), (x.0, x.1, x.2))
        };
        let of_field = |map: MapBuilder| finish(map.times(unit), samples.clone(), time, space);
        let [of_f, of_k] = [power.over_frequency(), power.over_wavenumber()];
        let [of_both, of_flux] = [power.over_both(), power.flux()];
        Maps {
            field: self.field.map(of_field),
            temporal: self.temporal.map(|map| finish(map, of_f, frequency, space)),
            spatial: self.spatial.map(|map| finish(map, of_k, time, wavenumber)),
            spacetime: self
                .spacetime
                .map(|map| finish(map, of_both, frequency, signed)),
            flux: self.flux.map(|map| finish(map, of_flux, time, wavenumber)),
        }
    }
}
