//! The page of a slope.

use maud::html as markup;

use crate::estimates::{FieldAxis, Slope};
use crate::plot::{Style, slope_charts};
use crate::report::page::{self, CurveGroup, Page, Picture, number};
use crate::report::{Provenance, SlopeSummary, slope_sentences};

const DEFINITIONS: [(&str, &str); 4] = [
    (
        "Slope",
        "Least squares of ln S against ln k (or ln f) over the stated band, each bin with the same weight.",
    ),
    (
        "Interval of the regression",
        "From the residuals of the line alone: it holds deviations from a power law, but not what another record \
         would give. With several shots, the interval is that of the mean over shots.",
    ),
    (
        "Break",
        "Where a continuous line of two or three pieces changes its slope. It is accepted if the improvement has a \
         small probability without a break, times the number of places tried.",
    ),
    (
        "Shock time",
        "Zero of the line through 1/max|∂v/∂x| against time while the gradient is at most three times the first: where \
         a front that steepens by v ∂v/∂x would become infinitely steep.",
    ),
];

/// The page of the slope of a field with this name.
///
/// # Errors
/// None for results of this library.
pub fn slope_html(
    found: &Slope,
    name: &str,
    provenance: &Provenance,
    warnings: &[[String; 2]],
    style: &Style,
) -> serde_json::Result<String> {
    let charts = slope_charts(found)
        .into_iter()
        .enumerate()
        .map(|(i, chart)| {
            let group = CurveGroup::of_chart(&format!("chart-{i}"), "", &chart);
            vec![Picture::from(group)]
        });
    let json = SlopeSummary::new(found, provenance).to_json()?;
    let table = page::table(
        "Averages",
        &[
            ("shots", found.shots.to_string()),
            ("samples a segment", found.segment[0].to_string()),
            ("snapshots left out", found.left_out.to_string()),
            ("bins of the fit", found.law.points.to_string()),
            ("scatter of ln S", number(found.law.scatter)),
        ],
    );
    let over = match found.axis {
        FieldAxis::Space => "wavenumbers",
        FieldAxis::Time => "frequencies",
    };
    let page = Page {
        title: format!("Slope of {name}"),
        sentence: format!("Spectrum over {over}"),
        answers: page::answers("How steep is the spectrum?", slope_sentences(found)),
        warnings: page::warnings(
            &warnings
                .iter()
                .map(|[message, advice]| (message.clone(), Some(advice.clone())))
                .collect::<Vec<_>>(),
        ),
        rows: charts.collect(),
        rest: markup! {
            (page::numbers(table))
            (page::how_to_read(&DEFINITIONS))
            (page::folded("summary", "Summary", markup! { pre { (json) } }))
        },
        style: *style,
    };
    Ok(page.html())
}
