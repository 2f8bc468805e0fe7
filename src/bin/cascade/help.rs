//! What help shows: commands grouped by question, and under `-h` the options that most people need.

use clap::{Arg, Command, CommandFactory, Subcommand};

use crate::args::Cli;
use crate::estimates::EstimateCommand;

/// Commands by the question they answer; those on estimates come behind the first group.
const GROUPS: [(&str, &str); 5] = [
    ("Look at a field", "analyze inspect filter convert"),
    ("Simulate chains", "scene simulate sweep"),
    ("Follow the energy of chains", "budget triads compare"),
    (
        "From a measurement to a design",
        "plan fit design attenuate localize",
    ),
    ("Start, and tools", "examples completions man help"),
];

/// All groups.
fn groups() -> Vec<(&'static str, Vec<String>)> {
    let of = |names: &str| names.split(' ').map(str::to_owned).collect();
    let all = GROUPS.iter();
    let mut all: Vec<_> = all
        .map(|(question, names)| (*question, of(names)))
        .collect();
    let estimates = EstimateCommand::augment_subcommands(Command::new("estimates"));
    all.insert(1, ("Estimate, with intervals", names_of(&estimates)));
    all
}

fn names_of(command: &Command) -> Vec<String> {
    let all = command.get_subcommands();
    all.map(|command| command.get_name().to_owned()).collect()
}

/// Headings whose options few need, and options that few need under any heading: `-h` leaves them out.
const RARE_HEADINGS: [&str; 11] = [
    "The field and its axes",
    "Scans: one record a file, one field",
    "Spectra",
    "Low and high band, directions",
    "Short-time spectra",
    "Dispersion relations drawn over S(k, f)",
    "Display limits of figures and report",
    "Figures",
    "A measured field",
    "Transfer",
    "Against a key of the scene",
];
const RARE: &str = "precision memory threads read significance equal_weights no_jackknife space_window \
    space_multitaper part merge max_time arrival_threshold detrend_field detrend_space \
    window_samples window_sites without_sites until_arrival sites plan only format from_samples filter scales \
    map_scale band_edge_frequency band_edge_wavenumber subtract_noise overlap window lengths \
    contacts measured measured_field sense lag_band histograms frames points range";

/// What most need of the rare headings.
const COMMON: &str = "layout dt dx unit noise figures transfer open";

/// The program's arguments with their help.
pub fn command() -> Command {
    let mut all = Cli::command();
    let listed = grouped(&all);
    for name in names_of(&all) {
        all = all.mut_subcommand(name, |command| {
            command.mut_args(|arg| {
                let is_rare = is_rare(&arg);
                arg.hide_short_help(is_rare)
            })
        });
    }
    all.help_template(
        "{about}\n\n{usage-heading} {usage}\n{before-help}\nOptions:\n{options}{after-help}",
    )
    .before_help(listed)
    .after_help(
        "`cascade COMMAND -h` shows what most need, `--help` all. `cascade examples` is a start.",
    )
}

fn is_rare(arg: &Arg) -> bool {
    let id = arg.get_id().as_str();
    let is_below = arg
        .get_help_heading()
        .is_some_and(|heading| RARE_HEADINGS.contains(&heading));
    let is_in = |names: &str| names.split(' ').any(|name| name == id);
    is_in(RARE) || (is_below && !is_in(COMMON))
}

/// The commands with what they do, a line each.
fn grouped(all: &Command) -> String {
    let about = |name: &str| match all.find_subcommand(name).and_then(Command::get_about) {
        Some(about) => about.to_string(),
        None => "Print help of the program, or of a command".into(),
    };
    let mut text = String::new();
    for (question, names) in groups() {
        text += &format!("\n{question}:\n");
        for name in names {
            text += &format!("  {name:<12} {}\n", about(&name));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_command_is_in_one_group_with_one_line() {
        let all = Cli::command();
        let mut listed: Vec<String> = groups().into_iter().flat_map(|(_, names)| names).collect();
        let mut known = names_of(&all);
        known.push("help".into());
        listed.sort_unstable();
        known.sort_unstable();
        assert_eq!(listed, known);
        for line in grouped(&all).lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
    }

    #[test]
    fn brief_help_fits_on_a_screen() {
        for name in names_of(&Cli::command()) {
            let mut all = command();
            let help = all.find_subcommand_mut(&name).unwrap().render_help();
            let help = help.to_string();
            let lines = help.lines().count();
            assert!(lines <= 50, "{name}: {lines} lines\n{help}");
        }
    }

    #[test]
    fn examples_are_commands() {
        let all = Cli::command();
        for command in all.get_subcommands() {
            let Some(text) = command.get_after_help() else {
                continue;
            };
            let text = text.to_string();
            let words = text.trim_start_matches("Example: ").split(' ');
            let parsed = Cli::command().try_get_matches_from(words);
            assert!(parsed.is_ok(), "{text}: {}", parsed.unwrap_err());
        }
    }

    #[test]
    fn options_named_here_are_there() {
        let all = Cli::command();
        let args = || {
            all.get_subcommands()
                .flat_map(Command::get_arguments)
                .chain(all.get_arguments())
        };
        for name in RARE.split(' ').chain(COMMON.split(' ')) {
            assert!(args().any(|arg| arg.get_id() == name), "{name}");
        }
        for heading in RARE_HEADINGS {
            assert!(
                args().any(|arg| arg.get_help_heading() == Some(heading)),
                "{heading}"
            );
        }
    }
}
