//! Paints figures as SVG: text stays text, pictures are embedded.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use plotters_backend::BackendColor;
use plotters_backend::text_anchor::HPos;

use super::bitmap;
use super::font;
use super::painter::{Brush, Lettering, Outline, Painter, Point, Raster};
use super::scene::Rect;
use super::style::PageUnits;

/// A figure as an SVG document.
#[derive(Debug)]
pub(super) struct Svg {
    /// All of it but the closing tag.
    document: String,
}

impl Svg {
    pub fn new(title: &str, (width, height): (f64, f64), page: &PageUnits) -> Self {
        let [wide, high] = [width, height].map(|side| page.millimetres(side));
        let document = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{wide:.2}mm\" height=\"{high:.2}mm\" \
             viewBox=\"0 0 {width:.1} {height:.1}\" font-family=\"'DejaVu Sans', sans-serif\" \
             role=\"img\">\n<title>{}</title>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
            escape(title)
        );
        Svg { document }
    }

    fn push(&mut self, element: &str) {
        self.document.push_str(element);
        self.document.push('\n');
    }
}

impl Painter for Svg {
    fn shape(&mut self, shape: &Outline, brush: Brush, color: BackendColor) {
        let look = match brush {
            Brush::Fill => ink("fill", color),
            Brush::Stroke(width) => {
                let stroke = ink("stroke", color);
                format!("fill=\"none\" {stroke} stroke-width=\"{width}\"")
            }
        };
        let element = match shape {
            Outline::Path(points) => format!("<polyline {look} points=\"{}\"/>", list(points)),
            Outline::Rect(rect) => format!("<rect {} {look}/>", place(rect)),
            Outline::Circle { center, radius } => format!(
                "<circle {look} cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\"/>",
                center.0, center.1
            ),
        };
        self.push(&element);
    }

    fn text(&mut self, text: &str, at: Point, lettering: &Lettering) -> Result<(), String> {
        let anchor = match lettering.anchor.h_pos {
            HPos::Left => "start",
            HPos::Center => "middle",
            HPos::Right => "end",
        };
        let turn = match lettering.degrees() {
            0 => String::new(),
            degrees => format!(" rotate({degrees})"),
        };
        self.push(&format!(
            "<text transform=\"translate({:.1} {:.1}){turn}\" y=\"{:.1}\" font-size=\"{:.1}\" \
             text-anchor=\"{anchor}\" {}>{}</text>",
            at.0,
            at.1,
            font::baseline(lettering.anchor.v_pos, lettering.size),
            lettering.size,
            ink("fill", lettering.color),
            escape(text)
        ));
        Ok(())
    }

    fn image(&mut self, at: &Rect, raster: &Raster) -> Result<(), String> {
        self.push(&format!(
            "<image {} preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
             href=\"data:image/png;base64,{}\"/>",
            place(at),
            BASE64_STANDARD.encode(bitmap::png(raster, None)?)
        ));
        Ok(())
    }

    fn encode(&self) -> Result<Vec<u8>, String> {
        Ok(format!("{}</svg>\n", self.document).into_bytes())
    }
}

fn list(points: &[Point]) -> String {
    let points: Vec<String> = points
        .iter()
        .map(|(x, y)| format!("{x:.1},{y:.1}"))
        .collect();
    points.join(" ")
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

/// A colour as the attribute `name`, with its opacity where it has one.
fn ink(name: &str, BackendColor { alpha, rgb }: BackendColor) -> String {
    let (red, green, blue) = rgb;
    let color = format!("{name}=\"#{red:02x}{green:02x}{blue:02x}\"");
    match alpha < 1.0 {
        true => format!("{color} {name}-opacity=\"{alpha:.3}\""),
        false => color,
    }
}

/// Text escaped for XML; characters that XML forbids become U+FFFD.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
