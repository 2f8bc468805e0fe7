//! What killed runs have left below a folder.

use std::fs;
use std::path::Path;

use crate::error::{Error, Result};
pub use crate::system::publish::{Hold, Leftover};
use crate::system::publish::{is_working_name, leftovers};

/// Results that are being written, and those that killed runs have left.
#[derive(Debug, Default)]
pub struct Leftovers {
    /// In order of their paths.
    pub found: Vec<Leftover>,
    /// Folders that could not be listed.
    pub unread: Vec<Error>,
}

impl Leftovers {
    /// All in `folder` and the folders below it. Symbolic links are not followed.
    ///
    /// # Errors
    /// [`Error::Read`] if `folder` itself cannot be listed.
    pub fn below(folder: &Path) -> Result<Leftovers> {
        let mut all = Leftovers::default();
        all.add(folder)?;
        all.found.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(all)
    }

    fn add(&mut self, folder: &Path) -> Result<()> {
        let list = Error::read("list", folder);
        self.found.extend(leftovers(folder).map_err(list)?);
        let entries = fs::read_dir(folder).map_err(Error::read("list", folder))?;
        for entry in entries.flatten() {
            let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
            if is_folder && !is_working_name(&entry.file_name()) {
                let added = self.add(&entry.path());
                self.unread.extend(added.err());
            }
        }
        Ok(())
    }
}
