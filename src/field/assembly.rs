//! Samples that are made row by row: in memory, or where that is not allowed, in a scratch file.

use std::fs::File;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use rayon::prelude::*;

use super::Sample;
use super::file_bytes::FileBytes;
use super::memory::SharedBytes;
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

    fn finish(self) -> Result<Arc<FileBytes>> {
        FileBytes::of_scratch(&self.file, &self.place)
    }

    /// What was written, as rows of `row_len` samples, of times or of sites.
    pub(crate) fn storage(self, row_len: usize, rows_are_times: bool) -> Result<Storage> {
        let (bytes, sample) = (Bytes::Spilled(self.finish()?), Sample::F64);
        Ok(Storage::in_rows(bytes, sample, row_len, rows_are_times))
    }
}

/// A field of which rows are added.
pub(super) struct Assembly {
    sample: Sample,
    n_rows: usize,
    row_len: usize,
    target: Target,
}

enum Target {
    Memory(Vec<u8>),
    Scratch(ScratchFile),
}

impl Assembly {
    /// Rows of `row_len` samples, zero before they are written. `what` they are is told if there is no memory.
    pub(super) fn new(
        what: &'static str,
        sample: Sample,
        [n_rows, row_len]: [usize; 2],
        options: &OpenOptions,
    ) -> Result<Assembly> {
        let needed = (n_rows as u64)
            .saturating_mul(row_len as u64)
            .saturating_mul(sample.bytes() as u64);
        let allowed = options.memory.unwrap_or_else(half_of_free_memory);
        let target = match needed <= allowed {
            true => {
                let zeros = try_filled(needed as usize, 0);
                Target::Memory(zeros.map_err(|_| Error::Refused { what, needed })?)
            }
            false => Target::Scratch(ScratchFile::new(needed)?),
        };
        Ok(Assembly {
            sample,
            n_rows,
            row_len,
            target,
        })
    }

    /// Whether the samples are held in memory.
    pub(super) fn is_in_memory(&self) -> bool {
        matches!(self.target, Target::Memory(_))
    }

    /// Writes whole rows of doubles, from row `row` on.
    pub(super) fn write(&mut self, row: usize, rows: &[f64]) -> Result<()> {
        let (from, bytes) = (row * self.row_len * 8, bytemuck::cast_slice(rows));
        match &mut self.target {
            Target::Memory(all) => {
                all[from..from + bytes.len()].copy_from_slice(bytes);
                Ok(())
            }
            Target::Scratch(file) => file.write(from as u64, bytes),
        }
    }

    /// Has `read` make all rows, at most so many `at_once`.
    pub(super) fn fill(
        &mut self,
        at_once: usize,
        read: impl Fn(Range<usize>, &mut [u8]) -> Result<()> + Sync,
    ) -> Result<()> {
        let row = self.row_len * self.sample.bytes();
        let part = |n: usize| n * at_once..self.n_rows.min((n + 1) * at_once);
        match &mut self.target {
            Target::Memory(all) => {
                let parts = all.par_chunks_mut(at_once * row).enumerate();
                parts.try_for_each(|(n, out)| read(part(n), out))
            }
            Target::Scratch(file) => {
                let refused = |_| Error::Refused {
                    what: "a part of the field that is decoded at once",
                    needed: (at_once * row) as u64,
                };
                let mut out = try_filled(at_once * row, 0).map_err(refused)?;
                for part in (0..self.n_rows.div_ceil(at_once)).map(part) {
                    let out = &mut out[..part.len() * row];
                    read(part.clone(), out)?;
                    file.write((part.start * row) as u64, out)?;
                }
                Ok(())
            }
        }
    }

    /// The samples, with rows of times or of sites.
    pub(super) fn finish(self, rows_are_times: bool) -> Result<Storage> {
        let bytes = match self.target {
            Target::Memory(all) => Bytes::Held(SharedBytes::new(all)),
            Target::Scratch(file) => Bytes::Spilled(file.finish()?),
        };
        let (sample, row_len) = (self.sample, self.row_len);
        Ok(Storage::in_rows(bytes, sample, row_len, rows_are_times))
    }
}
