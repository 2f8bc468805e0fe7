//! Heat maps and their colour bars.

use ndarray::ArrayView2;

use super::axis::{Edge, Side, TICK_SIZE};
use super::font;
use super::scale::{NO_VALUE, Scale};
use super::scene::{Anchor, Color, INK, Image, Rect, Scene};
use super::style::Colormap;
use crate::sheet::{Map, Reduction, block_extremes, blocks_of};

/// Most rows and columns of cells in a picture, so that an SVG of noise stays below 500 kB.
const MOST_CELLS: (usize, usize) = (400, 600);

/// `values` (row 0 at the bottom) over a whole frame.
pub(super) fn image<T>(at: Rect, values: ArrayView2<T>, scale: &Scale, colormap: Colormap) -> Image
where
    T: Copy + Into<f64>,
{
    let blocks = block_extremes(values, most_cells(&at));
    let (rows, columns) = blocks.dim();
    let from_top = blocks.rows().into_iter().rev();
    Image {
        at,
        columns,
        rows,
        palette: scale.palette(colormap),
        cells: from_top
            .flatten()
            .map(|value| scale.index(*value))
            .collect(),
    }
}

/// Least over largest magnitude of the two signs in a cell from which on neither stands for it: the
/// sign would alternate from cell to cell as the samples happen to fall, and draw waves that are not
/// there.
const BOTH_SIGNS: f64 = 0.5;

/// Share of the scale up to which a cell is drawn as zero, whatever its signs: grey would show rounding of nothing.
const NEAR_ZERO: f64 = 1.0 / 32.0;

/// Grey of cells that hold both signs: at the largest magnitude, and at none.
const GREYS: (f64, f64) = (64.0, 247.0);

/// Whether a map of signed values has cells of both signs that [`signed_image`] would show in grey.
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

/// A map of signed values over a whole frame, cells that hold both signs in grey.
pub(super) fn signed_image(at: Rect, map: &Map, scale: &Scale, colormap: Colormap) -> Image {
    let image = image(at, map.values.view(), scale, colormap);
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
    Image {
        palette,
        cells,
        ..image
    }
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

/// A colour scale with its quantity, right of a frame or below it.
pub(super) struct ColorBar<'a> {
    pub scale: Scale,
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
/// Below a level bar, for each colour that is none of its scale, and from its label to the first.
const GREY_LINE: f64 = 26.0;
const GREYS_FROM: f64 = 6.0;

impl ColorBar<'_> {
    fn edge(&self, side: Side, length: f64) -> Edge {
        Edge::of(
            &self.scale,
            self.scale.color_label(self.quantity),
            side,
            length,
        )
    }

    /// What the bar takes right of a frame of this height, or below one of this width.
    pub fn extent(&self, side: Side, length: f64) -> f64 {
        let beside = self.edge(side, length).extent();
        let explained = self.greys.explained();
        GAP + THICKNESS
            + match side.is_upright() {
                true => explained
                    .map(|(_, meaning)| 11.0 + font::width(meaning, TICK_SIZE))
                    .fold(beside, f64::max),
                false => explained.fold(beside, |below, _| below + GREY_LINE) + GREYS_FROM,
            }
    }

    /// Draws the bar `from` a frame's side on, as long as the frame.
    pub fn draw(&self, scene: &mut Scene, frame: Rect, side: Side, from: f64) {
        let from = from + GAP;
        let palette = self.scale.palette(scene.style.colormap);
        let levels = palette.len() - 1;
        let all = (0..levels).map(|level| level as u8);
        let (at, columns, rows, cells) = match side.is_upright() {
            true => {
                let left = frame.right + from;
                let right = left + THICKNESS;
                let at = Rect {
                    left,
                    right,
                    ..frame
                };
                (at, 1, levels, all.rev().collect())
            }
            false => {
                let top = frame.bottom + from;
                let bottom = top + THICKNESS;
                let at = Rect {
                    top,
                    bottom,
                    ..frame
                };
                (at, levels, 1, all.collect())
            }
        };
        scene.image(&Image {
            at,
            columns,
            rows,
            palette,
            cells,
        });
        scene.outline(at, INK);
        let edge = self.edge(side, side.length(&at));
        edge.draw(scene, &at, true);
        let below = match side.is_upright() {
            true => 18.0,
            false => edge.extent() + GREYS_FROM,
        };
        self.explain_greys(scene, (at.left, at.bottom + below));
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave of three samples a period, thinned tenfold: drawn by its extremes it would beat.
    #[test]
    fn cells_of_both_signs_are_grey_and_do_not_beat() {
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
        let colors = |map: &Map, limit: f64| -> Vec<Color> {
            let scale = Scale::linear(-limit, limit);
            let image = match holds_both_signs(map) {
                true => signed_image(rect, map, &scale, Colormap::default()),
                false => image(rect, map.values.view(), &scale, Colormap::default()),
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
