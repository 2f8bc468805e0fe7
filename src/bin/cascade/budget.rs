//! `cascade budget`: a run file, its budgets, the files.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use wavecascade::Error;
use wavecascade::arrays::{Precision, Sink};
use wavecascade::budget::measured::MeasuredReport;
use wavecascade::budget::{Budget as Found, Motion};
use wavecascade::field::{FileState, file_hash, is_run_file};
use wavecascade::observer::Observer;
use wavecascade::plot::{figures_of, save_all};
use wavecascade::report::{
    Provenance, ResultDirectory, RunFile, budget_snippet, describe_budget, sheet_html,
    write_budget_arrays,
};

use crate::analyze::named_after;
use crate::args::FormatArg;
use crate::arrays_file::ArraysFile;
use crate::described::{ResultArgs, end, stem_of, subject_of};
use crate::failure::Failure;
use crate::figure_args::ColorArgs;
use crate::measured::{self, MeasuredArgs, MeasuredInput};
use crate::view_args::ViewArgs;
use crate::words::as_text;

/// What `cascade budget` takes.
#[derive(Debug, Args)]
#[command(mut_group("Input", |group| group.requires("scene")))]
pub struct Budget {
    /// Run file of `cascade simulate`; with `--scene`, a measured field of velocities.
    pub run: PathBuf,
    /// File of the arrays: budget.npz for NumPy, or budget.nc for `xarray.open_dataset`, with named
    /// dimensions, coordinates and units.
    #[arg(long, value_enum, default_value_t = FormatArg::Npz)]
    pub format: FormatArg,
    #[command(flatten)]
    pub result: ResultArgs,
    #[command(flatten)]
    pub views: ViewArgs,
    #[command(flatten)]
    pub measured: MeasuredArgs,
    #[command(flatten)]
    pub colors: ColorArgs,
}

/// Runs the command.
pub fn run(typed: Budget) -> Result<(), Failure> {
    let ResultArgs {
        out,
        force,
        figures,
        how,
    } = &typed.result;
    let drawing = figures.drawing(Some(&typed.colors))?;
    let out = out.clone();
    let out = out.unwrap_or_else(|| named_after(&typed.run, "npz", "-budget"));
    let progress = how.begin()?;
    let started = Instant::now();
    // Before any work: could the result be written?
    drop(ResultDirectory::create(&out, *force)?);
    let opened = FileState::at(&typed.run)?;
    let source = match &typed.measured.scene {
        None => {
            if typed.run.is_file() && !is_run_file(&typed.run)? {
                let expected = format!(
                    "the chain that this field is a record of, `cascade budget {} --scene SCENE.toml`",
                    typed.run.display()
                );
                let found = "no scene, and a file that is no run of `cascade simulate`";
                return Err(Error::request("scene", expected, found).into());
            }
            MotionSource::Run(Box::new(RunFile::read(&typed.run)?))
        }
        Some(scene) => {
            let read = measured::read(&typed.run, scene, &typed.measured, &typed.views, how.quiet);
            MotionSource::Measured(Box::new(read.map_err(|error| error.of_file(&typed.run))?))
        }
    };
    let name = stem_of(&typed.run);

    progress.begin_writing();
    let directory = ResultDirectory::create(&out, *force)?;
    let format = typed.format.into();
    let arrays = ArraysFile::create(&directory, "budget", format, Precision::F64)?;
    let budget = match &source {
        MotionSource::Run(file) => compute(&typed.views, file, arrays.arrays(), &progress),
        MotionSource::Measured(measured) => measured.budget(arrays.arrays(), &progress),
    };
    let budget = budget.map_err(|error| error.of_file(&typed.run))?;
    progress.check()?;
    let input = typed.run.display().to_string();
    let provenance = Provenance::new(as_text(), Some(input), Some(file_hash(&typed.run)?));
    // All that reads or hashes the file has done so.
    opened.check()?;
    let mut sheet = budget.describe(source.report());
    write_budget_arrays(&budget, arrays.arrays())?;
    arrays.finish(|file| describe_budget(&budget, &sheet.summary_value(&provenance), file))?;
    let json = sheet.summary(&provenance)?;
    directory.write("summary.json", &json)?;
    directory.write("plot.py", budget_snippet(&budget, &name, format))?;
    if drawing.is_wanted() {
        progress.stage("drawing", 1);
        let style = &drawing.style;
        let figures = figures_of(&budget, &sheet, &name, "budget", style);
        let folder = directory.path().join("figures");
        save_all(&figures, &folder, &drawing.formats)?;
        let page = sheet_html(&budget, &sheet, &name, &provenance, style);
        directory.write("report.html", page?)?;
    }
    let seconds = format!("{:.2} s", started.elapsed().as_secs_f64());
    sheet.detail("computation", seconds);
    let subject = subject_of(std::slice::from_ref(&typed.run));
    end(
        (&sheet, &subject),
        &json,
        directory,
        (&drawing, how),
        &progress,
    )
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
