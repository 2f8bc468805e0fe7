//! DejaVu Sans, shipped with the program: outlines and advances.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, InvalidFont, OutlineCurve};
use plotters_backend::text_anchor::VPos;

static BYTES: &[u8] = include_bytes!("../../assets/fonts/DejaVuSans.ttf");

/// Height of a digit over the em.
const CAP_HEIGHT: f64 = 0.729;

/// Reach of the tallest letters above, and of the deepest below the baseline, over the em.
const ASCENT: f64 = 0.76;
const DESCENT: f64 = 0.24;

/// A glyph's closed contours, in units of the em, y upwards.
pub(super) struct Glyph {
    pub curves: Vec<OutlineCurve>,
    /// Its origin on the line of text, in units of the em.
    pub offset: f64,
}

fn font() -> Result<&'static FontRef<'static>, String> {
    static FONT: OnceLock<Result<FontRef<'static>, InvalidFont>> = OnceLock::new();
    FONT.get_or_init(|| FontRef::try_from_slice(BYTES))
        .as_ref()
        .map_err(InvalidFont::to_string)
}

/// Units of the font's design grid in one em.
pub(super) fn units_per_em() -> f64 {
    font()
        .ok()
        .and_then(|font| font.units_per_em())
        .map_or(1.0, f64::from)
}

/// The glyphs of one line of text.
pub(super) fn glyphs(text: &str) -> Result<Vec<Glyph>, String> {
    let font = font()?;
    let em = units_per_em();
    let mut pen = 0.0;
    let mut previous = None;
    let mut glyphs = Vec::new();
    for id in text.chars().map(|c| font.glyph_id(c)) {
        if let Some(previous) = previous {
            pen += f64::from(font.kern_unscaled(previous, id)) / em;
        }
        glyphs.push(Glyph {
            curves: font.outline(id).map(|o| o.curves).unwrap_or_default(),
            offset: pen,
        });
        pen += f64::from(font.h_advance_unscaled(id)) / em;
        previous = Some(id);
    }
    Ok(glyphs)
}

/// Width of one line of text set in an em of `size` pixels.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let em = units_per_em();
    let advance = |c| match font() {
        Ok(font) => f64::from(font.h_advance_unscaled(font.glyph_id(c))) / em,
        Err(_) => 0.6,
    };
    text.chars().map(advance).sum::<f64>() * size
}

/// Distance of a text's baseline below its anchor; the middle is that of a digit.
pub(super) fn baseline(anchor: VPos, size: f64) -> f64 {
    size * match anchor {
        VPos::Top => ASCENT,
        VPos::Center => CAP_HEIGHT / 2.0,
        VPos::Bottom => -DESCENT,
    }
}

/// `text` in lines that fit into `room`, broken at spaces; a longer word has a line of its own.
pub(super) fn wrap(text: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().filter(|line| !line.is_empty());
        match line {
            Some(line) if width(&format!("{line} {word}"), size) <= room => {
                line.push(' ');
                line.push_str(word);
            }
            Some(_) => lines.push(word.to_owned()),
            None => lines = vec![word.to_owned()],
        }
    }
    lines
}

/// `text`, or as much of its beginning as fits into `room`, with an ellipsis.
pub(super) fn shorten(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.into();
    }
    let mut short = String::new();
    for c in text.chars() {
        short.push(c);
        if width(&short, size) + size > room {
            break;
        }
    }
    short.push('…');
    short
}
