//! The field `v[n, j]`: samples at times `t_n = t0 + n dt` and sites `x_j = x0 + j dx`.
//!
//! A [`Field`] is a view of samples with its two axes. The samples stay in a mapped file, an
//! inflated archive member, or an array of the caller. They are converted and copied block by block
//! on request, so a field may be larger than memory.

mod align;
mod assembly;
mod beside;
mod block;
mod coordinates;
mod csv;
mod directory;
mod file_bytes;
mod graded;
mod header;
mod inspect;
mod interpolate;
mod labelled;
mod meaning;
mod memory;
mod note;
mod open;
mod options;
mod preamble;
mod resample;
mod rows;
mod scan;
mod select;
mod sidecar;
mod stamp;
mod state;
mod statements;
mod storage;
mod written;

use std::ops::Range;

use ndarray::Array2;

use crate::arrays::Precision;
use crate::error::{Error, Result};

pub use inspect::{Inspection, VariableInfo, inspect};
pub use interpolate::Interpolation;
pub use memory::{ListedAxis, MemoryLabels, MemorySamples, SharedBytes};
pub use note::Note;
pub use options::{At, Delays, Header, Label, OpenOptions, ReadMode, Selection, TimeColumn};
pub use resample::Resample;
pub use scan::{EqualPositions, PositionFrom, Scan, ScanRecord, Scanned};
pub use sidecar::Sidecar;
pub use state::FileState;
pub use wavecascade_formats::{ByteOrder, Sample};

pub(crate) use assembly::ScratchFile;
pub(crate) use file_bytes::regular_file;
pub(crate) use graded::graded_masses;
pub(crate) use labelled::Arrays as Members;
pub use open::{file_hash, is_run_file};
pub(crate) use open::{is_field_file, is_netcdf, is_run_archive, own_netcdf, read_members};
pub(crate) use storage::Storage;
pub(crate) use written::{array_hash, check_written};

/// One axis: `origin + index * step`, in `unit`.
///
/// Without a unit the axis counts samples or sites.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Axis {
    pub origin: f64,
    pub step: f64,
    pub unit: Option<String>,
}

impl Axis {
    /// An axis of indices: origin 0, step 1, no unit.
    pub fn index() -> Self {
        Axis {
            origin: 0.0,
            step: 1.0,
            unit: None,
        }
    }

    /// Words for its unit of time: its name, `sample` where it counts, else `unit of time`.
    pub fn time_unit(&self) -> String {
        self.unit_or("sample", "unit of time")
    }

    /// The same of an axis of positions: `site`, or `unit of length`.
    pub fn space_unit(&self) -> String {
        self.unit_or("site", "unit of length")
    }

    fn unit_or(&self, counted: &str, stepped: &str) -> String {
        let word = if self.step == 1.0 { counted } else { stepped };
        self.unit.clone().unwrap_or_else(|| word.into())
    }

    /// The coordinate of `index`.
    pub fn at(&self, index: usize) -> f64 {
        self.origin + index as f64 * self.step
    }
}

/// The physical quantity of the samples. Only a velocity has a kinetic energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    #[default]
    Velocity,
    Displacement,
    Acceleration,
    StrainRate,
    Force,
}

impl Quantity {
    pub const ALL: [Quantity; 5] = [
        Quantity::Velocity,
        Quantity::Displacement,
        Quantity::Acceleration,
        Quantity::StrainRate,
        Quantity::Force,
    ];

    /// The name of its member in archives.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Velocity => "velocity",
            Quantity::Displacement => "displacement",
            Quantity::Acceleration => "acceleration",
            Quantity::StrainRate => "strain_rate",
            Quantity::Force => "force",
        }
    }

    pub(crate) fn in_words(self) -> &'static str {
        match self {
            Quantity::StrainRate => "strain rate",
            other => other.name(),
        }
    }
}

/// The order of the two axes in a file. A two-dimensional array does not state it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// The first index counts times, the second sites.
    #[default]
    TimeSite,
    /// The first index counts sites, the second times.
    SiteTime,
}

/// A field of samples with its axes; see the [module](self) documentation.
#[derive(Debug, Clone)]
pub struct Field {
    storage: Storage,
    /// `None` if the field was not read from a file.
    opened: Option<FileState>,
    n_times: usize,
    n_sites: usize,
    pub name: String,
    pub time: Axis,
    pub space: Axis,
    pub quantity: Quantity,
    pub unit: Option<String>,
    /// Names that the file gives to times and sites.
    pub(crate) axis_names: [Option<String>; 2],
    /// Names that the file gives to single sites.
    pub(crate) channels: Vec<String>,
    /// In a simulated run, the last site that is struck, displaced or driven at the start.
    pub struck: Option<usize>,
    /// In a simulated run whose bodies or contacts are not those of a repeated cell, the masses.
    pub masses: Option<Vec<f64>>,
    /// Dispersion relation that the sidecar states, as [`Dispersion::parse`] takes it.
    ///
    /// [`Dispersion::parse`]: crate::analyze::Dispersion::parse
    pub dispersion: Option<String>,
    /// BLAKE3 hash of the file in hexadecimal, if the field was read from a file.
    pub content_hash: Option<String>,
    /// What was inferred about the file.
    pub notes: Vec<Note>,
}

impl Field {
    /// Whether nothing states which axis is time, and the other choice is as likely.
    pub(crate) fn has_guessed_layout(&self) -> bool {
        self.notes.iter().any(|note| note.code == "wide-array")
    }

    /// That both axes have a step above 0, since whoever makes a field may set any.
    ///
    /// # Errors
    /// [`Error::Request`].
    pub(crate) fn check_axes(&self) -> Result<()> {
        for (option, axis) in [("dt", &self.time), ("dx", &self.space)] {
            if !(axis.step > 0.0 && axis.step.is_finite() && axis.origin.is_finite()) {
                let expected =
                    "a step above 0 and a finite origin: set `Field::time` and `Field::space`";
                let found = format!("a step of {} from {} on", axis.step, axis.origin);
                return Err(Error::request(option, expected, found));
            }
        }
        Ok(())
    }

    /// A field from an array `(time, site)`, with axes of indices.
    ///
    /// Set [`Field::time`], [`Field::space`] and the other fields afterwards. Non-finite samples
    /// are allowed; the options of the analysis state how to treat them.
    pub fn from_array(values: Array2<f64>) -> Self {
        let shape = values.dim();
        Field::of_storage(Storage::from_array(values), shape)
    }

    /// The same from samples in storage.
    pub(crate) fn of_storage(storage: Storage, (n_times, n_sites): (usize, usize)) -> Self {
        Field {
            storage,
            opened: None,
            n_times,
            n_sites,
            name: "field".into(),
            time: Axis::index(),
            space: Axis::index(),
            quantity: Quantity::default(),
            unit: None,
            axis_names: [None, None],
            channels: Vec::new(),
            struck: None,
            masses: None,
            dispersion: None,
            content_hash: None,
            notes: Vec::new(),
        }
    }

    /// The same without its samples.
    fn without_samples(self) -> Field {
        let storage = Storage::from_values(Vec::new(), 0, true);
        Field { storage, ..self }
    }

    pub fn n_times(&self) -> usize {
        self.n_times
    }

    pub fn n_sites(&self) -> usize {
        self.n_sites
    }

    /// The same samples with the axes exchanged: snapshots are its records. No copy is made.
    pub(crate) fn transposed(&self) -> Field {
        let [times, sites] = self.axis_names.clone();
        Field {
            storage: self.storage.transposed(),
            n_times: self.n_sites,
            n_sites: self.n_times,
            time: self.space.clone(),
            space: self.time.clone(),
            axis_names: [sites, times],
            channels: Vec::new(),
            struck: None,
            masses: None,
            ..self.clone()
        }
    }

    /// Copies a block in time-major order: `out[(n - times.start) * sites.len() + (j -
    /// sites.start)]`.
    ///
    /// # Panics
    /// If the ranges leave the field or `out` is not as long as the block.
    pub fn read_time_major(&self, times: Range<usize>, sites: Range<usize>, out: &mut [f64]) {
        self.check_block(&times, &sites, out.len());
        self.storage.read(times, sites, false, out);
    }

    /// Copies a block in site-major order: `out[(j - sites.start) * times.len() + (n -
    /// times.start)]`.
    ///
    /// # Panics
    /// If the ranges leave the field or `out` is not as long as the block.
    pub fn read_site_major(&self, times: Range<usize>, sites: Range<usize>, out: &mut [f64]) {
        self.check_block(&times, &sites, out.len());
        self.storage.read(times, sites, true, out);
    }

    /// The state of the file when it was opened; it can be checked after the field is dropped.
    pub fn file_state(&self) -> Option<FileState> {
        self.opened.clone()
    }

    /// Checks that the file was neither modified nor replaced since it was opened.
    ///
    /// Compares length, modification time and, where the system has them, inode and time of the last
    /// change, which no program can set. If it succeeds after
    /// an analysis and a hash, both are of the same file.
    ///
    /// # Errors
    /// [`crate::Error::Changed`]; [`crate::Error::Read`] if the file is gone.
    pub fn check_unchanged(&self) -> Result<()> {
        self.opened.as_ref().map_or(Ok(()), FileState::check)
    }

    /// BLAKE3 hash of the file in hexadecimal, for fields opened without [`OpenOptions::hash`].
    ///
    /// `None` if the field was not read from a file. Uses all threads of the current pool. With
    /// `in_use`, the pages of a mapped file stay in memory.
    ///
    /// # Errors
    /// [`crate::Error::Read`].
    pub fn file_hash(&self, in_use: bool) -> Result<Option<String>> {
        let Some(opened) = &self.opened else {
            return Ok(self.content_hash.clone());
        };
        match self.storage.file() {
            Some(bytes) if in_use => Ok(Some(bytes.hash(|_| ()))),
            _ => file_hash(opened.path()).map(Some),
        }
    }

    /// The shorter of the two precisions that holds every sample as it is stored: single precision for
    /// floats of 32 and 16 bits and integers of at most 16 bits.
    pub fn precision(&self) -> Precision {
        match self.storage.is_single() {
            true => Precision::F32,
            false => Precision::F64,
        }
    }

    /// Whether the samples of one time are contiguous.
    pub(crate) fn is_time_major(&self) -> bool {
        self.storage.rows_are_times()
    }

    /// The samples of `times` in time-major order, if they are stored as native `f64` in that
    /// order.
    pub(crate) fn stored_profiles(&self, times: Range<usize>) -> Option<&[f64]> {
        let run = times.start * self.n_sites..times.end * self.n_sites;
        let numbers = self.storage.numbers(self.n_sites)?;
        self.is_time_major().then(|| &numbers[run])
    }

    fn check_block(&self, times: &Range<usize>, sites: &Range<usize>, len: usize) {
        assert!(times.end <= self.n_times && sites.end <= self.n_sites);
        assert_eq!(len, times.len() * sites.len());
    }

    /// Lets the operating system drop mapped pages of the file from memory.
    pub(crate) fn release_pages(&self) {
        self.storage.release_pages();
    }

    /// Bytes of samples in memory that are no pages of a file: of a table or an inflated member.
    pub(crate) fn loaded_bytes(&self) -> u64 {
        match self.opened.is_some() || self.content_hash.is_some() {
            true => self.storage.loaded_bytes(),
            false => 0,
        }
    }

    /// As [`Field::read_time_major`]. Where records are contiguous in a mapped file, a block of times has
    /// pages of all of them: they are read a few at a time, and their pages let go of.
    pub(crate) fn read_releasing(&self, times: Range<usize>, sites: Range<usize>, out: &mut [f64]) {
        /// Records whose pages are held at once, with those that the system maps around them.
        const RECORDS: usize = 32;
        if self.is_time_major() || self.storage.mapped().is_none() {
            return self.read_time_major(times, sites, out);
        }
        let width = sites.len();
        let mut some = vec![0.0; times.len() * RECORDS.min(width)];
        for from in sites.clone().step_by(RECORDS) {
            let group = from..sites.end.min(from + RECORDS);
            let some = &mut some[..times.len() * group.len()];
            self.storage.fetch_block(times.clone(), group.clone());
            self.read_time_major(times.clone(), group.clone(), some);
            let at = from - sites.start;
            let rows = out.chunks_exact_mut(width);
            for (row, read) in rows.zip(some.chunks_exact(group.len())) {
                row[at..at + group.len()].copy_from_slice(read);
            }
            self.release_block(times.clone(), group);
        }
    }

    /// As [`Field::release_pages`], for the pages of a block.
    pub(crate) fn release_block(&self, times: Range<usize>, sites: Range<usize>) {
        self.storage.release_block(times, sites);
    }
}
