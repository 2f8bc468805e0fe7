//! A map of cells on axes of which the horizontal one may be logarithmic, with a colour bar.

use super::axis::{PlotAxis, Side};
use super::dispersion;
use super::heat::{self, ColorBar, Greys};
use super::legend::Entry;
use super::panel::{self, Margins, Panel};
use super::scale::Scale;
use super::scene::{Anchor, INK, Rect, Scene, WHITE};
use super::style::Style;
use super::uprights;
use crate::sheet::{Colors, HeatChart, Map, Reduction, Role};

/// The colour bar of a map, or of maps that share the scale of the first; the greys are those of all.
pub(super) fn color_bar<'a>(maps: &[&'a HeatChart], style: &Style) -> Option<ColorBar<'a>> {
    let first = maps.first()?;
    let misses = |map: &&HeatChart| map.shown_values().any(|value| !value.is_finite());
    Some(ColorBar {
        scale: first.scale(style),
        quantity: &first.label,
        greys: Greys {
            missing: maps.iter().any(misses),
            both_signs: maps.iter().any(|map| map.holds_both_signs()),
        },
    })
}

impl HeatChart {
    fn shown(&self) -> Option<&Map> {
        self.reduced.as_deref().map(Map::shown)
    }

    fn panel(&self, rect: Rect, names_x: bool) -> Panel {
        let second = |axis: usize| {
            let roles = self.roles.filter(|roles| roles[axis] == Role::Wavenumber);
            roles.and(self.second.clone())
        };
        Panel {
            rect,
            x: PlotAxis::over(&self.x_label, &self.x, self.log_x, second(0)),
            y: PlotAxis::over(&self.y_label, &self.y, false, second(1)),
            names_x,
        }
    }

    fn shown_values(&self) -> impl Iterator<Item = f64> {
        let reduced = self.shown().into_iter();
        let reduced = reduced.flat_map(|map| map.values.iter().map(|value| f64::from(*value)));
        reduced.chain(self.values.iter().copied())
    }

    fn holds_both_signs(&self) -> bool {
        self.shown().is_some_and(heat::holds_both_signs)
    }

    fn scale(&self, style: &Style) -> Scale {
        match (&self.colors, self.shared) {
            (Colors::Between(range), _) => Scale::linear(range.start, range.end),
            (Colors::Signed { limit, decades }, _) => Scale::signed(*limit, *decades),
            (Colors::Powers, Some(ends)) => Scale::fitted(ends.into_iter(), style.depth),
            (Colors::Powers, None) => Scale::fitted(self.shown_values(), style.depth),
        }
    }

    /// Names of the curves.
    pub(super) fn entries(&self) -> Vec<Entry> {
        dispersion::entries(&self.curves).collect()
    }

    /// What a cell of a frame of this size shows, and of how many samples.
    pub(super) fn cell(&self, rect: &Rect) -> (&'static str, [usize; 2]) {
        let (what, (rows, columns), shape) = match self.shown() {
            None => ("largest value", (1, 1), self.values.dim()),
            Some(map) => {
                let what = match map.reduction {
                    Reduction::Max { .. } => "largest value",
                    Reduction::Extreme { .. } => "value of largest magnitude",
                };
                (what, map.reduction.samples(), map.values.dim())
            }
        };
        let cell = heat::cell_of(rect, shape);
        (what, [rows * cell.0, columns * cell.1])
    }

    /// What is drawn beside a frame of this size, with a colour bar at this side.
    pub(super) fn margins(
        &self,
        rect: Rect,
        names_x: bool,
        bar: Option<Side>,
        style: &Style,
    ) -> Margins {
        let panel = self.panel(rect, names_x);
        let mut margins = panel.margins();
        margins.top = margins.top.max(uprights::height(&self.marks, &panel));
        if let Some((side, bar)) = bar.zip(color_bar(&[self], style)) {
            let extent = bar.extent(side, side.length(&rect));
            match side.is_upright() {
                true => margins.right = margins.right.max(extent + beside(&panel)),
                false => margins.bottom += extent,
            }
        }
        margins
    }

    pub(super) fn draw(&self, scene: &mut Scene, rect: Rect, names_x: bool, bar: Option<Side>) {
        let (panel, scale) = (self.panel(rect, names_x), self.scale(&scene.style));
        let colormap = scene.style.colormap;
        let image = match self.shown() {
            Some(map) if self.holds_both_signs() => heat::signed_image(rect, map, &scale, colormap),
            Some(map) => heat::image(rect, map.values.view(), &scale, colormap),
            None => heat::image(rect, self.values.view(), &scale, colormap),
        };
        scene.image(&image);
        let color = if scale.is_signed() { INK } else { WHITE };
        dispersion::draw(scene, &panel, &self.curves);
        uprights::draw(scene, &self.marks, &panel, color);
        for level in &self.levels {
            let inside = |y: &f64| *y > rect.top && *y < rect.bottom;
            let Some(y) = panel.place_y(level.at).filter(inside) else {
                continue;
            };
            scene.dashes(&[(rect.left, y), (rect.right, y)], color, 2.0);
            let name = if y - rect.top > 30.0 {
                y - 16.0
            } else {
                y + 16.0
            };
            panel::note(scene, &level.label, (rect.right - 10.0, name), Anchor::End);
        }
        panel.draw_axes(scene);
        if let Some((side, bar)) = bar.zip(color_bar(&[self], &scene.style)) {
            let from = match side.is_upright() {
                true => beside(&panel),
                false => panel.margins().bottom,
            };
            bar.draw(scene, rect, side, from);
        }
    }
}

/// What a second vertical axis takes right of a frame.
fn beside(panel: &Panel) -> f64 {
    match panel.y.second {
        Some(_) => panel.margins().right,
        None => 0.0,
    }
}
