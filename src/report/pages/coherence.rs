//! The page of a coherence.

use maud::html as markup;

use crate::estimates::Coherence;
use crate::plot::{Style, coherence_by_frequency, coherence_charts, coherence_map};
use crate::report::page::{self, AxisData, CurveGroup, MapData, Page, Picture, Role, number};
use crate::report::{CoherenceSummary, Provenance, percent};

const DEFINITIONS: [(&str, &str); 5] = [
    (
        "Coherence γ²",
        "Share of a site's power at a frequency that follows the reference linearly: |S_rj|² / (S_rr S_jj) of \
         averaged cross-spectra, 0 to 1.",
    ),
    (
        "Level",
        "What one cell exceeds by chance with the stated probability where the true coherence is 0. Of many \
         cells, that share exceeds it.",
    ),
    (
        "Delay",
        "By how much a site follows the reference, over all coherent frequencies; positive behind it. Its error \
         assumes that records differ by a delay and independent noise.",
    ),
    (
        "Phase velocity",
        "2πf/k, with k from the phases of the sites around the reference up to the first whose \
         phase is not known to 45 degrees; positive for waves towards +x. Sites must be less than half a wavelength apart.",
    ),
    (
        "Independent realisations",
        "Segments, tapers and records that are averaged, less what overlapping segments share. The segments \
         of a transient are not independent: then the records alone count.",
    ),
];

/// The page of a coherence of a field with this name.
///
/// # Errors
/// None for results of this library.
pub fn coherence_html(
    found: &Coherence,
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let (time_unit, space_unit) = found.units();
    let map = coherence_map(found);
    let axes = [
        AxisData::new(&map.x_label, (map.x.start, map.x.end), Role::Position),
        AxisData::new(&map.y_label, (map.y.start, map.y.end), Role::Frequency),
    ];
    let shows = "How much of each site's power follows the reference, by frequency.";
    let map = MapData::spectrum(
        ("coherence".into(), "Coherence γ²(f, x)".into()),
        shows.into(),
        axes,
        &map.label,
        map.values.view(),
    )
    .linear()
    .with_range(Some([0.0, 1.0]));
    let mut rows: Vec<Vec<Picture>> = vec![vec![map.into()]];
    let charts = [coherence_by_frequency(found)];
    for (i, chart) in charts
        .into_iter()
        .chain(coherence_charts(found))
        .enumerate()
    {
        rows.push(vec![
            CurveGroup::of_chart(&format!("chart-{i}"), "", &chart).into(),
        ]);
    }
    let independence = &found.independence;
    let level = match found.level() {
        Some(level) => format!("{} at {}", number(level), percent(found.alpha)),
        None => "not stated: fewer than two independent realisations".into(),
    };
    let above = match found.above_level() {
        Some(share) => format!(
            "{} of the cells are above the level, {} would be by chance",
            percent(share),
            percent(found.alpha)
        ),
        None => "no significance can be stated".into(),
    };
    let json = CoherenceSummary::new(found, provenance).to_json()?;
    let table = page::table(
        "Averages",
        &[
            ("records", independence.records.to_string()),
            ("segments of a record", independence.segments.to_string()),
            ("tapers", independence.tapers.to_string()),
            ("samples a segment", found.segment[0].to_string()),
            ("effective realisations", number(independence.effective)),
            ("level of one cell", level),
        ],
    );
    let page = Page {
        title: format!("Coherence of {name}"),
        sentence: format!(
            "All sites against site {} at {} {space_unit}, times in {time_unit}",
            found.reference,
            number(found.space.at(found.reference)),
        ),
        answers: page::answer(
            "At how many frequencies and sites does the motion follow the reference?",
            above,
        ),
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
