//! Chains: runs and sweeps.

use std::collections::HashMap;
use std::sync::Arc;

use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use wavecascade::Result;
use wavecascade::arrays::Precision;
use wavecascade::chain::scene::{SceneSource, Setting};
use wavecascade::plot::Style;
use wavecascade::report::{Provenance, RunFile, RunParts, sheet_html};
use wavecascade::sweep::{Part, Sweep, Swept, read};

use super::faults::{self, From};
use super::kept::Kept;
use super::page::Page;
use super::typed::{provenance, typed};
use super::watch;
use crate::advice;
use crate::prelude::*;
use crate::scene::source_of;

/// A run with its scene.
#[pyclass(frozen, module = "wavecascade._native")]
#[derive(Clone)]
pub struct Run(Arc<RunFile>);

impl Run {
    pub fn file(&self) -> Arc<RunFile> {
        Arc::clone(&self.0)
    }
}

#[pymethods]
impl Run {
    /// Of the arrays and the texts that `simulate` gives, which are checked against its scene.
    #[new]
    fn new(arrays: HashMap<String, PyReadonlyArrayDyn<'_, f64>>, texts: Texts) -> PyResult<Run> {
        let of_shape = |array: &PyReadonlyArrayDyn<'_, f64>| {
            let shape = array.shape().iter().map(|&n| n as u64).collect();
            (shape, array.as_array().iter().copied().collect())
        };
        let arrays = arrays.iter();
        let parts = RunParts {
            path: "the run".into(),
            texts,
            arrays: arrays
                .map(|(name, a)| (name.clone(), of_shape(a)))
                .collect(),
        };
        let file = RunFile::of(parts).map_err(value_error)?;
        Ok(Run(Arc::new(file)))
    }

    /// The scene that it is of.
    #[getter]
    fn scene(&self) -> &str {
        &self.0.setup.text
    }
}

/// Texts by their names.
type Texts = std::collections::BTreeMap<String, String>;

/// A scene as text or as a file, with the keys that are typed over it.
fn scene(text: Option<String>, path: Option<&Path>, keys: &[Setting]) -> Result<SceneSource> {
    Ok(source_of(text, path)?.with(keys.to_vec()))
}

fn value_error(error: impl std::fmt::Display) -> PyErr {
    pyo3::exceptions::PyValueError::new_err(error.to_string())
}

/// `cascade simulate`.
#[pyfunction]
#[pyo3(signature = (text, words, progress=None))]
pub fn simulate<'py>(
    py: Python<'py>,
    text: Option<String>,
    words: Vec<String>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let typed = typed!(&words, Simulate);
    let work = |observer: &dyn Observer| -> Result<_> {
        let source = scene(text, typed.scene.as_deref(), &typed.keys.settings)?;
        let setup = source.setup()?;
        let run = typed.compute(&source, &setup, observer)?;
        let kept = Kept::new(Precision::F64);
        RunFile::hand_over(&setup, &run, &kept, observer)?;
        Ok((RunFile { setup, run }, kept))
    };
    let (file, kept) = watch::run(py, progress.as_ref(), From::Files, work)?;
    let out = kept.into_python(py)?;
    let warnings = file.run.report.warnings.iter();
    let warnings = warnings.map(|one| faults::warning("run", &advice::of_run(one)));
    out.set_item("warnings", PyList::new(py, warnings)?)?;
    let described = serde_json::to_string(&file.setup.description()).map_err(value_error)?;
    out.set_item("description", described)?;
    Ok(out)
}

/// `cascade sweep`: its table in CSV, ensembles in JSON, the scene, the page. With a directory, it resumes there.
#[pyfunction]
#[pyo3(signature = (text, words, progress=None))]
pub fn sweep(
    py: Python<'_>,
    text: Option<String>,
    words: Vec<String>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(String, String, String, Page)> {
    let typed = typed!(&words, Sweep);
    let threads = typed.how.threads;
    let work = |observer: &dyn Observer| -> Result<_> {
        let source = scene(text, typed.scene.as_deref(), &typed.keys.settings)?;
        let sweep = Sweep::new(source, &typed.varied())?;
        on_threads(threads, || match &typed.out {
            None => sweep.compute(observer),
            Some(out) => {
                sweep.run(out, typed.part.unwrap_or(Part::WHOLE), observer)?;
                read(out)
            }
        })
    };
    let (request, outcomes) = watch::run(py, progress.as_ref(), From::Files, work)?;
    let ensembles = serde_json::to_string(&request.ensembles(&outcomes)).map_err(value_error)?;
    let (scene, swept) = (request.scene.clone(), Swept { request, outcomes });
    let csv = swept.csv().map_err(value_error)?;
    let provenance = Provenance::new(provenance(&words), None, None);
    let page = Page::new(move || {
        let style = Style::screen();
        sheet_html(&swept, &swept.describe(), "sweep", &provenance, &style)
    });
    Ok((csv, ensembles, scene, page))
}
