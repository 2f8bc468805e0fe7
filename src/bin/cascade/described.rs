//! What is done with a described result, whatever it is: its files, and what is printed.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use wavecascade::arrays::{Nowhere, Precision, Sink};
use wavecascade::field::{FileState, OpenOptions, file_hash, is_run_file};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, figures_of};
use wavecascade::report::{
    ArrayFile, ArrayFormat, Provenance, ResultDirectory, RunFile, sheet_html, write_beside,
};
use wavecascade::sheet::{Describe, Sheet};
use wavecascade::{Error, Field};
use wavecascade_system::threads::in_pool;

use crate::analyze::{named_after, open_options, print_notes, use_threads};
use crate::args::Input;
use crate::chain_args::How;
use crate::failure::Failure;
use crate::fields::expanded;
use crate::figure_args::{ColorArgs, Drawing, FigureArgs};
use crate::progress::Progress;
use crate::summary::Summary;
use crate::terminal::{self, Tone};
use crate::words::as_text;

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

/// Writes what goes beside a result to its directory.
type Beside = Box<dyn Fn(&Path) -> Result<(), Error> + Send + Sync>;

/// What was found.
pub struct Found {
    pub result: AnyResult,
    pub beside: Beside,
    /// Why a part of it is missing.
    pub failed: Option<String>,
}

impl Found {
    pub fn of(result: impl Describe + Send + Sync + 'static) -> Found {
        Found {
            result: Box::new(result),
            beside: Box::new(|_| Ok(())),
            failed: None,
        }
    }

    /// With a text as the file of this name beside it.
    pub fn with_text(self, name: &'static str, text: String) -> Found {
        let write =
            move |directory: &Path| write_beside(directory, name, text.as_bytes()).map(|_| ());
        Found {
            beside: Box::new(write),
            ..self
        }
    }
}

/// What a result is made of: the fields, and what a caller holds in memory in place of files.
#[derive(Default)]
pub struct Given<'a> {
    pub fields: &'a [&'a Field],
    /// Text of a scene.
    pub scene: Option<String>,
    /// Of each run the one in memory, if it is there.
    pub runs: Vec<Option<Arc<RunFile>>>,
    /// Where large arrays go.
    pub arrays: Option<&'a dyn ArrayFile>,
    /// The command, as it is kept with results.
    pub words: Vec<String>,
}

impl Given<'_> {
    /// The one field that a command is of.
    pub fn field(&self) -> Result<&Field, Error> {
        let first = self.fields.first().copied();
        first.ok_or_else(|| Error::request("field", "one", "none"))
    }

    /// The n-th run, else that of a file.
    pub fn run(&self, n: usize, path: &Path) -> Result<Arc<RunFile>, Error> {
        if let Some(Some(run)) = self.runs.get(n) {
            return Ok(Arc::clone(run));
        }
        match path.is_file() && !is_run_file(path)? {
            true => Err(not_a_run(path)),
            false => Ok(Arc::new(RunFile::read(path)?)),
        }
    }

    pub fn sink(&self) -> &dyn Sink {
        match self.arrays {
            Some(file) => file,
            None => &Nowhere,
        }
    }
}

/// A field, whose law is not known.
pub fn not_a_run(name: &Path) -> Error {
    Error::Unfit {
        path: name.to_owned(),
        expected: "a run file of `cascade simulate`, whose law is known".into(),
        found: "a file that is no run".into(),
    }
}

/// How fields are read.
#[derive(Clone, Copy)]
pub struct Reading<'a> {
    pub input: &'a Input,
    pub memory: Option<u64>,
}

/// What is known of a command before its result is made.
pub struct About<'a> {
    /// Its name, which ends that of the default directory.
    pub name: &'static str,
    pub threads: Option<usize>,
    /// Its files, or patterns of them.
    pub files: Vec<PathBuf>,
    /// Their usual extension, which the default directory leaves out.
    pub usual: &'static str,
    /// What the result is of, where it is of no file.
    pub subject: String,
    /// How its files are read as fields, where they are fields.
    pub reading: Option<Reading<'a>>,
    pub colors: Option<&'a ColorArgs>,
    /// Format of the file of arrays, where large ones come in blocks.
    pub format: Option<ArrayFormat>,
    /// Whether its directory keeps the runs that the result is made of, so that it is named and may be there.
    pub is_journal: bool,
    /// Name of the file of arrays and of the figure, where it is not that of the result.
    pub arrays: Option<&'static str>,
}

impl About<'_> {
    pub fn of<'a, 'f>(
        name: &'static str,
        how: &How,
        files: impl IntoIterator<Item = &'f PathBuf>,
        usual: &'static str,
    ) -> About<'a> {
        About {
            name,
            threads: how.threads,
            files: files.into_iter().cloned().collect(),
            usual,
            subject: String::new(),
            reading: None,
            colors: None,
            format: None,
            is_journal: false,
            arrays: None,
        }
    }
}

/// A command whose result is described: for the program, and for functions on arrays.
pub trait Describing: Sync {
    fn about(&self) -> About<'_>;

    /// That the options fit each other, before any work.
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Makes the result.
    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error>;
}

/// The names of one or two files, or of the first and how many there are beside it.
fn joined(names: &[String]) -> String {
    match names {
        [first, others @ ..] if others.len() > 1 => format!("{first} and {} more", others.len()),
        few => few.join(" and "),
    }
}

/// Files as they are named in sentences.
pub fn subject_of(paths: &[PathBuf]) -> String {
    let names = paths.iter().map(|path| {
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    });
    joined(&names.collect::<Vec<_>>())
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

/// Makes the result, publishes it where a directory is named or follows from its files, and prints it.
pub fn run(command: &dyn Describing, result: &ResultArgs) -> Result<(), Failure> {
    command.check()?;
    let (about, how) = (command.about(), &result.how);
    let drawing = result.figures.drawing(about.colors)?;
    use_threads(about.threads)?;
    let progress = Progress::new(!how.quiet);
    let files = expanded(&about.files)?;
    let ending = format!("-{}", about.name);
    let default = || Some(named_after(files.first()?, about.usual, &ending));
    let journal = result.out.as_deref().filter(|_| about.is_journal);
    let out = match about.is_journal {
        true => None,
        false => result.out.clone().or_else(default),
    };
    let begun = || {
        let directory = out
            .as_ref()
            .map(|out| ResultDirectory::create(out, result.force));
        directory.transpose()
    };
    // Before any work: could the result be written?
    drop(begun()?);
    let fields = match about.reading {
        Some(reading) => open(&files, reading, true, how.quiet)?,
        None => Vec::new(),
    };
    let opened: Vec<FileState> = match about.reading {
        Some(_) => fields.iter().filter_map(Field::file_state).collect(),
        None => files
            .iter()
            .map(|path| FileState::at(path))
            .collect::<Result<_, _>>()?,
    };
    progress.begin_writing();
    let directory = begun()?;
    let arrays = match (&directory, about.format) {
        (Some(directory), Some(format)) => {
            Some(format.create(directory.path(), about.name, Precision::F64)?)
        }
        _ => None,
    };
    let given = Given {
        fields: &fields.iter().collect::<Vec<_>>(),
        arrays: arrays.as_deref(),
        words: as_text(),
        ..Given::default()
    };
    let found = command.find(given, &progress);
    let found = found.map_err(|error| match files.first() {
        Some(file) => error.of_file(file),
        None => error,
    })?;
    let hash = match (fields.first(), files.first()) {
        (Some(field), _) => field.content_hash.clone(),
        (None, Some(file)) => Some(file_hash(file)?),
        (None, None) => None,
    };
    // All that reads or hashes the files has done so.
    opened.iter().try_for_each(FileState::check)?;
    drop(fields);
    let stems: Vec<String> = files.iter().map(|path| stem_of(path)).collect();
    let [name, subject] = match files.is_empty() {
        true => [about.subject.clone(), about.subject],
        false => [joined(&stems), subject_of(&files)],
    };
    let input = files.first().map(|path| path.display().to_string());
    let sheet = found.result.describe();
    let described = Described {
        found: &*found.result,
        sheet: &sheet,
        name: &name,
        provenance: &Provenance::new(as_text(), input, hash),
    };
    let main = directory.map(|directory| {
        let place = (directory, about.arrays.unwrap_or(sheet.name));
        described.publish(place, arrays, &drawing, &progress, &*found.beside)
    });
    let kept = journal.map(|out| described.keep(out, &drawing, &*found.beside));
    let main = main.or(kept).transpose()?;
    progress.clear();
    described.tell(&subject, how, main.as_deref())?;
    if let Some(main) = &main {
        drawing.present(main)?;
    }
    found.failed.map_or(Ok(()), |why| Err(Failure::Partly(why)))
}

/// A result with its description.
pub struct Described<'a> {
    pub found: &'a (dyn Describe + Sync),
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
    /// directory that appears whole, with what `beside` adds; returns the file to open. A file of arrays may have been begun
    /// with large ones.
    pub fn publish(
        &self,
        (directory, file): (ResultDirectory, &'static str),
        begun: Option<Box<dyn ArrayFile>>,
        drawing: &Drawing,
        progress: &Progress,
        beside: &dyn Fn(&Path) -> Result<(), Error>,
    ) -> Result<PathBuf, Failure> {
        let sheet = self.sheet;
        directory.write("summary.json", self.json()?)?;
        let arrays = match begun {
            None if !sheet.variables.is_empty() => {
                Some(ArrayFormat::Npz.create(directory.path(), file, Precision::F64)?)
            }
            begun => begun,
        };
        if let Some(arrays) = arrays {
            sheet.write_to(&*arrays)?;
            sheet.describe_file(&sheet.summary_value(self.provenance), &*arrays);
            arrays.finish()?;
        }
        if !sheet.records.head.is_empty() {
            let csv = sheet.records.to_csv().map_err(std::io::Error::other)?;
            directory.write("table.csv", csv)?;
        }
        beside(directory.path())?;
        progress.check()?;
        if drawing.is_wanted() {
            progress.stage("drawing", 1);
            let folder = directory.path().join("figures");
            let figures = || {
                let figures = figures_of(self.found, sheet, self.name, file, &drawing.style);
                plot::save_all(&figures, &folder, &drawing.formats)
            };
            let page = || Ok::<_, Failure>(directory.write("report.html", self.page(drawing)?)?);
            let (drawn, page) =
                in_pool(drawing.threads, || rayon::join(figures, page)).map_err(|error| {
                    Error::Threads {
                        threads: drawing.threads.unwrap_or_default(),
                        reason: error.to_string(),
                    }
                })?;
            drawn?;
            page?;
            progress.check()?;
        }
        let published = directory.publish()?;
        progress.clear();
        Ok(published.join(drawing.main()))
    }

    /// The same in the directory of a journal, which keeps the runs that the result is made of, each file whole: rows
    /// are in `curves.csv`, the figure beside it.
    fn keep(
        &self,
        out: &Path,
        drawing: &Drawing,
        beside: &dyn Fn(&Path) -> Result<(), Error>,
    ) -> Result<PathBuf, Failure> {
        let sheet = self.sheet;
        beside(out)?;
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
        if how.json {
            for warning in self.sheet.warnings.iter().filter(|_| !how.quiet) {
                terminal::message(Tone::Warning, &warning.message);
                if !warning.advice.is_empty() {
                    terminal::message(Tone::Help, &warning.advice);
                }
            }
            writeln!(terminal::stdout(), "{}", self.json()?)?;
        } else if !how.quiet {
            let mut summary = Summary::of(subject, self.sheet);
            if let Some(main) = main {
                summary.last(&format!("open {}", main.display()));
            }
            summary.print(how.detail.verbose)?;
        }
        Ok(())
    }
}
