//! One pair of axes with lines, dots and marks, linear or logarithmic.

use std::ops::Range;

use plotters::coord::combinators::IntoLogRange;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;

use super::Format;
use super::canvas::{Area, Canvas, px, sans};
use super::marks::{Mark, draw_marks};
use super::ticks::short;
use crate::Result;

/// Colours of Okabe and Ito, safe for colour-blind readers.
pub const PALETTE: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x00, 0x00, 0x00),
];
const GRID: RGBColor = RGBColor(0xe6, 0xe6, 0xe6);
const MARK: RGBColor = RGBColor(0x77, 0x77, 0x77);

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    Line,
    Dashed,
    Dots,
}

/// Points with a name, which may be empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub label: String,
    pub points: Vec<(f64, f64)>,
    /// Standard errors of the ordinates; empty where there are none.
    pub errors: Vec<f64>,
    pub look: Look,
    /// Index into [`PALETTE`].
    pub colour: usize,
}

impl Series {
    pub fn line(label: impl Into<String>, colour: usize, points: Vec<(f64, f64)>) -> Series {
        Series {
            label: label.into(),
            points,
            errors: Vec::new(),
            look: Look::Line,
            colour,
        }
    }

    pub fn with(self, look: Look) -> Series {
        Series { look, ..self }
    }
}

/// Series on one pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    pub x: Range<f64>,
    pub y: Range<f64>,
    pub log_x: bool,
    pub log_y: bool,
    pub series: Vec<Series>,
    pub marks: Vec<Mark>,
    /// Where the names of the series are.
    pub names: Corner,
}

/// A corner of a chart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Corner {
    #[default]
    UpperRight,
    LowerRight,
    LowerLeft,
    UpperLeft,
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
            log_x: false,
            log_y: false,
            series,
            marks: Vec::new(),
            names: Corner::default(),
        }
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

/// The bytes of a picture of charts, in rows of `columns`, each of this many pixels.
///
/// # Errors
/// [`crate::Error::Draw`].
pub fn draw_charts(
    title: &str,
    columns: usize,
    (width, height): (u32, u32),
    charts: &[Chart],
    format: Format,
) -> Result<Vec<u8>> {
    let columns = columns.max(1);
    let rows = charts.len().div_ceil(columns);
    let canvas = Canvas::new(title, width * columns as u32, height * rows as u32, format)?;
    let areas = canvas.area().split_evenly((rows, columns));
    for (chart, area) in charts.iter().zip(&areas) {
        chart.draw(area)?;
    }
    canvas.encode()
}

impl Chart {
    /// Draws the chart into an area of a canvas.
    ///
    /// # Errors
    /// [`crate::Error::Draw`].
    pub fn draw(&self, area: &Area) -> Result<()> {
        let (x, y) = (self.x.clone(), self.y.clone());
        match (self.log_x, self.log_y) {
            (false, false) => self.on(area, x, y),
            (true, false) => self.on(area, x.log_scale(), y),
            (false, true) => self.on(area, x, y.log_scale()),
            (true, true) => self.on(area, x.log_scale(), y.log_scale()),
        }
    }

    fn on<X, Y>(
        &self,
        area: &Area,
        x: impl plotters::coord::ranged1d::AsRangedCoord<CoordDescType = X, Value = f64>,
        y: impl plotters::coord::ranged1d::AsRangedCoord<CoordDescType = Y, Value = f64>,
    ) -> Result<()>
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let mut chart = ChartBuilder::on(area)
            .margin(px(14.0))
            .margin_right(px(30.0))
            .caption(&self.title, sans(18.0))
            .x_label_area_size(px(52.0))
            .y_label_area_size(px(84.0))
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .label_style(sans(15.0))
            .axis_desc_style(sans(16.0))
            .set_all_tick_mark_size(px(5.0))
            .x_labels(8)
            .y_labels(7)
            .x_label_formatter(&|v| short(*v, &self.x, self.log_x))
            .y_label_formatter(&|v| short(*v, &self.y, self.log_y))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .draw()?;
        draw_marks(&mut chart, &self.marks, (self.y.start, self.y.end), MARK)?;
        for series in &self.series {
            let colour = PALETTE[series.colour % PALETTE.len()];
            let style = colour.stroke_width(px(2.0));
            let points = series.points.iter().copied();
            let points = points.filter(|p| p.0.is_finite() && p.1.is_finite());
            for (point, error) in series.points.iter().zip(&series.errors) {
                let bar = vec![(point.0, point.1 - error), (point.0, point.1 + error)];
                chart.draw_series([PathElement::new(bar, style)])?;
            }
            let drawn = match series.look {
                Look::Line => chart.draw_series(LineSeries::new(points, style))?,
                Look::Dashed => {
                    chart.draw_series(DashedLineSeries::new(points, px(7.0), px(5.0), style))?
                }
                Look::Dots => {
                    chart.draw_series(points.map(|p| Circle::new(p, px(3.5), colour.filled())))?
                }
            };
            if series.label.is_empty() {
                continue;
            }
            let look = series.look;
            drawn.label(&series.label).legend(move |(x, y)| {
                let length = px(24.0) as i32;
                let piece = |from: i32, to: i32| PathElement::new(vec![(from, 0), (to, 0)], style);
                let at = EmptyElement::at((x, y));
                match look {
                    Look::Line => (at + piece(0, length)).into_dyn(),
                    Look::Dashed => {
                        let dash = length * 2 / 5;
                        (at + piece(0, dash) + piece(length - dash, length)).into_dyn()
                    }
                    Look::Dots => {
                        let dot = Circle::new((length / 2, 0), px(3.5), colour.filled());
                        (at + dot).into_dyn()
                    }
                }
            });
        }
        if self.series.iter().any(|s| !s.label.is_empty()) {
            let position = match self.names {
                Corner::UpperRight => SeriesLabelPosition::UpperRight,
                Corner::LowerRight => SeriesLabelPosition::LowerRight,
                Corner::LowerLeft => SeriesLabelPosition::LowerLeft,
                Corner::UpperLeft => SeriesLabelPosition::UpperLeft,
            };
            chart
                .configure_series_labels()
                .position(position)
                .legend_area_size(px(34.0))
                .label_font(sans(15.0))
                .background_style(WHITE.mix(0.85))
                .margin(px(8.0))
                .draw()?;
        }
        Ok(())
    }
}
