//! `cascade analyze` of several fields: one after the other, and an index of them.

use std::collections::BTreeSet;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use wavecascade::Error;
use wavecascade::report::{
    FieldOutcome, FieldRow, FieldSet, Headlines, Movement, field_names, percent,
};

use crate::analyze::{Finished, Task, print_plan};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::settings::{Call, CommandLine};
use crate::table::Table;
use crate::terminal::{self, HEADING, Tone, number, paragraphs, styled};

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
pub fn run(line: &CommandLine, fields: &[PathBuf]) -> Result<(), Failure> {
    let call = line.call();
    if call.plan {
        return plans(line, fields);
    }
    let names = field_names(fields)?;
    // Words that no field accepts end the program before anything is made.
    let _faults_of_settings = line.analyze(&fields[0]);
    let out = call.out.clone().unwrap_or_else(|| DEFAULT.into());
    let mut set = FieldSet::create(&out, call.force)?;
    let progress = Progress::new(!call.quiet && std::io::stderr().is_terminal());
    // From now on a directory and an index remain.
    progress.begin_writing();
    let mut said = BTreeSet::new();
    for (n, (field, name)) in fields.iter().zip(&names).enumerate() {
        progress.of(n + 1, fields.len(), name);
        let (place, replace) = set.place(name);
        let analyzed = line.analyze(field).and_then(|(typed, applied)| {
            if !call.quiet {
                let notes = applied.notes().into_iter();
                let fresh: Vec<String> = notes.filter(|note| said.insert(note.clone())).collect();
                fresh
                    .iter()
                    .for_each(|note| terminal::message(Tone::Note, note));
            }
            let task = Task {
                typed: &typed,
                field,
                files: std::slice::from_ref(field),
                out: &place,
                replace,
                applied: &applied,
                progress: &progress,
            };
            task.run().map_err(|failure| applied.located(failure))
        });
        progress.clear();
        if matches!(analyzed, Err(Failure::Library(Error::Cancelled))) {
            return stopped(set.stop(), &out, fields.len());
        }
        if call.json {
            print_json(field, &analyzed)?;
        }
        set.add(row(field, name, analyzed))?;
    }
    let rows = set.finish()?;
    tell(&call, &rows, &out)
}

/// What would be computed of each field.
fn plans(line: &CommandLine, fields: &[PathBuf]) -> Result<(), Failure> {
    for field in fields {
        let (typed, applied) = line.analyze(field)?;
        if !typed.output.json {
            let name = styled(HEADING, &field.display().to_string());
            writeln!(terminal::stdout(), "{name}")?;
        }
        print_plan(&typed, std::slice::from_ref(field))
            .map_err(|failure| applied.located(failure))?;
    }
    Ok(())
}

/// A field with its headlines, or why it has none.
fn row(field: &Path, name: &str, analyzed: Result<Finished, Failure>) -> FieldRow {
    FieldRow {
        field: field.display().to_string(),
        name: name.to_owned(),
        opens: analyzed.as_ref().ok().map(|finished| {
            let page = finished.main();
            let file = page.file_name().unwrap_or_default().to_string_lossy();
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
            let summary: Value =
                serde_json::from_str(&finished.json).map_err(std::io::Error::from)?;
            json!({ "field": field, "result": finished.published.display().to_string(), "summary": summary })
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

/// The table at the end, and whether all went well.
fn tell(call: &Call, rows: &[FieldRow], out: &Path) -> Result<(), Failure> {
    let failed = rows.iter().filter(|row| failure_of(row).is_some()).count();
    if !call.quiet && !call.json {
        let text = table(rows, terminal::width());
        let mut stdout = terminal::stdout();
        stdout.write_all(text.as_bytes())?;
        if failed < rows.len() {
            writeln!(stdout, "open {}", out.join("index.html").display())?;
        }
    } else if !call.json {
        for row in rows {
            if let Some(why) = failure_of(row) {
                terminal::message(Tone::Error, &named(row, why));
            }
        }
    }
    match failed {
        0 => Ok(()),
        failed => Err(Failure::Fields {
            failed,
            fields: rows.len(),
        }),
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

/// Headlines in columns, then the failures.
fn table(rows: &[FieldRow], width: usize) -> String {
    let (centroid, high) = ("centroid ratio", "high band, last");
    let table = Table::new("field")
        .numbers("size")
        .in_group(centroid, "along x")
        .in_group(centroid, "in time")
        .in_group(high, "along x")
        .in_group(high, "in time");
    let mut table = table.numbers("to +x").numbers("warnings");
    let mut failures = Vec::new();
    let known = |value: Option<f64>, word: fn(f64) -> String| value.map_or("-".into(), word);
    for row in rows {
        let found = match &row.outcome {
            FieldOutcome::Headlines(found) => found,
            FieldOutcome::Failed(why) => {
                failures.push(named(row, why));
                continue;
            }
        };
        let [x, t] = [&found.along_x, &found.along_t].map(Option::as_ref);
        let high = |of: Option<&Movement>| of?.last?.high_share;
        table.row(vec![
            row.name.clone(),
            format!("{} x {}", found.times, found.sites),
            known(x.and_then(Movement::rise), number),
            known(t.and_then(Movement::rise), number),
            known(high(x), percent),
            known(high(t), percent),
            known(found.toward_plus_x, percent),
            found.warnings.to_string(),
        ]);
    }
    let mut text = String::new();
    if failures.len() < rows.len() {
        text += &table.text(width);
        let legend = "centroid ratio: at the last site or time with energy, over the reference";
        text += &paragraphs(&[legend.to_owned()], width);
    }
    if !failures.is_empty() {
        text += &format!("{}\n", styled(Tone::Error.style(), "failed"));
        text += &paragraphs(&failures, width);
    }
    text
}
