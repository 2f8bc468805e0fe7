//! Zarr, versions 2 and 3: folders of chunks.

mod json;
mod quiet;
mod walk;

use std::path::Path;
use std::sync::Arc;

use zarrs::array::codec::CodecOptions;
use zarrs::array::{Array, ArrayBytes, ArrayShardedExt};
use zarrs::array_subset::ArraySubset;
use zarrs::filesystem::FilesystemStore;

use crate::container::{Block, Decoder, MAX_INFLATION, assign_coordinates};
use crate::{Bytes, Container, Error, Format, Options, Result, Sample};
use walk::Walk;

/// What any store may stand for: chunks that were never written cost nothing.
const SMALL: u64 = 64 << 20;

/// Opens the store in `folder`.
pub(crate) fn open(format: Format, folder: &Path, options: &Options) -> Result<Container> {
    let store = FilesystemStore::new(folder)
        .map_err(|cause| Error::damaged("the store", "a folder", cause.to_string()))?;
    let name = folder.file_stem().unwrap_or_default().to_string_lossy();
    let mut walk = Walk::new(Arc::new(store), &name);
    walk.visit(folder, "", 0)?;
    assign_coordinates(&mut walk.variables);
    let no_bytes: Bytes = Arc::new(Vec::<u8>::new());
    let mut container = Container::new(format, &no_bytes);
    let stored = length(folder, 0);
    container.most_bytes = stored.saturating_mul(MAX_INFLATION).max(SMALL);
    container.attributes = walk.attributes;
    for (variable, array) in walk.variables.into_iter().zip(walk.arrays) {
        match array {
            Some(array) => {
                let (most, memory) = (container.most_bytes, options.memory);
                let stored = Stored {
                    most,
                    memory,
                    ..array
                };
                container.push_decoded(variable, stored);
            }
            None => container.push(variable),
        }
    }
    Ok(container)
}

/// An array of numbers.
struct Stored {
    name: String,
    array: Array<FilesystemStore>,
    /// Rows of what is decoded at once: a chunk, or one within a shard.
    rows: u64,
    /// Bytes of a decoded chunk; of a shard, all of it.
    chunk: u64,
    /// Most bytes that the store stands for.
    most: u64,
    /// Bytes that decoding may take.
    memory: Option<u64>,
}

impl Stored {
    fn new(name: &str, array: Array<FilesystemStore>, sample: Sample) -> Result<Stored> {
        let place = || format!("variable {name}");
        let rank = array.shape().len();
        let whole = array
            .chunk_shape(&vec![0; rank])
            .map_err(|cause| Error::damaged(place(), "chunks", cause.to_string()))?;
        let lengths = whole.iter().map(|len| len.get());
        let chunk = lengths.fold(Some(sample.bytes() as u64), |n, len| n?.checked_mul(len));
        let chunk = chunk.ok_or_else(|| {
            let found = format!("chunks of {:?}", &whole[..]);
            Error::damaged(place(), "chunks of fewer than 2^64 bytes", found)
        })?;
        let part = array.effective_inner_chunk_shape().unwrap_or(whole);
        Ok(Stored {
            name: name.to_owned(),
            rows: part.first().map_or(1, |len| len.get()),
            array,
            chunk,
            most: u64::MAX,
            memory: None,
        })
    }

    /// How many chunks are decoded at once, beside a copy of `wanted` bytes.
    fn chunks_at_once(&self, wanted: u64) -> Result<usize> {
        let threads = rayon::current_num_threads();
        let Some(allowed) = self.memory else {
            return Ok(threads);
        };
        // Encoded and decoded.
        let chunk = self.chunk.saturating_mul(2).max(1);
        let needed = wanted.saturating_add(chunk);
        if needed > allowed {
            return Err(Error::Memory {
                what: format!("a chunk of {}", self.name),
                needed,
                allowed,
            });
        }
        let fitting = usize::try_from((allowed - wanted) / chunk).unwrap_or(usize::MAX);
        Ok(fitting.clamp(1, threads))
    }
}

impl Decoder for Stored {
    fn read(&self, block: Block, out: &mut [u8]) -> Result<()> {
        let place = || format!("variable {}", self.name);
        if self.chunk > self.most {
            let expected = format!("chunks of at most {} bytes in this store", self.most);
            return Err(Error::damaged(place(), expected, self.chunk));
        }
        let mut options = CodecOptions::default();
        options.set_concurrent_target(self.chunks_at_once(out.len() as u64)?);
        let subset = ArraySubset::new_with_ranges(block);
        let read = || self.array.retrieve_array_subset_opt(&subset, &options);
        let bytes = caught(&place(), read)?;
        let bytes = bytes.map_err(|cause| Error::damaged(place(), "sound chunks", cause))?;
        match bytes {
            ArrayBytes::Fixed(bytes) if bytes.len() == out.len() => {
                out.copy_from_slice(&bytes);
                Ok(())
            }
            _ => {
                let expected = format!("{} bytes", out.len());
                Err(Error::damaged(place(), expected, "another number"))
            }
        }
    }
}

/// Bytes of all files in a folder; links are not followed.
fn length(folder: &Path, level: usize) -> u64 {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let lengths = entries.map(|entry| match entry.metadata() {
        Ok(found) if found.is_dir() && level < 128 => length(&entry.path(), level + 1),
        Ok(found) if found.is_file() => found.len(),
        _ => 0,
    });
    lengths.fold(0, u64::saturating_add)
}

/// What `zarrs` makes of files, which on some damaged ones panics: on a chunk shorter than its checksum.
fn caught<T>(place: &str, call: impl FnOnce() -> T) -> Result<T> {
    let silence = quiet::Silence::new();
    // What a panic leaves behind is not used again but for reading.
    let called = std::panic::catch_unwind(std::panic::AssertUnwindSafe(call));
    drop(silence);
    called.map_err(|_| Error::damaged(place, "a sound array", "one that its decoder fails on"))
}
