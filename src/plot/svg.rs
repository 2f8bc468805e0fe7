//! A scene as SVG: text stays text, pictures are embedded.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::bitmap;
use super::font;
use super::scene::{Anchor, Color, Mark, Rect, Scene, Text};

/// The figure as an SVG document.
pub(super) fn svg(scene: &Scene) -> Result<String, String> {
    let (width, height) = (scene.width, scene.height);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"'DejaVu Sans', sans-serif\" role=\"img\">\n\
         <title>{}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        escape(&scene.title)
    );
    for mark in &scene.marks {
        out.push_str(&element(mark)?);
        out.push('\n');
    }
    out.push_str("</svg>\n");
    Ok(out)
}

fn element(mark: &Mark) -> Result<String, String> {
    Ok(match mark {
        Mark::Image(image) => format!(
            "<image {} preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
             href=\"data:image/png;base64,{}\"/>",
            place(&image.at),
            BASE64_STANDARD.encode(bitmap::indexed_png(image)?)
        ),
        Mark::Fill { rect, color } => {
            format!("<rect {} fill=\"{}\"/>", place(rect), hex(*color))
        }
        Mark::Line {
            points,
            color,
            width,
        } => {
            let points: Vec<String> = points
                .iter()
                .map(|(x, y)| format!("{x:.1},{y:.1}"))
                .collect();
            format!(
                "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" points=\"{}\"/>",
                hex(*color),
                points.join(" ")
            )
        }
        Mark::Text(text) => text_element(text),
    })
}

fn text_element(text: &Text) -> String {
    let anchor = match text.anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    let turn = if text.vertical { " rotate(-90)" } else { "" };
    format!(
        "<text transform=\"translate({:.1} {:.1}){turn}\" y=\"{:.1}\" font-size=\"{:.1}\" \
         text-anchor=\"{anchor}\" fill=\"{}\">{}</text>",
        text.at.0,
        text.at.1,
        text.size * font::CAP_HEIGHT / 2.0,
        text.size,
        hex(text.color),
        escape(&text.text)
    )
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

/// Text as XML takes it; characters that XML forbids become U+FFFD.
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
