//! Curves above one axis, for the page's script.

use serde::Serialize;

use super::{doubles, page_opens};
use crate::sheet::{Chart, Look, Role, Series, Weight};

/// Longest curve that is embedded whole; of longer ones, the extremes of each block.
const CURVE_LIMIT: usize = 1 << 16;

/// Values on the group's x, or on their own; arrays are little-endian f64: energies of faint fields are below the
/// range of f32.
#[derive(Debug, Serialize)]
struct SeriesData {
    label: String,
    look: Look,
    color: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    shade: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    weight: Option<Weight>,
    x: Option<String>,
    values: String,
    /// Standard errors.
    errors: Option<String>,
    /// Whether the area down to the series before is filled.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    band: bool,
}

impl SeriesData {
    /// The ends of the area of a series, then its points.
    fn of(series: &Series, shared: &[f64]) -> Vec<SeriesData> {
        let x: Vec<f64> = series.points.iter().map(|point| point.0).collect();
        let is_shared = x
            .iter()
            .map(|x| x.to_bits())
            .eq(shared.iter().map(|x| x.to_bits()));
        let values = series.points.iter().map(|point| point.1).collect();
        let is_weighty = series.weight != Weight::Normal;
        let has_errors = series.errors.iter().any(|error| *error > 0.0);
        let data = |label: String, values: Vec<f64>, look: Look| SeriesData {
            label,
            look,
            color: series.colour,
            shade: series.shade,
            weight: is_weighty.then_some(series.weight),
            x: (!is_shared).then(|| doubles(thinned(&x, middles))),
            values: doubles(thinned(&values, extremes)),
            errors: None,
            band: false,
        };
        let end = |of: fn(&(f64, f64)) -> f64, which: &str| {
            let band = series.band.as_ref()?;
            let ends = band.ends.iter().map(of).collect();
            Some(data(
                format!("{}, {which} end", band.label),
                ends,
                Look::Line,
            ))
        };
        let lower = end(|ends| ends.0, "lower");
        let upper = end(|ends| ends.1, "upper").map(|upper| SeriesData {
            band: true,
            ..upper
        });
        let own = SeriesData {
            errors: has_errors.then(|| doubles(series.errors.iter().copied())),
            ..data(series.label.clone(), values, series.look)
        };
        lower.into_iter().chain(upper).chain([own]).collect()
    }
}

/// Series on one y axis.
#[derive(Debug, Serialize)]
struct ChartData {
    label: String,
    log: bool,
    /// Values marked across the chart, with their names.
    levels: Vec<(f64, String)>,
    series: Vec<SeriesData>,
}

/// Charts above one x axis.
#[derive(Debug, Serialize)]
pub(in crate::report) struct CurveGroup {
    pub id: String,
    pub title: String,
    #[serde(skip)]
    pub caption: String,
    /// What the page holds, where that is not every value.
    note: String,
    label: String,
    role: Option<Role>,
    log: bool,
    /// Places on x, with their names.
    marks: Vec<(f64, String)>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    cumulative: bool,
    /// Ends of what is shown at first, where that is not all.
    shown: Option<[f64; 2]>,
    x: String,
    charts: Vec<ChartData>,
}

impl CurveGroup {
    /// Charts that share their x; without those that have no value, and `None` where none has one.
    pub fn of(id: String, title: String, charts: &[&Chart]) -> Option<CurveGroup> {
        let has_values = |chart: &&&Chart| {
            let points = chart.series.iter().flat_map(|series| &series.points);
            points.into_iter().any(|point| point.1.is_finite())
        };
        let charts: Vec<&Chart> = charts.iter().filter(has_values).copied().collect();
        let first = charts.first()?;
        let all = charts.iter().flat_map(|chart| &chart.series);
        let longest = all.max_by_key(|series| series.points.len())?;
        let x: Vec<f64> = longest.points.iter().map(|point| point.0).collect();
        let not_shown = first.not_shown.as_deref();
        Some(CurveGroup {
            id,
            title,
            caption: format!(
                "{}{}",
                first.caption,
                not_shown.map_or_else(String::new, page_opens)
            ),
            note: match block(x.len()) {
                1 => String::new(),
                length => {
                    format!(" The page holds the least and the largest of every {length} values.")
                }
            },
            label: first.x_label.clone(),
            role: first.role,
            log: first.log_x,
            marks: first
                .marks
                .iter()
                .map(|mark| (mark.at, mark.label.clone()))
                .collect(),
            cumulative: first.is_cumulative,
            shown: not_shown.map(|_| [first.x.start, first.x.end]),
            charts: charts.iter().map(|chart| data(chart, &x)).collect(),
            x: doubles(thinned(&x, middles)),
        })
    }

    /// Whether the page shows a part of it at first.
    pub fn opens_on_part(&self) -> bool {
        self.shown.is_some()
    }
}

fn data(chart: &Chart, shared: &[f64]) -> ChartData {
    let levels = chart.levels.iter();
    let series = chart.series.iter();
    ChartData {
        label: chart.y_label.clone(),
        log: chart.log_y,
        levels: levels
            .map(|level| (level.at, level.label.clone()))
            .collect(),
        series: series
            .flat_map(|series| SeriesData::of(series, shared))
            .collect(),
    }
}

/// Samples of a curve of this many that two embedded values stand for; 1 where all are embedded.
fn block(samples: usize) -> usize {
    match samples {
        0..=CURVE_LIMIT => 1,
        _ => samples.div_ceil(CURVE_LIMIT / 2),
    }
}

/// All values, or two of each block.
fn thinned(values: &[f64], of_block: fn(&[f64]) -> [f64; 2]) -> Vec<f64> {
    match block(values.len()) {
        1 => values.to_vec(),
        length => values.chunks(length).flat_map(of_block).collect(),
    }
}

/// A quarter and three quarters along.
fn middles(block: &[f64]) -> [f64; 2] {
    [block[block.len() / 4], block[3 * block.len() / 4]]
}

/// The smallest and the largest value, in their order of appearance.
fn extremes(block: &[f64]) -> [f64; 2] {
    let finite = || (0..block.len()).filter(|n| !block[*n].is_nan());
    let by_value = |a: &usize, b: &usize| block[*a].total_cmp(&block[*b]);
    let low = finite().min_by(by_value);
    let high = finite().rev().max_by(by_value);
    let at = |n: Option<usize>| n.map_or(f64::NAN, |n| block[n]);
    [low.min(high), low.max(high)].map(at)
}
