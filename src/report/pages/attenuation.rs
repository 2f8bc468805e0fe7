//! Pages of attenuation against length and of transmission against a key.

use maud::{Markup, html as markup};

use crate::attenuation::{Attenuation, AttenuationCurve, Transmission, TransmissionCurve};
use crate::chain::scene::Units;
use crate::plot::{Chart, Look, Overlay, Style, attenuation_charts, transmission_charts};
use crate::report::page::{self, CurveGroup, Page, Picture, number};
use crate::report::{law_sentence, reach_sentence, stop_sentence};

const DEFINITIONS: [(&str, &str); 6] = [
    (
        "Force",
        "The largest force of the pulse, over that in the same place of the homogeneous chain.",
    ),
    (
        "One long chain, wall",
        "At the contacts of one chain that the pulse runs along; or on the wall behind chains of \
         every length.",
    ),
    (
        "Energy",
        "Passed through the contact by the pulse, over that of the homogeneous chain.",
    ),
    (
        "High",
        "Share of the energy passed that lies above the band edge.",
    ),
    ("Width", "Of the force at half of its largest value."),
    (
        "Law",
        "Fitted to the forces in the compared contacts, with 95 % intervals: a level, an exponential, \
         a power law, or an exponential that settles.",
    ),
];

/// The page of attenuation curves.
pub fn attenuation_html(attenuation: &Attenuation, overlay: Overlay) -> String {
    let page = Page {
        title: "Attenuation against length".into(),
        sentence: format!(
            "{} of a struck chain followed over {} bodies, {} contacts compared",
            "The pulse",
            attenuation.length,
            attenuation.kind.name()
        ),
        answers: attenuation_answers(attenuation),
        warnings: page::warnings(&failures(&attenuation.failed)),
        rows: rows(
            &attenuation_charts(attenuation, overlay),
            "Dashed: the law that fits best.",
        ),
        rest: markup! {
            (page::numbers(attenuation_table(attenuation)))
            (page::how_to_read(&DEFINITIONS))
        },
        style: Style::default(),
    };
    page.html()
}

fn attenuation_answers(attenuation: &Attenuation) -> Markup {
    let left = attenuation.curves.iter().filter_map(|curve| {
        let row = curve.rows.iter().rev();
        let last = row.into_iter().find(|row| row.relative_force.is_some())?;
        let text = format!(
            "{} of the homogeneous chain's after {} bodies",
            number(last.relative_force?),
            last.bodies
        );
        Some((named(curve), text))
    });
    let reached = attenuation.curves.iter().filter_map(|curve| {
        let reach = curve.reach.as_ref()?;
        Some((named(curve), reach_sentence(reach, attenuation.target?)))
    });
    markup! {
        (page::answers("How much of the force is left?", left.collect()))
        (page::answers("How long must the structure be?", reached.collect()))
    }
}

fn named(curve: &AttenuationCurve) -> String {
    format!("{}, {}", curve.name, curve.sense.name())
}

fn attenuation_table(attenuation: &Attenuation) -> Markup {
    let head = [
        "chain", "sense", "ratio", "bodies", "force", "energy", "width", "high", "law", "end",
    ];
    let optional = |value: Option<f64>| value.map_or("–".into(), number);
    let rows = attenuation.curves.iter().map(|curve| {
        let last = curve.rows.last();
        vec![
            curve.name.clone(),
            curve.sense.name().into(),
            number(curve.stiffness_ratio),
            last.map_or("0".into(), |row| row.bodies.to_string()),
            optional(last.and_then(|row| row.relative_force)),
            optional(last.and_then(|row| row.relative_energy)),
            last.map_or("–".into(), |row| {
                let unit = if curve.units == Units::Si { " s" } else { "" };
                format!("{}{unit}", number(row.pulse.width.value))
            }),
            optional(last.and_then(|row| row.high_share)),
            curve.fits.as_ref().map_or("–".into(), law_sentence),
            curve.stop.as_ref().map_or(String::new(), stop_sentence),
        ]
    });
    page::grid(
        "Curves at their last point",
        &head,
        &rows.collect::<Vec<_>>(),
    )
}

/// The page of transmission curves.
pub fn transmission_html(transmission: &Transmission, overlay: Overlay) -> String {
    let key = transmission.key.replace('_', " ");
    let curves = transmission.curves.iter();
    let least = curves.clone().filter_map(|curve| {
        let least = curve.least()?;
        let text = format!(
            "{} of the homogeneous chain's, at {key} {}",
            number(least.relative_force),
            number(least.value)
        );
        Some((settings(curve), text))
    });
    let localized = curves.filter_map(|curve| {
        let marks = curve.localized.iter();
        let named: Vec<String> = marks
            .map(|mark| format!("{} (order {})", number(mark.value), mark.order))
            .collect();
        (!named.is_empty()).then(|| (settings(curve), named.join(", ")))
    });
    let page = Page {
        title: format!("Transmission against {key}"),
        sentence: "The pulse at the wall behind a struck chain".into(),
        answers: markup! {
            (page::answers(&format!("Which {key} passes least force?"), least.collect()))
            (page::answers(&format!("At which {key} do localized waves travel?"), localized.collect()))
        },
        warnings: page::warnings(&failures(&transmission.failed)),
        rows: rows(&transmission_charts(transmission, overlay), ""),
        rest: markup! {
            (page::numbers(markup! {
                @for curve in &transmission.curves { (transmission_table(&key, curve)) }
            }))
            (page::how_to_read(&DEFINITIONS[..1]))
        },
        style: Style::default(),
    };
    page.html()
}

fn settings(curve: &TransmissionCurve) -> String {
    let settings = curve.settings.iter();
    let named = settings.map(|(key, text)| format!("{} {text}", key.replace('_', " ")));
    named.collect::<Vec<_>>().join(", ")
}

fn transmission_table(key: &str, curve: &TransmissionCurve) -> Markup {
    let head = [key, "ratio", "force", "time of flight", "mean speed", "row"];
    let points = curve.points.iter().map(|point| (point, String::new()));
    let extremes = curve.extremes.iter().map(|extreme| {
        let kind = if extreme.is_maximum {
            "maximum"
        } else {
            "minimum"
        };
        (
            &extreme.point,
            format!("{kind}, located to {}", number(extreme.value_error)),
        )
    });
    let mut all: Vec<_> = points.chain(extremes).collect();
    all.sort_by(|a, b| a.0.value.total_cmp(&b.0.value));
    let rows = all.into_iter().map(|(point, note)| {
        vec![
            number(point.value),
            number(point.stiffness_ratio),
            number(point.relative_force),
            number(point.time_of_flight.value),
            number(point.mean_speed),
            note,
        ]
    });
    page::grid(&settings(curve), &head, &rows.collect::<Vec<_>>())
}

/// One chart a row; those with dashed curves carry the caption that names them.
fn rows(charts: &[Chart], dashed: &str) -> Vec<Vec<Picture>> {
    let groups = charts.iter().enumerate().map(|(n, chart)| {
        let has_dashes = chart
            .series
            .iter()
            .any(|series| series.look == Look::Dashed);
        let caption = if has_dashes { dashed } else { "" };
        vec![CurveGroup::of_chart(&format!("chart-{}", n + 1), caption, chart).into()]
    });
    groups.collect()
}

/// Chains whose run failed, and why.
fn failures(failed: &[(String, String)]) -> Vec<(String, Option<String>)> {
    let failed = failed.iter();
    failed
        .map(|(name, why)| (format!("{name} failed: {why}"), None))
        .collect()
}
