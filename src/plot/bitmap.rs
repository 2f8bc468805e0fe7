//! A scene as PNG.

use ab_glyph::OutlineCurve;
use tiny_skia::{
    Color as Fill, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform,
};

use super::font;
use super::scene::{Anchor, Color, Image, Mark, Rect, Scene, Text};

/// Pixels of the file to one pixel of the design.
const PIXEL_RATIO: f64 = 1.5;

/// The figure as the bytes of a PNG file.
pub(super) fn png(scene: &Scene) -> Result<Vec<u8>, String> {
    let device = |length: u32| (f64::from(length) * PIXEL_RATIO).round() as u32;
    let (width, height) = (device(scene.width), device(scene.height));
    let mut pixmap = Pixmap::new(width, height).ok_or("the figure is too large")?;
    pixmap.fill(Fill::WHITE);
    for mark in &scene.marks {
        match mark {
            Mark::Image(image) => paint_image(&mut pixmap, image),
            Mark::Fill { rect, color } => paint_rect(&mut pixmap, rect, *color),
            Mark::Line {
                points,
                color,
                width,
            } => paint_line(&mut pixmap, points, *color, *width),
            Mark::Text(text) => paint_text(&mut pixmap, text)?,
        }
    }
    let rgb: Vec<u8> = pixmap
        .pixels()
        .iter()
        .flat_map(|p| [p.red(), p.green(), p.blue()])
        .collect();
    encode(width, height, png::ColorType::Rgb, None, &rgb)
}

/// An image alone, with its palette, as the bytes of a PNG file.
pub(super) fn indexed_png(image: &Image) -> Result<Vec<u8>, String> {
    encode(
        image.columns as u32,
        image.rows as u32,
        png::ColorType::Indexed,
        Some(image.palette.concat()),
        &image.cells,
    )
}

fn encode(
    width: u32,
    height: u32,
    color: png::ColorType,
    palette: Option<Vec<u8>>,
    bytes: &[u8],
) -> Result<Vec<u8>, String> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    if let Some(palette) = palette {
        encoder.set_palette(palette);
    }
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(bytes))
        .map_err(|error| error.to_string())?;
    Ok(file)
}

fn to_device() -> Transform {
    Transform::from_scale(PIXEL_RATIO as f32, PIXEL_RATIO as f32)
}

fn paint([red, green, blue]: Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

/// Nearest cell for each pixel, so that cells keep sharp edges.
fn paint_image(pixmap: &mut Pixmap, image: &Image) {
    let (width, height) = (pixmap.width() as usize, pixmap.height() as usize);
    let cell_of = |from: f64, to: f64, cells: usize, limit: usize| -> Vec<(usize, usize)> {
        let (from, to) = (from * PIXEL_RATIO, to * PIXEL_RATIO);
        let first = from.round().max(0.0) as usize;
        let end = (to.round().max(0.0) as usize).min(limit);
        (first..end)
            .map(|pixel| {
                let share = (pixel as f64 + 0.5 - from) / (to - from);
                (pixel, ((share * cells as f64) as usize).min(cells - 1))
            })
            .collect()
    };
    let columns = cell_of(image.at.left, image.at.right, image.columns, width);
    let rows = cell_of(image.at.top, image.at.bottom, image.rows, height);
    let data = pixmap.data_mut();
    for (y, row) in rows {
        for &(x, column) in &columns {
            let color = image.palette[image.cells[row * image.columns + column] as usize];
            let at = 4 * (y * width + x);
            data[at..at + 3].copy_from_slice(&color);
        }
    }
}

fn paint_rect(pixmap: &mut Pixmap, rect: &Rect, color: Color) {
    let area = tiny_skia::Rect::from_ltrb(
        rect.left as f32,
        rect.top as f32,
        rect.right as f32,
        rect.bottom as f32,
    );
    if let Some(area) = area {
        pixmap.fill_rect(area, &paint(color), to_device(), None);
    }
}

fn paint_line(pixmap: &mut Pixmap, points: &[(f64, f64)], color: Color, width: f64) {
    let mut builder = PathBuilder::new();
    for (index, &(x, y)) in points.iter().enumerate() {
        match index {
            0 => builder.move_to(x as f32, y as f32),
            _ => builder.line_to(x as f32, y as f32),
        }
    }
    if let Some(path) = builder.finish() {
        let stroke = Stroke {
            width: width as f32,
            line_cap: LineCap::Butt,
            line_join: LineJoin::Bevel,
            ..Stroke::default()
        };
        pixmap.stroke_path(&path, &paint(color), &stroke, to_device(), None);
    }
}

fn paint_text(pixmap: &mut Pixmap, text: &Text) -> Result<(), String> {
    let start = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -font::width(&text.text, text.size) / 2.0,
        Anchor::End => -font::width(&text.text, text.size),
    };
    let baseline = text.size * font::CAP_HEIGHT / 2.0;
    let mut to_page = to_device().pre_translate(text.at.0 as f32, text.at.1 as f32);
    if text.vertical {
        to_page = to_page.pre_rotate(-90.0);
    }
    let scale = text.size / font::units_per_em();
    to_page = to_page
        .pre_translate(start as f32, baseline as f32)
        .pre_scale(scale as f32, -scale as f32);
    if let Some(path) = text_path(&text.text)? {
        pixmap.fill_path(&path, &paint(text.color), FillRule::Winding, to_page, None);
    }
    Ok(())
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
