//! The commands whose result is described: fields, scenes and runs to arrays with their summary.

use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use wavecascade::Field;
use wavecascade::arrays::Precision;
use wavecascade::observer::Observer;
use wavecascade::plot::Style;
use wavecascade::report::{Provenance, sheet_html};
use wavecascade::sheet::{Describe, Warning};

use super::analysis::on_threads;
use super::chains::Run;
use super::faults::{self, keywords};
use super::kept::Kept;
use super::page::Page;
use super::samples::{Opener, Source};
use super::typed::{command, provenance};
use super::watch;
use crate::args::Command;
use crate::described::{AnyResult, Describing, Given, not_a_run, stem_of};
use crate::failure::Failure;
use crate::fields::expanded;

/// What the command that the words name finds of fields, of the text of a scene and of runs, which stand for files among
/// the words (None for a run in a file): arrays with labels, `csv`, `summary` in JSON, `warnings`, `page`.
#[pyfunction]
#[pyo3(signature = (words, progress=None, sources=Vec::new(), scene=None, runs=Vec::new()))]
pub fn found<'py>(
    py: Python<'py>,
    words: Vec<String>,
    progress: Option<Bound<'py, PyAny>>,
    sources: Vec<Source>,
    scene: Option<String>,
    runs: Vec<Option<Bound<'py, Run>>>,
) -> PyResult<Bound<'py, PyDict>> {
    let typed = command(&words)?;
    let typed: &dyn Describing = match &typed {
        Command::Attenuate(typed) => &**typed,
        Command::Budget(typed) => &**typed,
        Command::Compare(typed) => &**typed,
        Command::Design(typed) => &**typed,
        Command::Estimate(typed) => typed,
        Command::Fit(typed) => &**typed,
        Command::Localize(typed) => &**typed,
        Command::Plan(typed) => &**typed,
        Command::Triads(typed) => &**typed,
        _ => {
            let text = format!("expected the words of a command with a result, found {words:?}");
            return Err(PyValueError::new_err(text));
        }
    };
    let from = sources.first().map_or(faults::From::Files, Source::from);
    let openers = sources.iter().map(Source::opener).collect();
    let runs = runs.into_iter();
    let runs = runs.map(|run| run.map(|run| run.get().file()));
    let runs = runs.collect();
    let work = |observer: &dyn Observer| {
        let given = Given {
            scene,
            runs,
            words: provenance(&words),
            ..Given::default()
        };
        made(typed, openers, given, observer)
    };
    let done = watch::run(py, progress.as_ref(), work)?;
    let done = done.map_err(|error| faults::of_failure(py, error, from))?;
    done.into_python(py)
}

/// What a command found, on its way to Python.
pub struct Made {
    command: &'static str,
    arrays: Kept,
    /// Its table, in CSV.
    records: Option<String>,
    summary: String,
    /// Of the fields as they were read.
    doubts: Vec<Warning>,
    warnings: Vec<Warning>,
    page: Page,
}

impl Made {
    pub fn new(
        command: &'static str,
        arrays: Kept,
        found: AnyResult,
        name: &str,
        provenance: Provenance,
    ) -> Result<Made, Failure> {
        let sheet = found.describe();
        sheet.write_to(&arrays)?;
        let has_records = !sheet.records.head.is_empty();
        let records = has_records.then(|| sheet.records.to_csv()).transpose();
        let records = records.map_err(std::io::Error::other)?;
        let summary = sheet.summary(&provenance)?;
        let warnings = sheet.warnings;
        let name = name.to_owned();
        Ok(Made {
            command,
            arrays,
            records,
            summary,
            doubts: Vec::new(),
            page: Page::new(move || {
                let sheet = found.describe();
                sheet_html(&*found, &sheet, &name, &provenance, &Style::screen())
            }),
            warnings,
        })
    }

    pub fn into_python(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let out = self.arrays.into_python(py)?;
        out.set_item("csv", self.records)?;
        out.set_item("summary", self.summary)?;
        let of_fields = self.doubts.iter().map(|doubt| ("field", doubt));
        let own = self.warnings.iter().map(|warning| (self.command, warning));
        let all = of_fields.chain(own);
        let all = all.map(|(of, one)| (of, keywords(&one.message), keywords(&one.advice)));
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

/// Opens the fields, where the command is of fields, and makes the result.
fn made(
    typed: &dyn Describing,
    openers: Vec<Opener>,
    given: Given,
    observer: &dyn Observer,
) -> Result<Made, Failure> {
    typed.check()?;
    let about = typed.about();
    let all = each_field(openers)?;
    let path: Option<PathBuf> = all.first().and_then(Opener::path);
    let name = path.clone().unwrap_or_else(|| "field".into());
    let fields = match about.reading {
        Some(reading) => {
            let open = |opener: Opener| opener.open(reading.input, reading.memory, None);
            all.into_iter().map(open).collect::<Result<_, _>>()?
        }
        None if !all.is_empty() && path.is_none() => {
            return Err(Failure::Library(not_a_run(&name)));
        }
        None => Vec::new(),
    };
    let doubts = fields.iter().flat_map(|field: &Field| &field.notes);
    let doubts = doubts.filter(|note| note.is_doubtful);
    let doubts = doubts.map(Warning::from).collect();
    let opened: Vec<&Field> = fields.iter().collect();
    let arrays = Kept::new(Precision::F64);
    let words = given.words.clone();
    let given = Given {
        fields: &opened,
        arrays: Some(&arrays),
        ..given
    };
    let found = on_threads(about.threads, || typed.find(given, observer));
    let found = found.map_err(|error| error.of_file(&name))?;
    fields.iter().try_for_each(Field::check_unchanged)?;
    let title = path.as_deref().map_or(about.name.to_owned(), stem_of);
    let input = path.map(|path| path.display().to_string());
    let hash = fields.first().and_then(|field| field.content_hash.clone());
    let provenance = Provenance::new(words, input, hash);
    Ok(Made {
        doubts,
        ..Made::new(about.name, arrays, found.result, &title, provenance)?
    })
}
