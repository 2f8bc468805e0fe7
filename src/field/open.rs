//! Opens a field: detects the format and resolves the settings.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use super::coordinates::{Coordinates, StatedAxis};
use super::file_bytes::FileBytes;
use super::interpolate::Interpolant;
use super::options::{At, Header, OpenOptions, ReadMode, TimeColumn};
use super::resample::resampled;
use super::scan::NamedNumber;
use super::sidecar::Sidecar;
use super::state::FileState;
use super::storage::{Bytes, Storage};
use super::{Field, Layout, Note, Quantity, csv, directory, labelled, npy, npz};
use crate::error::{DimensionName, Error, ForeignFormat, InputFault, Result};
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

    pub(super) fn fault(&self, fault: InputFault) -> Error {
        Error::input(self.path)(fault)
    }

    /// Checks that `needed` bytes are within the memory limit, with a copy of the file.
    pub(super) fn allow(&self, what: &'static str, needed: u64) -> Result<()> {
        let copied = match self.bytes.is_copy() {
            true => self.bytes.len() as u64,
            false => 0,
        };
        self.options.allow(what, needed.saturating_add(copied))
    }
}

impl FileSource<'_> {
    /// Checks that an array of NumPy has a further dimension where one is stated.
    pub(super) fn check_at(&self, header: &npy::Header) -> Result<()> {
        match header.shape.len() {
            found @ 0..=2 if !self.options.at.is_empty() => Err(Error::request(
                "at",
                "an array of three dimensions or more",
                format!("one of {found}"),
            )),
            _ => Ok(()),
        }
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
        if let Some(format) = wavecascade_formats::Format::detect_directory(path) {
            return Ok(Opened {
                bytes: FileBytes::of_directory(),
                state: None,
                format: Format::Labelled(format),
            });
        }
        let allow = |length| options.allow("a copy of the file", length);
        let (bytes, state) = FileBytes::open(path, options.read, allow)?;
        let format = Format::detect(path, &bytes).map_err(Error::input(path))?;
        Ok(Opened {
            bytes,
            state: Some(state),
            format,
        })
    }
}

/// Output of the format readers.
pub(super) struct Contents {
    pub(super) storage: Storage,
    pub(super) n_times: usize,
    pub(super) n_sites: usize,
    pub(super) time: Coordinates,
    pub(super) space: Coordinates,
    /// How samples come to the axes of times and sites, where they are not there.
    pub(super) resampling: [Option<Interpolant>; 2],
    pub(super) quantity: Option<Quantity>,
    pub(super) unit: Option<String>,
    pub(super) notes: Vec<Note>,
    /// As [`Field::axis_names`].
    pub(super) axis_names: [Option<String>; 2],
    /// As [`Field::channels`].
    pub(super) channels: Vec<String>,
    /// As [`Field::struck`].
    pub(super) struck: Option<usize>,
    /// As [`Field::masses`].
    pub(super) masses: Option<Vec<f64>>,
    /// As [`Field::dispersion`].
    pub(super) dispersion: Option<String>,
}

impl Contents {
    /// The samples in `bytes` from `start`, described by an `.npy` header.
    pub(super) fn from_npy(
        header: &npy::Header,
        bytes: Bytes,
        start: usize,
        layout: Layout,
    ) -> Result<Contents, InputFault> {
        let (n_times, n_sites) = header.field_lengths(layout)?;
        let storage = Storage::new(bytes, header.arrangement(start, layout)?);
        Ok(Contents::of(storage, [n_times, n_sites]))
    }

    /// As [`Contents::from_npy`], of an array of any dimensions, taken where `at` says; `coordinate` has the
    /// values of a dimension and their unit.
    pub(super) fn from_npy_at(
        header: &npy::Header,
        bytes: Bytes,
        start: usize,
        layout: Layout,
        at: &[At],
        coordinate: &mut dyn FnMut(&str) -> Option<labelled::Places>,
    ) -> Result<Contents, InputFault> {
        if at.is_empty() && header.shape.len() <= 2 {
            return Contents::from_npy(header, bytes, start, layout);
        }
        header.check_samples()?;
        let names = header.names(layout);
        let dimensions = || {
            let named = names.iter().zip(&header.shape);
            let named: Vec<String> = named.map(|(name, len)| format!("{name}: {len}")).collect();
            named.join(", ")
        };
        let variable = || "the array".to_owned();
        let (mut fixed, mut notes) = (vec![None; names.len()], Vec::new());
        for At { dimension, label } in at {
            let by_name = names.iter().position(|name| name == dimension);
            let by_number = || dimension.parse().ok().filter(|&d| d < names.len());
            let Some(d) = by_name.or_else(by_number) else {
                return Err(InputFault::NoSuchDimension {
                    name: dimension.clone(),
                    variable: variable(),
                    dimensions: dimensions(),
                });
            };
            let len = header.shape[d];
            let listed = coordinate(&names[d]).filter(|(values, _)| values.len() as u64 == len);
            let (index, note) = labelled::nearest(&names[d], len, listed, label)?;
            fixed[d] = Some(index);
            notes.extend(note);
        }
        let free = (0..names.len()).filter(|&d| fixed[d].is_none());
        let (time, others): (Vec<usize>, Vec<usize>) = free.partition(|&d| names[d] == "time");
        let long = |&d: &usize| header.shape[d] > 1;
        let mut sites: Vec<usize> = others.iter().copied().filter(long).collect();
        if sites.is_empty() {
            sites.extend(others.last());
        }
        let [time] = time[..] else {
            return Err(InputFault::NoTimes {
                variable: variable(),
                dimension: names[sites.first().copied().unwrap_or(0)].clone(),
            });
        };
        if let [_, .., _] = sites[..] {
            return Err(InputFault::FurtherDimension {
                variable: variable(),
                dimensions: dimensions(),
                dimension: Box::new(DimensionName {
                    name: names[sites[0]].clone(),
                    len: header.shape[sites[0]],
                    range: None,
                }),
            });
        }
        let strides = header.strides();
        let skipped = fixed
            .iter()
            .zip(&strides)
            .map(|(index, stride)| index.unwrap_or(0) * stride);
        let start = start + skipped.sum::<u64>() as usize;
        let size = header.sample.bytes();
        let stride = |d: usize| strides[d] as usize;
        let (n_times, n_sites) = (
            header.shape[time] as usize,
            sites.first().map_or(1, |&d| header.shape[d] as usize),
        );
        let across = sites.first().map_or(size, |&d| stride(d));
        let storage = Storage::of_strides(
            bytes,
            (header.sample, header.order),
            start,
            [n_times, n_sites],
            [stride(time) as isize, across as isize],
        );
        Ok(Contents {
            notes,
            ..Contents::of(storage, [n_times, n_sites])
        })
    }

    /// Samples without axes.
    pub(super) fn of(storage: Storage, [n_times, n_sites]: [usize; 2]) -> Contents {
        Contents {
            storage,
            n_times,
            n_sites,
            time: Coordinates::default(),
            space: Coordinates::default(),
            resampling: [None, None],
            quantity: None,
            unit: None,
            notes: Vec::new(),
            axis_names: [None, None],
            channels: Vec::new(),
            struck: None,
            masses: None,
            dispersion: None,
        }
    }

    /// Brings the samples to the axes.
    fn resampled(mut self, options: &OpenOptions) -> Result<Contents> {
        let [time, space] = &self.resampling;
        if let Some(time) = time {
            self.storage = resampled(&self.storage, self.n_sites, time, options, true)?;
        }
        if let Some(space) = space {
            self.storage = resampled(&self.storage, self.n_times, space, options, false)?;
        }
        Ok(self)
    }

    /// Adds notes on a doubtful layout and, if the file has no times, on a first site that looks
    /// like times.
    pub(super) fn note_doubts(&mut self, is_layout_known: bool) {
        let (times, sites) = (self.n_times, self.n_sites);
        if !is_layout_known {
            self.notes.extend(Note::on_shape(times, sites));
        }
        if self.time == Coordinates::default() {
            self.notes
                .extend(Note::on_samples(&self.storage, times, sites));
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
        let Opened {
            bytes,
            state,
            format,
        } = Opened::at(path, options)?;
        format.check(path, options)?;
        // The `run.toml` next to a run is its scene, and `field.toml` next to a field that this program
        // wrote that of the file it was made of: not a sidecar.
        let is_own = match format {
            Format::Npz => npz::is_own(&bytes),
            Format::Labelled(_) => labelled::own(Arc::clone(&bytes)).is_some(),
            Format::Npy | Format::Table => false,
        };
        let sidecar = Sidecar::find_for(path, is_own)?.map(|(_, sidecar)| sidecar);
        let source = FileSource {
            path,
            bytes,
            options,
            stated: options.over(sidecar.unwrap_or_default()),
        };
        let contents = match format {
            Format::Npy => read_npy(&source)?,
            Format::Npz => npz::read(&source)?,
            Format::Table => csv::read(&source)?,
            Format::Labelled(format) => labelled::read(&source, format)?,
        };
        // A copy is hashed at once: the file may be another when its hash is wanted.
        let is_copy = source.bytes.is_copy();
        let content_hash = match &state {
            None => Some(directory::hash(path)?),
            Some(_) => (options.hash || is_copy).then(|| source.bytes.hash_releasing()),
        };
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let stated = source.stated.clone();
        let field = completed(contents, stated, options, &name, &|fault| {
            source.fault(fault)
        })?;
        Ok(Field {
            opened: state.filter(|_| !is_copy),
            content_hash,
            ..field
        })
    }
}

/// Steps that differ by less are one, rounded.
const SAME_STEP: f64 = 1e-6;

/// The field of `contents`, whose axes are as `stated`, else as the contents state them.
pub(super) fn completed(
    contents: Contents,
    stated: Sidecar,
    options: &OpenOptions,
    name: &str,
    fault: &dyn Fn(InputFault) -> Error,
) -> Result<Field> {
    let contents = contents.resampled(options)?;
    // Not what a sidecar states, which is written with the samples.
    let typed = [
        options.dt.is_some() || options.rate.is_some(),
        options.dx.is_some(),
    ];
    let of_file = [contents.time.step, contents.space.step];
    let is_unit_stated = [stated.time_unit.is_some(), stated.space_unit.is_some()];
    let time = contents.time.axis(StatedAxis {
        origin: stated.t0,
        step: stated.dt,
        unit: stated.time_unit,
    });
    let space = contents.space.axis(StatedAxis {
        origin: stated.x0,
        step: stated.dx,
        unit: stated.space_unit,
    });
    let (time, space) = (time.map_err(fault)?, space.map_err(fault)?);
    let mut notes = contents.notes;
    for (n, (axis, found)) in [("time", &time), ("x", &space)].into_iter().enumerate() {
        let Some(of_file) = of_file[n].filter(|_| typed[n] && !is_unit_stated[n]) else {
            continue;
        };
        if (of_file - found.step).abs() > SAME_STEP * found.step.abs() {
            notes.push(Note::Replaced {
                axis,
                step: found.step,
                of_file,
                unit: found.unit.clone(),
            });
        }
    }
    let quantity = stated.quantity.or(contents.quantity).unwrap_or_default();
    let unit = stated.unit.or(contents.unit).map(|unit| quotient(&unit));
    notes.extend(Note::on_units(quantity, unit.as_deref(), [&time, &space]));
    let field = Field {
        name: name.to_owned(),
        time,
        space,
        quantity,
        unit,
        axis_names: contents.axis_names,
        channels: contents.channels,
        struck: contents.struck,
        masses: contents.masses,
        dispersion: stated.dispersion.or(contents.dispersion),
        notes,
        ..Field::of_storage(contents.storage, (contents.n_times, contents.n_sites))
    };
    field.selected(&options.select)
}

fn read_npy(source: &FileSource) -> Result<Contents> {
    let header = npy::Header::parse(&source.bytes).map_err(|fault| source.fault(fault))?;
    source.check_at(&header)?;
    let contents = header.check_samples().and_then(|()| {
        header.check_len(source.bytes.len() as u64)?;
        let bytes = Bytes::File(Arc::clone(&source.bytes));
        let (start, layout) = (header.data_start, source.layout());
        let at = &source.options.at;
        let mut contents = Contents::from_npy_at(&header, bytes, start, layout, at, &mut |_| None)?;
        contents.note_doubts(source.stated.layout.is_some());
        Ok(contents)
    });
    contents.map_err(|fault| source.fault(fault))
}

/// The numbers of the header of a file that may be the position of its record: those called as positions
/// are, or `asked`.
pub(super) fn header_numbers(
    path: &Path,
    options: &OpenOptions,
    asked: Option<&str>,
) -> Result<Vec<NamedNumber>> {
    let bytes = map(path)?;
    let format = Format::detect(path, &bytes).map_err(Error::input(path))?;
    let sidecar = Sidecar::find_for(path, false)?.map(|(_, sidecar)| sidecar);
    let sidecar = sidecar.unwrap_or_default();
    let x0 = sidecar.x0.map(|x0| NamedNumber {
        name: "x0".into(),
        value: x0.value,
        unit: match x0.has_unit {
            true => Some(Length::UNITS[0].0.to_owned()),
            false => sidecar.space_unit,
        },
        rounding: f64::EPSILON * x0.value.abs(),
    });
    let source = FileSource {
        path,
        bytes,
        options,
        stated: Sidecar::default(),
    };
    let mut numbers = match format {
        Format::Labelled(format) => labelled::positions(&source, format, asked)?,
        Format::Npz => npz::positions(&source, asked)?,
        Format::Npy | Format::Table => Vec::new(),
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
    is_at(path, npz::is_run)
}

/// Whether the file at `path` is a field written by this program.
///
/// # Errors
/// [`Error::Read`].
pub(crate) fn is_field_file(path: &Path) -> Result<bool> {
    is_at(path, npz::is_field)
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

/// The texts and the arrays of a NetCDF file; `None` for any other file.
///
/// # Errors
/// [`Error::Read`]; [`Error::Input`] for a damaged file.
pub(crate) fn read_container(path: &Path) -> Result<Option<labelled::Parts>> {
    let parts = labelled::parts(map(path)?).transpose();
    parts.map_err(|fault| Error::Input {
        path: path.to_owned(),
        fault: InputFault::Container {
            fault: Box::new(fault),
        },
    })
}

/// Whether an archive is one. Of other files, which may change once they are copied, the end is not looked at.
fn is_at(path: &Path, is_one: impl FnOnce(&[u8]) -> bool) -> Result<bool> {
    let mut first = [0; 2];
    let start = File::open(path).and_then(|mut file| file.read_exact(&mut first));
    if start.is_ok() && first != *b"PK" {
        return Ok(false);
    }
    match map(path) {
        // Empty, or no regular file.
        Err(Error::Input { .. }) => Ok(false),
        bytes => Ok(is_one(&bytes?)),
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

#[derive(Debug, Clone, Copy)]
pub(super) enum Format {
    Npy,
    Npz,
    Table,
    /// Of named arrays.
    Labelled(wavecascade_formats::Format),
}

impl Format {
    /// Checks that every option applies to the format.
    fn check(&self, path: &Path, options: &OpenOptions) -> Result<()> {
        let is_table = matches!(self, Format::Table);
        let has_dimensions = matches!(self, Format::Labelled(_));
        let has_arrays = has_dimensions || matches!(self, Format::Npz);
        let has_header = options.header != Header::Detect;
        let has_column = options.time_column != TimeColumn::Detect;
        let arrays = "a file of several arrays";
        let dimensions = "a file of arrays with named dimensions";
        let useless = [
            (
                "variable",
                options.variable.is_some() && !has_arrays,
                arrays,
            ),
            (
                "time-dim",
                options.time_dim.is_some() && !has_dimensions,
                dimensions,
            ),
            (
                "space-dim",
                options.space_dim.is_some() && !has_dimensions,
                dimensions,
            ),
            ("at", !options.at.is_empty() && is_table, dimensions),
            ("header", has_header && !is_table, "a table of text"),
            ("time-column", has_column && !is_table, "a table of text"),
        ];
        match useless.into_iter().find(|(_, is_useless, _)| *is_useless) {
            None => Ok(()),
            Some((option, _, expected)) => Err(Error::request(
                option,
                format!("{expected}, which alone it is for"),
                format!("{}, {}", path.display(), self.name()),
            )),
        }
    }

    pub(super) fn name(&self) -> String {
        match self {
            Format::Npy => "an array (.npy)".into(),
            Format::Npz => "an archive (.npz)".into(),
            Format::Table => "a table of text".into(),
            Format::Labelled(format) => format.to_string(),
        }
    }

    /// Detects the format from the magic bytes, else from the extension.
    pub(super) fn detect(path: &Path, bytes: &[u8]) -> Result<Format, InputFault> {
        if bytes.starts_with(npy::MAGIC) {
            return Ok(Format::Npy);
        }
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        let extension = extension.to_string_lossy();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        // Numbers of a table may look like the header of a text format.
        let is_table = matches!(extension.as_ref(), "csv" | "tsv");
        let labelled = wavecascade_formats::Format::detect(&name, bytes);
        if let Some(format) = labelled.filter(|_| !is_table) {
            return Ok(Format::Labelled(format));
        }
        if let Some(format) = ForeignFormat::detect(&extension, bytes) {
            return Err(InputFault::ForeignFormat { format });
        }
        if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
            return Ok(Format::Npz);
        }
        match extension.as_ref() {
            "npy" => Ok(Format::Npy),
            "npz" => Ok(Format::Npz),
            "csv" | "tsv" | "txt" => Ok(Format::Table),
            other => Err(InputFault::UnknownFormat {
                found: format!("the extension {other:?}"),
            }),
        }
    }
}
