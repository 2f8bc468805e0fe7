//! `--part` and `--merge`: an estimate summed in several processes.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use wavecascade::Error;
use wavecascade::estimates::{Combination, Combined, DividedRequest, Part, PartialAbout, partial};
use wavecascade::field::FileState;
use wavecascade::report::{
    PARTIAL_SCHEMA, Provenance, ResultDirectory, read_partial, read_partial_about, write_partial,
};
use wavecascade::sheet::Describe;

use crate::analyze::named_after;
use crate::described::{AnyResult, Described, Describing, open, subject_of};
use crate::estimates::EstimateArgs;
use crate::failure::Failure;
use crate::fields::expanded;
use crate::parse;
use crate::summary::Summary;
use crate::terminal;
use crate::words;

/// How an estimate is divided among processes.
#[derive(Debug, Args)]
#[command(next_help_heading = "Parts")]
pub struct PartArgs {
    /// Sum the I-th of N parts of the segments of all records, such as 3/64, and write a partial result; only
    /// the samples of these segments are read. There is no jackknife in parts.
    #[arg(long, value_name = "I/N", value_parser = parse::part_of_segments)]
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

/// What is typed of an estimate that is summed in parts.
pub trait InParts: Describing {
    fn parts(&self) -> (&PartArgs, &EstimateArgs);

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

/// Sums a part, or makes the result of all parts, where one of them is typed.
pub fn run(typed: &dyn InParts) -> Option<Result<(), Failure>> {
    let (PartArgs { part, merge: all }, _) = typed.parts();
    match part {
        _ if !all.is_empty() => Some(merge(typed, all)),
        part => part.map(|part| write(typed, part)),
    }
}

/// Sums a part, and writes it.
fn write(typed: &dyn InParts, part: Part) -> Result<(), Failure> {
    let (_, shared) = typed.parts();
    let result = &shared.result;
    let progress = result.how.begin()?;
    let paths = expanded(&shared.fields)?;
    let ending = format!("-{}-{}-of-{}", typed.about().name, part.number, part.of);
    let out = result.out.clone();
    let out = out.unwrap_or_else(|| named_after(&paths[0], "npy", &ending));
    drop(ResultDirectory::create(&out, result.force)?);
    let fields = open(&paths, shared.reading(), false, result.how.quiet)?;
    let all: Vec<_> = fields.iter().collect();
    let sums = partial(&all, &typed.divided()?, part, &progress);
    let sums = sums.map_err(|error| error.of_file(&paths[0]))?;
    let opened: Vec<FileState> = all.iter().filter_map(|field| field.file_state()).collect();
    drop(fields);
    progress.begin_writing();
    let directory = ResultDirectory::create(&out, result.force)?;
    opened.iter().try_for_each(FileState::check)?;
    let input = paths[0].display().to_string();
    let summary = PartSummary {
        schema: PARTIAL_SCHEMA,
        provenance: &Provenance::new(words::as_text(), Some(input), None),
        about: &sums.about,
    };
    let json = serde_json::to_string_pretty(&summary)?;
    directory.write("summary.json", &json)?;
    write_partial(&directory.path().join(FILE), &sums)?;
    progress.check()?;
    let published = directory.publish()?;
    progress.clear();
    if result.how.json {
        writeln!(terminal::stdout(), "{json}")?;
    } else if !result.how.quiet {
        let [from, end] = sums.about.range;
        let answer = format!(
            "part {part} is summed, segments {from} to {} of all records, counted from 0",
            end - 1
        );
        let mut summary = Summary::new(&subject_of(&paths), &answer);
        summary.last(&format!("wrote {}", published.join(FILE).display()));
        summary.print(result.how.detail.verbose)?;
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

/// The result of all parts, whatever it is.
pub fn any(combined: Combined) -> AnyResult {
    match combined {
        Combined::Spectrum(found) => found,
        Combined::Coherence(found) => found,
    }
}

/// Makes the result of all parts in the memory allowed.
fn merge(typed: &dyn InParts, directories: &[PathBuf]) -> Result<(), Failure> {
    let (name, (_, shared)) = (typed.about().name, typed.parts());
    let result = &shared.result;
    let drawing = result.figures.drawing(None)?;
    let progress = result.how.begin()?;
    let Some(out) = &result.out else {
        return Ok(());
    };
    drop(ResultDirectory::create(out, result.force)?);
    let about = |directory: &PathBuf| -> Result<(String, PartialAbout), Error> {
        let about = read_partial_about(&file(directory))?;
        Ok((directory.display().to_string(), about))
    };
    let parts: Result<Vec<_>, Error> = directories.iter().map(about).collect();
    let parts = parts?;
    let fields = parts[0].1.fields.clone();
    let (mut combination, order) = Combination::new(parts, shared.memory)?;
    for at in order {
        progress.check()?;
        combination.add(&read_partial(&file(&directories[at]))?)?;
    }
    let found = any(combination.finish()?);
    let sheet = found.describe();
    if sheet.name != name {
        let expected = format!("parts of `cascade {name}`");
        return Err(Error::request("merge", expected, "those of another command").into());
    }
    let described = Described {
        found: &*found,
        sheet: &sheet,
        name: fields.first().map_or("field", String::as_str),
        provenance: &Provenance::new(words::as_text(), Some(fields.join(", ")), None),
    };
    let files: Vec<PathBuf> = fields.iter().map(PathBuf::from).collect();
    let directory = ResultDirectory::create(out, result.force)?;
    let place = (directory, name);
    let main = described.publish(place, None, &drawing, &progress, &|_| Ok(()))?;
    described.tell(&subject_of(&files), &result.how, Some(&main))?;
    drawing.present(&main)
}
