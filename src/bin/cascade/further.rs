//! What an analysis of one field leaves open, and the commands that answer it.

use std::path::Path;

use clap::{Args, Command};
use wavecascade::analyze::Analysis;

use crate::args::Input;
use crate::words::{self, quoted};

/// Sites from which waves along x can be told apart.
const WAVES: usize = 16;

/// Questions that are left open, each with its command. `is_run`: the field carries its chain.
pub fn questions(analysis: &Analysis, is_run: bool, field: &Path) -> Vec<[String; 2]> {
    let file = quoted(&field.to_string_lossy());
    let options = input_options(words::as_text());
    let field = format!("{file}{options}");
    let mut open = Vec::new();
    let mut ask = |question: &str, command: String| open.push([question.to_owned(), command]);
    if is_run {
        ask(
            "where the energy goes, with a balance that closes",
            format!("cascade budget {file}"),
        );
    }
    let waves = analysis.axes.n_sites >= WAVES && analysis.direction.is_some();
    if waves {
        ask(
            "phase and group velocity of each branch",
            format!("cascade ridges {field}"),
        );
    }
    let Some(interval) = analysis.interval.filter(|_| !is_run) else {
        return open;
    };
    if interval.factors.is_none() {
        ask(
            "how well the spectra of this transient are known, and whether its frequencies are coupled: repeated \
             records, one a file",
            format!("cascade spectrum 'shot*'{options}, cascade bicoherence 'shot*'{options}"),
        );
        return open;
    }
    ask(
        "how well each spectrum is known, and lines in it",
        format!("cascade spectrum {field}"),
    );
    if analysis.axes.n_sites > 1 {
        ask(
            "which sites move together, and how late",
            format!("cascade coherence {field}"),
        );
    }
    ask(
        "whether frequencies are coupled, and what passes between them",
        format!("cascade bicoherence {field}, cascade transfer {field} --from A --to B"),
    );
    open
}

/// The options among the words of a command that say how its field is read.
fn input_options(words: Vec<String>) -> String {
    let known = Input::augment_args(Command::new("input"));
    let mut kept = String::new();
    let mut words = words.into_iter();
    while let Some(word) = words.next() {
        let Some(name) = word.strip_prefix("--") else {
            continue;
        };
        let (name, has_value) = match name.split_once('=') {
            Some((name, _)) => (name, true),
            None => (name, false),
        };
        let found = known
            .get_arguments()
            .find(|option| option.get_long() == Some(name));
        let Some(option) = found else {
            continue;
        };
        kept += &format!(" {}", quoted(&word));
        if !has_value && option.get_action().takes_values() {
            kept.extend(words.next().map(|value| format!(" {}", quoted(&value))));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_the_input_are_kept_with_their_values() {
        let words = "cascade analyze a.npy --out b --rate 1kHz --dx=2mm --force --unit";
        let mut words: Vec<String> = words.split(' ').map(str::to_owned).collect();
        words.push("m / s".into());
        assert_eq!(input_options(words), " --rate 1kHz --dx=2mm --unit 'm / s'");
    }
}
