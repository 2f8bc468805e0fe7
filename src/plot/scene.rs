//! A figure as an SVG document in units of its layout: text stays text, pictures are embedded.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::font;
use super::raster::png;
use super::style::Style;

/// Red, green, blue.
pub(crate) type Color = [u8; 3];
pub(super) type Point = (f64, f64);

pub(super) const INK: Color = [0x22, 0x22, 0x22];
pub(super) const FAINT: Color = [0x66, 0x66, 0x66];
pub(super) const GRID: Color = [0xdd, 0xdd, 0xdd];
pub(super) const WHITE: Color = [0xff; 3];

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

/// What is painted, in its order, on a white ground.
#[derive(Debug)]
pub(super) struct Scene {
    pub title: String,
    pub width: f64,
    pub height: f64,
    pub style: Style,
    elements: String,
}

impl Scene {
    /// As wide as the style says.
    pub fn new(title: &str, style: &Style) -> Self {
        Scene {
            title: title.into(),
            width: style.columns(),
            height: 0.0,
            style: *style,
            elements: String::new(),
        }
    }

    /// The whole document.
    pub fn document(&self) -> String {
        let size = (self.width, self.height);
        let opening = opening(&self.title, size, self.style.unit_mm());
        format!("{opening}{}</svg>\n", self.elements)
    }

    fn add(&mut self, element: &str) {
        self.elements.push_str(element);
        self.elements.push('\n');
    }

    pub fn line(&mut self, points: &[Point], color: Color, width: f64) {
        self.stroke(points, color, width, "");
    }

    /// A line of dashes.
    pub fn dashes(&mut self, points: &[Point], color: Color, width: f64) {
        self.stroke(points, color, width, " stroke-dasharray=\"9 6\"");
    }

    fn stroke(&mut self, points: &[Point], color: Color, width: f64, dashes: &str) {
        let (ink, width, points) = (hex(color), width.max(1.0), list(points));
        self.add(&format!(
            "<polyline fill=\"none\" stroke=\"{ink}\" stroke-width=\"{width}\"{dashes} points=\"{points}\"/>"
        ));
    }

    pub fn polygon(&mut self, corners: &[Point], color: Color) {
        let (ink, points) = (hex(color), list(corners));
        self.add(&format!("<polyline fill=\"{ink}\" points=\"{points}\"/>"));
    }

    pub fn disk(&mut self, (x, y): Point, radius: f64, color: Color) {
        let ink = hex(color);
        self.add(&format!(
            "<circle fill=\"{ink}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"/>"
        ));
    }

    pub fn fill(&mut self, rect: Rect, color: Color) {
        let (place, ink) = (place(&rect), hex(color));
        self.add(&format!("<rect {place} fill=\"{ink}\"/>"));
    }

    /// An image whose cells keep sharp edges.
    pub fn image(&mut self, image: &Image) {
        let size = (image.columns, image.rows);
        if image.cells.is_empty() {
            return;
        }
        let png = png(size, Some(&image.palette), &image.cells, None).unwrap_or_default();
        let (place, data) = (place(&image.at), BASE64_STANDARD.encode(png));
        self.add(&format!(
            "<image {place} preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
             href=\"data:image/png;base64,{data}\"/>"
        ));
    }

    pub fn outline(&mut self, rect: Rect, color: Color) {
        let Rect {
            left,
            top,
            right,
            bottom,
        } = rect;
        let corners = [(left, top), (right, top), (right, bottom), (left, bottom)];
        self.line(&[&corners[..], &corners[..1]].concat(), color, 1.0);
    }

    pub fn text(&mut self, text: &str, at: Point, size: f64, anchor: Anchor) {
        self.letters(text, at, size, anchor, INK, "");
    }

    /// One line that reads upwards, around its middle.
    pub fn upright(&mut self, text: &str, at: Point, size: f64) {
        self.letters(text, at, size, Anchor::Middle, INK, " rotate(-90)");
    }

    /// One line; `size` is the em.
    pub fn letters(
        &mut self,
        text: &str,
        (x, y): Point,
        size: f64,
        anchor: Anchor,
        color: Color,
        turn: &str,
    ) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let (baseline, ink, text) = (font::baseline(size), hex(color), escape(text));
        self.add(&format!(
            "<text transform=\"translate({x:.1} {y:.1}){turn}\" y=\"{baseline:.1}\" font-size=\"{size:.1}\" \
             text-anchor=\"{anchor}\" fill=\"{ink}\">{text}</text>"
        ));
    }

    /// Lines of text from `y` down, `size` apart by a quarter more.
    pub fn lines(&mut self, lines: &[String], (x, y): Point, size: f64, anchor: Anchor) {
        for (index, line) in lines.iter().enumerate() {
            let y = y + 1.25 * size * index as f64;
            self.text(line, (x, y), size, anchor);
        }
    }
}

/// The beginning of a document with a white ground, whose units have so many millimetres. Lines are joined without the
/// spikes that a noisy curve would have.
pub(super) fn opening(title: &str, (width, height): (f64, f64), unit_mm: f64) -> String {
    let [wide, high] = [width, height].map(|side| side * unit_mm);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{wide:.2}mm\" height=\"{high:.2}mm\" \
         viewBox=\"0 0 {width:.1} {height:.1}\" font-family=\"'DejaVu Sans', sans-serif\" \
         stroke-linejoin=\"bevel\" role=\"img\">\n<title>{}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        escape(title)
    )
}

fn list(points: &[Point]) -> String {
    let mut list = String::new();
    for (n, (x, y)) in points.iter().enumerate() {
        let space = if n > 0 { " " } else { "" };
        // Writing to a string does not fail.
        let _ = write!(list, "{space}{x:.1},{y:.1}");
    }
    list
}

fn place(rect: &Rect) -> String {
    format!(
        "x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"",
        rect.left,
        rect.top,
        rect.width(),
        rect.height()
    )
}

fn hex([red, green, blue]: Color) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Text escaped for XML; characters that XML forbids become U+FFFD.
fn escape(text: &str) -> String {
    let text: String = text
        .chars()
        .map(|c| match c {
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => '\u{fffd}',
            c => c,
        })
        .collect();
    let pairs = [
        ("&", "&amp;"),
        ("<", "&lt;"),
        (">", "&gt;"),
        ("\"", "&quot;"),
    ];
    pairs
        .iter()
        .fold(text, |text, (from, to)| text.replace(from, to))
}
