//! A transfer on the page of a bicoherence.

use maud::{Markup, html as markup};

use crate::estimates::Transfer;
use crate::plot::{transfer_charts, transfer_map};
use crate::report::page::{self, AxisData, CurveGroup, MapData, Picture, Role, number};
use crate::report::percent;

pub(super) const DEFINITIONS: [(&str, &str); 5] = [
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

/// Pictures in rows.
pub(super) fn pictures(found: &Transfer) -> Vec<Vec<Picture>> {
    let mut rows: Vec<Vec<Picture>> = Vec::new();
    for (i, chart) in transfer_charts(found).into_iter().enumerate() {
        rows.push(vec![
            CurveGroup::of_chart(&format!("transfer-{i}"), "", &chart).into(),
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
    rows
}

/// What was found, and of what.
pub(super) fn numbers(found: &Transfer) -> Markup {
    let (independence, shares) = (&found.independence, &found.shares);
    let heading = format!(
        "Transfer from site {} at {} to site {} at {}",
        found.from,
        number(found.space.at(found.from)),
        found.to,
        number(found.space.at(found.to)),
    );
    let table = page::table(
        &heading,
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
    markup! { p { (found.answer()) } (table) }
}
