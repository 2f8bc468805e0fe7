//! `cascade triads`: of a run, or of a run file.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use wavecascade::field::is_run_file;
use wavecascade::observer::Observer;
use wavecascade::report::{Provenance, RunFile};

use super::analysis::on_threads;
use super::chains::Moved;
use super::estimates::Made;
use super::faults::{self, From};
use super::samples::Opener;
use super::typed::{provenance, typed};
use super::watch;
use crate::estimates::Typed;
use crate::failure::Failure;

enum Of {
    Run(Arc<RunFile>),
    Field(Box<Opener>),
}

/// Arrays with labels, `summary` in JSON, `warnings`, as of an estimate.
#[pyfunction]
#[pyo3(signature = (moved, words, progress=None))]
pub fn triads<'py>(
    py: Python<'py>,
    moved: Moved,
    words: Vec<String>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let typed = typed!(&words, Triads);
    let (of, from) = match &moved {
        Moved::Run(run) => (Of::Run(run.file()), From::Memory),
        Moved::Field(source) => (Of::Field(Box::new(source.opener())), source.from()),
    };
    let work = |observer: &dyn Observer| -> Result<Made, Failure> {
        let threads = typed.shared().threads();
        let of_run = |file: &RunFile, name: &str| -> Result<_, Failure> {
            typed.check(name, true, words.clone())?;
            Ok(on_threads(threads, || typed.of_run(file, observer))?)
        };
        let mut path = None;
        let found = match of {
            Of::Run(file) => of_run(&file, "run")?,
            Of::Field(opener) => {
                path = opener.path();
                let name = path.clone().unwrap_or_else(|| PathBuf::from("field"));
                let text = name.display().to_string();
                let is_run = match &path {
                    Some(path) => path.is_file() && is_run_file(path)?,
                    None => false,
                };
                typed.check(&text, is_run, words.clone())?;
                of_run(&RunFile::read(&name)?, &text)?
            }
        };
        let input = path.map(|path| path.display().to_string());
        let provenance = Provenance::new(provenance(&words), input, None);
        Made::new("triads", found, "run", provenance)
    };
    let done = watch::run(py, progress.as_ref(), work)?;
    let done = done.map_err(|error| faults::of_failure(py, error, from))?;
    done.into_python(py)
}
