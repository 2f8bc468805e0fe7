//! Files and directories that appear whole or not at all, whatever ends the process.
//!
//! A result is written under a random name beside its target and then renamed: [`Working`]. A lock,
//! which the system drops when the process ends, says whether a process still writes it. What no
//! process holds is removed by the next run in the same folder ([`remove_abandoned`]).

mod abandoned;
mod durable;
mod lock;
mod working;

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{Result, Write};
use std::path::{Path, PathBuf};

pub use abandoned::remove_abandoned;
pub use durable::sync_directory;
pub use working::Working;

use crate::file_io::begin_sync;

/// How the names of working files and directories begin; 16 hexadecimal digits follow.
const PREFIX: &str = ".cascade-partial-";
const DIGITS: usize = 16;

/// Suffix of the lock of a working file, and of the old result between two renames.
const LOCK: &str = ".lock";
const OLD: &str = ".old";

/// Whether a file or directory of this name belongs to a result that is being written, or to a run
/// that was killed.
pub fn is_working_name(name: &OsStr) -> bool {
    stem_of(name).is_some()
}

/// Of a name that belongs to a working file or directory, the name of that itself.
fn stem_of(name: &OsStr) -> Option<&str> {
    let name = name.to_str()?;
    let stem = name.strip_suffix(LOCK).or(name.strip_suffix(OLD));
    let stem = stem.unwrap_or(name);
    let id = stem.strip_prefix(PREFIX)?;
    let is_id = id.len() == DIGITS && id.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
    is_id.then_some(stem)
}

/// Whether `path` is that of a working file or directory itself.
fn is_working(path: &Path) -> bool {
    path.file_name()
        .is_some_and(|name| stem_of(name).is_some_and(|stem| stem == name))
}

/// The path that a file which is being written, or one in a directory that is, will have; of other
/// files their own.
pub fn final_path(path: &Path) -> PathBuf {
    let of_working = || {
        let working = path.ancestors().find(|path| is_working(path))?;
        let target = working.with_file_name(lock::target_of(working)?);
        let target = target.strip_prefix(".").unwrap_or(&target);
        let rest = path.strip_prefix(working).ok()?;
        Some(target.join(rest).components().collect())
    };
    of_working().unwrap_or_else(|| path.to_owned())
}

/// Writes `path` through a working file, durably.
///
/// A file inside a working directory is written directly: it appears with its directory, which is
/// also when it is synced. The system writes it to the disk meanwhile.
///
/// # Errors
/// The system's; nothing is left behind, and an older file stays.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    if path.ancestors().skip(1).any(is_working) {
        let mut file = File::create(path)?;
        file.write_all(bytes)?;
        begin_sync(&file);
        return Ok(());
    }
    let mut working = Working::reserve(path)?;
    working.create_file()?.write_all(bytes)?;
    working.publish()
}

/// The working path with a suffix: that of its lock, or of the old result.
fn beside(working: &Path, suffix: &str) -> PathBuf {
    let mut name = working.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Whether something has this name; the empty one is that of the current directory.
fn is_there(path: &Path) -> bool {
    path.as_os_str().is_empty() || fs::symlink_metadata(path).is_ok()
}
