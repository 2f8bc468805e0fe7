//! A figure as marks in design pixels, before any file format.

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

/// Which point of a text lies at its coordinates; vertically it is always the middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// One line of text; `size` is the em in pixels.
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
    Text(Text),
}

/// Marks in painting order on a white ground.
#[derive(Debug)]
pub(super) struct Scene {
    pub title: String,
    pub width: u32,
    pub height: u32,
    pub marks: Vec<Mark>,
}

impl Scene {
    pub fn new(title: &str, width: u32, height: u32) -> Self {
        Scene {
            title: title.into(),
            width,
            height,
            marks: Vec::new(),
        }
    }

    pub fn line(&mut self, points: Vec<(f64, f64)>, color: Color, width: f64) {
        self.marks.push(Mark::Line {
            points,
            color,
            width,
        });
    }

    /// A straight line of dashes 9 pixels long.
    pub fn dashes(&mut self, from: (f64, f64), to: (f64, f64), color: Color, width: f64) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = dx.hypot(dy);
        let along = |s: f64| (from.0 + dx * s / length, from.1 + dy * s / length);
        let mut start = 0.0;
        while start < length {
            let end = (start + 9.0).min(length);
            self.line(vec![along(start), along(end)], color, width);
            start += 15.0;
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
}
