//! Samples that are made row by row: in memory, or where that is not allowed, in a scratch file.

use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;

use super::Sample;
use super::file_bytes::FileBytes;
use super::options::OpenOptions;
use super::storage::{Bytes, Storage};
use crate::error::{Error, Result};
use crate::system::file_io::{allocate, read_at, write_at};
use crate::system::memory::{half_of_free_memory, try_filled};

/// An unnamed file, which disappears when it is closed, however the program ends.
#[derive(Debug)]
pub(crate) struct ScratchFile {
    file: File,
    place: PathBuf,
}

impl ScratchFile {
    /// One of `length` bytes, whose space is reserved.
    pub(crate) fn new(length: u64) -> Result<ScratchFile> {
        let place = std::env::temp_dir();
        let file = tempfile::tempfile().map_err(Error::write("make a scratch file in", &place))?;
        allocate(&file, 0, length).map_err(Error::write("reserve a scratch file in", &place))?;
        Ok(ScratchFile { file, place })
    }

    pub(crate) fn write(&self, from: u64, bytes: &[u8]) -> Result<()> {
        write_at(&self.file, bytes, from)
            .map_err(Error::write("write a scratch file in", &self.place))
    }

    pub(crate) fn read(&self, from: u64, bytes: &mut [u8]) -> Result<()> {
        read_at(&self.file, bytes, from).map_err(Error::read("read a scratch file in", &self.place))
    }

    pub(super) fn finish(self) -> Result<Arc<FileBytes>> {
        FileBytes::of_scratch(&self.file, &self.place)
    }

    /// What was written, as rows of `row_len` samples, of times or of sites.
    pub(crate) fn storage(self, row_len: usize, rows_are_times: bool) -> Result<Storage> {
        let bytes = Bytes::Spilled(self.finish()?);
        Ok(Storage::in_rows(
            bytes,
            Sample::F64,
            row_len,
            rows_are_times,
        ))
    }
}

/// A field of which rows are added.
pub(super) struct Assembly {
    row_len: usize,
    target: Target,
}

enum Target {
    Memory(Vec<f64>),
    Scratch(ScratchFile),
}

impl Assembly {
    /// Rows of `row_len` samples, zero before they are written. `what` they are is told if there is no memory.
    pub(super) fn new(
        what: &'static str,
        [n_rows, row_len]: [usize; 2],
        options: &OpenOptions,
    ) -> Result<Assembly> {
        let needed = (n_rows as u64)
            .saturating_mul(row_len as u64)
            .saturating_mul(size_of::<f64>() as u64);
        let allowed = options.memory.unwrap_or_else(half_of_free_memory);
        let target = match needed <= allowed {
            true => Target::Memory(
                try_filled(n_rows * row_len, 0.0).map_err(|_| Error::Refused { what, needed })?,
            ),
            false => Target::Scratch(ScratchFile::new(needed)?),
        };
        Ok(Assembly { row_len, target })
    }

    /// Writes whole rows, from row `row` on.
    pub(super) fn write(&mut self, row: usize, rows: &[f64]) -> Result<()> {
        let from = row * self.row_len;
        match &mut self.target {
            Target::Memory(all) => {
                all[from..from + rows.len()].copy_from_slice(rows);
                Ok(())
            }
            Target::Scratch(file) => {
                file.write((from * size_of::<f64>()) as u64, bytemuck::cast_slice(rows))
            }
        }
    }

    /// The samples, with rows of times or of sites.
    pub(super) fn finish(self, rows_are_times: bool) -> Result<Storage> {
        match self.target {
            Target::Memory(all) => Ok(Storage::from_values(all, self.row_len, rows_are_times)),
            Target::Scratch(file) => file.storage(self.row_len, rows_are_times),
        }
    }
}
