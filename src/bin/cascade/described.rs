//! What is done with a described result, whatever it is: its files, and what is printed.

use std::sync::Arc;
use std::time::Instant;

use wavecascade::arrays::{Nowhere, Precision, Sink};
use wavecascade::chain::scene::Setup;
use wavecascade::field::{FileState, OpenOptions, ScanRecord, file_hash, is_run_file};
use wavecascade::plot::{self, figures_of};
use wavecascade::report::{
    ArrayFile, ArrayFormat, Headlines, Provenance, ResultDirectory, RunFile, sheet_html,
    write_beside,
};
use wavecascade::sheet::{Sheet, Warning};
use wavecascade_system::threads::in_pool;

use crate::analyze::{named_after, open_options, print_notes};
use crate::fields::expanded;
use crate::figure_args::{ColorArgs, Drawing, FigureArgs};
use crate::prelude::*;
use crate::scan_args::{ScanArgs, folder_name};
use crate::words::as_text;

/// Where the result of a command goes, and how it is made.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Output")]
pub struct ResultArgs {
    /// Directory for the results; by default the file's name with the command's, here.
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,

    #[command(flatten)]
    pub how: How,
    #[command(flatten)]
    pub figures: FigureArgs,
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
    /// What it is called in titles and sentences, and what it was made of, where those are not its files.
    pub name: Option<String>,
    pub input: Option<String>,
    /// How the field was read where nothing states it.
    pub read_as: Vec<String>,
    /// What an index of several analyses lists.
    pub headlines: Option<Headlines>,
    /// What follows the name of the file to open.
    pub next: String,
}

impl Found {
    pub fn of(result: impl Describe + Send + Sync + 'static) -> Found {
        Found {
            result: Box::new(result),
            beside: Box::new(|_| Ok(())),
            failed: None,
            name: None,
            input: None,
            read_as: Vec::new(),
            headlines: None,
            next: String::new(),
        }
    }

    /// With a text as the file of this name beside it.
    pub fn with_text(self, name: &'static str, text: String) -> Found {
        let others = self.beside;
        let write = move |directory: &Path| {
            others(directory)?;
            write_beside(directory, name, text.as_bytes()).map(|_| ())
        };
        Found {
            beside: Box::new(write),
            ..self
        }
    }
}

/// The chain of a run, and the step of its times.
pub type Chain = (Setup, f64);

/// What a result is made of: the fields, and what a caller holds in memory in place of files.
#[derive(Default)]
pub struct Given<'a> {
    pub fields: &'a [&'a Field],
    /// Of a scan, what was taken of its files.
    pub records: Option<&'a [ScanRecord]>,
    /// Files of the fields; none of those in memory.
    pub files: &'a [PathBuf],
    /// Text of a scene.
    pub scene: Option<String>,
    /// The chain of a run in memory that the field is a part of.
    pub chain: Option<&'a Chain>,
    /// Of each run the one in memory, if it is there.
    pub runs: Vec<Option<Arc<RunFile>>>,
    /// Where large arrays go.
    pub arrays: Option<&'a dyn ArrayFile>,
    /// Whether figures are drawn of it.
    pub is_drawn: bool,
    /// Whether it was asked for on a command line, where other commands can follow.
    pub is_typed: bool,
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

/// [`Error::Unfit`] of a file.
pub fn unfit(path: &Path, expected: impl Into<String>, found: impl Into<String>) -> Error {
    Error::Unfit {
        path: path.to_owned(),
        expected: expected.into(),
        found: found.into(),
    }
}

/// A field, whose law is not known.
pub fn not_a_run(name: &Path) -> Error {
    let expected = "a run file of `cascade simulate`, whose law is known";
    unfit(name, expected, "a file that is no run")
}

/// How fields are read.
#[derive(Clone, Copy)]
pub struct Reading<'a> {
    pub input: &'a Input,
    pub memory: Option<u64>,
    /// Of several files with a record each.
    pub scan: Option<&'a ScanArgs>,
    /// Whether the result itself says how its field was read, and its summary all warnings.
    pub is_told: bool,
}

impl<'a> Reading<'a> {
    pub fn of(input: &'a Input, memory: Option<u64>) -> Self {
        Reading {
            input,
            memory,
            scan: None,
            is_told: false,
        }
    }

    pub fn is_scan(&self) -> bool {
        self.scan.is_some_and(|scan| scan.position_from.is_some())
    }
}

/// What is known of a command before its result is made.
#[derive(Default)]
pub struct About<'a> {
    pub name: &'static str,
    pub threads: Option<usize>,
    /// Its files, or patterns of them.
    pub files: Vec<PathBuf>,
    /// Their usual extension, which the default directory leaves out.
    pub usual: &'static str,
    /// What the name of the default directory ends with, where that is not its name.
    pub ending: Option<&'static str>,
    /// What the result is of, where it is of no file.
    pub subject: String,
    /// Its default directory then; none where a result is written only if one is named.
    pub out: Option<PathBuf>,
    /// How its files are read as fields, where they are fields.
    pub reading: Option<Reading<'a>>,
    pub colors: Option<&'a ColorArgs>,
    /// Format, name and numbers of the file of arrays, where large ones come in blocks.
    pub blocks: Option<(ArrayFormat, &'static str, Precision)>,
    /// Whether its directory keeps the runs that the result is made of, so that it is named and may be there.
    pub is_journal: bool,
    /// Name of the file of arrays and of the figure, where it is not that of the result.
    pub arrays: Option<&'static str>,
    /// When it began, where that is said.
    pub started: Option<Instant>,
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
            ..About::default()
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

/// Whether reading a file once is slow enough to show progress.
fn is_long(field: &Path) -> bool {
    const A_WHILE: u64 = 256 << 20;
    std::fs::metadata(field).is_ok_and(|file| file.len() > A_WHILE)
}

/// The fields of these files, hashed if so; of a scan the one of all, with what was taken of each file.
pub fn open(
    paths: &[PathBuf],
    reading: Reading,
    hash: bool,
    quiet: bool,
    progress: &Progress,
) -> Result<(Vec<Field>, Option<Vec<ScanRecord>>), Error> {
    let options = OpenOptions {
        hash,
        ..open_options(reading.input, reading.memory)
    };
    if hash && (reading.is_scan() || paths.iter().any(|path| is_long(path))) {
        progress.wait("reading the field");
    }
    if let Some(scan) = reading.scan {
        let (field, records) = scan.open(paths, &options)?;
        return Ok((vec![field], records));
    }
    let one = |path: &PathBuf| {
        let field = Field::open(path, &options)?;
        print_notes(&field, quiet);
        Ok(field)
    };
    let fields: Result<_, Error> = paths.iter().map(one).collect();
    Ok((fields?, None))
}

/// Makes the result, publishes it where a directory is named or follows from its files, and prints it.
pub fn run(command: &dyn Describing, result: &ResultArgs) -> Result<(), Failure> {
    let files = expanded(&command.about().files)?;
    let progress = Progress::new(!result.how.quiet);
    let done = done(command, result, &files, &progress)?;
    done.tell(&result.how)?;
    if let Some(main) = &done.main {
        result.figures.present.run(main)?;
    }
    done.failed.map_or(Ok(()), |why| Err(Failure::Partly(why)))
}

/// A result that is where it belongs, and what is to be said of it.
pub struct Done {
    pub json: String,
    /// The file to open first, in the directory of the results.
    pub main: Option<PathBuf>,
    pub headlines: Option<Headlines>,
    summary: Summary,
    warnings: Vec<Warning>,
    failed: Option<String>,
}

/// Stated memory below which figures, which take some 20 MB each, are drawn one by one.
const ROOM_FOR_FIGURES: u64 = 128 << 20;

/// Runs on so many threads, else on those of the process. The results do not depend on it.
pub fn on_threads<T: Send, E: From<Error> + Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> Result<T, E> {
    let threads_wanted = threads.unwrap_or_default();
    in_pool(threads, work).map_err(|error| {
        Error::failed(format!(
            "cannot start {threads_wanted} worker threads: {error}"
        ))
    })?
}

/// Makes the result of these files on the threads that are typed, and publishes it.
pub fn done(
    command: &dyn Describing,
    result: &ResultArgs,
    files: &[PathBuf],
    progress: &Progress,
) -> Result<Done, Failure> {
    command.check()?;
    let threads = command.about().threads;
    on_threads(threads, || made(command, result, files, progress))
}

fn made(
    command: &dyn Describing,
    result: &ResultArgs,
    files: &[PathBuf],
    progress: &Progress,
) -> Result<Done, Failure> {
    let (about, quiet) = (command.about(), result.how.quiet);
    let is_scan = about.reading.is_some_and(|reading| reading.is_scan());
    let is_told = about.reading.is_some_and(|reading| reading.is_told);
    let mut drawing = result.figures.drawing(about.colors)?;
    let memory = about.reading.and_then(|reading| reading.memory);
    drawing.threads = memory
        .filter(|&stated| stated < ROOM_FOR_FIGURES)
        .map(|_| 1);
    let default = || {
        let Some(first) = files.first() else {
            return about.out.clone();
        };
        let ending = format!("-{}", about.ending.unwrap_or(about.name));
        let scanned = is_scan.then(|| folder_name(first));
        Some(named_after(
            scanned.as_ref().unwrap_or(first),
            about.usual,
            &ending,
        ))
    };
    let journal = result.out.clone().filter(|_| about.is_journal);
    let out = match about.is_journal {
        true => None,
        false => result.out.clone().or_else(default),
    };
    let create = |out: &PathBuf| ResultDirectory::create(out, result.force);
    let begun = || out.as_ref().map(create).transpose();
    // Before any work: could the result be written?
    drop(begun()?);
    let (fields, records) = match about.reading {
        Some(reading) => open(files, reading, true, quiet || is_told, progress)?,
        None => Default::default(),
    };
    let states = files.iter().map(|path| FileState::at(path));
    let opened: Vec<FileState> = match about.reading {
        Some(_) => fields.iter().filter_map(Field::file_state).collect(),
        None => states.collect::<Result<_, _>>()?,
    };
    progress.begin_writing();
    let directory = begun()?;
    let arrays = match (&directory, about.blocks) {
        (Some(directory), Some((format, name, precision))) => {
            Some(format.create(directory.path(), name, precision)?)
        }
        _ => None,
    };
    let given = Given {
        fields: &fields.iter().collect::<Vec<_>>(),
        records: records.as_deref(),
        files,
        arrays: arrays.as_deref(),
        is_drawn: drawing.is_wanted(),
        is_typed: true,
        words: as_text(),
        ..Given::default()
    };
    let found = command.find(given, progress);
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
    let [name, subject] = match (found.name.clone(), files) {
        (Some(name), _) => [name.clone(), name],
        (None, []) => [about.subject.clone(), about.subject],
        (None, files) => {
            let stems: Vec<String> = files.iter().map(|path| stem_of(path)).collect();
            [joined(&stems), subject_of(files)]
        }
    };
    let input = match files {
        [first, .., last] if is_scan => {
            let (first, last) = (first.display(), last.display());
            Some(format!("{} files, {first} to {last}", files.len()))
        }
        files => files.first().map(|path| path.display().to_string()),
    };
    let provenance = Provenance {
        read_as: found.read_as.clone(),
        ..Provenance::new(as_text(), found.input.clone().or(input), hash)
    };
    let sheet = found.result.describe();
    let described = Described {
        found: &found,
        sheet: &sheet,
        name: &name,
        file: about.arrays.unwrap_or(sheet.name),
        provenance: &provenance,
        json: sheet.summary(&provenance)?,
    };
    let folder = match &directory {
        Some(directory) => Some(directory.path()),
        None => journal.as_deref(),
    };
    if let Some(folder) = folder {
        described.write(folder, about.is_journal, arrays, &drawing, progress)?;
    }
    let folder = match directory {
        Some(directory) => Some(directory.publish()?),
        None => journal,
    };
    progress.clear();
    let main = folder.map(|folder| folder.join(drawing.main()));
    let mut summary = Summary::of(&subject, &sheet);
    if let Some(main) = &main {
        let seconds = about.started.map(|started| started.elapsed().as_secs_f64());
        let took = seconds.map_or(String::new(), |seconds| format!("done in {seconds:.2} s; "));
        summary.last(&format!("{took}open {}{}", main.display(), found.next));
    }
    let warnings = sheet.warnings.iter().filter(|_| !is_told);
    Ok(Done {
        json: described.json,
        main,
        summary,
        warnings: warnings.cloned().collect(),
        headlines: found.headlines.clone(),
        failed: found.failed.clone(),
    })
}

impl Done {
    /// Prints the JSON, or what was found and the file to open.
    fn tell(&self, how: &How) -> Result<(), Failure> {
        if how.json {
            if !how.quiet {
                terminal::warn(&self.warnings);
            }
            writeln!(terminal::stdout(), "{}", self.json)?;
        } else if !how.quiet {
            self.summary.print(how.verbose)?;
        }
        Ok(())
    }
}

/// A result with its description.
struct Described<'a> {
    found: &'a Found,
    sheet: &'a Sheet<'a>,
    /// Of the data, in titles.
    name: &'a str,
    /// Of the arrays and the figure.
    file: &'static str,
    provenance: &'a Provenance,
    json: String,
}

impl Described<'_> {
    /// Writes `summary.json`, arrays, the table, figures, the page, where there are such, and what goes beside them. A file
    /// of arrays may have been begun with large ones. The directory of a journal keeps the runs that the result is made of:
    /// rows are in `curves.csv` there, and figures beside it.
    fn write(
        &self,
        folder: &Path,
        is_journal: bool,
        begun: Option<Box<dyn ArrayFile>>,
        drawing: &Drawing,
        progress: &Progress,
    ) -> Result<(), Failure> {
        let (sheet, found) = (self.sheet, &self.found.result);
        write_beside(folder, "summary.json", self.json.as_bytes())?;
        let arrays = match begun {
            None if !is_journal && !sheet.variables.is_empty() => {
                Some(ArrayFormat::Npz.create(folder, self.file, Precision::F64)?)
            }
            begun => begun,
        };
        if let Some(arrays) = arrays {
            sheet.write_to(&*arrays)?;
            sheet.describe_file(&sheet.summary_value(self.provenance), &*arrays);
            arrays.finish()?;
        }
        let (rows, figures_in) = match is_journal {
            true => ("curves.csv", folder.to_owned()),
            false => ("table.csv", folder.join("figures")),
        };
        if is_journal || !sheet.records.head.is_empty() {
            let csv = sheet.records.to_csv().map_err(std::io::Error::other)?;
            write_beside(folder, rows, csv.as_bytes())?;
        }
        (self.found.beside)(folder)?;
        progress.check()?;
        if drawing.is_wanted() {
            progress.stage("drawing", 1);
            let figures = || {
                let figures = figures_of(found, sheet, self.name, self.file, &drawing.style);
                plot::save_all(&figures, &figures_in, &drawing.formats)
            };
            let page = || -> Result<_, Failure> {
                let html = sheet_html(found, sheet, self.name, self.provenance, &drawing.style)?;
                Ok(write_beside(folder, "report.html", html.as_bytes())?)
            };
            let both = || Ok::<_, Failure>(rayon::join(figures, page));
            let (figures, page) = on_threads(drawing.threads, both)?;
            figures?;
            page?;
            progress.check()?;
        }
        Ok(())
    }
}
