//! Shell completions and man pages, made from the arguments themselves.

use clap::CommandFactory;
use clap::error::ErrorKind;
use clap_complete::Shell;

use crate::args::Cli;
use crate::prelude::*;

/// Prints completions for `shell`.
pub fn completions(shell: Shell) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "cascade", &mut text);
    Ok(std::io::stdout().write_all(&text)?)
}

/// Prints the man page of the program, or of one of its commands.
pub fn page(name: Option<&str>) -> Result<(), Failure> {
    let mut all = Cli::command();
    all.build();
    let command = match name {
        None => all,
        Some(name) => match all.find_subcommand(name) {
            Some(command) => command.clone(),
            None => {
                let known: Vec<&str> = all.get_subcommands().map(|c| c.get_name()).collect();
                let message = format!("expected one of {}, found {name}", known.join(", "));
                all.error(ErrorKind::InvalidSubcommand, message).exit()
            }
        },
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(command).render(&mut text)?;
    Ok(std::io::stdout().write_all(&text)?)
}
