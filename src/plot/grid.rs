//! A row of maps, some of them on a common colour scale.

use super::Figure;
use super::axis::PlotAxis;
use super::budget::ordinary;
use super::dispersion;
use super::figures::{WHITE, values};
use super::font;
use super::heat::{self, BarSide, ColorBar, Greys};
use super::panel::{self, Margins, Panel};
use super::scale::ColorScale;
use super::scene::{Anchor, INK, Rect, Scene};
use super::style::Style;
use crate::analyze::Map;

/// Height of a tile over its width, and the least width.
const ASPECT: f64 = 0.71;
const NARROWEST: f64 = 450.0;
/// Above a frame, for the title of a tile.
const TITLE: f64 = 34.0;
/// Below all tiles, for a line of the note.
const LINE: f64 = 26.0;

/// A colour scale for maps that compare.
#[derive(Debug, Clone, Copy)]
pub struct Colours(ColorScale);

impl Colours {
    /// Logarithmic over this many decades; one nonzero cell in two hundred is above.
    pub fn log(maps: &[&Map], decades: f64) -> Colours {
        let high = match ordinary(maps.iter().copied().flat_map(values)) {
            0.0 => 1.0,
            high => high,
        };
        Colours(ColorScale::Log {
            low: high * 10f64.powf(-decades),
            high,
            smaller: true,
            decibels: false,
        })
    }

    /// Linear about zero; one cell in two hundred of those that are not 0 is beyond its ends.
    pub fn diverging(maps: &[&Map]) -> Colours {
        let limit = ordinary(maps.iter().copied().flat_map(values));
        Colours(ColorScale::diverging(std::iter::once(limit)))
    }

    /// Symmetric about 0, logarithmic in both directions over this many decades below the largest
    /// magnitude.
    pub fn signed(maps: &[&Map], decades: f64) -> Colours {
        let all = maps.iter().copied().flat_map(values);
        Colours(ColorScale::signed(all, decades))
    }
}

/// A map of a grid.
#[derive(Debug, Clone)]
pub struct Tile<'a> {
    pub title: String,
    pub map: &'a Map,
    pub colours: Colours,
    /// Points of a line over the map; may be empty.
    pub line: &'a [(f64, f64)],
}

/// The tiles in rows of `columns`, under a heading and over a note.
pub fn map_grid(
    name: &'static str,
    heading: &str,
    note: &str,
    (columns, tiles): (usize, &[Tile]),
    style: &Style,
) -> Figure {
    let mut scene = Scene::new(heading, style, 0.0);
    let columns = columns.clamp(1, ((scene.width / NARROWEST) as usize).max(1));
    let rows = tiles.len().div_ceil(columns);
    let head = panel::heading(&mut scene, heading, "");
    let wide = scene.width / columns as f64;
    let note = match note {
        "" => Vec::new(),
        note => font::wrap(note, panel::TICK_SIZE, scene.width - 60.0),
    };
    let foot = LINE * (note.len() as f64 + 0.5);
    let all = ASPECT * wide * rows as f64;
    scene.height = style.rows(head + all + foot, head + 280.0 * rows as f64 + foot);
    let tall = (scene.height - head - foot) / rows.max(1) as f64;
    let cell = |index: usize| {
        let left = wide * (index % columns) as f64;
        let top = head + tall * (index / columns) as f64;
        Rect {
            left,
            top,
            right: left + wide,
            bottom: top + tall,
        }
    };
    let margins = tiles
        .iter()
        .map(|tile| margins(tile, (wide, tall)))
        .fold(Margins::default(), Margins::max);
    for (index, tile) in tiles.iter().enumerate() {
        draw(&mut scene, tile, margins.inside(cell(index)));
    }
    let at = (30.0, scene.height - foot + 0.5 * LINE);
    scene.lines(&note, at, panel::TICK_SIZE, Anchor::Start);
    Figure { name, scene }
}

/// What is beside the map of a tile of this size.
fn margins(tile: &Tile, (wide, tall): (f64, f64)) -> Margins {
    let rect = Rect {
        left: 0.0,
        top: 0.0,
        right: 0.6 * wide,
        bottom: 0.7 * tall,
    };
    let axes = over(rect, tile.map).margins();
    let Colours(scale) = &tile.colours;
    let bar = bar(tile, scale).extent(BarSide::Right, rect.height());
    Margins {
        left: axes.left + 10.0,
        top: TITLE,
        right: bar + 10.0,
        bottom: axes.bottom + 14.0,
    }
}

fn bar<'a>(tile: &'a Tile, scale: &'a ColorScale) -> ColorBar<'a> {
    ColorBar {
        scale,
        quantity: &tile.map.label,
        greys: Greys {
            missing: tile.map.values.iter().any(|value| !value.is_finite()),
            ..Greys::default()
        },
    }
}

fn draw(scene: &mut Scene, tile: &Tile, rect: Rect) {
    let Colours(scale) = &tile.colours;
    let panel = over(rect, tile.map);
    heat::draw(scene, &panel, tile.map.values.view(), scale);
    line(scene, &panel, tile.line);
    panel.draw_axes(scene);
    bar(tile, scale).draw(scene, rect, BarSide::Right, 0.0);
    let title = font::shorten(&tile.title, panel::LABEL_SIZE, rect.width() + 120.0);
    let at = (rect.left, rect.top - 0.5 * TITLE);
    scene.text(title, at, panel::LABEL_SIZE, Anchor::Start);
}

fn over(rect: Rect, map: &Map) -> Panel {
    let axis = |axis: &crate::analyze::MapAxis| PlotAxis::linear(&axis.label, axis.low, axis.high);
    Panel::new(rect, axis(&map.x), axis(&map.y))
}

/// White on a dark background, visible on every colour.
fn line(scene: &mut Scene, panel: &Panel, points: &[(f64, f64)]) {
    for run in dispersion::inside(panel, points) {
        scene.line(run.clone(), INK, 4.5);
        scene.line(run, WHITE, 2.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyze::{MapAxis, Reduction};
    use crate::plot::Format;

    fn map(values: ndarray::Array2<f32>) -> Map {
        let axis = || MapAxis {
            label: "site".into(),
            low: 0.0,
            high: 2.0,
        };
        Map {
            values,
            x: axis(),
            y: axis(),
            reduction: Reduction::Max {
                rows: 1,
                columns: 1,
            },
            range: None,
            label: "value".into(),
            detail: None,
        }
    }

    #[test]
    fn a_shared_scale_spans_the_decades_asked_for() {
        let (small, large) = (
            map(ndarray::array![[1e-9, 1.0]]),
            map(ndarray::array![[0.0, 100.0]]),
        );
        let Colours(scale) = Colours::log(&[&small, &large], 4.0);
        assert_eq!(scale.share(100.0), Some(1.0));
        assert!((scale.share(1.0).unwrap() - 0.5).abs() < 1e-6);
        assert_eq!(scale.share(1e-9), Some(0.0));
    }

    #[test]
    fn grids_of_any_size_are_drawn() {
        let all = map(ndarray::array![[1.0, -2.0], [f32::NAN, 0.0]]);
        let tile = Tile {
            title: "a map".into(),
            map: &all,
            colours: Colours::diverging(&[&all]),
            line: &[(0.0, 0.5), (1.0, f64::NAN), (2.0, 1.5)],
        };
        for count in [0, 1, 3] {
            let figure = map_grid(
                "grid",
                "maps",
                "a note",
                (2, &vec![tile.clone(); count]),
                &Style::default(),
            );
            assert!(figure.encode(Format::Png).unwrap().starts_with(b"\x89PNG"));
        }
    }
}
