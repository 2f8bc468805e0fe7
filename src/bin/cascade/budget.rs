//! `cascade budget`: a run file, its budgets, the files.

use std::path::PathBuf;

use clap::Args;
use wavecascade::Error;
use wavecascade::arrays::Sink;
use wavecascade::budget::{Budget as Found, Motion};
use wavecascade::field::is_run_file;
use wavecascade::observer::Observer;
use wavecascade::report::{DescribedBudget, RunFile, budget_snippet};

use crate::args::FormatArg;
use crate::described::{self, About, Describing, Given, Reading, ResultArgs, stem_of};
use crate::figure_args::ColorArgs;
use crate::measured::{self, MeasuredArgs};
use crate::scene::source_of;
use crate::view_args::ViewArgs;

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

impl Describing for Budget {
    fn about(&self) -> About<'_> {
        let reading = Reading {
            input: &self.measured.input,
            memory: None,
        };
        About {
            reading: self.measured.scene.as_ref().map(|_| reading),
            colors: Some(&self.colors),
            format: Some(self.format.into()),
            ..About::of("budget", &self.result.how, [&self.run], "npz")
        }
    }

    /// That a field has its chain beside it.
    fn check(&self) -> Result<(), Error> {
        if self.measured.scene.is_some() || !self.run.is_file() || is_run_file(&self.run)? {
            return Ok(());
        }
        let expected = format!(
            "the chain that this field is a record of, `cascade budget {} --scene SCENE.toml`",
            self.run.display()
        );
        let found = "no scene, and a file that is no run of `cascade simulate`";
        Err(Error::request("scene", expected, found))
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<described::Found, Error> {
        let (budget, report) = match given.fields {
            [field, ..] => {
                let scene = self.measured.scene.as_deref();
                let setup = source_of(given.scene.clone(), scene)?.setup()?;
                let field = (*field).clone();
                let read =
                    measured::of_field(field, &self.run, &setup, &self.measured, &self.views)?;
                (read.budget(&given, observer)?, Some(read.motion.report))
            }
            [] => {
                let file = given.run(0, &self.run)?;
                (compute(&self.views, &file, given.sink(), observer)?, None)
            }
        };
        let script = budget_snippet(&budget, &stem_of(&self.run), self.format.into());
        let found = DescribedBudget { budget, report };
        Ok(described::Found::of(found).with_text("plot.py", script))
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
