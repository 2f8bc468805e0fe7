//! Curves, their legend, and level lines.

use super::font;
use super::panel::{Panel, TICK_SIZE};
use super::scene::{Anchor, Color, FAINT, Rect, Scene};

// Okabe and Ito's colours, told apart by colour-blind readers.
pub(super) const BLUE: Color = [0x00, 0x72, 0xb2];
pub(super) const VERMILLION: Color = [0xd5, 0x5e, 0x00];
pub(super) const GREEN: Color = [0x00, 0x9e, 0x73];
pub(super) const PURPLE: Color = [0xcc, 0x79, 0xa7];

const WIDTH: f64 = 2.4;

/// A named curve; gaps are where either coordinate cannot be placed.
pub(super) struct Curve<'a> {
    pub label: &'a str,
    pub color: Color,
    pub x: &'a [f64],
    pub y: &'a [f64],
}

impl Curve<'_> {
    pub fn draw(&self, scene: &mut Scene, panel: &Panel) {
        let mut run = Vec::new();
        for (&x, &y) in self.x.iter().zip(self.y) {
            match (panel.place_x(x), panel.place_y(y)) {
                (Some(x), Some(y)) => run.push((x, y)),
                _ => self.draw_run(scene, std::mem::take(&mut run)),
            }
        }
        self.draw_run(scene, run);
    }

    fn draw_run(&self, scene: &mut Scene, run: Vec<(f64, f64)>) {
        match run[..] {
            [] => {}
            [(x, y)] => scene.fill(
                Rect {
                    left: x - 3.0,
                    top: y - 3.0,
                    right: x + 3.0,
                    bottom: y + 3.0,
                },
                self.color,
            ),
            _ => scene.line(thin(run), self.color, WIDTH),
        }
    }
}

/// Keeps, of the points that share a pixel column (or, for curves along the vertical, a pixel
/// row), the first, the two extremes and the last: the drawn curve stays the same.
fn thin(run: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    if run.len() < 2000 {
        return run;
    }
    let extent = |part: fn(&(f64, f64)) -> f64| {
        let (first, last) = (part(&run[0]), part(&run[run.len() - 1]));
        (last - first).abs()
    };
    let upright = extent(|p| p.1) > extent(|p| p.0);
    let main = |p: &(f64, f64)| if upright { p.1 } else { p.0 };
    let cross = |p: &(f64, f64)| if upright { p.0 } else { p.1 };
    let mut kept = Vec::new();
    for group in run.chunk_by(|a, b| main(a).floor() == main(b).floor()) {
        let least = (0..group.len()).min_by(|&a, &b| cross(&group[a]).total_cmp(&cross(&group[b])));
        let most = (0..group.len()).max_by(|&a, &b| cross(&group[a]).total_cmp(&cross(&group[b])));
        let mut indices: Vec<usize> = [Some(0), least, most, Some(group.len() - 1)]
            .into_iter()
            .flatten()
            .collect();
        indices.sort_unstable();
        indices.dedup();
        kept.extend(indices.into_iter().map(|index| group[index]));
    }
    kept
}

/// Draws all curves over a grid, axes last, and their legend above the panel.
pub(super) fn draw_all(scene: &mut Scene, panel: &Panel, curves: &[Curve]) {
    panel.draw_grid(scene);
    for curve in curves {
        curve.draw(scene, panel);
    }
    panel.draw_axes(scene);
    let entries: Vec<(&str, Color)> = curves.iter().map(|c| (c.label, c.color)).collect();
    legend(scene, (panel.rect.left, panel.rect.top - 18.0), &entries);
}

/// Samples of line with their names, from `at` to the right.
pub(super) fn legend(scene: &mut Scene, at: (f64, f64), entries: &[(&str, Color)]) {
    let (mut x, y) = at;
    for &(label, color) in entries {
        scene.line(vec![(x, y), (x + 30.0, y)], color, 3.0);
        scene.text(label, (x + 38.0, y), TICK_SIZE, Anchor::Start);
        x += 38.0 + font::width(label, TICK_SIZE) + 28.0;
    }
}

/// A dashed horizontal line at `value`, if it lies on the axis.
pub(super) fn level(scene: &mut Scene, panel: &Panel, value: f64, color: Color) {
    if let Some(y) = panel.place_y(value).filter(|y| inside(*y, panel)) {
        scene.dashes((panel.rect.left, y), (panel.rect.right, y), color, 1.6);
    }
}

fn inside(y: f64, panel: &Panel) -> bool {
    y >= panel.rect.top && y <= panel.rect.bottom
}

/// Colour of level lines among curves.
pub(super) const LEVEL: Color = FAINT;
