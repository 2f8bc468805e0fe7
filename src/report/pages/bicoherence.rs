//! The page of a bicoherence.

use maud::html as markup;

use crate::estimates::{Bicoherence, Transfer};
use crate::plot::{
    HeatChart, Style, bicoherence_along_map, bicoherence_by_output, bicoherence_map,
};
use crate::report::page::{self, AxisData, CurveGroup, MapData, Page, Picture, Role, number};
use crate::report::pages::transfer;
use crate::report::{BicoherenceSummary, Provenance, percent};

const DEFINITIONS: [(&str, &str); 5] = [
    (
        "Bicoherence b²",
        "|⟨X₁X₂X₃*⟩|² / (⟨|X₁X₂|²⟩ ⟨|X₃|²⟩) at the frequencies f₁, f₂ and f₃ = f₁ + f₂, 0 to 1: the share of the \
         power at f₃ whose phase follows the sum of the phases at f₁ and f₂.",
    ),
    (
        "What it does not say",
        "Which of the three frequencies feeds which. A transfer towards high frequency needs its growth along x, \
         an estimate of the transfer between two sites, or a budget.",
    ),
    (
        "Levels",
        "Without coupling one cell exceeds the level of one cell with the stated probability, and any cell of the \
         whole map the level of the map (corrected for the number of cells by Sidak).",
    ),
    (
        "Biphase",
        "The phase of ⟨X₁X₂X₃*⟩: 0 or 180 degrees where crests are peaked or flat, ±90 degrees where one flank is steep.",
    ),
    (
        "Independent realisations",
        "Segments and records that are averaged, less what overlapping segments share. The segments of a transient \
         are not independent: then the records alone count. Repeated pulses of the same shape are coupled at all frequencies.",
    ),
];

/// The page of a bicoherence of a field with this name, with a transfer if there is one.
///
/// # Errors
/// None for results of this library.
pub fn bicoherence_html(
    (found, transfer): (&Bicoherence, Option<&Transfer>),
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let (time_unit, space_unit) = found.units();
    let data = |map: HeatChart, [id, title, shows]: [&str; 3], x: Role| {
        let axes = [
            AxisData::new(&map.x_label, (map.x.start, map.x.end), x),
            AxisData::new(&map.y_label, (map.y.start, map.y.end), Role::Frequency),
        ];
        MapData::spectrum(
            (id.into(), title.into()),
            shows.into(),
            axes,
            &map.label,
            map.values.view(),
        )
        .linear()
        .with_range(Some([0.0, map.scale.end]))
    };
    let words = [
        "bicoherence",
        "Bicoherence b²(f₁, f₂)",
        "Which frequencies are coupled with their sum.",
    ];
    let mut rows: Vec<Vec<Picture>> = vec![vec![
        data(bicoherence_map(found), words, Role::Frequency).into(),
    ]];
    let chart = bicoherence_by_output(found);
    rows.push(vec![CurveGroup::of_chart("by-output", "", &chart).into()]);
    if let Some(map) = bicoherence_along_map(found) {
        let words = [
            "along",
            "Along x",
            "The largest bicoherence of all pairs with the sum f₃, at each site.",
        ];
        rows.push(vec![data(map, words, Role::Position).into()]);
    }
    rows.extend(transfer.into_iter().flat_map(transfer::pictures));
    let independence = &found.independence;
    let level = |level: Option<f64>| match level {
        Some(level) => format!("{} at {}", number(level), percent(found.alpha)),
        None => "not stated: fewer than two independent realisations".into(),
    };
    let json = BicoherenceSummary::new(found, transfer, provenance).to_json()?;
    let table = page::table(
        "Averages",
        &[
            ("records", independence.records.to_string()),
            ("segments of a record", independence.segments.to_string()),
            ("samples a segment", found.segment[0].to_string()),
            ("effective realisations", number(independence.effective)),
            ("triples of frequencies", found.cells().to_string()),
            ("level of one cell", level(found.cell_level())),
            ("level of the map", level(found.map_level())),
        ],
    );
    let mut definitions = DEFINITIONS.to_vec();
    if transfer.is_some() {
        definitions.extend(transfer::DEFINITIONS);
    }
    let page = Page {
        title: format!("Bicoherence of {name}"),
        sentence: format!(
            "Two frequencies of site {} at {} {space_unit} with their sum at site {}, times in {time_unit}",
            found.site,
            number(found.space.at(found.site)),
            found.output,
        ),
        answers: page::answer("Which frequencies are coupled?", found.coupling()),
        warnings: page::warnings(
            &warnings
                .iter()
                .map(|[message, advice]| (message.clone(), Some(advice.clone())))
                .collect::<Vec<_>>(),
        ),
        rows,
        rest: markup! {
            (page::numbers(markup! { (table) @if let Some(found) = transfer { (transfer::numbers(found)) } }))
            (page::how_to_read(&definitions))
            (page::folded("summary", "Summary", markup! { pre { (json) } }))
        },
        style: *style,
    };
    Ok(page.html())
}
