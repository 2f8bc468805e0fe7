//! The extension module `wavecascade._native`: the program's commands as functions on arrays.
//!
//! Options come as the words of a command line, so that clap judges them as it does for the program, with the
//! same defaults and messages; the Python code beside it turns keywords into words and results into datasets.

mod analysis;
mod chains;
mod faults;
mod fft;
mod kept;
mod page;
mod parts;
mod results;
mod samples;
mod typed;
mod watch;

use pyo3::prelude::*;

/// The native half of the package. Without the lock of the interpreter it has not been tried.
#[pymodule(gil_used = true)]
mod _native {
    #[pymodule_export]
    use super::analysis::{filter, inspected, open, planned};
    #[pymodule_export]
    use super::chains::{Run, simulate, sweep};
    #[pymodule_export]
    use super::fft::rfft;
    #[pymodule_export]
    use super::page::{Page, report};
    #[pymodule_export]
    use super::parts::{Partial, combine, joined, outlined, partial};
    #[pymodule_export]
    use super::results::found;
    #[pymodule_export]
    use super::samples::Samples;
    #[pymodule_export]
    use super::{is_run_file, program, scene_keys};

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const version: &str = env!("CARGO_PKG_VERSION");
}

/// Runs the program with these words, the name of the program first; returns its exit code.
#[pyfunction]
fn program(py: Python<'_>, words: Vec<std::ffi::OsString>) -> u8 {
    // Words are given once in the life of a process, as for the program.
    let _ = crate::words::GIVEN.set(words);
    py.detach(crate::program)
}

/// Whether a file is that of a run; one that cannot be read is said to be so where it is read.
#[pyfunction]
fn is_run_file(path: std::path::PathBuf) -> bool {
    !path.is_file() || wavecascade::field::is_run_file(&path).unwrap_or(true)
}

/// The keys of scenes.
#[pyfunction]
fn scene_keys() -> Vec<&'static str> {
    let all = wavecascade::chain::scene::properties().iter();
    all.map(|property| property.name.as_str()).collect()
}
