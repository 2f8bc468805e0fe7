//! Fields to their spectra, filtered fields.

use std::path::PathBuf;

use numpy::{PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use wavecascade::analyze::{Request, filtered, plan, run as run_plan};
use wavecascade::arrays::Precision;
use wavecascade::chain::scene::{SceneSource, Setup};
use wavecascade::field::{Axis, is_run_file};
use wavecascade::observer::Observer;
use wavecascade::plot::Style;
use wavecascade::report::{Provenance, label_analysis, sheet_html};
use wavecascade::sheet::{Describe, Warning};
use wavecascade::{Error, Field};
use wavecascade_system::threads::in_pool;

use super::chains::Run;
use super::faults::{self, keywords};
use super::kept::Kept;
use super::page::Page;
use super::samples::{Opener, Source};
use super::typed::{provenance, typed};
use super::watch;
use crate::analyze::{conclusions, in_time_of, motion_of_run, request};
use crate::args::Analyze;
use crate::dispersion;
use crate::failure::Failure;

/// Runs on the threads that were typed.
pub fn on_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> Result<T, Error> {
    in_pool(threads, work).map_err(|error| Error::Threads {
        threads: threads.unwrap_or_default(),
        reason: error.to_string(),
    })?
}

/// `(code, message, advice)` of each.
fn warnings<'py>(py: Python<'py>, found: &[Warning]) -> PyResult<Bound<'py, PyList>> {
    let told = found.iter().map(|warning| {
        let advice = keywords(&warning.advice);
        (warning.code, keywords(&warning.message), advice)
    });
    PyList::new(py, told)
}

/// `cascade analyze`: arrays with labels, attributes, `summary` in JSON, `warnings`, `page`. With `run`, of which the
/// field is the velocities, total energies answer in time.
#[pyfunction]
#[pyo3(signature = (source, words, progress=None, maps=true, run=None))]
pub fn analyze<'py>(
    py: Python<'py>,
    source: Source,
    words: Vec<String>,
    progress: Option<Bound<'py, PyAny>>,
    maps: bool,
    run: Option<Bound<'py, Run>>,
) -> PyResult<Bound<'py, PyDict>> {
    let typed = typed!(&words, Analyze);
    let (opener, from) = (source.opener(), source.from());
    let path = opener.path();
    let run = run.map(|run| run.get().file());
    let work = |observer: &dyn Observer| -> Result<_, Failure> {
        let (mut field, request) = asked(&typed, opener, maps)?;
        if let Some(run) = run
            .as_ref()
            .filter(|run| run.run.velocity.ncols() == field.n_sites())
        {
            run.run.label(&mut field);
        }
        let name = path.clone().unwrap_or_else(|| PathBuf::from(&field.name));
        let plan = plan(&field, &request).map_err(|error| error.of_file(&name))?;
        let kept = Kept::new(request.precision);
        let analysis = run_plan(&field, &plan, &kept, observer);
        let mut analysis = analysis.map_err(|error| error.of_file(&name))?;
        match (&run, &path) {
            (Some(run), _) => in_time_of(run, &mut analysis)?,
            (None, Some(path)) => {
                if let Some(run) = &motion_of_run(path)? {
                    in_time_of(run, &mut analysis)?;
                }
            }
            (None, None) => {}
        }
        field.check_unchanged()?;
        let input = path.as_ref().map(|path| path.display().to_string());
        let hash = analysis.content_hash.clone();
        let provenance = Provenance {
            read_as: conclusions(&field),
            ..Provenance::new(provenance(&words), input, hash)
        };
        analysis.describe().write_to(&kept)?;
        let mut sheet = analysis.words();
        label_analysis(&analysis, &mut sheet);
        sheet.write_to(&kept)?;
        sheet.describe_file(&sheet.summary_value(&provenance), &kept);
        Ok((analysis, kept, sheet, provenance))
    };
    let done = watch::run(py, progress.as_ref(), work)?;
    let (analysis, kept, sheet, provenance) =
        done.map_err(|error| faults::of_failure(py, error, from))?;
    let out = kept.into_python(py)?;
    let summary = sheet.summary(&provenance).map_err(std::io::Error::from)?;
    out.set_item("summary", summary)?;
    out.set_item("warnings", warnings(py, &sheet.warnings)?)?;
    let page = Page::new(move || {
        let name = &analysis.name;
        sheet_html(&analysis, &sheet, name, &provenance, &Style::screen())
    });
    out.set_item("page", Bound::new(py, page)?)?;
    Ok(out)
}

/// The `field` of the words, as it would be opened, and what would be asked of it.
fn asked(typed: &Analyze, opener: Opener, maps: bool) -> Result<(Field, Request), Failure> {
    let (path, scene) = (opener.path(), opener.scene());
    let mut field = opener.open(&typed.input, typed.work.memory, Some(&typed.scan))?;
    let scene = scene.map(|(text, step)| Ok((SceneSource::new(None, text).setup()?, step)));
    let scene: Option<(Setup, f64)> = scene.transpose().map_err(Failure::Library)?;
    if let Some((setup, _)) = &scene
        && setup.simulation.chain.n_sites() != field.n_sites()
    {
        // Of a part of the chain it is not known which body was struck.
        field.struck = None;
    }
    let mut request = request(typed, &field, maps)?;
    request.dispersion = match &path {
        Some(path) if is_run_file(path)? => dispersion::of(typed, path, &field)?,
        _ => {
            let lattice = scene.map(|(setup, step)| dispersion::of_chain(&setup, step, &field));
            dispersion::stated(typed, lattice, &field)?
        }
    };
    Ok((field, request))
}

/// `cascade analyze --plan`, in JSON.
#[pyfunction]
pub fn planned(py: Python<'_>, source: Source, words: Vec<String>) -> PyResult<String> {
    let typed = typed!(&words, Analyze);
    let (opener, from) = (source.opener(), source.from());
    let work = |_: &dyn Observer| -> Result<_, Failure> {
        let (field, request) = asked(&typed, opener, true)?;
        let plan = plan(&field, &request)?;
        Ok(serde_json::to_string(&plan.describe())?)
    };
    watch::run(py, None, work)?.map_err(|error| faults::of_failure(py, error, from))
}

/// `cascade inspect`, in JSON.
#[pyfunction]
pub fn inspected(py: Python<'_>, words: Vec<String>) -> PyResult<String> {
    let typed = typed!(&words, Inspect);
    let found = watch::run(py, None, |_| crate::inspect::json(&typed))?;
    let found = found.map_err(|error| faults::of_failure(py, error, faults::From::Files))?;
    Ok(found.to_string())
}

/// The samples of a field as an array `(time, site)`, with axes, names and notes.
fn described<'py>(py: Python<'py>, field: &Field) -> PyResult<Bound<'py, PyDict>> {
    let (times, sites) = (field.n_times(), field.n_sites());
    let mut values = vec![0.0; times * sites];
    py.detach(|| field.read_time_major(0..times, 0..sites, &mut values));
    let array = ndarray::ArrayView2::from_shape((times, sites), &values);
    let array =
        array.map_err(|error| pyo3::exceptions::PyRuntimeError::new_err(error.to_string()))?;
    let out = PyDict::new(py);
    match field.precision() {
        Precision::F64 => out.set_item("array", array.to_pyarray(py))?,
        Precision::F32 => {
            let array = array.to_pyarray(py).cast_array::<f32>(false)?;
            out.set_item("array", array)?;
        }
    }
    let places =
        |axis: &Axis, count: usize| -> Vec<f64> { (0..count).map(|i| axis.at(i)).collect() };
    for (name, axis, count) in [("time", &field.time, times), ("space", &field.space, sites)] {
        let coordinates = places(axis, count).to_pyarray(py);
        let is_counted = *axis == Axis::index();
        out.set_item(
            name,
            (coordinates, axis.step, axis.unit.clone(), is_counted),
        )?;
    }
    out.set_item("name", &field.name)?;
    out.set_item("quantity", field.quantity.name())?;
    out.set_item("unit", &field.unit)?;
    out.set_item("dispersion", &field.dispersion)?;
    out.set_item("hash", &field.content_hash)?;
    let notes = field.notes.iter().map(|note| {
        let advice = note.advice.map(keywords);
        (keywords(&note.text), note.is_doubtful, advice)
    });
    out.set_item("notes", PyList::new(py, notes)?)?;
    Ok(out)
}

/// The field that `cascade analyze` reads.
#[pyfunction]
pub fn open<'py>(
    py: Python<'py>,
    source: Source,
    words: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let typed = typed!(&words, Analyze);
    let (opener, from) = (source.opener(), source.from());
    let work = |_: &dyn Observer| opener.open(&typed.input, typed.work.memory, Some(&typed.scan));
    let field = watch::run(py, None, work)?;
    let field = field.map_err(|error| faults::of(py, error, from))?;
    let out = described(py, &field)?;
    field
        .check_unchanged()
        .map_err(|error| faults::of(py, error, from))?;
    Ok(out)
}

/// `cascade filter`: the field that passes, its energies, warnings.
#[pyfunction]
#[pyo3(signature = (source, words, progress=None))]
pub fn filter<'py>(
    py: Python<'py>,
    source: Source,
    words: Vec<String>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let typed = typed!(&words, Filter);
    let (opener, from) = (source.opener(), source.from());
    let name = opener.path();
    let work = |observer: &dyn Observer| {
        typed.check()?;
        let field = opener.open(&typed.input, typed.memory, None)?;
        let band = typed.band(&field)?;
        let threads = typed.how.threads;
        let found = on_threads(threads, || {
            filtered(&field, &band, typed.pad, typed.memory, observer)
        });
        let name = name.unwrap_or_else(|| PathBuf::from(&field.name));
        let found = found.map_err(|error| error.of_file(&name))?;
        field.check_unchanged()?;
        typed.check_passes(&found)?;
        Ok((found, field.precision()))
    };
    let found = watch::run(py, progress.as_ref(), work)?;
    let (found, precision) = found.map_err(|error| faults::of(py, error, from))?;
    let out = described(py, &found.field)?;
    out.set_item("is_single", precision == Precision::F32)?;
    out.set_item("energy_before", found.energy_before)?;
    out.set_item("energy_after", found.energy_after)?;
    let warnings = crate::filter::warnings(&typed, &found);
    let warnings = warnings
        .iter()
        .map(|[message, advice]| ("filter", keywords(message), keywords(advice)));
    out.set_item("warnings", PyList::new(py, warnings)?)?;
    Ok(out)
}
