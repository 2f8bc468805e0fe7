//! The commands whose result is described: fields, scenes and runs to arrays with their summary.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use wavecascade::arrays::Precision;
use wavecascade::plot::Style;
use wavecascade::report::{Provenance, sheet_html};
use wavecascade::sheet::Warning;

use super::chains::Run;
use super::faults;
use super::kept::Kept;
use super::page::Page;
use super::samples::Source;
use super::typed::{command, provenance};
use super::watch;
use crate::fields::expanded;
use crate::prelude::*;

/// What the command that the words name finds of fields, of the text of a scene and of runs, which stand for files among
/// the words (None for a run in a file): arrays with labels, `csv`, `summary` in JSON, `warnings`, `page`, of an analysis
/// with maps if so.
#[pyfunction]
#[pyo3(signature = (words, progress=None, sources=Vec::new(), scene=None, runs=Vec::new(), maps=true))]
pub fn found<'py>(
    py: Python<'py>,
    words: Vec<String>,
    progress: Option<Bound<'py, PyAny>>,
    sources: Vec<Source>,
    scene: Option<String>,
    runs: Vec<Option<Bound<'py, Run>>>,
    maps: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let command = command(&words)?;
    let (typed, _) = command.described().ok_or_else(|| {
        PyValueError::new_err(format!(
            "expected the words of a command with a result, found {words:?}"
        ))
    })?;
    let from = sources.first().map_or(faults::From::Files, Source::from);
    let runs = runs.into_iter();
    let runs = runs.map(|run| run.map(|run| run.get().file()));
    let runs = runs.collect();
    let work = |observer: &dyn Observer| {
        let given = Given {
            scene,
            runs,
            is_drawn: maps,
            words: provenance(&words),
            ..Given::default()
        };
        made(typed, sources, given, observer)
    };
    watch::run(py, progress.as_ref(), from, work)?.into_python(py)
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
        sheet.describe_file(&sheet.summary_value(&provenance), &arrays);
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
        let all = all.map(|(of, one)| faults::warning(of, one));
        out.set_item("warnings", PyList::new(py, all.collect::<Vec<_>>())?)?;
        out.set_item("page", Bound::new(py, self.page)?)?;
        Ok(out)
    }
}

/// The fields in memory or in files, of which patterns of paths may be several.
pub fn each_field(sources: Vec<Source>) -> Result<Vec<Source>, Failure> {
    let mut all = Vec::new();
    for source in sources {
        match source {
            Source::Files(paths) => {
                let paths = expanded(&paths)?;
                all.extend(paths.into_iter().map(|path| Source::Files(vec![path])));
            }
            memory => all.push(memory),
        }
    }
    Ok(all)
}

/// Opens the fields, where the command is of fields, and makes the result.
fn made(
    typed: &dyn Describing,
    sources: Vec<Source>,
    given: Given,
    observer: &dyn Observer,
) -> Result<Made, Failure> {
    typed.check()?;
    let about = typed.about();
    let sources = match about.reading {
        Some(reading) if reading.is_scan() => sources,
        _ => each_field(sources)?,
    };
    let files: Vec<PathBuf> = sources.iter().filter_map(Source::path).collect();
    let run = given.runs.first().and_then(Option::as_deref);
    let (mut fields, mut chain) = (Vec::new(), None);
    match about.reading {
        Some(reading) => {
            for source in sources {
                let (field, of) = source.open_of_chain(reading, run)?;
                fields.push(field);
                chain = of;
            }
        }
        None if files.len() < sources.len() => {
            return Err(Failure::Library(not_a_run(Path::new("field"))));
        }
        None => {}
    }
    let is_told = about.reading.is_some_and(|reading| reading.is_told);
    let doubts = fields.iter().flat_map(|field| &field.notes);
    let doubts = doubts.filter(|note| note.is_doubtful && !is_told);
    let doubts = doubts.map(Warning::from).collect();
    let arrays = Kept::new(about.blocks.map_or(Precision::F64, |(_, _, of)| of));
    let words = given.words.clone();
    let given = Given {
        fields: &fields.iter().collect::<Vec<_>>(),
        files: &files,
        chain: chain.as_ref(),
        arrays: Some(&arrays),
        ..given
    };
    let found = on_threads(about.threads, || typed.find(given, observer));
    let path = files.first();
    let name = path
        .cloned()
        .or(fields.first().map(|field| PathBuf::from(&field.name)));
    let found = found.map_err(|error| error.of_file(&name.unwrap_or_else(|| "field".into())))?;
    fields.iter().try_for_each(Field::check_unchanged)?;
    let title = path.map_or(about.name.to_owned(), |path| stem_of(path));
    let input = path.map(|path| path.display().to_string());
    let hash = fields.first().and_then(|field| field.content_hash.clone());
    let provenance = Provenance {
        read_as: found.read_as,
        ..Provenance::new(words, input, hash)
    };
    let title = found.name.unwrap_or(title);
    Ok(Made {
        doubts,
        ..Made::new(about.name, arrays, found.result, &title, provenance)?
    })
}
