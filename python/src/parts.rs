//! Averages in parts: sums over blocks of a record, and the result of all.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use wavecascade::arrays::Precision;
use wavecascade::estimates::{
    BlockPlace, Combined, DividedRequest, Part, Partial as Sums, combine as combined, join,
    outline, partial as sum, partial_of_block,
};
use wavecascade::report::{Provenance, read_partial, write_partial};

use super::faults;
use super::kept::Kept;
use super::results::{Made, each_field};
use super::samples::Source;
use super::typed::{command, provenance};
use super::watch;
use crate::args::Command;
use crate::estimates::parts::any;
use crate::prelude::*;

/// Sums over some segments of a record, of :func:`partial`.
#[pyclass(frozen, module = "wavecascade._native")]
pub struct Partial(Sums);

#[pymethods]
impl Partial {
    #[new]
    fn new(about: String, sums: Bound<'_, PyArray1<f64>>) -> PyResult<Partial> {
        let about = serde_json::from_str(&about);
        Ok(Partial(Sums {
            about: about.map_err(|error| PyValueError::new_err(format!("partial: {error}")))?,
            sums: numbers(sums)?,
        }))
    }

    #[allow(clippy::type_complexity)]
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyType>, (String, Bound<'py, PyArray1<f64>>))> {
        let about = serde_json::to_string(&self.0.about);
        let about = about.map_err(|error| PyValueError::new_err(error.to_string()))?;
        let numbers = (about, self.0.sums.clone().into_pyarray(py));
        Ok((py.get_type::<Partial>(), numbers))
    }

    /// Bytes of memory.
    fn __sizeof__(&self) -> usize {
        self.nbytes()
    }

    fn __repr__(&self) -> String {
        let [from, end] = self.0.about.range;
        let sites = self.0.about.grid.sites;
        format!(
            "<Partial of {}: segments {from} to {}, {sites} sites>",
            self.estimate(),
            end.saturating_sub(1)
        )
    }

    /// Bytes of the sums.
    #[getter]
    fn nbytes(&self) -> usize {
        self.0.bytes()
    }

    /// The segments of all records that it holds: the first, and the one behind the last.
    #[getter]
    fn segments(&self) -> (usize, usize) {
        let [from, end] = self.0.about.range;
        (from, end)
    }

    /// What is estimated.
    #[getter]
    fn estimate(&self) -> &'static str {
        match self.0.about.request {
            DividedRequest::Coherence(_) => "coherence",
            DividedRequest::Spectrum(_) => "spectrum",
        }
    }

    /// Write it to a new archive ``.npz``, which ``cascade spectrum --merge`` reads as well.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let written = py.detach(|| write_partial(&path, &self.0));
        written.map_err(|error| faults::of(py, error, faults::From::Files))
    }

    /// Read what :meth:`save` or ``cascade spectrum --part`` wrote.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Partial> {
        let read = py.detach(|| read_partial(&path));
        let read = read.map_err(|error| faults::of(py, error, faults::From::Files))?;
        Ok(Partial(read))
    }
}

/// The numbers of an array; buffers that came from another process may lie at any byte.
fn numbers(array: Bound<'_, PyArray1<f64>>) -> PyResult<Vec<f64>> {
    let flags = array.getattr("flags")?;
    let aligned = match flags.getattr("aligned")?.extract()? {
        true => array,
        false => array.call_method0("copy")?.cast_into()?,
    };
    let read: PyReadonlyArray1<'_, f64> = aligned.extract()?;
    Ok(read.as_slice()?.to_vec())
}

/// Fields that are summed in parts, what is summed of them, and of which part if that is typed.
type Opened = (Vec<Field>, DividedRequest, Option<Part>);

/// What these words say of these fields.
fn opened(words: &Command, sources: Vec<Source>) -> Result<Opened, Failure> {
    let Command::Estimate(typed) = words else {
        let expected = "spectrum or coherence";
        return Err(Error::request("estimate", expected, "another command").into());
    };
    let (_, estimate, shared) = typed.typed();
    let open = |source: Source| source.open_unhashed(shared.reading());
    let fields: Result<_, Error> = each_field(sources)?.into_iter().map(open).collect();
    let part = estimate.parts().and_then(|parts| parts.part);
    Ok((fields?, estimate.divided()?, part))
}

/// Sums over a part of the segments of fields; or, with the place of its first sample in a record and the samples
/// of the record, of those of a block.
#[pyfunction]
#[pyo3(signature = (sources, words, place=None, progress=None))]
pub fn partial(
    py: Python<'_>,
    sources: Vec<Source>,
    words: Vec<String>,
    place: Option<(usize, usize)>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Partial> {
    let from = sources.first().map_or(faults::From::Memory, Source::from);
    let name = sources.first().and_then(Source::path);
    let words = command(&words)?;
    let work = |observer: &dyn Observer| -> Result<Sums, Failure> {
        let (fields, request, part) = opened(&words, sources)?;
        let all: Vec<&Field> = fields.iter().collect();
        let found = match (place, &all[..]) {
            (Some((first, record)), [field]) => {
                let place = BlockPlace { first, record };
                partial_of_block(field, place, &request, observer)
            }
            (Some(_), several) => {
                let expected = "one field, of which the block is a part";
                Err(Error::request("field", expected, several.len()))
            }
            (None, _) => {
                let whole = Part { number: 1, of: 1 };
                sum(&all, &request, part.unwrap_or(whole), observer)
            }
        };
        let name = name.unwrap_or_else(|| Path::new("field").to_owned());
        let found = found.map_err(|error| error.of_file(&name))?;
        fields.iter().try_for_each(Field::check_unchanged)?;
        Ok(found)
    };
    Ok(Partial(watch::run(py, progress.as_ref(), from, work)?))
}

fn result(found: Combined, fields: &[String]) -> Result<Made, Failure> {
    let found = any(found);
    let command = found.describe().name;
    let words = [format!("{command}.combine")];
    let provenance = Provenance::new(provenance(&words), Some(fields.join(", ")), None);
    let name = fields.first().map_or("field", |name| name);
    Made::new(command, Kept::new(Precision::F64), found, name, provenance)
}

fn sums<'a>(partials: &'a [PyRef<'_, Partial>]) -> Vec<&'a Sums> {
    partials.iter().map(|partial| &partial.0).collect()
}

/// Working memory.
fn bytes(memory: Option<&str>) -> PyResult<Option<u64>> {
    let size = |text: &str| {
        let refuse = |expected| format!("memory: {expected}, found {text:?}");
        parse::bytes(text).map_err(|expected| PyValueError::new_err(refuse(expected)))
    };
    memory.map(size).transpose()
}

/// The result of all parts, in any order, as :func:`estimate` has it, in so much memory as `memory` says.
#[pyfunction]
#[pyo3(signature = (partials, memory=None, threads=None))]
pub fn combine<'py>(
    py: Python<'py>,
    partials: Vec<PyRef<'py, Partial>>,
    memory: Option<&str>,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyDict>> {
    let memory = bytes(memory)?;
    let parts = sums(&partials);
    let fields = parts.first().map(|part| part.about.fields.clone());
    let fields = fields.unwrap_or_default();
    let work = |_: &dyn Observer| result(combined(&parts, memory, threads)?, &fields);
    watch::run(py, None, faults::From::Memory, work)?.into_python(py)
}

/// One partial of several whose segments follow one another, in so much memory as `memory` says.
#[pyfunction]
#[pyo3(name = "join", signature = (partials, memory=None))]
pub fn joined(
    py: Python<'_>,
    partials: Vec<PyRef<'_, Partial>>,
    memory: Option<&str>,
) -> PyResult<Partial> {
    let memory = bytes(memory)?;
    let parts = sums(&partials);
    let found = py.detach(|| join(&parts, memory));
    let found = found.map_err(|error| faults::of(py, error, faults::From::Memory))?;
    Ok(Partial(found))
}

/// A result of zeros at the sites of `source`, as :func:`estimate` has it, and how records of `times` samples are
/// cut: samples of a segment, samples to the next, segments.
#[pyfunction]
#[pyo3(name = "outline")]
pub fn outlined<'py>(
    py: Python<'py>,
    source: Source,
    words: Vec<String>,
    times: usize,
) -> PyResult<(Bound<'py, PyDict>, (usize, usize, usize))> {
    let words = command(&words)?;
    let work = || -> Result<_, Failure> {
        let (fields, request, _) = opened(&words, vec![source])?;
        let found = outline(&fields[0], times, &request)?;
        let cut = found.segments;
        Ok((
            result(found.result, &[])?,
            (cut.length, cut.hop, cut.count()),
        ))
    };
    let (found, cut) = work().map_err(|error| faults::of(py, error, faults::From::Memory))?;
    Ok((found.into_python(py)?, cut))
}
