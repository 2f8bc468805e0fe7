//! Curves above one axis, for the page's script.

use serde_json::{Value, json};

use super::{Picture, doubles, page_opens};
use crate::sheet::{Chart, Look, Series, Weight};

/// Longest curve that is embedded whole; of longer ones, the extremes of each block.
const CURVE_LIMIT: usize = 1 << 16;

/// Charts that share their x; without those that have no value, and `None` where none has one. Arrays are little-endian f64:
/// energies of faint fields are below the range of f32.
pub(super) fn curves(id: String, title: String, charts: &[&Chart]) -> Option<Picture> {
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
    let note = match block(x.len()) {
        1 => String::new(),
        length => format!(" The page holds the least and the largest of every {length} values."),
    };
    let marks = first.marks.iter().map(|mark| (mark.at, &mark.label));
    let of_chart = |chart: &&Chart| {
        let levels = chart.levels.iter().map(|level| (level.at, &level.label));
        let series = chart.series.iter().flat_map(|one| of_series(one, &x));
        json!({
            "label": chart.y_label,
            "log": chart.log_y,
            "levels": levels.collect::<Vec<_>>(),
            "series": series.collect::<Vec<_>>(),
        })
    };
    Some(Picture {
        caption: first.caption.clone() + &not_shown.map(page_opens).unwrap_or_default(),
        opens_on_part: not_shown.is_some(),
        axes: None,
        data: json!({
            "kind": "curves",
            "id": id,
            "title": title,
            "note": note,
            "label": first.x_label,
            "role": first.roles[0],
            "log": first.log_x,
            "marks": marks.collect::<Vec<_>>(),
            "cumulative": first.is_cumulative,
            // Ends of what is shown at first, where that is not all.
            "shown": not_shown.map(|_| [first.x.start, first.x.end]),
            "x": doubles(thinned(&x, middles)),
            "charts": charts.iter().map(of_chart).collect::<Vec<_>>(),
        }),
        id,
        title,
    })
}

/// The ends of the area of a series, then its points; without x where that is the shared one.
fn of_series(series: &Series, shared: &[f64]) -> Vec<Value> {
    let x: Vec<f64> = series.points.iter().map(|point| point.0).collect();
    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let is_shared = bits(&x) == bits(shared);
    let has_errors = series.errors.iter().any(|error| *error > 0.0);
    let weight = Some(series.weight).filter(|weight| *weight != Weight::Normal);
    let data = |label: &str, values: Vec<f64>, look: Look, errors: Option<String>, band: bool| {
        json!({
            "label": label,
            "look": look,
            "color": series.colour,
            "shade": series.shade,
            "weight": weight,
            "x": (!is_shared).then(|| doubles(thinned(&x, middles))),
            "values": doubles(thinned(&values, extremes)),
            "errors": errors,
            // The area down to the series before is filled.
            "band": band,
        })
    };
    let mut all = Vec::new();
    if let Some(band) = &series.band {
        let (low, high) = band.ends.iter().copied().unzip();
        for (ends, which) in [(low, "lower"), (high, "upper")] {
            let label = format!("{}, {which} end", band.label);
            all.push(data(&label, ends, Look::Line, None, which == "upper"));
        }
    }
    let values = series.points.iter().map(|point| point.1).collect();
    let errors = has_errors.then(|| doubles(series.errors.iter().copied()));
    all.push(data(&series.label, values, series.look, errors, false));
    all
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
