//! A framed area with its axes: the ground that maps and curves are drawn on.

use super::axis::PlotAxis;
use super::font;
use super::scene::{Anchor, FAINT, GRID, INK, Mark, Rect, Scene, Text};
use super::style;
use super::ticks::Tick;

pub(super) const LABEL_SIZE: f64 = style::LABEL;
pub(super) const TICK_SIZE: f64 = style::SMALL;
const TICK_LENGTH: f64 = 7.0;
/// From one line of a label to the next.
pub(super) const LINE: f64 = 1.25 * LABEL_SIZE;
/// Around all that is drawn.
pub(super) const EDGE: f64 = 12.0;

/// What ticks and labels take beside a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Margins {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Margins {
    /// The larger at each side.
    pub fn max(self, other: Margins) -> Margins {
        Margins {
            left: self.left.max(other.left),
            top: self.top.max(other.top),
            right: self.right.max(other.right),
            bottom: self.bottom.max(other.bottom),
        }
    }
}

/// Where values land in the figure.
#[derive(Debug, Clone)]
pub(super) struct Panel {
    pub rect: Rect,
    pub x: PlotAxis,
    pub y: PlotAxis,
    /// Whether the horizontal axis carries tick labels and its label.
    pub names_x: bool,
}

impl Panel {
    pub fn new(rect: Rect, x: PlotAxis, y: PlotAxis) -> Self {
        Panel {
            rect,
            x,
            y,
            names_x: true,
        }
    }

    /// What the ticks and labels take beside a frame of this size.
    pub fn margins(&self) -> Margins {
        let lines = |axis: &PlotAxis| upright_lines(&axis.title(), self.rect.height()).len() as f64;
        let across = |axis: &PlotAxis| across_lines(&axis.title(), self.rect.width()).len() as f64;
        let beside = |axis: &PlotAxis| {
            let ticks = widest(&self.ticks_y(axis));
            34.0 + ticks + LINE * (lines(axis) - 1.0) + 0.5 * LABEL_SIZE
        };
        let half_tick = 0.5 * widest(&self.ticks_x(&self.x));
        Margins {
            left: beside(&self.y),
            top: match self.x.second_axis() {
                Some(second) => 53.0 + LINE * (across(&second) - 1.0) + 0.5 * LABEL_SIZE,
                None => 0.5 * TICK_SIZE,
            },
            right: match self.y.second_axis() {
                Some(second) => beside(&second),
                None => half_tick,
            },
            bottom: match self.names_x {
                true => 46.0 + LINE * (across(&self.x) - 1.0) + 0.5 * LABEL_SIZE,
                false => TICK_LENGTH,
            },
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

    fn ticks_x(&self, axis: &PlotAxis) -> Vec<(f64, Tick)> {
        let to_pixel = |v| {
            let share = axis.share(v)?;
            Some(self.rect.left + share * self.rect.width())
        };
        let mut count = (self.rect.width() / 75.0).max(2.0) as usize;
        loop {
            let ticks = place(axis.ticks(count), to_pixel);
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
        for (x, _) in self.ticks_x(&self.x) {
            scene.line(vec![(x, self.rect.top), (x, self.rect.bottom)], GRID, 1.0);
        }
        for (y, _) in self.ticks_y(&self.y) {
            scene.line(vec![(self.rect.left, y), (self.rect.right, y)], GRID, 1.0);
        }
    }

    /// Frame, ticks and labels.
    pub fn draw_axes(&self, scene: &mut Scene) {
        scene.outline(self.rect, INK);
        self.draw_across(scene, &self.x, self.names_x, None);
        self.draw_beside(scene, &self.y, LabelSide::Left);
        if let Some(second) = self.x.second_axis() {
            let lines = across_lines(&second.title(), self.rect.width()).len() as f64;
            self.draw_across(scene, &second, true, Some(lines));
        }
        if let Some(second) = self.y.second_axis() {
            self.draw_beside(scene, &second, LabelSide::Right);
        }
    }

    /// An axis below the frame, or above it with a label of so many lines.
    fn draw_across(&self, scene: &mut Scene, axis: &PlotAxis, names: bool, above: Option<f64>) {
        let (edge, out, label_at) = match above {
            Some(lines) => (self.rect.top, -1.0, 45.0 + LINE * (lines - 1.0)),
            None => (self.rect.bottom, 1.0, 46.0),
        };
        for (x, tick) in self.ticks_x(axis) {
            scene.line(vec![(x, edge), (x, edge + out * TICK_LENGTH)], INK, 1.0);
            if names {
                let at = (x, edge + out * 20.0);
                scene.text(tick.text, at, TICK_SIZE, Anchor::Middle);
            }
        }
        if names {
            let lines = across_lines(&axis.title(), self.rect.width());
            let at = (self.rect.middle().0, edge + out * label_at);
            scene.lines(&lines, at, LABEL_SIZE, Anchor::Middle);
        }
    }

    fn draw_beside(&self, scene: &mut Scene, axis: &PlotAxis, side: LabelSide) {
        let (edge, out, anchor) = match side {
            LabelSide::Left => (self.rect.left, -1.0, Anchor::End),
            LabelSide::Right => (self.rect.right, 1.0, Anchor::Start),
        };
        let ticks = self.ticks_y(axis);
        let label_at = (edge + out * (34.0 + widest(&ticks)), self.rect.middle().1);
        for (y, tick) in ticks {
            scene.line(vec![(edge, y), (edge + out * TICK_LENGTH, y)], INK, 1.0);
            scene.text(tick.text, (edge + out * 13.0, y), TICK_SIZE, anchor);
        }
        label_upright(scene, &axis.title(), label_at, self.rect.height(), side);
    }
}

/// A label above or below a frame of this width, in lines.
fn across_lines(label: &str, width: f64) -> Vec<String> {
    font::wrap(label, LABEL_SIZE, width + 2.0 * EDGE)
}

/// A label beside a frame of this height, in lines; the unit stays together where it can.
pub(super) fn upright_lines(label: &str, height: f64) -> Vec<String> {
    let room = height + 20.0;
    if font::width(label, LABEL_SIZE) <= room {
        return vec![label.to_owned()];
    }
    let unit = label.find(" (").or_else(|| label.find(" ["));
    let (name, unit) = match unit {
        Some(at) => (&label[..at], &label[at + 1..]),
        None => (label, ""),
    };
    let parts = [name, unit].into_iter().filter(|part| !part.is_empty());
    parts
        .flat_map(|part| font::wrap(part, LABEL_SIZE, room))
        .collect()
}

/// Position of a label relative to its subject.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LabelSide {
    Left,
    Right,
}

/// A label that reads upwards, centred on `at`, beside a frame of this height. Its lines after the
/// first are further out on the right, nearer to the frame on the left.
pub(super) fn label_upright(
    scene: &mut Scene,
    label: &str,
    (x, middle): (f64, f64),
    height: f64,
    side: LabelSide,
) {
    let lines = upright_lines(label, height);
    let first = match side {
        LabelSide::Left => x - LINE * (lines.len() - 1) as f64,
        LabelSide::Right => x,
    };
    for (index, line) in lines.into_iter().enumerate() {
        scene.marks.push(Mark::Text(Text {
            text: line,
            at: (first + LINE * index as f64, middle),
            size: LABEL_SIZE,
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

/// The figure's title and the name of its data, at the right or below; returns where they end. Nothing
/// in styles without headings.
pub(super) fn heading(scene: &mut Scene, title: &str, name: &str) -> f64 {
    const SIZE: f64 = 25.0;
    const SIDE: f64 = 30.0;
    if !scene.style.headings {
        return EDGE;
    }
    let room = scene.width - 2.0 * SIDE;
    let lines = font::wrap(title, SIZE, room);
    scene.lines(&lines, (SIDE, 32.0), SIZE, Anchor::Start);
    let last = lines.last().map_or(0.0, |line| font::width(line, SIZE));
    let mut y = 32.0 + 1.25 * SIZE * (lines.len() - 1) as f64;
    if !name.is_empty() {
        let needed = font::width(name, TICK_SIZE).min(0.4 * room);
        let beside = room - last - 30.0;
        let (room, anchor) = match needed <= beside {
            true => (beside, Anchor::End),
            false => (room, Anchor::Start),
        };
        let x = match anchor {
            Anchor::End => scene.width - SIDE,
            _ => SIDE,
        };
        if anchor == Anchor::Start {
            y += LINE + 4.0;
        }
        scene.marks.push(Mark::Text(Text {
            text: font::shorten(name, TICK_SIZE, room),
            at: (x, y),
            size: TICK_SIZE,
            color: FAINT,
            anchor,
            vertical: false,
        }));
    }
    y + 22.0
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
