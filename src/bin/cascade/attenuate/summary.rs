//! What `cascade attenuate` found, in words.

use wavecascade::attenuation::{
    AttenuationCurve, AttenuationLaw, Compared, CurveRow, Reach, Stop, StopCause,
};

use super::AttenuationReport;
use crate::terminal::number;

/// Reasons of failures that are printed; all are in the JSON.
const TOLD: usize = 3;

/// The summary for the terminal.
pub(super) fn told(found: &AttenuationReport) -> String {
    let attenuation = found.attenuation;
    let mut lines = vec![format!(
        "{:<22} {:<6} {:>8} {:>7} {:>8} {:>8} {:>9} {:>7}  law of the force, {} contacts",
        "chain",
        "sense",
        "ratio",
        "bodies",
        "force",
        "energy",
        "width",
        "high",
        attenuation.kind.name()
    )];
    for curve in &attenuation.curves {
        lines.push(curve_line(curve));
        lines.extend(curve.stop.as_ref().map(stop_line));
        if let (Some(reach), Some(target)) = (&curve.reach, attenuation.target) {
            lines.push(format!("  {}", reach_line(reach, target)));
        }
    }
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
    lines.push(String::new());
    lines.join("\n")
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

fn curve_line(curve: &AttenuationCurve) -> String {
    let optional = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.4}"));
    let last: Option<&CurveRow> = curve.rows.last();
    let law = curve.fits.as_ref().map_or("-".to_owned(), |fits| {
        let chosen = fits.chosen();
        let parameters = chosen.parameters.iter().map(|p| {
            format!(
                "{} = {} ({} to {})",
                p.name,
                number(p.value),
                number(p.low),
                number(p.high)
            )
        });
        format!(
            "{}: {}",
            law_name(chosen.law),
            parameters.collect::<Vec<_>>().join(", ")
        )
    });
    format!(
        "{:<22} {:<6} {:>8} {:>7} {:>8} {:>8} {:>9} {:>7}  {law}",
        curve.name,
        curve.sense.name(),
        format!("{:.4}", curve.stiffness_ratio),
        last.map_or(0, |row| row.bodies),
        optional(last.and_then(|row| row.relative_force)),
        optional(last.and_then(|row| row.relative_energy)),
        last.map_or("-".into(), |row| number(row.pulse.width.value)),
        optional(last.and_then(|row| row.high_share)),
    )
}

fn stop_line(stop: &Stop) -> String {
    let why = match stop.cause {
        StopCause::Reflection => "a reflection would enter there before the pulse is whole",
        StopCause::Faded => "the pulse has faded before the end of the chain",
        StopCause::Failed => "its run failed",
    };
    format!("  stops at {} bodies: {why}", stop.bodies)
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

fn law_name(law: AttenuationLaw) -> &'static str {
    match law {
        AttenuationLaw::Level => "c",
        AttenuationLaw::Exponential => "a exp(-r n)",
        AttenuationLaw::PowerLaw => "a n^-p",
        AttenuationLaw::Plateau => "c + a exp(-r n)",
    }
}

fn reach_line(reach: &Reach, target: f64) -> String {
    match reach {
        Reach::Within { bodies } => format!("at {target} or below from {bodies} bodies on"),
        Reach::Beyond { law, length } => format!(
            "beyond the curve: {} is at {target} after {} bodies ({} to {})",
            law_name(*law),
            number(length.value),
            number(length.low),
            number(length.high)
        ),
        Reach::Never { law, settles_at } => format!(
            "never at {target}: {} settles at {}",
            law_name(*law),
            number(*settles_at)
        ),
        Reach::Unknown => format!("{target} is not reached, and no law says where it would be"),
    }
}
