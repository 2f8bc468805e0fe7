//! The arrays of an analysis but for the large ones, under the names of the manual.

use super::super::axes::Side;
use super::super::labels::Power;
use super::super::{Analysis, Moments};
use crate::sheet::Sheet;
use crate::unit;

pub(super) fn add<'a>(analysis: &'a Analysis, sheet: &mut Sheet<'a>) {
    let axes = &analysis.axes;
    let unit_of = |side: Side| side.array_unit(axes);
    for side in Side::ALL {
        let values = side.coordinates(axes);
        sheet.line(side.name(), side.name(), &unit_of(side), values);
    }
    for (moments, sides) in [
        (&analysis.along_space, [Side::Frequency, Side::Space]),
        (&analysis.along_time, [Side::Wavenumber, Side::Time]),
    ] {
        if let Some(moments) = moments {
            let energy = Power::of(analysis).energy(sides[0]);
            measures(sheet, sides, [&unit_of(sides[0]), &energy], moments);
        }
    }
    if let Some(front) = &analysis.front {
        sheet.line(
            "front_arrival",
            "position",
            &unit_of(Side::Time),
            &front.arrival,
        );
        let low: Vec<f64> = front.high_share.iter().map(|high| 1.0 - high).collect();
        sheet.line("low_frequency_share_front", "position", "1", low);
        let high = "high_frequency_share_front";
        sheet.line(high, "position", "1", &front.high_share);
    }
    if let Some([plus, minus]) = &analysis.direction_by_frequency {
        sheet.line("toward_plus_x_share", "frequency", "1", plus);
        sheet.line("toward_minus_x_share", "frequency", "1", minus);
    }
    if let [first, ..] = &analysis.dispersion[..] {
        // The dispersion curves share their wavenumbers.
        let along = "dispersion_wavenumber";
        let [f, k] = [Side::Frequency, Side::Wavenumber].map(unit_of);
        sheet.line(along, along, &k, &first.wavenumber);
        let branches = analysis.dispersion.iter().flat_map(|curve| &curve.branches);
        let count = branches.clone().count();
        let dimensions = [
            ("dispersion_branch", count),
            (along, first.wavenumber.len()),
        ];
        let values: Vec<f64> = branches.flatten().copied().collect();
        sheet.variable("dispersion_frequency", &dimensions, &f, values);
    }
    for (name, spectra, sides) in [
        (
            "short_time",
            &analysis.short_time,
            [Side::Space, Side::Frequency, Side::Time],
        ),
        (
            "short_space",
            &analysis.short_space,
            [Side::Time, Side::Wavenumber, Side::Space],
        ),
    ] {
        let Some(spectra) = spectra else { continue };
        let places = [&spectra.at, &spectra.bins, &spectra.frames];
        let names = sides.map(|side| format!("{name}_{}", side.name()));
        let dimensions = [0, 1, 2].map(|n| (&*names[n], places[n].len()));
        let label = Power::of(analysis).density(&sides);
        let values = spectra.values.as_slice().expect("whole");
        let name = format!("{name}_spectrum");
        sheet.variable(&name, &dimensions, unit::split(&label).1, values);
        for n in [1, 2, 0] {
            sheet.line(&names[n], &names[n], &unit_of(sides[n]), places[n]);
        }
    }
}

/// Measures over bins `what` of each row along an axis; the unit of bins, and the label of energies.
fn measures<'a>(sheet: &mut Sheet<'a>, sides: [Side; 2], [bin, energy]: [&str; 2], m: &'a Moments) {
    let [what, axis] = sides.map(Side::name);
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
