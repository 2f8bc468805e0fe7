//! What an analysis of one field leaves open, and the commands that answer it.

use std::path::Path;

use wavecascade::analyze::Analysis;

use crate::words::quoted;

/// Sites from which waves along x can be told apart.
const WAVES: usize = 16;

/// Questions that are left open, each with its command. `is_run`: the field carries its chain.
pub fn questions(analysis: &Analysis, is_run: bool, field: &Path) -> Vec<[String; 2]> {
    let field = quoted(&field.to_string_lossy());
    let mut open = Vec::new();
    let mut ask = |question: &str, command: String| open.push([question.to_owned(), command]);
    if is_run {
        ask(
            "where the energy goes, with a balance that closes",
            format!("cascade budget {field}"),
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
            "cascade spectrum 'shot*.npy', cascade bicoherence 'shot*.npy'".into(),
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
