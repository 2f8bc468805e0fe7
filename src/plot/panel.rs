//! A framed area with its axes: the ground that maps and curves are drawn on.

use super::axis::PlotAxis;
use super::font;
use super::scene::{Anchor, FAINT, GRID, INK, Mark, Rect, Scene, Text};
use super::ticks::Tick;

pub(super) const LABEL_SIZE: f64 = 20.0;
pub(super) const TICK_SIZE: f64 = 17.0;
const TICK_LENGTH: f64 = 7.0;

/// Where values land in the figure.
#[derive(Debug, Clone)]
pub(super) struct Panel {
    pub rect: Rect,
    pub x: PlotAxis,
    pub y: PlotAxis,
    /// Whether the horizontal axis carries tick labels and its label.
    pub names_x: bool,
    /// Whether the vertical axis carries tick labels and its label.
    pub names_y: bool,
}

impl Panel {
    pub fn new(rect: Rect, x: PlotAxis, y: PlotAxis) -> Self {
        Panel {
            rect,
            x,
            y,
            names_x: true,
            names_y: true,
        }
    }

    pub fn place_x(&self, value: f64) -> Option<f64> {
        let share = self.x.share(value)?;
        Some(self.rect.left + share * self.rect.width())
    }

    pub fn place_y(&self, value: f64) -> Option<f64> {
        let share = self.y.share(value)?;
        Some(self.rect.bottom - share * self.rect.height())
    }

    fn ticks_x(&self) -> Vec<(f64, Tick)> {
        let mut count = (self.rect.width() / 90.0).max(2.0) as usize;
        loop {
            let ticks = place(self.x.ticks(count), |v| self.place_x(v));
            let widest = widest(&ticks);
            let crowded = ticks
                .windows(2)
                .any(|pair| pair[1].0 - pair[0].0 < widest + 0.6 * TICK_SIZE);
            if !crowded || count <= 1 {
                return ticks;
            }
            count -= 1;
        }
    }

    fn ticks_y(&self, axis: &PlotAxis) -> Vec<(f64, Tick)> {
        let spacing = if axis.log { 40.0 } else { 55.0 };
        let count = (self.rect.height() / spacing).max(2.0) as usize;
        let to_pixel = |v| {
            let share = axis.share(v)?;
            Some(self.rect.bottom - share * self.rect.height())
        };
        place(axis.ticks(count), to_pixel)
    }

    /// Light lines at the ticks, to be drawn under curves.
    pub fn draw_grid(&self, scene: &mut Scene) {
        for (x, _) in self.ticks_x() {
            scene.line(vec![(x, self.rect.top), (x, self.rect.bottom)], GRID, 1.0);
        }
        for (y, _) in self.ticks_y(&self.y) {
            scene.line(vec![(self.rect.left, y), (self.rect.right, y)], GRID, 1.0);
        }
    }

    /// Frame, ticks and labels.
    pub fn draw_axes(&self, scene: &mut Scene) {
        scene.outline(self.rect, INK);
        self.draw_bottom(scene);
        self.draw_left(scene);
        if let Some(second) = self.x.second_axis() {
            let top = Panel::new(self.rect, second, self.y.clone());
            top.draw_top(scene);
        }
        if let Some(second) = self.y.second_axis() {
            self.draw_right(scene, &second);
        }
    }

    fn draw_bottom(&self, scene: &mut Scene) {
        let bottom = self.rect.bottom;
        for (x, tick) in self.ticks_x() {
            scene.line(vec![(x, bottom), (x, bottom + TICK_LENGTH)], INK, 1.0);
            if self.names_x {
                scene.text(tick.text, (x, bottom + 20.0), TICK_SIZE, Anchor::Middle);
            }
        }
        if self.names_x {
            self.label_across(scene, &self.x.title(), bottom + 48.0);
        }
    }

    fn draw_top(&self, scene: &mut Scene) {
        let top = self.rect.top;
        for (x, tick) in self.ticks_x() {
            scene.line(vec![(x, top), (x, top - TICK_LENGTH)], INK, 1.0);
            scene.text(tick.text, (x, top - 19.0), TICK_SIZE, Anchor::Middle);
        }
        self.label_across(scene, &self.x.title(), top - 45.0);
    }

    fn label_across(&self, scene: &mut Scene, label: &str, y: f64) {
        let middle = (self.rect.left + self.rect.right) / 2.0;
        let size = font::fit(label, LABEL_SIZE, self.rect.width() + 60.0);
        scene.text(label, (middle, y), size, Anchor::Middle);
    }

    fn draw_left(&self, scene: &mut Scene) {
        let left = self.rect.left;
        let ticks = self.ticks_y(&self.y);
        let label_at = left - 34.0 - widest(&ticks);
        for (y, tick) in ticks {
            scene.line(vec![(left, y), (left - TICK_LENGTH, y)], INK, 1.0);
            if self.names_y {
                scene.text(tick.text, (left - 13.0, y), TICK_SIZE, Anchor::End);
            }
        }
        if self.names_y {
            self.label_along(scene, &self.y.title(), label_at, LabelSide::Left);
        }
    }

    fn draw_right(&self, scene: &mut Scene, axis: &PlotAxis) {
        let right = self.rect.right;
        let ticks = self.ticks_y(axis);
        let label_at = right + 34.0 + widest(&ticks);
        for (y, tick) in ticks {
            scene.line(vec![(right, y), (right + TICK_LENGTH, y)], INK, 1.0);
            scene.text(tick.text, (right + 13.0, y), TICK_SIZE, Anchor::Start);
        }
        self.label_along(scene, &axis.title(), label_at, LabelSide::Right);
    }

    fn label_along(&self, scene: &mut Scene, label: &str, x: f64, side: LabelSide) {
        let middle = (self.rect.top + self.rect.bottom) / 2.0;
        label_upright(scene, label, (x, middle), self.rect.height() + 20.0, side);
    }
}

/// Position of a label relative to its subject.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LabelSide {
    Left,
    Right,
}

/// A label that reads upwards, centred on `at`. If it is longer than `room`, it has two lines, the
/// name and the part in brackets, the second further out than `at`.
pub(super) fn label_upright(
    scene: &mut Scene,
    label: &str,
    (x, middle): (f64, f64),
    room: f64,
    side: LabelSide,
) {
    let fits = font::width(label, LABEL_SIZE) <= room;
    let lines = match label.find(" (").filter(|_| !fits) {
        Some(at) => vec![label[..at].trim_end(), &label[at + 1..]],
        None => vec![label],
    };
    let size = lines
        .iter()
        .map(|line| font::fit(line, LABEL_SIZE, room))
        .fold(LABEL_SIZE, f64::min);
    let spacing = 1.2 * LABEL_SIZE;
    let first = match side {
        LabelSide::Left => (x - spacing * (lines.len() - 1) as f64).max(0.6 * LABEL_SIZE),
        LabelSide::Right => x,
    };
    for (index, line) in lines.into_iter().enumerate() {
        scene.marks.push(Mark::Text(Text {
            text: line.into(),
            at: (first + spacing * index as f64, middle),
            size,
            color: INK,
            anchor: Anchor::Middle,
            vertical: true,
        }));
    }
}

/// Text on a picture, with a white background.
pub(super) fn note(scene: &mut Scene, text: &str, (x, y): (f64, f64), anchor: Anchor) {
    let width = font::width(text, TICK_SIZE);
    let left = match anchor {
        Anchor::Start => x,
        Anchor::Middle => x - width / 2.0,
        Anchor::End => x - width,
    };
    let ground = Rect {
        left: left - 6.0,
        top: y - 12.0,
        right: left + width + 6.0,
        bottom: y + 12.0,
    };
    scene.fill(ground, [255; 3]);
    scene.text(text, (x, y), TICK_SIZE, anchor);
}

/// The figure's title and, at the right, the name of its data.
pub(super) fn heading(scene: &mut Scene, title: &str, name: &str) {
    let width = f64::from(scene.width);
    let size = 25.0;
    let room = width - 90.0 - font::width(title, size);
    scene.text(title, (30.0, 32.0), size, Anchor::Start);
    if room > 60.0 {
        scene.marks.push(Mark::Text(Text {
            text: font::shorten(name, TICK_SIZE, room),
            at: (width - 30.0, 32.0),
            size: TICK_SIZE,
            color: FAINT,
            anchor: Anchor::End,
            vertical: false,
        }));
    }
}

fn place(ticks: Vec<Tick>, to_pixel: impl Fn(f64) -> Option<f64>) -> Vec<(f64, Tick)> {
    ticks
        .into_iter()
        .filter_map(|tick| Some((to_pixel(tick.value)?, tick)))
        .collect()
}

fn widest(ticks: &[(f64, Tick)]) -> f64 {
    ticks
        .iter()
        .map(|(_, tick)| font::width(&tick.text, TICK_SIZE))
        .fold(0.0, f64::max)
}
