//! Dispersion curves over `S(k, f)`: bright dashes with a dark edge, so that data stay visible.

use super::legend::Entry;
use super::panel::Panel;
use super::scene::{Color, INK, Scene};
use crate::sheet::Curve;

const BRIGHT: [Color; 3] = [[0xff, 0x6f, 0x3c], [0xff, 0xff, 0xff], [0x56, 0xc8, 0xff]];
const WIDTH: f64 = 1.8;
const EDGE: f64 = 1.3;

/// Draws the curves where they lie inside the panel.
pub(super) fn draw(scene: &mut Scene, panel: &Panel, curves: &[Curve]) {
    for (curve, color) in colored(curves) {
        for run in inside(panel, &curve.points) {
            scene.dashed_path(&run, INK, WIDTH + 2.0 * EDGE);
            scene.dashed_path(&run, color, WIDTH);
        }
    }
}

/// The curves' names, for the legend.
pub(super) fn entries(curves: &[Curve]) -> impl Iterator<Item = Entry> + '_ {
    let named = colored(curves).filter(|(curve, _)| !curve.label.is_empty());
    named.map(|(curve, color)| Entry::edged(&curve.label, color))
}

/// Curves with a name have the next colour, others that of the one before.
fn colored(curves: &[Curve]) -> impl Iterator<Item = (&Curve, Color)> {
    let mut names = 0;
    curves.iter().map(move |curve| {
        names += usize::from(!curve.label.is_empty());
        (curve, BRIGHT[(names.max(1) - 1) % BRIGHT.len()])
    })
}

/// The unbroken parts of a curve inside the panel.
pub(super) fn inside(panel: &Panel, points: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
    let rect = panel.rect;
    let mut runs = vec![Vec::new()];
    for &(k, f) in points {
        let at = panel.place_x(k).zip(panel.place_y(f)).filter(|&(x, y)| {
            (rect.left..=rect.right).contains(&x) && (rect.top..=rect.bottom).contains(&y)
        });
        match (at, runs.last_mut()) {
            (Some(at), Some(run)) => run.push(at),
            (None, Some(run)) if !run.is_empty() => runs.push(Vec::new()),
            _ => {}
        }
    }
    runs.retain(|run| run.len() > 1);
    runs
}
