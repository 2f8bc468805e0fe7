//! Figures from results, as PNG and SVG; computes nothing.
//!
//! [`figures_of`] draws the figures of a [described](crate::sheet::Describe) result in a [`Style`], [`save_all`] writes
//! them. [`own_chart`](fn@own_chart) serves charts of your own, drawn by [`plotters`].

mod axis;
mod chart;
mod curve;
mod dispersion;
mod font;
mod heat;
mod heat_chart;
mod layout;
mod legend;
mod own_chart;
mod panel;
mod raster;
mod scale;
mod scene;
mod style;
mod ticks;
mod uprights;

use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

pub use crate::sheet::{
    Band, Chart, Colors, Curve, FigureLayout, Level, Look, Mark, Marker, PALETTE, PlotRow, Role,
    Series, Weight, around, extent, magnitudes, ordinary,
};
pub use layout::figures_of;
pub use own_chart::{Area, own_chart, px, sans};
pub use plotters;
pub use style::{Colormap, Depth, Style};

pub(crate) use scale::{DECADES, palette};

use crate::{Error, Result};

/// A file format of figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    Png,
    /// With text as text and heat maps as embedded pictures.
    Svg,
}

impl Format {
    pub fn extension(self) -> &'static str {
        match self {
            Format::Png => "png",
            Format::Svg => "svg",
        }
    }

    /// A document as the bytes of a file, a PNG file with so many pixels per inch.
    fn encode(self, svg: String, dpi: u32) -> std::result::Result<Vec<u8>, String> {
        match self {
            Format::Png => raster::rendered(&svg, dpi),
            Format::Svg => Ok(svg.into_bytes()),
        }
    }
}

/// A figure, ready to be written in any format.
#[derive(Debug)]
pub struct Figure {
    name: &'static str,
    scene: scene::Scene,
}

impl Figure {
    /// Its caption.
    pub fn title(&self) -> &str {
        &self.scene.title
    }

    /// Name of its file, without extension.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The bytes of its file.
    ///
    /// # Errors
    /// [`Error::Failed`] if the figure cannot be painted or encoded.
    pub fn encode(&self, format: Format) -> Result<Vec<u8>> {
        let encoded = format.encode(self.scene.document(), self.scene.style.dpi);
        let title = &self.scene.title;
        encoded.map_err(|reason| Error::failed(format!("cannot draw {title}: {reason}")))
    }

    /// Writes `<dir>/<name>.<extension>`, whole or not at all, and returns its path.
    ///
    /// # Errors
    /// [`Error::Failed`] if the figure cannot be painted, [`Error::Write`] if it cannot be written.
    pub fn save(&self, dir: &Path, format: Format) -> Result<PathBuf> {
        let bytes = self.encode(format)?;
        let path = dir.join(format!("{}.{}", self.name, format.extension()));
        crate::system::publish::write_whole(&path, &bytes).map_err(Error::write("write", &path))?;
        Ok(path)
    }
}

/// Writes figures into `dir`, in parallel; returns the paths written, in order.
///
/// # Errors
/// The first of [`Figure::save`]'s errors; [`Error::Write`] if `dir` cannot be made.
pub fn save_all(figures: &[Figure], dir: &Path, formats: &[Format]) -> Result<Vec<PathBuf>> {
    fs::create_dir_all(dir).map_err(Error::write("make the directory", dir))?;
    let each = |figure| formats.iter().map(move |format| (figure, *format));
    let files: Vec<(&Figure, Format)> = figures.iter().flat_map(each).collect();
    files
        .par_iter()
        .map(|(figure, format)| figure.save(dir, *format))
        .collect()
}
