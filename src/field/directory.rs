//! Stores that are directories of files.

use std::fs::File;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// BLAKE3 hash of the names and bytes of all files in a directory, in hexadecimal.
///
/// # Errors
/// [`Error::Read`].
pub(super) fn hash(directory: &Path) -> Result<String> {
    let mut files = Vec::new();
    list(directory, &mut files)?;
    files.sort_unstable();
    let mut hasher = blake3::Hasher::new();
    for path in files {
        let name = path.strip_prefix(directory).unwrap_or(&path);
        let parts: Vec<_> = name.iter().map(|part| part.to_string_lossy()).collect();
        let name = parts.join("/");
        let failed = |cause| Error::read("read", &path)(cause);
        let file = File::open(&path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        // Lengths, so that no two directories give the same bytes.
        for number in [name.len() as u64, length] {
            hasher.update(&number.to_le_bytes());
        }
        hasher.update(name.as_bytes());
        hasher.update_reader(file).map_err(failed)?;
    }
    Ok(hasher.finalize().to_hex().to_string())
}

fn list(directory: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    let failed = |cause| Error::read("read", directory)(cause);
    for entry in std::fs::read_dir(directory).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        match entry.file_type().map_err(failed)?.is_dir() {
            true => list(&entry.path(), files)?,
            false => files.push(entry.path()),
        }
    }
    Ok(())
}
