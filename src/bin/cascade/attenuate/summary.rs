//! What `cascade attenuate` found, in words.

use wavecascade::attenuation::{AttenuationCurve, Compared, CurveRow, Reach};
use wavecascade::chain::scene::Units;
use wavecascade::report::{law_sentence, reach_sentence, stop_sentence};

use super::AttenuationReport;
use crate::summary::Summary;
use crate::table::Table;
use crate::terminal::number;

/// Reasons of failures that are printed; all are in the JSON.
const TOLD: usize = 3;

/// The summary for the terminal.
pub(super) fn told(subject: &str, found: &AttenuationReport) -> Summary {
    let attenuation = &found.attenuation;
    let mut summary = Summary::new(subject, &answer(found));
    if let Some(best) = &found.best {
        summary.sentence(&format!(
            "least force on a wall behind {} bodies: {} at {} {}, stiffness ratio {}",
            best.bodies,
            number(best.point.relative_force),
            best.key.replace('_', " "),
            number(best.point.value),
            number(best.point.stiffness_ratio)
        ));
    }
    let mut table = Table::new("chain").words("sense");
    for name in ["ratio", "bodies", "force", "energy", "width", "high"] {
        table = table.numbers(name);
    }
    for curve in &attenuation.curves {
        table.row(curve_cells(curve));
    }
    summary.rows(table);
    for curve in &attenuation.curves {
        let name = format!("{}, {}", curve.name, curve.sense.name());
        if let Some(stop) = &curve.stop {
            summary.sentence(&format!("{name}: {}", stop_sentence(stop)));
        }
        if let (Some(reach), Some(target)) = (&curve.reach, attenuation.target) {
            summary.sentence(&format!("{name}: {}", reach_sentence(reach, target)));
        }
    }
    let beside = &found.beside;
    let compared = beside.measured.iter().map(|c| compared_line("measured", c));
    let arrivals = beside.measured_arrivals.iter();
    let arrivals = arrivals.map(|c| compared_line("measured arrival", c));
    compared
        .chain(arrivals)
        .for_each(|line| summary.sentence(&line));
    if !beside.not_compared.is_empty() {
        let at: Vec<String> = beside.not_compared.iter().map(|at| number(*at)).collect();
        summary.sentence(&format!(
            "measured outside the curve, and not compared: {}",
            at.join(", ")
        ));
    }
    for [message, why] in [
        without_line(
            "no measured largest velocity",
            &beside.measured_without_peak,
            "where the record begins or ends there, or nothing moves forward, there is none",
        ),
        without_arrival_line(&beside.measured_without_arrival),
    ]
    .into_iter()
    .flatten()
    {
        summary.warning(&message, &why);
    }
    failure_lines(&attenuation.failed)
        .iter()
        .for_each(|line| summary.sentence(line));
    let kind = attenuation.kind.name();
    for curve in &attenuation.curves {
        if let Some(fits) = &curve.fits {
            let name = format!("{}, {}", curve.name, curve.sense.name());
            summary.detailed_sentence(&format!(
                "law of the force, {kind} contacts, {name}: {}",
                law_sentence(fits)
            ));
        }
    }
    summary
}

/// What the first chain that attenuates lets through, or the length that reaches the target.
fn answer(found: &AttenuationReport) -> String {
    let attenuation = &found.attenuation;
    let curves = &attenuation.curves;
    if let Some(target) = attenuation.target {
        let reached = |curve: &&AttenuationCurve| match curve.reach {
            Some(Reach::Within { bodies }) => bodies,
            _ => usize::MAX,
        };
        let first = curves.iter().filter(|curve| curve.reach.is_some());
        if let Some(curve) = first.min_by_key(reached)
            && let Some(reach) = &curve.reach
        {
            let what = reach_sentence(reach, target);
            return format!("{} ({}): {what}", curve.name, curve.sense.name());
        }
    }
    let forces = curves.iter().filter_map(|curve| {
        let known = curve.rows.iter().rev();
        let (bodies, force) = known
            .filter_map(|row| Some((row.bodies, row.relative_force?)))
            .next()?;
        Some((curve, bodies, force))
    });
    match forces.min_by(|a, b| a.2.total_cmp(&b.2)) {
        Some((curve, bodies, force)) => format!(
            "{} has {:.1} % of the force of the homogeneous chain after {bodies} bodies ({})",
            curve.name,
            100.0 * force,
            curve.sense.name()
        ),
        None => "no chain has a pulse".into(),
    }
}

/// A warning that nothing is compared at some abscissae.
fn without_line(what: &str, at: &[f64], why: &str) -> Option<[String; 2]> {
    let places: Vec<String> = at.iter().map(|at| number(*at)).collect();
    let (count, places) = (places.len(), places.join(", "));
    (count > 0).then(|| {
        [
            format!("{what} to compare at {places} ({count} in all)"),
            why.to_owned(),
        ]
    })
}

/// The same of arrivals.
pub fn without_arrival_line(at: &[f64]) -> Option<[String; 2]> {
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
        last.map_or("-".into(), |row| {
            let unit = if curve.units == Units::Si { " s" } else { "" };
            format!("{}{unit}", number(row.pulse.width.value))
        }),
        optional(last.and_then(|row| row.high_share)),
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
