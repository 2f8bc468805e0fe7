//! What all commands on estimates share: one or several fields, one library call, a directory of results.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use wavecascade::arrays::Precision;
use wavecascade::field::{FileState, OpenOptions};
use wavecascade::observer::Observer;
use wavecascade::plot;
use wavecascade::report::{Archive, Provenance, ResultDirectory, sheet_html};
use wavecascade::sheet::{Describe, Warning};
use wavecascade::{Error, Field};

use crate::analyze::{named_after, open_options, print_notes, use_threads};
use crate::args::Input;
use crate::budget::command;
use crate::chain_args::How;
use crate::failure::Failure;
use crate::fields::expanded;
use crate::figure_args::{Drawing, FigureArgs};
use crate::progress::Progress;
use crate::summary::Summary;
use crate::terminal::{self, Tone};

/// Where the result goes, and how it is made.
#[derive(Debug, Args)]
pub struct EstimateArgs {
    /// Directory for the results; by default the field's name with the command's, here.
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,

    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub figures: FigureArgs,
    #[command(flatten)]
    pub how: How,
}

impl EstimateArgs {
    /// Worker threads; `None`: one a core.
    pub fn threads(&self) -> Option<usize> {
        self.how.threads.map(usize::from)
    }
}

/// What is typed of a command on an estimate: for the program, and for functions on arrays.
pub trait Typed {
    type Found: Describe;

    /// Name of the command: that of the file of arrays, and the end of the default directory.
    const COMMAND: &'static str;
    /// Extension of usual files of fields, which the default directory leaves out.
    const EXTENSION: &'static str = "npy";

    fn fields(&self) -> &[PathBuf];

    fn shared(&self) -> &EstimateArgs;

    /// Working memory.
    fn memory(&self) -> Option<u64>;

    /// What makes the estimate of the opened fields.
    ///
    /// # Errors
    /// For what is missing, or contradicts itself, whatever the fields are.
    fn computation(&self) -> Result<impl Computation<Self::Found>, Error>;

    /// Findings about the fields, beside those about the result.
    fn findings(&self, _found: &Self::Found) -> Vec<Warning> {
        Vec::new()
    }

    /// Writes what stands beside the arrays to new files of `directory`.
    fn write_beside(&self, _found: &Self::Found, _directory: &Path) -> Result<(), Error> {
        Ok(())
    }
}

/// Makes an estimate of opened fields.
pub trait Computation<E>: FnOnce(&[&Field], &dyn Observer) -> Result<E, Error> {}

impl<E, F: FnOnce(&[&Field], &dyn Observer) -> Result<E, Error>> Computation<E> for F {}

/// Where a result goes, and what it is called.
pub struct Target<'a> {
    pub out: &'a Path,
    /// In titles.
    pub name: &'a str,
    /// Of the sentence that answers: the file.
    pub subject: &'a str,
    pub provenance: &'a Provenance,
}

/// The name of the first file, and how many there are beside it.
pub fn subject_of(paths: &[PathBuf]) -> String {
    let Some((first, others)) = paths.split_first() else {
        return "field".into();
    };
    let name = first.file_name().unwrap_or(first.as_os_str());
    let name = name.to_string_lossy().into_owned();
    match others.len() {
        0 => name,
        others => format!("{name} and {others} more"),
    }
}

/// Opens the fields, makes the estimate, and publishes it.
pub fn run<T: Typed>(command_typed: &T) -> Result<(), Failure> {
    let compute = command_typed.computation()?;
    let typed = command_typed.shared();
    let drawing = typed.figures.drawing()?;
    let ending = format!("-{}", T::COMMAND);
    let default = |first: &Path| named_after(first, T::EXTENSION, &ending);
    let (paths, out) = begin(command_typed.fields(), typed, default)?;
    let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
    let fields = open(&paths, typed, command_typed.memory(), true)?;
    let all: Vec<&Field> = fields.iter().collect();
    let found = compute(&all, &progress).map_err(|error| error.of_file(&paths[0]))?;
    let opened: Vec<FileState> = fields.iter().filter_map(Field::file_state).collect();
    let hash = fields[0].content_hash.clone();
    drop(fields);
    progress.begin_writing();
    opened.iter().try_for_each(FileState::check)?;
    let input = paths[0].display().to_string();
    let provenance = Provenance::new(command(), Some(input), hash);
    let name = paths[0].file_stem().unwrap_or_default().to_string_lossy();
    let target = Target {
        out: &out,
        name: &name,
        subject: &subject_of(&paths),
        provenance: &provenance,
    };
    publish(command_typed, &found, &target, &drawing, &progress)
}

/// The files that `fields` names, and the directory of the result, which is checked before any work.
pub fn begin(
    fields: &[PathBuf],
    typed: &EstimateArgs,
    default: impl FnOnce(&Path) -> PathBuf,
) -> Result<(Vec<PathBuf>, PathBuf), Failure> {
    let paths = expanded(fields)?;
    use_threads(typed.threads())?;
    let out = typed.out.clone().unwrap_or_else(|| default(&paths[0]));
    drop(ResultDirectory::create(&out, typed.force)?);
    Ok((paths, out))
}

/// The fields, hashed if so.
pub fn open(
    paths: &[PathBuf],
    typed: &EstimateArgs,
    memory: Option<u64>,
    hash: bool,
) -> Result<Vec<Field>, Failure> {
    let options = OpenOptions {
        hash,
        ..open_options(&typed.input, memory)
    };
    let mut fields = Vec::new();
    for path in paths {
        let field = Field::open(path, &options)?;
        print_notes(&field, typed.how.quiet);
        fields.push(field);
    }
    Ok(fields)
}

/// Writes what was found to the directory of the target, and prints it.
pub fn publish<T: Typed>(
    command_typed: &T,
    found: &T::Found,
    target: &Target<'_>,
    drawing: &Drawing,
    progress: &Progress,
) -> Result<(), Failure> {
    let typed = command_typed.shared();
    let mut sheet = found.describe();
    sheet.warnings.extend(command_typed.findings(found));
    let directory = ResultDirectory::create(target.out, typed.force)?;
    let json = sheet
        .summary(target.provenance)
        .map_err(std::io::Error::from)?;
    directory.write("summary.json", &json)?;
    let arrays = format!("{}.npz", T::COMMAND);
    let archive = Archive::create(&directory.path().join(arrays), Precision::F64)?;
    sheet.write_to(&archive)?;
    archive.finish()?;
    command_typed.write_beside(found, directory.path())?;
    if drawing.is_wanted() {
        progress.stage("drawing", 1);
        let style = &drawing.style;
        let figure = plot::figure_of(found, &sheet, target.name, T::COMMAND, style);
        let folder = directory.path().join("figures");
        plot::save_all(&[figure], &folder, &drawing.formats)?;
        let page = sheet_html(found, &sheet, target.name, target.provenance, style);
        directory.write("report.html", page.map_err(std::io::Error::from)?)?;
    }
    progress.check()?;
    let published = directory.publish()?;
    progress.clear();
    if typed.how.json {
        if !typed.how.quiet {
            for warning in &sheet.warnings {
                terminal::message(Tone::Warning, &warning.message);
                terminal::message(Tone::Help, &warning.advice);
            }
        }
        writeln!(terminal::stdout(), "{json}")?;
    } else if !typed.how.quiet {
        let mut summary = Summary::of(target.subject, &sheet);
        let main = match drawing.is_wanted() {
            true => "report.html",
            false => "summary.json",
        };
        summary.last(&format!("open {}", published.join(main).display()));
        summary.print(typed.how.detail.verbose)?;
    }
    Ok(())
}
