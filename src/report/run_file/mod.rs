//! Run files: the arrays of a run and its scene in one `.npz` archive, or in a NetCDF file.
//!
//! A file appears whole or not at all. Reading checks the arrays against the scene in the file:
//! every array that the scene records is present and has the right shape.

mod read;
mod write;

use std::path::Path;

use super::ArrayFile;
use super::new_file::NewFile;
use crate::chain::Run;
use crate::chain::scene::Setup;
#[cfg(doc)]
use crate::error::Error;
use crate::error::Result;
use crate::field::{is_run_file, own_netcdf};
use crate::observer::Observer;

use read::Arrays;
pub use read::RunParts;

/// Version of the layout of run files, which their member `schema` holds.
pub const RUN_SCHEMA: &str = "cascade.run/1";

/// Whether a path has the extension of NetCDF files.
fn is_netcdf(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("nc"))
}

fn new_file(path: &Path) -> NewFile {
    NewFile {
        extensions: &["npz", "nc"],
        word: "run",
        is_one: match is_netcdf(path) {
            true => |path| Ok(own_netcdf(path)?.is_some_and(|(schema, _)| schema == RUN_SCHEMA)),
            false => is_run_file,
        },
    }
}

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
    /// [`Error::Exists`] if a run is there and is not to be replaced, [`Error::OutputInUse`] if
    /// something else is; [`Error::Request`] for a path without a name; [`Error::Write`].
    pub fn check(path: &Path, replace: bool) -> Result<()> {
        new_file(path).check(path, replace)
    }

    /// Writes a run of `setup` to `path`: a run file, or with the extension `.nc` a NetCDF file with the
    /// same arrays.
    ///
    /// # Errors
    /// As [`RunFile::check`]; [`Error::Unfit`] for a run of another chain than that of the setup's text; [`Error::Cancelled`]
    /// when the observer asks to stop.
    pub fn write(
        path: &Path,
        replace: bool,
        setup: &Setup,
        run: &Run,
        observer: &dyn Observer,
    ) -> Result<()> {
        write::check(path, setup, run)?;
        new_file(path).write(path, replace, |working| match is_netcdf(path) {
            true => write::netcdf(working, setup, run, observer),
            false => write::archive(working, setup, run, observer),
        })
    }

    /// Hands over the arrays of a run with their labels, and its scene and report as attributes.
    ///
    /// # Errors
    /// Those of `file`; [`Error::Cancelled`] when the observer asks to stop.
    pub fn hand_over(
        setup: &Setup,
        run: &Run,
        file: &dyn ArrayFile,
        observer: &dyn Observer,
    ) -> Result<()> {
        write::labelled(Path::new("the run"), setup, run, file, observer)
    }

    /// Reads a run back.
    ///
    /// # Errors
    /// [`Error::Read`]; [`Error::Input`] for a file that is no run or whose arrays do not fit its
    /// scene; [`Error::Scene`] for an invalid scene.
    pub fn read(path: &Path) -> Result<RunFile> {
        read::run_file(path, Arrays::All)
    }

    /// The same without forces and energies.
    ///
    /// # Errors
    /// As [`RunFile::read`].
    pub fn read_motion(path: &Path) -> Result<RunFile> {
        read::run_file(path, Arrays::Motion)
    }

    /// A run of arrays and texts in memory, as [`RunFile::hand_over`] gives them.
    ///
    /// # Errors
    /// As [`RunFile::read`].
    pub fn of(mut parts: RunParts) -> Result<RunFile> {
        let path = parts.path.clone();
        read::of_parts(&path, &mut parts, Arrays::All)
    }

    /// Reads the scene of a run and the time between its samples, in the unit of the scene,
    /// without the large arrays.
    ///
    /// # Errors
    /// As [`RunFile::read`].
    pub fn read_scene(path: &Path) -> Result<(Setup, f64)> {
        read::scene_and_step(path)
    }
}
