//! Short-time and short-space spectra: one panel a site, or a time.

use super::axis::PlotAxis;
use super::panel::{self, Panel};
use super::scale::ColorScale;
use super::scene::{Anchor, Rect, Scene};
use super::{Figure, heat, labels};
use crate::analyze::{Analysis, ShortTimeSpectra};

const WIDTH: f64 = 1200.0;
const LEFT: f64 = 125.0;
const RIGHT: f64 = 965.0;
const GAP: f64 = 46.0;

/// `S(f; t)` of chosen sites.
pub fn short_time(analysis: &Analysis) -> Option<Figure> {
    let axes = &analysis.axes;
    let sheet = ShortTimeFigure {
        title: "Short-time spectra of chosen sites",
        name: &analysis.name,
        spectra: analysis.short_time.as_ref()?,
        along: labels::time(axes),
        content: labels::frequency(axes),
        second: None,
        quantity: labels::short_time_density(analysis),
        panel_label: labels::position(axes),
    };
    sheet.draw("short-time")
}

/// `S(k; x)` at chosen times.
pub fn short_space(analysis: &Analysis) -> Option<Figure> {
    let axes = &analysis.axes;
    let sheet = ShortTimeFigure {
        title: "Short-space spectra at chosen times",
        name: &analysis.name,
        spectra: analysis.short_space.as_ref()?,
        along: labels::position(axes),
        content: labels::wavenumber(axes),
        second: labels::wavenumber_reading(axes),
        quantity: labels::short_space_density(analysis),
        panel_label: labels::time(axes),
    };
    sheet.draw("short-space")
}

struct ShortTimeFigure<'a> {
    title: &'static str,
    name: &'a str,
    spectra: &'a ShortTimeSpectra,
    along: String,
    content: String,
    second: Option<(String, f64)>,
    quantity: String,
    panel_label: String,
}

/// Cell edges about evenly spaced centres.
pub(crate) fn edges(centres: &[f64]) -> (f64, f64) {
    match centres {
        [] => (0.0, 1.0),
        [only] => (only - 0.5, only + 0.5),
        [first, second, ..] => {
            let half = (second - first) / 2.0;
            (first - half, centres[centres.len() - 1] + half)
        }
    }
}

impl ShortTimeFigure<'_> {
    /// `None` where there is no spectrum to show.
    fn draw(self, name: &'static str) -> Option<Figure> {
        let count = self.spectra.spectra.len();
        if count == 0 {
            return None;
        }
        let columns = match count {
            1..=3 => 1,
            4..=8 => 2,
            _ => 3,
        };
        let rows = count.div_ceil(columns);
        let tall = (600.0 / rows as f64).max(200.0);
        let bottom = 60.0 + rows as f64 * (tall + GAP);
        let title = format!("{}: {}", self.title, self.name);
        let mut scene = Scene::new(&title, WIDTH as u32, (bottom + 95.0) as u32);
        panel::heading(&mut scene, self.title, self.name);

        let all = self.spectra.spectra.iter().flat_map(|s| s.values.iter());
        let scale = ColorScale::log(all.clone().copied());
        let mut most = (1, 1);
        for index in 0..count {
            let cell = self.draw_one(&mut scene, &scale, (index, count), columns, tall);
            most = (most.0.max(cell.0), most.1.max(cell.1));
        }
        heat::reduction_note(&mut scene, "largest value", most);
        let bar = Rect {
            left: WIDTH - 207.0,
            right: WIDTH - 183.0,
            top: 60.0 + GAP,
            bottom: (60.0 + GAP + 600.0).min(bottom),
        };
        let missing = all.clone().any(|value| !value.is_finite());
        heat::colour_bar(&mut scene, bar, &scale, &self.quantity, missing);
        Some(Figure { name, scene })
    }

    /// One panel; returns how many rows and columns of values its cells stand for.
    fn draw_one(
        &self,
        scene: &mut Scene,
        scale: &ColorScale,
        (index, count): (usize, usize),
        columns: usize,
        tall: f64,
    ) -> (usize, usize) {
        let spectrum = &self.spectra.spectra[index];
        let (row, column) = (index / columns, index % columns);
        let right = if self.second.is_some() {
            RIGHT - 75.0
        } else {
            RIGHT
        };
        let wide = (right - LEFT + 24.0) / columns as f64 - 24.0;
        let left = LEFT + column as f64 * (wide + 24.0);
        let top = 60.0 + GAP + row as f64 * (tall + GAP);
        let rect = Rect {
            left,
            top,
            right: left + wide,
            bottom: top + tall,
        };
        let last_column = column + 1 == columns || index + 1 == count;
        let second = self.second.clone().filter(|_| last_column);
        let (low, high) = edges(&self.spectra.frames);
        let x = PlotAxis::linear(&self.along, low, high);
        let (low, high) = edges(&self.spectra.bins);
        let y = PlotAxis::linear(&self.content, low, high).with_second(second);
        let mut panel = Panel::new(rect, x, y);
        panel.names_x = index + columns >= count;
        panel.names_y = column == 0;
        let cell = heat::draw(scene, &panel, spectrum.values.view(), scale);
        panel.draw_axes(scene);
        let text = format!("{} = {}", self.panel_label, shown(spectrum.at));
        let size = panel::TICK_SIZE;
        scene.text(text, (left, top - 16.0), size, Anchor::Start);
        cell
    }
}

/// Up to six significant digits.
fn shown(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded}")
}
