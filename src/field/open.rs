//! Opens a field: detects the format and resolves the settings.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use wavecascade_formats::{Container, Format, Options, has_members};

use super::coordinates::{Coordinates, Listed};
use super::file_bytes::FileBytes;
use super::labelled::Arrays;
use super::options::{Header, OpenOptions, ReadMode, TimeColumn};
use super::resample::resampled;
use super::scan::NamedNumber;
use super::sidecar::Sidecar;
use super::state::FileState;
use super::{Field, Layout, Note, Quantity, csv, directory, labelled};
use crate::error::{Error, Fault, Result};
use crate::measure::{Dimension, Length, quotient};

/// Input of the format readers: the bytes of a file and its settings.
pub(super) struct FileSource<'a> {
    pub(super) path: &'a Path,
    pub(super) bytes: Arc<FileBytes>,
    pub(super) options: &'a OpenOptions,
    /// Settings of the options, else of the sidecar.
    pub(super) stated: Sidecar,
}

impl FileSource<'_> {
    pub(super) fn layout(&self) -> Layout {
        self.stated.layout.unwrap_or_default()
    }

    /// Checks that `needed` bytes are within the memory limit, with a copy of the file.
    pub(super) fn allow(&self, what: &'static str, needed: u64) -> Result<()> {
        let copied = if self.bytes.is_copy() {
            self.bytes.len()
        } else {
            0
        };
        self.options
            .allow(what, needed.saturating_add(copied as u64))
    }
}

/// What is at a path.
pub(super) struct Opened {
    pub(super) bytes: Arc<FileBytes>,
    /// `None` for a directory.
    state: Option<FileState>,
    pub(super) format: Format,
}

impl Opened {
    /// The file at `path`, or the store that is a directory.
    pub(super) fn at(path: &Path, options: &OpenOptions) -> Result<Opened> {
        if let Some(format) = Format::detect_directory(path) {
            return Ok(Opened {
                bytes: FileBytes::of_directory(),
                state: None,
                format,
            });
        }
        let allow = |length| options.allow("a copy of the file", length);
        let (bytes, state) = FileBytes::open(path, options.read, allow)?;
        let format = detect(path, &bytes).map_err(Error::input(path))?;
        Ok(Opened {
            bytes,
            state: Some(state),
            format,
        })
    }

    /// The arrays of what is at `path` and no table.
    fn container(&self, path: &Path, memory: Option<u64>) -> Result<Container> {
        let mut options = Options::default();
        options.memory = memory;
        Ok(match self.format {
            Format::Zarr => wavecascade_formats::open_directory(self.format, path, &options)?,
            format => wavecascade_formats::open(format, Arc::clone(&self.bytes) as _, &options)?,
        })
    }

    /// What `read` makes of its arrays.
    pub(super) fn arrays<T>(
        self,
        path: &Path,
        options: &OpenOptions,
        read: impl FnOnce(&mut Arrays) -> Result<T>,
    ) -> Result<T> {
        let container = self.container(path, options.memory);
        let source = FileSource {
            path,
            bytes: self.bytes,
            options,
            stated: Sidecar::default(),
        };
        let arrays = container.and_then(|container| Arrays::new(&source, container));
        let read = arrays.and_then(|mut arrays| read(&mut arrays));
        read.map_err(|error| error.at(path))
    }
}

/// Output of the format readers.
pub(super) struct Contents {
    /// The samples and what is known of them, without its axes.
    pub(super) field: Field,
    pub(super) time: Listed,
    pub(super) space: Listed,
    pub(super) quantity: Option<Quantity>,
}

impl Contents {
    /// Brings the samples to the axes.
    fn resampled(mut self, options: &OpenOptions) -> Result<Contents> {
        let field = &mut self.field;
        if let Some(time) = &self.time.resampling {
            field.storage = resampled(&field.storage, field.n_sites, time, options, true)?;
        }
        if let Some(space) = &self.space.resampling {
            field.storage = resampled(&field.storage, field.n_times, space, options, false)?;
        }
        Ok(self)
    }

    /// Adds notes on a doubtful layout and, if the file has no times, on a first site that looks
    /// like times.
    pub(super) fn note_doubts(&mut self, is_layout_known: bool) {
        let field = &mut self.field;
        let (times, sites) = (field.n_times, field.n_sites);
        if !is_layout_known {
            field.notes.extend(Note::on_shape(times, sites));
        }
        if self.time.even == Coordinates::default() {
            let doubt = Note::on_samples(&field.storage, times, sites);
            field.notes.extend(doubt);
        }
    }
}

impl Field {
    /// A field from a NumPy array (`.npy`), a member of an archive (`.npz`), or a text table.
    ///
    /// A two-dimensional array is `(time, site)` unless the layout says otherwise. A
    /// one-dimensional array is the record of one site. Uncompressed arrays stay in the mapped
    /// file; deflated members and tables are loaded into memory. Steps, origins and units come from
    /// `options`, else from the [`Sidecar`], else from the file; without any, an axis counts
    /// indices.
    ///
    /// In an archive, `time` (`t`) and `position` (`x`) are the coordinates and `velocity` (`v`) is
    /// the field. The string `velocity_unit` is the unit of the array `velocity`; likewise for
    /// every array. If no layout is stated, the lengths of the coordinates determine it.
    ///
    /// In a table, the times are in the column named by a header (the first line, or a comment
    /// before the rows), else in the first column if its steps are even. [`Field::notes`] lists
    /// what was inferred and what is doubtful.
    ///
    /// A Zarr store is a directory; its samples are decoded when it is opened, and it may change
    /// afterwards.
    ///
    /// The file must not be truncated while the field is in use: a read of missing pages ends the
    /// process. [`Field::check_unchanged`] detects modification and replacement. With
    /// [`ReadMode::Copy`] the file is read once, into memory, and may change afterwards.
    ///
    /// # Errors
    /// - [`Error::Read`]: the file does not exist or cannot be read.
    /// - [`Error::Input`]: the contents violate the format.
    /// - [`Error::Request`]: a step or origin is not a valid number, or an option does not apply to
    ///   the format.
    /// - [`Error::Memory`]: the data to load exceed [`OpenOptions::memory`].
    pub fn open(path: impl AsRef<Path>, options: &OpenOptions) -> Result<Field> {
        let path = path.as_ref();
        options.check()?;
        Field::read(path, options).map_err(|error| error.at(path))
    }

    fn read(path: &Path, options: &OpenOptions) -> Result<Field> {
        let opened = Opened::at(path, options)?;
        check(opened.format, path, options)?;
        let is_table = opened.format == Format::Table;
        let container = (!is_table).then(|| opened.container(path, options.memory));
        let container = container.transpose()?;
        let Opened { bytes, state, .. } = opened;
        // The `run.toml` next to a run is its scene, and `field.toml` next to a field that this program
        // wrote that of the file it was made of: not a sidecar.
        let is_own = container.as_ref().and_then(labelled::own_schema).is_some();
        let sidecar = Sidecar::find_for(path, is_own)?.map(|(_, sidecar)| sidecar);
        let source = FileSource {
            path,
            bytes,
            options,
            stated: options.over(sidecar.unwrap_or_default()),
        };
        let contents = match container {
            None => csv::read(&source)?,
            Some(container) => labelled::read(&source, container)?,
        };
        // A copy is hashed at once: the file may be another when its hash is wanted.
        let is_copy = source.bytes.is_copy();
        let content_hash = match &state {
            None => Some(directory::hash(path)?),
            Some(_) => (options.hash || is_copy).then(|| source.bytes.hash_releasing()),
        };
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let stated = source.stated.clone();
        let field = completed(contents, stated, options, &name)?;
        Ok(Field {
            opened: state.filter(|_| !is_copy),
            content_hash,
            ..field
        })
    }
}

/// The field of `contents`, whose axes are as `stated`, else as the contents state them.
pub(super) fn completed(
    contents: Contents,
    stated: Sidecar,
    options: &OpenOptions,
    name: &str,
) -> Result<Field> {
    let contents = contents.resampled(options)?;
    let time = contents.time.even;
    let time = time.axis([stated.t0, stated.dt], stated.time_unit)?;
    let space = contents.space.even;
    let space = space.axis([stated.x0, stated.dx], stated.space_unit)?;
    let mut field = contents.field;
    let notes = &mut field.notes;
    let quantity = stated.quantity.or(contents.quantity).unwrap_or_default();
    let unit = stated.unit.or(field.unit).map(|unit| quotient(&unit));
    notes.extend(Note::on_units(quantity, unit.as_deref(), [&time, &space]));
    let field = Field {
        name: name.to_owned(),
        time,
        space,
        quantity,
        unit,
        dispersion: stated.dispersion.or(field.dispersion),
        ..field
    };
    field.selected(&options.select)
}

/// The numbers of the header of a file that may be the position of its record: those called as positions
/// are, or `asked`.
pub(super) fn header_numbers(
    path: &Path,
    options: &OpenOptions,
    asked: Option<&str>,
) -> Result<Vec<NamedNumber>> {
    let sidecar = Sidecar::find_for(path, false)?.map(|(_, sidecar)| sidecar);
    let sidecar = sidecar.unwrap_or_default();
    let metres = || Some(Length::UNITS[0].0.to_owned());
    let x0 = sidecar.x0.map(|x0| NamedNumber {
        name: "x0".into(),
        value: x0.value,
        unit: if x0.has_unit {
            metres()
        } else {
            sidecar.space_unit
        },
        rounding: f64::EPSILON * x0.value.abs(),
    });
    let mapped = OpenOptions {
        read: ReadMode::Map,
        ..options.clone()
    };
    let opened = Opened::at(path, &mapped)?;
    let mut numbers = match opened.format {
        Format::Table => Vec::new(),
        _ => opened.arrays(path, options, |arrays| arrays.positions(asked))?,
    };
    numbers.extend(x0.filter(|_| asked.is_none_or(|asked| asked == "x0")));
    Ok(numbers)
}

/// Whether the file at `path` is a run.
///
/// # Errors
/// [`Error::Read`].
pub fn is_run_file(path: &Path) -> Result<bool> {
    Ok(is_run_archive(path)? || own_netcdf(path)?.is_some_and(|(_, is_run)| is_run))
}

/// Whether the file at `path` is an archive of a run.
///
/// # Errors
/// [`Error::Read`].
pub(crate) fn is_run_archive(path: &Path) -> Result<bool> {
    own_members(path, [true, true])
}

/// Whether the file at `path` is a field written by this program.
///
/// # Errors
/// [`Error::Read`].
pub(crate) fn is_field_file(path: &Path) -> Result<bool> {
    own_members(path, [true, false])
}

/// What a NetCDF file that this program wrote states as its schema, and whether it is a run.
///
/// # Errors
/// [`Error::Read`].
pub(crate) fn own_netcdf(path: &Path) -> Result<Option<(String, bool)>> {
    match map(path) {
        Err(Error::Input { .. }) => Ok(None),
        bytes => Ok(labelled::own(bytes?)),
    }
}

/// Whether the file at `path` is a NetCDF file.
///
/// # Errors
/// [`Error::Read`]; [`Error::Input`] for an empty file.
pub(crate) fn is_netcdf(path: &Path) -> Result<bool> {
    Ok(labelled::netcdf(&map(path)?).is_some())
}

/// Reads arrays and texts of the NetCDF file at `path`, or of the archive that any other file is.
pub(crate) fn read_members<T>(
    path: &Path,
    read: impl FnOnce(&mut Arrays) -> Result<T>,
) -> Result<T> {
    let bytes = map(path)?;
    let opened = Opened {
        format: labelled::netcdf(&bytes).unwrap_or(Format::Npz),
        bytes,
        state: None,
    };
    opened.arrays(path, &OpenOptions::default(), read)
}

/// Whether an archive holds these texts of this program: a schema, as its fields and runs do, and a scene, as runs do.
/// Of other files, which may change once they are copied, the end is not looked at.
fn own_members(path: &Path, held: [bool; 2]) -> Result<bool> {
    let mut first = [0; 2];
    let start = File::open(path).and_then(|mut file| file.read_exact(&mut first));
    if start.is_ok() && first != *b"PK" {
        return Ok(false);
    }
    match map(path) {
        // Empty, or no regular file.
        Err(Error::Input { .. }) => Ok(false),
        bytes => Ok(has_members(&bytes?, ["schema", "scene"]) == held),
    }
}

/// The bytes of a file, mapped.
pub(super) fn map(path: &Path) -> Result<Arc<FileBytes>> {
    Ok(FileBytes::open(path, ReadMode::Map, |_| Ok(()))?.0)
}

/// BLAKE3 hash of the file at `path`, in hexadecimal.
///
/// # Errors
/// [`Error::Read`].
pub fn file_hash(path: &Path) -> Result<String> {
    Ok(map(path)?.hash_releasing())
}

/// Checks that every option applies to the format.
fn check(format: Format, path: &Path, options: &OpenOptions) -> Result<()> {
    let (is_table, is_array) = (format == Format::Table, format == Format::Npy);
    let [arrays, dimensions, table] = [
        "a file of several arrays",
        "a file of arrays with dimensions",
        "a table of text",
    ];
    let has_header = options.header != Header::Detect;
    let has_column = options.time_column != TimeColumn::Detect;
    let has_variable = options.variable.is_some();
    let useless = [
        ("variable", has_variable && (is_table || is_array), arrays),
        (
            "time-dim",
            options.time_dim.is_some() && is_table,
            dimensions,
        ),
        (
            "space-dim",
            options.space_dim.is_some() && is_table,
            dimensions,
        ),
        ("at", !options.at.is_empty() && is_table, dimensions),
        ("header", has_header && !is_table, table),
        ("time-column", has_column && !is_table, table),
    ];
    if let Some((option, _, expected)) = useless.into_iter().find(|(_, is_useless, _)| *is_useless)
    {
        let expected = format!("{expected}, which alone it is for");
        let found = format!("{}, {format}", path.display());
        return Err(Error::request(option, expected, found));
    }
    Ok(())
}

/// Detects the format from the magic bytes, else from the extension.
fn detect(path: &Path, bytes: &[u8]) -> Result<Format, Fault> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let extension = extension.to_string_lossy();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    // Numbers of a table may look like the header of a text format.
    let is_table = matches!(extension.as_ref(), "csv" | "tsv");
    let labelled = Format::detect(&name, bytes);
    if let Some(format) = labelled.filter(|format| !is_table || *format == Format::Npy) {
        return Ok(format);
    }
    // What a text is called says nothing of what it is.
    let (name, called) = match is_text(bytes) {
        true => ("", "text with the extension"),
        false => (extension.as_ref(), "the extension"),
    };
    if let Some([format, advice]) = foreign(name, bytes) {
        return Err(Fault::expected(READ, format, advice));
    }
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
        return Ok(Format::Npz);
    }
    match extension.as_ref() {
        "npy" => Ok(Format::Npy),
        "npz" => Ok(Format::Npz),
        "csv" | "tsv" | "txt" => Ok(Format::Table),
        other => {
            let advice = match other {
                "toml" => {
                    "a scene is run first: `cascade simulate SCENE.toml`, then `cascade analyze SCENE.npz`; beside a field, name the field"
                }
                _ => "convert it with `numpy.save(\"field.npy\", array)`",
            };
            Err(Fault::expected(READ, format!("{called} {other:?}"), advice))
        }
    }
}

const READ: &str = "NumPy (.npy, .npz), text (.csv, .tsv, .txt), HDF5, NetCDF, MATLAB, SEG-Y, UFF, TDMS, miniSEED or LAMMPS dumps";

const RENAME: &str =
    "the file is damaged, or its name is of another format: rename it, or write it again";

const UNZSTD: &str = "unpack it with `unzstd`";

const FROM_PARQUET: &str =
    "save it as CSV: `pandas.read_parquet(path).to_csv(\"field.csv\", index=False)`";

const FROM_WAV: &str = "convert it in Python, one channel a site: `rate, v = scipy.io.wavfile.read(path); \
                        numpy.save(\"field.npy\", v.astype(float))`, and state `--rate`";

/// First bytes of formats that are not read, or were not read as such, how messages call them and what to do.
const FOREIGN: [(&[u8], [&str; 2]); 8] = [
    (b"MATLAB 7.3 MAT-file", ["a MATLAB file", RENAME]),
    (b"MATLAB 5.0 MAT-file", ["a MATLAB file", RENAME]),
    (b"\x89HDF\r\n\x1a\n", ["an HDF5 file", RENAME]),
    (b"\x1f\x8b", ["a gzip file", "unpack it with `gunzip`"]),
    (b"\x28\xb5\x2f\xfd", ["a zstd file", UNZSTD]),
    (b"CDF", ["a NetCDF file", RENAME]),
    (b"PAR1", ["a Parquet file", FROM_PARQUET]),
    (b"RIFF", ["a WAV file", FROM_WAV]),
];

/// Of a file with this extension (lower case) and these first bytes that is in one of them.
fn foreign(extension: &str, bytes: &[u8]) -> Option<[&'static str; 2]> {
    // NetCDF 4 is HDF5 inside, a spreadsheet a zip archive.
    match extension {
        "nc" | "nc4" => Some(["a NetCDF file", RENAME]),
        "xlsx" | "xls" | "ods" => Some(["a spreadsheet", "save it as CSV"]),
        _ => FOREIGN
            .iter()
            .find(|it| bytes.starts_with(it.0))
            .map(|it| it.1),
    }
}

/// Whether the first bytes are those of a text.
fn is_text(bytes: &[u8]) -> bool {
    let first = &bytes[..bytes.len().min(1024)];
    let is_cut = |fault: std::str::Utf8Error| fault.error_len().is_none();
    !first.contains(&0) && str::from_utf8(first).map_or_else(is_cut, |_| true)
}
