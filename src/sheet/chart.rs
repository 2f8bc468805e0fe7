//! Charts as data: series on one pair of axes, with levels and marks.

use std::ops::Range;

use ndarray::Array2;

use super::map::{Colors, Curve, Map, Reduction, Role, magnitudes, range};
use super::units::Units;

/// Colours of Okabe and Ito, safe for colour-blind readers: red, green, blue.
pub const PALETTE: [[u8; 3]; 7] = [
    [0x00, 0x72, 0xb2],
    [0xd5, 0x5e, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0xe6, 0x9f, 0x00],
    [0x56, 0xb4, 0xe9],
    [0x22, 0x22, 0x22],
];
// Indices into the palette.
pub(crate) const BLUE: usize = 0;
pub(crate) const VERMILLION: usize = 1;
pub(crate) const GREEN: usize = 2;
pub(crate) const PURPLE: usize = 3;
pub(crate) const SKY: usize = 5;
pub(crate) const BLACK: usize = 6;

/// How much a series stands out.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Weight {
    /// Without values on hovering.
    Thin,
    #[default]
    Normal,
    Bold,
    /// A difference between other series.
    Gap,
}

/// A dashed line at a value of one axis, across the chart, with its name. That of an upright one is above its upper end.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    pub at: f64,
    /// Empty for a line without a name.
    pub label: String,
}

impl Mark {
    pub fn new(at: f64, label: impl Into<String>) -> Mark {
        let label = label.into();
        Mark { at, label }
    }

    /// The line at 0, without a name.
    pub fn zero() -> Mark {
        Mark::new(0.0, "")
    }
}

/// One that is level.
pub type Level = Mark;

/// A symbol at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    Circle,
    Square,
    Triangle,
    Cross,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Look {
    /// A line; its points are marked where they are few.
    #[default]
    Line,
    Dashed,
    Dots,
}

/// Lower and upper ends at the points of a series, such as those of an interval. Ends that are not finite
/// are a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    pub label: String,
    pub ends: Vec<(f64, f64)>,
}

/// Points with a name, which may be empty. A point that is not finite is a gap.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    pub label: String,
    pub points: Vec<(f64, f64)>,
    /// Standard errors of the ordinates; empty where there are none.
    pub errors: Vec<f64>,
    /// Drawn as an area below the line.
    pub band: Option<Band>,
    pub look: Look,
    /// Index into [`PALETTE`]; beyond it the colours return with another symbol at each point.
    pub colour: usize,
    /// The symbol of each point; by default circles where points are marked.
    pub marker: Option<Marker>,
    pub weight: Weight,
    /// Place on a scale of colours, from 0 to 1, in place of the palette.
    pub shade: Option<f64>,
}

impl Series {
    pub fn line(label: impl Into<String>, colour: usize, points: Vec<(f64, f64)>) -> Series {
        Series {
            label: label.into(),
            points,
            colour,
            ..Series::default()
        }
    }

    /// A line through values at `x`.
    pub fn of(label: impl Into<String>, colour: usize, x: &[f64], y: &[f64]) -> Series {
        let points = x.iter().copied().zip(y.iter().copied());
        Series::line(label, colour, points.collect())
    }

    /// Points with their errors, x, y and error of each; an error that is not finite is none.
    pub fn with_errors(
        label: impl Into<String>,
        colour: usize,
        points: impl IntoIterator<Item = [f64; 3]>,
    ) -> Series {
        let bar = |error: f64| if error.is_finite() { error } else { 0.0 };
        let points = points.into_iter();
        let (points, errors) = points.map(|[x, y, e]| ((x, y), bar(e))).unzip();
        Series {
            errors,
            ..Series::line(label, colour, points)
        }
    }

    pub fn with(self, look: Look) -> Series {
        Series { look, ..self }
    }

    /// With this symbol at each point.
    pub fn marked(self, marker: Marker) -> Series {
        Series {
            marker: Some(marker),
            ..self
        }
    }

    /// With an area below the line, where an end is known.
    pub fn with_band(self, label: impl Into<String>, ends: Vec<(f64, f64)>) -> Series {
        let (label, is_known) = (label.into(), ends.iter().any(|(low, _)| low.is_finite()));
        Series {
            band: is_known.then_some(Band { label, ends }),
            ..self
        }
    }
}

/// Decades that a logarithmic axis reaches down, at most.
const DECADES: i32 = 12;

/// Series on one pair of axes, over the cells of a map where there is one.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chart {
    /// Above the frame; may be empty.
    pub title: String,
    /// What to look for, on a page; may be empty.
    pub caption: String,
    pub x_label: String,
    pub y_label: String,
    pub x: Range<f64>,
    pub y: Range<f64>,
    /// Of a map, whether columns are evenly spaced in the logarithm of x.
    pub log_x: bool,
    pub log_y: bool,
    pub series: Vec<Series>,
    /// Uprights with their names.
    pub marks: Vec<Mark>,
    pub levels: Vec<Level>,
    /// What x and y count, where picks on a page are shared; those of a map on a page are known.
    pub roles: [Option<Role>; 2],
    /// Label of a second reading of wavenumbers, and what they are multiplied by for it.
    pub second: Option<(String, f64)>,
    /// Whether the curves rise to 1 towards the right, where names have room below them.
    pub is_cumulative: bool,
    /// What lies beyond the ranges; a page opens on them and holds the rest.
    pub not_shown: Option<String>,
    /// What the colours of a map mean, with its unit.
    pub label: String,
    /// Values of a map, each row from the lower end of the vertical axis on; none where there is no map.
    pub values: Array2<f64>,
    /// In their place, cells of many samples, with the part that is shown at first.
    pub reduced: Option<Box<Map>>,
    pub colors: Colors,
    /// Least positive and largest magnitude, of maps that share their colours.
    pub shared: Option<[f64; 2]>,
    /// Dashed lines over a map.
    pub curves: Vec<Curve>,
    /// What values along y are multiplied by for the ends of their 95 % interval.
    pub interval: Option<[f64; 2]>,
}

impl Chart {
    /// A linear chart whose axes hold all points and begin at 0 where that is near.
    pub fn of(
        title: impl Into<String>,
        x_label: impl Into<String>,
        y_label: impl Into<String>,
        series: Vec<Series>,
    ) -> Chart {
        let points = || series.iter().flat_map(|s| &s.points);
        let x = extent(points().map(|p| p.0));
        let y = extent(points().map(|p| p.1));
        let low = if y.start > 0.0 && y.start < 0.6 * y.end {
            0.0
        } else {
            y.start - 0.05 * (y.end - y.start)
        };
        Chart {
            title: title.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            x,
            y: low..y.end + 0.08 * (y.end - low),
            series,
            ..Chart::default()
        }
    }

    /// A map of values over two axes with the centres of its cells; the vertical one has no negative values.
    pub(crate) fn over(
        units: &Units,
        roles: [Role; 2],
        [x, y]: [&[f64]; 2],
        values: Array2<f64>,
    ) -> Chart {
        let vertical = range(y);
        Chart {
            x_label: units.label(roles[0]),
            y_label: units.label(roles[1]),
            x: range(x),
            y: vertical.start.max(0.0)..vertical.end,
            values,
            roles: roles.map(Some),
            ..Chart::default()
        }
    }

    /// A map of many samples a cell: colours about zero for signed ones, else logarithmic.
    pub fn of_map(map: &Map) -> Chart {
        let shown = map.shown();
        Chart {
            x_label: map.x.label.clone(),
            y_label: map.y.label.clone(),
            label: map.label.clone(),
            x: shown.x.low..shown.x.high,
            y: shown.y.low..shown.y.high,
            colors: match map.reduction {
                Reduction::Extreme { .. } => Colors::about_zero(magnitudes([shown].into_iter())[1]),
                Reduction::Max { .. } => Colors::Powers,
            },
            reduced: Some(Box::new(map.clone())),
            ..Chart::default()
        }
    }

    pub fn is_map(&self) -> bool {
        self.reduced.is_some() || self.values.dim() != (0, 0)
    }

    /// The same with a logarithmic vertical axis, over points and bands that are positive.
    pub fn logarithmic(self) -> Chart {
        let points = self.series.iter().flat_map(|series| &series.points);
        let bands = self.series.iter().flat_map(|series| &series.band);
        let ends = bands.flat_map(|band| band.ends.iter().flat_map(|(low, high)| [*low, *high]));
        let values = points.map(|point| point.1).chain(ends);
        let y = extent(values.filter(|y| *y > 0.0));
        Chart {
            y: 0.5 * y.start.max(y.end * 10f64.powi(-DECADES))..2.0 * y.end,
            log_y: true,
            ..self
        }
    }

    /// The same with a line at 0, over the bars of all points.
    pub fn about_zero(self) -> Chart {
        let bars = self.series.iter().flat_map(|series| {
            let errors = series.errors.iter().chain(std::iter::repeat(&0.0));
            let points = series.points.iter().zip(errors);
            points.flat_map(|((_, value), error)| [value - error, value + error])
        });
        let y = extent(bars.chain([0.0]));
        let space = 0.05 * (y.end - y.start);
        Chart {
            y: y.start - space..y.end + space,
            levels: vec![Level::zero()],
            ..self
        }
    }
}

/// The range of a linear axis that shows all of `values`, and zero.
pub fn around(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((0.0f64, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
    let room = 0.04 * (high - low);
    let below = if low < 0.0 { room } else { 0.0 };
    match high - low {
        0.0 => 0.0..1.0,
        _ => low - below..high + room,
    }
}

/// The range of finite values, never empty.
pub fn extent(values: impl Iterator<Item = f64>) -> Range<f64> {
    let finite = values.filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    match high - low {
        width if width > 0.0 => low..high,
        _ if low.is_finite() => low - 0.5 * low.abs().max(1.0)..low + 0.5 * low.abs().max(1.0),
        _ => 0.0..1.0,
    }
}
