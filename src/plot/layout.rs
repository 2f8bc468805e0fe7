//! The layout of a figure: charts and maps in rows, with aligned frames and a common legend.

use rayon::prelude::*;

use super::Figure;
use super::axis::{EDGE, LABEL_SIZE, LINE, Side, TICK_SIZE};
use super::font;
use super::heat_chart::color_bar;
use super::legend::{self, Entry};
use super::panel::{self, Margins};
use super::scene::{Anchor, Rect, Scene};
use super::style::Style;
use crate::sheet::{Chart, Describe, FigureLayout, PlotRow, Sheet};

/// Passes of a layout.
const PASSES: usize = 3;
/// Narrowest cell of a row; rows of more cells are broken.
const NARROWEST: f64 = 420.0;
/// Between two cells, and below a row.
const GAP: f64 = 18.0;
/// Least height of a frame.
const LOWEST: f64 = 100.0;

impl FigureLayout {
    /// The figure, laid out by a style.
    pub fn figure(&self, name: &'static str, style: &Style) -> Figure {
        let title = match self.data.is_empty() {
            true => self.title.clone(),
            false => format!("{}: {}", self.title, self.data),
        };
        let mut scene = Scene::new(&title, style);
        let top = panel::heading(&mut scene, &self.title, &self.data);
        Layout::of(self, &scene.style.clone(), scene.width, top).draw(&mut scene);
        Figure { name, scene }
    }
}

/// The figures of a result with the name `data`; one without a name of its own is called `name`.
pub fn figures_of(
    found: &dyn Describe,
    sheet: &Sheet,
    data: &str,
    name: &'static str,
    style: &Style,
) -> Vec<Figure> {
    let mut layouts = found.figures();
    layouts.retain(|layout| !layout.is_on_page_only);
    let draw = |layout: FigureLayout| {
        let is_named = !layout.name.is_empty();
        let notes = layout.notes.into_iter();
        let layout = FigureLayout {
            title: match layout.title.is_empty() {
                true => sheet.title.clone(),
                false => layout.title,
            },
            data: data.into(),
            notes: notes.chain([sheet.note.clone()]).collect(),
            ..layout
        };
        layout.figure(if is_named { layout.name } else { name }, style)
    };
    layouts.into_par_iter().map(draw).collect()
}

/// What a row takes: above its frames, and beside them.
#[derive(Default)]
struct MeasuredRow {
    /// Titles and legends.
    above: f64,
    margins: Margins,
    frame: f64,
}

struct Layout<'a> {
    figure: &'a FigureLayout,
    style: &'a Style,
    rows: Vec<PlotRow>,
    width: f64,
    top: f64,
    common: Vec<Entry>,
}

impl<'a> Layout<'a> {
    fn of(figure: &'a FigureLayout, style: &'a Style, width: f64, top: f64) -> Self {
        let most = ((width / NARROWEST) as usize).max(1);
        let rows: Vec<PlotRow> = figure
            .rows
            .iter()
            .flat_map(|row| match row.columns <= most {
                true => vec![row.clone()],
                false => (PlotRow::grid(most, row.plots.clone()).into_iter())
                    .map(|part| part.high(row.height))
                    .collect(),
            })
            .collect();
        Layout {
            common: common(&rows, width),
            rows,
            figure,
            style,
            width,
            top,
        }
    }

    fn cell(&self, row: &PlotRow, column: usize) -> (f64, f64) {
        let columns = row.columns as f64;
        let wide = (self.width - 2.0 * EDGE - GAP * (columns - 1.0)) / columns;
        let left = EDGE + column as f64 * (wide + GAP);
        (left, left + wide)
    }

    fn names_x(&self, index: usize) -> bool {
        !self.figure.shared_x || index + 1 == self.rows.len()
    }

    /// Maps that share their colours, where all plots do.
    fn sharing(&self) -> Vec<&Chart> {
        let mut maps: Vec<&Chart> = self.rows.iter().flat_map(|row| &row.plots).collect();
        let is_shared =
            |map: &&Chart| map.is_map() && map.shared.is_some() && map.shared == maps[0].shared;
        if maps.len() < 2 || !maps.iter().all(is_shared) {
            maps.clear();
        }
        maps
    }

    /// Where maps have their colour bars; if they share it, it is below the last row.
    fn bar(&self) -> Option<Side> {
        let side = match self.style.is_narrow() {
            true => Side::Below,
            false => Side::Right,
        };
        self.sharing().is_empty().then_some(side)
    }

    /// Margins of frames of the heights of these rows, equal where rows have as many cells.
    fn margins(&self, rows: &[MeasuredRow]) -> Vec<Margins> {
        let own: Vec<Margins> = (self.rows.iter().enumerate())
            .map(|(index, row)| {
                let (left, right) = self.cell(row, 0);
                let rect = Rect {
                    left: left + 90.0,
                    top: 0.0,
                    right: (right - 30.0).max(left + 150.0),
                    bottom: rows[index].frame,
                };
                let all = row.plots.iter();
                all.map(|plot| plot.margins(rect, self.names_x(index), self.bar(), self.style))
                    .fold(Margins::default(), Margins::max)
            })
            .collect();
        let aligned = |index: usize| {
            let alike = self.rows.iter().zip(&own);
            let alike = alike.filter(|(row, _)| row.columns == self.rows[index].columns);
            let most = alike.fold(Margins::default(), |most, (_, own)| most.max(*own));
            Margins {
                left: most.left,
                right: most.right,
                ..own[index]
            }
        };
        (0..self.rows.len()).map(aligned).collect()
    }

    fn above(&self, row: &PlotRow, width: f64) -> f64 {
        let heights = row.plots.iter().map(|plot| {
            let title = match &*plot.title {
                "" => 0.0,
                title => LINE * font::wrap(title, LABEL_SIZE, width).len() as f64 + 4.0,
            };
            title + legend::height(&self.entries(plot, width), width)
        });
        heights.fold(0.0, f64::max)
    }

    /// Of the legend of a plot; none where all have a common one.
    fn entries(&self, plot: &Chart, width: f64) -> Vec<Entry> {
        match self.common.is_empty() {
            true => plot.entries(width),
            false => Vec::new(),
        }
    }

    /// What rows take, and the height of the figure. Frames decide how labels break and how many ticks there are, and
    /// these what is left for the frames.
    fn measure(&self) -> (Vec<MeasuredRow>, f64) {
        let begun = self.rows.iter().map(|row| MeasuredRow {
            frame: 220.0 * row.height,
            ..MeasuredRow::default()
        });
        let (mut rows, mut total): (Vec<_>, _) = (begun.collect(), 0.0);
        for _ in 0..PASSES {
            let notes = self.notes(&rows).len();
            let margins = self.margins(&rows);
            let mut fixed = self.top + 1.25 * TICK_SIZE * notes as f64 + EDGE;
            for ((measured, row), margins) in rows.iter_mut().zip(&self.rows).zip(margins) {
                let (left, right) = self.cell(row, 0);
                let width = right - left - margins.left - margins.right;
                let most = (370.0 * row.height).max(LOWEST);
                *measured = MeasuredRow {
                    above: self.above(row, width),
                    margins,
                    frame: (0.62 * width * row.height.min(1.0)).clamp(LOWEST, most),
                };
                fixed += measured.above + margins.top + margins.bottom + GAP;
            }
            let (_, room) = self.common_place(&rows);
            fixed += legend::height(&self.common, room);
            if let Some(bar) = color_bar(&self.sharing(), self.style) {
                fixed += bar.extent(Side::Below, self.frames(&rows, 0.0).width());
            }
            let frames: f64 = rows.iter().map(|row| row.frame).sum();
            let needs = fixed + LOWEST * rows.len() as f64;
            total = self.style.rows(fixed + frames, needs);
            rows.iter_mut()
                .for_each(|row| row.frame *= (total - fixed) / frames);
        }
        (rows, total)
    }

    fn draw(&self, scene: &mut Scene) {
        let (rows, total) = self.measure();
        scene.height = total;
        let (left, room) = self.common_place(&rows);
        legend::draw(scene, (left, self.top), room, &self.common);
        let mut top = self.top + legend::height(&self.common, room);
        for (index, (row, measured)) in self.rows.iter().zip(&rows).enumerate() {
            let frame_top = top + measured.above + measured.margins.top;
            for (column, plot) in row.plots.iter().enumerate() {
                let rect = self.frame(row, measured, column, frame_top);
                self.draw_head(scene, plot, (top, top + measured.above), rect);
                plot.draw(scene, rect, self.names_x(index), self.bar());
            }
            top = frame_top + measured.frame + measured.margins.bottom + GAP;
        }
        if let Some(bar) = color_bar(&self.sharing(), self.style) {
            let frames = self.frames(&rows, top - GAP);
            bar.draw(scene, frames, Side::Below, 0.0);
            top += bar.extent(Side::Below, frames.width());
        }
        let at = (2.0 * EDGE, top + 0.5 * TICK_SIZE);
        scene.lines(&self.notes(&rows), at, TICK_SIZE, Anchor::Start);
    }

    fn frame(&self, row: &PlotRow, measured: &MeasuredRow, column: usize, top: f64) -> Rect {
        let (left, right) = self.cell(row, column);
        Rect {
            left: left + measured.margins.left,
            top,
            right: right - measured.margins.right,
            bottom: top + measured.frame,
        }
    }

    /// From the first frame of the first row to its last, down to `bottom`.
    fn frames(&self, rows: &[MeasuredRow], bottom: f64) -> Rect {
        let [first, last] = [0, self.rows[0].columns - 1]
            .map(|column| self.frame(&self.rows[0], &rows[0], column, 0.0));
        Rect {
            right: last.right,
            bottom,
            ..first
        }
    }

    /// Lines that say what is not shown, and of how many samples a cell is at most.
    fn notes(&self, rows: &[MeasuredRow]) -> Vec<String> {
        let mut notes = self.figure.notes.clone();
        let mut reduced: Option<(&str, [usize; 2])> = None;
        for (row, measured) in self.rows.iter().zip(rows) {
            for plot in &row.plots {
                notes.extend(plot.not_shown.clone());
                if plot.is_map() {
                    let (what, cell) = plot.cell(&self.frame(row, measured, 0, 0.0));
                    let most = reduced.map_or([1, 1], |(_, most)| most);
                    reduced = Some((what, [0, 1].map(|side| cell[side].max(most[side]))));
                }
            }
        }
        notes.dedup();
        if let Some((what, [rows, columns])) = reduced.filter(|(_, cell)| *cell != [1, 1]) {
            notes.push(format!(
                "each cell: {what} among up to {rows} (vertical) × {columns} (horizontal) samples"
            ));
        }
        let room = self.width - 4.0 * EDGE;
        let lines = notes.iter().filter(|note| !note.is_empty());
        lines
            .flat_map(|note| font::wrap(note, TICK_SIZE, room))
            .collect()
    }

    /// The left end of the common legend, where the first frame begins, and its width.
    fn common_place(&self, rows: &[MeasuredRow]) -> (f64, f64) {
        let left = EDGE + rows.first().map_or(0.0, |row| row.margins.left.min(100.0));
        (left, self.width - left - EDGE)
    }

    /// Title and legend, the latter down to `end`.
    fn draw_head(&self, scene: &mut Scene, plot: &Chart, (top, end): (f64, f64), rect: Rect) {
        let width = rect.width();
        if !plot.title.is_empty() {
            let title = font::wrap(&plot.title, LABEL_SIZE, width);
            let at = (rect.left, top + 0.5 * LINE);
            scene.lines(&title, at, LABEL_SIZE, Anchor::Start);
        }
        let entries = self.entries(plot, width);
        let start = end - legend::height(&entries, width);
        legend::draw(scene, (rect.left, start), width, &entries);
    }
}

/// The names of all charts, if they are the same in each; none if there is but one chart.
fn common(rows: &[PlotRow], width: f64) -> Vec<Entry> {
    let plots = || rows.iter().flat_map(|row| &row.plots);
    let mut all = plots()
        .map(|plot| plot.entries(width))
        .filter(|entries| !entries.is_empty());
    let (first, mut count) = (all.next().unwrap_or_default(), 1);
    let meaning = |entry: &Entry| (entry.label.clone(), entry.color, entry.stroke);
    let same = all.all(|entries| {
        count += 1;
        entries.iter().map(meaning).eq(first.iter().map(meaning))
    });
    match same && count > 1 {
        true => first,
        false => Vec::new(),
    }
}
