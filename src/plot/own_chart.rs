//! Charts of one's own, drawn by `plotters` as sharp as the built-in ones.

use std::sync::Once;

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::prelude::SVGBackend;
use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

use super::scene::opening;
use super::{Format, Style, font};
use crate::{Error, Result};

/// Units of `plotters` per pixel: below visibility.
const UNITS: u32 = 10;
/// `plotters`' size of a font over its em.
const SIZE_OVER_EM: f64 = 1.24;
/// Longest side, in pixels.
const LONGEST: u32 = 20_000;

/// Converts a length in pixels to the units of `plotters` on an [`Area`]: tenths of a pixel.
///
/// ```
/// assert_eq!(wavecascade::plot::px(2.5), 25);
/// ```
pub fn px(pixels: f64) -> u32 {
    (pixels * f64::from(UNITS)).round() as u32
}

/// DejaVu Sans with an em of `pixels`, for labels on an [`Area`].
pub fn sans(pixels: f64) -> FontDesc<'static> {
    register();
    let size = pixels * f64::from(UNITS) * SIZE_OVER_EM;
    FontDesc::new(FontFamily::Name(font::FAMILY), size, FontStyle::Normal)
}

/// Makes the shipped font known to `plotters`, for every family without a name.
fn register() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for family in [font::FAMILY, "sans-serif", "serif", "monospace"] {
            // The font is whole: a test reads it.
            let _ = register_font(family, FontStyle::Normal, font::BYTES);
        }
    });
}

/// What `plotters` draws on.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A chart of your own, drawn by `plotters`, as the bytes of a file of `width` by `height` pixels; a PNG file has 1.5
/// pixels for each.
///
/// `plotters` places everything in whole units of its backend. Here a unit is a tenth of a pixel, so that curves and letters
/// are not snapped to pixels: give lengths with [`px`] and fonts with [`sans`]; the defaults of `plotters` (letters of 12
/// units, ticks of 5) are too small to see. Strokes are at least a pixel wide. All text is set in DejaVu Sans, which is
/// shipped; no system font is used. The title names the figure in errors, and is the accessible name of an SVG file.
///
/// ```
/// use wavecascade::plot::plotters::prelude::*;
/// use wavecascade::plot::{Format, own_chart, px, sans};
///
/// let file: Vec<u8> = own_chart("Decay", (640, 400), Format::Png, |area| {
///     let mut chart = ChartBuilder::on(area)
///         .margin(px(20.0))
///         .x_label_area_size(px(55.0))
///         .y_label_area_size(px(70.0))
///         .build_cartesian_2d(0.0..5.0, 0.0..1.0)?;
///     chart
///         .configure_mesh()
///         .light_line_style(TRANSPARENT)
///         .label_style(sans(15.0))
///         .set_all_tick_mark_size(px(6.0))
///         .x_desc("time (s)")
///         .y_desc("energy (J)")
///         .draw()?;
///     let decay = (0..=500).map(|m| f64::from(m) / 100.0).map(|t| (t, (-t).exp()));
///     chart.draw_series(LineSeries::new(decay, BLUE.stroke_width(px(2.4))))?;
///     Ok(())
/// })?;
/// assert!(file.starts_with(b"\x89PNG"));
/// # Ok::<(), wavecascade::Error>(())
/// ```
///
/// # Errors
/// [`Error::Failed`] if a side is zero or too long, or the chart cannot be drawn; those of `draw`.
pub fn own_chart(
    title: &str,
    (width, height): (u32, u32),
    format: Format,
    draw: impl FnOnce(&Area) -> Result<()>,
) -> Result<Vec<u8>> {
    let fault = |reason: String| Error::failed(format!("cannot draw {title}: {reason}"));
    let sides = 1..=LONGEST;
    if !sides.contains(&width) || !sides.contains(&height) {
        return Err(fault(format!(
            "{width} by {height} pixels cannot be drawn on"
        )));
    }
    register();
    let mut drawn = String::new();
    let area =
        SVGBackend::with_string(&mut drawn, (width * UNITS, height * UNITS)).into_drawing_area();
    draw(&area)?;
    area.present()?;
    drop(area);
    // Its first line is replaced by one that states millimetres and the title.
    let (_, elements) = drawn.split_once('\n').unwrap_or_default();
    let thin = (1..UNITS).map(|width| format!("stroke-width=\"{width}\""));
    let elements = thin.fold(elements.to_owned(), |all, thin| {
        all.replace(&thin, &format!("stroke-width=\"{UNITS}\""))
    });
    let style = Style::screen();
    let size = [width, height].map(|side| f64::from(side * UNITS));
    let svg = opening(
        title,
        (size[0], size[1]),
        style.unit_mm() / f64::from(UNITS),
    )
    .replacen("<svg", &format!("<svg stroke-width=\"{UNITS}\""), 1)
        + &elements;
    format.encode(svg, style.dpi).map_err(fault)
}

impl From<DrawingAreaErrorKind<std::io::Error>> for Error {
    fn from(error: DrawingAreaErrorKind<std::io::Error>) -> Self {
        Error::failed(format!("cannot draw the chart: {error}"))
    }
}
