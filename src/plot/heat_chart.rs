//! A map of cells on axes of which the horizontal one may be logarithmic, with a colour bar.

use std::ops::Range;

use ndarray::Array2;
use plotters::coord::combinators::IntoLogRange;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

use super::canvas::{Area, px, sans};
use super::marks::{Mark, draw_marks};
use super::ticks::short;
use crate::Result;

/// Width of the colour bar with its labels, in pixels.
const BAR: f64 = 110.0;
/// Cells of the colour bar.
const STEPS: usize = 128;

/// Values over two axes, each row from the lower end of the vertical axis on.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatChart {
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    /// What the colours mean, with its unit.
    pub label: String,
    pub x: Range<f64>,
    pub y: Range<f64>,
    pub log_x: bool,
    pub values: Array2<f64>,
    /// Values at the ends of the colour scale; if symmetric about 0, the colour map is diverging.
    pub scale: Range<f64>,
    /// Uprights over the map.
    pub marks: Vec<Mark>,
}

impl HeatChart {
    /// Draws the chart into an area of a canvas.
    ///
    /// # Errors
    /// [`crate::Error::Draw`].
    pub fn draw(&self, area: &Area) -> Result<()> {
        let (width, _) = area.dim_in_pixel();
        let bar = px(BAR).min(width / 3);
        let (map, side) = area.split_horizontally(width - bar);
        match self.log_x {
            true => self.on(&map, self.x.clone().log_scale())?,
            false => self.on(&map, self.x.clone())?,
        }
        self.bar(&side)
    }

    fn on<X>(
        &self,
        area: &Area,
        x: impl AsRangedCoord<CoordDescType = X, Value = f64>,
    ) -> Result<()>
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let mut chart = ChartBuilder::on(area)
            .margin(px(14.0))
            .margin_right(px(18.0))
            .caption(&self.title, sans(18.0))
            .x_label_area_size(px(52.0))
            .y_label_area_size(px(70.0))
            .build_cartesian_2d(x, self.y.clone())?;
        let (rows, columns) = self.values.dim();
        let across = |j: f64| {
            let share = j / columns as f64;
            match self.log_x {
                true => self.x.start * (self.x.end / self.x.start).powf(share),
                false => self.x.start + (self.x.end - self.x.start) * share,
            }
        };
        let up = |i: f64| self.y.start + (self.y.end - self.y.start) * i / rows as f64;
        chart.draw_series(self.values.indexed_iter().map(|((i, j), value)| {
            let (i, j) = (i as f64, j as f64);
            // A little over, so that no ground shows between cells.
            let far = (
                across((j + 1.05).min(columns as f64)),
                up((i + 1.05).min(rows as f64)),
            );
            Rectangle::new([(across(j), up(i)), far], self.colour(*value).filled())
        }))?;
        draw_marks(&mut chart, &self.marks, (self.y.start, self.y.end), WHITE)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .label_style(sans(15.0))
            .axis_desc_style(sans(16.0))
            .set_all_tick_mark_size(px(5.0))
            .x_labels(8)
            .y_labels(7)
            .x_label_formatter(&|v| short(*v, &self.x, self.log_x))
            .y_label_formatter(&|v| short(*v, &self.y, false))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .draw()?;
        Ok(())
    }

    fn bar(&self, area: &Area) -> Result<()> {
        let mut chart = ChartBuilder::on(area)
            .margin_top(px(48.0))
            .margin_bottom(px(66.0))
            .margin_right(px(10.0))
            .y_label_area_size(px(80.0))
            .build_cartesian_2d(0.0..1.0, self.scale.clone())?;
        let step = (self.scale.end - self.scale.start) / STEPS as f64;
        chart.draw_series((0..STEPS).map(|i| {
            let low = self.scale.start + step * i as f64;
            let high = (low + 1.2 * step).min(self.scale.end);
            let colour = self.colour(low + 0.5 * step);
            Rectangle::new([(0.0, low), (1.0, high)], colour.filled())
        }))?;
        chart
            .configure_mesh()
            .disable_mesh()
            .disable_x_axis()
            .label_style(sans(14.0))
            .axis_desc_style(sans(15.0))
            .y_labels(6)
            .y_label_formatter(&|v| short(*v, &self.scale, false))
            .y_desc(&self.label)
            .draw()?;
        Ok(())
    }

    fn colour(&self, value: f64) -> RGBColor {
        if !value.is_finite() {
            return RGBColor(0xcc, 0xcc, 0xcc);
        }
        let share = (value - self.scale.start) / (self.scale.end - self.scale.start);
        let share = share.clamp(0.0, 1.0);
        let symmetric = self.scale.start == -self.scale.end;
        let colour = match symmetric {
            true => colorous::RED_BLUE.eval_continuous(1.0 - share),
            false => colorous::CIVIDIS.eval_continuous(share),
        };
        RGBColor(colour.r, colour.g, colour.b)
    }
}
