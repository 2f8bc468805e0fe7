//! The field `v[n, j]`: samples at times `t_n = t0 + n dt` and sites `x_j = x0 + j dx`.
//!
//! A [`Field`] is a view of samples where they lie (in a mapped file, in an inflated archive
//! member, in an array of the caller) with its two axes. Nothing is converted or copied until a
//! block is asked for, so that a field larger than memory costs no more than the blocks in use.

mod block;
mod coordinates;
mod csv;
mod header;
mod names;
mod note;
mod npy;
mod npz;
mod open;
mod options;
mod rows;
mod sidecar;
mod state;
mod storage;

use std::ops::Range;

use ndarray::Array2;

use crate::error::Result;

pub use note::Note;
pub use options::{Header, OpenOptions, TimeColumn};
pub use sidecar::Sidecar;
pub use state::FileState;

pub(crate) use npz::{Archive as Members, read_members};
pub(crate) use open::is_field_file;
pub(crate) use open::regular_file;
pub use open::{file_hash, is_run_file};
use storage::Storage;

/// One axis: `origin + index * step`, in `unit`.
///
/// Without a unit the axis counts samples (or sites): what is not known is not invented.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub origin: f64,
    pub step: f64,
    pub unit: Option<String>,
}

impl Axis {
    /// An axis that counts: origin 0, step 1, no unit.
    pub fn index() -> Self {
        Axis {
            origin: 0.0,
            step: 1.0,
            unit: None,
        }
    }

    /// The coordinate of `index`.
    pub fn at(&self, index: usize) -> f64 {
        self.origin + index as f64 * self.step
    }
}

/// What the samples measure. Only a velocity has a kinetic energy.
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

    /// Its name in archives.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Velocity => "velocity",
            Quantity::Displacement => "displacement",
            Quantity::Acceleration => "acceleration",
            Quantity::StrainRate => "strain_rate",
            Quantity::Force => "force",
        }
    }
}

/// The order of the two axes in a file: an array of two dimensions does not say it.
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
    /// `None` where it came from no file.
    opened: Option<FileState>,
    n_times: usize,
    n_sites: usize,
    pub name: String,
    pub time: Axis,
    pub space: Axis,
    pub quantity: Quantity,
    pub unit: Option<String>,
    /// Where the field is of a simulated run: the last site that is struck, displaced or driven at its
    /// start.
    pub struck: Option<usize>,
    /// BLAKE3 of the file's bytes, in hexadecimal, where the field came from a file.
    pub content_hash: Option<String>,
    /// What was concluded about the file it came from.
    pub notes: Vec<Note>,
}

impl Field {
    /// A field from an array `(time, site)`, with axes that count.
    ///
    /// Set [`Field::time`], [`Field::space`] and the rest afterwards. Non-finite samples are
    /// allowed here; what to do with them is stated with the analysis.
    pub fn from_array(values: Array2<f64>) -> Self {
        let (n_times, n_sites) = values.dim();
        Field {
            storage: Storage::from_array(values),
            opened: None,
            n_times,
            n_sites,
            name: "field".into(),
            time: Axis::index(),
            space: Axis::index(),
            quantity: Quantity::default(),
            unit: None,
            struck: None,
            content_hash: None,
            notes: Vec::new(),
        }
    }

    pub fn n_times(&self) -> usize {
        self.n_times
    }

    pub fn n_sites(&self) -> usize {
        self.n_sites
    }

    /// Copies a block time-major: `out[(n - times.start) * sites.len() + (j - sites.start)]`.
    ///
    /// # Panics
    /// If the ranges leave the field or `out` is not as long as the block.
    pub fn read_time_major(&self, times: Range<usize>, sites: Range<usize>, out: &mut [f64]) {
        self.check_block(&times, &sites, out.len());
        self.storage.read(times, sites, false, out);
    }

    /// Copies a block site-major: `out[(j - sites.start) * times.len() + (n - times.start)]`.
    ///
    /// # Panics
    /// If the ranges leave the field or `out` is not as long as the block.
    pub fn read_site_major(&self, times: Range<usize>, sites: Range<usize>, out: &mut [f64]) {
        self.check_block(&times, &sites, out.len());
        self.storage.read(times, sites, true, out);
    }

    /// What is known of the file it came from, to be checked when the field is gone.
    pub fn file_state(&self) -> Option<FileState> {
        self.opened.clone()
    }

    /// That the file it came from is still the one that was opened and was not written to since, by
    /// length, time of modification and where there is one inode; so results are of one file, and a hash
    /// taken by now is of that one.
    ///
    /// # Errors
    /// [`crate::Error::Changed`]; [`crate::Error::Read`] where the file is gone.
    pub fn check_unchanged(&self) -> Result<()> {
        self.opened.as_ref().map_or(Ok(()), FileState::check)
    }

    /// BLAKE3 of the bytes of the file it came from, in hexadecimal, for fields that were opened without
    /// [`OpenOptions::hash`]; by all threads of the current pool. `None` where it came from no file.
    ///
    /// With `in_use`, samples that are read where they lie in the file stay mapped.
    ///
    /// # Errors
    /// [`crate::Error::Read`].
    pub fn file_hash(&self, in_use: bool) -> Result<Option<String>> {
        let Some(opened) = &self.opened else {
            return Ok(None);
        };
        match self.storage.mapped() {
            Some(map) if in_use => Ok(Some(open::hash(map, |_| ()))),
            _ => file_hash(opened.path()).map(Some),
        }
    }

    /// Whether the samples of one time are neighbours.
    pub(crate) fn is_time_major(&self) -> bool {
        self.storage.rows_are_times()
    }

    /// The samples of `times`, time by time, where they lie like that.
    pub(crate) fn stored_profiles(&self, times: Range<usize>) -> Option<&[f64]> {
        let run = times.start * self.n_sites..times.end * self.n_sites;
        let numbers = self.storage.numbers()?;
        self.is_time_major().then(|| &numbers[run])
    }

    fn check_block(&self, times: &Range<usize>, sites: &Range<usize>, len: usize) {
        assert!(times.end <= self.n_times && sites.end <= self.n_sites);
        assert_eq!(len, times.len() * sites.len());
    }

    /// Tells the operating system that mapped pages read so far need not stay in memory.
    pub(crate) fn release_pages(&self) {
        self.storage.release_pages();
    }

    /// The same of the pages that hold a block.
    pub(crate) fn release_block(&self, times: Range<usize>, sites: Range<usize>) {
        self.storage.release_block(times, sites);
    }
}
