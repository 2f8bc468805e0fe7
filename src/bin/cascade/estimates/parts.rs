//! `--part` and `--merge`: an estimate summed in several processes.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use wavecascade::Error;
use wavecascade::estimates::{Combination, Combined, DividedRequest, Part, PartialAbout, partial};
use wavecascade::field::FileState;
use wavecascade::prepare::Examined;
use wavecascade::report::{
    PARTIAL_SCHEMA, Provenance, ResultDirectory, read_partial, read_partial_about, write_partial,
};

use crate::analyze::{named_after, use_threads};
use crate::budget::command;
use crate::estimates::{self, Target, Typed};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::summary::Summary;
use crate::terminal;

/// How an estimate is divided among processes.
#[derive(Debug, Args)]
#[command(next_help_heading = "Parts")]
pub struct PartArgs {
    /// Sum the I-th of N parts of the segments of all records, such as 3/64, and write a partial result; only
    /// the samples of these segments are read. There is no jackknife in parts.
    #[arg(long, value_name = "I/N", value_parser = part)]
    pub part: Option<Part>,
    /// Make the result of these directories, which `--part` has written: all parts, in any order, in `--memory`.
    #[arg(
        long,
        value_name = "DIR",
        num_args = 1..,
        requires = "out",
        conflicts_with_all = ["fields", "part", "Input", "averaging"]
    )]
    pub merge: Vec<PathBuf>,
}

/// A part and their number.
fn part(text: &str) -> Result<Part, String> {
    let expected = "expected a part and their number, such as 3/64: from 1/64 to 64/64";
    let (number, of) = text.split_once('/').ok_or(expected)?;
    match (number.trim().parse(), of.trim().parse()) {
        (Ok(number), Ok(of)) => Part::new(number, of).map_err(|_| expected.to_owned()),
        _ => Err(expected.into()),
    }
}

/// What is typed of an estimate that is summed in parts.
pub trait InParts: Typed {
    fn parts(&self) -> &PartArgs;

    /// What is summed.
    ///
    /// # Errors
    /// For options that contradict themselves.
    fn divided(&self) -> Result<DividedRequest, Error>;
}

/// The archive of a partial result.
const FILE: &str = "part.npz";

/// `summary.json` of a partial result.
#[derive(serde::Serialize)]
struct PartSummary<'a> {
    schema: &'static str,
    provenance: &'a Provenance,
    #[serde(flatten)]
    about: &'a PartialAbout,
}

/// Runs a command, a part of it, or makes the result of all parts, which `choose` picks if it is that of the
/// command.
pub fn run<T: InParts>(
    typed: &T,
    choose: impl FnOnce(Combined) -> Option<T::Found>,
) -> Result<(), Failure> {
    let PartArgs { part, merge: all } = typed.parts();
    match part {
        _ if !all.is_empty() => merge(typed, all, choose),
        Some(part) => write(typed, *part),
        None => estimates::run(typed),
    }
}

/// Sums a part, and writes it.
fn write<T: InParts>(typed: &T, part: Part) -> Result<(), Failure> {
    let (command_line, typed) = (typed, typed.shared());
    let ending = format!("-{}-{}-of-{}", T::COMMAND, part.number, part.of);
    let (paths, out) = estimates::begin(typed, |first| named_after(first, "npy", &ending))?;
    let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
    let fields = estimates::open(&paths, typed, false)?;
    let all: Vec<_> = fields.iter().collect();
    let request = command_line.divided()?;
    let sums =
        partial(&all, &request, part, &progress).map_err(|error| error.of_file(&paths[0]))?;
    let opened: Vec<FileState> = all.iter().filter_map(|field| field.file_state()).collect();
    drop(fields);
    progress.begin_writing();
    let directory = ResultDirectory::create(&out, typed.force)?;
    opened.iter().try_for_each(FileState::check)?;
    let provenance = Provenance::new(command(), Some(paths[0].display().to_string()), None);
    let summary = PartSummary {
        schema: PARTIAL_SCHEMA,
        provenance: &provenance,
        about: &sums.about,
    };
    let json = serde_json::to_string_pretty(&summary).map_err(std::io::Error::from)?;
    directory.write("summary.json", &json)?;
    write_partial(&directory.path().join(FILE), &sums)?;
    progress.check()?;
    let published = directory.publish()?;
    progress.clear();
    if typed.how.json {
        writeln!(terminal::stdout(), "{json}")?;
    } else if !typed.how.quiet {
        let [from, end] = sums.about.range;
        let answer = format!(
            "part {part} is summed, segments {from} to {} of all records, counted from 0",
            end - 1
        );
        let mut summary = Summary::new(&estimates::subject_of(&paths), &answer);
        summary.last(&format!("wrote {}", published.join(FILE).display()));
        summary.print(typed.how.detail.verbose)?;
    }
    Ok(())
}

/// The archive of the directory of a partial result, or this file.
fn file(directory: &Path) -> PathBuf {
    match directory.is_dir() {
        true => directory.join(FILE),
        false => directory.to_owned(),
    }
}

/// Makes the result of all parts in the memory allowed, which `choose` picks if it is that of this command.
fn merge<T: InParts>(
    command_line: &T,
    directories: &[PathBuf],
    choose: impl FnOnce(Combined) -> Option<T::Found>,
) -> Result<(), Failure> {
    let typed = command_line.shared();
    let drawing = typed.figures.drawing()?;
    use_threads(typed.threads())?;
    let Some(out) = &typed.out else {
        return Ok(());
    };
    drop(ResultDirectory::create(out, typed.force)?);
    let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
    let about = |directory: &PathBuf| -> Result<(String, PartialAbout), Error> {
        let about = read_partial_about(&file(directory))?;
        Ok((directory.display().to_string(), about))
    };
    let parts: Result<Vec<_>, Error> = directories.iter().map(about).collect();
    let parts = parts?;
    let fields = parts[0].1.fields.clone();
    let (mut combination, order) = Combination::new(parts, typed.memory)?;
    for at in order {
        progress.check()?;
        combination.add(&read_partial(&file(&directories[at]))?)?;
    }
    let Some(found) = choose(combination.finish()?) else {
        return Err(Failure::Library(Error::Request {
            option: "merge",
            expected: format!("parts of `cascade {}`", T::COMMAND),
            found: "those of another command".into(),
        }));
    };
    let name = fields.first().map_or("field", String::as_str);
    let provenance = Provenance::new(command(), Some(fields.join(", ")), None);
    let files: Vec<PathBuf> = fields.iter().map(PathBuf::from).collect();
    let target = Target {
        out,
        name,
        subject: &estimates::subject_of(&files),
        provenance: &provenance,
    };
    let found = Examined {
        found,
        channels: Vec::new(),
    };
    estimates::publish(command_line, &found, &target, &drawing, &progress)
}
