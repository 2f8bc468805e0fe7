//! What all commands on estimates share: one or several fields, one library call, a directory of results.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use wavecascade::arrays::Precision;
use wavecascade::estimates::Independence;
use wavecascade::field::{FileState, OpenOptions};
use wavecascade::observer::Observer;
use wavecascade::plot::{self, Figure, Style};
use wavecascade::report::{Archive, LabelledArrays, Provenance, ResultDirectory};
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
    type Found: Estimate;

    fn fields(&self) -> &[PathBuf];

    fn shared(&self) -> &EstimateArgs;

    /// Working memory.
    fn memory(&self) -> Option<u64>;

    /// What makes the estimate of the opened fields.
    ///
    /// # Errors
    /// For what is missing, or contradicts itself, whatever the fields are.
    fn computation(&self) -> Result<impl Computation<Self::Found>, Error>;
}

/// Makes an estimate of opened fields.
pub trait Computation<E>: FnOnce(&[&Field], &dyn Observer) -> Result<E, Error> {}

impl<E, F: FnOnce(&[&Field], &dyn Observer) -> Result<E, Error>> Computation<E> for F {}

/// What an estimate found, as files and in words.
pub trait Estimate {
    /// Name of the command: that of the file of arrays, and the end of the default directory.
    const COMMAND: &'static str;
    /// Extension of usual files of fields, which the default directory leaves out.
    const EXTENSION: &'static str = "npy";

    /// `summary.json`.
    fn summary(&self, provenance: &Provenance) -> serde_json::Result<String>;

    /// Hands over the arrays, with their axes and units.
    fn arrays(&self, to: &dyn LabelledArrays) -> Result<(), Error>;

    /// Writes what stands beside the arrays to new files of `directory`.
    fn write_beside(&self, _directory: &Path) -> Result<(), Error> {
        Ok(())
    }

    /// Figures of the field `name`.
    fn figures(&self, name: &str, style: &Style) -> Vec<Figure>;

    /// `report.html`.
    fn page(
        &self,
        name: &str,
        provenance: &Provenance,
        warnings: &[[String; 2]],
        style: &Style,
    ) -> serde_json::Result<String>;

    /// What the user should know, each with what to do.
    fn warnings(&self) -> Vec<[String; 2]>;

    /// What was found, in one sentence without its subject, the field.
    fn answer(&self) -> String;

    /// Facts and details beside the answer.
    fn tell(&self, summary: &mut Summary);
}

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
    let ending = format!("-{}", T::Found::COMMAND);
    let default = |first: &Path| named_after(first, T::Found::EXTENSION, &ending);
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
    publish(&found, typed, &target, &drawing, &progress)
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
pub fn publish<E: Estimate>(
    found: &E,
    typed: &EstimateArgs,
    target: &Target<'_>,
    drawing: &Drawing,
    progress: &Progress,
) -> Result<(), Failure> {
    let Target {
        name, provenance, ..
    } = *target;
    let directory = ResultDirectory::create(target.out, typed.force)?;
    let json = found.summary(provenance).map_err(std::io::Error::from)?;
    directory.write("summary.json", &json)?;
    let arrays = format!("{}.npz", E::COMMAND);
    let archive = Archive::create(&directory.path().join(arrays), Precision::F64)?;
    found.arrays(&archive)?;
    archive.finish()?;
    found.write_beside(directory.path())?;
    let warnings = found.warnings();
    if drawing.is_wanted() {
        progress.stage("drawing", 1);
        let figures = found.figures(name, &drawing.style);
        let folder = directory.path().join("figures");
        plot::save_all(&figures, &folder, &drawing.formats)?;
        let page = found.page(name, provenance, &warnings, &drawing.style);
        directory.write("report.html", page.map_err(std::io::Error::from)?)?;
    }
    progress.check()?;
    let published = directory.publish()?;
    progress.clear();
    if typed.how.json {
        if !typed.how.quiet {
            for [message, advice] in &warnings {
                terminal::message(Tone::Warning, message);
                terminal::message(Tone::Help, advice);
            }
        }
        writeln!(terminal::stdout(), "{json}")?;
    } else if !typed.how.quiet {
        let mut summary = Summary::new(target.subject, &found.answer());
        found.tell(&mut summary);
        for [message, advice] in &warnings {
            summary.warning(message, advice);
        }
        let main = match drawing.is_wanted() {
            true => "report.html",
            false => "summary.json",
        };
        summary.last(&format!("open {}", published.join(main).display()));
        summary.print(typed.how.detail.verbose)?;
    }
    Ok(())
}

/// What to say of a record, or what stands for it, that is one realisation by itself.
pub fn one_realisation(of: &Independence, what: &str) -> Option<[String; 2]> {
    (of.is_transient() && of.records < 2).then(|| alone(of, what))
}

/// Why a record by itself has no errors.
pub fn alone(of: &Independence, what: &str) -> [String; 2] {
    match of.steadiness.is_nan() {
        true => [
            format!(
                "{} of the {what}: no level of chance and no interval is stated",
                of.why()
            ),
            "leave out the segments that miss samples: `--gaps leave-out`".into(),
        ],
        false => [
            format!(
                "the {what} is a transient (steadiness {}): its segments are not independent",
                terminal::number(of.steadiness)
            ),
            "name several records of the same sites, one a shot".into(),
        ],
    }
}
