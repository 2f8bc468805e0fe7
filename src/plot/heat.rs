//! Heat maps and their colour bars.

use ndarray::ArrayView2;

use super::font;
use super::panel::{self, EDGE, LABEL_SIZE, LINE, LabelSide, Panel, TICK_SIZE, label_upright};
use super::scale::{ColorScale, NO_VALUE};
use super::scene::{Anchor, Color, INK, Image, Mark, Rect, Scene};
use crate::sheet::{Map, Reduction, block_extremes, blocks_of};

/// Most rows and columns of cells in a picture, so that an SVG of noise stays below 500 kB.
const MOST_CELLS: (usize, usize) = (400, 600);

/// Draws `values` (row 0 at the bottom) over the whole panel.
pub(super) fn draw<T>(scene: &mut Scene, panel: &Panel, values: ArrayView2<T>, scale: &ColorScale)
where
    T: Copy + Into<f64>,
{
    let blocks = block_extremes(values, most_cells(&panel.rect));
    let (rows, columns) = blocks.dim();
    if rows == 0 || columns == 0 {
        return;
    }
    scene.marks.push(Mark::Image(Image {
        at: panel.rect,
        columns,
        rows,
        palette: scale.palette(scene.style.colormap),
        cells: blocks
            .rows()
            .into_iter()
            .rev()
            .flat_map(|row| row.to_vec())
            .map(|value| scale.index(value))
            .collect(),
    }));
}

/// Least over largest magnitude of the two signs in a cell from which on neither stands for it: the
/// sign would alternate from cell to cell as the samples happen to fall, and draw waves that are not
/// there.
const BOTH_SIGNS: f64 = 0.5;

/// Share of the scale up to which a cell is drawn as zero, whatever its signs: grey would show rounding of nothing.
const NEAR_ZERO: f64 = 1.0 / 32.0;

/// Grey of cells that hold both signs: at the largest magnitude, and at none.
const GREYS: (f64, f64) = (64.0, 247.0);

/// Whether a map of signed values has cells of both signs that [`draw_signed`] would show in grey.
pub(super) fn holds_both_signs(map: &Map) -> bool {
    let is_signed = matches!(map.reduction, Reduction::Extreme { .. });
    let any = map.range.as_ref().is_some_and(|[low, high]| {
        let mut cells = low.iter().zip(high);
        cells.any(|(low, high)| balanced(-f64::from(*low), f64::from(*high)).is_some())
    });
    is_signed && any
}

/// The larger magnitude of two signs, if neither stands for both.
fn balanced(down: f64, up: f64) -> Option<f64> {
    let size = up.max(down);
    (size.is_finite() && up.min(down) > BOTH_SIGNS * size).then_some(size)
}

/// Draws a map of signed values over the whole panel, cells that hold both signs in grey.
pub(super) fn draw_signed(scene: &mut Scene, panel: &Panel, map: &Map, scale: &ColorScale) {
    draw(scene, panel, map.values.view(), scale);
    let Some(Mark::Image(image)) = scene.marks.last_mut() else {
        return;
    };
    let [low, high] = match &map.range {
        Some(range) => range.each_ref(),
        None => [&map.values; 2],
    };
    let (rows, columns) = (image.rows, image.columns);
    // Every other colour of the scale, then as many greys, then that of cells without a value.
    let colors = image.palette.len() / 2;
    let palette = image.palette.iter().step_by(2).take(colors).copied();
    let greys = (0..colors - 1).map(|level| {
        let share = level as f64 / (colors - 2) as f64;
        [(GREYS.1 + share * (GREYS.0 - GREYS.1)) as u8; 3]
    });
    let palette: Vec<Color> = palette.chain(greys).chain([NO_VALUE]).collect();
    let mut cells = Vec::with_capacity(image.cells.len());
    let least = blocks_of(low.view(), (rows, columns), f32::INFINITY, f32::min);
    let most = blocks_of(high.view(), (rows, columns), f32::NEG_INFINITY, f32::max);
    for (at, &index) in image.cells.iter().enumerate() {
        let place = [rows - 1 - at / columns, at % columns];
        let [down, up] = [-least[place], most[place]].map(f64::from);
        let is_missing = usize::from(index) + 1 == image.palette.len();
        cells.push(match balanced(down, up) {
            _ if is_missing => index,
            Some(size) => {
                let share = scale.share(size).map_or(0.0, |share| 2.0 * (share - 0.5));
                if share < NEAR_ZERO {
                    cells.push(scale.index(0.0) / 2);
                    continue;
                }
                (colors as f64 + share * (colors - 2) as f64) as u8
            }
            None => index / 2,
        });
    }
    (image.palette, image.cells) = (palette, cells);
}

/// A cell is no smaller than a unit, so that none is lost between pixels.
fn most_cells(rect: &Rect) -> (usize, usize) {
    (
        (rect.height() as usize).clamp(1, MOST_CELLS.0),
        (rect.width() as usize).clamp(1, MOST_CELLS.1),
    )
}

/// How many rows and columns of values a cell stands for, at most.
pub(super) fn cell_of(rect: &Rect, (rows, columns): (usize, usize)) -> (usize, usize) {
    let (most_rows, most_columns) = most_cells(rect);
    let of = |values: usize, most: usize| values.div_ceil(values.clamp(1, most));
    (of(rows, most_rows), of(columns, most_columns))
}

/// Where a colour bar is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BarSide {
    /// Right of the frame, with its label beside it.
    Right,
    /// Below the frame, with its label below it.
    Below,
}

/// A colour scale with its quantity.
pub(super) struct ColorBar<'a> {
    pub scale: &'a ColorScale,
    pub quantity: &'a str,
    pub greys: Greys,
}

/// Colours of a map that are none of its scale.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Greys {
    /// Whether the map has cells without a value.
    pub missing: bool,
    /// Whether it has cells of both signs.
    pub both_signs: bool,
}

impl Greys {
    /// Colours with what they mean.
    fn explained(self) -> impl Iterator<Item = (Color, &'static str)> {
        let grey = [((GREYS.0 + GREYS.1) / 2.0) as u8; 3];
        let missing = self.missing.then_some((NO_VALUE, "no value"));
        let both = self.both_signs.then_some((grey, "both signs"));
        missing.into_iter().chain(both)
    }
}

/// From the frame, or what is beside it, to the bar.
const GAP: f64 = 22.0;
const THICKNESS: f64 = 22.0;
/// Below a level bar, for each colour that is none of its scale.
const GREY_LINE: f64 = 26.0;

impl ColorBar<'_> {
    /// Values with their place along a bar of this length, 0 to 1.
    fn ticks(&self, length: f64, spacing: f64) -> Vec<(f64, String)> {
        let lowest = self.scale.lowest_text().map(|text| (0.0, text));
        let nearest = spacing / length;
        let regular = self.scale.ticks((length / spacing / 1.5).max(2.0) as usize);
        let regular = regular.into_iter().filter_map(|tick| {
            let share = self.scale.share(tick.value)?;
            (lowest.is_none() || share > nearest).then_some((share, tick.text))
        });
        lowest.iter().cloned().chain(regular).collect()
    }

    /// What the bar takes right of a frame of this height, or below one of this width.
    pub fn extent(&self, side: BarSide, length: f64) -> f64 {
        let label = self.scale.label(self.quantity);
        match side {
            BarSide::Right => {
                let lines = panel::upright_lines(&label, length).len() as f64;
                let ticks = self.ticks(length, UPRIGHT_SPACING);
                let widest = ticks.iter().map(|(_, text)| font::width(text, TICK_SIZE));
                let widest = widest.fold(0.0, f64::max);
                let beside = 30.0 + widest + LINE * (lines - 1.0) + 0.5 * LABEL_SIZE;
                let greys = self.greys.explained();
                let greys = greys.map(|(_, meaning)| 11.0 + font::width(meaning, TICK_SIZE));
                GAP + THICKNESS + greys.fold(beside, f64::max)
            }
            BarSide::Below => {
                let lines = font::wrap(&label, LABEL_SIZE, length + 2.0 * EDGE).len() as f64;
                let greys = self.greys.explained().count() as f64;
                let greys = if greys > 0.0 {
                    14.0 + GREY_LINE * greys
                } else {
                    0.0
                };
                GAP + THICKNESS + 42.0 + LINE * (lines - 1.0) + 0.5 * LABEL_SIZE + greys
            }
        }
    }

    /// Draws the bar `from` a frame's side on, as long as the frame.
    pub fn draw(&self, scene: &mut Scene, frame: Rect, side: BarSide, from: f64) {
        match side {
            BarSide::Right => {
                let left = frame.right + from + GAP;
                let right = left + THICKNESS;
                let bar = Rect {
                    left,
                    right,
                    ..frame
                };
                self.draw_upright(scene, bar);
            }
            BarSide::Below => {
                let top = frame.bottom + from + GAP;
                let bottom = top + THICKNESS;
                let bar = Rect {
                    top,
                    bottom,
                    ..frame
                };
                self.draw_level(scene, bar);
            }
        }
    }

    fn colors(&self, scene: &mut Scene, rect: Rect, side: BarSide) {
        let palette = self.scale.palette(scene.style.colormap);
        let levels = palette.len() - 1;
        let all = (0..levels).map(|level| level as u8);
        let (columns, rows, cells) = match side {
            BarSide::Right => (1, levels, all.rev().collect()),
            BarSide::Below => (levels, 1, all.collect()),
        };
        scene.marks.push(Mark::Image(Image {
            at: rect,
            columns,
            rows,
            palette,
            cells,
        }));
        scene.outline(rect, INK);
    }

    fn draw_upright(&self, scene: &mut Scene, rect: Rect) {
        self.colors(scene, rect, BarSide::Right);
        let mut widest = 0.0f64;
        for (share, text) in self.ticks(rect.height(), UPRIGHT_SPACING) {
            let y = rect.bottom - share * rect.height();
            scene.line(vec![(rect.right, y), (rect.right + 6.0, y)], INK, 1.0);
            widest = widest.max(font::width(&text, TICK_SIZE));
            scene.text(text, (rect.right + 11.0, y), TICK_SIZE, Anchor::Start);
        }
        let label = self.scale.label(self.quantity);
        let at = (rect.right + 30.0 + widest, rect.middle().1);
        label_upright(scene, &label, at, rect.height(), LabelSide::Right);
        self.explain_greys(scene, (rect.left, rect.bottom + 18.0));
    }

    fn draw_level(&self, scene: &mut Scene, rect: Rect) {
        self.colors(scene, rect, BarSide::Below);
        let mut end = f64::NEG_INFINITY;
        for (share, text) in self.ticks(rect.width(), LEVEL_SPACING) {
            let x = rect.left + share * rect.width();
            let width = font::width(&text, TICK_SIZE);
            if x - 0.5 * width < end + 0.5 * TICK_SIZE {
                continue;
            }
            end = x + 0.5 * width;
            let below = rect.bottom;
            scene.line(vec![(x, below), (x, below + 6.0)], INK, 1.0);
            scene.text(text, (x, below + 18.0), TICK_SIZE, Anchor::Middle);
        }
        let label = self.scale.label(self.quantity);
        let lines = font::wrap(&label, LABEL_SIZE, rect.width() + 2.0 * EDGE);
        let at = (rect.middle().0, rect.bottom + 42.0);
        scene.lines(&lines, at, LABEL_SIZE, Anchor::Middle);
        let top = rect.bottom + 42.0 + LINE * (lines.len() as f64 - 0.5) + 4.0;
        self.explain_greys(scene, (rect.left, top));
    }

    /// Swatches from `(left, top)` down, with their meaning.
    fn explain_greys(&self, scene: &mut Scene, (left, top): (f64, f64)) {
        for (index, (color, meaning)) in self.greys.explained().enumerate() {
            let top = top + GREY_LINE * index as f64;
            let swatch = Rect {
                left,
                right: left + THICKNESS,
                top,
                bottom: top + 18.0,
            };
            scene.fill(swatch, color);
            scene.outline(swatch, INK);
            let at = (swatch.right + 11.0, swatch.middle().1);
            scene.text(meaning, at, TICK_SIZE, Anchor::Start);
        }
    }
}

/// From one value of a bar to the next, at least.
const UPRIGHT_SPACING: f64 = 1.5 * TICK_SIZE;
const LEVEL_SPACING: f64 = 64.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave of three samples a period, thinned tenfold: drawn by its extremes it would beat.
    #[test]
    fn cells_of_both_signs_are_grey_and_do_not_beat() {
        use crate::plot::{Style, axis::PlotAxis};
        use ndarray::Array2;
        let at = |n: usize| (std::f32::consts::PI * 0.7 * n as f32).cos();
        let column = |of: fn(f32, f32) -> f32| {
            let cell = |(i, _)| (10 * i..10 * i + 10).map(at).reduce(of).unwrap_or_default();
            Array2::from_shape_fn((40, 1), cell)
        };
        let mut map = Map {
            values: column(|a, b| if a.abs() < b.abs() { b } else { a }),
            range: Some([column(f32::min), column(f32::max)]),
            reduction: Reduction::Extreme {
                rows: 10,
                columns: 1,
            },
            ..Map::default()
        };
        let rect = Rect {
            left: 0.0,
            top: 0.0,
            right: 100.0,
            bottom: 100.0,
        };
        let axis = |label| PlotAxis::linear(label, 0.0, 1.0);
        let panel = Panel::new(rect, axis("x"), axis("t"));
        let colors = |map: &Map, limit: f64| -> Vec<Color> {
            let scale = ColorScale::diverging([limit].into_iter());
            let mut scene = Scene::new("map", &Style::default(), 100.0);
            match holds_both_signs(map) {
                true => draw_signed(&mut scene, &panel, map, &scale),
                false => draw(&mut scene, &panel, map.values.view(), &scale),
            }
            let Some(Mark::Image(image)) = scene.marks.pop() else {
                panic!("an image")
            };
            let cells = image.cells.iter();
            cells
                .map(|&cell| image.palette[usize::from(cell)])
                .collect()
        };
        assert!(holds_both_signs(&map));
        let grey = colors(&map, 1.0);
        let is_dark = |[r, g, b]: &Color| r == g && g == b && *r < 80;
        assert!(grey.iter().all(is_dark), "{grey:?}");
        // Rounding beside a wave is no value: all of one colour, which is no grey.
        let faint = colors(&map, 1e3);
        assert!(
            faint
                .iter()
                .all(|color| *color == faint[0] && !is_dark(color))
        );
        // Cells of one sample each keep their colours.
        map.range = None;
        assert!(!holds_both_signs(&map));
        assert!(colors(&map, 1.0).iter().any(|[r, _, b]| r != b));
    }
}
