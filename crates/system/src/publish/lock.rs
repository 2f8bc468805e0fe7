//! The lock of a working file: who holds it, and what it was to become.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{ErrorKind, Read, Result, Write};
use std::path::{Path, PathBuf};

use super::working::lock_of;
use super::{DIGITS, PREFIX};

/// A lock file is at most as long as this: an identifier of the machine and a file name.
const LONGEST: u64 = 8 << 10;

/// How often a name is chosen anew.
const TRIES: usize = 16;

/// A lock file that this process has created.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    /// Open as long as the lock is held.
    file: File,
}

impl Lock {
    /// Creates a lock in `folder` under a random name, for the target of this name.
    ///
    /// A cleaner that finds the file before it is locked may take it for a leftover. It removes a
    /// file only while it holds the lock, so the owner who got the lock and still finds the file in
    /// its place is safe; one who does not begins again under another name.
    pub(super) fn create(folder: &Path, target: &OsStr) -> Result<(Lock, PathBuf)> {
        for _ in 0..TRIES {
            let working = folder.join(random_name());
            let path = lock_of(&working);
            let file = match OpenOptions::new()
                .read(true)
                .write(true)
                .create_new(true)
                .open(&path)
            {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                opened => opened?,
            };
            match file.try_lock() {
                // Without locks there is no cleaner either: it removes nothing it cannot lock.
                Ok(()) | Err(TryLockError::Error(_)) => (),
                Err(TryLockError::WouldBlock) => {
                    let _ = fs::remove_file(&path);
                    continue;
                }
            }
            if !is_at(&file, &path) {
                continue;
            }
            let mut lock = Lock { path, file };
            lock.note(target)
                .inspect_err(|_| drop(fs::remove_file(&lock.path)))?;
            return Ok((lock, working));
        }
        Err(ErrorKind::AlreadyExists.into())
    }

    /// Writes down the machine and the name of the target.
    fn note(&mut self, target: &OsStr) -> Result<()> {
        let mut text = machine().into_bytes();
        text.push(b'\n');
        text.extend(target.as_encoded_bytes());
        self.file.write_all(&text)
    }

    /// Has the name of the target on the disk.
    pub(super) fn sync(&self) -> Result<()> {
        self.file.sync_all()
    }

    /// Removes the file and lets the lock go.
    pub(super) fn remove(&self) -> Result<()> {
        fs::remove_file(&self.path)
    }
}

/// What a lock file says about its owner.
#[derive(Debug)]
pub(super) enum Found {
    /// A process has it.
    Held,
    /// It cannot be locked here, or not read.
    Unknown,
    /// No process of this machine has it; `_lock` keeps others away while it is being removed.
    Free {
        _lock: File,
        /// Whether it was written under the running kernel.
        is_of_this_machine: bool,
        target: Option<OsString>,
    },
}

/// Looks at the lock file of another owner.
pub(super) fn examine(path: &Path) -> Found {
    let is_file = fs::symlink_metadata(path).is_ok_and(|found| found.is_file());
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
    let Some(mut file) = is_file.then(|| options.open(path).ok()).flatten() else {
        return Found::Unknown;
    };
    match file.try_lock() {
        Ok(()) => {
            let (machine_then, target) = read(&mut file);
            Found::Free {
                is_of_this_machine: machine_then == machine(),
                target,
                _lock: file,
            }
        }
        Err(TryLockError::WouldBlock) => Found::Held,
        Err(TryLockError::Error(_)) => Found::Unknown,
    }
}

/// Name that the working file of this path will have.
pub(super) fn target_of(working: &Path) -> Option<OsString> {
    read(&mut File::open(lock_of(working)).ok()?).1
}

/// The machine and the target that a lock names.
fn read(file: &mut File) -> (String, Option<OsString>) {
    let mut text = Vec::new();
    if file.take(LONGEST).read_to_end(&mut text).is_err() {
        text.clear();
    }
    let Some(end) = text.iter().position(|&byte| byte == b'\n') else {
        return (String::new(), None);
    };
    let machine = String::from_utf8_lossy(&text[..end]).into_owned();
    (machine, name_of(text.split_off(end + 1)))
}

#[cfg(unix)]
fn name_of(bytes: Vec<u8>) -> Option<OsString> {
    use std::os::unix::ffi::OsStringExt;
    plain(OsString::from_vec(bytes))
}

#[cfg(not(unix))]
fn name_of(bytes: Vec<u8>) -> Option<OsString> {
    plain(String::from_utf8(bytes).ok()?.into())
}

/// `name` if it is one, not a path that leads elsewhere.
fn plain(name: OsString) -> Option<OsString> {
    (Path::new(&name).file_name() == Some(&name)).then_some(name)
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

/// A name that no other run has: whoever has it nevertheless has created it exclusively.
fn random_name() -> String {
    let mut hasher = RandomState::new().build_hasher();
    hasher.write_u32(std::process::id());
    if let Ok(time) = std::time::SystemTime::UNIX_EPOCH.elapsed() {
        hasher.write_u128(time.as_nanos());
    }
    format!("{PREFIX}{:0width$x}", hasher.finish(), width = DIGITS)
}
