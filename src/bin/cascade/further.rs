//! What an analysis of one field leaves open, and the commands that answer it.

use std::path::Path;

use wavecascade::analyze::Analysis;

use crate::words::quoted;

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
        let open = open.join(", ");
        format!("{open} -> cascade COMMAND {file}, with the options of its axes")
    });
    let of_shots = (interval.is_some() && !is_steady).then(|| {
        "of repeated records: intervals (spectrum), coupled frequencies (bicoherence)".to_owned()
    });
    let all: Vec<String> = of_field.into_iter().chain(of_shots).collect();
    (!all.is_empty()).then(|| all.join("; "))
}
