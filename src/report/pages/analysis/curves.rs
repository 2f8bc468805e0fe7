//! Curves along x, along t and along frequency, of an analysis.

use super::words;
use crate::analyze::Analysis;
use crate::plot::Content;
use crate::plot::labels::{self, Side};
use crate::report::page::{Chart, CurveGroup, Series};

/// The groups whose results are present and have values.
pub(super) fn of(analysis: &Analysis) -> Vec<CurveGroup> {
    let contents = [Content::along_x(analysis), Content::along_t(analysis)];
    let mut groups: Vec<CurveGroup> = (contents.into_iter().flatten())
        .map(|content| {
            let charts = charts(analysis, &content);
            let [along, _] = content.sides;
            group(
                (content.id, content.title),
                analysis,
                along,
                &content.along,
                charts,
            )
        })
        .collect();
    let told = analysis.direction_by_frequency.as_ref();
    if let Some([plus, minus]) = told.filter(|_| analysis.undirected.is_none()) {
        let series = vec![
            Series::new("towards +x", plus),
            Series::new("towards −x", minus),
        ];
        let charts = vec![Chart::new("share of energy", series)];
        let heading = ("direction", "Direction of travel at each frequency");
        let frequency = &analysis.axes.frequency;
        groups.push(group(heading, analysis, Side::Frequency, frequency, charts));
    }
    groups.retain(CurveGroup::has_values);
    groups
}

fn charts(analysis: &Analysis, content: &Content) -> Vec<Chart> {
    let moments = content.moments;
    let places = vec![
        Series::new("centroid", &moments.centroid),
        Series::new("90 % below", &moments.quantile_90),
        Series::new("median", &moments.median),
    ];
    let energy = vec![Series::new("energy", &moments.energy)];
    vec![
        Chart::new(content.sides[1].label(&analysis.axes), places),
        Chart::new(&content.energy_label, energy).log(),
    ]
}

/// Charts along an axis, within its display limits.
fn group(
    (id, title): (&str, &str),
    analysis: &Analysis,
    side: Side,
    x: &[f64],
    charts: Vec<Chart>,
) -> CurveGroup {
    let along = (side.label(&analysis.axes), Some(side.role()));
    let extent = side.extent(analysis);
    let not_shown = labels::not_shown(analysis, &[side], true);
    CurveGroup::new((id, title), words::curve_caption(id), along, x, charts)
        .limited([extent.low, extent.high], not_shown)
}
