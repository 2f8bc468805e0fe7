//! Dispersion curves over `S(k, f)`: bright dashes with a dark edge, so that data stay visible.

use super::legend::Entry;
use super::panel::Panel;
use super::scene::{Color, INK, Scene};
use crate::analyze::DispersionCurve;

const BRIGHT: [Color; 3] = [[0xff, 0x6f, 0x3c], [0xff, 0xff, 0xff], [0x56, 0xc8, 0xff]];
const WIDTH: f64 = 1.8;
const EDGE: f64 = 1.3;

/// Draws the curves where they lie inside the panel.
pub(super) fn draw(scene: &mut Scene, panel: &Panel, curves: &[DispersionCurve]) {
    for (curve, color) in curves.iter().zip(BRIGHT.into_iter().cycle()) {
        for branch in &curve.branches {
            for run in inside(panel, &curve.wavenumber, branch) {
                scene.dashed_path(&run, INK, WIDTH + 2.0 * EDGE);
                scene.dashed_path(&run, color, WIDTH);
            }
        }
    }
}

/// The curves' names, for the legend.
pub(super) fn entries(curves: &[DispersionCurve]) -> impl Iterator<Item = Entry> + '_ {
    let colors = BRIGHT.into_iter().cycle();
    let named = curves.iter().zip(colors);
    named.map(|(curve, color)| Entry::edged(&curve.name, color))
}

/// The unbroken parts of a branch inside the panel.
fn inside(panel: &Panel, wavenumber: &[f64], branch: &[f64]) -> Vec<Vec<(f64, f64)>> {
    let rect = panel.rect;
    let mut runs = vec![Vec::new()];
    for (&k, &f) in wavenumber.iter().zip(branch) {
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
