//! Maps finished: the arrays reduced by the passes get their axes and labels.

use super::arrays::Outputs;
use super::display::{Display, Extent};
use super::labels::{self, Power};
use super::plan::Plan;
use crate::arrays::LargeArray;
use crate::diagnostics::{Map, MapBuilder};
use crate::field::Field;
use crate::unit::label;

/// Maps of the field, of `S(f, x)`, `S(k, t)`, `S(k, f)` and the flux, in this order, with their axes; prepared samples count
/// `unit` as 1, and powers are stored in units of the square of `power_unit`.
pub(super) fn finished(
    (of_field, outputs): (Option<MapBuilder>, Outputs),
    field: &Field,
    plan: &Plan,
    [unit, power_unit]: [f64; 2],
    display: &Display,
) -> [Option<Map>; 5] {
    let axes = &plan.axes;
    let power = Power::new(
        axes,
        plan.request.scaling,
        field.unit.as_deref(),
        power_unit,
    );
    let name = field.quantity.in_words();
    let samples = label(name, field.unit.as_deref().unwrap_or_default());
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
    let mut shown = [
        (unit, samples, time, space),
        (1.0, power.over_frequency(), frequency, space),
        (1.0, power.over_wavenumber(), time, wavenumber),
        (1.0, power.over_both(), frequency, signed),
        (1.0, power.flux(), time, wavenumber),
    ]
    .into_iter();
    let [temporal, spatial, spacetime, flux] = outputs.maps([
        LargeArray::TEMPORAL_SPECTRUM,
        LargeArray::SPATIAL_SPECTRUM,
        LargeArray::SPACETIME_SPECTRUM,
        LargeArray::KINETIC_FLUX_SURROGATE,
    ]);
    [of_field, temporal, spatial, spacetime, flux].map(|map| {
        let (unit, label, y, x) = shown.next()?;
        let part = (y.3.bins.clone(), x.3.bins.clone());
        let map = map?.times(unit);
        Some(map.finish(Some(&part), label, (y.0, y.1, y.2), (x.0, x.1, x.2)))
    })
}
