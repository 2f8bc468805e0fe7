//! Settings files: options that are kept beside a field or in the home configuration.
//!
//! Each file is turned into the words that a command line would have, so that clap remains the only
//! judge of values. What is typed takes precedence, then `analysis.toml`, `style.toml` beside the
//! field, and the style of the home configuration.

mod command;
mod file;
mod home;
mod keys;
mod locate;
mod template;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command, CommandFactory, FromArgMatches};
use wavecascade::report::SettingInEffect;

use crate::args::{Analyze, Cli};
use crate::failure::Failure;
pub use command::{Settings, run};
use file::Setting;
pub use file::SettingFault;
pub use keys::FIGURES;
use keys::{Kind, key_of};

/// The words as typed, and what can be seen of them before settings complete them.
#[derive(Debug)]
pub struct CommandLine {
    words: Vec<OsString>,
    /// Of the words alone, where some may yet be missing.
    seen: ArgMatches,
}

/// What a call states that no file can: options that several fields have in common.
#[derive(Debug)]
pub struct Call {
    pub out: Option<PathBuf>,
    pub force: bool,
    pub plan: bool,
    pub json: bool,
    pub quiet: bool,
    pub verbose: bool,
    pub max_time: Option<Duration>,
}

/// Settings of files that took effect.
#[derive(Debug, Clone, Default)]
pub struct Applied {
    settings: Vec<Setting>,
    /// Files beside what was read, which nobody has named.
    beside: Vec<PathBuf>,
    in_effect: Vec<SettingInEffect>,
}

/// One file with its settings.
struct Layer {
    kind: Kind,
    settings: Vec<Setting>,
}

/// Settings of all files.
#[derive(Default)]
struct Chosen {
    kept: Vec<Setting>,
    /// Those that something of higher precedence sets or excludes.
    overridden: Vec<Setting>,
}

impl CommandLine {
    /// The words that the program was called with. Help, version, and words that no settings could
    /// complete end the program.
    pub fn typed() -> CommandLine {
        let words = crate::words::typed();
        let seen = Cli::command()
            .ignore_errors(true)
            .try_get_matches_from(&words);
        CommandLine {
            seen: seen.unwrap_or_else(|shown| shown.exit()),
            words,
        }
    }

    /// Paths that a command which takes the files of a scan is to read.
    pub fn fields(&self) -> Vec<PathBuf> {
        let seen = ["analyze", "inspect", "convert"]
            .iter()
            .find_map(|name| self.seen.subcommand_matches(name));
        let fields = seen.and_then(|seen| seen.try_get_many("fields").ok().flatten());
        fields.into_iter().flatten().cloned().collect()
    }

    /// Whether they are one field, or go to a command that refuses others.
    pub fn is_scan(&self) -> bool {
        let analyze = self.seen.subcommand_matches("analyze");
        analyze.is_none_or(|seen| seen.value_source("position_from").is_some())
    }

    /// Options of the call itself; those that its command does not have are off.
    pub fn call(&self) -> Call {
        let seen = self.seen.subcommand().map(|(_, seen)| seen);
        let flag = |name: &str| {
            let found = seen.and_then(|seen| seen.try_get_one::<bool>(name).ok().flatten());
            found.copied().unwrap_or(false)
        };
        let out = seen.and_then(|seen| seen.try_get_one::<PathBuf>("out").ok().flatten());
        Call {
            out: out.cloned(),
            force: flag("force"),
            plan: flag("plan"),
            json: flag("json"),
            quiet: flag("quiet"),
            verbose: flag("verbose"),
            max_time: seen
                .and_then(|seen| seen.try_get_one("max_time").ok().flatten())
                .copied(),
        }
    }

    /// The command with the settings that hold for `input`, or for the first file that it reads.
    ///
    /// # Errors
    /// A settings file that cannot be read or has a fault.
    pub fn parse(&self, input: Option<&Path>) -> Result<(Cli, Applied), Failure> {
        let (matches, applied) = self.matches(input)?;
        let cli = Cli::from_arg_matches(&matches);
        let cli = cli.unwrap_or_else(|error| error.format(&mut Cli::command()).exit());
        Ok((cli, applied))
    }

    /// The same of one of the fields of `cascade analyze`.
    ///
    /// # Errors
    /// As for [`CommandLine::parse`].
    pub fn analyze(&self, field: &Path) -> Result<(Analyze, Applied), Failure> {
        let (matches, applied) = self.matches(Some(field))?;
        let typed = matches.subcommand_matches("analyze").unwrap_or(&matches);
        let typed = Analyze::from_arg_matches(typed);
        let typed = typed.unwrap_or_else(|error| error.format(&mut Cli::command()).exit());
        Ok((typed, applied))
    }

    fn matches(&self, input: Option<&Path>) -> Result<(ArgMatches, Applied), Failure> {
        let program = Cli::command();
        let typed = self.seen.subcommand();
        let typed = typed.and_then(|(name, seen)| Some((program.find_subcommand(name)?, seen)));
        let (mut chosen, mut beside) = (Chosen::default(), Vec::new());
        if let Some((command, seen)) = typed {
            let input = input.or_else(|| first_path(command, seen));
            let (layers, found) = layers(command, seen, input)?;
            chosen = uncontradicted(command, seen, layers);
            beside = found;
        }
        let (matches, settings) = locate::parsed(&self.words, chosen.kept, &chosen.overridden)?;
        let in_effect = typed.map(|(command, _)| in_effect(command, &matches, &settings));
        let applied = Applied {
            settings,
            beside,
            in_effect: in_effect.unwrap_or_default(),
        };
        Ok((matches, applied))
    }
}

/// The first file among the words without an option.
fn first_path<'a>(command: &Command, seen: &'a ArgMatches) -> Option<&'a Path> {
    let mut positional = command.get_positionals();
    let path = positional.find_map(|arg| {
        let found = seen.try_get_many::<PathBuf>(arg.get_id().as_str());
        found.ok().flatten()?.next()
    });
    path.map(PathBuf::as_path)
}

/// Files with settings for a command, those that take precedence first, and those of them that nobody
/// has named.
fn layers(
    command: &Command,
    seen: &ArgMatches,
    input: Option<&Path>,
) -> Result<(Vec<Layer>, Vec<PathBuf>), Failure> {
    let (mut layers, mut beside) = (Vec::new(), Vec::new());
    let mut add = |kind: Kind, path: &Path| -> Result<(), Failure> {
        let settings = file::read(kind, path, command)?;
        layers.push(Layer { kind, settings });
        Ok(())
    };
    if !Kind::Analysis.of_command(command).is_empty() {
        let named = seen.try_get_one::<PathBuf>("settings").ok().flatten();
        match named {
            Some(none) if none.as_os_str() == "none" => {}
            Some(path) => add(Kind::Analysis, path)?,
            None => {
                if let Some(path) = home::beside(Kind::Analysis, input) {
                    add(Kind::Analysis, &path)?;
                    beside.push(path);
                }
            }
        }
    }
    if !Kind::Style.of_command(command).is_empty() {
        if let Some(path) = home::beside(Kind::Style, input) {
            add(Kind::Style, &path)?;
            beside.push(path);
        }
        if let Some(path) = home::style() {
            add(Kind::Style, &path)?;
        }
    }
    Ok((layers, beside))
}

/// Settings that nothing of higher precedence sets or excludes. Without figures a style has no effect.
fn uncontradicted(command: &Command, seen: &ArgMatches, layers: Vec<Layer>) -> Chosen {
    let typed = |arg: &&Arg| {
        let id = arg.get_id().as_str();
        // A command that could not be read to its end does not know all of its options.
        let is_known = seen.try_contains_id(id).is_ok();
        is_known && seen.value_source(id) == Some(ValueSource::CommandLine)
    };
    let mut taken: Vec<Arg> = command.get_arguments().filter(typed).cloned().collect();
    let figures = seen.try_get_raw("figures").ok().flatten();
    let mut draws = figures.is_none_or(|mut formats| formats.any(|format| format != "none"));
    let mut chosen = Chosen::default();
    for Layer { kind, settings } in layers {
        if kind == Kind::Style && !draws {
            continue;
        }
        let is_overridden =
            |one: &Setting| taken.iter().any(|arg| excludes(command, arg, &one.arg));
        let (overridden, kept): (Vec<_>, Vec<_>) = settings.into_iter().partition(is_overridden);
        draws &= kept.iter().all(|one| one.words != ["--figures=none"]);
        taken.extend(kept.iter().map(|one| one.arg.clone()));
        chosen.kept.extend(kept);
        chosen.overridden.extend(overridden);
    }
    chosen
}

/// Whether two options are the same, or cannot be given together.
fn excludes(command: &Command, one: &Arg, other: &Arg) -> bool {
    let conflicts = |one: &Arg, other: &Arg| {
        let all = command.get_arg_conflicts_with(one);
        all.iter().any(|arg| arg.get_id() == other.get_id())
    };
    one.get_id() == other.get_id() || conflicts(one, other) || conflicts(other, one)
}

/// Options that were typed or set, with their values as typed and where.
fn in_effect(
    command: &Command,
    matches: &ArgMatches,
    settings: &[Setting],
) -> Vec<SettingInEffect> {
    let Some((_, matches)) = matches.subcommand() else {
        return Vec::new();
    };
    let is_typed = |arg: &&Arg| {
        let source = matches.value_source(arg.get_id().as_str());
        let key = key_of(arg);
        source == Some(ValueSource::CommandLine)
            && arg.get_long().is_some()
            && keys::reason_against(&key).is_none()
    };
    let options = command.get_arguments().filter(is_typed);
    let in_effect = options.map(|arg| {
        let raw = matches.get_raw(arg.get_id().as_str());
        let words = raw.into_iter().flatten();
        let words: Vec<_> = words.map(|word| word.to_string_lossy()).collect();
        let of_file = settings.iter().find(|one| one.arg.get_id() == arg.get_id());
        SettingInEffect {
            option: key_of(arg),
            value: words.join(","),
            stated_by: of_file.map_or("command line".into(), Setting::place),
        }
    });
    in_effect.collect()
}

impl Applied {
    /// What was typed or set, for the provenance of a result.
    pub fn in_effect(&self) -> &[SettingInEffect] {
        &self.in_effect
    }

    /// One line for each file that nobody has named.
    pub fn notes(&self) -> Vec<String> {
        let note = |path: &PathBuf| {
            let of_file = self.settings.iter().filter(|one| one.path == *path);
            let keys: Vec<&str> = of_file.map(|one| &*one.key).collect();
            let keys = match keys.is_empty() {
                true => "none has an effect here".into(),
                false => keys.join(", "),
            };
            format!("settings of {}: {keys}", path.display())
        };
        self.beside.iter().map(note).collect()
    }

    /// A fault of an option that a file has set, as a fault of the file.
    pub fn located(&self, failure: Failure) -> Failure {
        use wavecascade::Error;
        match failure {
            Failure::Library(Error::Request {
                option,
                expected,
                found,
            }) => {
                let typed = format!("--{}", option.replace('_', "-"));
                let set = self.settings.iter().find(|one| one.option() == typed);
                match set {
                    Some(set) => set.fault(expected, found).into(),
                    None => Failure::Library(Error::Request {
                        option,
                        expected,
                        found,
                    }),
                }
            }
            other => other,
        }
    }
}
