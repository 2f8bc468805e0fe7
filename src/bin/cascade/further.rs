//! What an analysis of one field leaves open, and the commands that answer it.

use clap::{Arg, Command};
use wavecascade::analyze::Analysis;

use crate::prelude::*;
use crate::words::{self, quoted};

/// Sites from which waves along x can be told apart.
const WAVES: usize = 16;

/// What is left open, with the commands that answer it. `is_run`: the field carries its chain.
pub fn sentence(analysis: &Analysis, is_run: bool, field: &Path) -> Option<String> {
    let mut open = Vec::new();
    let waves = analysis.axes.n_sites >= WAVES && analysis.direction.is_some();
    let interval = analysis.interval.filter(|_| !is_run);
    let is_steady = interval.is_some_and(|interval| interval.factors.is_some());
    if is_steady {
        open.push("intervals and lines (spectrum)");
        if analysis.axes.n_sites > 1 {
            open.push("delays (coherence)");
        }
        open.push("coupled frequencies (bicoherence)");
    }
    if waves {
        open.push(match is_steady {
            true => "dispersion (ridges, spectrum --along both)",
            false => "dispersion (ridges)",
        });
    }
    if is_run {
        open.push("exact balances of energy (budget)");
    }
    let of_field = (!open.is_empty()).then(|| {
        let file = quoted(&field.to_string_lossy());
        let options = input_options(&words::as_text());
        format!("{} -> cascade COMMAND {file}{options}", open.join(", "))
    });
    let of_shots = (interval.is_some() && !is_steady).then(|| {
        "of repeated records: intervals (spectrum), coupled frequencies (bicoherence)".to_owned()
    });
    let all: Vec<String> = of_field.into_iter().chain(of_shots).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// The options among the words of a command that say how its field is read.
pub fn input_options(words: &[String]) -> String {
    let known = Input::augment_args(Command::new("input"));
    let mut kept = String::new();
    let mut words = words.iter();
    while let Some(word) = words.next() {
        let Some(name) = word.strip_prefix("--") else {
            continue;
        };
        let (name, has_value) = match name.split_once('=') {
            Some((name, _)) => (name, true),
            None => (name, false),
        };
        let is_it = |option: &&Arg| {
            let aliases = option.get_all_aliases().unwrap_or_default();
            option.get_long() == Some(name) || aliases.contains(&name)
        };
        let found = known.get_arguments().find(is_it);
        let Some(option) = found else {
            continue;
        };
        kept += &format!(" {}", quoted(word));
        if !has_value && option.get_action().takes_values() {
            kept.extend(words.next().map(|value| format!(" {}", quoted(value))));
        }
    }
    kept
}
