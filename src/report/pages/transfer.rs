//! The page of a transfer.

use maud::html as markup;

use crate::estimates::Transfer;
use crate::plot::{Style, transfer_charts, transfer_map};
use crate::report::page::{self, AxisData, CurveGroup, MapData, Page, Picture, Role, number};
use crate::report::{Provenance, TransferSummary, percent};

const DEFINITIONS: [(&str, &str); 5] = [
    (
        "Model",
        "Y(f) = L(f) X(f) + Σ Q(f₁, f₂) X(f₁) X(f₂) over f₁ + f₂ = f, differences included, by least squares over \
         realisations. The input is not taken for Gaussian.",
    ),
    (
        "Gained from pairs",
        "What the quadratic terms add to the power of a frequency between the two sites; what it gives to others \
         is negative. Chance is subtracted.",
    ),
    (
        "Passes f",
        "Power that the quadratic terms move from below f to above it; positive towards high frequency.",
    ),
    (
        "Not fitted",
        "Each fifth of the realisations is predicted from the others. A share below 0 means that the terms \
         predict nothing: the field has no such expansion, or the realisations are too few.",
    ),
    (
        "Weaker and stronger half",
        "The coefficients of an expansion do not depend on the amplitude. Fitted to the weaker half of the \
         realisations, they must explain the stronger half too.",
    ),
];

/// The page of a transfer in a field with this name.
///
/// # Errors
/// None for results of this library.
pub fn transfer_html(
    found: &Transfer,
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let (time_unit, space_unit) = found.units();
    let mut rows: Vec<Vec<Picture>> = Vec::new();
    for (i, chart) in transfer_charts(found).into_iter().enumerate() {
        rows.push(vec![
            CurveGroup::of_chart(&format!("chart-{i}"), "", &chart).into(),
        ]);
    }
    let map = transfer_map(found);
    let axes = [
        AxisData::new(&map.x_label, (map.x.start, map.x.end), Role::Frequency),
        AxisData::new(&map.y_label, (map.y.start, map.y.end), Role::Frequency),
    ];
    let map = MapData::spectrum(
        ("pairs".into(), "What each pair brings".into()),
        "Which pairs of frequencies feed a third, and which take from it.".into(),
        axes,
        &map.label,
        map.values.view(),
    )
    .signed(map.scale.end);
    rows.push(vec![map.into()]);
    let (independence, shares) = (&found.independence, &found.shares);
    let json = TransferSummary::new(found, provenance).to_json()?;
    let table = page::table(
        "Averages",
        &[
            ("records", independence.records.to_string()),
            ("segments of a record", independence.segments.to_string()),
            ("samples a segment", found.segment[0].to_string()),
            ("effective realisations", number(independence.effective)),
            ("unknowns of a frequency", found.unknowns.to_string()),
            ("linear share of the output", percent(shares.linear)),
            ("quadratic share", percent(shares.quadratic)),
            ("residual share", percent(shares.residual)),
        ],
    );
    let page = Page {
        title: format!("Transfer in {name}"),
        sentence: format!(
            "From site {} at {} to site {} at {} {space_unit}, times in {time_unit}",
            found.from,
            number(found.space.at(found.from)),
            found.to,
            number(found.space.at(found.to)),
        ),
        answers: page::answer(
            "Does power pass from low to high frequency between the two sites?",
            found.answer(),
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
