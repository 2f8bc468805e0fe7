//! A framed area with its axes: the ground that maps and curves are drawn on.

use super::axis::{EDGE, Edge, LINE, PlotAxis, Side, TICK_LENGTH, TICK_SIZE};
use super::font;
use super::scene::{Anchor, FAINT, GRID, INK, Rect, Scene, WHITE};

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
    fn edge(&self, axis: &PlotAxis, side: Side) -> Edge {
        axis.edge(side, side.length(&self.rect))
    }

    /// The second readings.
    fn seconds(&self) -> [Option<Edge>; 2] {
        [(&self.x, Side::Above), (&self.y, Side::Right)]
            .map(|(axis, side)| axis.second_axis().map(|axis| self.edge(&axis, side)))
    }

    /// What the ticks and labels take beside a frame of this size.
    pub fn margins(&self) -> Margins {
        let below = self.edge(&self.x, Side::Below);
        let [above, right] = self.seconds();
        Margins {
            left: self.edge(&self.y, Side::Left).extent(),
            top: above.map_or(0.5 * TICK_SIZE, |edge| edge.extent()),
            right: right.map_or(0.5 * below.widest(), |edge| edge.extent()),
            bottom: match self.names_x {
                true => below.extent(),
                false => TICK_LENGTH,
            },
        }
    }

    pub fn place_x(&self, value: f64) -> Option<f64> {
        let share = self.x.scale.place(value)?;
        Some(self.rect.left + share * self.rect.width())
    }

    pub fn place_y(&self, value: f64) -> Option<f64> {
        let share = self.y.scale.place(value)?;
        Some(self.rect.bottom - share * self.rect.height())
    }

    /// Light lines at the ticks, to be drawn under curves.
    pub fn draw_grid(&self, scene: &mut Scene) {
        let (width, height) = (self.rect.width(), self.rect.height());
        for (axis, side, across) in [(&self.x, Side::Below, height), (&self.y, Side::Left, width)] {
            for (share, _) in self.edge(axis, side).ticks {
                let ends = [0.0, -across].map(|out| side.place(&self.rect, share, out));
                scene.line(&ends, GRID, 1.0);
            }
        }
    }

    /// Frame, ticks and labels.
    pub fn draw_axes(&self, scene: &mut Scene) {
        scene.outline(self.rect, INK);
        self.edge(&self.x, Side::Below)
            .draw(scene, &self.rect, self.names_x);
        self.edge(&self.y, Side::Left).draw(scene, &self.rect, true);
        for edge in self.seconds().into_iter().flatten() {
            edge.draw(scene, &self.rect, true);
        }
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
    scene.fill(ground, WHITE);
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
        let name = font::shorten(name, TICK_SIZE, room);
        scene.letters(&name, (x, y), TICK_SIZE, anchor, FAINT, "");
    }
    y + 22.0
}
