//! `cascade compare`: the budgets of two runs on one page, or a measured field against a run.

use std::path::PathBuf;

use clap::Args;
use serde_json::Value;
use wavecascade::Error;
use wavecascade::budget::{Budget, ComparedBudgets};
use wavecascade::chain::scene::{SceneSource, Units};
use wavecascade::field::{FileState, file_hash, is_run_file};
use wavecascade::fit::CompareRequest;
use wavecascade::observer::Observer;
use wavecascade::plot::{Style, figures_of, save_all};
use wavecascade::report::{Provenance, ResultDirectory, RunFile, sheet_html};
use wavecascade::sheet::Describe;

use crate::args::Input;
use crate::budget::compute;
use crate::chain_args::How;
use crate::described::{
    self, Describing, Found, Given, Publishing, Reading, ResultArgs, end, stem_of, subject_of,
};
use crate::failure::Failure;
use crate::further::input_options;
use crate::parse;
use crate::scene::source_of;
use crate::view_args::ViewArgs;
use crate::words::as_text;

/// Directory for the results where none is named.
const OUT: &str = "comparison";

/// What `cascade compare` takes.
#[derive(Debug, Args)]
#[command(mut_arg("out", |arg| arg.default_value(OUT).help("Directory for the results")))]
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
        Ok(!self.first.is_file() || is_run_file(&self.first)?)
    }

    /// That no option of fields is among the words beside two runs.
    pub fn refuse_options_of_fields(&self, words: &[String]) -> Result<(), Error> {
        match input_options(words).trim_start() {
            "" => Ok(()),
            typed => Err(Error::Unfit {
                path: self.first.clone(),
                expected: format!("a measured field beside `{typed}`, which says how one is read"),
                found: "a run, which has its own axes and units: leave it out".into(),
            }),
        }
    }
}

impl Describing for Compare {
    fn name(&self) -> &'static str {
        "compare"
    }

    fn how(&self) -> &How {
        &self.result.how
    }

    fn reading(&self) -> Option<Reading<'_>> {
        Some(Reading {
            input: &self.input,
            memory: None,
        })
    }

    /// A field against the chain of a text, else of a run, or of a scene.
    fn find(&self, given: Given, observer: &dyn Observer) -> Result<Found, Error> {
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
}

impl Publishing for Compare {
    fn result(&self) -> &ResultArgs {
        &self.result
    }

    fn files(&self) -> Result<(Vec<PathBuf>, &'static str), Failure> {
        Ok((vec![self.first.clone()], "npy"))
    }

    fn arrays(&self) -> &'static str {
        "compare-field"
    }
}

/// The budgets of two runs.
pub struct Compared {
    names: [String; 2],
    budgets: [Budget; 2],
    summaries: [Value; 2],
    provenance: Provenance,
}

impl Compared {
    /// The second budget takes over what was chosen for the first.
    pub fn of(
        mut views: ViewArgs,
        files: [&RunFile; 2],
        paths: &[PathBuf; 2],
        words: &[String],
        observer: &dyn Observer,
    ) -> Result<Compared, Failure> {
        let [first, second] = files.map(|file| file.setup.units);
        if first != second {
            let words = |units: Units| match units {
                Units::Si => "in SI",
                Units::None => "without units",
            };
            return Err(Failure::Library(Error::Unfit {
                path: paths[1].clone(),
                expected: format!("a run {}, as {} is", words(first), paths[0].display()),
                found: format!("one {}", words(second)),
            }));
        }
        let mut one = |file: &RunFile, path: &PathBuf| -> Result<(Budget, Value), Failure> {
            let found = compute(&views, file, &wavecascade::arrays::Nowhere, observer)
                .map_err(|error| error.of_file(path))?;
            views.take_over(&found);
            let hash = path.is_file().then(|| file_hash(path)).transpose()?;
            let input = Some(path.display().to_string());
            let provenance = Provenance::new(words.to_vec(), input, hash);
            let summary = found.describe(None).summary_value(&provenance);
            Ok((found, summary))
        };
        let (a, first) = one(files[0], &paths[0])?;
        let (b, second) = one(files[1], &paths[1])?;
        Ok(Compared {
            names: names(paths.each_ref().map(|path| stem_of(path))),
            budgets: [a, b],
            summaries: [first, second],
            provenance: Provenance::new(words.to_vec(), None, None),
        })
    }

    pub fn found(&self) -> ComparedBudgets<'_> {
        let [a, b] = &self.names;
        ComparedBudgets {
            both: [(a, &self.budgets[0]), (b, &self.budgets[1])],
            summaries: self.summaries.clone(),
        }
    }

    /// `summary.json`.
    pub fn json(&self) -> serde_json::Result<String> {
        self.found().describe().summary(&self.provenance)
    }

    /// Of both, in titles.
    fn name(&self) -> String {
        self.names.join(" and ")
    }

    /// `report.html`.
    pub fn page(&self, style: &Style) -> serde_json::Result<String> {
        let found = self.found();
        sheet_html(
            &found,
            &found.describe(),
            &self.name(),
            &self.provenance,
            style,
        )
    }
}

/// Runs the command.
pub fn run(typed: Compare) -> Result<(), Failure> {
    if !typed.is_of_runs()? {
        return described::run(&typed);
    }
    let words = as_text();
    typed.refuse_options_of_fields(&words)?;
    let ResultArgs {
        figures,
        how,
        force,
        out,
    } = &typed.result;
    let drawing = figures.drawing(None)?;
    let progress = how.begin()?;
    let out = out.clone().unwrap_or_else(|| OUT.into());
    drop(ResultDirectory::create(&out, *force)?);
    let opened = [FileState::at(&typed.first)?, FileState::at(&typed.second)?];
    if !is_run_file(&typed.second)? {
        return Err(Failure::Library(Error::Unfit {
            path: typed.second,
            expected: "a run of `cascade simulate`, as the first file is; a measured field stands first, before the run".into(),
            found: "a file that is no run".into(),
        }));
    }
    let files = [RunFile::read(&typed.first)?, RunFile::read(&typed.second)?];
    progress.begin_writing();
    let directory = ResultDirectory::create(&out, *force)?;
    let paths = [typed.first, typed.second];
    let both = [&files[0], &files[1]];
    let compared = Compared::of(typed.views, both, &paths, &words, &progress)?;
    // All that reads or hashes the files has done so.
    opened.iter().try_for_each(FileState::check)?;
    let found = compared.found();
    let sheet = found.describe();
    let json = compared.json()?;
    directory.write("summary.json", &json)?;
    if drawing.is_wanted() {
        progress.stage("drawing", 1);
        directory.write("report.html", compared.page(&drawing.style)?)?;
        let name = compared.name();
        let figures = figures_of(&found, &sheet, &name, "compare", &drawing.style);
        let folder = directory.path().join("figures");
        save_all(&figures, &folder, &drawing.formats)?;
    }
    let subject = paths.map(|path| subject_of(&[path])).join(" and ");
    end(
        (&sheet, &subject),
        &json,
        directory,
        (&drawing, how),
        &progress,
    )
}

/// Two names that differ.
fn names([first, second]: [String; 2]) -> [String; 2] {
    match first == second {
        true => [format!("{first} (first)"), format!("{second} (second)")],
        false => [first, second],
    }
}
