//! A map of cells on axes of which the horizontal one may be logarithmic, with a colour bar.

use super::axis::PlotAxis;
use super::dispersion;
use super::figures::WHITE;
use super::heat::{self, BarSide, ColorBar, Greys};
use super::legend::Entry;
use super::panel::{Margins, Panel};
use super::scale::ColorScale;
use super::scene::{Rect, Scene};
use super::style::Depth;
use super::uprights;
use crate::sheet::{Colors, HeatChart};

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
        match &self.colors {
            Colors::Between(range) => ColorScale::between(range.start, range.end),
            Colors::Powers => ColorScale::log(self.values.iter().copied(), Depth::Fitted),
        }
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

    /// Names of the curves.
    pub(super) fn entries(&self) -> Vec<Entry> {
        dispersion::entries(&self.curves).collect()
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
        dispersion::draw(scene, &panel, &self.curves);
        uprights::draw(scene, &self.marks, &panel, WHITE);
        panel.draw_axes(scene);
        self.bar(&scale).draw(scene, rect, BarSide::Right, 0.0);
    }
}
