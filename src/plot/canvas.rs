//! The painters as a backend of `plotters`: figures of one's own, as sharp as the built-in ones.

use std::cell::RefCell;
use std::rc::Rc;

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::style::{FontDesc, FontFamily, FontStyle};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use super::Format;
use super::bitmap::Bitmap;
use super::font;
use super::painter::{Brush, Lettering, Outline, Painter, Point, Raster};
use super::scene::Rect;
use super::style::PageUnits;
use super::svg::Svg;
use crate::{Error, Result};

/// Backend units per pixel: below visibility, and one decimal in an SVG.
const UNITS: f64 = 10.0;

/// `plotters`' size of a font over its em.
const SIZE_OVER_EM: f64 = 1.24;

/// Converts a length in pixels to the units of `plotters` on a [`Canvas`]: tenths of a pixel.
///
/// ```
/// assert_eq!(wavecascade::plot::px(2.5), 25);
/// ```
pub fn px(pixels: f64) -> u32 {
    (pixels * UNITS).round() as u32
}

/// DejaVu Sans with an em of `pixels`, for labels on a [`Canvas`].
pub fn sans(pixels: f64) -> FontDesc<'static> {
    let family = FontFamily::Name("DejaVu Sans");
    FontDesc::new(family, pixels * UNITS * SIZE_OVER_EM, FontStyle::Normal)
}

fn pixels((x, y): BackendCoord) -> Point {
    (f64::from(x) / UNITS, f64::from(y) / UNITS)
}

/// A [`Canvas`] as `plotters` draws on it.
pub type Area = DrawingArea<CanvasSurface, Shift>;

/// A white drawing area for your own charts, drawn by `plotters`.
///
/// `plotters` places everything in whole units of its backend. Here a unit is a tenth of a pixel,
/// so that curves and letters are not snapped to pixels: give lengths with [`px`] and fonts with
/// [`sans`]; the defaults of `plotters` (letters of 12 units, ticks of 5) are too small to see.
/// Strokes are at least a pixel wide. All text is set in DejaVu Sans, which is shipped; no system
/// font is used.
///
/// ```
/// use wavecascade::plot::plotters::prelude::*;
/// use wavecascade::plot::{Canvas, Format, px, sans};
///
/// # fn main() -> wavecascade::Result<()> {
/// let canvas = Canvas::new("Decay", 640, 400, Format::Png)?;
/// let area = canvas.area();
/// let mut chart = ChartBuilder::on(&area)
///     .margin(px(20.0))
///     .x_label_area_size(px(55.0))
///     .y_label_area_size(px(70.0))
///     .build_cartesian_2d(0.0..5.0, 0.0..1.0)?;
/// chart
///     .configure_mesh()
///     .light_line_style(TRANSPARENT)
///     .label_style(sans(15.0))
///     .set_all_tick_mark_size(px(6.0))
///     .x_desc("time (s)")
///     .y_desc("energy (J)")
///     .draw()?;
/// let decay = (0..=500).map(|m| f64::from(m) / 100.0).map(|t| (t, (-t).exp()));
/// chart.draw_series(LineSeries::new(decay, BLUE.stroke_width(px(2.4))))?;
/// let file: Vec<u8> = canvas.encode()?;
/// # assert!(file.starts_with(b"\x89PNG"));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Canvas {
    surface: Rc<RefCell<CanvasSurface>>,
}

impl Canvas {
    /// A canvas of `width` by `height` pixels; a PNG file has 1.5 pixels for each.
    ///
    /// The title names the figure in errors, and is the accessible name of an SVG file.
    ///
    /// # Errors
    /// [`Error::Draw`] if a side is zero or too long.
    pub fn new(title: &str, width: u32, height: u32, format: Format) -> Result<Self> {
        let size = (f64::from(width), f64::from(height));
        let surface = CanvasSurface {
            title: title.into(),
            size: (px(size.0), px(size.1)),
            painter: painter(title, size, &PageUnits::pixels(format))?,
        };
        Ok(Canvas {
            surface: Rc::new(RefCell::new(surface)),
        })
    }

    /// The whole sheet; all areas of a canvas draw on the same one.
    pub fn area(&self) -> Area {
        Area::from(&self.surface)
    }

    /// The bytes of a file with all that was drawn so far.
    ///
    /// # Errors
    /// [`Error::Draw`] if it cannot be encoded.
    pub fn encode(&self) -> Result<Vec<u8>> {
        match self.surface.try_borrow() {
            Ok(surface) => surface.painter.encode().map_err(|r| surface.fault(r)),
            Err(_) => Err(DrawingAreaErrorKind::SharingError.into()),
        }
    }
}

/// What paints a sheet of this width and height in units of a page.
pub(super) fn painter(title: &str, size: (f64, f64), page: &PageUnits) -> Result<Box<dyn Painter>> {
    let longest = f64::from(i32::MAX) / UNITS;
    let is_possible = size.0 > 0.0 && size.1 > 0.0 && size.0.max(size.1) <= longest;
    let painter: Option<Box<dyn Painter>> = match (is_possible, page.format) {
        (true, Format::Png) => Bitmap::new(size, page).map(|made| Box::new(made) as _),
        (true, Format::Svg) => Some(Box::new(Svg::new(title, size, page))),
        (false, _) => None,
    };
    painter.ok_or_else(|| Error::Draw {
        figure: title.into(),
        reason: format!("{} by {} pixels cannot be drawn on", size.0, size.1),
    })
}

impl From<DrawingAreaErrorKind<Error>> for Error {
    fn from(error: DrawingAreaErrorKind<Error>) -> Self {
        match error {
            DrawingAreaErrorKind::BackendError(DrawingErrorKind::DrawingError(error)) => error,
            other => Error::Draw {
                figure: "the chart".into(),
                reason: other.to_string(),
            },
        }
    }
}

/// The backend behind a [`Canvas`].
#[derive(Debug)]
pub struct CanvasSurface {
    title: String,
    size: (u32, u32),
    painter: Box<dyn Painter>,
}

type Drawn = std::result::Result<(), DrawingErrorKind<Error>>;

impl CanvasSurface {
    fn fault(&self, reason: String) -> Error {
        Error::Draw {
            figure: self.title.clone(),
            reason,
        }
    }

    fn done(&self, painted: std::result::Result<(), String>) -> Drawn {
        painted.map_err(|reason| DrawingErrorKind::DrawingError(self.fault(reason)))
    }

    fn paint(&mut self, shape: &Outline, style: &impl BackendStyle, fill: bool) -> Drawn {
        let (color, width) = (style.color(), style.stroke_width());
        if color.alpha > 0.0 && (fill || width > 0) {
            let brush = match fill {
                true => Brush::Fill,
                false => Brush::Stroke((f64::from(width) / UNITS).max(1.0)),
            };
            self.painter.shape(shape, brush, color);
        }
        Ok(())
    }
}

fn rect(from: BackendCoord, to: BackendCoord) -> Rect {
    let ((left, top), (right, bottom)) = (pixels(from), pixels(to));
    Rect {
        left,
        top,
        right,
        bottom,
    }
}

/// The em of a style's font, in pixels.
fn em(style: &impl BackendTextStyle) -> f64 {
    style.size() / SIZE_OVER_EM / UNITS
}

impl DrawingBackend for CanvasSurface {
    type ErrorType = Error;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Drawn {
        self.draw_rect((x, y), (x + 1, y + 1), &color, true)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn {
        self.paint(&Outline::Rect(rect(upper_left, bottom_right)), style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        let points: Vec<Point> = path.into_iter().map(pixels).collect();
        self.paint(&Outline::Path(&points), style, false)
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let circle = Outline::Circle {
            center: pixels(center),
            radius: f64::from(radius) / UNITS,
        };
        self.paint(&circle, style, fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        vert: I,
        style: &S,
    ) -> Drawn {
        let corners: Vec<Point> = vert.into_iter().map(pixels).collect();
        self.paint(&Outline::Path(&corners), style, true)
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        pos: BackendCoord,
    ) -> Drawn {
        let lettering = Lettering {
            size: em(style),
            color: style.color(),
            anchor: style.anchor(),
            turn: style.transform(),
        };
        if lettering.color.alpha == 0.0 {
            return Ok(());
        }
        let painted = self.painter.text(text, pixels(pos), &lettering);
        self.done(painted)
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> std::result::Result<(u32, u32), DrawingErrorKind<Error>> {
        let width = font::width(text, em(style));
        Ok((px(width), style.size().round() as u32))
    }

    /// A pixel of the bitmap is a unit, as everywhere in `plotters`.
    fn blit_bitmap(
        &mut self,
        (left, top): BackendCoord,
        (columns, rows): (u32, u32),
        src: &[u8],
    ) -> Drawn {
        let raster = Raster {
            columns: columns as usize,
            rows: rows as usize,
            palette: None,
            samples: src,
        };
        if src.len() != 3 * raster.columns * raster.rows {
            return self.done(Err("the bitmap is not red, green, blue".into()));
        }
        let at = rect((left, top), (left + columns as i32, top + rows as i32));
        let painted = self.painter.image(&at, &raster);
        self.done(painted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bitmaps_cover_a_unit_a_sample() {
        let canvas = Canvas::new("bitmap", 4, 4, Format::Svg).unwrap();
        let mut surface = canvas.surface.borrow_mut();
        let green = [0, 255, 0].repeat(30);
        surface.blit_bitmap((5, 10), (15, 2), &green).unwrap();
        assert!(surface.blit_bitmap((0, 0), (15, 3), &green).is_err());
        drop(surface);
        let svg = String::from_utf8(canvas.encode().unwrap()).unwrap();
        let place = "<image x=\"0.5\" y=\"1.0\" width=\"1.5\" height=\"0.2\"";
        assert!(svg.contains(place), "{svg}");
    }

    #[test]
    fn an_image_fills_its_pixels() {
        let page = PageUnits::pixels(Format::Png);
        let mut painter = painter("bitmap", (4.0, 4.0), &page).unwrap();
        let raster = Raster {
            columns: 1,
            rows: 2,
            palette: Some(&[[1, 2, 3], [4, 5, 6]]),
            samples: &[0, 1],
        };
        painter.image(&rect((0, 0), (40, 40)), &raster).unwrap();
        let file = std::io::Cursor::new(painter.encode().unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut pixels = vec![0; 6 * 6 * 3];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels[..3 * 18], [1, 2, 3].repeat(18));
        assert_eq!(pixels[3 * 18..], [4, 5, 6].repeat(18));
    }
}
