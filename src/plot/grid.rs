//! A row of maps, some of them on a common colour scale.

use super::Figure;
use super::axis::PlotAxis;
use super::budget::ordinary;
use super::figures::values;
use super::font;
use super::heat;
use super::panel::{self, Panel};
use super::scale::ColorScale;
use super::scene::{Anchor, Color, INK, Rect, Scene};
use crate::analyze::Map;

/// Width and height of a tile.
const TILE: (f64, f64) = (625.0, 445.0);
/// From the left, top, right and bottom of a tile to its map.
const MARGINS: [f64; 4] = [95.0, 50.0, 210.0, 75.0];
/// Above all tiles.
const HEAD: f64 = 60.0;
/// Below all tiles, for a line of the note.
const LINE: f64 = 26.0;
const WHITE: Color = [255; 3];

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
    /// An inset: a part of the map with its own scale, in the upper right corner.
    pub inset: Option<&'a Map>,
}

/// The tiles in rows of `columns`, under a heading and over a note of lines.
pub fn map_grid(
    name: &'static str,
    heading: &str,
    note: &[&str],
    columns: usize,
    tiles: &[Tile],
) -> Figure {
    let columns = columns.max(1);
    let rows = tiles.len().div_ceil(columns);
    let width = TILE.0 * columns as f64;
    let foot = HEAD + TILE.1 * rows as f64;
    let height = foot + LINE * (note.len() as f64 + 0.5);
    let mut scene = Scene::new(heading, width as u32, height as u32);
    panel::heading(&mut scene, heading, "");
    for (index, tile) in tiles.iter().enumerate() {
        let at = (
            TILE.0 * (index % columns) as f64,
            HEAD + TILE.1 * (index / columns) as f64,
        );
        draw(&mut scene, tile, at);
    }
    for (index, line) in note.iter().enumerate() {
        let at = (30.0, foot + LINE * (index as f64 + 0.4));
        let size = font::fit(line, panel::TICK_SIZE, width - 60.0);
        scene.text(*line, at, size, Anchor::Start);
    }
    Figure { name, scene }
}

fn draw(scene: &mut Scene, tile: &Tile, (x, y): (f64, f64)) {
    let [left, top, right, bottom] = MARGINS;
    let rect = Rect {
        left: x + left,
        top: y + top,
        right: x + TILE.0 - right,
        bottom: y + TILE.1 - bottom,
    };
    let Colours(scale) = &tile.colours;
    let panel = over(rect, tile.map);
    heat::draw(scene, &panel, tile.map.values.view(), scale);
    line(scene, &panel, tile.line);
    panel.draw_axes(scene);
    if let Some(map) = tile.inset {
        inset(scene, rect, map, scale);
    }
    let bar = Rect {
        left: rect.right + 26.0,
        right: rect.right + 46.0,
        ..rect
    };
    let missing = tile.map.values.iter().any(|value| !value.is_finite());
    heat::colour_bar(scene, bar, scale, &tile.map.label, missing);
    let size = font::fit(&tile.title, panel::LABEL_SIZE, TILE.0 - left - 20.0);
    scene.text(
        &tile.title,
        (rect.left, rect.top - 22.0),
        size,
        Anchor::Start,
    );
}

fn over(rect: Rect, map: &Map) -> Panel {
    let axis = |axis: &crate::analyze::MapAxis| PlotAxis::linear(&axis.label, axis.low, axis.high);
    Panel::new(rect, axis(&map.x), axis(&map.y))
}

/// White on a dark background, visible on every colour.
fn line(scene: &mut Scene, panel: &Panel, points: &[(f64, f64)]) {
    let rect = panel.rect;
    let inside = |(x, y): (f64, f64)| {
        let place = (panel.place_x(x)?, panel.place_y(y)?);
        let within = (rect.left..=rect.right).contains(&place.0)
            && (rect.top..=rect.bottom).contains(&place.1);
        within.then_some(place)
    };
    let placed: Vec<(f64, f64)> = points.iter().filter_map(|point| inside(*point)).collect();
    if placed.len() > 1 {
        scene.line(placed.clone(), INK, 4.5);
        scene.line(placed, WHITE, 2.0);
    }
}

fn inset(scene: &mut Scene, rect: Rect, map: &Map, scale: &ColorScale) {
    let inner = Rect {
        left: rect.left + 0.44 * rect.width(),
        top: rect.top + 10.0,
        right: rect.right - 14.0,
        bottom: rect.top + 0.42 * rect.height(),
    };
    let ground = Rect {
        left: inner.left - 44.0,
        top: rect.top,
        right: rect.right,
        bottom: inner.bottom + 32.0,
    };
    scene.fill(ground, WHITE);
    scene.outline(ground, INK);
    let panel = over(inner, map);
    heat::draw(scene, &panel, map.values.view(), scale);
    panel.draw_axes(scene);
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
            inset: Some(&all),
        };
        for count in [0, 1, 3] {
            let figure = map_grid("grid", "maps", &["a note"], 2, &vec![tile.clone(); count]);
            assert!(figure.encode(Format::Png).unwrap().starts_with(b"\x89PNG"));
        }
    }
}
