//! Curves along x, along t and along frequency, of an analysis.

use super::words;
use crate::analyze::{Analysis, Axes, Moments};
use crate::plot::labels::{self, Side};
use crate::report::page::{Chart, CurveGroup, Role, Series};

/// The groups whose results are present and have values.
pub(super) fn of(analysis: &Analysis) -> Vec<CurveGroup> {
    let axes = &analysis.axes;
    let mut groups = Vec::new();
    if let Some(moments) = &analysis.along_space {
        let content = labels::frequency(axes);
        let energy = labels::site_energy(analysis);
        let charts = moment_charts(moments, content, energy);
        let along = (labels::position(axes), Role::Position);
        let along_x = group("along-x", along, &axes.positions(), charts);
        groups.push(limited(along_x, analysis, Side::Space));
    }
    if let Some(moments) = &analysis.along_time {
        let content = labels::wavenumber(axes);
        let energy = labels::time_energy(analysis);
        let charts = moment_charts(moments, content, energy);
        let along = (labels::time(axes), Role::Time);
        let along_t = group("along-t", along, &axes.times(), charts);
        groups.push(limited(along_t, analysis, Side::Time));
    }
    let told = analysis.direction_by_frequency.as_ref();
    if let Some([plus, minus]) = told.filter(|_| analysis.undirected.is_none()) {
        let direction = direction_group(axes, plus, minus);
        groups.push(limited(direction, analysis, Side::Frequency));
    }
    groups.retain(CurveGroup::has_values);
    groups
}

/// The group within the display limits of the axis that it runs along.
fn limited(group: CurveGroup, analysis: &Analysis, side: Side) -> CurveGroup {
    let extent = side.extent(analysis);
    let not_shown = labels::not_shown(analysis, &[side], true);
    group.limited([extent.low, extent.high], not_shown)
}

fn direction_group(axes: &Axes, plus: &[f64], minus: &[f64]) -> CurveGroup {
    let series = vec![
        Series::new("towards +x", plus),
        Series::new("towards −x", minus),
    ];
    let charts = vec![Chart::new("share of energy", series)];
    let along = (labels::frequency(axes), Role::Frequency);
    group("direction", along, &axes.frequency, charts)
}

fn moment_charts(moments: &Moments, content: String, energy: String) -> Vec<Chart> {
    let places = vec![
        Series::new("centroid", &moments.centroid),
        Series::new("90 % below", &moments.quantile_90),
        Series::new("median", &moments.median),
    ];
    vec![
        Chart::new(content, places),
        Chart::new(energy, vec![Series::new("energy", &moments.energy)]).log(),
    ]
}

fn group(
    id: &'static str,
    (label, role): (String, Role),
    x: &[f64],
    charts: Vec<Chart>,
) -> CurveGroup {
    let heading = (id, words::title(id));
    CurveGroup::new(
        heading,
        words::curve_caption(id),
        (label, Some(role)),
        x,
        charts,
    )
}
