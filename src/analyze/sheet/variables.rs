//! The arrays of an analysis but for the large ones, under the names of the manual.

use super::super::labels::{self, Power};
use super::super::{Analysis, Axes, Moments, ShortTimeSpectra};
use crate::sheet::Sheet;
use crate::unit;

/// Units of the axes of an analysis; empty for a step without one.
struct Units {
    time: String,
    space: String,
    frequency: String,
    wavenumber: String,
}

impl Units {
    fn of(axes: &Axes) -> Units {
        let of = |label: String| unit::split(&label).1.to_owned();
        Units {
            time: of(labels::time(axes)),
            space: axes.space.unit.clone().unwrap_or_default(),
            frequency: axes.frequency_unit(),
            wavenumber: axes.wavenumber_unit(),
        }
    }
}

pub(super) fn add<'a>(analysis: &'a Analysis, sheet: &mut Sheet<'a>) {
    let (axes, units) = (&analysis.axes, &Units::of(&analysis.axes));
    sheet.line("time", "time", &units.time, axes.times());
    sheet.line("position", "position", &units.space, axes.positions());
    for (name, unit, values) in [
        ("frequency", &units.frequency, &axes.frequency),
        ("wavenumber", &units.wavenumber, &axes.wavenumber),
        (
            "wavenumber_signed",
            &units.wavenumber,
            &axes.wavenumber_signed,
        ),
    ] {
        sheet.line(name, name, unit, values);
    }
    let power = Power::of(analysis);
    if let Some(moments) = &analysis.along_space {
        let units = [&*units.frequency, &power.of_site(axes)];
        measures(sheet, ["frequency", "position"], units, moments);
    }
    if let Some(moments) = &analysis.along_time {
        let units = [&*units.wavenumber, &power.of_time(axes)];
        measures(sheet, ["wavenumber", "time"], units, moments);
    }
    if let Some(front) = &analysis.front {
        sheet.line("front_arrival", "position", &units.time, &front.arrival);
        sheet.line(
            "low_frequency_share_front",
            "position",
            "1",
            &front.low_share,
        );
        sheet.line(
            "high_frequency_share_front",
            "position",
            "1",
            &front.high_share,
        );
    }
    if let Some([plus, minus]) = &analysis.direction_by_frequency {
        sheet.line("toward_plus_x_share", "frequency", "1", plus);
        sheet.line("toward_minus_x_share", "frequency", "1", minus);
    }
    dispersion(analysis, units, sheet);
    let [time, space] = [("time", &units.time), ("position", &units.space)];
    if let Some(spectra) = &analysis.short_time {
        let names = [space, ("frequency", &units.frequency), time];
        short(
            sheet,
            "short_time",
            names,
            &power.over_frequency(axes),
            spectra,
        );
    }
    if let Some(spectra) = &analysis.short_space {
        let names = [time, ("wavenumber", &units.wavenumber), space];
        short(
            sheet,
            "short_space",
            names,
            &power.over_wavenumber(axes),
            spectra,
        );
    }
}

/// Measures over bins `what` of each row along an axis; the unit of bins, and the label of energies.
fn measures<'a>(
    sheet: &mut Sheet<'a>,
    [what, axis]: [&str; 2],
    [bin, energy]: [&str; 2],
    m: &'a Moments,
) {
    let of = |ending: &str| format!("{what}_{ending}");
    for (name, unit, values) in [
        (of("centroid"), bin, &m.centroid),
        (of("bandwidth"), bin, &m.bandwidth),
        (of("effective_bandwidth"), bin, &m.effective_bandwidth),
        (of("entropy"), "1", &m.entropy),
        (of("participation"), "1", &m.participation),
        (of("zero_share"), "1", &m.zero_share),
        (of("median"), bin, &m.median),
        (of("90"), bin, &m.quantile_90),
        (format!("low_{what}_share"), "1", &m.low_share),
        (format!("high_{what}_share"), "1", &m.high_share),
        (of("energy"), unit::split(energy).1, &m.energy),
    ] {
        sheet.line(&name, axis, unit, values);
    }
}

/// The dispersion curves, which share their wavenumbers.
fn dispersion<'a>(analysis: &'a Analysis, units: &Units, sheet: &mut Sheet<'a>) {
    let [first, ..] = &analysis.dispersion[..] else {
        return;
    };
    let along = "dispersion_wavenumber";
    sheet.line(along, along, &units.wavenumber, &first.wavenumber);
    let branches = analysis.dispersion.iter().flat_map(|curve| &curve.branches);
    let count = branches.clone().count();
    let dimensions = [
        ("dispersion_branch", count),
        (along, first.wavenumber.len()),
    ];
    let values: Vec<f64> = branches.flatten().copied().collect();
    sheet.variable(
        "dispersion_frequency",
        &dimensions,
        &units.frequency,
        values,
    );
}

/// Short-time spectra `name`, whose axes have these names and units.
fn short<'a>(
    sheet: &mut Sheet<'a>,
    name: &str,
    axes: [(&str, &String); 3],
    label: &str,
    spectra: &'a ShortTimeSpectra,
) {
    let stacked = spectra.stacked();
    let (n, m, s) = stacked.dim();
    let [place, bin, frame] = axes.map(|(axis, unit)| (format!("{name}_{axis}"), unit));
    let dimensions = [(&*place.0, n), (&*bin.0, m), (&*frame.0, s)];
    // A new array is contiguous, in order.
    let values = stacked.into_raw_vec_and_offset().0;
    sheet.variable(
        &format!("{name}_spectrum"),
        &dimensions,
        unit::split(label).1,
        values,
    );
    let places: Vec<f64> = spectra.spectra.iter().map(|one| one.at).collect();
    sheet.line(&bin.0, &bin.0, bin.1, &spectra.bins);
    sheet.line(&frame.0, &frame.0, frame.1, &spectra.frames);
    sheet.line(&place.0, &place.0, place.1, places);
}
