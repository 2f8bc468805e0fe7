//! `cascade compare`: the budgets of two runs on one page, or a measured field against a run.

use std::io::IsTerminal;
use std::path::PathBuf;

use clap::Args;
use serde_json::Value;
use wavecascade::budget::Budget;
use wavecascade::chain::scene::{SceneSource, Units};
use wavecascade::field::{FileState, file_hash, is_run_file};
use wavecascade::fit::{CompareRequest, Comparison};
use wavecascade::observer::Observer;
use wavecascade::plot::{Style, save_all, views};
use wavecascade::report::{Provenance, ResultDirectory, RunFile, budget_html};
use wavecascade::sheet::Sheet;
use wavecascade::{Error, Field};

use crate::analyze::use_threads;
use crate::args::Input;
use crate::budget::{command, compute, name_of};
use crate::chain_args::How;
use crate::described::{Found, ResultArgs, tell};
use crate::estimates::subject_of;
use crate::failure::Failure;
use crate::figure_args::FigureArgs;
use crate::fit::of_field;
use crate::parse;
use crate::progress::Progress;
use crate::view_args::ViewArgs;

/// What `cascade compare` takes.
#[derive(Debug, Args)]
pub struct Compare {
    /// Run file of `cascade simulate`, for example of a chain that carries a localized wave; or a measured field.
    pub first: PathBuf,
    /// Another run, for example of a dispersive chain; beside a field a run or its scene.
    pub second: PathBuf,
    /// Directory for the results.
    #[arg(long, short, value_name = "DIR", default_value = "comparison")]
    pub out: PathBuf,
    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,
    /// Of a field, the body of each site, or of forces the contact [default: by the positions, else by the numbers of the
    /// sites].
    #[arg(long, value_delimiter = ',', value_name = "BODY,..")]
    pub bodies: Option<Vec<usize>>,
    /// Of a field, the relative difference of energies up to which they agree [default: 5%].
    #[arg(long, value_name = "SHARE", value_parser = parse::share)]
    pub within: Option<f64>,
    #[command(flatten)]
    pub how: How,
    #[command(flatten)]
    pub views: ViewArgs,
    #[command(flatten)]
    pub input: Input,
    #[command(flatten)]
    pub figures: FigureArgs,
}

impl Compare {
    /// Whether the first file is a run; others are fields.
    pub fn is_of_runs(&self) -> Result<bool, Error> {
        Ok(!self.first.is_file() || is_run_file(&self.first)?)
    }

    /// That no option of fields is there beside two runs.
    pub fn refuse_options_of_fields(&self) -> Result<(), Error> {
        if self.input == Input::default() {
            return Ok(());
        }
        Err(Error::Unfit {
            path: self.first.clone(),
            expected: "no options of fields beside two runs, which have their own axes".into(),
            found: "some".into(),
        })
    }

    /// The chain of a text, else of a run, or of a scene.
    pub fn source(&self, text: Option<String>) -> Result<SceneSource, Error> {
        let file = &self.second;
        match text {
            Some(text) => Ok(SceneSource::new(None, text)),
            None if is_run_file(file)? => Ok(SceneSource::new(
                Some(file),
                RunFile::read(file)?.setup.text,
            )),
            None => SceneSource::read(file),
        }
    }

    /// A field against a chain.
    pub fn find(
        &self,
        field: &Field,
        scene: &SceneSource,
        observer: &dyn Observer,
    ) -> Result<Comparison, Error> {
        let request = CompareRequest {
            bodies: self.bodies.clone(),
            within: self.within.unwrap_or(CompareRequest::default().within),
        };
        request.run(field, scene, observer)
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
            names: names(paths.each_ref().map(|path| name_of(path))),
            budgets: [a, b],
            summaries: [first, second],
            provenance: Provenance::new(words.to_vec(), None, None),
        })
    }

    fn both(&self) -> [(&str, &Budget); 2] {
        let [a, b] = &self.names;
        [(a, &self.budgets[0]), (b, &self.budgets[1])]
    }

    pub fn describe(&self) -> Sheet<'static> {
        Budget::compare(self.both(), self.summaries.clone())
    }

    /// `summary.json`.
    pub fn json(&self) -> serde_json::Result<String> {
        self.describe().summary(&self.provenance)
    }

    /// `report.html`.
    pub fn page(&self, style: &Style) -> serde_json::Result<String> {
        budget_html(&self.both(), &self.describe(), &self.provenance, style)
    }
}

/// Runs the command.
pub fn run(typed: Compare) -> Result<(), Failure> {
    if !typed.is_of_runs()? {
        return run_of_field(typed);
    }
    typed.refuse_options_of_fields()?;
    let drawing = typed.figures.drawing()?;
    let progress = Progress::new(!typed.how.quiet && std::io::stderr().is_terminal());
    use_threads(typed.how.threads.map(usize::from))?;
    drop(ResultDirectory::create(&typed.out, typed.force)?);
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
    let directory = ResultDirectory::create(&typed.out, typed.force)?;
    let paths = [typed.first, typed.second];
    let both = [&files[0], &files[1]];
    let compared = Compared::of(typed.views, both, &paths, &command(), &progress)?;
    // All that reads or hashes the files has done so.
    opened.iter().try_for_each(FileState::check)?;
    let both = compared.both();
    let json = compared.json().map_err(std::io::Error::from)?;
    directory.write("summary.json", &json)?;
    if drawing.is_wanted() {
        progress.stage("drawing", 1);
        let page = compared
            .page(&drawing.style)
            .map_err(std::io::Error::from)?;
        directory.write("report.html", page)?;
        let together: Vec<_> = views(&both, &drawing.style).into_iter().collect();
        let folder = directory.path().join("figures");
        save_all(&together, &folder, &drawing.formats)?;
    }
    progress.check()?;
    let published = directory.publish()?;
    progress.clear();
    let subject = paths.map(|path| subject_of(&[path])).join(" and ");
    let main = published.join(drawing.main());
    tell(
        &compared.describe(),
        &json,
        &subject,
        &typed.how,
        Some(&main),
    )?;
    drawing.present(&main)
}

fn run_of_field(typed: Compare) -> Result<(), Failure> {
    let result = ResultArgs {
        out: Some(typed.out.clone()),
        force: typed.force,
        figures: typed.figures.clone(),
        how: typed.how.clone(),
    };
    result.make((&typed.first, "npy"), "compare", |progress| {
        let find = |field: &Field| typed.find(field, &typed.source(None)?, progress);
        let of = (&*typed.first, &typed.input);
        let (found, hash) = of_field(of, typed.how.quiet, find)?;
        if found.causes.is_cut {
            progress.write_found();
        }
        Ok(Found {
            found,
            hash,
            beside: None,
        })
    })
}

/// Two names that differ.
fn names([first, second]: [String; 2]) -> [String; 2] {
    match first == second {
        true => [format!("{first} (first)"), format!("{second} (second)")],
        false => [first, second],
    }
}
