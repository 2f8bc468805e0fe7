//! Paints figures as PNG.

use ab_glyph::OutlineCurve;
use plotters_backend::BackendColor;
use plotters_backend::text_anchor::HPos;
use tiny_skia::{
    FillRule, IntSize, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform,
};

use super::font;
use super::painter::{Brush, Lettering, Outline, Painter, Point, Raster};
use super::scene::Rect;
use super::style::PageUnits;

/// Every byte of a white pixel.
const WHITE: u8 = 0xff;

/// An inch in metres.
const INCH: f64 = 0.0254;

/// A figure as pixels.
#[derive(Debug)]
pub(super) struct Bitmap {
    pixmap: Pixmap,
    /// Pixels of a unit of the layout.
    ratio: f64,
    dpi: u32,
}

impl Bitmap {
    /// `None` if there is no such bitmap.
    pub fn new((width, height): (f64, f64), page: &PageUnits) -> Option<Self> {
        let ratio = page.pixel_ratio();
        let device = |length: f64| (length * ratio).round() as u32;
        let size = IntSize::from_wh(device(width), device(height))?;
        let row = 4 * size.width() as usize;
        let white = vec![WHITE; row.checked_mul(size.height() as usize)?];
        let pixmap = Pixmap::from_vec(white, size)?;
        Some(Bitmap {
            pixmap,
            ratio,
            dpi: page.dpi,
        })
    }

    fn to_device(&self) -> Transform {
        Transform::from_scale(self.ratio as f32, self.ratio as f32)
    }

    /// The pixels between two coordinates, up to `limit`, each with the cell that its middle lies in.
    fn cells(&self, from: f64, to: f64, cells: usize, limit: usize) -> Vec<(usize, usize)> {
        let (from, to) = (from * self.ratio, to * self.ratio);
        let first = from.round().max(0.0) as usize;
        let end = (to.round().max(0.0) as usize).min(limit);
        (first..end)
            .map(|pixel| {
                let share = (pixel as f64 + 0.5 - from) / (to - from);
                (pixel, ((share * cells as f64) as usize).min(cells - 1))
            })
            .collect()
    }
}

impl Painter for Bitmap {
    fn shape(&mut self, shape: &Outline, brush: Brush, color: BackendColor) {
        let Some(path) = outline(shape) else {
            return;
        };
        let (paint, to_page) = (paint(color), self.to_device());
        match brush {
            Brush::Fill => {
                self.pixmap
                    .fill_path(&path, &paint, FillRule::Winding, to_page, None);
            }
            Brush::Stroke(width) => {
                let stroke = Stroke {
                    width: width as f32,
                    line_cap: LineCap::Butt,
                    line_join: LineJoin::Bevel,
                    ..Stroke::default()
                };
                self.pixmap
                    .stroke_path(&path, &paint, &stroke, to_page, None);
            }
        }
    }

    fn text(&mut self, text: &str, at: Point, lettering: &Lettering) -> Result<(), String> {
        let size = lettering.size;
        let start = match lettering.anchor.h_pos {
            HPos::Left => 0.0,
            HPos::Center => -font::width(text, size) / 2.0,
            HPos::Right => -font::width(text, size),
        };
        let baseline = font::baseline(lettering.anchor.v_pos, size);
        let scale = (size / font::units_per_em()) as f32;
        let to_page = self
            .to_device()
            .pre_translate(at.0 as f32, at.1 as f32)
            .pre_rotate(lettering.degrees() as f32)
            .pre_translate(start as f32, baseline as f32)
            .pre_scale(scale, -scale);
        if let Some(path) = text_path(text)? {
            let paint = paint(lettering.color);
            self.pixmap
                .fill_path(&path, &paint, FillRule::Winding, to_page, None);
        }
        Ok(())
    }

    /// Nearest cell for each pixel, so that cells keep sharp edges.
    fn image(&mut self, at: &Rect, raster: &Raster) -> Result<(), String> {
        let (width, height) = (self.pixmap.width() as usize, self.pixmap.height() as usize);
        let columns = self.cells(at.left, at.right, raster.columns, width);
        let rows = self.cells(at.top, at.bottom, raster.rows, height);
        let (Some(&(left, _)), Some(&(right, _))) = (columns.first(), columns.last()) else {
            return Ok(());
        };
        let data = self.pixmap.data_mut();
        let mut painted: Option<(usize, usize)> = None;
        for (y, row) in rows {
            let start = 4 * (y * width + left);
            match painted.filter(|(_, same)| *same == row) {
                // A row of cells is several rows of pixels.
                Some((above, _)) => {
                    let above = 4 * (above * width + left);
                    data.copy_within(above..above + 4 * (right + 1 - left), start);
                }
                None => {
                    for &(x, column) in &columns {
                        let at = start + 4 * (x - left);
                        data[at..at + 3].copy_from_slice(&raster.color(row, column));
                    }
                }
            }
            painted = Some((y, row));
        }
        Ok(())
    }

    fn encode(&self) -> Result<Vec<u8>, String> {
        let (columns, rows) = (self.pixmap.width() as usize, self.pixmap.height() as usize);
        let (fours, rest) = self.pixmap.data().as_chunks();
        let packed: Vec<[u8; 12]> = fours.iter().map(without_alpha).collect();
        let mut rgb = packed.into_flattened();
        rest.chunks(4).for_each(|rgba| rgb.extend(&rgba[..3]));
        let raster = Raster {
            columns,
            rows,
            palette: None,
            samples: &rgb,
        };
        png(&raster, Some(self.dpi))
    }
}

/// Red, green and blue of four pixels, in one piece: byte by byte it took a quarter of the encoding.
fn without_alpha(rgba: &[u8; 16]) -> [u8; 12] {
    let all = u128::from_le_bytes(*rgba);
    let rgb = (0..4).map(|n| (all >> (8 * n)) & (0xff_ffff << (24 * n)));
    let [packed @ .., _, _, _, _] = rgb.fold(0, |packed, pixel| packed | pixel).to_le_bytes();
    packed
}

/// An image alone, as the bytes of a PNG file, which may state its pixels per inch.
pub(super) fn png(raster: &Raster, dpi: Option<u32>) -> Result<Vec<u8>, String> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, raster.columns as u32, raster.rows as u32);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    // As small as with a filter chosen for each row, in half of the time.
    encoder.set_filter(png::Filter::Paeth);
    match raster.palette {
        Some(palette) => {
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_palette(palette.concat());
        }
        None => encoder.set_color(png::ColorType::Rgb),
    }
    encoder.set_pixel_dims(dpi.map(|dpi| {
        let per_metre = (f64::from(dpi) / INCH).round() as u32;
        png::PixelDimensions {
            xppu: per_metre,
            yppu: per_metre,
            unit: png::Unit::Meter,
        }
    }));
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(raster.samples))
        .map_err(|error| error.to_string())?;
    Ok(file)
}

fn paint(BackendColor { alpha, rgb }: BackendColor) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(rgb.0, rgb.1, rgb.2, (255.0 * alpha).round() as u8);
    paint
}

/// `None` for what has no extent.
fn outline(shape: &Outline) -> Option<Path> {
    match shape {
        Outline::Path(points) => {
            let mut builder = PathBuilder::new();
            for (index, &(x, y)) in points.iter().enumerate() {
                match index {
                    0 => builder.move_to(x as f32, y as f32),
                    _ => builder.line_to(x as f32, y as f32),
                }
            }
            builder.finish()
        }
        Outline::Rect(rect) => tiny_skia::Rect::from_ltrb(
            rect.left as f32,
            rect.top as f32,
            rect.right as f32,
            rect.bottom as f32,
        )
        .map(PathBuilder::from_rect),
        Outline::Circle { center, radius } => {
            PathBuilder::from_circle(center.0 as f32, center.1 as f32, *radius as f32)
        }
    }
}

/// The outlines of a line of text, in the font's units, y upwards.
fn text_path(text: &str) -> Result<Option<Path>, String> {
    let mut builder = PathBuilder::new();
    for glyph in font::glyphs(text)? {
        let shift = (glyph.offset * font::units_per_em()) as f32;
        let mut pen = None;
        for curve in &glyph.curves {
            let (start, end) = match curve {
                OutlineCurve::Line(a, b)
                | OutlineCurve::Quad(a, _, b)
                | OutlineCurve::Cubic(a, _, _, b) => (*a, *b),
            };
            if pen != Some(start) {
                builder.move_to(start.x + shift, start.y);
            }
            match curve {
                OutlineCurve::Line(..) => builder.line_to(end.x + shift, end.y),
                OutlineCurve::Quad(_, c, _) => {
                    builder.quad_to(c.x + shift, c.y, end.x + shift, end.y)
                }
                OutlineCurve::Cubic(_, c, d, _) => {
                    builder.cubic_to(c.x + shift, c.y, d.x + shift, d.y, end.x + shift, end.y)
                }
            }
            pen = Some(end);
        }
    }
    Ok(builder.finish())
}
