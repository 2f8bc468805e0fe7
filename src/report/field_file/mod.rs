//! Fields as files: one file of samples with their axes, or an array or table with a sidecar.

mod blocks;
mod write;

use std::path::{Path, PathBuf};

use super::directory::read_text;
use super::new_file::{NewFile, place};
use crate::error::{Error, Result};
use crate::field::{Field, is_field_file, own_netcdf};
use crate::observer::{Observer, Silent};
use crate::system::publish::Working;

/// Version of the layout of field files, which their member (or attribute) `schema` holds.
pub const FIELD_SCHEMA: &str = "cascade.field/1";

/// First line of the sidecar of an array or table that this program wrote.
const MARK: &str = "# cascade.field/1, of the array beside it";

/// Sites of the widest table: its rows are no longer than what is read of one.
const WIDEST_TABLE: usize = 500_000;

const NEW_SIDECAR: NewFile = NewFile {
    word: "sidecar of this program",
    extensions: &["toml"],
    is_one: is_own_sidecar,
};

/// A field as a file that [`Field::open`] reads with its axes and units.
///
/// The extension chooses the format; samples are `(time, site)`, in single precision if they were stored
/// so ([`Field::precision`]).
///
/// - An archive (`.npz`, and any extension of no other format) holds the samples by the name of their
///   quantity, `time`, `position`, and units as texts.
/// - A NetCDF file (`.nc`) holds the samples by the name of their quantity, with the dimensions `time` and
///   `position`, whose coordinates have these names.
/// - An array (`.npy`) or a table (`.csv`, positions in its first line, times in its first column) holds
///   the samples; everything else is in the sidecar file, `field.npy.toml` for `field.npy`.
#[derive(Debug)]
pub struct FieldFile;

/// The format of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Archive,
    NetCdf,
    Array,
    Table,
}

impl Format {
    fn of(path: &Path) -> Format {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        match extension.to_str() {
            Some("nc") => Format::NetCdf,
            Some("npy") => Format::Array,
            Some("csv") => Format::Table,
            _ => Format::Archive,
        }
    }

    fn new_file(self) -> NewFile {
        let has_own_sidecar = |path: &Path| is_own_sidecar(&sidecar_of(path));
        let of = |extensions, is_one| NewFile {
            word: "field of this program",
            extensions,
            is_one,
        };
        match self {
            // Of a path with one of the others the format is another.
            Format::Archive => of(&FieldFile::EXTENSIONS, is_field_file),
            Format::NetCdf => of(&["nc"], |path| {
                Ok(own_netcdf(path)?.is_some_and(|(schema, _)| schema == FIELD_SCHEMA))
            }),
            Format::Array => of(&["npy"], has_own_sidecar),
            Format::Table => of(&["csv"], has_own_sidecar),
        }
    }

    fn has_sidecar(self) -> bool {
        matches!(self, Format::Array | Format::Table)
    }
}

impl FieldFile {
    /// Extensions of the formats of fields.
    pub const EXTENSIONS: [&'static str; 4] = ["nc", "npz", "npy", "csv"];

    /// That a field can be written to `path`, before any work is done.
    ///
    /// # Errors
    /// [`Error::Exists`] if one is there and is not to be replaced, [`Error::OutputInUse`] if something
    /// else is; [`Error::Request`] for a path without a name or with the extension of another format;
    /// [`Error::Write`].
    pub fn check(path: &Path, replace: bool) -> Result<()> {
        let format = Format::of(path);
        format.new_file().check(path, replace)?;
        if !format.has_sidecar() {
            return Ok(());
        }
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

    /// Writes a field to `path`, in blocks of 8 MB.
    ///
    /// # Errors
    /// As [`FieldFile::check`], and [`Error::Changed`] if the field's own file was changed meanwhile.
    pub fn write(path: &Path, replace: bool, field: &Field) -> Result<()> {
        FieldFile::write_observed(path, replace, field, &Silent)
    }

    /// The same, watched.
    ///
    /// # Errors
    /// As [`FieldFile::write`]; [`Error::Cancelled`] when the observer asks to stop.
    pub fn write_observed(
        path: &Path,
        replace: bool,
        field: &Field,
        observer: &dyn Observer,
    ) -> Result<()> {
        FieldFile::check(path, replace)?;
        let format = Format::of(path);
        let new = format.new_file();
        let fill = |working: &Path| {
            match format {
                Format::Archive => write::archive(working, field, observer),
                Format::NetCdf => write::netcdf(working, field, observer),
                Format::Array => write::array(working, field, observer),
                Format::Table => {
                    check_width(path, field).and_then(|()| write::table(working, field, observer))
                }
            }?;
            field.check_unchanged()
        };
        if !format.has_sidecar() {
            return new.write(path, replace, fill);
        }
        let sidecar = sidecar_of(path);
        let samples = new.begin(path, replace, fill)?;
        let axes =
            NEW_SIDECAR.begin(&sidecar, replace, |working| write::sidecar(working, field))?;
        // Of two processes one publishes both of its files, then the other.
        let names = samples.lock_names();
        new.check_free(path, replace)?;
        NEW_SIDECAR.check_free(&sidecar, replace)?;
        let published = publish_pair((axes, &sidecar), (samples, path), replace);
        drop(names);
        published
    }
}

fn check_width(path: &Path, field: &Field) -> Result<()> {
    match field.n_sites() {
        ..=WIDEST_TABLE => Ok(()),
        found => Err(Error::Unfit {
            path: path.to_owned(),
            expected: format!("at most {WIDEST_TABLE} sites, which the rows of a table can hold"),
            found: found.to_string(),
        }),
    }
}

/// Publishes the axes, then the samples; if that fails, what was there has its place again.
fn publish_pair(
    (mut axes, sidecar): (Working, &Path),
    (mut samples, path): (Working, &Path),
    replace: bool,
) -> Result<()> {
    let published =
        place(&mut axes, sidecar, replace).and_then(|()| place(&mut samples, path, replace));
    published.inspect_err(|_| {
        // Samples would be misread with the axes of others.
        let _ = samples.withdraw();
        let _ = axes.withdraw();
    })
}

fn sidecar_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".toml");
    name.into()
}

fn is_own_sidecar(path: &Path) -> Result<bool> {
    Ok(read_text(path)?.starts_with(MARK))
}
