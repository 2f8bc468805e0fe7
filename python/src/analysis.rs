//! Fields: opened, inspected, filtered, and the plan of an analysis.

use numpy::{PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use wavecascade::analyze::filtered;
use wavecascade::arrays::Precision;
use wavecascade::field::Axis;

use super::faults::{self, keywords};
use super::samples::Source;
use super::typed::typed;
use super::watch;
use crate::prelude::*;

/// `cascade analyze --plan`, in JSON.
#[pyfunction]
pub fn planned(py: Python<'_>, source: Source, words: Vec<String>) -> PyResult<String> {
    let typed = typed!(&words, Analyze);
    let from = source.from();
    let path = source.path();
    let work = |_: &dyn Observer| -> Result<_, Failure> {
        let (field, chain) = source.open_of_chain(typed.reading(), None)?;
        let plan = typed.plan(&field, chain.as_ref(), path.as_ref(), true)?;
        Ok(serde_json::to_string(&plan.describe())?)
    };
    watch::run(py, None, from, work)
}

/// `cascade inspect`, in JSON.
#[pyfunction]
pub fn inspected(py: Python<'_>, words: Vec<String>) -> PyResult<String> {
    let typed = typed!(&words, Inspect);
    let work = |_: &dyn Observer| crate::inspect::json(&typed);
    let found = watch::run(py, None, faults::From::Files, work)?;
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
    let from = source.from();
    let work = |_: &dyn Observer| source.open(typed.reading());
    let field = watch::run(py, None, from, work)?;
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
    let from = source.from();
    let name = source.path();
    let work = |observer: &dyn Observer| -> Result<_, Error> {
        typed.check()?;
        let field = source.open(Reading::of(&typed.input, typed.memory))?;
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
    let (found, precision) = watch::run(py, progress.as_ref(), from, work)?;
    let out = described(py, &found.field)?;
    out.set_item("is_single", precision == Precision::F32)?;
    out.set_item("energy_before", found.energy_before)?;
    out.set_item("energy_after", found.energy_after)?;
    let warnings = crate::filter::warnings(&typed, &found);
    let warnings = warnings.iter().map(|one| faults::warning("filter", one));
    out.set_item("warnings", PyList::new(py, warnings)?)?;
    Ok(out)
}
