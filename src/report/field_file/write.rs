//! The samples of a field to a new file of each format.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::ops::Range;
use std::path::Path;

use super::super::archive::npy_header;
use super::super::netcdf::{KEPT_FOR_A_FIELD, NetCdf};
use super::super::samples::{Order, bytes_of, in_bytes};
use super::super::{Archive, ArrayFile, ArrayLabels, Attribute};
use super::blocks::each_block;
use super::{FIELD_SCHEMA, MARK};
use crate::arrays::Precision;
use crate::error::{Error, Result};
use crate::field::{Axis, Field, Layout, Sidecar};
use crate::measure::{self, Time};
use crate::observer::Observer;
use crate::system::file_io::{allocate, begin_sync, write_at};

/// Writes a block of `sites` of whole or partial profiles by `write`, which takes the place of a sample
/// and what follows from there.
fn put_profiles(
    n_sites: usize,
    (times, sites): (Range<usize>, Range<usize>),
    values: &[f64],
    write: impl Fn(usize, &[f64]) -> Result<()>,
) -> Result<()> {
    let first = times.start * n_sites + sites.start;
    if sites.len() == n_sites {
        return write(first, values);
    }
    let mut profiles = values.chunks_exact(sites.len().max(1)).enumerate();
    profiles.try_for_each(|(n, profile)| write(first + n * n_sites, profile))
}

/// Writes coordinates of an axis by `add`, which takes the name, the unit and the step too; nothing of one that only
/// counts.
fn each_axis(field: &Field, mut add: impl FnMut(&str, &Axis, &[f64]) -> Result<()>) -> Result<()> {
    for (name, axis, count) in [
        ("time", &field.time, field.n_times()),
        ("position", &field.space, field.n_sites()),
    ] {
        if *axis != Axis::index() {
            let places: Vec<f64> = (0..count).map(|i| axis.at(i)).collect();
            add(name, axis, &places)?;
        }
    }
    Ok(())
}

/// Writes the samples to a file of arrays, with an attribute for gaps.
fn samples(file: &dyn ArrayFile, field: &Field, observer: &dyn Observer) -> Result<()> {
    let sites = field.n_sites();
    let axes = [("time", field.n_times()), ("position", sites)];
    let labels = ArrayLabels {
        unit: field.unit.as_deref().unwrap_or_default(),
        ..ArrayLabels::of(field.quantity.name(), &axes)
    };
    let place = file.reserve_array(&labels, field.precision())?;
    // A gap is no number; without this, the number that NetCDF leaves in what was never written is one.
    let gap = match field.precision() {
        Precision::F64 => Attribute::Number(f64::NAN),
        Precision::F32 => Attribute::Single(f32::NAN),
    };
    file.describe(labels.name, vec![("_FillValue", gap)]);
    let Some(place) = place else { return Ok(()) };
    each_block(field, false, observer, |t, s, values| {
        put_profiles(sites, (t, s), values, |first, values| {
            file.write_samples(place, first, values)
        })
    })
}

pub(super) fn archive(working: &Path, field: &Field, observer: &dyn Observer) -> Result<()> {
    let archive = Archive::create(working, Precision::F64)?;
    let unit = |name: &str, unit: Option<&str>| match unit {
        Some(unit) => archive.append_text(&format!("{name}_unit"), unit),
        None => Ok(()),
    };
    archive.append_text("schema", FIELD_SCHEMA)?;
    samples(&archive, field, observer)?;
    unit(field.quantity.name(), field.unit.as_deref())?;
    each_axis(field, |name, axis, places| {
        archive.append(&ArrayLabels::of(name, &[(name, places.len())]), places)?;
        unit(name, axis.unit.as_deref())
    })?;
    if let Some(dispersion) = &field.dispersion {
        archive.append_text("dispersion", dispersion)?;
    }
    archive.finish()
}

pub(super) fn netcdf(working: &Path, field: &Field, observer: &dyn Observer) -> Result<()> {
    let file = NetCdf::create_keeping(working, Precision::F64, KEPT_FOR_A_FIELD)?;
    let text = |text: &str| Attribute::Text(text.into());
    file.attribute("schema", text(FIELD_SCHEMA));
    file.attribute(
        "source",
        text(concat!("cascade ", env!("CARGO_PKG_VERSION"))),
    );
    file.attribute("title", text(&field.name));
    if let Some(dispersion) = &field.dispersion {
        file.attribute("dispersion", text(dispersion));
    }
    if let Some(site) = field.struck.and_then(|site| i32::try_from(site).ok()) {
        file.attribute("struck_site", Attribute::Integer(site));
    }
    each_axis(field, |name, axis, places| {
        let unit = axis.unit.as_deref().unwrap_or_default();
        let axes = [(name, places.len())];
        let labels = ArrayLabels {
            // Words such as `seconds` would be taken for a time of day.
            unit: match name {
                "time" => measure::symbol::<Time>(unit).unwrap_or(unit),
                _ => unit,
            },
            ..ArrayLabels::of(name, &axes)
        };
        file.append(&labels, places)?;
        file.describe(name, vec![("step", Attribute::Number(axis.step))]);
        Ok(())
    })?;
    samples(&file, field, observer)?;
    file.finish()
}

pub(super) fn array(working: &Path, field: &Field, observer: &dyn Observer) -> Result<()> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let precision = field.precision();
    let item = bytes_of(precision);
    let file = File::create(working).map_err(Error::write("create", working))?;
    let header = npy_header(&format!("<f{item}"), &format!("({times}, {sites})"), 0);
    let start = header.len() as u64;
    let end = start + times as u64 * sites as u64 * item;
    allocate(&file, 0, end).map_err(Error::write("reserve room in", working))?;
    let write =
        |at, bytes: &[u8]| write_at(&file, bytes, at).map_err(Error::write("write to", working));
    write(0, &header)?;
    each_block(field, false, observer, |t, s, values| {
        put_profiles(sites, (t, s), values, |first, values| {
            let at = start + first as u64 * item;
            in_bytes(values, precision, Order::Little, |from, bytes| {
                write(at + from, bytes)
            })
        })
    })?;
    begin_sync(&file);
    Ok(())
}

/// A table whose first line has the positions and whose first column the times, with all digits.
pub(super) fn table(working: &Path, field: &Field, observer: &dyn Observer) -> Result<()> {
    let failed = || Error::write("write to", working);
    let file = File::create(working).map_err(Error::write("create", working))?;
    let mut out = BufWriter::new(file);
    let unit = field.time.unit.as_deref();
    let unit = unit.map_or(String::new(), |unit| format!(" ({unit})"));
    write!(out, "time{unit}").map_err(failed())?;
    for j in 0..field.n_sites() {
        write!(out, ",{:?}", field.space.at(j)).map_err(failed())?;
    }
    writeln!(out).map_err(failed())?;
    each_block(field, true, observer, |times, _, values| {
        for (n, profile) in times.zip(values.chunks_exact(field.n_sites())) {
            write!(out, "{:?}", field.time.at(n)).map_err(failed())?;
            for value in profile {
                write!(out, ",{value:?}").map_err(failed())?;
            }
            writeln!(out).map_err(failed())?;
        }
        Ok(())
    })?;
    out.flush().map_err(failed())
}

pub(super) fn sidecar(working: &Path, field: &Field) -> Result<()> {
    let stated = |axis: &Axis, value: f64| (*axis != Axis::index()).then_some(value);
    let (time, space) = (&field.time, &field.space);
    let sidecar = Sidecar {
        layout: Some(Layout::TimeSite),
        dt: stated(time, time.step).map(Into::into),
        t0: stated(time, time.origin).map(Into::into),
        time_unit: time.unit.clone(),
        dx: stated(space, space.step).map(Into::into),
        x0: stated(space, space.origin).map(Into::into),
        space_unit: space.unit.clone(),
        quantity: Some(field.quantity),
        unit: field.unit.clone(),
        rate: None,
        dispersion: field.dispersion.clone(),
    };
    let failed = Error::write("write to", working);
    match toml::to_string(&sidecar) {
        Ok(text) => fs::write(working, format!("{MARK}\n{text}")).map_err(failed),
        Err(error) => Err(failed(std::io::Error::other(error))),
    }
}
