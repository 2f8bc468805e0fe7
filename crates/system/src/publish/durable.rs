//! Renames that survive a power cut.

use std::fs::{self, File};
use std::io::{ErrorKind, Result};
use std::path::Path;

use super::is_there;

/// Writes a file, or a directory with all that is in it, to the disk.
pub(super) fn sync_tree(path: &Path) -> Result<()> {
    if !fs::symlink_metadata(path)?.is_dir() {
        let file = File::options().read(true).write(true).open(path)?;
        file.sync_all()?;
        #[cfg(test)]
        synced::note(path);
        return Ok(());
    }
    for entry in fs::read_dir(path)? {
        let entry = entry?;
        let kind = entry.file_type()?;
        if kind.is_dir() || kind.is_file() {
            sync_tree(&entry.path())?;
        }
    }
    sync_directory(path)
}

/// Writes the names in a directory to the disk, where the system can.
///
/// # Errors
/// The system's.
pub fn sync_directory(path: &Path) -> Result<()> {
    if !cfg!(unix) {
        return Ok(());
    }
    let path = match path.as_os_str().is_empty() {
        true => Path::new("."),
        false => path,
    };
    match File::open(path)?.sync_all() {
        // Some network systems sync names by themselves and refuse to be told so.
        Err(error) if is_refusal(&error) => {}
        done => done?,
    }
    #[cfg(test)]
    synced::note(path);
    Ok(())
}

/// Exchanges two names in one step, or gives one that nothing has; `false` if the file system cannot.
pub(super) fn rename_at_once(from: &Path, to: &Path, is_exchange: bool) -> Result<bool> {
    #[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
    {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        let flags = match is_exchange {
            true => RenameFlags::EXCHANGE,
            false => RenameFlags::NOREPLACE,
        };
        match renameat_with(CWD, from, CWD, to, flags).map_err(std::io::Error::from) {
            Ok(()) => Ok(true),
            // Some containers forbid what their filter of system calls does not know. Where the
            // names themselves may not be changed, what is tried next fails, too.
            Err(error) if error.kind() == ErrorKind::PermissionDenied => Ok(false),
            Err(error) if is_refusal(&error) => Ok(false),
            Err(error) => Err(error),
        }
    }
    #[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
    {
        let _ = (from, to, is_exchange);
        Ok(false)
    }
}

/// Gives a file or directory a name that nothing has.
///
/// # Errors
/// The system's, [`ErrorKind::AlreadyExists`] where something has it.
pub(super) fn rename_new(from: &Path, to: &Path) -> Result<()> {
    if rename_at_once(from, to, false)? {
        return Ok(());
    }
    if fs::symlink_metadata(from)?.is_file() {
        match fs::hard_link(from, to) {
            // The other name goes with what is left of the work.
            Ok(()) => return fs::remove_file(from),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => return Err(error),
            // A file system without links.
            Err(_) => {}
        }
    }
    match is_there(to) {
        true => Err(ErrorKind::AlreadyExists.into()),
        false => fs::rename(from, to),
    }
}

fn is_refusal(error: &std::io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::InvalidInput | ErrorKind::Unsupported
    )
}

/// Removes a file, or a directory with all that is in it; nothing is as good as removed.
pub(super) fn remove(path: &Path) -> Result<()> {
    let removed = match fs::symlink_metadata(path) {
        Ok(found) if found.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
        Err(error) => Err(error),
    };
    match removed {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        done => done,
    }
}

/// What was written to the disk in a thread, in its order: each file, and each directory with the names in it.
#[cfg(test)]
pub(super) mod synced {
    use std::cell::RefCell;
    use std::ffi::OsString;
    use std::path::{Path, PathBuf};

    type Synced = Vec<(PathBuf, Vec<OsString>)>;

    thread_local! {
        static SYNCED: RefCell<Synced> = const { RefCell::new(Vec::new()) };
    }

    pub(in crate::publish) fn note(path: &Path) {
        let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
        let names = entries.map(|entry| entry.file_name()).collect();
        SYNCED.with_borrow_mut(|all| all.push((path.to_owned(), names)));
    }

    pub(in crate::publish) fn take() -> Synced {
        SYNCED.take()
    }
}
