//! `--part` and `--merge`: an estimate summed in several processes.

use wavecascade::estimates::{Combination, Combined, Part, PartialAbout, partial};
use wavecascade::field::FileState;
use wavecascade::report::{
    PARTIAL_SCHEMA, Provenance, ResultDirectory, read_partial, read_partial_about, write_partial,
};

use super::*;
use crate::analyze::named_after;
use crate::fields::expanded;
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

/// Sums a part, and writes it.
pub fn write(typed: &EstimateCommand, part: Part) -> Result<(), Failure> {
    let (name, estimate, shared) = typed.typed();
    let result = &shared.result;
    let progress = Progress::new(!result.how.quiet);
    let paths = expanded(&shared.fields)?;
    let ending = format!("-{}-{}-of-{}", name, part.number, part.of);
    let out = result.out.clone();
    let out = out.unwrap_or_else(|| named_after(&paths[0], "npy", &ending));
    drop(ResultDirectory::create(&out, result.force)?);
    let (fields, _) = open(&paths, shared.reading(), false, result.how.quiet, &progress)?;
    let all: Vec<_> = fields.iter().collect();
    let request = estimate.divided()?;
    let sums = on_threads(result.how.threads, || {
        partial(&all, &request, part, &progress)
    });
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
        summary.print(result.how.verbose)?;
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

/// The result of all parts, in the memory allowed.
pub struct Merge<'a>(pub &'a EstimateCommand, pub &'a PartArgs);

impl Describing for Merge<'_> {
    fn about(&self) -> About<'_> {
        About {
            files: Vec::new(),
            reading: None,
            ..self.0.about()
        }
    }

    fn find(&self, _: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let (Merge(typed, parts), memory) = (self, self.0.typed().2.memory);
        let about = |directory: &PathBuf| -> Result<(String, PartialAbout), Error> {
            let about = read_partial_about(&file(directory))?;
            Ok((directory.display().to_string(), about))
        };
        let all: Result<Vec<_>, Error> = parts.merge.iter().map(about).collect();
        let all = all?;
        let fields = all[0].1.fields.clone();
        let (mut combination, order) = Combination::new(all, memory)?;
        for at in order {
            if observer.cancelled() {
                return Err(Error::Cancelled);
            }
            combination.add(&read_partial(&file(&parts.merge[at]))?)?;
        }
        let found = any(combination.finish()?);
        let name = typed.typed().0;
        let (is_its, expected) = (
            found.describe().name == name,
            format!("parts of `cascade {name}`"),
        );
        Error::require(is_its, "merge", expected, "those of another command")?;
        let files: Vec<PathBuf> = fields.iter().map(PathBuf::from).collect();
        Ok(Found {
            name: Some(subject_of(&files)),
            input: Some(fields.join(", ")),
            ..Found::of(found)
        })
    }
}
