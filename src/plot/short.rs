//! Short-time and short-space spectra: one panel a site, or a time.

use std::ops::Range;

use ndarray::{ArrayView2, s};

use super::axis::PlotAxis;
use super::figures::PASSES;
use super::heat::{BarSide, ColorBar, Greys};
use super::labels::Side;
use super::panel::{self, EDGE, Margins, Panel, TICK_SIZE};
use super::scale::ColorScale;
use super::scene::{Anchor, Rect, Scene};
use super::style::Style;
use super::{Figure, heat, labels};
use crate::analyze::labels::Power;
use crate::analyze::{Analysis, Extent, ShortTimeSpectra, ShortTimeSpectrum};
use crate::sheet::{edges, six_digits};

/// Above each panel, for its name.
const NAME: f64 = 46.0;
/// Between two panels of a row.
const GAP: f64 = 26.0;
/// Least height of a panel.
const LOWEST: f64 = 110.0;

/// `S(f; t)` of chosen sites.
pub fn short_time(analysis: &Analysis, style: &Style) -> Option<Figure> {
    Short::in_time(analysis)?.draw(style)
}

/// `S(k; x)` at chosen times.
pub fn short_space(analysis: &Analysis, style: &Style) -> Option<Figure> {
    Short::in_space(analysis)?.draw(style)
}

/// Spectra of short pieces.
pub(crate) struct Short<'a> {
    analysis: &'a Analysis,
    /// Of the figure, and on pages.
    pub id: &'static str,
    title: &'static str,
    pub spectra: &'a ShortTimeSpectra,
    /// Of bins, and of frames.
    pub sides: [Side; 2],
    /// What each spectrum is at.
    pub at: Side,
    pub quantity: String,
}

impl<'a> Short<'a> {
    pub fn in_time(analysis: &'a Analysis) -> Option<Self> {
        Some(Short {
            analysis,
            id: "short-time",
            title: "Short-time spectra of chosen sites",
            spectra: analysis.short_time.as_ref()?,
            sides: [Side::Frequency, Side::Time],
            at: Side::Space,
            quantity: Power::of(analysis).over_frequency(),
        })
    }

    pub fn in_space(analysis: &'a Analysis) -> Option<Self> {
        Some(Short {
            analysis,
            id: "short-space",
            title: "Short-space spectra at chosen times",
            spectra: analysis.short_space.as_ref()?,
            sides: [Side::Wavenumber, Side::Space],
            at: Side::Time,
            quantity: Power::of(analysis).over_wavenumber(),
        })
    }
}

/// The bins (frames) at `centres` that lie within the display limits of their axis, by index; all of
/// them where there are none.
pub(crate) fn within(centres: &[f64], extent: &Extent) -> Range<usize> {
    if extent.is_whole() {
        return 0..centres.len();
    }
    let slack = 1e-9 * (extent.high - extent.low);
    let is_below = |centre: &f64| *centre < extent.low - slack;
    let first = centres.partition_point(is_below);
    // The bin after the last one still holds a part of what is shown.
    let end = centres.partition_point(|centre| *centre < extent.high - slack) + 1;
    let end = end.min(centres.len());
    match first < end {
        true => first..end,
        false => 0..centres.len(),
    }
}

/// Panels in rows and columns.
struct PanelGrid {
    count: usize,
    columns: usize,
    rows: usize,
    /// Of the outermost panels.
    margins: Margins,
    /// The frames of all panels, and the gaps between them.
    frames: Rect,
}

impl PanelGrid {
    fn rect(&self, index: usize) -> Rect {
        let (row, column) = (index / self.columns, index % self.columns);
        let gaps = GAP * (self.columns - 1) as f64;
        let wide = (self.frames.width() - gaps) / self.columns as f64;
        let tall = self.frames.height() / self.rows as f64;
        let left = self.frames.left + column as f64 * (wide + GAP);
        let top = self.frames.top + row as f64 * tall + NAME;
        Rect {
            left,
            top,
            right: left + wide,
            bottom: top + tall - NAME,
        }
    }
}

impl Short<'_> {
    /// `None` where there is no spectrum to show.
    fn draw(self, style: &Style) -> Option<Figure> {
        let count = self.spectra.spectra.len();
        if count == 0 {
            return None;
        }
        let name = &self.analysis.name;
        let mut scene = Scene::new(&format!("{}: {name}", self.title), style, 0.0);
        let top = panel::heading(&mut scene, self.title, name);
        let spectra = self.spectra.spectra.iter();
        let all: Vec<f64> = spectra
            .flat_map(|s| self.shown(s).into_iter().copied())
            .collect();
        let scale = ColorScale::log(all.iter().copied(), style.depth);
        let bar = ColorBar {
            scale: &scale,
            quantity: &self.quantity,
            greys: Greys {
                missing: all.iter().any(|value| !value.is_finite()),
                ..Greys::default()
            },
        };
        let side = match style.is_narrow() {
            true => BarSide::Below,
            false => BarSide::Right,
        };
        let mut grid = self.grid(count, scene.width);
        // The frames decide how labels break, and these what is left for the frames.
        let mut note = Vec::new();
        for _ in 0..PASSES {
            note = self.notes(&grid, scene.width);
            self.lay_out(&mut grid, &mut scene, (&bar, side), (top, note.len()));
            grid.margins = self.margins(&grid);
        }
        for index in 0..count {
            self.draw_one(&mut scene, &scale, &grid, index);
        }
        let frames = Rect {
            top: grid.frames.top + NAME,
            ..grid.frames
        };
        let from = match side {
            BarSide::Below => grid.margins.bottom,
            BarSide::Right => grid.margins.right,
        };
        bar.draw(&mut scene, frames, side, from);
        let first = scene.height - EDGE - 1.25 * TICK_SIZE * (note.len() as f64 - 0.5);
        let at = (scene.width - 2.0 * EDGE, first);
        scene.lines(&note, at, TICK_SIZE, Anchor::End);
        let name = self.id;
        Some(Figure { name, scene })
    }

    /// The grid before its frames are known but for their approximate size.
    fn grid(&self, count: usize, width: f64) -> PanelGrid {
        let columns = match count {
            _ if width < 900.0 => 1,
            1..=3 => 1,
            4..=8 => 2,
            _ => 3,
        };
        let rows = count.div_ceil(columns);
        let tall = (600.0 / rows as f64).max(160.0);
        let frames = Rect {
            left: 0.0,
            top: 0.0,
            right: 0.7 * width,
            bottom: rows as f64 * (tall + NAME),
        };
        let mut grid = PanelGrid {
            count,
            columns,
            rows,
            margins: Margins::default(),
            frames,
        };
        grid.margins = self.margins(&grid);
        grid
    }

    /// What the outermost panels have beside their frames.
    fn margins(&self, grid: &PanelGrid) -> Margins {
        Margins {
            left: self.panel(grid, 0).margins().left,
            ..self.panel(grid, grid.count - 1).margins()
        }
    }

    /// Sets the height of the figure and the frames of the panels.
    fn lay_out(
        &self,
        grid: &mut PanelGrid,
        scene: &mut Scene,
        (bar, side): (&ColorBar, BarSide),
        (top, note_lines): (f64, usize),
    ) {
        let margins = grid.margins;
        let tall = grid.frames.height();
        let left = EDGE + margins.left;
        let (right, below) = match side {
            BarSide::Right => (margins.right + bar.extent(side, tall - NAME), 0.0),
            BarSide::Below => {
                let length = scene.width - left - EDGE - margins.right;
                (margins.right, bar.extent(side, length))
            }
        };
        let foot = margins.bottom + below + EDGE + heat::note_height(note_lines);
        let needed = (LOWEST + NAME) * grid.rows as f64;
        scene.height = scene.style.rows(top + tall + foot, top + needed + foot);
        grid.frames = Rect {
            left,
            top,
            right: scene.width - EDGE - right,
            bottom: scene.height - foot,
        };
    }

    /// The bins and frames within the display limits.
    fn limits(&self) -> [Range<usize>; 2] {
        let [bins, frames] = self.sides.map(|side| side.extent(self.analysis));
        [
            within(&self.spectra.bins, bins),
            within(&self.spectra.frames, frames),
        ]
    }

    /// The values of a spectrum that are shown.
    fn shown<'s>(&self, spectrum: &'s ShortTimeSpectrum) -> ArrayView2<'s, f64> {
        let extents = self.sides.map(|side| side.extent(self.analysis));
        if extents.iter().all(|extent| extent.is_whole()) {
            return spectrum.values.view();
        }
        let [bins, frames] = self.limits();
        spectrum.values.slice(s![bins, frames])
    }

    /// Lines that say what is not shown, and of how many samples a cell is.
    fn notes(&self, grid: &PanelGrid, width: f64) -> Vec<String> {
        let cells = self.spectra.spectra.iter().enumerate();
        let cells = cells
            .map(|(index, spectrum)| heat::cell_of(&grid.rect(index), self.shown(spectrum).dim()));
        let most = cells.fold((1, 1), |most, cell| {
            (most.0.max(cell.0), most.1.max(cell.1))
        });
        let room = width - 4.0 * EDGE;
        let not_shown = labels::not_shown(self.analysis, &self.sides, false);
        let mut notes = heat::wrapped(not_shown.as_deref(), room);
        notes.extend(heat::reduction_note("largest value", most, room));
        notes
    }

    fn panel(&self, grid: &PanelGrid, index: usize) -> Panel {
        let column = index % grid.columns;
        let is_last = column + 1 == grid.columns || index + 1 == grid.count;
        let axes = &self.analysis.axes;
        let second = self.sides[0].second_reading(axes).filter(|_| is_last);
        let [bins, frames] = self.limits();
        let [content, along] = self.sides.map(|side| side.label(axes));
        let (low, high) = edges(&self.spectra.frames[frames]);
        let x = PlotAxis::linear(&along, low, high);
        let (low, high) = edges(&self.spectra.bins[bins]);
        let y = PlotAxis::linear(&content, low, high).with_second(second);
        Panel {
            names_x: index + grid.columns >= grid.count,
            names_y: column == 0,
            ..Panel::new(grid.rect(index), x, y)
        }
    }

    fn draw_one(&self, scene: &mut Scene, scale: &ColorScale, grid: &PanelGrid, index: usize) {
        let spectrum = &self.spectra.spectra[index];
        let panel = self.panel(grid, index);
        heat::draw(scene, &panel, self.shown(spectrum), scale);
        panel.draw_axes(scene);
        let label = self.at.label(&self.analysis.axes);
        let text = format!("{label} = {}", six_digits(spectrum.at));
        let at = (panel.rect.left, panel.rect.top - 16.0);
        scene.text(text, at, TICK_SIZE, Anchor::Start);
    }
}
