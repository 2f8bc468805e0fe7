//! One pair of axes with lines, dots and marks, linear or logarithmic.

use std::ops::Range;

use super::axis::PlotAxis;
use super::curve;
use super::legend::{self, Entry, Marker, Stroke};
use super::panel::{Margins, Panel};
use super::scene::{Color, FAINT, Rect, Scene};
use super::uprights::{self, Mark};

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
pub(super) const BLUE: usize = 0;
pub(super) const VERMILLION: usize = 1;
pub(super) const GREEN: usize = 2;
pub(super) const PURPLE: usize = 3;
pub(super) const ORANGE: usize = 4;
pub(super) const SKY: usize = 5;
pub(super) const BLACK: usize = 6;

/// Symbols of points, one a round through the palette.
const SYMBOLS: [Marker; 4] = [
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
    Marker::Cross,
];
const WIDTH: f64 = 2.4;
/// Units from one point to the next on average from which on a curve has its points marked.
const MARKED_FROM: f64 = 14.0;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// A line; its points are marked where they are few.
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
#[derive(Debug, Clone, PartialEq)]
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
    /// Width of the line, in units of 1/20 of the size of labels.
    pub width: f64,
}

impl Series {
    pub fn line(label: impl Into<String>, colour: usize, points: Vec<(f64, f64)>) -> Series {
        Series {
            label: label.into(),
            points,
            errors: Vec::new(),
            band: None,
            look: Look::Line,
            colour,
            marker: None,
            width: WIDTH,
        }
    }

    /// A line through values at `x`.
    pub fn of(label: impl Into<String>, colour: usize, x: &[f64], y: &[f64]) -> Series {
        let points = x.iter().copied().zip(y.iter().copied());
        Series::line(label, colour, points.collect())
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

    /// With an area below the line.
    pub fn with_band(self, label: impl Into<String>, ends: Vec<(f64, f64)>) -> Series {
        let label = label.into();
        Series {
            band: Some(Band { label, ends }),
            ..self
        }
    }

    /// The colour of its area.
    fn tint(&self) -> Color {
        self.color().map(|c| 255 - (255 - c) / 10 * 3)
    }

    fn draw_band(&self, scene: &mut Scene, panel: &Panel, band: &Band) {
        let rect = panel.rect;
        // One column of the picture has one lower and one upper end.
        let mut columns: Vec<Option<[f64; 3]>> = Vec::new();
        for ((x, _), (low, high)) in self.points.iter().zip(&band.ends) {
            let placed = (panel.place_x(*x), panel.place_y(*low), panel.place_y(*high));
            let (Some(x), Some(low), Some(high)) = placed else {
                columns.push(None);
                continue;
            };
            if x < rect.left || x > rect.right {
                continue;
            }
            let inside = |y: f64| y.clamp(rect.top, rect.bottom);
            let [low, high] = [inside(low), inside(high)];
            match columns.last_mut() {
                Some(Some([at, top, bottom])) if at.floor() == x.floor() => {
                    (*top, *bottom) = (top.min(high), bottom.max(low));
                }
                _ => columns.push(Some([x, high, low])),
            }
        }
        for part in columns.split(|column| column.is_none()) {
            let upper = part.iter().flatten().map(|[x, top, _]| (*x, *top));
            let lower = part.iter().flatten().map(|[x, _, bottom]| (*x, *bottom));
            if part.len() > 1 {
                scene.polygon(upper.chain(lower.rev()).collect(), self.tint());
            }
        }
    }

    fn color(&self) -> Color {
        PALETTE[self.colour % PALETTE.len()]
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
            label: self.label.clone(),
            color: self.color(),
            stroke: self.stroke(),
            width: self.width,
            marker: self.symbol(width),
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
                    Look::Dashed => scene.dashed_path(&path, color, self.width),
                    _ => scene.line(path, color, self.width),
                }
            }
        }
        for (point, error) in self.points.iter().zip(&self.errors) {
            let ends = [point.1 - error, point.1 + error];
            for bar in curve::paths(&ends.map(|y| (point.0, y)), panel) {
                scene.line(bar, color, self.width);
            }
        }
        let Some(symbol) = symbol else { return };
        for &(x, y) in &self.points {
            let place = (panel.place_x(x), panel.place_y(y));
            if let (Some(x), Some(y)) = place
                && panel.rect.contains((x, y))
            {
                legend::draw_marker(scene, symbol, (x, y), color);
            }
        }
    }
}

/// A dashed line across a chart at a value, with its name.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    pub at: f64,
    /// Empty for a line without a name.
    pub label: String,
}

/// Series on one pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Above the frame; may be empty.
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    pub x: Range<f64>,
    pub y: Range<f64>,
    pub log_x: bool,
    pub log_y: bool,
    pub series: Vec<Series>,
    /// Uprights with their names.
    pub marks: Vec<Mark>,
    pub levels: Vec<Level>,
    /// Label of a second reading of the vertical axis, and what values are multiplied by for it.
    pub second_y: Option<(String, f64)>,
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
            levels: Vec::new(),
            second_y: None,
        }
    }

    pub(super) fn panel(&self, rect: Rect, names_x: bool) -> Panel {
        let x = PlotAxis::over(&self.x_label, &self.x, self.log_x);
        let y = PlotAxis::over(&self.y_label, &self.y, self.log_y);
        Panel {
            names_x,
            ..Panel::new(rect, x, y.with_second(self.second_y.clone()))
        }
    }

    /// Meanings of the curves in a frame of this width.
    pub(super) fn entries(&self, width: f64) -> Vec<Entry> {
        let named = self.series.iter().filter(|series| !series.label.is_empty());
        let levels = self.levels.iter().filter(|level| !level.label.is_empty());
        let bands = self.series.iter().filter_map(|series| {
            let band = series.band.as_ref().filter(|band| !band.label.is_empty())?;
            Some(Entry {
                width: 9.0,
                ..Entry::line(&band.label, series.tint())
            })
        });
        named
            .map(|series| series.entry(width))
            .chain(bands)
            .chain(levels.map(|level| Entry::dashed(&level.label, FAINT)))
            .collect()
    }

    /// What is drawn beside a frame of this size.
    pub(super) fn margins(&self, rect: Rect, names_x: bool) -> Margins {
        let panel = self.panel(rect, names_x);
        let margins = panel.margins();
        Margins {
            top: margins.top.max(uprights::height(&self.marks, &panel)),
            ..margins
        }
    }

    pub(super) fn draw(&self, scene: &mut Scene, rect: Rect, names_x: bool) {
        let panel = self.panel(rect, names_x);
        panel.draw_grid(scene);
        uprights::draw(scene, &self.marks, &panel, FAINT);
        for level in &self.levels {
            if let Some(y) = panel.place_y(level.at) {
                for path in rect.clip_path(vec![(rect.left, y), (rect.right, y)]) {
                    scene.dashed_path(&path, FAINT, 1.6);
                }
            }
        }
        for series in &self.series {
            series.draw(scene, &panel);
        }
        panel.draw_axes(scene);
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
