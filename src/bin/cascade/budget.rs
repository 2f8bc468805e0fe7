//! `cascade budget`: a run file, its budgets, the files.

use wavecascade::arrays::{Precision, Sink};
use wavecascade::budget::{Budget as Budgets, Motion};
use wavecascade::field::is_run_file;
use wavecascade::report::{DescribedBudget, RunFile, budget_snippet, write_measured_arrays};

use crate::args::FormatArg;
use crate::figure_args::ColorArgs;
use crate::measured::{self, MeasuredArgs};
use crate::prelude::*;
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
        let reading = Reading::of(&self.measured.input, None);
        About {
            reading: self.measured.scene.as_ref().map(|_| reading),
            colors: Some(&self.colors),
            blocks: Some((self.format.into(), "budget", Precision::F64)),
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

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        let (budget, report) = match given.fields {
            [field, ..] => {
                let scene = self.measured.scene.as_deref();
                let setup = source_of(given.scene.clone(), scene)?.setup()?;
                let field = (*field).clone();
                let (run, typed) = (&self.run, &self.measured);
                let (motion, request) = measured::of_field(field, run, &setup, typed, &self.views)?;
                let (budget, errors) = motion.run(&request, given.sink(), observer)?;
                if let Some(file) = given.arrays {
                    write_measured_arrays(&motion, &errors, &budget.units, file)?;
                }
                (budget, Some(motion.report))
            }
            [] => {
                let file = given.run(0, &self.run)?;
                (compute(&self.views, &file, given.sink(), observer)?, None)
            }
        };
        let script = budget_snippet(&budget, &stem_of(&self.run), self.format.into());
        let found = DescribedBudget { budget, report };
        Ok(Found::of(found).with_text("plot.py", script))
    }
}

/// The budgets of a run file.
pub fn compute(
    views: &ViewArgs,
    file: &RunFile,
    sink: &dyn Sink,
    observer: &dyn Observer,
) -> Result<Budgets, Error> {
    let motion = Motion::of(&file.run)?;
    wavecascade::budget::run(&motion, &views.request(&file.setup)?, sink, observer)
}
