//! Fields as files: one archive of samples with their axes.

use std::path::Path;

use super::Archive;
use super::new_file::NewFile;
use crate::analyze::Precision;
use crate::error::Result;
use crate::field::{Axis, Field, is_field_file};

/// Version of the layout of field files, which their member `schema` holds.
pub const FIELD_SCHEMA: &str = "cascade.field/1";

const NEW: NewFile = NewFile {
    word: "field of this program",
    is_one: is_field_file,
};

/// A field as an archive that [`Field::open`] reads with its axes and units: the samples `(time,
/// site)` by the name of their quantity, `time`, `position`, and units as texts.
#[derive(Debug)]
pub struct FieldFile;

impl FieldFile {
    /// That a field can be written to `path`, before any work is done.
    ///
    /// # Errors
    /// [`crate::Error::Exists`] if one is there and is not to be replaced, [`crate::Error::Occupied`]
    /// if something else is; [`crate::Error::Request`] for a path without a name;
    /// [`crate::Error::Write`].
    pub fn check(path: &Path, replace: bool) -> Result<()> {
        NEW.check(path, replace)
    }

    /// Writes a field to `path`.
    ///
    /// # Errors
    /// As [`FieldFile::check`].
    pub fn write(path: &Path, replace: bool, field: &Field) -> Result<()> {
        NEW.write(path, replace, |working| {
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
        })
    }
}
