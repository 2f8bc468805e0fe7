//! `cascade analyze` of several fields: one after the other, and an index of them.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use wavecascade::Error;
use wavecascade::report::{
    FieldOutcome, FieldRow, FieldSet, Headlines, field_names, fields_tables, verdicts_in_words,
};

use crate::analyze::{Finished, Task, print_plan};
use crate::args::{Analyze, Output};
use crate::failure::Failure;
use crate::present::open_page;
use crate::progress::Progress;
use crate::summary::Summary;
use crate::terminal::{self, HEADING, Tone, styled};

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
    if typed.work.plan {
        return plans(typed, fields);
    }
    let names = field_names(fields)?;
    let out = typed.out.clone().unwrap_or_else(|| DEFAULT.into());
    let mut set = FieldSet::create(&out, typed.force)?;
    let progress = Progress::new(!typed.output.quiet);
    // From now on a directory and an index remain.
    progress.begin_writing();
    for (n, (field, name)) in fields.iter().zip(&names).enumerate() {
        progress.of(n + 1, fields.len(), name);
        let (place, replace) = set.place(name);
        let task = Task {
            typed,
            field,
            files: std::slice::from_ref(field),
            out: &place,
            replace,
            progress: &progress,
        };
        let analyzed = task.run();
        progress.clear();
        if matches!(analyzed, Err(Failure::Library(Error::Cancelled))) {
            return stopped(set.stop(), &out, fields.len());
        }
        if typed.output.json {
            print_json(field, &analyzed)?;
        }
        set.add(row(field, name, analyzed))?;
    }
    let rows = set.finish()?;
    if typed.figures.present.open {
        open_page(&out.join("index.html"));
    }
    tell(typed, &rows, &out)
}

/// What would be computed of each field.
fn plans(typed: &Analyze, fields: &[PathBuf]) -> Result<(), Failure> {
    for field in fields {
        if !typed.output.json {
            let name = styled(HEADING, &field.display().to_string());
            writeln!(terminal::stdout(), "{name}")?;
        }
        print_plan(typed, std::slice::from_ref(field))?;
    }
    Ok(())
}

/// A field with its headlines, or why it has none.
fn row(field: &Path, name: &str, analyzed: Result<Finished, Failure>) -> FieldRow {
    FieldRow {
        field: field.display().to_string(),
        name: name.to_owned(),
        opens: analyzed.as_ref().ok().map(|finished| {
            let file = finished.main.file_name().unwrap_or_default();
            let file = file.to_string_lossy();
            format!("{name}/{file}")
        }),
        outcome: match analyzed {
            Ok(finished) => FieldOutcome::Headlines(Box::new(Headlines::of(&finished.analysis))),
            Err(failure) => {
                let why = failure.text().unwrap_or_default();
                let why = match failure.advice() {
                    Some(advice) => format!("{why} -> {advice}"),
                    None => why,
                };
                FieldOutcome::Failed(why)
            }
        },
    }
}

/// A line of JSON: the field with its summary, or with its error.
fn print_json(field: &Path, analyzed: &Result<Finished, Failure>) -> Result<(), Failure> {
    let field = field.display().to_string();
    let line = match analyzed {
        Ok(finished) => {
            let summary: Value = serde_json::from_str(&finished.json)?;
            json!({ "field": field, "result": finished.main.parent(), "summary": summary })
        }
        Err(failure) => json!({ "field": field, "error": failure.text() }),
    };
    Ok(writeln!(terminal::stdout(), "{line}")?)
}

/// Says what an interrupt has left.
fn stopped(rows: Vec<FieldRow>, out: &Path, fields: usize) -> Result<(), Failure> {
    let known = rows.len();
    Err(match known {
        0 => Failure::Library(Error::Cancelled),
        _ => Failure::Stopped {
            known,
            fields,
            out: out.to_owned(),
        },
    })
}

/// The verdicts, and whether all went well.
fn tell(typed: &Analyze, rows: &[FieldRow], out: &Path) -> Result<(), Failure> {
    let failed = rows.iter().filter(|row| failure_of(row).is_some()).count();
    let Output { json, quiet, .. } = typed.output;
    if !quiet && !json {
        let mut summary = summary(rows);
        if failed < rows.len() {
            summary.last(&format!("open {}", out.join("index.html").display()));
        }
        summary.print(typed.output.detail.verbose)?;
    } else if !json {
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
