//! The page of transfers by triads.

use maud::html as markup;

use crate::budget::Triads;
use crate::plot::{Style, triad_charts, triad_map};
use crate::report::page::{self, AxisData, CurveGroup, MapData, Page, Picture, Role, number};
use crate::report::{Provenance, TriadsSummary, percent, triad_sentences};

const DEFINITIONS: [(&str, &str); 4] = [
    (
        "Triad",
        "Three wavenumbers k = p + q. Where the force is quadratic, energy is exchanged within each triad, and each \
         keeps its energy.",
    ),
    (
        "Map",
        "Energy that k gained with the larger partner p, both signs of k together: below the diagonal k is the sum of \
         its partners, above it their difference.",
    ),
    (
        "Flux past k",
        "Energy that triads moved from wavenumbers up to k to larger ones.",
    ),
    (
        "Ratio",
        "The largest over the smallest wavenumber of a triad, at least 2. A cascade is local if triads of small \
         ratios carry the flux.",
    ),
];

/// The page of the triads of a run or field with this name.
///
/// # Errors
/// None for results of this library.
pub fn triads_html(
    found: &Triads,
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let map = triad_map(found);
    let axes = [
        AxisData::new(&map.x_label, (map.x.start, map.x.end), Role::Wavenumber),
        AxisData::new(&map.y_label, (map.y.start, map.y.end), Role::Wavenumber),
    ];
    let map = MapData::spectrum(
        ("pairs".into(), "What each pair brings".into()),
        "Which wavenumbers gain energy, and from which partners.".into(),
        axes,
        &map.label,
        map.values.view(),
    )
    .signed(map.scale.end);
    let mut rows: Vec<Vec<Picture>> = vec![vec![map.into()]];
    for (i, chart) in triad_charts(found).into_iter().enumerate() {
        let group = CurveGroup::of_chart(&format!("chart-{i}"), "", &chart);
        rows.push(vec![group.into()]);
    }
    let json = TriadsSummary::new(found, provenance).to_json()?;
    let table = page::table(
        "Sums",
        &[
            ("samples", found.samples.to_string()),
            ("energy at the start", number(found.energy)),
            (
                "error by sampling",
                percent(found.sampling_error / found.energy),
            ),
            (
                "each triad keeps its energy to",
                number(found.identities.detailed),
            ),
            (
                "sums over pairs are products to",
                number(found.identities.sums),
            ),
        ],
    );
    let [from, to] = found.window.map(number);
    let page = Page {
        title: format!("Triads of {name}"),
        sentence: format!("Energy exchanged between wavenumbers from time {from} to {to}"),
        answers: page::answers("Which wavenumbers feed which?", triad_sentences(found)),
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
