//! `cascade analyze` of several fields: one after the other, and an index of them.

use serde_json::{Value, json};
use wavecascade::report::{
    FieldOutcome, FieldRow, FieldSet, field_names, fields_tables, verdicts_in_words,
};

use crate::args::Analyze;
use crate::prelude::*;
use crate::present::open_page;
use crate::terminal::Tone;

/// Directory of the results where none is named.
const DEFAULT: &str = "fields-cascade";

/// The files that a pattern of a shell matches, where the shell has left it; other paths as they are.
///
/// # Errors
/// A pattern that is none, or that matches nothing.
pub fn expanded(typed: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut fields = Vec::new();
    for path in typed {
        let text = path.to_string_lossy();
        if !text.contains(['*', '?', '[']) || path.symlink_metadata().is_ok() {
            fields.push(path.clone());
            continue;
        }
        let refused = |found: String| Failure::Pattern {
            pattern: text.to_string(),
            found,
        };
        let matched = glob::glob(&text).map_err(|error| refused(error.to_string()))?;
        let before = fields.len();
        fields.extend(matched.flatten());
        if fields.len() == before {
            return Err(refused("none".into()));
        }
    }
    Ok(fields)
}

/// Runs the command on several fields.
pub fn run(typed: &Analyze, fields: &[PathBuf]) -> Result<(), Failure> {
    let (typed_result, how) = (&typed.result, &typed.result.how);
    let names = field_names(fields)?;
    let out = typed_result.out.clone();
    let out = out.unwrap_or_else(|| DEFAULT.into());
    let mut set = FieldSet::create(&out, typed_result.force)?;
    let progress = Progress::new(!how.quiet);
    // From now on a directory and an index remain.
    progress.begin_writing();
    for (n, (field, name)) in fields.iter().zip(&names).enumerate() {
        progress.of(n + 1, fields.len(), name);
        let (place, replace) = set.place(name);
        let result = ResultArgs {
            out: Some(place),
            force: replace,
            ..typed_result.clone()
        };
        let analyzed = done(typed, &result, std::slice::from_ref(field), &progress);
        progress.clear();
        if matches!(analyzed, Err(Failure::Library(Error::Cancelled))) {
            // What an interrupt has left.
            return Err(match set.stop().len() {
                0 => Failure::Library(Error::Cancelled),
                known => Failure::Stopped {
                    known,
                    fields: fields.len(),
                    out,
                },
            });
        }
        if how.json {
            print_json(field, &analyzed)?;
        }
        set.add(row(field, name, analyzed))?;
    }
    let rows = set.finish()?;
    if typed_result.figures.present.open {
        open_page(&out.join("index.html"));
    }
    tell(how, &rows, &out)
}

/// A field with its headlines, or why it has none.
fn row(field: &Path, name: &str, analyzed: Result<Done, Failure>) -> FieldRow {
    let failed = |failure: Failure| {
        let why = failure.text().unwrap_or_default();
        FieldOutcome::Failed(match failure.advice() {
            Some(advice) => format!("{why} -> {advice}"),
            None => why,
        })
    };
    let main = analyzed.as_ref().ok().and_then(|done| done.main.as_ref());
    FieldRow {
        field: field.display().to_string(),
        name: name.to_owned(),
        opens: main.and_then(|main| Some(format!("{name}/{}", main.file_name()?.display()))),
        outcome: match analyzed.map(|done| done.headlines) {
            Ok(Some(headlines)) => FieldOutcome::Headlines(Box::new(headlines)),
            Ok(None) => FieldOutcome::Failed(String::new()),
            Err(failure) => failed(failure),
        },
    }
}

/// A line of JSON: the field with its summary, or with its error.
fn print_json(field: &Path, analyzed: &Result<Done, Failure>) -> Result<(), Failure> {
    let field = field.display().to_string();
    let line = match analyzed {
        Ok(done) => {
            let summary: Value = serde_json::from_str(&done.json)?;
            let result = done.main.as_ref().and_then(|main| main.parent());
            json!({ "field": field, "result": result, "summary": summary })
        }
        Err(failure) => json!({ "field": field, "error": failure.text() }),
    };
    Ok(writeln!(terminal::stdout(), "{line}")?)
}

/// The verdicts, and whether all went well.
fn tell(how: &How, rows: &[FieldRow], out: &Path) -> Result<(), Failure> {
    let failed = rows.iter().filter(|row| failure_of(row).is_some()).count();
    if !how.quiet && !how.json {
        let mut summary = summary(rows);
        if failed < rows.len() {
            summary.last(&format!("open {}", out.join("index.html").display()));
        }
        summary.print(how.verbose)?;
    } else if !how.json {
        for row in rows {
            if let Some(why) = failure_of(row) {
                terminal::message(Tone::Error, &named(row, why));
            }
        }
    }
    match failed {
        0 => Ok(()),
        failed => Err(Failure::Partly(format!(
            "{failed} of {} fields have no result, for the reasons given",
            rows.len()
        ))),
    }
}

fn failure_of(row: &FieldRow) -> Option<&str> {
    match &row.outcome {
        FieldOutcome::Failed(why) => Some(why),
        FieldOutcome::Headlines(_) => None,
    }
}

/// A failure with its field, which many name themselves.
fn named(row: &FieldRow, why: &str) -> String {
    match why.starts_with(&row.field) {
        true => why.to_owned(),
        false => format!("{}: {why}", row.field),
    }
}

/// How many fields there are of each verdict, the verdicts, and why others have none.
fn summary(rows: &[FieldRow]) -> Summary {
    let (fields, verdicts) = verdicts_in_words(rows);
    let mut summary = Summary::new(&fields, &verdicts);
    for table in fields_tables(rows) {
        summary.table(&table);
    }
    for row in rows {
        if let Some(why) = failure_of(row) {
            let (why, advice) = why.split_once(" -> ").unwrap_or((why, ""));
            summary.warning(&named(row, why), advice);
        }
    }
    summary
}
