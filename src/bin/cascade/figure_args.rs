//! Options of figures, the same for all commands that draw.

use wavecascade::plot::{Colormap, Depth, Format, Style};

use crate::prelude::*;
use crate::present::PresentArgs;

/// Formats and size of figures.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Figures")]
pub struct FigureArgs {
    /// Formats of the figures [default: png]; none leaves the report out too.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "FORMAT")]
    pub figures: Vec<FigureArg>,
    /// Size and letters of the figures [default: screen].
    #[arg(long, value_enum)]
    pub style: Option<StyleArg>,
    /// Width of the figures, or width and height, such as 86mm, 86x60mm, 3.4x2.5in or 9x6cm; those with
    /// several rows of panels are taller where they need it [default: as the style has it].
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub figure_size: Option<FigureSize>,
    /// Pixels per inch of PNG files [default: 144 for the screen, 300 for papers].
    #[arg(long, value_name = "N")]
    pub dpi: Option<u32>,
    #[command(flatten)]
    pub present: PresentArgs,
}

/// Colours of maps.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Figures")]
pub struct ColorArgs {
    /// Colours of the maps in figures [default: viridis].
    #[arg(long, value_enum)]
    pub colormap: Option<ColormapArg>,
    /// Decades below the largest value that the maps of spectra show [default: all, up to 8].
    #[arg(long, value_name = "N", value_parser = parse::finite, conflicts_with = "db")]
    pub decades: Option<f64>,
    /// Show the maps of spectra in decibels relative to the largest value, this many.
    #[arg(long, value_name = "N", value_parser = parse::finite)]
    pub db: Option<f64>,
}

choice!(FigureArg => Option<Format> {
    Png => Some(Format::Png),
    /// Vector, with text as text.
    Svg => Some(Format::Svg),
    None => None,
});

choice!(StyleArg => Style {
    /// 1200 pixels wide, with headings.
    Screen => Self::screen(),
    /// For a column of a paper: 86 mm wide, labels of 8 pt, no headings.
    Paper => Self::paper(),
    /// For both columns of a paper: 178 mm wide.
    PaperWide => Self::paper_wide(),
});

choice!(ColormapArg => Colormap {
    Viridis, Cividis, Inferno, Magma, Plasma,
    /// For prints without colour.
    Gray,
});

/// A width in mm, and a height.
type FigureSize = (f64, Option<f64>);

/// `86mm`, `86x60mm`, `3.4x2.5in`, `9x6cm`; without a unit in mm.
fn size(text: &str) -> Result<FigureSize, String> {
    let expected = "expected a width or WIDTHxHEIGHT such as 86mm, 86x60mm, 3.4x2.5in or 9x6cm";
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let mm = match &text[digits.len()..] {
        "" | "mm" => 1.0,
        "cm" => 10.0,
        "in" => 25.4,
        _ => return Err(expected.into()),
    };
    let length = |text: &str| match text.trim().parse::<f64>() {
        Ok(length) if length.is_finite() && length > 0.0 => Ok(length * mm),
        _ => Err(expected.to_owned()),
    };
    let (width, height) = match digits.split_once('x') {
        Some((width, height)) => (width, Some(length(height)?)),
        None => (digits, None),
    };
    Ok((length(width)?, height))
}

/// What a command draws, and how.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// None for no figures and no report.
    pub formats: Vec<Format>,
    pub style: Style,
    /// Threads that draw, where they are not all.
    pub threads: Option<usize>,
}

impl Drawing {
    pub fn is_wanted(&self) -> bool {
        !self.formats.is_empty()
    }

    /// The file of a result to open.
    pub fn main(&self) -> &'static str {
        match self.is_wanted() {
            true => "report.html",
            false => "summary.json",
        }
    }
}

impl FigureArgs {
    /// Formats and style of curves, and of maps in these colours.
    pub fn drawing(&self, colors: Option<&ColorArgs>) -> Result<Drawing, Error> {
        let formats = self.formats()?;
        let has_png = formats.contains(&Format::Png);
        self.present.check(!formats.is_empty(), has_png)?;
        let style = self.style(colors);
        style.check()?;
        Ok(Drawing {
            formats,
            style,
            threads: None,
        })
    }

    /// The formats typed, each once.
    fn formats(&self) -> Result<Vec<Format>, Error> {
        let typed: Vec<Option<Format>> = self.figures.iter().map(|one| (*one).into()).collect();
        if typed.is_empty() {
            return Ok(vec![Format::Png]);
        }
        let mut chosen = vec![Format::Png, Format::Svg];
        chosen.retain(|format| typed.contains(&Some(*format)));
        let is_clear = !typed.contains(&None) || chosen.is_empty();
        Error::require(is_clear, "figures", "formats, or none alone", "both")?;
        Ok(chosen)
    }

    fn style(&self, colors: Option<&ColorArgs>) -> Style {
        let mut style: Style = self.style.unwrap_or(StyleArg::Screen).into();
        if let Some(size) = self.figure_size {
            (style.width, style.height) = size;
        }
        style.dpi = self.dpi.unwrap_or(style.dpi);
        let Some(colors) = colors else { return style };
        style.colormap = colors.colormap.map(Into::into).unwrap_or_default();
        style.depth = match (colors.decades, colors.db) {
            (Some(decades), _) => Depth::Decades(decades),
            (None, Some(db)) => Depth::Decibels(db),
            (None, None) => Depth::default(),
        };
        style
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_in_millimetres() {
        assert_eq!(size("86"), Ok((86.0, None)));
        assert_eq!(size("86x60mm"), Ok((86.0, Some(60.0))));
        assert_eq!(size("9x6cm"), Ok((90.0, Some(60.0))));
        assert_eq!(size("2x1in"), Ok((50.8, Some(25.4))));
        for wrong in ["", "mm", "86pt", "86x", "x60mm", "-3mm", "0x4cm", "1x2x3"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
