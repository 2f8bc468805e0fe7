//! A heat map for the page's script.

use ndarray::ArrayView2;
use serde::Serialize;

use super::{doubles, singles};
use crate::sheet::{Colors, Curve, HeatChart, Map, Reduction, Role};

#[derive(Debug, Clone, Serialize)]
pub(super) struct AxisData {
    pub label: String,
    low: f64,
    high: f64,
    role: Role,
    /// A second reading: its label, and what values are multiplied by.
    second: Option<(String, f64)>,
    /// Values marked across the picture.
    marks: Vec<f64>,
}

/// A line over a map, with breaks where its values are NaN.
#[derive(Debug, Serialize)]
struct LineData {
    name: String,
    /// Little-endian f64.
    x: String,
    y: String,
}

#[derive(Debug, Serialize)]
pub(in crate::report) struct MapData {
    pub id: String,
    pub title: String,
    #[serde(skip)]
    pub caption: String,
    pub(super) x: AxisData,
    pub(super) y: AxisData,
    label: String,
    signed: bool,
    /// Whether the page opens with linear colours; those of signed values are linear anyway.
    linear: bool,
    /// Axis that the curve beside the map runs along at first.
    along: &'static str,
    /// Magnitude at which a linear colour scale ends; by default the largest.
    limit: Option<f64>,
    /// Least and largest value of the colour scale, where other maps share it.
    range: Option<[f64; 2]>,
    #[serde(flatten)]
    cells: CellData,
    /// The part that the page shows at first, where it is not all of it or has finer cells.
    detail: Option<DetailData>,
    /// Dispersion curves.
    lines: Vec<LineData>,
    /// What values along y are multiplied by for the ends of their 95 % interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    interval: Option<[f64; 2]>,
}

/// The cells of a map.
#[derive(Debug, Serialize)]
struct CellData {
    rows: usize,
    columns: usize,
    /// Row by row from the lowest y, little-endian f32.
    values: String,
    /// Least and largest value of each cell, if a cell is of more than one signed sample.
    least: Option<String>,
    largest: Option<String>,
    /// What a point of the curve beside the map is, where that is not one sample.
    block: Option<String>,
}

/// A part of a map, with its ends on both axes.
#[derive(Debug, Serialize)]
struct DetailData {
    x: [f64; 2],
    y: [f64; 2],
    #[serde(flatten)]
    cells: CellData,
}

impl CellData {
    fn of(map: &Map) -> CellData {
        let side = |n: usize| {
            let range = map.range.as_ref()?;
            Some(singles(range[n].iter().copied()))
        };
        CellData {
            rows: map.values.nrows(),
            columns: map.values.ncols(),
            values: singles(map.values.iter().copied()),
            least: side(0),
            largest: side(1),
            block: block(map.reduction),
        }
    }

    /// Of values that are not negative.
    fn of_values(values: ArrayView2<f64>) -> CellData {
        CellData {
            rows: values.nrows(),
            columns: values.ncols(),
            values: singles(values.iter().map(|&value| value as f32)),
            least: None,
            largest: None,
            block: None,
        }
    }
}

impl MapData {
    /// A map whose axes have roles.
    pub fn of(id: String, title: String, map: &HeatChart) -> Option<MapData> {
        let roles = map.roles?;
        let reduced = map.reduced.as_deref();
        let ends = match reduced {
            Some(whole) => [&whole.x, &whole.y].map(|axis| [axis.low, axis.high]),
            None => [&map.x, &map.y].map(|range| [range.start, range.end]),
        };
        let named = map.marks.iter().filter(|mark| !mark.label.is_empty());
        let marks = [
            named.map(|mark| mark.at).collect(),
            map.levels.iter().map(|level| level.at).collect(),
        ];
        let labels = [&map.x_label, &map.y_label];
        let axes = roles.iter().zip(labels).zip(ends.iter().zip(marks));
        let mut axes = axes.map(|((role, label), (ends, marks))| AxisData {
            label: label.clone(),
            low: ends[0],
            high: ends[1],
            role: *role,
            second: map.second.clone().filter(|_| *role == Role::Wavenumber),
            marks,
        });
        let (x, y) = axes.next().zip(axes.next())?;
        let (signed, limit, range) = match &map.colors {
            Colors::Between(range) if range.start == -range.end => {
                (true, Some(range.end), map.shared)
            }
            Colors::Signed { limit, .. } => (true, Some(*limit), map.shared),
            Colors::Between(range) => (false, None, Some([range.start, range.end])),
            Colors::Powers => (false, None, map.shared),
        };
        Some(MapData {
            id,
            title,
            caption: caption(map),
            x,
            y,
            label: map.label.clone(),
            signed,
            linear: !matches!(map.colors, Colors::Powers),
            along: match roles {
                [
                    Role::Wavenumber | Role::Frequency,
                    Role::Time | Role::Position,
                ] => "x",
                _ => "y",
            },
            limit,
            range,
            cells: match reduced {
                Some(whole) => CellData::of(whole),
                None => CellData::of_values(map.values.view()),
            },
            detail: reduced
                .and_then(|whole| whole.detail.as_ref())
                .map(|part| DetailData {
                    x: [part.x.low, part.x.high],
                    y: [part.y.low, part.y.high],
                    cells: CellData::of(part),
                }),
            lines: lines(&map.curves),
            interval: map.interval,
        })
    }

    /// Whether the page shows a part of it at first.
    pub fn has_detail(&self) -> bool {
        self.detail.is_some()
    }
}

/// Each curve under its name, or that of the one before.
fn lines(curves: &[Curve]) -> Vec<LineData> {
    let mut name = "";
    let lines = curves.iter().map(|curve| {
        if !curve.label.is_empty() {
            name = &curve.label;
        }
        LineData {
            name: name.to_owned(),
            x: doubles(curve.points.iter().map(|point| point.0)),
            y: doubles(curve.points.iter().map(|point| point.1)),
        }
    });
    lines.collect()
}

/// What pictures that open on a part of their axes leave out, as a sentence after others.
pub(super) fn page_opens(not_shown: &str) -> String {
    format!(" At first {not_shown}.")
}

/// What it shows, how much a cell holds, the names of its curves, and what it leaves out at first.
fn caption(map: &HeatChart) -> String {
    let mut caption = map.caption.clone();
    if let Some(whole) = &map.reduced {
        let cells = |of: &Map| {
            let (rows, columns) = of.reduction.samples();
            format!("{rows} × {columns}")
        };
        let [fine, coarse] = [cells(whole.shown()), cells(whole)];
        let (what, signs) = match whole.reduction {
            Reduction::Max { .. } => ("the largest value", ""),
            Reduction::Extreme { .. } => (
                "the value of largest magnitude",
                ", or grey where it holds both signs",
            ),
        };
        if coarse != "1 × 1" {
            caption += &format!(" Each cell shows {what} of {fine} samples{signs}");
            if fine != coarse {
                caption += &format!("; in the whole picture, {what} of {coarse}");
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

/// What a point of a curve along a map is, if not one sample.
fn block(reduction: Reduction) -> Option<String> {
    let (what, rows, columns) = match reduction {
        Reduction::Max { rows, columns } => ("the largest", rows, columns),
        Reduction::Extreme { rows, columns } => ("the least and the largest", rows, columns),
    };
    (rows * columns > 1)
        .then(|| format!("A point is {what} of a cell of {rows} × {columns} samples."))
}
