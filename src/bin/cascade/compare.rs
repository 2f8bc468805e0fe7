//! `cascade compare`: the budgets of two runs on one page.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};
use wavecascade::Error;
use wavecascade::budget::Budget;
use wavecascade::chain::scene::Units;
use wavecascade::field::{FileState, file_hash};
use wavecascade::observer::Observer;
use wavecascade::plot::{Style, save_all, views};
use wavecascade::report::{
    BudgetSummary, Provenance, ResultDirectory, RunFile, comparison_html, comparison_rows,
};

use crate::analyze::use_threads;
use crate::args::DetailArgs;
use crate::budget::{command, compute, name_of};
use crate::estimates::subject_of;
use crate::failure::Failure;
use crate::figure_args::FigureArgs;
use crate::progress::Progress;
use crate::summary::Summary;
use crate::table::Table;
use crate::terminal::{self, number};
use crate::view_args::ViewArgs;

/// What `cascade compare` takes.
#[derive(Debug, Args)]
pub struct Compare {
    /// Run file of `cascade simulate`, for example of a chain that carries a localized wave.
    pub first: PathBuf,
    /// Another, for example of a dispersive one.
    pub second: PathBuf,
    /// Directory for the results.
    #[arg(long, short, value_name = "DIR", default_value = "comparison")]
    pub out: PathBuf,
    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,
    /// Print the summary as JSON on standard output.
    #[arg(long)]
    pub json: bool,
    /// Print errors only.
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub detail: DetailArgs,
    #[command(flatten)]
    pub views: ViewArgs,
    #[command(flatten)]
    pub figures: FigureArgs,
}

/// Version of the layout of a comparison's `summary.json`.
const SCHEMA: &str = "cascade.compare/1";

/// The budgets of two runs.
pub struct Compared {
    names: [String; 2],
    budgets: [Budget; 2],
    pub summary: Value,
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
            let summary = serde_json::to_value(BudgetSummary::new(&found, &provenance));
            Ok((found, summary.map_err(std::io::Error::from)?))
        };
        let (a, first) = one(files[0], &paths[0])?;
        let (b, second) = one(files[1], &paths[1])?;
        let difference = difference(&first, &second);
        Ok(Compared {
            names: names(paths.each_ref().map(|path| name_of(path))),
            budgets: [a, b],
            summary: json!({
                "schema": SCHEMA,
                "first": first,
                "second": second,
                "difference": difference,
            }),
        })
    }

    fn both(&self) -> [(&str, &Budget); 2] {
        let [a, b] = &self.names;
        [(a, &self.budgets[0]), (b, &self.budgets[1])]
    }

    /// `report.html`.
    pub fn page(&self, style: &Style) -> String {
        comparison_html(self.both(), style)
    }
}

/// Runs the command.
pub fn run(typed: Compare) -> Result<(), Failure> {
    let drawing = typed.figures.drawing()?;
    typed.views.refuse_without_effect()?;
    let progress = Progress::new(!typed.quiet && std::io::stderr().is_terminal());
    use_threads(typed.views.threads.map(usize::from))?;
    drop(ResultDirectory::create(&typed.out, typed.force)?);
    let opened = [FileState::at(&typed.first)?, FileState::at(&typed.second)?];
    let files = [RunFile::read(&typed.first)?, RunFile::read(&typed.second)?];
    progress.begin_writing();
    let directory = ResultDirectory::create(&typed.out, typed.force)?;
    let paths = [typed.first, typed.second];
    let both = [&files[0], &files[1]];
    let compared = Compared::of(typed.views, both, &paths, &command(), &progress)?;
    // All that reads or hashes the files has done so.
    opened.iter().try_for_each(FileState::check)?;
    let both = compared.both();
    let json = serde_json::to_string_pretty(&compared.summary).map_err(std::io::Error::from)?;
    directory.write("summary.json", &json)?;
    if drawing.is_wanted() {
        progress.stage("drawing", 1);
        directory.write("report.html", compared.page(&drawing.style))?;
        let together: Vec<_> = views(&both, &drawing.style).into_iter().collect();
        let folder = directory.path().join("figures");
        save_all(&together, &folder, &drawing.formats)?;
    }
    progress.check()?;
    let published = directory.publish()?;
    progress.clear();
    if typed.json {
        writeln!(terminal::stdout(), "{json}")?;
    } else if !typed.quiet {
        let subject = paths.map(|path| subject_of(&[path]));
        let mut summary = Summary::new(
            &subject.join(" and "),
            &answer(&compared.names, &compared.budgets),
        );
        let rows = comparison_rows(both);
        if let Some(table) = table(&rows, |name| !name.starts_with("residual")) {
            summary.rows(table);
        }
        if let Some(table) = table(&rows, |name| name.starts_with("residual")) {
            summary.detailed_rows(table);
        }
        let main = match drawing.is_wanted() {
            true => "report.html",
            false => "summary.json",
        };
        summary.last(&format!("open {}", published.join(main).display()));
        summary.print(typed.detail.verbose)?;
    }
    Ok(())
}

/// How far apart two runs are, in words: by what passes to high wavenumbers, or past the middle.
fn answer(names: &[String; 2], budgets: &[Budget; 2]) -> String {
    let [first, second] = [&budgets[0], &budgets[1]];
    let passages = [first, second].map(|budget| budget.largest_passage());
    if let [Some(a), Some(b)] = passages {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        return format!(
            "{} of the energy apart: {} and {} pass to higher wavenumbers (net)",
            percent((b.share - a.share).abs()),
            percent(a.share),
            percent(b.share)
        );
    }
    let passed = [first, second].map(|budget| budget.passed.get(budget.n_contacts / 2).copied());
    match passed {
        [Some(a), Some(b)] => format!(
            "{} passes the middle of {}, {} that of {}",
            number(a),
            names[0],
            number(b),
            names[1]
        ),
        _ => "no energy passes".into(),
    }
}

/// The first row names the columns; of the others those that are wanted.
fn table(rows: &[[String; 4]], is_wanted: impl Fn(&str) -> bool) -> Option<Table> {
    let ([name, columns @ ..], rows) = rows.split_first()?;
    let mut table = Table::new(name);
    for column in columns {
        table = table.numbers(column);
    }
    for row in rows.iter().filter(|row| is_wanted(&row[0])) {
        table.row(row.to_vec());
    }
    Some(table)
}

/// Two names that differ.
fn names([first, second]: [String; 2]) -> [String; 2] {
    match first == second {
        true => [format!("{first} (first)"), format!("{second} (second)")],
        false => [first, second],
    }
}

/// Second less first, for every number that both have under the same name.
fn difference(first: &Value, second: &Value) -> Value {
    match (first, second) {
        (Value::Object(a), Value::Object(b)) => {
            let pairs = a
                .iter()
                .filter_map(|(key, a)| Some((key, difference(a, b.get(key)?))));
            let kept = pairs.filter(|(_, value)| !value.is_null());
            let map: serde_json::Map<_, _> =
                kept.map(|(key, value)| (key.clone(), value)).collect();
            if map.is_empty() {
                Value::Null
            } else {
                Value::Object(map)
            }
        }
        (Value::Number(a), Value::Number(b)) => match (a.as_f64(), b.as_f64()) {
            (Some(a), Some(b)) => json!(b - a),
            _ => Value::Null,
        },
        _ => Value::Null,
    }
}
