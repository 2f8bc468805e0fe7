//! The bytes of a file: mapped, or read into memory.

use std::fs::{File, Metadata};
use std::io::Read;
use std::ops::{Deref, Range};
use std::path::Path;
use std::sync::Arc;

use memmap2::Mmap;

use super::options::ReadMode;
use super::state::FileState;
use crate::error::{Error, Fault, Result, UNFINISHED};
use crate::system::signals::Watched;

/// Bytes that are treated at a time.
const CHUNK: usize = 16 << 20;

/// All bytes of a file.
#[derive(Debug)]
pub(crate) enum FileBytes {
    /// Another program that shortens the file has reads of the missing pages end the process.
    Mapped {
        // Dropped before the other.
        map: Mmap,
        _watched: Watched,
    },
    Copied(Vec<u8>),
}

impl AsRef<[u8]> for FileBytes {
    fn as_ref(&self) -> &[u8] {
        self
    }
}

impl Deref for FileBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            FileBytes::Mapped { map, .. } => map,
            FileBytes::Copied(bytes) => bytes,
        }
    }
}

impl wavecascade_formats::FileBytes for FileBytes {
    fn release(&self, range: Range<usize>) {
        FileBytes::release(self, range);
    }
}

impl FileBytes {
    /// The file at `path` and its state when it was opened. `allow` says whether that many bytes may
    /// be copied to memory.
    pub(super) fn open(
        path: &Path,
        mode: ReadMode,
        allow: impl FnOnce(u64) -> Result<()>,
    ) -> Result<(Arc<FileBytes>, FileState)> {
        let is_empty = regular_file(path)?.len() == 0;
        let file = File::open(path).map_err(Error::read("open", path))?;
        if is_empty {
            let fault = Fault::expected("samples", "an empty file", UNFINISHED);
            return Err(Error::input(path)(fault));
        }
        let opened = FileState::opened(&file, path)?;
        let bytes = match mode {
            ReadMode::Map => FileBytes::map(&file, path)?,
            ReadMode::Copy => {
                allow(opened.length())?;
                let bytes = FileBytes::copy(file, opened.length(), path)?;
                opened.check()?;
                bytes
            }
        };
        Ok((Arc::new(bytes), opened))
    }

    /// Those of a directory, whose files are read by themselves.
    pub(super) fn of_directory() -> Arc<FileBytes> {
        Arc::new(FileBytes::Copied(Vec::new()))
    }

    fn map(file: &File, path: &Path) -> Result<FileBytes> {
        // SAFETY: the map is read-only and as long as the file is now. `Field::open` documents the
        // condition that no other program truncates the file meanwhile.
        let map = unsafe { Mmap::map(file) }.map_err(Error::read("map", path))?;
        Ok(FileBytes::Mapped {
            _watched: Watched::new(&map, path),
            map,
        })
    }

    /// All bytes of an unnamed scratch file in the folder `place`.
    pub(super) fn of_scratch(file: &File, place: &Path) -> Result<Arc<FileBytes>> {
        Ok(Arc::new(FileBytes::map(file, place)?))
    }

    fn copy(mut file: File, length: u64, path: &Path) -> Result<FileBytes> {
        let mut bytes = Vec::new();
        let reserved = bytes.try_reserve_exact(length as usize);
        let reserved = reserved.map_err(std::io::Error::other);
        let read = reserved.and_then(|()| file.by_ref().take(length).read_to_end(&mut bytes));
        read.map_err(Error::read("read", path))?;
        Ok(FileBytes::Copied(bytes))
    }

    /// Whether they are in memory, where nobody else changes them.
    pub(super) fn is_copy(&self) -> bool {
        matches!(self, FileBytes::Copied(_))
    }

    /// Drops the mapped pages of `range` from this process; a later access reads them again.
    pub(crate) fn release(&self, range: Range<usize>) {
        #[cfg(unix)]
        if let FileBytes::Mapped { map, .. } = self {
            let advice = memmap2::UncheckedAdvice::DontNeed;
            // SAFETY: the map is read-only and file-backed, so a dropped page comes back with the
            // same bytes. A failure only keeps the page, which is harmless.
            let _kept = unsafe { map.unchecked_advise_range(advice, range.start, range.len()) };
        }
        #[cfg(not(unix))]
        let _ = range;
    }

    /// Has the system read `range` of a mapped file while something else is done.
    pub(crate) fn fetch(&self, range: Range<usize>) {
        #[cfg(unix)]
        if let FileBytes::Mapped { map, .. } = self {
            // Without it, the samples are read when they are touched.
            let _hint = map.advise_range(memmap2::Advice::WillNeed, range.start, range.len());
        }
        #[cfg(not(unix))]
        let _ = range;
    }

    /// Passes `range` to `consume` in chunks, in order; drops each chunk's pages afterwards.
    pub(super) fn stream(&self, range: Range<usize>, mut consume: impl FnMut(&[u8])) {
        let mut start = range.start;
        while start < range.end {
            let end = range.end.min(start + CHUNK);
            consume(&self[start..end]);
            self.release(start..end);
            start = end;
        }
    }

    /// BLAKE3 hash in hexadecimal; passes each finished range to `done`.
    pub(super) fn hash(&self, mut done: impl FnMut(Range<usize>)) -> String {
        let mut hasher = blake3::Hasher::new();
        for start in (0..self.len()).step_by(CHUNK) {
            let chunk = start..self.len().min(start + CHUNK);
            hasher.update_rayon(&self[chunk.clone()]);
            done(chunk);
        }
        hasher.finalize().to_hex().to_string()
    }

    /// BLAKE3 hash in hexadecimal; releases pages progressively.
    pub(super) fn hash_releasing(&self) -> String {
        self.hash(|done| self.release(done))
    }
}

/// Metadata of a regular file; rejects others without opening them (opening a pipe would block).
pub(crate) fn regular_file(path: &Path) -> Result<Metadata> {
    let metadata = std::fs::metadata(path).map_err(Error::read("read", path))?;
    match irregular_kind(&metadata) {
        None => Ok(metadata),
        Some(found) => {
            let advice = "name a file inside it, or write the samples to a file first";
            let fault = Fault::expected("a file", found, advice);
            Err(Error::input(path)(fault))
        }
    }
}

fn irregular_kind(metadata: &Metadata) -> Option<&'static str> {
    let kind = metadata.file_type();
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return Some("a pipe");
        }
        if kind.is_socket() {
            return Some("a socket");
        }
    }
    match () {
        _ if kind.is_dir() => Some("a directory"),
        _ if kind.is_file() => None,
        _ => Some("a device"),
    }
}
