//! A heat map for the page's script.

use serde_json::{Value, json};

use super::{Picture, doubles, singles};
use crate::sheet::{Chart, Colors, Curve, Map, Reduction, Role};

/// A map whose axes have roles. Cells are little-endian f32, row by row from the lowest y.
pub(super) fn map(id: String, title: String, map: &Chart) -> Option<Picture> {
    let [Some(x_role), Some(y_role)] = map.roles else {
        return None;
    };
    let reduced = map.reduced.as_deref();
    let [x, y] = match reduced {
        Some(whole) => [&whole.x, &whole.y].map(|axis| (axis.low, axis.high)),
        None => [&map.x, &map.y].map(|range| (range.start, range.end)),
    };
    let axis = |role: Role, label: &str, (low, high): (f64, f64), marks: Vec<f64>| {
        let second = map.second.as_ref().filter(|_| role == Role::Wavenumber);
        json!({
            "label": label, "low": low, "high": high, "role": role, "second": second, "marks": marks,
        })
    };
    let named = map.marks.iter().filter(|mark| !mark.label.is_empty());
    let marks = named.map(|mark| mark.at).collect();
    let levels = map.levels.iter().map(|level| level.at).collect();
    let (signed, limit, range) = match &map.colors {
        Colors::Between(range) if range.start == -range.end => (true, Some(range.end), map.shared),
        Colors::Signed { limit, .. } => (true, Some(*limit), map.shared),
        Colors::Between(range) => (false, None, Some([range.start, range.end])),
        Colors::Powers => (false, None, map.shared),
    };
    // The curve beside the map runs along time or position at first.
    let along = match (x_role, y_role) {
        (Role::Wavenumber | Role::Frequency, Role::Time | Role::Position) => "x",
        _ => "y",
    };
    let detail = reduced.and_then(|whole| whole.detail.as_deref());
    let mut data = match reduced {
        Some(whole) => cells(whole),
        None => json!({
            "rows": map.values.nrows(),
            "columns": map.values.ncols(),
            "values": singles(map.values.iter().map(|&value| value as f32)),
        }),
    };
    for (name, value) in [
        ("kind", json!("map")),
        ("id", json!(id)),
        ("title", json!(title)),
        ("x", axis(x_role, &map.x_label, x, marks)),
        ("y", axis(y_role, &map.y_label, y, levels)),
        ("label", json!(map.label)),
        ("signed", json!(signed)),
        // Whether the page opens with linear colours; those of signed values are linear anyway.
        ("linear", json!(!matches!(map.colors, Colors::Powers))),
        ("along", json!(along)),
        // Magnitude at which a linear colour scale ends; by default the largest.
        ("limit", json!(limit)),
        // Of the colour scale, where other maps share it.
        ("range", json!(range)),
        ("lines", lines(&map.curves)),
        ("interval", json!(map.interval)),
        (
            "detail",
            detail.map_or(Value::Null, |part| {
                let mut data = cells(part);
                data["x"] = json!([part.x.low, part.x.high]);
                data["y"] = json!([part.y.low, part.y.high]);
                data
            }),
        ),
    ] {
        data[name] = value;
    }
    Some(Picture {
        id,
        title,
        caption: caption(map),
        axes: Some([map.x_label.clone(), map.y_label.clone()]),
        opens_on_part: detail.is_some(),
        data,
    })
}

/// The cells of a map; least and largest value of each, if a cell is of more than one signed sample; what a point of the curve
/// beside the map is, where that is not one sample.
fn cells(map: &Map) -> Value {
    let range = map.range.as_ref();
    let range = range.map(|range| range.each_ref().map(|side| singles(side.iter().copied())));
    let (rows, columns) = map.reduction.samples();
    let what = match map.reduction {
        Reduction::Max { .. } => "the largest",
        Reduction::Extreme { .. } => "the least and the largest",
    };
    let block = (rows * columns > 1)
        .then(|| format!("A point is {what} of a cell of {rows} × {columns} samples."));
    json!({
        "rows": map.values.nrows(),
        "columns": map.values.ncols(),
        "values": singles(map.values.iter().copied()),
        "least": range.as_ref().map(|[least, _]| least),
        "largest": range.as_ref().map(|[_, largest]| largest),
        "block": block,
    })
}

/// Each curve, broken where its values are NaN, under its name or that of the one before.
fn lines(curves: &[Curve]) -> Value {
    let mut name = "";
    let lines = curves.iter().map(|curve| {
        if !curve.label.is_empty() {
            name = &curve.label;
        }
        json!({
            "name": name,
            "x": doubles(curve.points.iter().map(|point| point.0)),
            "y": doubles(curve.points.iter().map(|point| point.1)),
        })
    });
    lines.collect()
}

/// What pictures that open on a part of their axes leave out, as a sentence after others.
pub(super) fn page_opens(not_shown: &str) -> String {
    format!(" At first {not_shown}.")
}

/// What it shows, how much a cell holds, the names of its curves, and what it leaves out at first.
fn caption(map: &Chart) -> String {
    let mut caption = map.caption.clone();
    if let Some(whole) = &map.reduced {
        let cells = |of: &Map| {
            let (rows, columns) = of.reduction.samples();
            format!("{rows} × {columns}")
        };
        let [fine, coarse] = [cells(whole.shown()), cells(whole)];
        let what = whole.reduction.shows();
        let signs = match whole.reduction {
            Reduction::Max { .. } => "",
            Reduction::Extreme { .. } => ", or grey where it holds both signs",
        };
        if coarse != "1 × 1" {
            caption += &format!(" Each cell shows the {what} of {fine} samples{signs}");
            if fine != coarse {
                caption += &format!("; in the whole picture, the {what} of {coarse}");
            }
            caption += ".";
        }
    }
    let names = map.curves.iter().map(|curve| &curve.label[..]);
    let names: Vec<&str> = names.filter(|name| !name.is_empty()).collect();
    if !names.is_empty() {
        caption += &format!(" Dashed curves: {}.", names.join("; "));
    }
    caption.extend(map.not_shown.as_deref().map(page_opens));
    caption
}
