//! Pages of results: what `report` writes.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// What was found beside the arrays of a result, of which its page is made.
#[pyclass(frozen, module = "wavecascade._native")]
pub struct Page(Box<dyn Fn() -> serde_json::Result<String> + Send + Sync>);

impl Page {
    pub fn new(html: impl Fn() -> serde_json::Result<String> + Send + Sync + 'static) -> Page {
        Page(Box::new(html))
    }
}

#[pymethods]
impl Page {
    /// Copies of a dataset share it.
    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    /// It does not travel to other processes.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, ())> {
        Ok((py.None().bind(py).get_type().into_any(), ()))
    }
}

/// The page of a result.
#[pyfunction]
pub fn report(py: Python<'_>, page: &Bound<'_, Page>) -> PyResult<String> {
    let page = page.get();
    let html = py.detach(|| (page.0)());
    html.map_err(|error| PyRuntimeError::new_err(error.to_string()))
}
