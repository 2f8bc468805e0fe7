//! What a file format has to be able to paint; lengths are units of the layout.

use std::fmt;

use plotters_backend::text_anchor::Pos;
use plotters_backend::{BackendColor, FontTransform};

use super::scene::{Color, Rect};

pub(super) type Point = (f64, f64);

/// An outline: open when stroked, closed when filled.
pub(super) enum Outline<'a> {
    Path(&'a [Point]),
    Rect(Rect),
    Circle { center: Point, radius: f64 },
}

/// How an outline is painted.
#[derive(Clone, Copy)]
pub(super) enum Brush {
    Fill,
    /// Along the outline, with a width.
    Stroke(f64),
}

/// Alignment of a line of text; `size` is the em.
pub(super) struct Lettering {
    pub size: f64,
    pub color: BackendColor,
    pub anchor: Pos,
    pub turn: FontTransform,
}

impl Lettering {
    /// Rotation of the text in degrees, clockwise.
    pub fn degrees(&self) -> i32 {
        match self.turn {
            FontTransform::None => 0,
            FontTransform::Rotate90 => 90,
            FontTransform::Rotate180 => 180,
            FontTransform::Rotate270 => -90,
        }
    }
}

/// Rows of samples, the top one first: indices into the palette, or without one red, green, blue.
pub(super) struct Raster<'a> {
    pub columns: usize,
    pub rows: usize,
    pub palette: Option<&'a [Color]>,
    pub samples: &'a [u8],
}

impl Raster<'_> {
    pub fn color(&self, row: usize, column: usize) -> Color {
        let at = row * self.columns + column;
        match self.palette {
            Some(palette) => palette[usize::from(self.samples[at])],
            None => [0, 1, 2].map(|part| self.samples[3 * at + part]),
        }
    }
}

/// Paints one figure on a white ground, mark by mark; encodes what was painted so far.
pub(super) trait Painter: fmt::Debug {
    fn shape(&mut self, shape: &Outline, brush: Brush, color: BackendColor);

    fn text(&mut self, text: &str, at: Point, lettering: &Lettering) -> Result<(), String>;

    /// Stretches the samples over `at`, with sharp edges.
    fn image(&mut self, at: &Rect, raster: &Raster) -> Result<(), String>;

    fn encode(&self) -> Result<Vec<u8>, String>;
}
