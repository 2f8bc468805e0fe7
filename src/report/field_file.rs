//! Fields as files: one archive of samples with their axes, or an array with a sidecar.

use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::Archive;
use super::archive::npy_header;
use super::directory::read_text;
use super::new_file::NewFile;
use crate::arrays::Precision;
use crate::error::{Error, Result};
use crate::field::{Axis, Field, Layout, Sidecar, is_field_file};
use crate::system::publish::Working;

/// Version of the layout of field files, which their member `schema` holds.
pub const FIELD_SCHEMA: &str = "cascade.field/1";

/// First line of the sidecar of an array that this program wrote.
const MARK: &str = "# cascade.field/1, of the array beside it";

const NEW_ARCHIVE: NewFile = NewFile {
    word: "field of this program",
    extensions: &["npz"],
    is_one: is_field_file,
};

const NEW_ARRAY: NewFile = NewFile {
    word: "field of this program",
    extensions: &["npy"],
    is_one: |path| is_own_sidecar(&sidecar_of(path)),
};

const NEW_SIDECAR: NewFile = NewFile {
    word: "sidecar of this program",
    extensions: &["toml"],
    is_one: is_own_sidecar,
};

/// A field as a file that [`Field::open`] reads with its axes and units.
///
/// An archive (`.npz`) holds the samples `(time, site)` by the name of their quantity, `time`,
/// `position`, and units as texts. An array (`.npy`) holds the samples alone; everything else is in
/// the sidecar file, `field.npy.toml` for `field.npy`.
#[derive(Debug)]
pub struct FieldFile;

impl FieldFile {
    /// That a field can be written to `path`, before any work is done.
    ///
    /// # Errors
    /// [`Error::Exists`] if one is there and is not to be replaced, [`Error::OutputInUse`] if something
    /// else is; [`Error::Request`] for a path without a name or with the extension of another format;
    /// [`Error::Write`].
    pub fn check(path: &Path, replace: bool) -> Result<()> {
        if !is_array(path) {
            return NEW_ARCHIVE.check(path, replace);
        }
        NEW_ARRAY.check(path, replace)?;
        NEW_SIDECAR.check(&sidecar_of(path), replace)?;
        let other = path.with_extension("toml");
        match other.symlink_metadata() {
            Ok(_) => Err(Error::OutputInUse {
                path: other,
                found: "is there and would be a second sidecar of the field".into(),
            }),
            Err(_) => Ok(()),
        }
    }

    /// Writes a field to `path`.
    ///
    /// # Errors
    /// As [`FieldFile::check`].
    pub fn write(path: &Path, replace: bool, field: &Field) -> Result<()> {
        FieldFile::check(path, replace)?;
        if !is_array(path) {
            return NEW_ARCHIVE.write(path, replace, |working| write_archive(working, field));
        }
        let sidecar = sidecar_of(path);
        let samples = NEW_ARRAY.begin(path, replace, |working| write_array(working, field))?;
        let axes = NEW_SIDECAR.begin(&sidecar, replace, |working| write_sidecar(working, field))?;
        NEW_ARRAY.check_free(path, replace)?;
        NEW_SIDECAR.check_free(&sidecar, replace)?;
        publish_pair((axes, &sidecar), (samples, path))
    }
}

/// Publishes the axes, then the samples; if that fails, what was there has its place again.
fn publish_pair(
    (mut axes, sidecar): (Working, &Path),
    (mut samples, path): (Working, &Path),
) -> Result<()> {
    let published = place(&mut axes, sidecar).and_then(|()| place(&mut samples, path));
    published.inspect_err(|_| {
        // Samples would be misread with the axes of others.
        let _ = samples.withdraw();
        let _ = axes.withdraw();
    })
}

fn place(working: &mut Working, path: &Path) -> Result<()> {
    let placed = match path.exists() {
        true => working.swap(),
        false => working.publish(),
    };
    placed.map_err(Error::write("finish", path))
}

fn is_array(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("npy"))
}

fn sidecar_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".toml");
    name.into()
}

fn is_own_sidecar(path: &Path) -> Result<bool> {
    Ok(read_text(path)?.starts_with(MARK))
}

fn write_archive(working: &Path, field: &Field) -> Result<()> {
    let archive = Archive::create(working, Precision::F64)?;
    let (times, sites) = (field.n_times(), field.n_sites());
    let quantity = field.quantity.name();
    archive.append_text("schema", FIELD_SCHEMA)?;
    let mut values = vec![0.0; times * sites];
    field.read_time_major(0..times, 0..sites, &mut values);
    archive.append(quantity, &[times, sites], &values)?;
    let unit = |name: &str, unit: Option<&str>| match unit {
        Some(unit) => archive.append_text(&format!("{name}_unit"), unit),
        None => Ok(()),
    };
    unit(quantity, field.unit.as_deref())?;
    for (name, axis, count) in [
        ("time", &field.time, times),
        ("position", &field.space, sites),
    ] {
        // An axis that only counts states nothing.
        if *axis == Axis::index() {
            continue;
        }
        let places: Vec<f64> = (0..count).map(|i| axis.at(i)).collect();
        archive.append(name, &[count], &places)?;
        unit(name, axis.unit.as_deref())?;
    }
    archive.finish()
}

fn write_array(working: &Path, field: &Field) -> Result<()> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let failed = || Error::write("write to", working);
    let file = fs::File::create(working).map_err(Error::write("create", working))?;
    let mut file = BufWriter::new(file);
    let header = npy_header("<f8", &format!("({times}, {sites})"), 0);
    file.write_all(&header).map_err(failed())?;
    let mut row = vec![0.0; sites];
    for n in 0..times {
        field.read_time_major(n..n + 1, 0..sites, &mut row);
        for value in &row {
            file.write_all(&value.to_le_bytes()).map_err(failed())?;
        }
    }
    file.flush().map_err(failed())
}

fn write_sidecar(working: &Path, field: &Field) -> Result<()> {
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
