//! The program: arguments, one library call, files, exit code.

mod advice;
mod analyze;
mod args;
mod attenuate;
mod bench;
mod budget;
mod chain_args;
mod compare;
mod contact;
mod effect;
mod failure;
mod filter;
mod localize;
mod manual;
mod measured;
mod parse;
mod progress;
mod saved;
mod scene;
mod scene_keys;
mod simulate;
mod sweep;
mod terminal;
mod transmit;
mod view_args;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match cli.command {
        Command::Analyze(typed) => analyze::run(*typed),
        Command::Budget(typed) => budget::run(*typed),
        Command::Compare(typed) => compare::run(*typed),
        Command::Filter(typed) => filter::run(*typed),
        Command::Simulate(typed) => simulate::run(*typed),
        Command::Sweep(typed) => sweep::run(*typed),
        Command::Scene(typed) => scene::run(typed),
        Command::Contact(typed) => contact::run(typed),
        Command::Attenuate(typed) => attenuate::run(*typed),
        Command::Transmit(typed) => transmit::run(*typed),
        Command::Localize(typed) => localize::run(*typed),
        Command::Bench(typed) => bench::run(*typed),
        Command::Completions { shell } => manual::completions(shell),
        Command::Man { page } => manual::page(page.as_deref()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
