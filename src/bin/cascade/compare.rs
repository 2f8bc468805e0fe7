//! `cascade compare`: the budgets of two runs on one page, or a measured field against a run.

use serde_json::Value;
use wavecascade::arrays::Nowhere;
use wavecascade::budget::{Budget, ComparedBudgets};
use wavecascade::chain::scene::{SceneSource, Units};
use wavecascade::field::{file_hash, is_run_file};
use wavecascade::fit::CompareRequest;
use wavecascade::report::{Provenance, RunFile};

use crate::budget::compute;
use crate::further::input_options;
use crate::prelude::*;
use crate::scene::source_of;
use crate::view_args::ViewArgs;
use crate::words::as_text;

/// What `cascade compare` takes.
#[derive(Debug, Args)]
#[command(mut_arg("out", |arg| arg.default_value("comparison").help("Directory for the results")))]
pub struct Compare {
    /// Run file of `cascade simulate`, for example of a chain that carries a localized wave; or a measured field.
    pub first: PathBuf,
    /// Another run, for example of a dispersive chain; beside a field a run or its scene.
    pub second: PathBuf,
    /// Of a field, the body of each site, or of forces the contact [default: by the positions, else by the numbers of the
    /// sites].
    #[arg(long, value_delimiter = ',', value_name = "BODY,..")]
    pub bodies: Option<Vec<usize>>,
    /// Of a field, the relative difference of energies up to which they agree [default: 5%].
    #[arg(long, value_name = "SHARE", value_parser = parse::share)]
    pub within: Option<f64>,
    #[command(flatten)]
    pub result: ResultArgs,
    #[command(flatten)]
    pub views: ViewArgs,
    #[command(flatten)]
    pub input: Input,
}

impl Compare {
    /// Whether the first file is a run; others are fields.
    fn is_of_runs(&self) -> Result<bool, Error> {
        Ok(self.first.is_file() && is_run_file(&self.first)?)
    }

    /// A field against the chain of a text, else of a run, or of a scene.
    fn of_field(&self, given: &Given, observer: &dyn Observer) -> Result<Found, Error> {
        let file = &self.second;
        let scene = match given.scene.clone() {
            None if is_run_file(file)? => {
                SceneSource::new(Some(file), RunFile::read(file)?.setup.text)
            }
            text => source_of(text, Some(file))?,
        };
        let request = CompareRequest {
            bodies: self.bodies.clone(),
            within: self.within.unwrap_or(CompareRequest::default().within),
        };
        Ok(Found::of(request.run(given.field()?, &scene, observer)?))
    }

    /// The budgets of two runs; the second takes over what was chosen for the first.
    fn of_runs(&self, given: &Given, observer: &dyn Observer) -> Result<Found, Error> {
        let paths = [&self.first, &self.second];
        let files = [given.run(0, paths[0])?, given.run(1, paths[1])?];
        let [first, second] = files.each_ref().map(|file| file.setup.units);
        if first != second {
            let words = |units: Units| match units {
                Units::Si => "in SI",
                Units::None => "without units",
            };
            let expected = format!("a run {}, as {} is", words(first), paths[0].display());
            return Err(unfit(paths[1], expected, format!("one {}", words(second))));
        }
        let mut views = self.views.clone();
        let mut one = |n: usize| -> Result<(Budget, Value), Error> {
            let (file, path) = (&files[n], paths[n]);
            let found = compute(&views, file, &Nowhere, observer);
            let found = found.map_err(|error| error.of_file(path))?;
            views.take_over(&found);
            let hash = path.is_file().then(|| file_hash(path)).transpose()?;
            let input = Some(path.display().to_string());
            let provenance = Provenance::new(given.words.clone(), input, hash);
            let summary = found.describe(None).summary_value(&provenance);
            Ok((found, summary))
        };
        let ((a, first), (b, second)) = (one(0)?, one(1)?);
        let [a_name, b_name] = names(paths.map(|path| stem_of(path)));
        Ok(Found::of(ComparedBudgets {
            both: [(a_name, a), (b_name, b)],
            summaries: [first, second],
        }))
    }
}

impl Describing for Compare {
    fn about(&self) -> About<'_> {
        // A file that cannot be read is refused by the check.
        let is_of_runs = self.is_of_runs().unwrap_or(false);
        let fields = [&self.first].into_iter();
        let files = fields.chain(is_of_runs.then_some(&self.second));
        let reading = Reading::of(&self.input, None);
        About {
            reading: (!is_of_runs).then_some(reading),
            ..About::of("compare", &self.result.how, files, "npy")
        }
    }

    /// That no option of fields and no field is beside a run.
    fn check(&self) -> Result<(), Error> {
        let (path, expected, found) = if !self.is_of_runs()? {
            return Ok(());
        } else if self.input != Input::default() {
            let typed = input_options(&as_text());
            let typed = typed.trim_start();
            let expected = format!("a measured field beside `{typed}`, which says how one is read");
            let found = "a run, which has its own axes and units: leave it out";
            (&self.first, expected, found)
        } else if self.second.is_file() && !is_run_file(&self.second)? {
            let expected = "a run of `cascade simulate`, as the first file is; a measured field stands first, before the run";
            (&self.second, expected.into(), "a file that is no run")
        } else {
            return Ok(());
        };
        Err(unfit(path, expected, found))
    }

    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
        match !given.runs.is_empty() || self.is_of_runs()? {
            true => self.of_runs(&given, observer),
            false => self.of_field(&given, observer),
        }
    }
}

/// Two names that differ.
fn names([first, second]: [String; 2]) -> [String; 2] {
    match first == second {
        true => [format!("{first} (first)"), format!("{second} (second)")],
        false => [first, second],
    }
}
