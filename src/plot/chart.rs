//! One pair of axes with lines, dots and marks, linear or logarithmic, and with the cells of a map.

use super::axis::{PlotAxis, Side};
use super::heat_chart::color_bar;
use super::legend::{self, Entry, Stroke};
use super::panel::{self, Margins, Panel};
use super::scene::{Anchor, Color, FAINT, INK, Point, Rect, Scene, WHITE};
use super::{Style, curve, dispersion, uprights};
use crate::sheet::{Band, Chart, Look, Marker, PALETTE, Role, Series, Weight};

/// Symbols of points, one a round through the palette.
const SYMBOLS: [Marker; 4] = [
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
    Marker::Cross,
];
/// Units from one point to the next on average from which on a curve has its points marked.
const MARKED_FROM: f64 = 14.0;

impl Series {
    /// The colour of its area.
    fn tint(&self) -> Color {
        self.color().map(|c| 255 - (255 - c) / 10 * 3)
    }

    /// From the upper ends to the lower ones, as far as they are inside the frame.
    fn draw_band(&self, scene: &mut Scene, panel: &Panel, band: &Band) {
        let scale = &panel.y.scale;
        let paths = |of: fn(&(f64, f64)) -> f64| {
            let ends = self.points.iter().zip(&band.ends);
            let ends = ends.map(
                |((x, _), ends)| match ends.0.is_finite() && ends.1.is_finite() {
                    true => (*x, of(ends).clamp(scale.low, scale.high)),
                    false => (*x, f64::NAN),
                },
            );
            curve::paths(&ends.collect::<Vec<Point>>(), panel)
        };
        for (upper, lower) in paths(|ends| ends.1).into_iter().zip(paths(|ends| ends.0)) {
            let corners: Vec<Point> = upper.into_iter().chain(lower.into_iter().rev()).collect();
            scene.polygon(&corners, self.tint());
        }
    }

    fn color(&self) -> Color {
        PALETTE[self.colour % PALETTE.len()]
    }

    /// Of the line.
    fn width(&self) -> f64 {
        match self.weight {
            Weight::Thin => 1.4,
            Weight::Normal => 2.4,
            Weight::Bold => 3.6,
            Weight::Gap => 5.0,
        }
    }

    /// The symbol of each point in a frame of this width.
    fn symbol(&self, width: f64) -> Option<Marker> {
        let round = self.colour / PALETTE.len();
        let is_marked = round > 0 || width / self.points.len() as f64 >= MARKED_FROM;
        let usual = Some(self.marker.unwrap_or(SYMBOLS[round % SYMBOLS.len()]));
        match self.look {
            Look::Dots => usual,
            Look::Line if is_marked => usual,
            _ => self.marker,
        }
    }

    fn stroke(&self) -> Stroke {
        match self.look {
            Look::Line => Stroke::Solid,
            Look::Dashed => Stroke::Dashed,
            Look::Dots => Stroke::Nothing,
        }
    }

    fn entry(&self, width: f64) -> Entry {
        Entry {
            marker: self.symbol(width),
            ..Entry::new(&self.label, self.color(), self.stroke(), self.width())
        }
    }

    pub(super) fn draw(&self, scene: &mut Scene, panel: &Panel) {
        let (color, symbol) = (self.color(), self.symbol(panel.rect.width()));
        if let Some(band) = &self.band {
            self.draw_band(scene, panel, band);
        }
        if self.look != Look::Dots {
            for path in curve::paths(&self.points, panel) {
                match self.look {
                    _ if curve::is_a_dot(&path) => {
                        legend::draw_marker(scene, Marker::Circle, path[0], color);
                    }
                    Look::Dashed => scene.dashes(&path, color, self.width()),
                    _ => scene.line(&path, color, self.width()),
                }
            }
        }
        for (point, error) in self.points.iter().zip(&self.errors) {
            let ends = [point.1 - error, point.1 + error];
            for bar in curve::paths(&ends.map(|y| (point.0, y)), panel) {
                scene.line(&bar, color, self.width());
            }
        }
        let Some(symbol) = symbol else { return };
        // Symbols of a curve of many points stand apart.
        let dense = MARKED_FROM * self.points.len() as f64 / panel.rect.width();
        let is_dense = self.look == Look::Line && dense > 1.0;
        let step = if is_dense { 4.0 * dense } else { 1.0 };
        for &(x, y) in self.points.iter().step_by(step as usize) {
            let place = (panel.place_x(x), panel.place_y(y));
            if let (Some(x), Some(y)) = place
                && panel.rect.contains((x, y))
            {
                legend::draw_marker(scene, symbol, (x, y), color);
            }
        }
    }
}

impl Chart {
    fn panel(&self, rect: Rect, names_x: bool) -> Panel {
        let second = |axis: usize| {
            let second = self.second.clone();
            second.filter(|_| self.roles[axis] == Some(Role::Wavenumber))
        };
        Panel {
            rect,
            x: PlotAxis::over(&self.x_label, &self.x, self.log_x, second(0)),
            y: PlotAxis::over(&self.y_label, &self.y, self.log_y, second(1)),
            names_x,
        }
    }

    /// Meanings of the curves in a frame of this width.
    pub(super) fn entries(&self, width: f64) -> Vec<Entry> {
        let named = self.series.iter().filter(|series| !series.label.is_empty());
        let levels = self.levels.iter().filter(|level| !level.label.is_empty());
        let bands = self.series.iter().filter_map(|series| {
            let band = series.band.as_ref().filter(|band| !band.label.is_empty())?;
            Some(Entry::new(&band.label, series.tint(), Stroke::Solid, 9.0))
        });
        // Those of maps are named where they are.
        let levels = levels.filter(|_| !self.is_map());
        let levels = levels.map(|level| Entry::new(&level.label, FAINT, Stroke::Dashed, 1.6));
        named
            .map(|series| series.entry(width))
            .chain(bands)
            .chain(levels)
            .chain(dispersion::entries(&self.curves))
            .collect()
    }

    /// What is drawn beside a frame of this size, with the colour bar of a map at this side.
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
        let (panel, is_map) = (self.panel(rect, names_x), self.is_map());
        let scale = self.scale(&scene.style);
        let color = match (is_map, scale.is_signed()) {
            (false, _) => FAINT,
            (true, true) => INK,
            (true, false) => WHITE,
        };
        match is_map {
            true => scene.image(&self.image(rect, &scale, scene.style.colormap)),
            false => panel.draw_grid(scene),
        }
        dispersion::draw(scene, &panel, &self.curves);
        uprights::draw(scene, &self.marks, &panel, color);
        for level in &self.levels {
            let inside = |y: &f64| *y > rect.top && *y < rect.bottom;
            let Some(y) = panel.place_y(level.at).filter(inside) else {
                continue;
            };
            let width = if is_map { 2.0 } else { 1.6 };
            scene.dashes(&[(rect.left, y), (rect.right, y)], color, width);
            if is_map {
                let name = if y - rect.top > 30.0 {
                    y - 16.0
                } else {
                    y + 16.0
                };
                panel::note(scene, &level.label, (rect.right - 10.0, name), Anchor::End);
            }
        }
        for series in &self.series {
            series.draw(scene, &panel);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_curves_than_colours_stay_apart() {
        let points: Vec<(f64, f64)> = (0..200).map(|n| (f64::from(n), 0.0)).collect();
        let entries: Vec<Entry> = (0..2 * PALETTE.len())
            .map(|i| Series::line("", i, points.clone()).entry(400.0))
            .collect();
        for (i, entry) in entries.iter().enumerate() {
            assert!(!entries[..i].contains(entry), "{i}");
        }
    }
}
