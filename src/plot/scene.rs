//! A figure as marks in design pixels, before any file format; `plotters` draws them.

use plotters::drawing::DrawingAreaErrorKind;
use plotters::element::{Drawable, PathElement, PointCollection, Rectangle, Text as Label};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color as _, FontTransform, RGBColor, TextStyle};
use plotters_backend::{BackendCoord, DrawingErrorKind};

use super::canvas::{Area, CanvasSurface, place, px, sans};
use super::painter::Raster;
use crate::Error;

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

    fn corners(&self) -> [BackendCoord; 2] {
        [(self.left, self.top), (self.right, self.bottom)].map(place)
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

impl<'a> PointCollection<'a, BackendCoord> for &'a Image {
    type Point = BackendCoord;
    type IntoIter = [BackendCoord; 2];

    fn point_iter(self) -> Self::IntoIter {
        self.at.corners()
    }
}

/// A separate element, since those of `plotters` do not scale their pixels.
impl Drawable<CanvasSurface> for Image {
    fn draw<I: Iterator<Item = BackendCoord>>(
        &self,
        mut pos: I,
        surface: &mut CanvasSurface,
        _: (u32, u32),
    ) -> Result<(), DrawingErrorKind<Error>> {
        let (Some(from), Some(to)) = (pos.next(), pos.next()) else {
            return Ok(());
        };
        let raster = Raster {
            columns: self.columns,
            rows: self.rows,
            palette: Some(&self.palette),
            samples: &self.cells,
        };
        surface.draw_image(from, to, &raster)
    }
}

/// The point of a text at its coordinates; vertically always the middle.
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

impl Text {
    fn style(&self) -> TextStyle<'static> {
        let turn = match self.vertical {
            true => FontTransform::Rotate270,
            false => FontTransform::None,
        };
        let across = match self.anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let font = sans(self.size).transform(turn);
        font.color(&rgb(self.color))
            .pos(Pos::new(across, VPos::Center))
    }
}

fn rgb([red, green, blue]: Color) -> RGBColor {
    RGBColor(red, green, blue)
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

    /// Draws every mark as an element of `plotters`.
    pub fn draw(&self, area: &Area) -> Result<(), DrawingAreaErrorKind<Error>> {
        for mark in &self.marks {
            match mark {
                Mark::Image(image) => area.draw(image)?,
                Mark::Line {
                    points,
                    color,
                    width,
                } => {
                    let points: Vec<BackendCoord> = points.iter().copied().map(place).collect();
                    let style = rgb(*color).stroke_width(px(*width));
                    area.draw(&PathElement::new(points, style))?;
                }
                Mark::Fill { rect, color } => {
                    area.draw(&Rectangle::new(rect.corners(), rgb(*color).filled()))?;
                }
                Mark::Text(text) => {
                    area.draw(&Label::new(&text.text[..], place(text.at), text.style()))?;
                }
            }
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
