//! Files that appear whole or not at all.

use std::fs;
use std::io::Result;
use std::path::{Path, PathBuf};

/// The start of the names under which a file or directory `name` is written before it gets its own.
pub fn working_prefix(name: &str) -> String {
    format!(".{name}.partial-")
}

/// The name in `folder` under which `path` is written before the rename.
pub fn working_path(folder: &Path, path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    folder.join(working_prefix(&name) + &std::process::id().to_string())
}

/// Writes `path` through a file beside it, which is then renamed.
///
/// # Errors
/// The system's; nothing is left behind.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let working = working_path(path.parent().unwrap_or(Path::new("")), path);
    fs::write(&working, bytes)
        .and_then(|()| fs::rename(&working, path))
        .inspect_err(|_| drop(fs::remove_file(&working)))
}
