//! A directory of results that appears whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Files are written to a directory beside the wanted one; [`ResultDirectory::publish`] renames
/// it. Dropped before that, it is removed with everything in it.
#[derive(Debug)]
pub struct ResultDirectory {
    wanted: PathBuf,
    working: PathBuf,
    replace: bool,
    published: bool,
}

impl ResultDirectory {
    /// Makes the working directory; fails before any work is done.
    ///
    /// # Errors
    /// [`Error::Exists`] if `wanted` is there (an empty directory may be) and is not to be
    /// replaced; [`Error::Write`] if nothing can be written beside it.
    pub fn create(wanted: &Path, replace: bool) -> Result<Self> {
        if !replace && is_occupied(wanted)? {
            return Err(Error::Exists {
                path: wanted.to_owned(),
            });
        }
        let parent = match wanted.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        fs::create_dir_all(parent).map_err(Error::write("create", parent))?;
        let name = wanted.file_name().unwrap_or_default().to_string_lossy();
        let working = parent.join(format!(".{name}.partial-{}", std::process::id()));
        if working.exists() {
            // A leftover of a killed run that had the same process number.
            fs::remove_dir_all(&working).map_err(Error::write("remove", &working))?;
        }
        fs::create_dir(&working).map_err(Error::write("create", &working))?;
        Ok(ResultDirectory {
            wanted: wanted.to_owned(),
            working,
            replace,
            published: false,
        })
    }

    /// Where to write.
    pub fn path(&self) -> &Path {
        &self.working
    }

    /// Writes one file of it.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> Result<()> {
        let path = self.working.join(name);
        fs::write(&path, contents).map_err(Error::write("write", &path))
    }

    /// Gives the directory its name, in place of an older one where that was allowed.
    ///
    /// # Errors
    /// [`Error::Exists`] if someone else was there first; [`Error::Write`].
    pub fn publish(mut self) -> Result<PathBuf> {
        let write = |action| Error::write(action, &self.wanted);
        let occupied = is_occupied(&self.wanted)?;
        if occupied && !self.replace {
            return Err(Error::Exists {
                path: self.wanted.clone(),
            });
        }
        if occupied {
            // The old result leaves only once the new one stands beside it.
            let old = self.working.with_extension("replaced");
            fs::rename(&self.wanted, &old).map_err(write("move away"))?;
            if let Err(source) = fs::rename(&self.working, &self.wanted) {
                let _ = fs::rename(&old, &self.wanted);
                return Err(write("rename to")(source));
            }
            self.published = true;
            remove(&old).map_err(Error::write("remove", &old))?;
        } else {
            fs::rename(&self.working, &self.wanted).map_err(write("rename to"))?;
            self.published = true;
        }
        Ok(self.wanted.clone())
    }
}

impl Drop for ResultDirectory {
    fn drop(&mut self) {
        if !self.published {
            let _ = fs::remove_dir_all(&self.working);
        }
    }
}

/// Whether something other than an empty directory is at `path`.
fn is_occupied(path: &Path) -> Result<bool> {
    match fs::symlink_metadata(path) {
        Err(_) => Ok(false),
        Ok(found) if found.is_dir() => {
            let mut entries = fs::read_dir(path).map_err(Error::read("list", path))?;
            Ok(entries.next().is_some())
        }
        Ok(_) => Ok(true),
    }
}

fn remove(path: &Path) -> std::io::Result<()> {
    if fs::symlink_metadata(path)?.is_dir() {
        fs::remove_dir_all(path)
    } else {
        fs::remove_file(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn appears_whole_or_not_at_all() -> std::result::Result<(), Box<dyn std::error::Error>> {
        let place = tempfile::tempdir()?;
        let wanted = place.path().join("out");
        let count = || fs::read_dir(place.path()).map(Iterator::count);

        let dropped = ResultDirectory::create(&wanted, false)?;
        dropped.write("a", "1")?;
        drop(dropped);
        assert_eq!(count()?, 0);

        let first = ResultDirectory::create(&wanted, false)?;
        first.write("a", "1")?;
        first.publish()?;
        assert_eq!(fs::read_to_string(wanted.join("a"))?, "1");
        let refused = ResultDirectory::create(&wanted, false);
        assert!(matches!(refused, Err(Error::Exists { .. })));

        let second = ResultDirectory::create(&wanted, true)?;
        second.write("b", "2")?;
        second.publish()?;
        assert!(!wanted.join("a").exists() && wanted.join("b").exists());
        assert_eq!(count()?, 1);
        Ok(())
    }
}
