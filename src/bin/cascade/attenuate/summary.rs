//! What `cascade attenuate` found, in words.

use wavecascade::attenuation::{AttenuationCurve, Compared, CurveRow};
use wavecascade::report::{law_sentence, reach_sentence, stop_sentence};

use super::AttenuationReport;
use crate::table::Table;
use crate::terminal::{number, paragraphs};

/// Reasons of failures that are printed; all are in the JSON.
const TOLD: usize = 3;

/// The summary for the terminal.
pub(super) fn told(found: &AttenuationReport, width: usize) -> String {
    let attenuation = &found.attenuation;
    let law = format!("law of the force, {} contacts", attenuation.kind.name());
    let mut table = Table::new("chain").words("sense");
    for name in ["ratio", "bodies", "force", "energy", "width", "high"] {
        table = table.numbers(name);
    }
    let mut table = table.words(&law);
    for curve in &attenuation.curves {
        let mut notes: Vec<String> = curve.stop.iter().map(stop_sentence).collect();
        if let (Some(reach), Some(target)) = (&curve.reach, attenuation.target) {
            notes.push(reach_sentence(reach, target));
        }
        table.noted_row(curve_cells(curve), &notes.join("; "));
    }
    let mut lines = Vec::new();
    if let Some(best) = &found.best {
        lines.push(format!(
            "least force on a wall behind {} bodies: {} at {} {}, stiffness ratio {}",
            best.bodies,
            number(best.point.relative_force),
            best.key.replace('_', " "),
            number(best.point.value),
            number(best.point.stiffness_ratio)
        ));
    }
    let beside = &found.beside;
    lines.extend(beside.measured.iter().map(|c| compared_line("measured", c)));
    let arrivals = beside.measured_arrivals.iter();
    lines.extend(arrivals.map(|c| compared_line("measured arrival", c)));
    if !beside.not_compared.is_empty() {
        let at: Vec<String> = beside.not_compared.iter().map(|at| number(*at)).collect();
        lines.push(format!(
            "measured outside the curve, and not compared: {}",
            at.join(", ")
        ));
    }
    lines.extend(without_line(
        "no measured largest velocity",
        &beside.measured_without_peak,
        "where the record begins or ends there, or nothing moves forward, there is none",
    ));
    lines.extend(without_arrival_line(&beside.measured_without_arrival));
    lines.extend(failure_lines(&attenuation.failed));
    table.text(width) + &paragraphs(&lines, width)
}

/// A warning that nothing is compared at some abscissae.
fn without_line(what: &str, at: &[f64], why: &str) -> Option<String> {
    let places: Vec<String> = at.iter().map(|at| number(*at)).collect();
    let (count, places) = (places.len(), places.join(", "));
    (count > 0).then(|| format!("warning: {what} to compare at {places} ({count} in all): {why}"))
}

/// The same of arrivals.
pub fn without_arrival_line(at: &[f64]) -> Option<String> {
    without_line(
        "no measured arrival",
        at,
        "what moves from the first sample on, measured or computed, has none",
    )
}

/// A measured point beside the computed one.
pub fn compared_line(what: &str, compared: &Compared) -> String {
    let error = match compared.measured.error {
        Some(error) => format!(" +- {}", number(error)),
        None => String::new(),
    };
    let within = match compared.in_errors {
        Some(errors) => format!(" ({} standard errors)", number(errors)),
        None => String::new(),
    };
    format!(
        "{what} at {}: {}{error}, computed {}, difference {}{within}",
        number(compared.measured.at),
        number(compared.measured.value),
        number(compared.computed),
        number(compared.difference)
    )
}

fn curve_cells(curve: &AttenuationCurve) -> Vec<String> {
    let optional = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.4}"));
    let last: Option<&CurveRow> = curve.rows.last();
    vec![
        curve.name.clone(),
        curve.sense.name().to_owned(),
        format!("{:.4}", curve.stiffness_ratio),
        last.map_or(0, |row| row.bodies).to_string(),
        optional(last.and_then(|row| row.relative_force)),
        optional(last.and_then(|row| row.relative_energy)),
        last.map_or("-".into(), |row| number(row.pulse.width.value)),
        optional(last.and_then(|row| row.high_share)),
        curve.fits.as_ref().map_or("-".to_owned(), law_sentence),
    ]
}

/// The first reasons of runs that failed.
pub fn failure_lines(failed: &[(String, String)]) -> Vec<String> {
    let told = failed.iter().take(TOLD);
    let mut lines: Vec<String> = told
        .map(|(name, why)| format!("failed: {name}: {why}"))
        .collect();
    if failed.len() > TOLD {
        lines.push(format!("failed: {} more", failed.len() - TOLD));
    }
    lines
}
