//! What is done with a described result, whatever it is: its files, and what is printed.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use wavecascade::Error;
use wavecascade::arrays::Precision;
use wavecascade::observer::Observer;
use wavecascade::plot::{self, figures_of};
use wavecascade::report::{Archive, Provenance, ResultDirectory, sheet_html, write_beside};
use wavecascade::sheet::{Describe, Sheet};

use crate::analyze::{named_after, use_threads};
use crate::budget::command;
use crate::chain_args::How;
use crate::estimates::subject_of;
use crate::failure::Failure;
use crate::figure_args::{Drawing, FigureArgs};
use crate::progress::Progress;
use crate::summary::Summary;
use crate::terminal::{self, Tone};

/// Where the result of a command on one file goes, and how it is made.
#[derive(Debug, Args)]
pub struct ResultArgs {
    /// Directory for the results; by default the file's name with the command's, here.
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// Replace an existing result.
    #[arg(long)]
    pub force: bool,

    #[command(flatten)]
    pub figures: FigureArgs,
    #[command(flatten)]
    pub how: How,
}

/// What was found of a file, with the hash of what was read and a file that goes beside the results.
pub struct Found<T> {
    pub found: T,
    pub hash: Option<String>,
    pub beside: Option<(&'static str, String)>,
}

impl ResultArgs {
    /// Makes the result of a file, whose usual extension its directory leaves out, publishes it and prints it.
    pub fn make<T: Describe>(
        &self,
        (file, usual): (&Path, &str),
        command_name: &'static str,
        find: impl FnOnce(&Progress) -> Result<Found<T>, Failure>,
    ) -> Result<(), Failure> {
        let drawing = self.figures.drawing()?;
        use_threads(self.how.threads.map(usize::from))?;
        let default = || named_after(file, usual, &format!("-{command_name}"));
        let out = self.out.clone().unwrap_or_else(default);
        let directory = ResultDirectory::create(&out, self.force)?;
        let progress = Progress::new(!self.how.quiet && std::io::stderr().is_terminal());
        progress.begin_writing();
        let Found {
            found,
            hash,
            beside,
        } = find(&progress)?;
        let provenance = Provenance::new(command(), Some(file.display().to_string()), hash);
        let sheet = found.describe();
        let described = Described {
            found: &found,
            sheet: &sheet,
            name: &file.file_stem().unwrap_or_default().to_string_lossy(),
            provenance: &provenance,
        };
        let write = |path: &Path| match beside {
            Some((name, text)) => write_beside(path, name, text.as_bytes()).map(|_| ()),
            None => Ok(()),
        };
        let main = described.publish((directory, sheet.name), &drawing, &progress, write)?;
        described.tell(&subject_of(&[file.to_owned()]), &self.how, Some(&main))?;
        drawing.present(&main)
    }
}

/// A result with its description.
pub struct Described<'a> {
    pub found: &'a dyn Describe,
    pub sheet: &'a Sheet<'a>,
    /// Of the data, in titles.
    pub name: &'a str,
    pub provenance: &'a Provenance,
}

impl Described<'_> {
    pub fn json(&self) -> Result<String, Failure> {
        let json = self.sheet.summary(self.provenance);
        Ok(json.map_err(std::io::Error::from)?)
    }

    fn page(&self, drawing: &Drawing) -> Result<String, Failure> {
        let Described {
            found,
            sheet,
            name,
            provenance,
        } = self;
        let page = sheet_html(*found, sheet, name, provenance, &drawing.style);
        Ok(page.map_err(std::io::Error::from)?)
    }

    /// Writes `summary.json`, arrays and figures called `file`, `table.csv` and the page, where there are such, to a
    /// directory that appears whole, with what `beside` adds; returns the file to open.
    pub fn publish(
        &self,
        (directory, file): (ResultDirectory, &'static str),
        drawing: &Drawing,
        progress: &Progress,
        beside: impl FnOnce(&Path) -> Result<(), Error>,
    ) -> Result<PathBuf, Failure> {
        let sheet = self.sheet;
        directory.write("summary.json", self.json()?)?;
        if !sheet.variables.is_empty() {
            let arrays = directory.path().join(format!("{file}.npz"));
            let archive = Archive::create(&arrays, Precision::F64)?;
            sheet.write_to(&archive)?;
            archive.finish()?;
        }
        if !sheet.records.head.is_empty() {
            let csv = sheet.records.to_csv().map_err(std::io::Error::other)?;
            directory.write("table.csv", csv)?;
        }
        beside(directory.path())?;
        if drawing.is_wanted() {
            progress.stage("drawing", 1);
            let figures = figures_of(self.found, sheet, self.name, file, &drawing.style);
            let folder = directory.path().join("figures");
            plot::save_all(&figures, &folder, &drawing.formats)?;
            directory.write("report.html", self.page(drawing)?)?;
        }
        progress.check()?;
        let published = directory.publish()?;
        progress.clear();
        Ok(published.join(drawing.main()))
    }

    /// The same in the directory of a journal, which keeps the runs that the result is made of, each file whole: rows
    /// are in `curves.csv`, the figure beside it.
    pub fn keep(&self, out: &Path, drawing: &Drawing) -> Result<PathBuf, Failure> {
        let sheet = self.sheet;
        let summary = write_beside(out, "summary.json", self.json()?.as_bytes())?;
        let csv = sheet.records.to_csv().map_err(std::io::Error::other)?;
        write_beside(out, "curves.csv", csv.as_bytes())?;
        if !drawing.is_wanted() {
            return Ok(summary);
        }
        for figure in figures_of(self.found, sheet, self.name, sheet.name, &drawing.style) {
            for format in &drawing.formats {
                let file = format!("{}.{}", figure.name(), format.extension());
                write_beside(out, &file, &figure.encode(*format)?)?;
            }
        }
        Ok(write_beside(
            out,
            "report.html",
            self.page(drawing)?.as_bytes(),
        )?)
    }

    /// Prints the JSON, or what was found of the subject and the file to open.
    pub fn tell(&self, subject: &str, how: &How, main: Option<&Path>) -> Result<(), Failure> {
        tell(self.sheet, &self.json()?, subject, how, main)
    }
}

/// Prints the JSON, or what was found of the subject and the file to open.
pub fn tell(
    sheet: &Sheet,
    json: &str,
    subject: &str,
    how: &How,
    main: Option<&Path>,
) -> Result<(), Failure> {
    if how.json {
        if !how.quiet {
            for warning in &sheet.warnings {
                terminal::message(Tone::Warning, &warning.message);
                if !warning.advice.is_empty() {
                    terminal::message(Tone::Help, &warning.advice);
                }
            }
        }
        writeln!(terminal::stdout(), "{json}")?;
    } else if !how.quiet {
        let mut summary = Summary::of(subject, sheet);
        if let Some(main) = main {
            summary.last(&format!("open {}", main.display()));
        }
        summary.print(how.detail.verbose)?;
    }
    Ok(())
}
