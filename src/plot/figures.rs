//! Figures of one heat map each.

use super::axis::PlotAxis;
use super::curve::{self, BLUE, Curve, VERMILLION};
use super::labels;
use super::panel::{self, Panel};
use super::scale::ColorScale;
use super::scene::{Anchor, INK, Rect, Scene};
use super::{Figure, heat};
use crate::analyze::{Analysis, Map, Reduction};

const WIDTH: u32 = 1200;
const HEIGHT: u32 = 800;

const LEFT: f64 = 125.0;
const RIGHT: f64 = 965.0;
const BOTTOM: f64 = 700.0;
const TOP: f64 = 75.0;
/// Below a second axis.
const LOW_TOP: f64 = 130.0;

pub(super) const WHITE: [u8; 3] = [255; 3];

/// The field itself, on a colour scale symmetric about zero.
pub fn space_time(analysis: &Analysis) -> Option<Figure> {
    let map = analysis.field_map.as_ref()?;
    let mut sheet = MapFigure::new("Field v(t, x)", &analysis.name, map, None);
    sheet.draw_map(map, ColorScale::diverging(values(map)));
    Some(sheet.figure("space-time"))
}

/// `S(f, x)` on a logarithmic colour scale, with the band edge.
pub fn temporal_spectrum(analysis: &Analysis) -> Option<Figure> {
    let map = analysis.temporal_map.as_ref()?;
    let mut sheet = MapFigure::new("Temporal spectrum S(f, x)", &analysis.name, map, None);
    sheet.draw_map(map, ColorScale::log(values(map)));
    sheet.mark_frequency_edge(analysis.frequency_edge.map(|edge| edge.value()), WHITE);
    Some(sheet.figure("temporal-spectrum"))
}

/// `E(k, t)` on a logarithmic colour scale, with the band edge.
pub fn spatial_spectrum(analysis: &Analysis) -> Option<Figure> {
    let map = analysis.spatial_map.as_ref()?;
    let second = labels::wavenumber_reading(&analysis.axes);
    let mut sheet = MapFigure::new("Spatial spectrum E(k, t)", &analysis.name, map, second);
    sheet.draw_map(map, ColorScale::log(values(map)));
    sheet.mark_wavenumber_edge(analysis.wavenumber_edge.map(|edge| edge.value()), WHITE);
    Some(sheet.figure("spatial-spectrum"))
}

/// `Pi_K(k, t)`, from velocity alone, on a colour scale symmetric about zero.
pub fn flux_surrogate(analysis: &Analysis) -> Option<Figure> {
    let map = analysis.flux_map.as_ref()?;
    let second = labels::wavenumber_reading(&analysis.axes);
    let title = "Kinetic flux surrogate Π_K(k, t), positive towards high k";
    let mut sheet = MapFigure::new(title, &analysis.name, map, second);
    sheet.draw_map(map, ColorScale::diverging(values(map)));
    sheet.mark_wavenumber_edge(analysis.wavenumber_edge.map(|edge| edge.value()), INK);
    Some(sheet.figure("flux-surrogate"))
}

/// `S(k, f)` with the energy travelling each way: in all, and at each frequency.
pub fn spacetime_spectrum(analysis: &Analysis) -> Option<Figure> {
    let map = analysis.spacetime_map.as_ref()?;
    let second = labels::wavenumber_reading(&analysis.axes);
    let mut sheet = MapFigure::new("Space-time spectrum S(k, f)", &analysis.name, map, second);
    if let Some(shares) = &analysis.direction_by_frequency {
        sheet.panel.rect.right = 780.0;
        sheet.draw_shares(&analysis.axes.frequency, shares);
    }
    sheet.draw_map(map, ColorScale::log(values(map)));
    sheet.mark_directions(analysis);
    Some(sheet.figure("spacetime-spectrum"))
}

pub(super) fn values(map: &Map) -> impl Iterator<Item = f64> + '_ {
    map.values.iter().copied().map(f64::from)
}

/// One map with its axes, colour bar and notes.
pub(super) struct MapFigure {
    scene: Scene,
    panel: Panel,
}

impl MapFigure {
    pub(super) fn new(title: &str, name: &str, map: &Map, second: Option<(String, f64)>) -> Self {
        let mut scene = Scene::new(&format!("{title}: {name}"), WIDTH, HEIGHT);
        panel::heading(&mut scene, title, name);
        let rect = Rect {
            left: LEFT,
            top: if second.is_some() { LOW_TOP } else { TOP },
            right: RIGHT,
            bottom: BOTTOM,
        };
        let x = PlotAxis::linear(&map.x.label, map.x.low, map.x.high).with_second(second);
        let y = PlotAxis::linear(&map.y.label, map.y.low, map.y.high);
        MapFigure {
            scene,
            panel: Panel::new(rect, x, y),
        }
    }

    pub(super) fn draw_map(&mut self, map: &Map, scale: ColorScale) {
        let cell = heat::draw(&mut self.scene, &self.panel, map.values.view(), &scale);
        self.panel.draw_axes(&mut self.scene);
        let bar = Rect {
            left: RIGHT + 28.0,
            right: RIGHT + 52.0,
            ..self.panel.rect
        };
        let missing = map.values.iter().any(|v| !v.is_finite());
        heat::colour_bar(&mut self.scene, bar, &scale, &map.label, missing);
        let (what, rows, columns) = match map.reduction {
            Reduction::Max { rows, columns } => ("largest value", rows, columns),
            Reduction::Extreme { rows, columns } => ("value of largest magnitude", rows, columns),
        };
        heat::reduction_note(&mut self.scene, what, (rows * cell.0, columns * cell.1));
    }

    pub(super) fn mark_frequency_edge(&mut self, edge: Option<f64>, color: [u8; 3]) {
        let Some(y) = edge.and_then(|edge| self.panel.place_y(edge)) else {
            return;
        };
        let rect = self.panel.rect;
        if y > rect.top && y < rect.bottom {
            let (scene, room) = (&mut self.scene, y - rect.top);
            scene.dashes((rect.left, y), (rect.right, y), color, 2.0);
            let beside = if room > 30.0 { y - 16.0 } else { y + 16.0 };
            panel::note(scene, "band edge", (rect.right - 10.0, beside), Anchor::End);
        }
    }

    pub(super) fn mark_wavenumber_edge(&mut self, edge: Option<f64>, color: [u8; 3]) {
        let Some(x) = edge.and_then(|edge| self.panel.place_x(edge)) else {
            return;
        };
        let rect = self.panel.rect;
        if x > rect.left && x < rect.right {
            let scene = &mut self.scene;
            scene.dashes((x, rect.bottom), (x, rect.top), color, 2.0);
            let (beside, anchor) = if rect.right - x > 120.0 {
                (x + 8.0, Anchor::Start)
            } else {
                (x - 8.0, Anchor::End)
            };
            panel::note(scene, "band edge", (beside, rect.top + 18.0), anchor);
        }
    }

    /// The line k = 0 and each side's share of the energy.
    fn mark_directions(&mut self, analysis: &Analysis) {
        let rect = self.panel.rect;
        let scene = &mut self.scene;
        let inside = |x: &f64| *x > rect.left && *x < rect.right;
        if let Some(x) = self.panel.place_x(0.0).filter(inside) {
            scene.dashes((x, rect.bottom), (x, rect.top), WHITE, 1.6);
        }
        let Some(direction) = analysis.direction else {
            return;
        };
        let percent = |share: f64| match share.is_finite() {
            true => format!("{:.1} %", 100.0 * share),
            false => "no energy".into(),
        };
        let high = rect.top + 20.0;
        let left = format!("← towards −x: {}", percent(direction.toward_minus_x));
        let right = format!("towards +x: {} →", percent(direction.toward_plus_x));
        panel::note(scene, &left, (rect.left + 12.0, high), Anchor::Start);
        panel::note(scene, &right, (rect.right - 12.0, high), Anchor::End);
        let rest = format!("undirected: {}", percent(direction.undirected));
        panel::note(scene, &rest, (rect.left + 12.0, high + 30.0), Anchor::Start);
    }

    /// Shares of each direction at each frequency, beside the map.
    fn draw_shares(&mut self, frequency: &[f64], [plus, minus]: &[Vec<f64>; 2]) {
        let rect = Rect {
            left: self.panel.rect.right + 24.0,
            right: RIGHT,
            ..self.panel.rect
        };
        let share = PlotAxis::linear("share of energy", 0.0, 1.0);
        let mut side = Panel::new(rect, share, self.panel.y.clone());
        side.names_y = false;
        side.draw_grid(&mut self.scene);
        for (y, color) in [(minus, VERMILLION), (plus, BLUE)] {
            let label = "";
            let (x, y) = (&y[..], frequency);
            Curve { label, color, x, y }.draw(&mut self.scene, &side);
        }
        side.draw_axes(&mut self.scene);
        let at = (rect.left + 16.0, rect.top - 18.0);
        let entries = [("+x", BLUE), ("−x", VERMILLION)];
        curve::legend(&mut self.scene, at, &entries);
    }

    pub(super) fn figure(self, name: &'static str) -> Figure {
        Figure {
            name,
            scene: self.scene,
        }
    }
}
