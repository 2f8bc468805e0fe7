//! Dispersion curves over `S(k, f)`: bright dashes with a dark edge, so that data stay visible.

use super::curve;
use super::legend::{Entry, Stroke};
use super::panel::Panel;
use super::scene::{Color, INK, Scene};
use crate::sheet::Curve;

const BRIGHT: [Color; 3] = [[0xff, 0x6f, 0x3c], [0xff, 0xff, 0xff], [0x56, 0xc8, 0xff]];
const WIDTH: f64 = 1.8;
const EDGE: f64 = 1.3;

/// Draws the curves where they lie inside the panel.
pub(super) fn draw(scene: &mut Scene, panel: &Panel, curves: &[Curve]) {
    for (line, color) in colored(curves) {
        for run in curve::paths(&line.points, panel) {
            scene.dashes(&run, INK, WIDTH + 2.0 * EDGE);
            scene.dashes(&run, color, WIDTH);
        }
    }
}

/// The curves' names, for the legend.
pub(super) fn entries(curves: &[Curve]) -> impl Iterator<Item = Entry> + '_ {
    let named = colored(curves).filter(|(curve, _)| !curve.label.is_empty());
    named.map(|(curve, color)| Entry::new(&curve.label, color, Stroke::Edged, WIDTH))
}

/// Curves with a name have the next colour, others that of the one before.
fn colored(curves: &[Curve]) -> impl Iterator<Item = (&Curve, Color)> {
    let mut names = 0;
    curves.iter().map(move |curve| {
        names += usize::from(!curve.label.is_empty());
        (curve, BRIGHT[(names.max(1) - 1) % BRIGHT.len()])
    })
}
