//! `cascade fit`, and `compare` of a field and a run, of a scene as text or as a file; `cascade plan` and `cascade design`.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use wavecascade::observer::Observer;
use wavecascade::report::Provenance;

use super::analysis::on_threads;
use super::estimates::Made;
use super::faults;
use super::samples::Source;
use super::typed::{provenance, typed};
use super::watch;
use crate::failure::Failure;
use crate::fit::source_of;

/// Defines the function of a command on a field and a scene, the text or the file among the words: arrays with labels,
/// `summary` in JSON, `warnings`, as of an estimate. The last words lead to what all commands take.
macro_rules! of_field {
    ($function:ident, $command:ident, $name:literal, $($shared:ident).+) => {
        #[pyfunction]
        #[pyo3(signature = (field, scene_text, words, progress=None))]
        pub fn $function<'py>(
            py: Python<'py>,
            field: Source,
            scene_text: Option<String>,
            words: Vec<String>,
            progress: Option<Bound<'py, PyAny>>,
        ) -> PyResult<Bound<'py, PyDict>> {
            let typed = typed!(&words, $command);
            let (opener, from) = (field.opener(), field.from());
            let threads = typed.$($shared).+.threads.map(usize::from);
            let work = |observer: &dyn Observer| -> Result<Made, Failure> {
                let path = opener.path();
                let name = path.clone().unwrap_or_else(|| PathBuf::from("field"));
                let field = opener.open(&typed.input, None, None)?;
                let scene = typed.source(scene_text)?;
                let found = on_threads(threads, || typed.find(&field, &scene, observer));
                let found = found.map_err(|error| error.of_file(&name))?;
                let input = path.map(|path| path.display().to_string());
                let provenance = Provenance::new(provenance(&words), input, None);
                let name = name.file_stem().unwrap_or_default().to_string_lossy();
                Made::new($name, found, &name, provenance)
            };
            let done = watch::run(py, progress.as_ref(), work)?;
            let done = done.map_err(|error| faults::of_failure(py, error, from))?;
            done.into_python(py)
        }
    };
}

of_field!(fit, Fit, "fit", result.how);
of_field!(compare_field, Compare, "compare", how);

/// Defines the function of a command on a scene: the text, or the file among the words.
macro_rules! of_scene {
    ($function:ident, $command:ident, $name:literal) => {
        #[pyfunction]
        #[pyo3(signature = (scene_text, words, progress=None))]
        pub fn $function<'py>(
            py: Python<'py>,
            scene_text: Option<String>,
            words: Vec<String>,
            progress: Option<Bound<'py, PyAny>>,
        ) -> PyResult<Bound<'py, PyDict>> {
            let typed = typed!(&words, $command);
            let threads = typed.result.how.threads.map(usize::from);
            let work = |observer: &dyn Observer| -> Result<Made, Failure> {
                let scene = source_of(Some(&typed.scene), scene_text)?;
                let found = on_threads(threads, || typed.find(&scene, observer))?;
                let name = typed.scene.file_stem().unwrap_or_default();
                let provenance = Provenance::new(provenance(&words), None, None);
                Made::new($name, found, &name.to_string_lossy(), provenance)
            };
            let done = watch::run(py, progress.as_ref(), work)?;
            let done = done.map_err(|error| faults::of_failure(py, error, faults::From::Memory))?;
            done.into_python(py)
        }
    };
}

of_scene!(design, Design, "design");
of_scene!(plan, Plan, "plan");
