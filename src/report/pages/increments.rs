//! The page of structure functions.

use maud::html as markup;

use crate::estimates::{AxisIncrements, ExponentBasis, FieldAxis, Increments, IntervalBasis};
use crate::plot::{Style, increment_charts};
use crate::report::page::{self, CurveGroup, Page, Picture, number};
use crate::report::{IncrementsSummary, Provenance, increment_sentences};

const DEFINITIONS: [(&str, &str); 5] = [
    (
        "Increment",
        "Difference of two samples a separation r apart along x, towards +x, or a lag τ apart in time.",
    ),
    (
        "Structure function",
        "Mean of |increment| to the power p, over all pairs of samples. Charts show its p-th root.",
    ),
    (
        "Flatness",
        "⟨d⁴⟩/⟨d²⟩²: 3 for normal increments. Where it grows towards small scales, the field is \
         intermittent: large increments are rare and concentrated.",
    ),
    (
        "Third moment",
        "⟨d³⟩ with its sign. Negative along x where fronts steepen towards +x. In Burgers' equation and in \
         turbulence a negative one goes with transfer to small scales; elsewhere it states an asymmetry alone.",
    ),
    (
        "Exponent",
        "Slope of ln S_p against the logarithm of the scale over the stated band. The interval of the \
         regression holds deviations from a power law; only that over shots holds what another record would give.",
    ),
];

/// The page of the increments of a field with this name.
///
/// # Errors
/// None for results of this library.
pub fn increments_html(
    found: &Increments,
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let (time_unit, space_unit) = found.units();
    let charts = found
        .axes
        .iter()
        .flat_map(|axis| increment_charts(found, axis));
    let rows = charts.enumerate().map(|(i, chart)| {
        let group = CurveGroup::of_chart(&format!("chart-{i}"), "", &chart);
        vec![Picture::from(group)]
    });
    let json = IncrementsSummary::new(found, provenance).to_json()?;
    let basis = match found.basis {
        IntervalBasis::Shots => format!("over {} shots", found.shots),
        IntervalBasis::Parts => "over 16 parts of the record".into(),
        IntervalBasis::None => "none: one transient".into(),
    };
    let tables = markup! {
        (page::table("Averages", &[
            ("shots", found.shots.to_string()),
            ("steadiness", number(found.steadiness)),
            ("intervals", basis),
        ]))
        @for axis in &found.axes {
            @if let Some(rows) = exponent_rows(axis) {
                (page::grid(
                    &format!("Exponents {}", along(axis)),
                    &["order", "exponent", "half interval", "relative to order 3"],
                    &rows,
                ))
            }
        }
    };
    let page = Page {
        title: format!("Increments of {name}"),
        sentence: format!("Separations in {space_unit}, lags in {time_unit}"),
        answers: page::answers(
            "How do differences grow with scale?",
            increment_sentences(found),
        ),
        warnings: page::warnings(
            &warnings
                .iter()
                .map(|[message, advice]| (message.clone(), Some(advice.clone())))
                .collect::<Vec<_>>(),
        ),
        rows: rows.collect(),
        rest: markup! {
            (page::numbers(tables))
            (page::how_to_read(&DEFINITIONS))
            (page::folded("summary", "Summary", markup! { pre { (json) } }))
        },
        style: *style,
    };
    Ok(page.html())
}

fn along(axis: &AxisIncrements) -> &'static str {
    match axis.axis {
        FieldAxis::Space => "along x",
        FieldAxis::Time => "in time",
    }
}

/// A row an order.
fn exponent_rows(axis: &AxisIncrements) -> Option<Vec<Vec<String>>> {
    let fit = axis.exponents.as_ref()?;
    let basis = match fit.basis {
        ExponentBasis::Shots => "over shots",
        ExponentBasis::Regression => "of the regression",
    };
    let row = |p: usize| {
        vec![
            (p + 1).to_string(),
            number(fit.exponents[p]),
            format!("{} {basis}", number(fit.half[p])),
            number(fit.relative[p]),
        ]
    };
    Some((0..fit.exponents.len()).map(row).collect())
}
