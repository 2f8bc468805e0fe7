//! A file as it was, to be known again.

use std::fs::{File, Metadata};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::file_bytes::regular_file;
use crate::error::{Error, Result};

/// A file as it was at some time: its length, when it was modified, and where there are inodes,
/// which one it was and when that changed last: programs can set back the former time, not the latter.
#[derive(Debug, Clone, PartialEq)]
pub struct FileState {
    path: PathBuf,
    length: u64,
    /// `None` if the file system does not record it.
    modified: Option<SystemTime>,
    #[cfg(unix)]
    device_and_inode: (u64, u64),
    /// Seconds and nanoseconds.
    #[cfg(unix)]
    inode_changed: (i64, i64),
}

impl FileState {
    /// The file at `path` as it is now.
    ///
    /// # Errors
    /// [`Error::Read`].
    pub fn at(path: &Path) -> Result<FileState> {
        regular_file(path)?;
        // A network system looks up on its server what a file is only when it is opened.
        let file = File::open(path).map_err(Error::read("read", path))?;
        FileState::opened(&file, path)
    }

    /// What `file` is, which was opened at `path`.
    pub(super) fn opened(file: &File, path: &Path) -> Result<FileState> {
        let metadata = file.metadata().map_err(Error::read("read", path))?;
        Ok(FileState::of(&metadata, path))
    }

    fn of(metadata: &Metadata, path: &Path) -> FileState {
        #[cfg(unix)]
        use std::os::unix::fs::MetadataExt;
        FileState {
            path: path.to_owned(),
            length: metadata.len(),
            modified: metadata.modified().ok(),
            #[cfg(unix)]
            device_and_inode: (metadata.dev(), metadata.ino()),
            #[cfg(unix)]
            inode_changed: (metadata.ctime(), metadata.ctime_nsec()),
        }
    }

    pub(super) fn length(&self) -> u64 {
        self.length
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// That its path still leads to the same file, which nothing was written to since.
    ///
    /// # Errors
    /// [`Error::Changed`]; [`Error::Read`] where the file is gone.
    pub fn check(&self) -> Result<()> {
        match self.change_to(&FileState::at(&self.path)?) {
            None => Ok(()),
            Some(change) => Err(Error::Changed {
                path: self.path.clone(),
                change,
            }),
        }
    }

    /// What was expected, and what was found.
    fn change_to(&self, now: &FileState) -> Option<String> {
        #[cfg(unix)]
        if now.device_and_inode != self.device_and_inode {
            let found = "expected the file that was opened, found another in its place";
            return Some(found.into());
        }
        if now.length != self.length {
            let [expected, found] = [self.length, now.length];
            return Some(format!("expected {expected} bytes, found {found}"));
        }
        if now.modified != self.modified {
            let times = self.modified.zip(now.modified);
            let by = match times.map(|(before, now)| now.duration_since(before)) {
                None => String::new(),
                Some(Ok(later)) => format!(" {later:.3?} after the last before"),
                Some(Err(earlier)) => {
                    format!(" dated {:.3?} before the last one", earlier.duration())
                }
            };
            let found = "expected no modification since it was opened, found one";
            return Some(found.to_owned() + &by);
        }
        #[cfg(unix)]
        if now.inode_changed != self.inode_changed {
            let found = "expected no change since it was opened, found one that kept the time of modification";
            return Some(found.into());
        }
        None
    }
}
