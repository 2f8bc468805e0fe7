//! Panels of curves with separate axes.

use std::ops::Range;

use plotters::prelude::*;

use super::Format;
use super::canvas::{Area, Canvas, px, sans};
use crate::Result;

/// A curve by its name, which may be empty, and its points.
pub type Curve = (&'static str, Vec<(f64, f64)>);

/// Curves on one pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    pub title: String,
    pub x_label: &'static str,
    pub y_label: &'static str,
    pub x: Range<f64>,
    pub y: Range<f64>,
    pub curves: Vec<Curve>,
}

/// Okabe and Ito's blue, vermillion, green and purple.
const COLOURS: [RGBColor; 4] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
];
const GRID: RGBColor = RGBColor(0xe6, 0xe6, 0xe6);
const SIZE: (u32, u32) = (560, 330);

/// The bytes of a picture of the panels, in rows of `columns`.
///
/// # Errors
/// [`crate::Error::Draw`].
pub fn draw_panels(
    title: &str,
    columns: usize,
    panels: &[Panel],
    format: Format,
) -> Result<Vec<u8>> {
    let columns = columns.max(1);
    let rows = panels.len().div_ceil(columns);
    let (width, height) = (SIZE.0 * columns as u32, SIZE.1 * rows as u32);
    let canvas = Canvas::new(title, width, height, format)?;
    let areas = canvas.area().split_evenly((rows, columns));
    for (panel, area) in panels.iter().zip(&areas) {
        draw(panel, area)?;
    }
    canvas.encode()
}

fn draw(panel: &Panel, area: &Area) -> Result<()> {
    let mut chart = ChartBuilder::on(area)
        .margin(px(16.0))
        .margin_right(px(36.0))
        .caption(&panel.title, sans(17.0))
        .x_label_area_size(px(48.0))
        .y_label_area_size(px(72.0))
        .build_cartesian_2d(panel.x.clone(), panel.y.clone())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .label_style(sans(14.0))
        .axis_desc_style(sans(15.0))
        .set_all_tick_mark_size(px(5.0))
        .x_labels(7)
        .y_labels(6)
        .x_desc(panel.x_label)
        .y_desc(panel.y_label)
        .draw()?;
    let named = panel.curves.iter().any(|(label, _)| !label.is_empty());
    for ((label, points), colour) in panel.curves.iter().zip(COLOURS.into_iter().cycle()) {
        let style = colour.stroke_width(px(2.0));
        let series = chart.draw_series(LineSeries::new(points.iter().copied(), style))?;
        series
            .label(*label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + px(22.0) as i32, y)], style));
    }
    if named {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .legend_area_size(px(30.0))
            .label_font(sans(14.0))
            .background_style(WHITE.mix(0.8))
            .margin(px(6.0))
            .draw()?;
    }
    Ok(())
}

/// A range that holds 0 and all values of the curves, with a margin.
pub fn around(curves: &[Curve]) -> Range<f64> {
    let values = curves.iter().flat_map(|(_, points)| points).map(|p| p.1);
    let (low, high) = values.fold((0.0f64, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
    let margin = 0.08 * (high - low);
    low - margin..high + margin
}
