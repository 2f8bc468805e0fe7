//! Vertical lines through a frame, with their names above it, or inside where an axis is above.

use super::axis::TICK_SIZE;
use super::font;
use super::legend::ROW;
use super::panel::{self, Panel};
use super::scene::{Anchor, Color, Scene};
use crate::sheet::Mark;

/// Between two names in a row.
const GAP: f64 = 8.0;

/// What the names take above a frame.
pub(super) fn height(marks: &[Mark], panel: &Panel) -> f64 {
    if is_inside(panel) {
        return 0.0;
    }
    let named = marks.iter().zip(places(marks, panel));
    let named = named.filter(|(mark, _)| !mark.label.is_empty());
    let rows = named.map(|(_, placed)| placed.row + 1);
    rows.max().map_or(0.0, |rows| ROW * rows as f64 + 6.0)
}

fn is_inside(panel: &Panel) -> bool {
    panel.x.second.is_some()
}

/// Draws the lines and their names.
pub(super) fn draw(scene: &mut Scene, marks: &[Mark], panel: &Panel, color: Color) {
    for (mark, placed) in marks.iter().zip(places(marks, panel)) {
        let rect = panel.rect;
        if !(rect.left..=rect.right).contains(&placed.line) {
            continue;
        }
        let ends = [(placed.line, rect.bottom), (placed.line, rect.top)];
        scene.dashes(&ends, color, 1.2);
        let beyond = ROW * (placed.row as f64 + 0.5) + 2.0;
        let y = match is_inside(panel) {
            true => rect.top + beyond,
            false => rect.top - beyond,
        };
        if !mark.label.is_empty() {
            panel::note(scene, &mark.label, (placed.left, y), Anchor::Start);
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct PlacedName {
    line: f64,
    left: f64,
    row: usize,
}

fn places(marks: &[Mark], panel: &Panel) -> impl Iterator<Item = PlacedName> {
    let words: Vec<(f64, f64)> = marks
        .iter()
        .map(|mark| {
            let line = panel.place_x(mark.at).unwrap_or(f64::NEG_INFINITY);
            (line, font::width(&mark.label, TICK_SIZE))
        })
        .collect();
    rows(&words, panel.rect.left, panel.rect.right).into_iter()
}

/// Left end and row of each word, given its line and its width: over its line, shifted where it would
/// leave the frame, in the lowest row where it touches no word before it.
fn rows(words: &[(f64, f64)], start: f64, end: f64) -> Vec<PlacedName> {
    let mut placed: Vec<PlacedName> = Vec::new();
    for (i, &(line, width)) in words.iter().enumerate() {
        let left = (line - 0.5 * width).min(end - width).max(start);
        let touched = |row: usize| {
            let before = placed.iter().zip(&words[..i]);
            before
                .filter(|(p, _)| p.row == row)
                .any(|(p, (_, w))| left < p.left + w + GAP && p.left < left + width + GAP)
        };
        let row = (0..i).find(|row| !touched(*row)).unwrap_or(i);
        placed.push(PlacedName { line, left, row });
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stay_inside_and_touch_no_other() {
        // Far apart; crowded, where every other one is higher; at the end; and out of order.
        let words = [0.0, 100.0, 110.0, 133.0, 195.0, 60.0].map(|line| (line, 20.0));
        let placed = rows(&words, 0.0, 200.0);
        let found: Vec<(f64, usize)> = placed.iter().map(|p| (p.left, p.row)).collect();
        let expected = [
            (0.0, 0),
            (90.0, 0),
            (100.0, 1),
            (123.0, 0),
            (180.0, 0),
            (50.0, 0),
        ];
        assert_eq!(found, expected);
    }
}
