//! Figures of one heat map each.

use super::axis::PlotAxis;
use super::heat::{self, BarSide, ColorBar, Greys};
use super::labels::{self, Side};
use super::legend::{self, Entry};
use super::panel::{self, EDGE, Panel, TICK_SIZE};
use super::scale::ColorScale;
use super::scene::{Anchor, INK, Rect, Scene};
use super::style::Style;
use super::{Figure, dispersion};
use crate::analyze::{Analysis, DispersionCurve, Map, Reduction};
use crate::moved::{Answer, Movement};
use crate::sheet::{BLUE, PALETTE, Series, VERMILLION};

/// Least height of a map.
const LOWEST: f64 = 150.0;
/// Passes of a layout.
pub(super) const PASSES: usize = 3;
/// Share of the width of a map that a panel beside it takes, and the gap between them.
const SIDE: (f64, f64) = (0.2, 20.0);

pub(super) const WHITE: [u8; 3] = [255; 3];

/// A map of an analysis, in figures and on pages.
pub(crate) struct MapKind {
    /// On pages.
    pub id: &'static str,
    pub title: &'static str,
    /// What it shows, and what to look for.
    pub shows: &'static str,
    pub map: fn(&Analysis) -> Option<&Map>,
    /// Of x and of y.
    pub sides: [Side; 2],
}

const FIELD: MapKind = MapKind {
    id: "field",
    title: "Field v(t, x)",
    shows: "The samples themselves. Slopes are speeds: a steeper band is slower. Look for the leading pulse, what it \
            leaves behind, and reflections.",
    map: |analysis| analysis.field_map.as_ref(),
    sides: [Side::Space, Side::Time],
};

const SPACETIME: MapKind = MapKind {
    id: "spacetime",
    title: "Space-time spectrum S(k, f)",
    shows: "Energy by wavenumber and frequency: the right half travels towards +x, the left half towards −x. Ridges are \
            dispersion curves, gaps are band gaps; in a chain with a cell of two sites, folding shows a few per cent of \
            a one-way wave on the other side.",
    map: |analysis| analysis.spacetime_map.as_ref(),
    sides: [Side::SignedWavenumber, Side::Frequency],
};

const TEMPORAL: MapKind = MapKind {
    id: "temporal",
    title: "Temporal spectrum S(f, x)",
    shows: "Which frequencies each site sees. A cascade fills the top of the picture as x grows; the dashed line is the \
            frequency past which energy moves.",
    map: |analysis| analysis.temporal_map.as_ref(),
    sides: [Side::Space, Side::Frequency],
};

const SPATIAL: MapKind = MapKind {
    id: "spatial",
    title: "Spatial spectrum S(k, t)",
    shows: "Which wavenumbers the field holds at each time. A cascade spreads to the right as time goes on; the dashed \
            line is the wavenumber past which energy moves.",
    map: |analysis| analysis.spatial_map.as_ref(),
    sides: [Side::Wavenumber, Side::Time],
};

const FLUX: MapKind = MapKind {
    id: "flux",
    title: "Kinetic flux surrogate Π_K(k, t), positive towards high k",
    shows: "Rate at which kinetic energy leaves the wavenumbers up to k, from velocity alone: positive towards high k. It \
            counts exchange with contact energy too, so read it as a surrogate and compare it with an exact budget \
            where one can be had.",
    map: |analysis| analysis.flux_map.as_ref(),
    sides: [Side::Wavenumber, Side::Time],
};

/// In the order of reading.
pub(crate) const MAPS: [MapKind; 5] = [FIELD, SPACETIME, TEMPORAL, SPATIAL, FLUX];

impl MapKind {
    /// The figure of the map, drawn but for its marks.
    fn drawn(
        &self,
        analysis: &Analysis,
        style: &Style,
        prepare: impl FnOnce(&mut MapFigure),
    ) -> Option<MapFigure> {
        let map = (self.map)(analysis)?.shown();
        let second = self.sides[0].second_reading(&analysis.axes);
        let mut sheet = MapFigure::new(style, self.title, &analysis.name, map, second);
        sheet.not_shown = labels::not_shown(analysis, &self.sides, true);
        prepare(&mut sheet);
        let scale = match map.reduction {
            Reduction::Extreme { .. } => ColorScale::diverging(values(map)),
            Reduction::Max { .. } => ColorScale::log(values(map), style.depth),
        };
        sheet.draw_map(map, scale);
        Some(sheet)
    }
}

/// The field itself, on a colour scale symmetric about zero.
pub fn space_time(analysis: &Analysis, style: &Style) -> Option<Figure> {
    Some(FIELD.drawn(analysis, style, |_| {})?.figure("space-time"))
}

/// Past which frequency or wavenumber energy is told to move.
fn past(analysis: &Analysis, of: fn(&Answer) -> &Movement) -> Option<f64> {
    of(analysis.answer.as_ref()?).past()
}

/// `S(f, x)` on a logarithmic colour scale, with the frequency of the verdict.
pub fn temporal_spectrum(analysis: &Analysis, style: &Style) -> Option<Figure> {
    let mut sheet = TEMPORAL.drawn(analysis, style, |sheet| sheet.note_interval(analysis))?;
    sheet.mark_frequency(past(analysis, |a| &a.frequency), "verdict", WHITE);
    Some(sheet.figure("temporal-spectrum"))
}

/// `S(k, t)` on a logarithmic colour scale, with the wavenumber of the verdict.
pub fn spatial_spectrum(analysis: &Analysis, style: &Style) -> Option<Figure> {
    let mut sheet = SPATIAL.drawn(analysis, style, |_| {})?;
    sheet.mark_wavenumber(past(analysis, |a| &a.wavenumber), "verdict", WHITE);
    Some(sheet.figure("spatial-spectrum"))
}

/// `Pi_K(k, t)`, from velocity alone, on a colour scale symmetric about zero.
pub fn flux_surrogate(analysis: &Analysis, style: &Style) -> Option<Figure> {
    let mut sheet = FLUX.drawn(analysis, style, |_| {})?;
    sheet.mark_wavenumber(past(analysis, |a| &a.wavenumber), "verdict", INK);
    Some(sheet.figure("flux-surrogate"))
}

/// `S(k, f)` with the energy travelling each way: in all, and at each frequency.
pub fn spacetime_spectrum(analysis: &Analysis, style: &Style) -> Option<Figure> {
    let curves = DispersionCurve::curves(&analysis.dispersion);
    // Where the answer withholds them, nothing else states them.
    let shares = analysis.direction_by_frequency.as_ref();
    let shares = shares.filter(|_| analysis.undirected.is_none());
    let mut sheet = SPACETIME.drawn(analysis, style, |sheet| {
        sheet.has_side = shares.is_some();
        sheet.name_directions(analysis);
        sheet.above.extend(dispersion::entries(&curves));
    })?;
    sheet.mark_standing();
    dispersion::draw(&mut sheet.scene, &sheet.panel, &curves);
    if let Some(shares) = shares {
        let bins = analysis.display.frequency.bins.clone();
        let shares = shares.each_ref().map(|shares| &shares[bins.clone()]);
        sheet.draw_shares(&analysis.axes.frequency[bins], shares);
    }
    Some(sheet.figure("spacetime-spectrum"))
}

pub(super) fn values(map: &Map) -> impl Iterator<Item = f64> + '_ {
    map.values.iter().copied().map(f64::from)
}

/// One map with its axes, colour bar and notes.
pub(super) struct MapFigure {
    scene: Scene,
    panel: Panel,
    /// End of the heading.
    top: f64,
    /// Words and names of curves above the map.
    above: Vec<Entry>,
    /// What the display limits leave out.
    not_shown: Option<String>,
    /// How well a spectrum is known.
    interval: Option<String>,
    /// Whether a panel beside the map shares its vertical axis.
    has_side: bool,
}

impl MapFigure {
    pub(super) fn new(
        style: &Style,
        title: &str,
        name: &str,
        map: &Map,
        second: Option<(String, f64)>,
    ) -> Self {
        let mut scene = Scene::new(&format!("{title}: {name}"), style, 0.0);
        let top = panel::heading(&mut scene, title, name);
        // As large as a first guess, to choose ticks and to break labels.
        let rect = Rect {
            left: 0.0,
            top: 0.0,
            right: 0.7 * scene.width,
            bottom: 0.45 * scene.width,
        };
        let x = PlotAxis::linear(&map.x.label, map.x.low, map.x.high).with_second(second);
        let y = PlotAxis::linear(&map.y.label, map.y.low, map.y.high);
        MapFigure {
            scene,
            panel: Panel::new(rect, x, y),
            top,
            above: Vec::new(),
            not_shown: None,
            interval: None,
            has_side: false,
        }
    }

    pub(super) fn draw_map(&mut self, map: &Map, scale: ColorScale) {
        let greys = Greys {
            missing: map.values.iter().any(|v| !v.is_finite()),
            both_signs: heat::holds_both_signs(map),
        };
        let bar = ColorBar {
            scale: &scale,
            quantity: &map.label,
            greys,
        };
        let side = match self.scene.style.is_narrow() {
            true => BarSide::Below,
            false => BarSide::Right,
        };
        // The frame decides how labels break, and these what is left for the frame.
        let mut outer = self.panel.rect;
        for _ in 0..PASSES {
            outer = self.lay_out(&bar, side, self.notes(map).len());
        }
        let note = self.notes(map);
        let beside = self.panel.margins();
        let names = (outer.left, self.top);
        legend::draw(&mut self.scene, names, outer.width(), &self.above);
        match greys.both_signs {
            true => heat::draw_signed(&mut self.scene, &self.panel, map, &scale),
            false => heat::draw(&mut self.scene, &self.panel, map.values.view(), &scale),
        }
        self.panel.draw_axes(&mut self.scene);
        let from = match side {
            BarSide::Below => beside.bottom,
            BarSide::Right => 0.0,
        };
        bar.draw(&mut self.scene, outer, side, from);
        let step = 1.25 * TICK_SIZE;
        let first = self.scene.height - EDGE - step * (note.len() as f64 - 0.5);
        let at = (self.scene.width - 2.0 * EDGE, first);
        self.scene.lines(&note, at, TICK_SIZE, Anchor::End);
    }

    /// Sets the height of the figure and the frame of the map; returns the frame with what is beside it.
    fn lay_out(&mut self, bar: &ColorBar, side: BarSide, note_lines: usize) -> Rect {
        let (width, style) = (self.scene.width, self.scene.style);
        let beside = self.panel.margins();
        let left = EDGE + beside.left;
        let right = width
            - EDGE
            - match side {
                BarSide::Right => bar.extent(side, self.panel.rect.height()),
                BarSide::Below => beside.right,
            };
        let names = legend::height(&self.above, right - left);
        let foot = EDGE + heat::note_height(note_lines);
        let below = beside.bottom
            + match side {
                BarSide::Right => 0.0,
                BarSide::Below => bar.extent(side, right - left),
            };
        let fixed = self.top + names + beside.top + below + foot;
        let natural = match side {
            BarSide::Right => width / 1.5,
            BarSide::Below => fixed + 0.65 * (right - left),
        };
        self.scene.height = style.rows(natural, fixed + LOWEST);
        let outer = Rect {
            left,
            top: self.top + names + beside.top,
            right,
            bottom: self.scene.height - below - foot,
        };
        self.panel.rect = match self.has_side {
            true => Rect {
                right: right - SIDE.0 * outer.width() - SIDE.1,
                ..outer
            },
            false => outer,
        };
        outer
    }

    /// Says how well the spectrum is known, if it is of a stationary record.
    fn note_interval(&mut self, analysis: &Analysis) {
        let Some(interval) = analysis.interval else {
            return;
        };
        self.interval = match (interval.degrees_of_freedom, interval.factors) {
            (Some(degrees), Some([low, high])) => Some(format!(
                "95 % interval: {low:.3} to {high:.3} of a value ({degrees:.3} degrees of freedom)"
            )),
            _ => Some("no interval: a transient is one realisation".into()),
        };
    }

    /// Lines that say what is not shown, and how many samples a cell of the picture stands for.
    fn notes(&self, map: &Map) -> Vec<String> {
        let cell = heat::cell_of(&self.panel.rect, map.values.dim());
        let (what, rows, columns) = match map.reduction {
            Reduction::Max { rows, columns } => ("largest value", rows, columns),
            Reduction::Extreme { rows, columns } => ("value of largest magnitude", rows, columns),
        };
        let samples = (rows * cell.0, columns * cell.1);
        let room = self.scene.width - 4.0 * EDGE;
        let mut notes = heat::wrapped(self.not_shown.as_deref(), room);
        notes.extend(heat::wrapped(self.interval.as_deref(), room));
        notes.extend(heat::reduction_note(what, samples, room));
        notes
    }

    pub(super) fn mark_frequency(&mut self, at: Option<f64>, name: &str, color: [u8; 3]) {
        let Some(y) = at.and_then(|at| self.panel.place_y(at)) else {
            return;
        };
        let rect = self.panel.rect;
        if y > rect.top && y < rect.bottom {
            let (scene, room) = (&mut self.scene, y - rect.top);
            scene.dashes((rect.left, y), (rect.right, y), color, 2.0);
            let beside = if room > 30.0 { y - 16.0 } else { y + 16.0 };
            panel::note(scene, name, (rect.right - 10.0, beside), Anchor::End);
        }
    }

    pub(super) fn mark_wavenumber(&mut self, at: Option<f64>, name: &str, color: [u8; 3]) {
        let Some(x) = at.and_then(|at| self.panel.place_x(at)) else {
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
            panel::note(scene, name, (beside, rect.top + 18.0), anchor);
        }
    }

    /// The line k = 0.
    fn mark_standing(&mut self) {
        let rect = self.panel.rect;
        let inside = |x: &f64| *x > rect.left && *x < rect.right;
        if let Some(x) = self.panel.place_x(0.0).filter(inside) {
            self.scene
                .dashes((x, rect.bottom), (x, rect.top), WHITE, 1.6);
        }
    }

    /// Each side's share of the energy above the map, with the colours of the curves beside it.
    fn name_directions(&mut self, analysis: &Analysis) {
        let Some(direction) = analysis.direction_of_waves() else {
            return;
        };
        let percent = |share: f64| match share.is_finite() {
            true => format!("{:.1} %", 100.0 * share),
            false => "no energy".into(),
        };
        let minus = format!("← towards −x: {}", percent(direction.toward_minus_x));
        let plus = format!("→ towards +x: {}", percent(direction.toward_plus_x));
        let entry = |label: &str, color: usize| match self.has_side {
            true => Entry::line(label, PALETTE[color]),
            false => Entry::words(label),
        };
        let rest = format!("undirected: {}", percent(direction.undirected));
        self.above = vec![
            entry(&minus, VERMILLION),
            entry(&plus, BLUE),
            Entry::words(&rest),
        ];
    }

    /// Shares of each direction at each frequency, beside the map.
    fn draw_shares(&mut self, frequency: &[f64], [plus, minus]: [&[f64]; 2]) {
        let map = self.panel.rect;
        let rect = Rect {
            left: map.right + SIDE.1,
            right: map.right + SIDE.1 + SIDE.0 / (1.0 - SIDE.0) * (map.width() + SIDE.1),
            ..map
        };
        let label = match rect.width() > 150.0 {
            true => "share of energy",
            false => "share",
        };
        let share = PlotAxis::linear(label, 0.0, 1.0);
        let mut side = Panel::new(rect, share, self.panel.y.clone());
        side.names_y = false;
        side.draw_grid(&mut self.scene);
        for (shares, color) in [(minus, VERMILLION), (plus, BLUE)] {
            Series::of("", color, shares, frequency).draw(&mut self.scene, &side);
        }
        side.draw_axes(&mut self.scene);
    }

    pub(super) fn figure(self, name: &'static str) -> Figure {
        Figure {
            name,
            scene: self.scene,
        }
    }
}
