//! How the content moves along x and along t: three panels of curves each.

use super::axis::PlotAxis;
use super::curve::{self, BLUE, Curve, GREEN, LEVEL, PURPLE, VERMILLION};
use super::panel::{self, Panel};
use super::scene::{Anchor, Rect, Scene};
use super::{Figure, labels};
use crate::analyze::{Analysis, BandEdge, Moments};

const WIDTH: u32 = 1200;
const HEIGHT: u32 = 1000;
const LEFT: f64 = 130.0;

/// Frequency content along x: centroid, median, 90 % frequency, band shares, energy.
pub fn along_x(analysis: &Analysis) -> Option<Figure> {
    let moments = analysis.along_space.as_ref()?;
    let axes = &analysis.axes;
    let sheet = RedistributionFigure {
        title: "Frequency content along x",
        name: &analysis.name,
        moments,
        front: analysis.front.as_ref().map(|front| &front.high_share[..]),
        edge: analysis.frequency_edge,
        along: &axes.positions(),
        along_label: labels::position(axes),
        content_label: labels::frequency(axes),
        second: None,
        row_label: "site",
        energy_label: labels::site_energy(analysis),
    };
    Some(sheet.draw("along-x"))
}

/// Wavenumber content along t: centroid, median, 90 % wavenumber, band shares, energy.
pub fn along_t(analysis: &Analysis) -> Option<Figure> {
    let moments = analysis.along_time.as_ref()?;
    let axes = &analysis.axes;
    let sheet = RedistributionFigure {
        title: "Wavenumber content along t",
        name: &analysis.name,
        moments,
        front: None,
        edge: analysis.wavenumber_edge,
        along: &axes.times(),
        along_label: labels::time(axes),
        content_label: labels::wavenumber(axes),
        second: labels::wavenumber_reading(axes),
        row_label: "time",
        energy_label: labels::time_energy(analysis),
    };
    Some(sheet.draw("along-t"))
}

struct RedistributionFigure<'a> {
    title: &'static str,
    name: &'a str,
    moments: &'a Moments,
    /// Shares of the high band over the passage of the front.
    front: Option<&'a [f64]>,
    edge: Option<BandEdge>,
    along: &'a [f64],
    along_label: String,
    content_label: String,
    second: Option<(String, f64)>,
    row_label: &'static str,
    energy_label: String,
}

impl RedistributionFigure<'_> {
    fn draw(self, name: &'static str) -> Figure {
        let title = format!("{}: {}", self.title, self.name);
        let mut scene = Scene::new(&title, WIDTH, HEIGHT);
        panel::heading(&mut scene, self.title, self.name);
        self.draw_content(&mut scene);
        self.draw_shares(&mut scene);
        self.draw_energy(&mut scene);
        Figure { name, scene }
    }

    fn panel(&self, top: f64, bottom: f64, y: PlotAxis) -> Panel {
        let rect = Rect {
            left: LEFT,
            top,
            right: if self.second.is_some() {
                1070.0
            } else {
                1165.0
            },
            bottom,
        };
        let (first, last) = match self.along {
            [first, .., last] => (*first, *last),
            [only] => (*only, *only),
            [] => (0.0, 1.0),
        };
        Panel::new(rect, PlotAxis::linear(&self.along_label, first, last), y)
    }

    fn draw_content(&self, scene: &mut Scene) {
        let Moments {
            centroid,
            median,
            quantile_90,
            ..
        } = self.moments;
        let edge = self.edge.map(|edge| edge.value()).filter(|e| e.is_finite());
        let all = [centroid, median, quantile_90]
            .into_iter()
            .flatten()
            .copied()
            .chain(edge);
        let y = PlotAxis::around(&self.content_label, all).with_second(self.second.clone());
        let mut panel = self.panel(110.0, 410.0, y);
        panel.names_x = false;
        let curves = [
            self.curve("90 % of the energy lies below", VERMILLION, quantile_90),
            self.curve("centroid", BLUE, centroid),
            self.curve("median", GREEN, median),
        ];
        curve::draw_all(scene, &panel, &curves);
        if let Some(edge) = edge {
            curve::level(scene, &panel, edge, LEVEL);
            let at = (panel.rect.right - 10.0, panel.rect.top - 18.0);
            scene.text("dashed: band edge", at, panel::TICK_SIZE, Anchor::End);
        }
    }

    fn draw_shares(&self, scene: &mut Scene) {
        let Moments {
            low_share,
            high_share,
            ..
        } = self.moments;
        let all = [low_share, high_share].into_iter().flatten().copied();
        let y = PlotAxis::around("share of energy", all.chain([1.0]));
        let mut panel = self.panel(470.0, 655.0, y);
        panel.names_x = false;
        let mut curves = vec![
            self.curve("low band (up to the edge)", BLUE, low_share),
            self.curve("high band", VERMILLION, high_share),
        ];
        let front = self
            .front
            .filter(|shares| shares.iter().any(|s| s.is_finite()));
        curves.extend(front.map(|shares| self.curve("high band, front passage", GREEN, shares)));
        curve::draw_all(scene, &panel, &curves);
    }

    fn draw_energy(&self, scene: &mut Scene) {
        let energy = &self.moments.energy;
        let y = PlotAxis::log_around(&self.energy_label, energy.iter().copied());
        let panel = self.panel(715.0, 910.0, y);
        let label = format!(
            "energy of each {} (integral of its spectrum), log scale",
            self.row_label
        );
        curve::draw_all(scene, &panel, &[self.curve(&label, PURPLE, energy)]);
    }

    fn curve<'a>(&'a self, label: &'a str, color: [u8; 3], y: &'a [f64]) -> Curve<'a> {
        Curve {
            label,
            color,
            x: self.along,
            y,
        }
    }
}
