//! Run files: the arrays of a run with the scene that it is a run of, one `.npz` archive.
//!
//! A file appears whole or not at all. What is read back is checked against the scene in the file:
//! every array that the scene records is there, in the shape that it says.

mod read;
mod write;

use std::fs;
use std::path::{Path, PathBuf};

use crate::analyze::Observer;
use crate::chain::Run;
use crate::chain::scene::Setup;
use crate::error::{Error, Result};
use crate::field::is_run_file;

/// Version of the layout of run files, which their member `schema` holds.
pub const RUN_SCHEMA: &str = "cascade.run/1";

/// A run with its scene.
#[derive(Debug, Clone)]
pub struct RunFile {
    pub setup: Setup,
    pub run: Run,
}

impl RunFile {
    /// That a run can be written to `path`, before any work is done.
    ///
    /// # Errors
    /// [`Error::Exists`] if a run is there and is not to be replaced, [`Error::Occupied`] if
    /// something else is; [`Error::Request`] for a path without a name; [`Error::Write`].
    pub fn check(path: &Path, replace: bool) -> Result<()> {
        check_free(path, replace)?;
        // Folders that are missing are made only once there is something to put into them.
        let there = path.ancestors().skip(1).find(|parent| parent.exists());
        let there = there.filter(|parent| !parent.as_os_str().is_empty());
        let probe = partial(there.unwrap_or(Path::new(".")), path);
        fs::write(&probe, "").map_err(Error::write("create", path))?;
        fs::remove_file(&probe).map_err(Error::write("remove", &probe))
    }

    /// Writes a run of `setup` to `path`.
    ///
    /// # Errors
    /// As [`RunFile::check`]; [`Error::Cancelled`] when the observer asks to stop.
    pub fn write(
        path: &Path,
        replace: bool,
        setup: &Setup,
        run: &Run,
        observer: &dyn Observer,
    ) -> Result<()> {
        check_free(path, replace)?;
        let parent = path.parent().unwrap_or(Path::new(""));
        let made: Vec<&Path> = parent.ancestors().take_while(|p| !is_there(p)).collect();
        let working = partial(parent, path);
        let written = fs::create_dir_all(parent)
            .map_err(Error::write("create", parent))
            .and_then(|()| write::all(&working, setup, run, observer))
            .and_then(|()| check_free(path, replace))
            .and_then(|()| fs::rename(&working, path).map_err(Error::write("rename to", path)));
        if written.is_err() {
            let _ = fs::remove_file(&working);
            for parent in made {
                // One that someone else has put something into stays.
                let _ = fs::remove_dir(parent);
            }
        }
        written
    }

    /// Reads a run back.
    ///
    /// # Errors
    /// [`Error::Read`]; [`Error::Input`] for a file that is no run or whose arrays are not what
    /// its scene says; [`Error::Scene`] for a scene that is at fault.
    pub fn read(path: &Path) -> Result<RunFile> {
        read::run_file(path)
    }
}

/// The file that is written before it gets its name.
fn partial(folder: &Path, path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    folder.join(format!(".{name}.partial-{}", std::process::id()))
}

fn is_there(folder: &Path) -> bool {
    folder.as_os_str().is_empty() || folder.exists()
}

/// Refuses a place that is taken.
fn check_free(path: &Path, replace: bool) -> Result<()> {
    let ends_in_separator = path
        .as_os_str()
        .to_string_lossy()
        .ends_with(std::path::is_separator);
    if path.file_name().is_none() || ends_in_separator {
        return Err(Error::Request {
            option: "out",
            expected: "a file with a name".into(),
            found: path.display().to_string(),
        });
    }
    let occupied = |found: &str| {
        Err(Error::Occupied {
            path: path.to_owned(),
            found: found.into(),
        })
    };
    match fs::symlink_metadata(path) {
        Err(_) => Ok(()),
        Ok(found) if !found.is_file() => occupied("is there and is no file"),
        Ok(_) if !is_run_file(path) => occupied("is there and is no run"),
        Ok(_) if replace => Ok(()),
        Ok(_) => Err(Error::Exists {
            path: path.to_owned(),
        }),
    }
}
