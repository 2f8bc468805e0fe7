//! Curves along x, along t and along frequency, for the page's script.

use serde::Serialize;

use super::data::{Role, double, mark};
use super::words;
use crate::analyze::{Analysis, Axes, Moments};
use crate::plot::labels;

/// Longest curve that is embedded whole; of longer ones, the extremes of each block.
const CURVE_LIMIT: usize = 1 << 16;

#[derive(Debug, Serialize)]
pub(super) struct CurveGroup {
    pub id: &'static str,
    pub title: &'static str,
    #[serde(skip)]
    pub caption: &'static str,
    /// What the page holds, where that is not every value.
    note: String,
    label: String,
    role: Role,
    /// Little-endian f64.
    x: String,
    pub charts: Vec<Chart>,
}

#[derive(Debug, Serialize)]
pub(super) struct Chart {
    label: String,
    log: bool,
    mark: Option<f64>,
    series: Vec<CurveSeries>,
}

#[derive(Debug, Serialize)]
struct CurveSeries {
    label: &'static str,
    /// Little-endian f64: energies of faint fields are below the range of f32.
    values: String,
}

/// The groups whose results are present.
pub(super) fn of(analysis: &Analysis) -> Vec<CurveGroup> {
    let axes = &analysis.axes;
    let mut groups = Vec::new();
    if let Some(moments) = &analysis.along_space {
        let content = labels::frequency(axes);
        let energy = labels::site_energy(analysis);
        let mut charts = moment_charts(moments, content, energy, mark(analysis.frequency_edge));
        if let (Some(front), Some(shares)) = (&analysis.front, charts.get_mut(1)) {
            let high = series("high band, front", &front.high_share);
            shares.series.push(high);
        }
        let along = (labels::position(axes), Role::Position);
        groups.push(group("along-x", along, &axes.positions(), charts));
    }
    if let Some(moments) = &analysis.along_time {
        let content = labels::wavenumber(axes);
        let energy = labels::time_energy(analysis);
        let charts = moment_charts(moments, content, energy, mark(analysis.wavenumber_edge));
        let along = (labels::time(axes), Role::Time);
        groups.push(group("along-t", along, &axes.times(), charts));
    }
    if let Some([plus, minus]) = &analysis.direction_by_frequency {
        groups.push(direction_group(axes, plus, minus));
    }
    groups
}

fn direction_group(axes: &Axes, plus: &[f64], minus: &[f64]) -> CurveGroup {
    let series = vec![series("towards +x", plus), series("towards −x", minus)];
    let charts = vec![chart("share of energy".into(), false, None, series)];
    let along = (labels::frequency(axes), Role::Frequency);
    group("direction", along, &axes.frequency, charts)
}

fn moment_charts(
    moments: &Moments,
    content: String,
    energy: String,
    edge: Option<f64>,
) -> Vec<Chart> {
    let places = vec![
        series("centroid", &moments.centroid),
        series("90 % below", &moments.quantile_90),
        series("median", &moments.median),
    ];
    let shares = vec![
        series("low band", &moments.low_share),
        series("high band", &moments.high_share),
    ];
    vec![
        chart(content, false, edge, places),
        chart("share of energy".into(), false, None, shares),
        chart(energy, true, None, vec![series("energy", &moments.energy)]),
    ]
}

fn chart(label: String, log: bool, mark: Option<f64>, series: Vec<CurveSeries>) -> Chart {
    Chart {
        label,
        log,
        mark,
        series,
    }
}

fn series(label: &'static str, values: &[f64]) -> CurveSeries {
    let shown = shown(values.len());
    CurveSeries {
        label,
        values: match shown {
            EmbeddedCurve::All => double(values.iter().copied()),
            EmbeddedCurve::Blocks(length) => double(values.chunks(length).flat_map(extremes)),
        },
    }
}

fn group(id: &'static str, along: (String, Role), x: &[f64], charts: Vec<Chart>) -> CurveGroup {
    let shown = shown(x.len());
    let x: Vec<f64> = match shown {
        EmbeddedCurve::All => x.to_vec(),
        EmbeddedCurve::Blocks(length) => x
            .chunks(length)
            .flat_map(|block| [block[block.len() / 4], block[3 * block.len() / 4]])
            .collect(),
    };
    CurveGroup {
        id,
        title: words::title(id),
        caption: words::curve_caption(id),
        note: match shown {
            EmbeddedCurve::All => String::new(),
            EmbeddedCurve::Blocks(length) => {
                format!(" The page holds the least and the largest of every {length} values.")
            }
        },
        label: along.0,
        role: along.1,
        x: double(x),
        charts,
    }
}

/// How much of a curve is embedded.
enum EmbeddedCurve {
    All,
    /// The extremes of each block of this many samples, one after the other.
    Blocks(usize),
}

fn shown(samples: usize) -> EmbeddedCurve {
    match samples {
        0..=CURVE_LIMIT => EmbeddedCurve::All,
        _ => EmbeddedCurve::Blocks(samples.div_ceil(CURVE_LIMIT / 2)),
    }
}

/// The smallest and the largest value, in their order of appearance.
fn extremes(block: &[f64]) -> [f64; 2] {
    let (mut low, mut high) = ((0, f64::NAN), (0, f64::NAN));
    for (index, &value) in block.iter().enumerate() {
        if low.1.is_nan() || value < low.1 {
            low = (index, value);
        }
        if high.1.is_nan() || value > high.1 {
            high = (index, value);
        }
    }
    match low.0 <= high.0 {
        true => [low.1, high.1],
        false => [high.1, low.1],
    }
}
