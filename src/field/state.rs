//! The file that a field was opened from, to be known again.

use std::fs::{File, Metadata};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::error::{Error, Result};

/// A file as it was when it was opened.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Opened {
    path: PathBuf,
    length: u64,
    /// `None` where the file system does not tell.
    modified: Option<SystemTime>,
    #[cfg(unix)]
    device_and_inode: (u64, u64),
}

impl Opened {
    /// What `file` is, which was opened at `path`.
    pub(super) fn new(file: &File, path: &Path) -> Result<Opened> {
        let metadata = file.metadata().map_err(Error::read("read", path))?;
        Ok(Opened::of(&metadata, path))
    }

    fn of(metadata: &Metadata, path: &Path) -> Opened {
        #[cfg(unix)]
        use std::os::unix::fs::MetadataExt;
        Opened {
            path: path.to_owned(),
            length: metadata.len(),
            modified: metadata.modified().ok(),
            #[cfg(unix)]
            device_and_inode: (metadata.dev(), metadata.ino()),
        }
    }

    /// That the path still leads to the same file, which nothing was written to.
    pub(super) fn check(&self) -> Result<()> {
        let metadata = std::fs::metadata(&self.path).map_err(Error::read("read", &self.path))?;
        match Opened::of(&metadata, &self.path) == *self {
            true => Ok(()),
            false => Err(Error::Changed {
                path: self.path.clone(),
            }),
        }
    }
}
