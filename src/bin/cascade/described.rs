//! What is done with a described result, whatever it is: its files, and what is printed.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use wavecascade::arrays::Precision;
use wavecascade::field::{OpenOptions, file_hash};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, figures_of};
use wavecascade::report::{
    Archive, Provenance, ResultDirectory, RunFile, sheet_html, write_beside,
};
use wavecascade::sheet::{Describe, Sheet};
use wavecascade::{Error, Field};

use crate::analyze::{named_after, open_options, print_notes};
use crate::args::Input;
use crate::chain_args::How;
use crate::failure::Failure;
use crate::figure_args::{Drawing, FigureArgs};
use crate::progress::Progress;
use crate::summary::Summary;
use crate::terminal::{self, Tone};

/// Where the result of a command goes, and how it is made.
#[derive(Debug, Clone, Args)]
pub struct ResultArgs {
    /// Directory for the results; by default the file's name with the command's, here.
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,

    #[command(flatten)]
    pub figures: FigureArgs,
    #[command(flatten)]
    pub how: How,
}

/// A result that any thread may describe.
pub type AnyResult = Box<dyn Describe + Send + Sync>;

/// What was found, and a file of this name that goes beside it.
pub struct Found {
    pub result: AnyResult,
    pub beside: Option<(&'static str, String)>,
}

impl Found {
    pub fn of(result: impl Describe + Send + Sync + 'static) -> Found {
        Found {
            result: Box::new(result),
            beside: None,
        }
    }
}

/// What a result is made of: the fields, and what a caller holds in memory in place of files.
#[derive(Default)]
pub struct Given<'a> {
    pub fields: &'a [&'a Field],
    /// Text of a scene.
    pub scene: Option<String>,
    pub run: Option<Arc<RunFile>>,
}

impl Given<'_> {
    /// The one field that a command is of.
    pub fn field(&self) -> Result<&Field, Error> {
        let first = self.fields.first().copied();
        first.ok_or_else(|| Error::request("field", "one", "none"))
    }
}

/// How fields are read.
pub struct Reading<'a> {
    pub input: &'a Input,
    pub memory: Option<u64>,
}

/// A command whose result is described: for the program, and for functions on arrays.
pub trait Describing: Sync {
    /// Name of the command: that of its arrays, and the end of the default directory.
    fn name(&self) -> &'static str;

    fn how(&self) -> &How;

    /// How its files are read as fields, where they are fields.
    fn reading(&self) -> Option<Reading<'_>> {
        None
    }

    /// That the options fit each other, before any work.
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Makes the result.
    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error>;
}

/// A [`Describing`] command that makes a directory of results from files.
pub trait Publishing: Describing {
    fn result(&self) -> &ResultArgs;

    /// Its files, and their usual extension, which the default directory leaves out.
    fn files(&self) -> Result<(Vec<PathBuf>, &'static str), Failure>;

    /// Name of the file of arrays.
    fn arrays(&self) -> &'static str {
        self.name()
    }
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

/// The name of a file without its extension.
pub fn stem_of(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or(path.as_os_str());
    stem.to_string_lossy().into_owned()
}

/// The fields of these files, hashed if so.
pub fn open(
    paths: &[PathBuf],
    reading: Reading,
    hash: bool,
    quiet: bool,
) -> Result<Vec<Field>, Error> {
    let options = OpenOptions {
        hash,
        ..open_options(reading.input, reading.memory)
    };
    let one = |path: &PathBuf| {
        let field = Field::open(path, &options)?;
        print_notes(&field, quiet);
        Ok(field)
    };
    paths.iter().map(one).collect()
}

/// Makes the result of files, publishes it and prints it.
pub fn run(command: &dyn Publishing) -> Result<(), Failure> {
    command.check()?;
    let (result, how) = (command.result(), command.how());
    let drawing = result.figures.drawing(None)?;
    let progress = how.begin()?;
    let (files, usual) = command.files()?;
    let default = || named_after(&files[0], usual, &format!("-{}", command.name()));
    let out = result.out.clone().unwrap_or_else(default);
    // Before any work: could the result be written?
    drop(ResultDirectory::create(&out, result.force)?);
    let fields = match command.reading() {
        Some(reading) => open(&files, reading, true, how.quiet)?,
        None => Vec::new(),
    };
    progress.begin_writing();
    let directory = ResultDirectory::create(&out, result.force)?;
    let opened: Vec<&Field> = fields.iter().collect();
    let given = Given {
        fields: &opened,
        ..Given::default()
    };
    let found = command.find(given, &progress);
    let found = found.map_err(|error| error.of_file(&files[0]))?;
    fields.iter().try_for_each(Field::check_unchanged)?;
    let hash = match fields.first() {
        Some(field) => field.content_hash.clone(),
        None => Some(file_hash(&files[0])?),
    };
    drop(fields);
    let input = files[0].display().to_string();
    let described = Described {
        found: &*found.result,
        sheet: &found.result.describe(),
        name: &stem_of(&files[0]),
        provenance: &Provenance::new(crate::words::as_text(), Some(input), hash),
    };
    let place = (directory, command.arrays());
    let main = described.publish(place, &drawing, &progress, |path| match &found.beside {
        Some((name, text)) => write_beside(path, name, text.as_bytes()).map(|_| ()),
        None => Ok(()),
    })?;
    described.tell(&subject_of(&files), how, Some(&main))?;
    drawing.present(&main)
}

/// Publishes what is in the directory, and prints and presents it.
pub fn end(
    (sheet, subject): (&Sheet, &str),
    json: &str,
    directory: ResultDirectory,
    (drawing, how): (&Drawing, &How),
    progress: &Progress,
) -> Result<(), Failure> {
    progress.check()?;
    let main = directory.publish()?.join(drawing.main());
    progress.clear();
    tell(sheet, json, subject, how, Some(&main))?;
    drawing.present(&main)
}

/// A result with its description.
pub struct Described<'a> {
    pub found: &'a dyn Describe,
    pub sheet: &'a Sheet<'a>,
    /// Of the data, in titles.
    pub name: &'a str,
    pub provenance: &'a Provenance,
}

impl Described<'_> {
    pub fn json(&self) -> Result<String, Failure> {
        Ok(self.sheet.summary(self.provenance)?)
    }

    fn page(&self, drawing: &Drawing) -> Result<String, Failure> {
        let Described {
            found,
            sheet,
            name,
            provenance,
        } = self;
        Ok(sheet_html(*found, sheet, name, provenance, &drawing.style)?)
    }

    /// Writes `summary.json`, arrays and figures called `file`, `table.csv` and the page, where there are such, to a
    /// directory that appears whole, with what `beside` adds; returns the file to open.
    pub fn publish(
        &self,
        (directory, file): (ResultDirectory, &'static str),
        drawing: &Drawing,
        progress: &Progress,
        beside: impl FnOnce(&Path) -> Result<(), Error>,
    ) -> Result<PathBuf, Failure> {
        let sheet = self.sheet;
        directory.write("summary.json", self.json()?)?;
        if !sheet.variables.is_empty() {
            let arrays = directory.path().join(format!("{file}.npz"));
            let archive = Archive::create(&arrays, Precision::F64)?;
            sheet.write_to(&archive)?;
            archive.finish()?;
        }
        if !sheet.records.head.is_empty() {
            let csv = sheet.records.to_csv().map_err(std::io::Error::other)?;
            directory.write("table.csv", csv)?;
        }
        beside(directory.path())?;
        if drawing.is_wanted() {
            progress.stage("drawing", 1);
            let figures = figures_of(self.found, sheet, self.name, file, &drawing.style);
            let folder = directory.path().join("figures");
            plot::save_all(&figures, &folder, &drawing.formats)?;
            directory.write("report.html", self.page(drawing)?)?;
        }
        progress.check()?;
        let published = directory.publish()?;
        progress.clear();
        Ok(published.join(drawing.main()))
    }

    /// The same in the directory of a journal, which keeps the runs that the result is made of, each file whole: rows
    /// are in `curves.csv`, the figure beside it.
    pub fn keep(&self, out: &Path, drawing: &Drawing) -> Result<PathBuf, Failure> {
        let sheet = self.sheet;
        let summary = write_beside(out, "summary.json", self.json()?.as_bytes())?;
        let csv = sheet.records.to_csv().map_err(std::io::Error::other)?;
        write_beside(out, "curves.csv", csv.as_bytes())?;
        if !drawing.is_wanted() {
            return Ok(summary);
        }
        for figure in figures_of(self.found, sheet, self.name, sheet.name, &drawing.style) {
            for format in &drawing.formats {
                let file = format!("{}.{}", figure.name(), format.extension());
                write_beside(out, &file, &figure.encode(*format)?)?;
            }
        }
        Ok(write_beside(
            out,
            "report.html",
            self.page(drawing)?.as_bytes(),
        )?)
    }

    /// Prints the JSON, or what was found of the subject and the file to open.
    pub fn tell(&self, subject: &str, how: &How, main: Option<&Path>) -> Result<(), Failure> {
        tell(self.sheet, &self.json()?, subject, how, main)
    }
}

/// Prints the JSON, or what was found of the subject and the file to open.
pub fn tell(
    sheet: &Sheet,
    json: &str,
    subject: &str,
    how: &How,
    main: Option<&Path>,
) -> Result<(), Failure> {
    if how.json {
        if !how.quiet {
            for warning in &sheet.warnings {
                terminal::message(Tone::Warning, &warning.message);
                if !warning.advice.is_empty() {
                    terminal::message(Tone::Help, &warning.advice);
                }
            }
        }
        writeln!(terminal::stdout(), "{json}")?;
    } else if !how.quiet {
        let mut summary = Summary::of(subject, sheet);
        if let Some(main) = main {
            summary.last(&format!("open {}", main.display()));
        }
        summary.print(how.detail.verbose)?;
    }
    Ok(())
}
