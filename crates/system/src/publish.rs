//! Files that appear whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// How the names begin under which a file or directory `name` is written before it gets its own.
pub(crate) fn working_prefix(name: &str) -> String {
    format!(".{name}.partial-")
}

/// What is written in `folder` before it is renamed to the last component of `path`.
pub(crate) fn working_path(folder: &Path, path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    folder.join(working_prefix(&name) + &std::process::id().to_string())
}

/// Writes `path` by way of a file beside it.
///
/// # Errors
/// [`Error::Write`]; nothing is left behind.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let working = working_path(path.parent().unwrap_or(Path::new("")), path);
    fs::write(&working, bytes)
        .map_err(Error::write("write", path))
        .and_then(|()| fs::rename(&working, path).map_err(Error::write("rename to", path)))
        .inspect_err(|_| drop(fs::remove_file(&working)))
}
