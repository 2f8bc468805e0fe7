//! `cascade settings`: a settings file to start from, its schema, what a file sets.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{Arg, Args, Command, CommandFactory, FromArgMatches};

use super::file::{self, Setting};
use super::keys::Kind;
use super::locate;
use super::template::{schema, template};
use crate::args::{self, Cli};
use crate::failure::Failure;
use crate::terminal::{self, Lines};

/// What `cascade settings` takes.
#[derive(Debug, Args)]
pub struct Settings {
    /// Kind of the file [default: style for a file of the name style.toml, else analysis].
    #[arg(value_enum)]
    pub kind: Option<Kind>,

    /// Print the JSON schema of such files instead.
    #[arg(long, conflicts_with = "check")]
    pub schema: bool,

    /// Check this file, and print what it sets.
    #[arg(long, value_name = "FILE")]
    pub check: Option<PathBuf>,

    /// With `--check`, as JSON.
    #[arg(long, requires = "check")]
    pub json: bool,
}

/// Runs the command.
pub fn run(typed: Settings) -> Result<(), Failure> {
    let style: &Path = Kind::Style.file_name().as_ref();
    let is_style = |path: &PathBuf| path.file_name() == Some(style.as_os_str());
    let kind = typed
        .kind
        .unwrap_or(match typed.check.as_ref().is_some_and(is_style) {
            true => Kind::Style,
            false => Kind::Analysis,
        });
    let mut out = terminal::stdout();
    if typed.schema {
        let text = serde_json::to_string_pretty(&schema(kind)).map_err(std::io::Error::from)?;
        return Ok(writeln!(out, "{text}")?);
    }
    let Some(path) = typed.check else {
        return Ok(out.write_all(template(kind).as_bytes())?);
    };
    let settings = checked(kind, &path)?;
    if typed.json {
        let pairs = settings.iter().map(|one| (&one.key, &one.value));
        let set: BTreeMap<_, _> = pairs.collect();
        let text = serde_json::to_string_pretty(&set).map_err(std::io::Error::from)?;
        return Ok(writeln!(out, "{text}")?);
    }
    let mut lines = Lines::new(terminal::width());
    for one in &settings {
        lines.line(&one.key, &one.shown());
    }
    if settings.is_empty() {
        lines.line("no key", "is set: all are commented out");
    }
    Ok(out.write_all(lines.text.as_bytes())?)
}

/// What a file sets, once every command that has one of its keys has accepted it.
fn checked(kind: Kind, path: &Path) -> Result<Vec<Setting>, Failure> {
    let program = Cli::command();
    let mut all: Vec<Setting> = Vec::new();
    for command in program.get_subcommands() {
        if kind.of_command(command).is_empty() {
            continue;
        }
        let settings = file::read(kind, path, command)?;
        let (matches, settings) = locate::parsed(&least(command), settings, &[])?;
        if let Ok(cli) = Cli::from_arg_matches(&matches)
            && let args::Command::Analyze(typed) = cli.command
        {
            let applied = super::Applied {
                settings: settings.clone(),
                ..super::Applied::default()
            };
            let found = crate::analyze::check(&typed);
            found.map_err(|failure| applied.located(failure))?;
        }
        for one in settings {
            if all.iter().all(|known| known.key != one.key) {
                all.push(one);
            }
        }
    }
    all.sort_by_key(|one| one.line);
    Ok(all)
}

/// The shortest command line of a command: files that it requires, also those required unless an option is
/// there.
fn least(command: &Command) -> Vec<OsString> {
    let words = |is_given: fn(&&Arg) -> bool| -> Vec<OsString> {
        let named = [OsString::from("cascade"), command.get_name().into()];
        let files = command.get_positionals().filter(is_given);
        named
            .into_iter()
            .chain(files.map(|_| "FILE".into()))
            .collect()
    };
    let required = words(|arg| arg.is_required_set());
    match Cli::command().try_get_matches_from(&required) {
        Err(error) if error.kind() == ErrorKind::MissingRequiredArgument => words(|_| true),
        _ => required,
    }
}
