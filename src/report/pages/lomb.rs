//! The page of spectra by least squares.

use maud::html as markup;

use crate::estimates::{Lomb, LombAxis};
use crate::plot::{Style, lomb_chart, lomb_map};
use crate::report::page::{self, AxisData, CurveGroup, MapData, Page, Picture, Role, number};
use crate::report::{LombSummary, Provenance, percent};

const DEFINITIONS: [(&str, &str); 3] = [
    (
        "Power p",
        "Share of the variance of a record that a sine of this frequency, with a constant, explains by least \
         squares at the times that there are: 0 to 1. Nothing is interpolated.",
    ),
    (
        "Level",
        "What white noise exceeds anywhere in a record's spectrum with the stated probability (Baluev's bound).",
    ),
    (
        "Density",
        "p times the sum of squares times the mean step: the one-sided power spectral density, which for even times \
         is the periodogram.",
    ),
];

/// The page of spectra by least squares of a field with this name.
///
/// # Errors
/// None for results of this library.
pub fn lomb_html(
    found: &Lomb,
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let mut rows: Vec<Vec<Picture>> = Vec::new();
    if let Some(map) = lomb_map(found) {
        let axes = [
            AxisData::new(&map.x_label, (map.x.start, map.x.end), Role::Position),
            AxisData::new(&map.y_label, (map.y.start, map.y.end), Role::Frequency),
        ];
        let shows = "Share of each site's variance that a sine explains, by frequency.";
        let map = MapData::spectrum(
            ("power".into(), "Power p(f, x)".into()),
            shows.into(),
            axes,
            &map.label,
            map.values.view(),
        );
        rows.push(vec![map.into()]);
    }
    rows.push(vec![
        CurveGroup::of_chart("chart", "", &lomb_chart(found)).into(),
    ]);
    let significant = found.significant();
    let answer = match found.axis {
        LombAxis::Time => format!(
            "{significant} of {} records have a power above the level, {} would of white noise",
            found.samples.len(),
            percent(found.alpha)
        ),
        LombAxis::Space => format!(
            "Profiles at {} times are averaged; no level is stated.",
            found.averaged
        ),
    };
    let unit = match found.axis {
        LombAxis::Time => found.time.unit.clone(),
        LombAxis::Space => found.space.unit.clone(),
    };
    let unit = unit.unwrap_or_default();
    let table = page::table(
        "Sampling",
        &[
            ("samples that are missing", found.missing.to_string()),
            (
                "shortest step",
                format!("{} {unit}", number(found.steps[0])),
            ),
            ("longest step", format!("{} {unit}", number(found.steps[1]))),
            ("mean step", format!("{} {unit}", number(found.steps[2]))),
            ("frequencies", found.frequency.len().to_string()),
        ],
    );
    let json = LombSummary::new(found, provenance).to_json()?;
    let page = Page {
        title: format!("Spectra of {name} by least squares"),
        sentence: format!(
            "At the samples that there are; frequencies in {}",
            found.unit()
        ),
        answers: page::answer("Is there a sine in the records?", answer),
        warnings: page::warnings(
            &warnings
                .iter()
                .map(|[message, advice]| (message.clone(), Some(advice.clone())))
                .collect::<Vec<_>>(),
        ),
        rows,
        rest: markup! {
            (page::numbers(table))
            (page::how_to_read(&DEFINITIONS))
            (page::folded("summary", "Summary", markup! { pre { (json) } }))
        },
        style: *style,
    };
    Ok(page.html())
}
