//! SVG documents as PNG.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{self, Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::font;
use super::scene::Color;

/// An inch in metres.
const INCH: f64 = 0.0254;
/// Pixels in an inch of a document.
const CSS_DPI: f32 = 96.0;

/// The shipped font stands for every family; none of the system is looked for.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(font::BYTES.to_vec());
    fonts.set_sans_serif_family(font::FAMILY);
    Arc::new(fonts)
});

/// A document as the bytes of a PNG file of so many pixels per inch.
pub(super) fn rendered(svg: &str, dpi: u32) -> Result<Vec<u8>, String> {
    let options = Options {
        font_family: font::FAMILY.into(),
        fontdb: FONTS.clone(),
        ..Options::default()
    };
    let tree = Tree::from_str(svg, &options).map_err(|error| error.to_string())?;
    let scale = dpi as f32 / CSS_DPI;
    let [width, height] =
        [tree.size().width(), tree.size().height()].map(|side| (side * scale).round() as u32);
    let mut pixmap = Pixmap::new(width, height)
        .ok_or_else(|| format!("{width} by {height} pixels cannot be drawn on"))?;
    pixmap.fill(tiny_skia::Color::WHITE);
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixmap.as_mut(),
    );
    let (fours, rest) = pixmap.data().as_chunks();
    let packed: Vec<[u8; 12]> = fours.iter().map(without_alpha).collect();
    let mut rgb = packed.into_flattened();
    rest.chunks(4).for_each(|rgba| rgb.extend(&rgba[..3]));
    png((width as usize, height as usize), None, &rgb, Some(dpi))
}

/// Red, green and blue of four pixels, in one piece: byte by byte it took a quarter of the encoding.
fn without_alpha(rgba: &[u8; 16]) -> [u8; 12] {
    let all = u128::from_le_bytes(*rgba);
    let rgb = (0..4).map(|n| (all >> (8 * n)) & (0xff_ffff << (24 * n)));
    let [packed @ .., _, _, _, _] = rgb.fold(0, |packed, pixel| packed | pixel).to_le_bytes();
    packed
}

/// Samples as the bytes of a PNG file, which may state its pixels per inch: indices into the palette, or without one red,
/// green, blue.
pub(super) fn png(
    (columns, rows): (usize, usize),
    palette: Option<&[Color]>,
    samples: &[u8],
    dpi: Option<u32>,
) -> Result<Vec<u8>, String> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns as u32, rows as u32);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    // As small as with a filter chosen for each row, in half of the time.
    encoder.set_filter(png::Filter::Paeth);
    match palette {
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
        .and_then(|mut writer| writer.write_image_data(samples))
        .map_err(|error| error.to_string())?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::super::Style;
    use super::super::scene::{Image, Rect, Scene};
    use super::*;

    #[test]
    fn cells_of_an_image_fill_their_pixels() {
        let mut scene = Scene::new("", &Style::screen());
        // Half an inch.
        (scene.width, scene.height) = (48.0, 48.0);
        let (left, top, right, bottom) = (0.0, 0.0, 48.0, 48.0);
        let at = Rect {
            left,
            top,
            right,
            bottom,
        };
        let (palette, cells) = (vec![[1, 2, 3], [4, 5, 6]], vec![0, 1]);
        scene.image(&Image {
            at,
            columns: 1,
            rows: 2,
            palette,
            cells,
        });
        let file = rendered(&scene.document(), Style::screen().dpi).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(file))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; 72 * 72 * 3];
        reader.next_frame(&mut pixels).unwrap();
        let (upper, lower) = pixels.split_at(36 * 72 * 3);
        assert!(upper == [1, 2, 3].repeat(36 * 72) && lower == [4, 5, 6].repeat(36 * 72));
    }
}
