//! The lock of a working file: who holds it, and what it was to become.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::hash::{BuildHasher, RandomState};
use std::io::{ErrorKind, Read, Result, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::{DIGITS, LOCK, PREFIX, beside};

/// A lock file is at most as long as this: an identifier of the machine and a file name.
const LONGEST: u64 = 8 << 10;

/// How often a name is chosen anew.
const TRIES: usize = 16;

/// Creates a lock in `folder` under a random name, for the target of this name: the file, locked as long as it is open, and
/// the path of the working file that it belongs to.
///
/// A cleaner that finds the file before it is locked may take it for a leftover. It removes a
/// file only while it holds the lock, so the owner who got the lock and still finds the file in
/// its place is safe; one who does not begins again under another name.
pub(super) fn create(folder: &Path, target: &OsStr) -> Result<(File, PathBuf)> {
    for _ in 0..TRIES {
        // Whoever has the name nevertheless has created it exclusively.
        let id = RandomState::new().hash_one((std::process::id(), SystemTime::now()));
        let working = folder.join(format!("{PREFIX}{id:0DIGITS$x}"));
        let path = beside(&working, LOCK);
        let mut options = OpenOptions::new();
        let mut file = match options.read(true).write(true).create_new(true).open(&path) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
            opened => opened?,
        };
        // Without locks there is no cleaner either: it removes nothing it cannot lock.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            let _ = fs::remove_file(&path);
            continue;
        }
        if is_at(&file, &path) {
            let text = [machine().as_bytes(), b"\n", target.as_encoded_bytes()].concat();
            let noted = file.write_all(&text);
            noted.inspect_err(|_| drop(fs::remove_file(&path)))?;
            return Ok((file, working));
        }
    }
    Err(ErrorKind::AlreadyExists.into())
}

/// The lock of another owner, who has let it go; others are kept away as long as this lives.
#[derive(Debug)]
pub(super) struct Released {
    _file: File,
    /// Whether it was written under the running kernel.
    pub(super) is_of_this_machine: bool,
    pub(super) target: Option<OsString>,
}

impl Released {
    /// `None` where a process has the lock, or where the file cannot be locked here or is none.
    pub(super) fn take(path: &Path) -> Option<Released> {
        let mut options = OpenOptions::new();
        // A network system locks only what is open for writing.
        options.read(true).write(true);
        #[cfg(unix)]
        {
            use rustix::fs::OFlags;
            use std::os::unix::fs::OpenOptionsExt;
            let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
            options.custom_flags(flags.bits().cast_signed());
        }
        let is_file = fs::symlink_metadata(path).ok()?.is_file();
        let mut file = is_file.then(|| options.open(path).ok())??;
        file.try_lock().ok()?;
        let (then, target) = read(&mut file);
        Some(Released {
            _file: file,
            is_of_this_machine: then == machine(),
            target,
        })
    }
}

/// Name that the working file of this path will have.
pub(super) fn target_of(working: &Path) -> Option<OsString> {
    read(&mut File::open(beside(working, LOCK)).ok()?).1
}

/// The machine and the target that a lock names.
fn read(file: &mut File) -> (String, Option<OsString>) {
    let mut text = Vec::new();
    let is_read = file.take(LONGEST).read_to_end(&mut text).is_ok();
    let end = text.iter().position(|&byte| byte == b'\n');
    let Some(end) = end.filter(|_| is_read) else {
        return (String::new(), None);
    };
    let name = text.split_off(end + 1);
    #[cfg(unix)]
    let name: Option<OsString> = Some(std::os::unix::ffi::OsStringExt::from_vec(name));
    #[cfg(not(unix))]
    let name = String::from_utf8(name).ok().map(OsString::from);
    // Not a path that leads elsewhere.
    let name = name.filter(|name| Path::new(name).file_name() == Some(name));
    text.truncate(end);
    (String::from_utf8_lossy(&text).into_owned(), name)
}

/// Whether the open file is still the one at `path`.
fn is_at(file: &File, path: &Path) -> bool {
    let (Ok(open), Ok(there)) = (file.metadata(), fs::symlink_metadata(path)) else {
        return false;
    };
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        (open.dev(), open.ino()) == (there.dev(), there.ino())
    }
    #[cfg(not(unix))]
    {
        open.is_file() && there.is_file()
    }
}

/// Identifies the running kernel, which decides about the locks of all its containers; empty where
/// the system does not say.
fn machine() -> String {
    let id = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    id.trim().to_owned()
}
