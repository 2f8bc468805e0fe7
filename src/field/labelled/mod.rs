//! Fields in files of named arrays with dimensions and coordinates: HDF5, NetCDF, MATLAB, SEG-Y, TDMS
//! and others.
//!
//! `choose` decides which variable is the field and which of its dimensions are times and sites, `axes`
//! what their coordinates say, `load` where the samples are, `delays` what becomes of traces that begin at
//! different times.

mod axes;
mod choose;
mod delays;
mod load;

use std::collections::BTreeMap;
use std::sync::Arc;

use wavecascade_formats::{Attributes, Container, Format, Options, Remark, Value};

use super::beside::{self, Beside};
use super::file_bytes::FileBytes;
use super::open::{Contents, FileSource};
use super::options::{Delays, Label};
use super::scan::NamedNumber;
use super::storage::Packing;
use super::{Note, Quantity, graded_masses, names};
use crate::error::{Error, InputFault, Result};
use crate::measure::{self, Length};

use axes::AxisFault;
pub(super) use axes::dated;
use choose::Choice;
pub(super) use choose::{Places, dimensions, nearest};

/// Texts, and arrays with their shapes, by their names.
pub(crate) type Parts = (
    BTreeMap<String, String>,
    BTreeMap<String, (Vec<u64>, Vec<f64>)>,
);

/// The field of a file of `format`.
pub(super) fn read(source: &FileSource, format: Format) -> Result<Contents> {
    let container = open(source, format)?;
    let choice = Choice::of(&container, source.options, source.stated.layout)
        .map_err(|fault| source.fault(fault))?;
    let (n_times, n_sites) = (choice.n_times(&container)?, choice.n_sites(&container)?);
    let storage = load::storage(source, &container, &choice)?;
    let variable = &container.variables[choice.variable];
    let attributes = &variable.attributes;
    // What this program wrote says itself what is the field.
    let own = own_schema(&container);
    let mut notes = match own {
        Some(_) => Vec::new(),
        None => vec![choice.note(&container)],
    };
    notes.extend(choice.notes.iter().cloned());
    let of_it = |remark: &&Remark| remark.variable.is_none_or(|about| about == choice.variable);
    let remarks = container.remarks.iter().filter(of_it);
    notes.extend(remarks.map(|remark| Note::Remark {
        text: remark.text.clone(),
    }));
    let stated = &source.stated;
    let axis_of = |axis, place: Option<&choose::Place>, is_stated: bool| {
        let rules = (!is_stated).then(|| source.options.evenness(axis));
        axes::coordinates(&container, axis, place, rules).map_err(|fault| match fault {
            AxisFault::Container(fault) => source.container_fault(fault),
            AxisFault::Input(fault) => source.fault(fault),
        })
    };
    let (time, time_notes) = axis_of("time", choice.times(), stated.dt.is_some())?;
    let (space, space_notes) = axis_of("space", choice.sites(), stated.dx.is_some())?;
    notes.extend(time_notes);
    notes.extend(space_notes);
    // Times that count from a date say so themselves.
    let is_dated = |note: &Note| matches!(note, Note::Start { .. });
    if let Some(start) = attributes.text("start_time")
        && matches!(format, Format::Tdms | Format::MiniSeed)
        && !notes.iter().any(is_dated)
    {
        let time = start.to_owned();
        notes.push(Note::Start { time });
    }
    let unit = attributes.text("units").map(str::to_owned);
    let quantity = quantity(
        &variable.path,
        attributes.text("standard_name"),
        unit.as_deref(),
    );
    let mut contents = Contents {
        time: time.even,
        space: space.even,
        resampling: [time.resampling, space.resampling],
        quantity,
        unit,
        notes,
        axis_names: [choice.times(), choice.sites()]
            .map(|place| Some(choose::last_name(place?.name.as_deref()?).to_owned())),
        ..Contents::of(storage.packed(packing(variable)), [n_times, n_sites])
    };
    if own.is_none() {
        let mut find = |name: &str| {
            stated_beside(&container, choice.variable, name)
                .map_err(|fault| source.container_fault(fault))
        };
        beside::complete(&mut contents, stated, &mut find)?;
    } else {
        let attributes = &container.attributes;
        contents.dispersion = attributes.text("dispersion").map(str::to_owned);
        contents.struck = match attributes.get("struck_site") {
            Some(Value::Integers(sites)) => sites.first().and_then(|&site| site.try_into().ok()),
            _ => None,
        };
        contents.struck = contents.struck.filter(|site| *site < n_sites);
        contents.masses =
            masses(&container, n_sites).map_err(|fault| source.container_fault(fault))?;
    }
    contents.note_doubts(choice.is_layout_known || stated.layout.is_some());
    if attributes.get("delays").is_none() {
        return Ok(contents);
    }
    match source.options.delays {
        Delays::Ignore => {
            contents.notes.push(Note::Delays);
            Ok(contents)
        }
        treated => delays::aligned(source, &container, contents, treated),
    }
}

/// The masses of a graded chain of `n_sites` bodies, of a run.
fn masses(container: &Container, n_sites: usize) -> wavecascade_formats::Result<Option<Vec<f64>>> {
    let numbers = |name| {
        container
            .find(name)
            .map(|i| container.numbers(i))
            .transpose()
    };
    let bodies = numbers("mass")?.zip(numbers("contact_coefficient")?);
    let bodies = bodies.filter(|(masses, _)| masses.len() == n_sites);
    Ok(bodies.and_then(|(masses, coefficients)| graded_masses(&masses, &coefficients)))
}

/// What the attributes of a variable, else its group or struct, else the groups around it state under a name:
/// an attribute or a variable of one number.
fn stated_beside(
    container: &Container,
    variable: usize,
    name: &str,
) -> wavecascade_formats::Result<Option<Beside>> {
    let path = container.variables[variable].path.trim_start_matches('/');
    let of = |attributes: &Attributes, found: &str| match attributes.text(found) {
        Some(text) => Some(beside::Value::Text(text.to_owned())),
        None => attributes.number(found).map(beside::Value::Number),
    };
    let attribute = |attributes: &Attributes, wanted: &str| {
        let mut names = attributes.0.iter().map(|(found, _)| found.clone());
        let found = names.find(|found| found.eq_ignore_ascii_case(wanted))?;
        of(attributes, &found).map(|value| (found, value))
    };
    if let Some((found, value)) = attribute(&container.variables[variable].attributes, name) {
        let place = format!("{path}/{found}");
        return Ok(Some(Beside { place, value }));
    }
    let mut group = path;
    while let Some(end) = group.rfind(['/', '.']).or((!group.is_empty()).then_some(0)) {
        let prefix = &path[..end + usize::from(end > 0)];
        group = &path[..end];
        let wanted = format!("{prefix}{name}");
        if let Some((place, value)) = attribute(&container.attributes, &wanted) {
            return Ok(Some(Beside { place, value }));
        }
        for (i, other) in container.variables.iter().enumerate() {
            let place = other.path.trim_start_matches('/');
            let is_number = other.count() == Some(1) && other.sample_type.number().is_some();
            if is_number && place.eq_ignore_ascii_case(&wanted) {
                let value = beside::Value::Number(unpacked(container, i)?[0]);
                return Ok(Some(Beside {
                    place: place.to_owned(),
                    value,
                }));
            }
        }
    }
    Ok(None)
}

/// Single numbers of a file that may be the position of its record: attributes of the field and of the file,
/// variables of one number.
pub(super) fn positions(
    source: &FileSource,
    format: Format,
    asked: Option<&str>,
) -> Result<Vec<NamedNumber>> {
    let container = open(source, format)?;
    let choice = Choice::of(&container, source.options, source.stated.layout).ok();
    // Of several groups of records the coordinates are `/x/1`, `/x/2`.
    let is_it = |name: &str| {
        let bare = name.trim_start_matches('/');
        let mut parts = bare.split(['/', '.']);
        match asked {
            Some(asked) => bare == asked.trim_start_matches('/') || parts.any(|part| part == asked),
            None => {
                let is_known =
                    |part: &str| names::POSITION.contains(&part.to_ascii_lowercase().as_str());
                parts.any(is_known)
            }
        }
    };
    let own = choice.map(|choice| &container.variables[choice.variable].attributes);
    let mut found = Vec::new();
    for attributes in own.into_iter().chain([&container.attributes]) {
        let named = attributes.0.iter().filter(|(name, _)| is_it(name));
        found.extend(named.filter_map(|(name, _)| of_attribute(attributes, name)));
    }
    for (i, variable) in container.variables.iter().enumerate() {
        let is_number = variable.count() == Some(1) && variable.sample_type.number().is_some();
        if !is_number || !is_it(&variable.path) {
            continue;
        }
        let numbers = unpacked(&container, i).map_err(|fault| source.container_fault(fault))?;
        let value = numbers[0];
        let sample = variable.sample_type.number();
        let relative = sample.map_or(f64::EPSILON, |sample| sample.relative_rounding());
        found.push(NamedNumber {
            name: variable.path.trim_start_matches('/').to_owned(),
            value,
            unit: variable.attributes.text("units").map(length_unit),
            rounding: relative * value.abs(),
        });
    }
    Ok(found)
}

/// An attribute that is a number, or a text of a number and a unit.
fn of_attribute(attributes: &Attributes, name: &str) -> Option<NamedNumber> {
    let beside = || {
        let endings = ["_unit", "_units"].iter();
        endings
            .filter_map(|end| attributes.text(&format!("{name}{end}")))
            .next()
    };
    let (value, unit) = match attributes.number(name) {
        Some(value) => (value, beside().map(length_unit)),
        None => match Label::parse(attributes.text(name)?)? {
            Label::Value { value, unit } => (value, unit.as_deref().or(beside()).map(length_unit)),
            Label::Index(_) => return None,
        },
    };
    Some(NamedNumber {
        name: name.to_owned(),
        value,
        unit,
        rounding: f64::EPSILON * value.abs(),
    })
}

/// The symbol of a unit of length; another unit as it is.
fn length_unit(unit: &str) -> String {
    let symbol = measure::symbol::<Length>(unit);
    symbol.unwrap_or(unit).to_owned()
}

/// What a file that this program wrote states as its schema.
fn own_schema(container: &Container) -> Option<&str> {
    let schema = container.attributes.text("schema");
    schema.filter(|schema| schema.starts_with("cascade."))
}

/// The schema of a NetCDF file that this program or its Python package wrote, and whether it holds a whole run;
/// `None` for any other file.
pub(super) fn own(bytes: Arc<FileBytes>) -> Option<(String, bool)> {
    let container = own_container(bytes)?;
    let schema = own_schema(&container)?.to_owned();
    // A part of a run, which arrays of other languages are easily cut to, is a field.
    let is_whole = || {
        let shape = &container.variables[container.find("velocity")?].shape();
        let words: Vec<String> = shape.iter().map(u64::to_string).collect();
        (container.attributes.text("shape")? == words.join(" x ")).then_some(())
    };
    let is_run = schema.starts_with("cascade.run/") && is_whole().is_some();
    Some((schema, is_run))
}

fn own_container(bytes: Arc<FileBytes>) -> Option<Container> {
    let is_netcdf = |format: &Format| matches!(format, Format::NetCdf3 | Format::Hdf5);
    let format = Format::detect("a.nc", &bytes).filter(is_netcdf)?;
    wavecascade_formats::open(format, bytes, &Options::default()).ok()
}

/// The texts and the arrays of a NetCDF file; `None` for any other file.
pub(super) fn parts(bytes: Arc<FileBytes>) -> Option<wavecascade_formats::Result<Parts>> {
    let container = own_container(bytes)?;
    let texts = container.attributes.0.iter();
    let texts = texts.filter_map(|(name, _)| {
        let text = container.attributes.text(name)?;
        Some((name.clone(), text.to_owned()))
    });
    let is_number = |i: &usize| container.variables[*i].sample_type.number().is_some();
    let arrays = (0..container.variables.len()).filter(is_number).map(|i| {
        let variable = &container.variables[i];
        let name = variable.path.trim_start_matches('/').to_owned();
        Ok((name, (variable.shape(), container.numbers(i)?)))
    });
    let arrays: wavecascade_formats::Result<_> = arrays.collect();
    let texts = texts.collect();
    Some(arrays.map(|arrays| (texts, arrays)))
}

/// The arrays of a file of `format`.
pub(super) fn open(source: &FileSource, format: Format) -> Result<Container> {
    let mut options = Options::default();
    options.memory = source.options.memory;
    let container = match format {
        Format::Zarr => wavecascade_formats::open_directory(format, source.path, &options),
        _ => wavecascade_formats::open(format, source.bytes.clone(), &options),
    };
    container.map_err(|fault| source.container_fault(fault))
}

impl FileSource<'_> {
    /// A fault of a container as one of its file.
    fn container_fault(&self, fault: wavecascade_formats::Error) -> Error {
        match fault {
            wavecascade_formats::Error::Memory {
                needed, allowed, ..
            } => Error::Memory {
                what: "what has to be decoded of the file",
                needed,
                allowed,
            },
            fault => self.fault(InputFault::Container {
                fault: Box::new(fault),
            }),
        }
    }
}

/// Scale and offset of packed numbers as the CF conventions name them, also where a text holds them.
fn scaling(attributes: &Attributes) -> (f64, f64) {
    let number = |name| {
        let of_text = || attributes.text(name)?.parse().ok();
        attributes.number(name).or_else(of_text)
    };
    (
        number("scale_factor").unwrap_or(1.0),
        number("add_offset").unwrap_or(0.0),
    )
}

/// The numbers that those of a variable stand for.
fn unpacked(container: &Container, i: usize) -> wavecascade_formats::Result<Vec<f64>> {
    let (scale, offset) = scaling(&container.variables[i].attributes);
    let numbers = container.numbers(i)?.into_iter();
    Ok(numbers.map(|v| scale * v + offset).collect())
}

/// Scale, offset and gaps as the CF conventions name them.
fn packing(variable: &wavecascade_formats::Variable) -> Option<Packing> {
    use wavecascade_formats::Sample;
    /// What NetCDF fills floats with that were never written.
    const UNWRITTEN: f64 = 9.969_209_968_386_869e36;
    let attributes = &variable.attributes;
    let mut gaps = Vec::new();
    for name in ["_FillValue", "missing_value"] {
        match attributes.get(name) {
            Some(Value::Integers(values)) => gaps.extend(values.iter().map(|&v| v as f64)),
            Some(Value::Numbers(values)) => gaps.extend(values),
            _ => gaps.extend(
                attributes
                    .text(name)
                    .and_then(|text| text.parse::<f64>().ok()),
            ),
        }
    }
    gaps.retain(|gap| !gap.is_nan());
    // A gap stated with more digits than the samples have is one of them, rounded.
    if variable.sample_type.number() == Some(Sample::F32) {
        gaps.iter_mut()
            .for_each(|gap| *gap = f64::from(*gap as f32));
    }
    let is_float = matches!(
        variable.sample_type.number(),
        Some(Sample::F32 | Sample::F64)
    );
    // A stated fill value takes the place of the usual one.
    if is_float && attributes.get("_FillValue").is_none() {
        gaps.push(UNWRITTEN);
    }
    let (scale, offset) = scaling(attributes);
    Packing::new(scale, offset, gaps)
}

/// The quantity that a name, or else a unit, stands for.
pub(super) fn quantity(
    path: &str,
    standard_name: Option<&str>,
    unit: Option<&str>,
) -> Option<Quantity> {
    let last = choose::last_name(path).to_ascii_lowercase();
    let names = [Some(last.as_str()), standard_name];
    let by_name = Quantity::ALL.into_iter().find(|quantity| {
        let is_it =
            |name: &str| name == quantity.name() || name == quantity.name().replace('_', "");
        names.into_iter().flatten().any(is_it)
    });
    by_name.or_else(|| of_unit(unit?))
}

/// The quantity that is measured in `unit`.
pub(super) fn of_unit(unit: &str) -> Option<Quantity> {
    let spelled: String = unit.chars().filter(|c| !c.is_whitespace()).collect();
    let spelled = spelled
        .replace("**", "")
        .replace('^', "")
        .replace(['*', '.'], "");
    let bare = |units: &[&str]| {
        let prefixes = ["", "m", "u", "\u{b5}", "\u{3bc}", "n", "c", "k"];
        let is_prefixed = |unit: &&str| {
            let rest = spelled.strip_suffix(*unit);
            rest.is_some_and(|prefix| prefixes.contains(&prefix))
        };
        units.iter().any(is_prefixed)
    };
    match () {
        _ if bare(&["m/s", "ms-1", "m/sec"]) => Some(Quantity::Velocity),
        _ if bare(&["m/s2", "ms-2", "m/s\u{b2}"]) || spelled == "g" => Some(Quantity::Acceleration),
        _ if bare(&["m", "meter", "metre"]) => Some(Quantity::Displacement),
        _ if bare(&["strain/s", "1/s", "s-1", "/s"]) => Some(Quantity::StrainRate),
        _ if bare(&["N"]) => Some(Quantity::Force),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_names_its_quantity() {
        for (unit, quantity) in [
            ("m/s", Some(Quantity::Velocity)),
            ("mm/s", Some(Quantity::Velocity)),
            ("m s-1", Some(Quantity::Velocity)),
            ("m s**-1", Some(Quantity::Velocity)),
            ("\u{b5}m/s", Some(Quantity::Velocity)),
            ("m/s^2", Some(Quantity::Acceleration)),
            ("g", Some(Quantity::Acceleration)),
            ("nm", Some(Quantity::Displacement)),
            ("strain/s", Some(Quantity::StrainRate)),
            ("kN", Some(Quantity::Force)),
            ("Pa", None),
            ("counts", None),
        ] {
            assert_eq!(of_unit(unit), quantity, "{unit}");
        }
    }
}
