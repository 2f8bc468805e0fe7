//! What curves and symbols mean, in rows outside of the frames.

use super::axis::TICK_SIZE;
use super::font;
use super::scene::{Anchor, Color, INK, Point, Scene};
use crate::sheet::Marker;

/// From one row to the next.
pub(super) const ROW: f64 = 25.0;
const SAMPLE: f64 = 30.0;
const GAP: f64 = 28.0;

/// How a curve is drawn along its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stroke {
    Solid,
    Dashed,
    /// Dashes with a dark edge, as they are over maps.
    Edged,
    Nothing,
}

/// A name with what it names.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    pub label: String,
    pub color: Color,
    pub stroke: Stroke,
    pub width: f64,
    pub marker: Option<Marker>,
}

impl Entry {
    pub fn new(label: &str, color: Color, stroke: Stroke, width: f64) -> Entry {
        Entry {
            label: label.into(),
            color,
            stroke,
            width,
            marker: None,
        }
    }

    /// The label in lines that fit beside the sample.
    fn lines(&self, room: f64) -> Vec<String> {
        font::wrap(&self.label, TICK_SIZE, room - SAMPLE - 8.0)
    }

    fn width(&self, room: f64) -> f64 {
        let widths = self.lines(room).into_iter();
        let widths = widths.map(|line| font::width(&line, TICK_SIZE));
        SAMPLE + 8.0 + widths.fold(0.0, f64::max)
    }
}

/// Rows of entries that fit into `room`, with the lines that each has.
fn rows(entries: &[Entry], room: f64) -> Vec<(&[Entry], usize)> {
    let mut rows = Vec::new();
    let (mut start, mut filled) = (0, 0.0);
    for (index, entry) in entries.iter().enumerate() {
        let width = entry.width(room);
        if index > start && filled + width > room {
            rows.push(&entries[start..index]);
            (start, filled) = (index, 0.0);
        }
        filled += width + GAP;
    }
    if start < entries.len() {
        rows.push(&entries[start..]);
    }
    let most = |row: &[Entry]| row.iter().map(|entry| entry.lines(room).len()).max();
    rows.into_iter()
        .map(|row| (row, most(row).unwrap_or(1)))
        .collect()
}

/// Height of a legend of this width.
pub(super) fn height(entries: &[Entry], room: f64) -> f64 {
    let lines = rows(entries, room).into_iter().map(|(_, lines)| lines);
    ROW * lines.sum::<usize>() as f64
}

/// Draws entries in rows from `(left, top)` down.
pub(super) fn draw(scene: &mut Scene, (left, top): (f64, f64), room: f64, entries: &[Entry]) {
    let mut y = top + 0.5 * ROW;
    for (row, lines) in rows(entries, room) {
        let mut x = left;
        for entry in row {
            draw_entry(scene, entry, (x, y), room);
            x += entry.width(room) + GAP;
        }
        y += ROW * lines as f64;
    }
}

fn draw_entry(scene: &mut Scene, entry: &Entry, (x, y): (f64, f64), room: f64) {
    let ends = [(x, y), (x + SAMPLE, y)];
    match entry.stroke {
        Stroke::Solid => scene.line(&ends, entry.color, entry.width),
        Stroke::Dashed => scene.dashes(&ends, entry.color, entry.width),
        Stroke::Edged => {
            scene.dashes(&ends, INK, entry.width + 2.6);
            scene.dashes(&ends, entry.color, entry.width);
        }
        Stroke::Nothing => {}
    }
    if let Some(marker) = entry.marker {
        draw_marker(scene, marker, (x + 0.5 * SAMPLE, y), entry.color);
    }
    let at = (x + SAMPLE + 8.0, y);
    scene.lines(&entry.lines(room), at, TICK_SIZE, Anchor::Start);
}

/// A symbol at a point of the figure.
pub(super) fn draw_marker(scene: &mut Scene, marker: Marker, (x, y): Point, color: Color) {
    let at = |points: &[Point]| -> Vec<Point> {
        let points = points.iter();
        points.map(|p| (x + p.0, y + p.1)).collect()
    };
    match marker {
        Marker::Circle => scene.disk((x, y), 4.5, color),
        Marker::Square => {
            let corners = [(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)];
            scene.polygon(&at(&corners), color);
        }
        Marker::Triangle => scene.polygon(&at(&[(0.0, -5.5), (5.0, 4.0), (-5.0, 4.0)]), color),
        Marker::Cross => {
            scene.line(&at(&[(-4.5, -4.5), (4.5, 4.5)]), color, 2.2);
            scene.line(&at(&[(-4.5, 4.5), (4.5, -4.5)]), color, 2.2);
        }
    }
}
