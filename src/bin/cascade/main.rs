// The program: arguments, one library call, files, exit code.

mod advice;
// The allocator of a process is the choice of its program, not of an extension.
#[cfg(not(feature = "python"))]
mod allocator;
mod analyze;
mod args;
mod attenuate;
mod budget;
mod chain_args;
mod compare;
mod convert;
mod described;
mod design;
mod dispersion;
mod estimates;
mod examples;
mod failure;
mod fields;
mod figure_args;
mod filter;
mod fit;
mod further;
mod gone;
mod help;
mod inspect;
mod localize;
mod manual;
mod measured;
mod parse;
mod picture;
mod plan;
mod prelude;
mod present;
mod progress;
mod scan_args;
mod scene;
mod scene_keys;
mod show_args;
mod simulate;
mod summary;
mod sweep;
mod table;
mod terminal;
mod text;
mod triads;
mod view_args;
mod words;

/// The same program as an extension module of Python, with functions on arrays.
#[cfg(feature = "python")]
#[path = "../../../python/src/module.rs"]
mod python;

use args::{Cli, Command};
use failure::Failure;

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
    wavecascade_system::memory::return_large_memory();
    match run(gone::parsed(words::typed())) {
        Ok(()) => 0,
        Err(failure) => failure.report(),
    }
}

fn run(cli: Cli) -> Result<(), Failure> {
    progress::end_after(cli.max_time);
    match cli.command {
        Command::Analyze(typed) => analyze::run(&typed),
        Command::Estimate(typed) => typed.run(),
        Command::Inspect(typed) => inspect::run(&typed),
        Command::Convert(typed) => convert::run(&typed),
        Command::Filter(typed) => filter::run(*typed),
        Command::Simulate(typed) => simulate::run(*typed),
        Command::Sweep(typed) => sweep::run(*typed),
        Command::Scene(typed) => scene::run(typed),
        Command::Examples(typed) => examples::run(typed),
        Command::Completions { shell } => manual::completions(shell),
        Command::Man { page } => manual::page(page.as_deref()),
        command => {
            let described = command.described();
            described.map_or(Ok(()), |(command, result)| described::run(command, result))
        }
    }
}
