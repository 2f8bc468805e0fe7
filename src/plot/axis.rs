//! Axes, and what is drawn of them along a side of a frame.

use std::ops::Range;

use super::font;
use super::scale::Scale;
use super::scene::{Anchor, INK, Point, Rect, Scene};
use super::style::{LABEL, SMALL};

pub(super) const LABEL_SIZE: f64 = LABEL;
pub(super) const TICK_SIZE: f64 = SMALL;
pub(super) const TICK_LENGTH: f64 = 7.0;
/// From one line of a label to the next.
pub(super) const LINE: f64 = 1.25 * LABEL_SIZE;
/// Around all that is drawn.
pub(super) const EDGE: f64 = 12.0;

/// A scale with its label.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlotAxis {
    pub label: String,
    pub scale: Scale,
    /// Label of a second reading of the same axis, and what values are multiplied by for it.
    pub second: Option<(String, f64)>,
}

impl PlotAxis {
    /// A linear axis, or a logarithmic one where the range is positive.
    pub fn over(
        label: &str,
        range: &Range<f64>,
        log: bool,
        second: Option<(String, f64)>,
    ) -> PlotAxis {
        let (low, high) = (range.start, range.end);
        PlotAxis {
            label: label.into(),
            scale: match log && low > 0.0 && high > low {
                true => Scale::logarithmic(low, high),
                false => Scale::linear(low, high),
            },
            second,
        }
    }

    /// The second reading as an axis of its own.
    pub fn second_axis(&self) -> Option<PlotAxis> {
        let (label, factor) = self.second.as_ref()?;
        let range = self.scale.low * factor..self.scale.high * factor;
        Some(PlotAxis::over(label, &range, false, None))
    }

    /// Along a side of this length.
    pub fn edge(&self, side: Side, length: f64) -> Edge {
        Edge::of(
            &self.scale,
            self.scale.axis_label(&self.label),
            side,
            length,
        )
    }
}

/// A side of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
    Above,
    Below,
}

impl Side {
    pub fn is_upright(self) -> bool {
        matches!(self, Side::Left | Side::Right)
    }

    pub fn length(self, rect: &Rect) -> f64 {
        match self.is_upright() {
            true => rect.height(),
            false => rect.width(),
        }
    }

    /// So far out of a frame, at a share of the side from its left or lower end.
    pub fn place(self, rect: &Rect, share: f64, out: f64) -> Point {
        let (x, y) = (
            rect.left + share * rect.width(),
            rect.bottom - share * rect.height(),
        );
        match self {
            Side::Left => (rect.left - out, y),
            Side::Right => (rect.right + out, y),
            Side::Above => (x, rect.top - out),
            Side::Below => (x, rect.bottom + out),
        }
    }
}

/// Ticks and a label along a side of a frame.
pub(super) struct Edge {
    side: Side,
    /// Shares of the side, with what is written there.
    pub ticks: Vec<(f64, String)>,
    lines: Vec<String>,
}

impl Edge {
    /// With as many ticks as fit side by side.
    pub fn of(scale: &Scale, label: String, side: Side, length: f64) -> Edge {
        let is_upright = side.is_upright();
        let spacing = match (is_upright, scale.is_logarithmic()) {
            (false, _) => 75.0,
            (true, true) => 40.0,
            (true, false) => 55.0,
        };
        let lowest = scale.lowest_text().map(|text| (0.0, text));
        let mut count = (length / spacing).max(2.0) as usize;
        let ticks = loop {
            let ticks = scale.ticks(count).into_iter();
            let placed = ticks.filter_map(|tick| Some((scale.place(tick.value)?, tick.text)));
            let mut ticks: Vec<(f64, String)> = placed.collect();
            // From a tick to the next, and from the lowest colour's to the first.
            let (wide, lowest_wide) = (widest(ticks.iter()), widest(lowest.iter()));
            let [needed, from] = match is_upright {
                true => [1.5 * TICK_SIZE; 2],
                false => [wide, 0.5 * (wide + lowest_wide)].map(|width| width + 0.6 * TICK_SIZE),
            };
            ticks.retain(|(share, _)| lowest.is_none() || share * length > from);
            let mut pairs = ticks.windows(2);
            let is_crowded = pairs.any(|pair| (pair[1].0 - pair[0].0) * length < needed);
            if is_upright || !is_crowded || count <= 1 {
                break ticks;
            }
            count -= 1;
        };
        Edge {
            side,
            ticks: lowest.into_iter().chain(ticks).collect(),
            lines: match is_upright {
                true => upright_lines(&label, length + 20.0),
                false => font::wrap(&label, LABEL_SIZE, length + 2.0 * EDGE),
            },
        }
    }

    pub fn widest(&self) -> f64 {
        widest(self.ticks.iter())
    }

    /// From the frame to the first line of the label.
    fn label_at(&self) -> f64 {
        match self.side.is_upright() {
            true => 34.0 + self.widest(),
            false => 46.0,
        }
    }

    /// What it takes beside the frame.
    pub fn extent(&self) -> f64 {
        self.label_at() + LINE * (self.lines.len() as f64 - 1.0) + 0.5 * LABEL_SIZE
    }

    /// Draws it, or the ticks alone.
    pub fn draw(&self, scene: &mut Scene, rect: &Rect, is_named: bool) {
        let (out, anchor) = match self.side {
            Side::Left => (13.0, Anchor::End),
            Side::Right => (13.0, Anchor::Start),
            Side::Above | Side::Below => (20.0, Anchor::Middle),
        };
        for (share, text) in &self.ticks {
            let ends = [0.0, TICK_LENGTH].map(|out| self.side.place(rect, *share, out));
            scene.line(&ends, INK, 1.0);
            if is_named {
                let at = self.side.place(rect, *share, out);
                scene.text(text, at, TICK_SIZE, anchor);
            }
        }
        let lines = self.lines.iter().enumerate().filter(|_| is_named);
        for (index, line) in lines {
            // The first line is the leftmost or the uppermost.
            let from_frame = match self.side {
                Side::Left | Side::Above => self.lines.len() - 1 - index,
                Side::Right | Side::Below => index,
            };
            let out = self.label_at() + LINE * from_frame as f64;
            let at = self.side.place(rect, 0.5, out);
            match self.side.is_upright() {
                true => scene.upright(line, at, LABEL_SIZE),
                false => scene.text(line, at, LABEL_SIZE, Anchor::Middle),
            }
        }
    }
}

fn widest<'t>(ticks: impl Iterator<Item = &'t (f64, String)>) -> f64 {
    let widths = ticks.map(|(_, text)| font::width(text, TICK_SIZE));
    widths.fold(0.0, f64::max)
}

/// A label beside a frame, in lines that fit into `room`; the unit stays together where it can.
fn upright_lines(label: &str, room: f64) -> Vec<String> {
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
