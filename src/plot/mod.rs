//! Figures from results, as PNG and SVG; computes nothing.
//!
//! Each figure is a function of results and a [`Style`]; it gives `None` if a result was not requested.
//! [`draw_all`] draws and writes all of them. They are drawn by [`plotters`] on a [`Canvas`], which
//! also serves your own charts.

mod axis;
mod bitmap;
mod budget;
mod canvas;
mod chart;
mod curve;
mod dispersion;
mod figures;
mod font;
mod grid;
mod heat;
mod heat_chart;
pub(crate) mod labels;
mod layout;
mod legend;
mod painter;
mod panel;
mod redistribution;
mod scale;
mod scene;
mod short;
mod style;
mod svg;
mod ticks;
mod uprights;
mod views;

use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

pub use crate::sheet::{
    Band, Chart, Colors, Curve, HeatChart, Level, Look, Mark, Marker, PALETTE, Plot, PlotRow, Role,
    Series, extent,
};
pub use axis::around;
pub use budget::{SharedScales, budget_figures, encode_all};
pub use canvas::{Area, Canvas, CanvasSurface, px, sans};
pub use figures::{
    flux_surrogate, space_time, spacetime_spectrum, spatial_spectrum, temporal_spectrum,
};
pub use grid::{Colours, Tile, map_grid};
pub use layout::{FigureLayout, figure_of};
pub use plotters;
pub use redistribution::{along_t, along_x};
pub use short::{short_space, short_time};
pub use style::{Colormap, Depth, Style};
pub use views::views;

pub(crate) use budget::ordinary;
pub(crate) use figures::MAPS;
pub(crate) use heat::block_extremes;
pub(crate) use redistribution::Content;
pub(crate) use scale::{ColorScale, DECADES};
pub(crate) use short::{Short, within};

use crate::analyze::Analysis;
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
    /// [`Error::Draw`] if the figure cannot be painted or encoded.
    pub fn encode(&self, format: Format) -> Result<Vec<u8>> {
        let scene = &self.scene;
        let size = (scene.width, scene.height);
        let canvas = Canvas::of(&scene.title, size, &scene.style.page(format))?;
        scene.draw(&canvas.area())?;
        canvas.encode()
    }

    /// Writes `<dir>/<name>.<extension>`, whole or not at all, and returns its path.
    ///
    /// # Errors
    /// [`Error::Draw`] if the figure cannot be painted, [`Error::Write`] if it cannot be written.
    pub fn save(&self, dir: &Path, format: Format) -> Result<PathBuf> {
        let bytes = self.encode(format)?;
        let path = dir.join(format!("{}.{}", self.name, format.extension()));
        crate::system::publish::write_whole(&path, &bytes).map_err(Error::write("write", &path))?;
        Ok(path)
    }
}

/// Draws every figure whose result is present into `dir`, in parallel; returns the paths written,
/// in a fixed order.
///
/// # Errors
/// The first of [`Figure::save`]'s errors; [`Error::Write`] if `dir` cannot be made.
pub fn draw_all(
    analysis: &Analysis,
    dir: &Path,
    formats: &[Format],
    style: &Style,
) -> Result<Vec<PathBuf>> {
    let figures: [fn(&Analysis, &Style) -> Option<Figure>; 9] = [
        space_time,
        temporal_spectrum,
        spatial_spectrum,
        spacetime_spectrum,
        along_x,
        along_t,
        short_time,
        short_space,
        flux_surrogate,
    ];
    let figures: Vec<Figure> = figures
        .par_iter()
        .filter_map(|draw| draw(analysis, style))
        .collect();
    save_all(&figures, dir, formats)
}

/// Writes figures into `dir`, in parallel; returns the paths written, in order.
///
/// # Errors
/// As [`draw_all`].
pub fn save_all(figures: &[Figure], dir: &Path, formats: &[Format]) -> Result<Vec<PathBuf>> {
    fs::create_dir_all(dir).map_err(Error::write("make the directory", dir))?;
    let each = |figure| formats.iter().map(move |format| (figure, *format));
    let files: Vec<(&Figure, Format)> = figures.iter().flat_map(each).collect();
    files
        .par_iter()
        .map(|(figure, format)| figure.save(dir, *format))
        .collect()
}
