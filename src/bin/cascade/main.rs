//! The program: arguments, one library call, files, exit code.

mod advice;
// The allocator of a process is the choice of its program, not of an extension.
#[cfg(not(feature = "python"))]
mod allocator;
mod analyze;
mod args;
mod arrays_file;
mod attenuate;
mod bench;
mod bicoherence;
mod budget;
mod chain_args;
mod clean;
mod coherence;
mod compare;
mod contact;
mod convert;
mod dispersion;
mod effect;
mod estimate;
mod failure;
mod fields;
mod figure_args;
mod filter;
mod further;
mod increments;
mod inspect;
mod localize;
mod manual;
mod measured;
mod modes;
mod parse;
mod parts;
mod progress;
mod ridges;
mod saved;
mod scan_args;
mod scene;
mod scene_keys;
mod settings;
mod show_args;
mod simulate;
mod slope;
mod spacetime;
mod spectrum;
mod summary;
mod sweep;
mod table;
mod terminal;
mod text;
mod transfer;
mod transmit;
mod triads;
mod triple_args;
mod view_args;
mod words;

/// The same program as an extension module of Python, with functions on arrays.
#[cfg(feature = "python")]
#[path = "../../../python/src/module.rs"]
mod python;

use std::path::PathBuf;

use args::{Cli, Command};
use failure::Failure;
use settings::{Applied, CommandLine};
use terminal::Tone;

/// What is said of a mapped file whose bytes are gone.
const FILE_LOST: &str = "was shortened while it was read, or its disk cannot be read: expected all \
    bytes of the file\nhelp: repeat the command once nothing writes to the file, or copy it to memory \
    first with `--read copy`\n";

#[cfg(not(feature = "python"))]
fn main() -> std::process::ExitCode {
    program().into()
}

/// Runs the command that was typed; returns the exit code.
fn program() -> u8 {
    wavecascade_system::signals::prepare(FILE_LOST);
    match run(&CommandLine::typed()) {
        Ok(()) => 0,
        Err(failure) => failure.report(),
    }
}

fn run(line: &CommandLine) -> Result<(), Failure> {
    let fields = fields::expanded(&line.fields())?;
    if fields.len() > 1 && !line.is_scan() {
        progress::end_after(line.call().max_time);
        return fields::run(line, &fields);
    }
    let field = fields.first().map(PathBuf::as_path);
    let (cli, applied) = line.parse(field)?;
    progress::end_after(cli.max_time);
    if !line.call().quiet {
        for note in applied.notes() {
            terminal::message(Tone::Note, &note);
        }
    }
    let done = one(cli, &fields, &applied);
    done.map_err(|failure| applied.located(failure))
}

fn one(cli: Cli, fields: &[PathBuf], applied: &Applied) -> Result<(), Failure> {
    match cli.command {
        Command::Analyze(typed) => analyze::run(&typed, fields, applied),
        Command::Bicoherence(typed) => estimate::run(&*typed),
        Command::Triads(typed) => estimate::run(&*typed),
        Command::Coherence(typed) => coherence::run(&typed),
        Command::Ridges(typed) => estimate::run(&*typed),
        Command::Modes(typed) => estimate::run(&*typed),
        Command::Increments(typed) => estimate::run(&*typed),
        Command::Slope(typed) => estimate::run(&*typed),
        Command::Spectrum(typed) => spectrum::run(*typed),
        Command::Budget(typed) => budget::run(*typed),
        Command::Compare(typed) => compare::run(*typed),
        Command::Inspect(typed) => inspect::run(*typed, fields),
        Command::Convert(typed) => convert::run(*typed, fields),
        Command::Filter(typed) => filter::run(*typed),
        Command::Simulate(typed) => simulate::run(*typed),
        Command::Sweep(typed) => sweep::run(*typed),
        Command::Scene(typed) => scene::run(typed),
        Command::Settings(typed) => settings::run(typed),
        Command::Contact(typed) => contact::run(typed),
        Command::Attenuate(typed) => attenuate::run(*typed),
        Command::Transmit(typed) => transmit::run(*typed),
        Command::Localize(typed) => localize::run(*typed),
        Command::Bench(typed) => bench::run(*typed),
        Command::Clean(typed) => clean::run(typed),
        Command::Completions { shell } => manual::completions(shell),
        Command::Man { page } => manual::page(page.as_deref()),
    }
}
