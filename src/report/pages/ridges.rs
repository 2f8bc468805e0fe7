//! The page of ridges.

use maud::html as markup;

use crate::plot::labels::{self, Side};
use crate::plot::{Style, ridge_charts};
use crate::report::page::{self, CurveGroup, MapData, Page, Picture, Role, number};
use crate::report::{Provenance, RidgesSummary, percent};
use crate::ridges::Ridges;

const DEFINITIONS: [(&str, &str); 5] = [
    (
        "Ridge",
        "A row of peaks of S(k, f): along k at each frequency where a branch is steep, along f at each wavenumber \
         where it is flat. Peaks stand above the level, above what stronger waves leak, and apart from them.",
    ),
    (
        "Level",
        "The power over the mean of the noise about it that noise exceeds anywhere in the spectrum with the \
         stated probability; the noise is the local median.",
    ),
    (
        "Place",
        "The top of the parabola through the logarithms of three bins, corrected for the window; of a broad \
         ridge its centre above half of the maximum. Its error is that of noise, or the spread about neighbouring \
         points.",
    ),
    ("Phase velocity", "2πf/k, positive towards +x."),
    (
        "Group velocity",
        "2π df/dk, of a parabola through the points about it, by least squares.",
    ),
];

/// The page of the ridges of a field with this name.
///
/// # Errors
/// None for results of this library.
pub fn ridges_html(
    found: &Ridges,
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let analysis = &found.analysis;
    let second = labels::wavenumber_reading(&analysis.axes);
    let mut rows: Vec<Vec<Picture>> = Vec::new();
    if let Some(map) = &analysis.spacetime_map {
        let shows = "Power by wavenumber and frequency; positive wavenumbers travel towards +x.";
        let roles = (Role::Wavenumber, Role::Frequency);
        let sides = [Side::SignedWavenumber, Side::Frequency];
        let map = MapData::of(
            map,
            "spacetime",
            "Space-time spectrum S(k, f)",
            shows,
            roles,
        )
        .limited(labels::not_shown(analysis, &sides, true))
        .with_dispersion(&analysis.dispersion)
        .annotated(None, None, &second);
        rows.push(vec![map.into()]);
    }
    for (i, chart) in ridge_charts(found).iter().enumerate() {
        rows.push(vec![
            CurveGroup::of_chart(&format!("chart-{i}"), "", chart).into(),
        ]);
    }
    let json = RidgesSummary::new(found, provenance).to_json()?;
    let conventions = &analysis.conventions;
    let (time_unit, space_unit) = (analysis.axes.time_unit(), analysis.axes.space_unit());
    let table = page::table(
        "Spectrum",
        &[
            ("records", found.records.to_string()),
            ("segments of a record", conventions.segments.to_string()),
            ("samples a segment", conventions.segment.to_string()),
            ("effective realisations", number(found.realisations)),
            (
                "level over the noise",
                match found.is_single() {
                    true => format!("{}: {}", number(found.level), found.independence.why()),
                    false => format!("{} at {}", number(found.level), percent(found.alpha)),
                },
            ),
            (
                "bin of frequency",
                format!(
                    "{} {}",
                    number(found.bins[0]),
                    analysis.axes.frequency_unit()
                ),
            ),
            (
                "bin of wavenumber",
                format!(
                    "{} {}",
                    number(found.bins[1]),
                    analysis.axes.wavenumber_unit()
                ),
            ),
        ],
    );
    let points = found.points().count();
    let answer = match found.branches() {
        0 => "No ridge stands above the noise.".to_owned(),
        branches => format!(
            "{branches} branches in {} ridges, {points} points.",
            found.ridges.len()
        ),
    };
    let fits: Vec<Vec<String>> = found
        .fits
        .iter()
        .flat_map(|fit| {
            fit.parameters.iter().map(|parameter| {
                vec![
                    fit.name.clone(),
                    parameter.name.clone(),
                    number(parameter.value),
                    number(parameter.error),
                    number(fit.deviation),
                    number(fit.reduced),
                ]
            })
        })
        .collect();
    let head = [
        "law",
        "parameter",
        "value",
        "standard error",
        "deviation (bins)",
        "reduced χ²",
    ];
    let fits = (!fits.is_empty()).then(|| page::grid("Fitted laws", &head, &fits));
    let page = Page {
        title: format!("Dispersion of {name}"),
        sentence: format!("Ridges of S(k, f); times in {time_unit}, lengths in {space_unit}"),
        answers: page::answer("Which branches does the spectrum show?", answer),
        warnings: page::warnings(
            &warnings
                .iter()
                .map(|[message, advice]| (message.clone(), Some(advice.clone())))
                .collect::<Vec<_>>(),
        ),
        rows,
        rest: markup! {
            (page::numbers(markup! { (table) @if let Some(fits) = fits { (fits) } }))
            (page::how_to_read(&DEFINITIONS))
            (page::folded("summary", "Summary", markup! { pre { (json) } }))
        },
        style: *style,
    };
    Ok(page.html())
}
