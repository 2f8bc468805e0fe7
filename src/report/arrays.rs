//! The arrays of an analysis with their labels: axes, measures along x and t, short-time spectra.

use serde_json::Value;

use super::netcdf::{ArrayLabels, Attribute, NetCdf};
use super::{Archive, Provenance, Summary};
use crate::analyze::labels::{self, Power};
use crate::analyze::{Analysis, Axes, Moments, ShortTimeSpectra};
use crate::error::Result;
use crate::unit;

/// Appends everything of `analysis` that is an array to `archive`, under the names of the manual.
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_small_arrays(analysis: &Analysis, archive: &Archive) -> Result<()> {
    each_small_array(analysis, &mut |labels, values| {
        archive.append(labels.name, &labels.shape(), values)
    })
}

/// Takes arrays with their labels, and values that belong to all of them: a file ([`NetCdf`]), or memory.
pub trait LabelledArrays {
    /// Takes an array, row-major.
    ///
    /// # Errors
    /// If it cannot be kept.
    fn append(&self, labels: &ArrayLabels, values: &[f64]) -> Result<()>;

    /// Adds values to the array of this name, if there is one.
    fn describe(&self, array: &str, attributes: Vec<(&str, Attribute)>);

    /// Adds a value that belongs to all arrays.
    fn attribute(&self, name: &str, value: Attribute);
}

impl LabelledArrays for NetCdf {
    fn append(&self, labels: &ArrayLabels, values: &[f64]) -> Result<()> {
        NetCdf::append(self, labels, values)
    }

    fn describe(&self, array: &str, attributes: Vec<(&str, Attribute)>) {
        NetCdf::describe(self, array, attributes);
    }

    fn attribute(&self, name: &str, value: Attribute) {
        NetCdf::attribute(self, name, value);
    }
}

/// Appends everything of `analysis` that is an array to `file`, under the same names, the axes as named
/// dimensions with their coordinates, and units to all arrays, those of the [`Sink`] too; conventions,
/// residuals and provenance are attributes of the file. What `summary.json` nests is a text in JSON.
///
/// [`Sink`]: crate::arrays::Sink
///
/// # Errors
/// [`crate::Error::Write`].
pub fn write_labelled_arrays(
    analysis: &Analysis,
    provenance: &Provenance,
    file: &dyn LabelledArrays,
) -> Result<()> {
    each_small_array(analysis, &mut |labels, values| file.append(labels, values))?;
    let (axes, power) = (&analysis.axes, Power::of(analysis));
    for (array, label) in [
        ("temporal_spectrum", power.over_frequency(axes)),
        ("spatial_spectrum", power.over_wavenumber(axes)),
        ("spacetime_spectrum", power.over_both(axes)),
        ("kinetic_flux_surrogate", power.flux(axes)),
    ] {
        let (name, unit) = unit::split(&label);
        file.describe(array, text_attributes(unit, name));
    }
    let summary = serde_json::to_value(Summary::new(analysis, provenance)).unwrap_or_default();
    let parts = [
        ("provenance", ""),
        ("field", ""),
        ("conventions", ""),
        ("parseval", "parseval_"),
    ];
    describe_file(&summary, &parts, file);
    Ok(())
}

/// The unit and the name of an array as attributes, those of them that it has.
pub(super) fn text_attributes<'a>(unit: &str, about: &str) -> Vec<(&'a str, Attribute)> {
    let texts = [("units", unit), ("long_name", about)].into_iter();
    let texts = texts.filter(|(_, text)| !text.is_empty());
    texts
        .map(|(name, text)| (name, Attribute::Text(text.into())))
        .collect()
}

/// The numbers and texts of these parts of a summary as attributes of the file, their names behind a prefix.
pub(super) fn describe_file(summary: &Value, parts: &[(&str, &str)], file: &dyn LabelledArrays) {
    for &(part, prefix) in parts {
        for (name, value) in summary[part].as_object().into_iter().flatten() {
            if let Some(value) = attribute(value) {
                file.attribute(&format!("{prefix}{name}"), value);
            }
        }
    }
    if let Some(schema) = attribute(&summary["schema"]) {
        file.attribute("schema", schema);
    }
}

/// A part of the summary as an attribute; nothing for what is not known.
fn attribute(value: &Value) -> Option<Attribute> {
    Some(match value {
        Value::Null => return None,
        Value::String(text) => Attribute::Text(text.clone()),
        Value::Number(number) => match number.as_i64().and_then(|n| i32::try_from(n).ok()) {
            Some(integer) => Attribute::Integer(integer),
            None => Attribute::Number(number.as_f64()?),
        },
        nested => Attribute::Text(nested.to_string()),
    })
}

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

type Add<'a> = &'a mut dyn FnMut(&ArrayLabels, &[f64]) -> Result<()>;

/// Hands over every array but the large ones.
fn each_small_array(analysis: &Analysis, add: Add) -> Result<()> {
    let (axes, units) = (&analysis.axes, &Units::of(&analysis.axes));
    let mut line = |name: &str, axis: &str, unit: &str, values: &[f64]| {
        let labels = ArrayLabels {
            name,
            axes: &[(axis, values.len())],
            unit,
            about: "",
        };
        add(&labels, values)
    };
    line("time", "time", &units.time, &axes.times())?;
    line("position", "position", &units.space, &axes.positions())?;
    for (name, unit, values) in [
        ("frequency", &units.frequency, &axes.frequency),
        ("wavenumber", &units.wavenumber, &axes.wavenumber),
        (
            "wavenumber_signed",
            &units.wavenumber,
            &axes.wavenumber_signed,
        ),
    ] {
        line(name, name, unit, values)?;
    }
    let power = Power::of(analysis);
    for (what, axis, moments, unit, label) in [
        (
            "frequency",
            "position",
            &analysis.along_space,
            &units.frequency,
            power.of_site(axes),
        ),
        (
            "wavenumber",
            "time",
            &analysis.along_time,
            &units.wavenumber,
            power.of_time(axes),
        ),
    ] {
        let Some(moments) = moments else { continue };
        for (name, unit, values) in measures(what, moments, [unit, unit::split(&label).1]) {
            line(&name, axis, unit, values)?;
        }
    }
    if let Some(front) = &analysis.front {
        line("front_arrival", "position", &units.time, &front.arrival)?;
        line(
            "low_frequency_share_front",
            "position",
            "1",
            &front.low_share,
        )?;
        line(
            "high_frequency_share_front",
            "position",
            "1",
            &front.high_share,
        )?;
    }
    if let Some([plus, minus]) = &analysis.direction_by_frequency {
        line("toward_plus_x_share", "frequency", "1", plus)?;
        line("toward_minus_x_share", "frequency", "1", minus)?;
    }
    dispersion(analysis, units, add)?;
    let [time, space] = [&units.time, &units.space];
    if let Some(spectra) = &analysis.short_time {
        let names = [
            ("position", space),
            ("frequency", &units.frequency),
            ("time", time),
        ];
        short(
            add,
            "short_time",
            names,
            power.over_frequency(axes),
            spectra,
        )?;
    }
    if let Some(spectra) = &analysis.short_space {
        let names = [
            ("time", time),
            ("wavenumber", &units.wavenumber),
            ("position", space),
        ];
        short(
            add,
            "short_space",
            names,
            power.over_wavenumber(axes),
            spectra,
        )?;
    }
    Ok(())
}

/// Names, units and values of measures over bins; the units are those of bins and of energies.
fn measures<'a>(
    what: &str,
    m: &'a Moments,
    [bin, energy]: [&'a str; 2],
) -> [(String, &'a str, &'a [f64]); 11] {
    let of = |ending: &str| format!("{what}_{ending}");
    [
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
        (of("energy"), energy, &m.energy),
    ]
}

/// The dispersion curves, which share their wavenumbers.
fn dispersion(analysis: &Analysis, units: &Units, add: Add) -> Result<()> {
    let [first, ..] = &analysis.dispersion[..] else {
        return Ok(());
    };
    let along = ("dispersion_wavenumber", first.wavenumber.len());
    let wavenumber = ArrayLabels {
        name: "dispersion_wavenumber",
        axes: &[along],
        unit: &units.wavenumber,
        about: "",
    };
    add(&wavenumber, &first.wavenumber)?;
    let curves = analysis.dispersion.iter();
    let branches: Vec<&Vec<f64>> = curves.flat_map(|curve| &curve.branches).collect();
    let frequency = ArrayLabels {
        name: "dispersion_frequency",
        axes: &[("dispersion_branch", branches.len()), along],
        unit: &units.frequency,
        about: "",
    };
    let values: Vec<f64> = branches.into_iter().flatten().copied().collect();
    add(&frequency, &values)
}

/// Short-time spectra `name`, whose axes have these names and units.
fn short(
    add: Add,
    name: &str,
    axes: [(&str, &String); 3],
    label: String,
    spectra: &ShortTimeSpectra,
) -> Result<()> {
    let stacked = spectra.stacked();
    let (n, m, s) = stacked.dim();
    let names = axes.map(|(axis, _)| format!("{name}_{axis}"));
    let (about, unit) = unit::split(&label);
    let labels = ArrayLabels {
        name: &format!("{name}_spectrum"),
        axes: &[(&names[0], n), (&names[1], m), (&names[2], s)],
        unit,
        about,
    };
    // A new array is contiguous, in order.
    add(&labels, stacked.as_slice().unwrap_or_default())?;
    let places: Vec<f64> = spectra.spectra.iter().map(|one| one.at).collect();
    let values = [&places, &spectra.bins, &spectra.frames];
    // In the order of the archives of earlier versions.
    for i in [1, 2, 0] {
        let labels = ArrayLabels {
            name: &names[i],
            axes: &[(&names[i], values[i].len())],
            unit: axes[i].1,
            about: "",
        };
        add(&labels, values[i])?;
    }
    Ok(())
}
