//! `cascade triads`: of a run, or of a run file.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use wavecascade::observer::Observer;
use wavecascade::report::Provenance;

use super::analysis::on_threads;
use super::chains::Moved;
use super::estimates::Made;
use super::faults;
use super::samples::Source;
use super::typed::{provenance, typed};
use super::watch;
use crate::failure::Failure;
use crate::triads::not_a_run;

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
    let (held, from, is_file) = match &moved {
        Moved::Run(run) => (Some(run.file()), faults::From::Memory, false),
        Moved::Field(source) => (None, source.from(), matches!(source, Source::Files(_))),
    };
    let work = |observer: &dyn Observer| -> Result<Made, Failure> {
        let file = match held {
            Some(file) => file,
            None if is_file => Arc::new(typed.read()?),
            None => return Err(Failure::Library(not_a_run("field".as_ref()))),
        };
        let threads = typed.result.how.threads.map(usize::from);
        let found = on_threads(threads, || typed.of_run(&file, observer))?;
        let input = is_file.then(|| typed.run.display().to_string());
        let provenance = Provenance::new(provenance(&words), input, None);
        Made::new("triads", found, "run", provenance)
    };
    let done = watch::run(py, progress.as_ref(), work)?;
    let done = done.map_err(|error| faults::of_failure(py, error, from))?;
    done.into_python(py)
}
