//! A figure as marks in units of its layout, before any file format.

use plotters_backend::text_anchor::{HPos, Pos, VPos};
use plotters_backend::{BackendColor, FontTransform};

use super::painter::{Brush, Lettering, Outline, Painter, Point, Raster};
use super::style::Style;

/// Red, green, blue.
pub(crate) type Color = [u8; 3];

pub(super) const INK: Color = [0x22, 0x22, 0x22];
pub(super) const FAINT: Color = [0x66, 0x66, 0x66];
pub(super) const GRID: Color = [0xdd, 0xdd, 0xdd];

/// An axis-parallel rectangle; `top` is nearer to the figure's top edge than `bottom`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rect {
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    pub fn middle(&self) -> Point {
        (
            (self.left + self.right) / 2.0,
            (self.top + self.bottom) / 2.0,
        )
    }

    pub fn contains(&self, (x, y): Point) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }

    /// The part of a straight line that lies inside.
    fn clip(&self, from: Point, to: Point) -> Option<[Point; 2]> {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        let sides = [
            (-dx, from.0 - self.left),
            (dx, self.right - from.0),
            (-dy, from.1 - self.top),
            (dy, self.bottom - from.1),
        ];
        for (speed, room) in sides {
            match room / speed {
                _ if speed == 0.0 && room < 0.0 => return None,
                _ if speed == 0.0 => {}
                share if speed < 0.0 => enter = enter.max(share),
                share => leave = leave.min(share),
            }
        }
        let at = |share: f64| (from.0 + share * dx, from.1 + share * dy);
        (enter <= leave).then(|| [at(enter), at(leave)])
    }

    /// The parts of a path that lie inside.
    pub fn clip_path(&self, path: Vec<Point>) -> Vec<Vec<Point>> {
        if path.iter().all(|point| self.contains(*point)) {
            return vec![path];
        }
        let mut parts: Vec<Vec<Point>> = Vec::new();
        for pair in path.windows(2) {
            let Some([from, to]) = self.clip(pair[0], pair[1]) else {
                continue;
            };
            match parts.last_mut() {
                Some(part) if part.last() == Some(&from) => part.push(to),
                _ => parts.push(vec![from, to]),
            }
        }
        parts
    }
}

/// A raster of palette indices, stretched over `at`; row 0 is at the top.
#[derive(Debug)]
pub(super) struct Image {
    pub at: Rect,
    pub columns: usize,
    pub rows: usize,
    pub palette: Vec<Color>,
    pub cells: Vec<u8>,
}

/// The point of a text at its coordinates; vertically always the middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// One line of text; `size` is the em.
#[derive(Debug)]
pub(super) struct Text {
    pub text: String,
    pub at: (f64, f64),
    pub size: f64,
    pub color: Color,
    pub anchor: Anchor,
    /// Reads from bottom to top.
    pub vertical: bool,
}

impl Text {
    fn lettering(&self) -> Lettering {
        let across = match self.anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        Lettering {
            size: self.size,
            color: opaque(self.color),
            anchor: Pos::new(across, VPos::Center),
            turn: match self.vertical {
                true => FontTransform::Rotate270,
                false => FontTransform::None,
            },
        }
    }
}

fn opaque([red, green, blue]: Color) -> BackendColor {
    BackendColor {
        alpha: 1.0,
        rgb: (red, green, blue),
    }
}

#[derive(Debug)]
pub(super) enum Mark {
    Image(Image),
    Line {
        points: Vec<(f64, f64)>,
        color: Color,
        width: f64,
    },
    Fill {
        rect: Rect,
        color: Color,
    },
    Disk {
        center: Point,
        radius: f64,
        color: Color,
    },
    Polygon {
        corners: Vec<Point>,
        color: Color,
    },
    Text(Text),
}

/// Marks in painting order on a white ground.
#[derive(Debug)]
pub(super) struct Scene {
    pub title: String,
    pub width: f64,
    pub height: f64,
    pub style: Style,
    pub marks: Vec<Mark>,
}

impl Scene {
    /// As wide as the style says.
    pub fn new(title: &str, style: &Style, height: f64) -> Self {
        Scene {
            title: title.into(),
            width: style.columns(),
            height,
            style: *style,
            marks: Vec::new(),
        }
    }

    /// Paints every mark.
    pub fn paint(&self, painter: &mut dyn Painter) -> Result<(), String> {
        for mark in &self.marks {
            let (shape, brush, color) = match mark {
                Mark::Image(image) => {
                    let raster = Raster {
                        columns: image.columns,
                        rows: image.rows,
                        palette: Some(&image.palette),
                        samples: &image.cells,
                    };
                    painter.image(&image.at, &raster)?;
                    continue;
                }
                Mark::Text(text) => {
                    painter.text(&text.text, text.at, &text.lettering())?;
                    continue;
                }
                Mark::Line {
                    points,
                    color,
                    width,
                } => (Outline::Path(points), Brush::Stroke(width.max(1.0)), color),
                Mark::Fill { rect, color } => (Outline::Rect(*rect), Brush::Fill, color),
                Mark::Disk {
                    center,
                    radius,
                    color,
                } => {
                    let (center, radius) = (*center, *radius);
                    (Outline::Circle { center, radius }, Brush::Fill, color)
                }
                Mark::Polygon { corners, color } => (Outline::Path(corners), Brush::Fill, color),
            };
            painter.shape(&shape, brush, opaque(*color));
        }
        Ok(())
    }

    pub fn line(&mut self, points: Vec<(f64, f64)>, color: Color, width: f64) {
        self.marks.push(Mark::Line {
            points,
            color,
            width,
        });
    }

    pub fn polygon(&mut self, corners: Vec<Point>, color: Color) {
        self.marks.push(Mark::Polygon { corners, color });
    }

    /// A straight line of dashes.
    pub fn dashes(&mut self, from: Point, to: Point, color: Color, width: f64) {
        self.dashed_path(&[from, to], color, width);
    }

    /// A path of dashes 9 units long, 6 apart, across its corners.
    pub fn dashed_path(&mut self, path: &[Point], color: Color, width: f64) {
        const PERIOD: f64 = 15.0;
        const DASH: f64 = 9.0;
        let mut passed = 0.0;
        let mut dash: Vec<Point> = Vec::new();
        for pair in path.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            let along = |s: f64| {
                let share = s / length;
                (
                    from.0 + (to.0 - from.0) * share,
                    from.1 + (to.1 - from.1) * share,
                )
            };
            let mut at = 0.0;
            while at < length {
                let phase = (passed + at) % PERIOD;
                let end = if phase < DASH { DASH } else { PERIOD };
                // A step below rounding would never end.
                let next = (at + (end - phase).max(1e-6)).min(length);
                if phase < DASH {
                    if dash.is_empty() {
                        dash.push(along(at));
                    }
                    dash.push(along(next));
                } else if !dash.is_empty() {
                    self.line(std::mem::take(&mut dash), color, width);
                }
                at = next;
            }
            passed += length;
        }
        if dash.len() > 1 {
            self.line(dash, color, width);
        }
    }

    pub fn fill(&mut self, rect: Rect, color: Color) {
        self.marks.push(Mark::Fill { rect, color });
    }

    pub fn outline(&mut self, rect: Rect, color: Color) {
        let Rect {
            left,
            top,
            right,
            bottom,
        } = rect;
        let corners = vec![
            (left, top),
            (right, top),
            (right, bottom),
            (left, bottom),
            (left, top),
        ];
        self.line(corners, color, 1.0);
    }

    pub fn text(&mut self, text: impl Into<String>, at: (f64, f64), size: f64, anchor: Anchor) {
        self.marks.push(Mark::Text(Text {
            text: text.into(),
            at,
            size,
            color: INK,
            anchor,
            vertical: false,
        }));
    }

    /// Lines of text from `y` down, `size` apart by a fifth more.
    pub fn lines(&mut self, lines: &[String], (x, y): Point, size: f64, anchor: Anchor) {
        for (index, line) in lines.iter().enumerate() {
            let y = y + 1.25 * size * index as f64;
            self.text(line.clone(), (x, y), size, anchor);
        }
    }
}
