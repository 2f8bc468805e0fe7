//! A heat map for the page's script.

use ndarray::ArrayView2;
use serde::Serialize;

use super::{Role, doubles, sentence_case, singles};
use crate::analyze::{Map, Reduction};
use crate::sheet::{Colors, Curve, HeatChart};

#[derive(Debug, Clone, Serialize)]
pub(in crate::report) struct AxisData {
    pub label: String,
    low: f64,
    high: f64,
    role: Role,
    /// A second reading: its label, and what values are multiplied by.
    second: Option<(String, f64)>,
    /// A value marked across the picture.
    mark: Option<f64>,
}

impl AxisData {
    pub fn new(label: &str, (low, high): (f64, f64), role: Role) -> AxisData {
        AxisData {
            label: label.into(),
            low,
            high,
            role,
            second: None,
            mark: None,
        }
    }
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
    pub x: AxisData,
    pub y: AxisData,
    label: String,
    signed: bool,
    /// Whether the page opens with linear colours; those of signed values are linear anyway.
    linear: bool,
    /// Axis that the curve beside the map runs along at first.
    pub along: &'static str,
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
    pub interval: Option<[f64; 2]>,
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
    /// A map of a result, with axes of these roles; `shows` says what to look for.
    pub fn of(map: &Map, id: &str, title: &str, shows: &str, (x, y): (Role, Role)) -> MapData {
        let axes = [
            AxisData::new(&map.x.label, (map.x.low, map.x.high), x),
            AxisData::new(&map.y.label, (map.y.low, map.y.high), y),
        ];
        let heading = (id.into(), title.into());
        let detail = map.detail.as_ref().map(|part| DetailData {
            x: [part.x.low, part.x.high],
            y: [part.y.low, part.y.high],
            cells: CellData::of(part),
        });
        MapData {
            signed: matches!(map.reduction, Reduction::Extreme { .. }),
            detail,
            ..MapData::new(
                heading,
                caption(shows, map),
                axes,
                &map.label,
                CellData::of(map),
            )
        }
    }

    /// A map of values that are not negative.
    pub fn spectrum(
        heading: (String, String),
        caption: String,
        axes: [AxisData; 2],
        label: &str,
        values: ArrayView2<f64>,
    ) -> MapData {
        MapData::new(heading, caption, axes, label, CellData::of_values(values))
    }

    fn new(
        (id, title): (String, String),
        caption: String,
        [x, y]: [AxisData; 2],
        label: &str,
        cells: CellData,
    ) -> MapData {
        MapData {
            id,
            title,
            caption,
            x,
            y,
            label: label.into(),
            signed: false,
            linear: false,
            along: "y",
            limit: None,
            range: None,
            cells,
            detail: None,
            lines: Vec::new(),
            interval: None,
        }
    }

    /// The map of a chart whose axes have roles.
    pub fn of_chart(id: &str, map: &HeatChart) -> Option<MapData> {
        let [x, y] = map.roles?;
        let axes = [
            AxisData::new(&map.x_label, (map.x.start, map.x.end), x),
            AxisData::new(&map.y_label, (map.y.start, map.y.end), y),
        ];
        let heading = (id.to_owned(), sentence_case(&map.title));
        let of_map = MapData::spectrum(
            heading,
            map.caption.clone(),
            axes,
            &map.label,
            map.values.view(),
        );
        let mut of_map = match &map.colors {
            Colors::Powers => of_map,
            Colors::Between(range) => {
                let is_signed = range.start == -range.end;
                MapData {
                    linear: true,
                    signed: is_signed,
                    range: (!is_signed).then_some([range.start, range.end]),
                    ..of_map.with_limit(if is_signed { range.end } else { 0.0 })
                }
            }
        };
        of_map.draw_over(&map.curves);
        Some(of_map)
    }

    /// Draws curves over it, which its caption names.
    pub fn draw_over(&mut self, curves: &[Curve]) {
        let mut name = "";
        for curve in curves {
            if !curve.label.is_empty() {
                name = &curve.label;
            }
            self.lines.push(LineData {
                name: name.to_owned(),
                x: doubles(curve.points.iter().map(|point| point.0)),
                y: doubles(curve.points.iter().map(|point| point.1)),
            });
        }
        let names = curves.iter().map(|curve| &curve.label[..]);
        let names: Vec<&str> = names.filter(|name| !name.is_empty()).collect();
        if !names.is_empty() {
            self.caption = format!("{} Dashed curves: {}.", self.caption, names.join("; "));
        }
    }

    /// With a part of these ends on x and y, which the page shows at first.
    pub fn with_detail(mut self, [x, y]: [(f64, f64); 2], values: ArrayView2<f64>) -> Self {
        self.detail = Some(DetailData {
            x: x.into(),
            y: y.into(),
            cells: CellData::of_values(values),
        });
        self
    }

    /// Says what the page does not show at first.
    pub fn limited(mut self, not_shown: Option<String>) -> Self {
        self.caption.extend(not_shown.as_deref().map(page_opens));
        self
    }

    /// Whether the page shows a part of it at first.
    pub fn has_detail(&self) -> bool {
        self.detail.is_some()
    }

    pub fn with_limit(mut self, limit: f64) -> Self {
        self.limit = (limit > 0.0).then_some(limit);
        self
    }

    pub fn with_range(mut self, range: Option<[f64; 2]>) -> Self {
        self.range = range;
        self
    }

    /// Marks values, and gives wavenumbers their second reading.
    pub fn annotated(
        mut self,
        frequency: Option<f64>,
        wavenumber: Option<f64>,
        second: &Option<(String, f64)>,
    ) -> Self {
        for axis in [&mut self.x, &mut self.y] {
            match axis.role {
                Role::Frequency => axis.mark = frequency,
                Role::Wavenumber => {
                    axis.second = second.clone();
                    axis.mark = wavenumber;
                }
                Role::Time | Role::Position => {}
            }
        }
        self
    }
}

/// What pictures that open on a part of their axes leave out, as a sentence after others.
pub(in crate::report) fn page_opens(not_shown: &str) -> String {
    format!(" At first {not_shown}.")
}

fn caption(shows: &str, map: &Map) -> String {
    let (what, rows, columns) = match map.shown().reduction {
        Reduction::Max { rows, columns } => ("the largest value", rows, columns),
        Reduction::Extreme { rows, columns } => ("the value of largest magnitude", rows, columns),
    };
    let whole = match map.reduction {
        Reduction::Max { rows, columns } | Reduction::Extreme { rows, columns } => (rows, columns),
    };
    let signs = match map.reduction {
        Reduction::Extreme { .. } => ", or grey where it holds both signs",
        Reduction::Max { .. } => "",
    };
    let cells = match rows * columns {
        0 | 1 => "Each cell is a sample".to_owned(),
        _ => format!("Each cell shows {what} of {rows} × {columns} samples{signs}"),
    };
    match (map.detail.is_some(), rows * columns) {
        (false, 0 | 1) => shows.into(),
        (true, _) if whole != (rows, columns) => {
            format!(
                "{shows} {cells}; in the whole picture, {what} of {} × {}.",
                whole.0, whole.1
            )
        }
        _ => format!("{shows} {cells}."),
    }
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
