//! Words that are no command and no option: files, and parts of a name.

use std::ffi::OsString;
use std::path::Path;

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches};
use wavecascade::error::nearest_key;

use crate::args::Cli;
use crate::help;
use crate::words::with_values;

/// Options that are looked for where they are none: the command, their names, and what serves.
const OPTIONS: [(&str, &str, &str); 2] = [
    (
        "analyze",
        "part merge",
        "an analysis is of whole records; averages over segments are made in parts by `cascade spectrum FIELD \
         --part 3/64` and by `cascade coherence`",
    ),
    (
        "filter",
        "band low-pass lowpass high-pass highpass band-pass bandpass",
        "a band of frequencies is `--frequency 2kHz:6kHz`; of wavenumbers `--wavenumber`, of phase velocities \
         `--speed`",
    ),
];

/// The command that was typed; help, version and words that are none end the program.
pub fn parsed(words: Vec<OsString>) -> Cli {
    use ErrorKind::{DisplayHelp, DisplayHelpOnMissingArgumentOrSubcommand};
    // Groups and brief help are made only for who asks: they take longer than the arguments of a run.
    let mut cli = Cli::command();
    let words = with_values(words);
    let command = words.get(1).cloned().unwrap_or_default();
    let typed = cli.try_get_matches_from_mut(words.clone());
    let typed = typed.or_else(|error| match error.kind() {
        DisplayHelp | DisplayHelpOnMissingArgumentOrSubcommand => {
            help::command().try_get_matches_from(words)
        }
        _ => Err(error),
    });
    let parsed = typed.and_then(|mut typed| Cli::from_arg_matches_mut(&mut typed));
    parsed.unwrap_or_else(|mut error| {
        if error.kind() == ErrorKind::InvalidSubcommand
            && let Some(ContextValue::String(name)) = error.get(ContextKind::InvalidSubcommand)
        {
            let name = name.clone();
            let known = cli.get_subcommands().map(clap::Command::get_name);
            // The one that was meant, not all that begin or end alike.
            error.remove(ContextKind::SuggestedSubcommand);
            if let Some(near) = nearest_key(&name, known) {
                let near = ContextValue::String(near.into());
                error.insert(ContextKind::SuggestedSubcommand, near);
            }
            if let Some(tip) = instead_of(&name) {
                let tip = ContextValue::StyledStrs(vec![StyledStr::from(tip)]);
                error.insert(ContextKind::Suggested, tip);
            }
        }
        if error.kind() == ErrorKind::UnknownArgument
            && let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidArg)
            && let Some(command) = cli.find_subcommand(&command)
            && let Some(tip) = options_with(word, command)
        {
            for kind in [ContextKind::SuggestedArg, ContextKind::Usage] {
                error.remove(kind);
            }
            let tip = ContextValue::StyledStrs(vec![StyledStr::from(tip)]);
            error.insert(ContextKind::Suggested, tip);
        }
        error.exit()
    })
}

/// What to type for a word that is no command.
fn instead_of(word: &str) -> Option<String> {
    let path = Path::new(word);
    let command = match path.extension()?.to_str()? {
        "toml" => "simulate",
        _ => "analyze",
    };
    path.is_file()
        .then(|| format!("a file comes after a command: `cascade {command} {word}`"))
}

/// What to type for a word that is no option of a command: options whose names have it as a part, `--stiffness-ratio` for `--ratio`.
fn options_with(word: &str, command: &clap::Command) -> Option<String> {
    let word = word.strip_prefix("--")?;
    let is_known = |(name, words, _): &&(&str, &str, &str)| {
        *name == command.get_name() && words.split(' ').any(|one| one == word)
    };
    if let Some((_, _, instead)) = OPTIONS.iter().find(is_known) {
        return Some((*instead).into());
    }
    let names = command.get_arguments().filter_map(clap::Arg::get_long);
    let names = names.filter(|name| name.split('-').any(|part| part == word));
    let names: Vec<String> = names.map(|name| format!("`--{name}`")).collect();
    (1..=4)
        .contains(&names.len())
        .then(|| format!("did you mean {}?", names.join(" or ")))
}
