//! A map of cells on axes of which the horizontal one may be logarithmic, with a colour bar.

use std::ops::Range;

use ndarray::Array2;

use super::axis::PlotAxis;
use super::heat::{self, BarSide, ColorBar, Greys};
use super::panel::{Margins, Panel};
use super::scale::ColorScale;
use super::scene::{Rect, Scene};
use super::uprights::{self, Mark};

const WHITE: [u8; 3] = [255; 3];

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
    /// Whether columns are evenly spaced in the logarithm of x.
    pub log_x: bool,
    pub values: Array2<f64>,
    /// Values at the ends of the colour scale; if symmetric about 0, the colour map is diverging.
    pub scale: Range<f64>,
    /// Uprights over the map.
    pub marks: Vec<Mark>,
}

impl HeatChart {
    pub(super) fn panel(&self, rect: Rect, names_x: bool) -> Panel {
        let x = PlotAxis::over(&self.x_label, &self.x, self.log_x);
        let y = PlotAxis::over(&self.y_label, &self.y, false);
        Panel {
            names_x,
            ..Panel::new(rect, x, y)
        }
    }

    fn color_scale(&self) -> ColorScale {
        ColorScale::between(self.scale.start, self.scale.end)
    }

    fn bar<'a>(&'a self, scale: &'a ColorScale) -> ColorBar<'a> {
        ColorBar {
            scale,
            quantity: &self.label,
            greys: Greys {
                missing: self.values.iter().any(|value| !value.is_finite()),
                ..Greys::default()
            },
        }
    }

    /// What is drawn beside a frame of this size.
    pub(super) fn margins(&self, rect: Rect, names_x: bool) -> Margins {
        let panel = self.panel(rect, names_x);
        let margins = panel.margins();
        let scale = self.color_scale();
        let bar = self.bar(&scale).extent(BarSide::Right, rect.height());
        Margins {
            right: margins.right.max(bar),
            top: margins.top.max(uprights::height(&self.marks, &panel)),
            ..margins
        }
    }

    pub(super) fn draw(&self, scene: &mut Scene, rect: Rect, names_x: bool) {
        let (panel, scale) = (self.panel(rect, names_x), self.color_scale());
        heat::draw(scene, &panel, self.values.view(), &scale);
        uprights::draw(scene, &self.marks, &panel, WHITE);
        panel.draw_axes(scene);
        self.bar(&scale).draw(scene, rect, BarSide::Right, 0.0);
    }
}
