//! Files and directories that appear whole or not at all, whatever ends the process.
//!
//! A result is written under a random name beside its target and then renamed: [`Working`]. A lock,
//! which the system drops when the process ends, says whether a process still writes it. What no
//! process holds is a [`Leftover`], which the next run in the same folder removes.

mod durable;
mod leftovers;
mod lock;
mod working;

use std::ffi::OsStr;
use std::fs::File;
use std::io::{Result, Write};
use std::path::{Path, PathBuf};

pub use durable::sync_directory;
pub use leftovers::{Hold, Leftover, leftovers, remove_abandoned};
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
    let Some(name) = name.to_str() else {
        return false;
    };
    let stem = name.strip_suffix(LOCK).or(name.strip_suffix(OLD));
    is_stem(stem.unwrap_or(name))
}

/// Whether `name` is that of a working file or directory itself.
fn is_stem(name: &str) -> bool {
    name.strip_prefix(PREFIX).is_some_and(|id| {
        id.len() == DIGITS && id.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
    })
}

/// The path that a file which is being written, or one in a directory that is, will have; of other
/// files their own.
pub fn final_path(path: &Path) -> PathBuf {
    let Some(working) = path.ancestors().find(|path| has_working_name(path)) else {
        return path.to_owned();
    };
    let (Some(target), Ok(rest)) = (lock::target_of(working), path.strip_prefix(working)) else {
        return path.to_owned();
    };
    let target = working.with_file_name(target);
    let target = target.strip_prefix(".").unwrap_or(&target);
    match rest.as_os_str().is_empty() {
        true => target.to_owned(),
        false => target.join(rest),
    }
}

/// Writes `path` through a working file, durably.
///
/// A file inside a working directory is written directly: it appears with its directory, which is
/// also when it is synced. The system writes it to the disk meanwhile.
///
/// # Errors
/// The system's; nothing is left behind, and an older file stays.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    if is_in_working_directory(path) {
        let mut file = File::create(path)?;
        file.write_all(bytes)?;
        begin_sync(&file);
        return Ok(());
    }
    let mut working = Working::reserve(path)?;
    let mut file = working.create_file()?;
    file.write_all(bytes)?;
    drop(file);
    working.publish()
}

fn is_in_working_directory(path: &Path) -> bool {
    path.ancestors().skip(1).any(has_working_name)
}

fn has_working_name(path: &Path) -> bool {
    let name = path.file_name().and_then(OsStr::to_str);
    name.is_some_and(is_stem)
}
