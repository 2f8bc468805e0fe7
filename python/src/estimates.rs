//! The commands on estimates: fields to arrays with their summary.

use std::path::{Path, PathBuf};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use wavecascade::Field;
use wavecascade::arrays::Precision;
use wavecascade::observer::Observer;
use wavecascade::plot::Style;
use wavecascade::prepare::{Examined, channel_findings};
use wavecascade::report::{Provenance, sheet_html};
use wavecascade::sheet::{Describe, Warning};

use super::faults::{self, keywords};
use super::kept::Kept;
use super::page::Page;
use super::samples::{Opener, Source};
use super::typed::{command, provenance};
use super::watch;
use crate::args::Command;
use crate::estimates::{OnEstimate, Typed};
use crate::failure::Failure;
use crate::fields::expanded;

/// The estimate that the words name, of one or several fields: arrays with labels, `summary` in JSON,
/// `warnings`.
#[pyfunction]
#[pyo3(signature = (sources, words, progress=None))]
pub fn estimate<'py>(
    py: Python<'py>,
    sources: Vec<Source>,
    words: Vec<String>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let from = sources.first().map_or(faults::From::Memory, Source::from);
    let openers = sources.iter().map(Source::opener).collect();
    let call = Call {
        py,
        from,
        openers,
        words: &words,
        progress,
    };
    match command(&words)? {
        Command::Estimate(typed) => typed.with(call),
        _ => Err(PyValueError::new_err(format!(
            "expected the words of an estimate, found {words:?}"
        ))),
    }
}

struct Call<'py, 'a> {
    py: Python<'py>,
    from: faults::From,
    openers: Vec<Opener>,
    words: &'a [String],
    progress: Option<Bound<'py, PyAny>>,
}

impl<'py> OnEstimate for Call<'py, '_> {
    type Done = PyResult<Bound<'py, PyDict>>;

    fn of<T: Typed + Sync>(self, typed: T) -> PyResult<Bound<'py, PyDict>>
    where
        T::Found: Send + Sync + 'static,
    {
        let (py, words, openers) = (self.py, self.words, self.openers);
        let work = |observer: &dyn Observer| made(&typed, openers, words, observer);
        let done = watch::run(py, self.progress.as_ref(), work)?;
        let done = done.map_err(|error| faults::of_failure(py, error, self.from))?;
        done.into_python(py)
    }
}

/// What an estimate found, on its way to Python.
pub struct Made {
    command: &'static str,
    arrays: Kept,
    summary: String,
    /// Of the fields as they were read.
    doubts: Vec<(String, String)>,
    warnings: Vec<Warning>,
    page: Page,
}

impl Made {
    pub fn new<D: Describe + Send + Sync + 'static>(
        command: &'static str,
        found: D,
        name: &str,
        provenance: Provenance,
    ) -> Result<Made, Failure> {
        let arrays = Kept::new(Precision::F64);
        let sheet = found.describe();
        sheet.write_to(&arrays)?;
        let summary = sheet.summary(&provenance).map_err(std::io::Error::from)?;
        let warnings = sheet.warnings;
        let name = name.to_owned();
        Ok(Made {
            command,
            arrays,
            summary,
            doubts: Vec::new(),
            page: Page::new(move || {
                sheet_html(
                    &found,
                    &found.describe(),
                    &name,
                    &provenance,
                    &Style::screen(),
                )
            }),
            warnings,
        })
    }

    pub fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let out = self.arrays.into_python(py)?;
        out.set_item("summary", self.summary)?;
        let of_fields = self.doubts.iter();
        let of_fields = of_fields.map(|(text, help)| ("field", text, help));
        let own = self.warnings.iter();
        let own = own.map(|warning| (self.command, &warning.message, &warning.advice));
        let all = of_fields.chain(own);
        let all = all.map(|(of, text, help)| (of, keywords(text), keywords(help)));
        out.set_item("warnings", PyList::new(py, all.collect::<Vec<_>>())?)?;
        out.set_item("page", Bound::new(py, self.page)?)?;
        Ok(out)
    }
}

/// The fields in memory or in files, of which patterns of paths may be several.
pub fn each_field(openers: Vec<Opener>) -> Result<Vec<Opener>, Failure> {
    let mut all = Vec::new();
    for opener in openers {
        match opener {
            Opener::Files(paths) => {
                let paths = expanded(&paths)?;
                all.extend(paths.into_iter().map(|path| Opener::Files(vec![path])));
            }
            memory => all.push(memory),
        }
    }
    Ok(all)
}

/// Opens the fields and makes the estimate.
fn made<T: Typed>(
    typed: &T,
    openers: Vec<Opener>,
    words: &[String],
    observer: &dyn Observer,
) -> Result<Made, Failure>
where
    T::Found: Send + Sync + 'static,
{
    let compute = typed.computation()?;
    let all = each_field(openers)?;
    let path: Option<PathBuf> = all.first().and_then(Opener::path);
    let name = path.clone();
    let name = name.unwrap_or_else(|| Path::new("field").to_owned());
    let input = &typed.shared().input;
    let open = |opener: Opener| opener.open(input, typed.shared().memory, None);
    let fields = all.into_iter().map(open);
    let fields: Vec<Field> = fields.collect::<Result<_, _>>()?;
    let doubts = fields.iter().flat_map(|field| &field.notes);
    let doubts = doubts.filter(|note| note.is_doubtful).map(|note| {
        let advice = note.advice.unwrap_or_default();
        (note.text.clone(), advice.to_owned())
    });
    let doubts = doubts.collect();
    let opened: Vec<&Field> = fields.iter().collect();
    let found = compute(&opened, observer).map_err(|error| error.of_file(&name))?;
    let first = opened
        .first()
        .map(|field| channel_findings(field, observer));
    let channels = first.transpose()?.unwrap_or_default();
    let found = Examined { found, channels };
    fields.iter().try_for_each(Field::check_unchanged)?;
    let input = path.map(|path| path.display().to_string());
    let named = name.file_stem().unwrap_or_default().to_string_lossy();
    let hash = fields.first().and_then(|field| field.content_hash.clone());
    let provenance = Provenance::new(provenance(words), input, hash);
    Ok(Made {
        doubts,
        ..Made::new(T::COMMAND, found, &named, provenance)?
    })
}
