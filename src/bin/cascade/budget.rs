//! `cascade budget`: a run file, its budgets, the files.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use wavecascade::Error;
use wavecascade::arrays::{Precision, Sink};
use wavecascade::budget::measured::MeasuredReport;
use wavecascade::budget::{Budget as Found, Motion};
use wavecascade::field::{FileState, file_hash, is_run_file};
use wavecascade::observer::Observer;
use wavecascade::plot::{figures_of, save_all};
use wavecascade::report::{Provenance, ResultDirectory, RunFile, budget_snippet, sheet_html};

use crate::analyze::{named_after, use_threads};
use crate::args::FormatArg;
use crate::arrays_file::ArraysFile;
use crate::chain_args::How;
use crate::described::tell;
use crate::estimates::subject_of;
use crate::failure::Failure;
use crate::figure_args::{ColorArgs, FigureArgs};
use crate::measured::{self, MeasuredArgs, MeasuredInput};
use crate::progress::Progress;
use crate::view_args::ViewArgs;

/// What `cascade budget` takes.
#[derive(Debug, Args)]
#[command(mut_group("Input", |group| group.requires("scene")))]
pub struct Budget {
    /// Run file of `cascade simulate`; with `--scene`, a measured field of velocities.
    pub run: PathBuf,
    /// Directory for the results; by default the run's name with `-budget`, here (run-budget
    /// for run.npz, field.npy-budget for field.npy).
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,
    /// File of the arrays: budget.npz for NumPy, or budget.nc for `xarray.open_dataset`, with named
    /// dimensions, coordinates and units.
    #[arg(long, value_enum, default_value_t = FormatArg::Npz)]
    pub format: FormatArg,
    #[command(flatten)]
    pub how: How,
    #[command(flatten)]
    pub views: ViewArgs,
    #[command(flatten)]
    pub measured: MeasuredArgs,
    #[command(flatten)]
    pub figures: FigureArgs,
    #[command(flatten)]
    pub colors: ColorArgs,
}

/// Runs the command.
pub fn run(typed: Budget) -> Result<(), Failure> {
    let drawing = typed.figures.drawing_of_maps(&typed.colors)?;
    let out = typed.out.clone().unwrap_or_else(|| default_out(&typed.run));
    let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
    let started = Instant::now();
    use_threads(typed.how.threads.map(usize::from))?;
    // Before any work: could the result be written?
    drop(ResultDirectory::create(&out, typed.force)?);
    let opened = FileState::at(&typed.run)?;
    let source = match &typed.measured.scene {
        None => {
            if typed.run.is_file() && !is_run_file(&typed.run)? {
                return Err(Failure::Library(Error::Request {
                    option: "scene",
                    expected: format!(
                        "the chain that this field is a record of, `cascade budget {} --scene SCENE.toml`",
                        typed.run.display()
                    ),
                    found: "no scene, and a file that is no run of `cascade simulate`".into(),
                }));
            }
            MotionSource::Run(Box::new(RunFile::read(&typed.run)?))
        }
        Some(scene) => {
            let read = measured::read(
                &typed.run,
                scene,
                &typed.measured,
                &typed.views,
                typed.how.quiet,
            );
            MotionSource::Measured(Box::new(read.map_err(|error| error.of_file(&typed.run))?))
        }
    };
    let name = name_of(&typed.run);

    progress.begin_writing();
    let directory = ResultDirectory::create(&out, typed.force)?;
    let format = typed.format.into();
    let arrays = ArraysFile::create(&directory, "budget", format, Precision::F64)?;
    let budget = match &source {
        MotionSource::Run(file) => compute(&typed.views, file, arrays.arrays(), &progress),
        MotionSource::Measured(measured) => measured.budget(arrays.arrays(), &progress),
    };
    let budget = budget.map_err(|error| error.of_file(&typed.run))?;
    progress.check()?;
    let input = typed.run.display().to_string();
    let provenance = Provenance::new(command(), Some(input), Some(file_hash(&typed.run)?));
    // All that reads or hashes the file has done so.
    opened.check()?;
    let mut sheet = budget.describe(source.report());
    arrays.finish_budget(&budget, &sheet.summary_value(&provenance))?;
    let json = sheet.summary(&provenance).map_err(std::io::Error::from)?;
    directory.write("summary.json", &json)?;
    directory.write("plot.py", budget_snippet(&budget, &name, format))?;
    if drawing.is_wanted() {
        progress.stage("drawing", 1);
        let style = &drawing.style;
        let figures = figures_of(&budget, &sheet, &name, "budget", style);
        let folder = directory.path().join("figures");
        save_all(&figures, &folder, &drawing.formats)?;
        let page = sheet_html(&budget, &sheet, &name, &provenance, style);
        directory.write("report.html", page.map_err(std::io::Error::from)?)?;
    }
    progress.check()?;
    let published = directory.publish()?;
    progress.clear();
    let subject = subject_of(std::slice::from_ref(&typed.run));
    let main = published.join(drawing.main());
    sheet.detail(
        "computation",
        format!("{:.2} s", started.elapsed().as_secs_f64()),
    );
    tell(&sheet, &json, &subject, &typed.how, Some(&main))?;
    drawing.present(&main)
}

/// Where the motion comes from.
enum MotionSource {
    Run(Box<RunFile>),
    Measured(Box<MeasuredInput>),
}

impl MotionSource {
    fn report(&self) -> Option<&MeasuredReport> {
        match self {
            MotionSource::Run(_) => None,
            MotionSource::Measured(measured) => Some(&measured.motion.report),
        }
    }
}

/// The budgets of a run file.
pub fn compute(
    views: &ViewArgs,
    file: &RunFile,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<Found, Error> {
    let motion = Motion::of(&file.run)?;
    wavecascade::budget::run(&motion, &views.request(&file.setup)?, sink, observer)
}

/// The words typed.
pub fn command() -> Vec<String> {
    crate::words::as_text()
}

pub fn name_of(run: &Path) -> String {
    let stem = run.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// `run-budget` of `run.npz`, which runs are; of other files with their extension.
fn default_out(run: &Path) -> PathBuf {
    named_after(run, "npz", "-budget")
}
