//! `cascade clean`: what killed runs have left.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use wavecascade::report::{Hold, Leftover, Leftovers};

use crate::failure::Failure;
use crate::table::Table;
use crate::terminal::{self, Tone, message};

/// What `cascade clean` takes.
#[derive(Debug, Args)]
pub struct Clean {
    /// Folder to look in; those below it are looked into, too.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// List what would be removed, and remove nothing.
    #[arg(long, short = 'n')]
    pub dry_run: bool,
    /// Print the list as JSON.
    #[arg(long)]
    pub json: bool,
    /// Print errors only.
    #[arg(long, short)]
    pub quiet: bool,
}

/// What became of a leftover.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Outcome {
    Removed,
    /// It was an earlier result, which has its name again.
    Restored,
    /// It is to be removed by a call without `--dry-run`.
    Removable,
    Held,
    Failed,
}

/// One line of the list.
#[derive(Debug, Serialize)]
struct Row {
    path: PathBuf,
    bytes: u64,
    /// Result that it was to become.
    #[serde(skip_serializing_if = "Option::is_none")]
    target: Option<PathBuf>,
    outcome: Outcome,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

#[derive(Debug, Serialize)]
struct Answer<'a> {
    schema: &'static str,
    leftovers: &'a [Row],
}

/// Runs the command.
pub fn run(typed: Clean) -> Result<(), Failure> {
    let all = Leftovers::below(&typed.folder)?;
    let treated = all.found.into_iter().map(|found| row(found, typed.dry_run));
    let rows: Vec<Row> = treated.collect();
    if typed.json {
        let answer = Answer {
            schema: "cascade.clean/1",
            leftovers: &rows,
        };
        let text = serde_json::to_string_pretty(&answer).map_err(std::io::Error::from)?;
        writeln!(terminal::stdout(), "{text}")?;
    } else if !typed.quiet {
        let text = text(&rows, &typed.folder, terminal::width());
        terminal::stdout().write_all(text.as_bytes())?;
    }
    for error in &all.unread {
        message(Tone::Error, &error.to_string());
    }
    match count(&rows, Outcome::Failed) + all.unread.len() {
        0 => Ok(()),
        failed => Err(Failure::Leftovers(failed)),
    }
}

/// Removes what nobody holds, unless it is only listed.
fn row(found: Leftover, is_listed: bool) -> Row {
    let mut row = Row {
        path: found.path.clone(),
        bytes: found.bytes,
        target: found.target.as_ref().map(|t| found.path.with_file_name(t)),
        outcome: Outcome::Held,
        reason: reason(found.hold).map(str::to_owned),
    };
    if found.hold != Hold::Nobody {
        return row;
    }
    row.outcome = match is_listed {
        true => Outcome::Removable,
        false => match found.remove() {
            Ok(None) => Outcome::Removed,
            Ok(Some(_)) => Outcome::Restored,
            Err(error) => {
                row.reason = Some(error.to_string());
                Outcome::Failed
            }
        },
    };
    row
}

/// Why something stays.
fn reason(hold: Hold) -> Option<&'static str> {
    Some(match hold {
        Hold::Nobody => return None,
        Hold::Process => "a process writes it",
        Hold::Recent => {
            "it changed less than a day ago, and a process of another machine may write it"
        }
        Hold::Unknown => "its lock cannot be tried here, so a process may write it",
        Hold::EarlierResult => {
            "it is an earlier result whose name is not known: rename or remove it yourself"
        }
    })
}

fn count(rows: &[Row], outcome: Outcome) -> usize {
    rows.iter().filter(|row| row.outcome == outcome).count()
}

fn text(rows: &[Row], folder: &Path, width: usize) -> String {
    if rows.is_empty() {
        return format!("no leftovers of killed runs below {}\n", folder.display());
    }
    let mut table = Table::new("leftover").numbers("size").words("");
    for row in rows {
        let (path, size) = (row.path.display().to_string(), size(row.bytes));
        let target = row.target.as_ref().and_then(|target| target.file_name());
        let target = target.map(|name| name.to_string_lossy().into_owned());
        let outcome = match (row.outcome, target) {
            (Outcome::Removed, Some(target)) => format!("removed; was to become {target}"),
            (Outcome::Removed, None) => "removed".to_owned(),
            (Outcome::Restored, Some(target)) => format!("restored as {target}"),
            (Outcome::Restored, None) => "restored".to_owned(),
            (Outcome::Removable, Some(target)) => format!("was to become {target}"),
            (Outcome::Removable, None) => String::new(),
            (Outcome::Held, _) => "stays".to_owned(),
            (Outcome::Failed, _) => "could not be removed".to_owned(),
        };
        table.noted_row(
            vec![path, size, outcome],
            row.reason.as_deref().unwrap_or(""),
        );
    }
    table.text(width) + &total(rows)
}

/// How many there are of each, and their size.
fn total(rows: &[Row]) -> String {
    let of = |outcome: Outcome| {
        let rows = rows.iter().filter(move |row| row.outcome == outcome);
        let bytes = rows.clone().map(|row| row.bytes).sum();
        (rows.count(), size(bytes))
    };
    let parts = [
        (Outcome::Removed, "removed"),
        (Outcome::Restored, "restored"),
        (Outcome::Removable, "to be removed without --dry-run"),
        (Outcome::Held, "left alone"),
        (Outcome::Failed, "not removed"),
    ];
    let parts = parts.into_iter().filter_map(|(outcome, word)| {
        let (count, size) = of(outcome);
        (count > 0).then(|| format!("{count} {word} ({size})"))
    });
    parts.collect::<Vec<_>>().join(", ") + "\n"
}

fn size(bytes: u64) -> String {
    wavecascade_system::memory::size(bytes)
}
