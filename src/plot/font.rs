//! DejaVu Sans, shipped with the program: how wide and how high its letters are.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef};

pub(super) const FAMILY: &str = "DejaVu Sans";
pub(super) static BYTES: &[u8] = include_bytes!("../../assets/fonts/DejaVuSans.ttf");

static FONT: LazyLock<Option<FontRef<'static>>> =
    LazyLock::new(|| FontRef::try_from_slice(BYTES).ok());

/// Height of a digit over the em.
const CAP_HEIGHT: f64 = 0.729;
/// Width of a letter over the em where no font is known.
const USUAL: f64 = 0.6;

/// Width of one line of text set in an em of `size`.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let advances = FONT.as_ref().and_then(|font| {
        let advance = |c| f64::from(font.h_advance_unscaled(font.glyph_id(c)));
        Some(text.chars().map(advance).sum::<f64>() / f64::from(font.units_per_em()?))
    });
    size * advances.unwrap_or(USUAL * text.chars().count() as f64)
}

/// Distance of a text's baseline below its middle, which is that of a digit.
pub(super) fn baseline(size: f64) -> f64 {
    0.5 * CAP_HEIGHT * size
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
