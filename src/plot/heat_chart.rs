//! A map of cells on axes of which the horizontal one may be logarithmic, with a colour bar.

use super::axis::PlotAxis;
use super::dispersion;
use super::heat::{self, BarSide, ColorBar, Greys};
use super::legend::Entry;
use super::panel::{self, Margins, Panel};
use super::scale::ColorScale;
use super::scene::{Anchor, INK, Rect, Scene};
use super::style::Style;
use super::uprights;
use crate::sheet::{Colors, HeatChart, Map, Reduction, Role};

const WHITE: [u8; 3] = [255; 3];

/// The colours of maps that share them.
pub(super) struct Legend<'a> {
    scale: ColorScale,
    quantity: &'a str,
    greys: Greys,
}

impl<'a> Legend<'a> {
    /// The scale of the first map, which others share, and the greys of all.
    pub fn of(maps: &[&'a HeatChart], style: &Style) -> Option<Legend<'a>> {
        let first = maps.first()?;
        Some(Legend {
            scale: first.scale(style),
            quantity: &first.label,
            greys: Greys {
                missing: maps
                    .iter()
                    .any(|map| map.shown_values().any(|value| !value.is_finite())),
                both_signs: maps.iter().any(|map| map.holds_both_signs()),
            },
        })
    }

    pub fn bar(&self) -> ColorBar<'_> {
        ColorBar {
            scale: &self.scale,
            quantity: self.quantity,
            greys: self.greys,
        }
    }
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
        let x = PlotAxis::over(&self.x_label, &self.x, self.log_x).with_second(second(0));
        let y = PlotAxis::over(&self.y_label, &self.y, false).with_second(second(1));
        Panel {
            names_x,
            ..Panel::new(rect, x, y)
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

    fn scale(&self, style: &Style) -> ColorScale {
        match (&self.colors, self.shared) {
            (Colors::Between(range), _) => ColorScale::between(range.start, range.end),
            (Colors::Signed { limit, decades }, _) => {
                ColorScale::signed([*limit].into_iter(), *decades)
            }
            (Colors::Powers, Some(ends)) => ColorScale::log(ends.into_iter(), style.depth),
            (Colors::Powers, None) => ColorScale::log(self.shown_values(), style.depth),
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
        bar: Option<BarSide>,
        style: &Style,
    ) -> Margins {
        let panel = self.panel(rect, names_x);
        let mut margins = panel.margins();
        margins.top = margins.top.max(uprights::height(&self.marks, &panel));
        if let Some((side, legend)) = bar.zip(Legend::of(&[self], style)) {
            match side {
                BarSide::Right => {
                    let bar = legend.bar().extent(side, rect.height()) + beside(&panel);
                    margins.right = margins.right.max(bar);
                }
                BarSide::Below => margins.bottom += legend.bar().extent(side, rect.width()),
            }
        }
        margins
    }

    pub(super) fn draw(&self, scene: &mut Scene, rect: Rect, names_x: bool, bar: Option<BarSide>) {
        let (panel, scale) = (self.panel(rect, names_x), self.scale(&scene.style));
        match self.shown() {
            Some(map) if self.holds_both_signs() => heat::draw_signed(scene, &panel, map, &scale),
            Some(map) => heat::draw(scene, &panel, map.values.view(), &scale),
            None => heat::draw(scene, &panel, self.values.view(), &scale),
        }
        let color = match scale {
            ColorScale::Diverging { .. } | ColorScale::Signed { .. } => INK,
            _ => WHITE,
        };
        dispersion::draw(scene, &panel, &self.curves);
        uprights::draw(scene, &self.marks, &panel, color);
        for level in &self.levels {
            let inside = |y: &f64| *y > rect.top && *y < rect.bottom;
            let Some(y) = panel.place_y(level.at).filter(inside) else {
                continue;
            };
            scene.dashes((rect.left, y), (rect.right, y), color, 2.0);
            let name = if y - rect.top > 30.0 {
                y - 16.0
            } else {
                y + 16.0
            };
            panel::note(scene, &level.label, (rect.right - 10.0, name), Anchor::End);
        }
        panel.draw_axes(scene);
        if let Some((side, legend)) = bar.zip(Legend::of(&[self], &scene.style)) {
            let from = match side {
                BarSide::Right => beside(&panel),
                BarSide::Below => panel.margins().bottom,
            };
            legend.bar().draw(scene, rect, side, from);
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
