//! How figures are laid out: their size in print, their letters, their colours.

use crate::{Error, Result};

/// Label size in the units of layouts: what is drawn is placed in these units.
pub(super) const LABEL: f64 = 20.0;
/// Smallest letters, 7 points where labels have 8.
pub(super) const SMALL: f64 = 17.5;

const MM_PER_INCH: f64 = 25.4;
const POINTS_PER_INCH: f64 = 72.0;

/// Smallest width and height of a figure, in units.
const LEAST: (f64, f64) = (450.0, 300.0);
/// Most pixels along a side of a PNG file.
const MOST_PIXELS: f64 = 20_000.0;

/// Colours of maps. Sequential maps are perceptually uniform and safe for colour-blind readers;
/// signed values are shown in purple and orange, or, with `Gray`, from black to white.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Colormap {
    #[default]
    Viridis,
    Cividis,
    Inferno,
    Magma,
    Plasma,
    /// For prints without colour: black is the least value.
    Gray,
}

/// What a logarithmic colour scale spans below its largest value.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Depth {
    /// All positive values, but at most eight decades.
    #[default]
    Fitted,
    /// This many decades.
    Decades(f64),
    /// This many decibels, with the bar in decibels relative to the largest value. Spectra are powers:
    /// 10 dB are a decade.
    Decibels(f64),
}

/// Size, letters and colours of figures.
///
/// A layout keeps its margins and letters in their size and gives the rest of the figure to the plots.
/// A figure with several rows of panels is taller than `height` where its panels need it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// Width of a figure, in mm.
    pub width: f64,
    /// Height of a figure, in mm; if absent, each figure has its own.
    pub height: Option<f64>,
    /// Size of the labels, in points. The smallest letters have 7/8 of it.
    pub letters: f64,
    /// Pixels per inch of PNG files.
    pub dpi: u32,
    /// Whether a figure carries its title and the name of its data.
    pub headings: bool,
    pub colormap: Colormap,
    pub depth: Depth,
}

impl Default for Style {
    fn default() -> Self {
        Style::screen()
    }
}

impl Style {
    /// 1200 CSS pixels wide, with headings.
    pub fn screen() -> Style {
        Style {
            width: 317.5,
            height: None,
            letters: 15.0,
            dpi: 144,
            headings: true,
            colormap: Colormap::default(),
            depth: Depth::default(),
        }
    }

    /// For a column of a paper: 86 mm, labels of 8 points, no headings.
    pub fn paper() -> Style {
        Style {
            width: 86.0,
            letters: 8.0,
            dpi: 300,
            headings: false,
            ..Style::screen()
        }
    }

    /// For both columns of a paper: 178 mm.
    pub fn paper_wide() -> Style {
        Style {
            width: 178.0,
            ..Style::paper()
        }
    }

    /// That figures of this style can be drawn and read.
    ///
    /// # Errors
    /// [`Error::Request`] for `figure-size` if letters would not leave room for the plots, or a side of a
    /// PNG file would have too many pixels; for `dpi`, `decades` and `db` outside their range.
    pub fn check(&self) -> Result<()> {
        let least = (LEAST.0 * self.unit_mm(), LEAST.1 * self.unit_mm());
        let height = self.height.unwrap_or(self.width);
        // Sizes typed in whole millimetres are not refused for a rounding.
        let is_large = self.width >= least.0 - 0.01 && height >= least.1 - 0.01;
        Error::require(
            is_large,
            "figure-size",
            self.least_text(least),
            self.size_text(),
        )?;
        Error::require(
            self.dpi >= 30,
            "dpi",
            "30 pixels per inch or more",
            self.dpi,
        )?;
        let longest = self.width.max(height) / MM_PER_INCH * f64::from(self.dpi);
        let expected = format!("at most {MOST_PIXELS} pixels along a side");
        let found = format!("{} at {} dpi", self.size_text(), self.dpi);
        Error::require(longest <= MOST_PIXELS, "figure-size", expected, found)?;
        let (is_within, option, expected, depth) = match self.depth {
            Depth::Fitted => return Ok(()),
            Depth::Decades(n) => (
                (0.5..=300.0).contains(&n),
                "decades",
                "0.5 to 300 decades",
                n,
            ),
            Depth::Decibels(n) => ((5.0..=3000.0).contains(&n), "db", "5 to 3000 dB", n),
        };
        Error::require(is_within, option, expected, depth)
    }

    fn least_text(&self, (width, height): (f64, f64)) -> String {
        let (width, height) = (width.ceil(), height.ceil());
        let letters = self.letters;
        let least = format!("at least {width:.0} by {height:.0} mm for letters of {letters} pt");
        match letters > Style::paper().letters {
            true => least + "; `--style paper` has smaller ones",
            false => least,
        }
    }

    fn size_text(&self) -> String {
        match self.height {
            Some(height) => format!("{} by {height} mm", self.width),
            None => format!("{} mm", self.width),
        }
    }

    /// Millimetres of a unit of the layout.
    pub(super) fn unit_mm(&self) -> f64 {
        self.letters / LABEL / POINTS_PER_INCH * MM_PER_INCH
    }

    /// Width of a figure, in units.
    pub(super) fn columns(&self) -> f64 {
        self.width / self.unit_mm()
    }

    /// Height of a figure in units: as asked for, but not below what it `needs`; else its own.
    pub(super) fn rows(&self, natural: f64, needs: f64) -> f64 {
        match self.height {
            Some(height) => (height / self.unit_mm()).max(needs),
            None => natural,
        }
    }

    /// Whether plots are as narrow as a column of text.
    pub(super) fn is_narrow(&self) -> bool {
        self.columns() < 900.0
    }
}
