//! Commands that there are no more, with what takes their place.

use std::ffi::OsString;

use clap::Parser;
use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::args::Cli;

const GONE: [(&str, &str); 7] = [
    (
        "clean",
        "the next run that writes to a folder removes what killed ones left there",
    ),
    (
        "contact",
        "`cascade scene --check` prints the coefficients of a chain",
    ),
    (
        "lomb",
        "`--resample` makes coordinates even; astropy has spectra by least squares",
    ),
    (
        "settings",
        "keep options in a script; `summary.json` holds the command line",
    ),
    (
        "transfer",
        "`cascade bicoherence --site FROM --transfer TO`",
    ),
    ("transmit", "`cascade attenuate --against KEY=VALUES`"),
    (
        "bench",
        "`cargo run --release --locked -p throughput` in a checkout",
    ),
];

/// The command that was typed; help, version and words that are none end the program.
pub fn parsed(words: Vec<OsString>) -> Cli {
    Cli::try_parse_from(words).unwrap_or_else(|mut error| {
        if error.kind() == ErrorKind::InvalidSubcommand
            && let Some(ContextValue::String(name)) = error.get(ContextKind::InvalidSubcommand)
            && let Some((_, instead)) = GONE.iter().find(|(gone, _)| gone == name)
        {
            let tip = StyledStr::from(format!("it is no command any more: {instead}"));
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip]));
        }
        error.exit()
    })
}
