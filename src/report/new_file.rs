//! A file that appears whole or not at all, and replaces only its like.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use crate::error::{Error, Result};
use crate::system::publish::Working;

/// Files of one kind.
pub(super) struct NewFile {
    /// What messages call one.
    pub(super) word: &'static str,
    /// Extensions of such files; other programs know the formats of fields by theirs.
    pub(super) extensions: &'static [&'static str],
    /// Whether the file at a path is one.
    pub(super) is_one: fn(&Path) -> Result<bool>,
}

impl NewFile {
    /// That a file can be written to `path`, before any work is done.
    ///
    /// # Errors
    /// [`Error::Exists`] if one is there and is not to be replaced, [`Error::OutputInUse`] if
    /// something else is; [`Error::Request`] for a path without a name; [`Error::Write`].
    pub(super) fn check(&self, path: &Path, replace: bool) -> Result<()> {
        self.check_free(path, replace)?;
        // Folders that are missing are made only once there is something to put into them.
        Working::check(path).map_err(Error::write("create", path))
    }

    /// Writes to `path` what `fill` puts into a new file beside it.
    ///
    /// # Errors
    /// As [`NewFile::check`], and those of `fill`.
    pub(super) fn write(
        &self,
        path: &Path,
        replace: bool,
        fill: impl FnOnce(&Path) -> Result<()>,
    ) -> Result<()> {
        let mut working = self.begin(path, replace, fill)?;
        self.check_free(path, replace)?;
        match replace {
            true => working.publish().map_err(Error::write("finish", path)),
            false => place(&mut working, path, false),
        }
    }

    /// A file that `fill` has written and that has not yet its name.
    ///
    /// # Errors
    /// As [`NewFile::write`].
    pub(super) fn begin(
        &self,
        path: &Path,
        replace: bool,
        fill: impl FnOnce(&Path) -> Result<()>,
    ) -> Result<Working> {
        self.check_free(path, replace)?;
        let working = Working::reserve(path).map_err(Error::write("create", path))?;
        fill(working.path())?;
        Ok(working)
    }

    /// Refuses an extension that promises another format.
    fn check_extension(&self, path: &Path) -> Result<()> {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        let is = |known: &&str| extension == **known;
        let is_ours = self.extensions.iter().any(&is) || !KNOWN.iter().any(is);
        let expected = format!("a name that ends in .{}", self.extensions.join(" or ."));
        Error::require(is_ours, "out", expected, path.display())
    }

    /// Refuses a place that is taken.
    pub(super) fn check_free(&self, path: &Path, replace: bool) -> Result<()> {
        let ends_in_separator = path
            .as_os_str()
            .to_string_lossy()
            .ends_with(std::path::is_separator);
        let has_name = path.file_name().is_some() && !ends_in_separator;
        Error::require(has_name, "out", "a file with a name", path.display())?;
        self.check_extension(path)?;
        if !is_there(path, false)? {
            return Ok(());
        }
        if !(self.is_one)(path)? {
            let found = format!("is there and is no {}", self.word);
            let path = path.to_owned();
            return Err(Error::OutputInUse { path, found });
        }
        match replace {
            true => Ok(()),
            false => Err(Error::Exists {
                path: path.to_owned(),
            }),
        }
    }
}

/// Whether there is a file or a directory at a path, whichever it is to be.
///
/// # Errors
/// [`Error::OutputInUse`] for anything else, a symbolic link too; [`Error::Write`] for a path that cannot be.
pub(super) fn is_there(path: &Path, is_directory: bool) -> Result<bool> {
    let found = match fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
        // The name is too long, or a folder of the path is a file.
        Err(error) => return Err(Error::write("create", path)(error)),
        Ok(found) if found.is_symlink() => "is a symbolic link, which no result takes the place of",
        Ok(found) if is_directory && !found.is_dir() => "is there and is no directory",
        Ok(found) if !is_directory && !found.is_file() => "is there and is no file",
        Ok(_) => return Ok(true),
    };
    Err(Error::OutputInUse {
        path: path.to_owned(),
        found: found.into(),
    })
}

/// Gives what was written its name, in place of a file of that name only if that is to be replaced.
///
/// # Errors
/// [`Error::Exists`], [`Error::Write`].
pub(super) fn place(working: &mut Working, path: &Path, replace: bool) -> Result<()> {
    let placed = match replace {
        // The old one is kept until all is done.
        true if path.exists() => working.swap(),
        true => working.publish(),
        false => working.publish_new(),
    };
    placed.map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists if !replace => Error::Exists {
            path: path.to_owned(),
        },
        _ => Error::write("finish", path)(error),
    })
}

/// Formats of fields that are known by their extension.
const KNOWN: [&str; 16] = [
    "npy", "npz", "csv", "tsv", "txt", "nc", "cdf", "nc4", "h5", "hdf5", "mat", "segy", "sgy",
    "su", "uff", "unv",
];
