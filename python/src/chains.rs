//! Chains: runs, budgets, sweeps, localized waves, attenuation.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::{Value, json};
use wavecascade::arrays::Precision;
use wavecascade::budget::Motion;
use wavecascade::chain::scene::{SceneSource, Setting};
use wavecascade::observer::Observer;
use wavecascade::plot::Style;
use wavecascade::report::{Provenance, RunFile, RunParts, sheet_html, write_budget_arrays};
use wavecascade::sheet::Describe;
use wavecascade::sweep::{Outcome, Part, Sweep, Swept, read};
use wavecascade::{Error, Result};

use super::analysis::on_threads;
use super::faults::{self, From, keywords};
use super::kept::Kept;
use super::page::Page;
use super::samples::Source;
use super::typed::{provenance, typed};
use super::watch;
use crate::compare::Compared;
use crate::failure::Failure;
use crate::scene::source_of;
use crate::{advice, measured};

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
    let done = watch::run(py, progress.as_ref(), work)?;
    let (file, kept) = done.map_err(|error| faults::of(py, error, From::Files))?;
    let out = kept.into_python(py)?;
    let warnings = file.run.report.warnings.iter();
    let warnings = warnings.map(|w| ("run", keywords(&w.message()), keywords(advice::of_run(w))));
    out.set_item("warnings", PyList::new(py, warnings)?)?;
    let described = serde_json::to_string(&file.setup.description()).map_err(value_error)?;
    out.set_item("description", described)?;
    Ok(out)
}

/// What a budget is computed of.
#[derive(FromPyObject)]
pub enum Moved<'py> {
    Run(PyRef<'py, Run>),
    Field(Source<'py>),
}

/// `cascade budget`: of a run, of a run file, or of a measured field with the chain of a scene.
#[pyfunction]
#[pyo3(signature = (moved, scene_text, words, progress=None))]
pub fn budget<'py>(
    py: Python<'py>,
    moved: Moved,
    scene_text: Option<String>,
    words: Vec<String>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let typed = typed!(&words, Budget);
    let (run, source, from) = match &moved {
        Moved::Run(run) => (Some(Arc::clone(&run.0)), None, From::Memory),
        Moved::Field(source) => (None, Some(source.opener()), source.from()),
    };
    let scene_path = typed.measured.scene.as_deref();
    let is_measured = scene_text.is_some() || scene_path.is_some();
    let threads = typed.result.how.threads;
    let work = |observer: &dyn Observer| -> std::result::Result<_, Failure> {
        let kept = Kept::new(Precision::F64);
        let path = source.as_ref().and_then(|source| source.path());
        let name = path.clone().unwrap_or_else(|| PathBuf::from("field"));
        let input = path.as_ref().map(|path| path.display().to_string());
        let provenance = Provenance::new(provenance(&words), input, None);
        let (found, report) = match (run, source) {
            (None, Some(source)) if is_measured => {
                let setup = scene(scene_text, scene_path, &[])?.setup()?;
                let field = source.open(&typed.measured.input, None, None)?;
                let read = measured::of_field(field, &name, &setup, &typed.measured, &typed.views);
                let read = read.map_err(|error| error.of_file(&name))?;
                let found = on_threads(threads, || read.budget(&kept, observer))?;
                (found, Some(read.motion.report))
            }
            (run, _) => {
                let file = match (run, &path) {
                    (Some(run), _) => run,
                    (None, Some(path)) => Arc::new(RunFile::read(path)?),
                    (None, None) => {
                        let expected = "the chain that a measured field is a record of";
                        return Err(Error::request("scene", expected, "none").into());
                    }
                };
                let motion = Motion::of(&file.run)?;
                let request = typed.views.request(&file.setup)?;
                let found = on_threads(threads, || {
                    wavecascade::budget::run(&motion, &request, &kept, observer)
                })?;
                (found, None)
            }
        };
        write_budget_arrays(&found, &kept)?;
        let sheet = found.describe(report.as_ref());
        let summary = sheet.summary(&provenance)?;
        let warnings = sheet.warnings.clone();
        let name = name.file_stem().unwrap_or_default();
        let name = name.to_string_lossy().into_owned();
        let page =
            Page::new(move || sheet_html(&found, &sheet, &name, &provenance, &Style::screen()));
        Ok((kept, summary, warnings, page))
    };
    let done = watch::run(py, progress.as_ref(), work)?;
    let (kept, summary, warnings, page) =
        done.map_err(|error| faults::of_failure(py, error, from))?;
    let out = kept.into_python(py)?;
    out.set_item("summary", summary)?;
    let warnings = warnings.iter();
    let warnings = warnings.map(|w| ("budget", keywords(&w.message), keywords(&w.advice)));
    out.set_item("warnings", PyList::new(py, warnings)?)?;
    out.set_item("page", Bound::new(py, page)?)?;
    Ok(out)
}

/// `cascade sweep`: names of the columns, and rows in JSON. With a directory, it resumes there.
#[pyfunction]
#[pyo3(signature = (text, words, progress=None))]
pub fn sweep(
    py: Python<'_>,
    text: Option<String>,
    words: Vec<String>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(String, Page)> {
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
    let done = watch::run(py, progress.as_ref(), work)?;
    let (request, outcomes) = done.map_err(|error| faults::of(py, error, From::Files))?;
    let rows: serde_json::Result<Vec<Value>> = outcomes
        .iter()
        .map(|(&member, outcome)| {
            let (measures, failure) = match outcome {
                Outcome::Done(measures) => (serde_json::to_value(measures)?, None),
                Outcome::Failed(reason) => (json!({}), Some(reason)),
            };
            Ok(json!([request.values(member), measures, failure]))
        })
        .collect();
    let rows = rows.map_err(value_error)?;
    let keys: Vec<&str> = request.vary.iter().map(|axis| axis.key.as_str()).collect();
    let columns = serde_json::to_value(wavecascade::sweep::Measures::default());
    let columns = columns.map_err(value_error)?;
    let columns: Vec<&String> = columns
        .as_object()
        .into_iter()
        .flat_map(|c| c.keys())
        .collect();
    let table = json!({ "keys": keys, "columns": columns, "rows": rows, "scene": request.scene,
        "ensembles": request.ensembles(&outcomes) });
    let swept = Swept { request, outcomes };
    let provenance = Provenance::new(provenance(&words), None, None);
    let page = Page::new(move || {
        let style = Style::screen();
        sheet_html(&swept, &swept.describe(), "sweep", &provenance, &style)
    });
    Ok((table.to_string(), page))
}

/// `cascade compare`: the budgets of two runs, and how they differ, in JSON; with its page.
#[pyfunction]
#[pyo3(signature = (first, second, words, progress=None))]
pub fn compare(
    py: Python<'_>,
    first: Moved,
    second: Moved,
    words: Vec<String>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(String, Page)> {
    let typed = typed!(&words, Compare);
    let paths = [typed.first.clone(), typed.second.clone()];
    let held = [&first, &second].map(|moved| match moved {
        Moved::Run(run) => Some(Arc::clone(&run.0)),
        Moved::Field(_) => None,
    });
    let threads = typed.result.how.threads;
    let work = |observer: &dyn Observer| -> std::result::Result<_, Failure> {
        typed.refuse_options_of_fields(&words)?;
        let mut files = Vec::new();
        for (path, held) in paths.iter().zip(held) {
            files.push(match held {
                Some(run) => run,
                None => Arc::new(RunFile::read(path)?),
            });
        }
        let files = [&*files[0], &*files[1]];
        on_threads(threads, || {
            let words = provenance(&words);
            Ok(Compared::of(typed.views, files, &paths, &words, observer))
        })?
    };
    let done = watch::run(py, progress.as_ref(), work)?;
    let found = done.map_err(|error| faults::of_failure(py, error, From::Files))?;
    let summary = found.json().map_err(value_error)?;
    Ok((summary, Page::new(move || found.page(&Style::screen()))))
}
