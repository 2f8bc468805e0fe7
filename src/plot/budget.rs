//! Figures of a budget: maps of its fluxes, energy passed and left behind, and its views in one
//! figure.

use super::axis::around;
use super::figures::{MapFigure, WHITE, values};
use super::layout::FigureLayout;
use super::scale::ColorScale;
use super::scene::INK;
use super::style::Style;
use super::views::views;
use super::{Figure, Format};
use crate::Result;
use crate::analyze::Map;
use crate::budget::{Budget, Residual};
use crate::sheet::PlotRow;
use crate::sheet::{BLACK, BLUE, Chart, GREEN, PURPLE, Series, VERMILLION, extent};

const BAND_EDGE: &str = "band edge";

/// Budgets whose pictures share their axes and colours, so that they compare.
#[derive(Debug, Clone)]
pub struct SharedScales<'a>(pub &'a [&'a Budget]);

impl SharedScales<'_> {
    fn of<'b>(&'b self, map: impl Fn(&'b Budget) -> Option<&'b Map>) -> impl Iterator<Item = f64> {
        let maps: Vec<&Map> = self.0.iter().copied().filter_map(map).collect();
        let all: Vec<f64> = maps.into_iter().flat_map(values).collect();
        all.into_iter()
    }
}

/// All figures of a budget called `name`, in the order of reading, on scales shared with others.
pub fn budget_figures(
    budget: &Budget,
    name: &str,
    shared: &SharedScales,
    style: &Style,
) -> Vec<Figure> {
    let closure = &budget.closure;
    let mut figures = vec![
        energies(budget, name, shared).figure("energies", style),
        flux_map(budget, &captioned(name, &closure.real_space), shared, style),
        passed(budget, &captioned(name, &closure.frequency), shared).figure("energy-passed", style),
    ];
    if let Some(flow) = &budget.frequency {
        let name = captioned(name, &closure.frequency);
        let mut sheet = MapFigure::new(
            style,
            "Power flow P(f) through each contact",
            &name,
            &flow.map,
            None,
        );
        let all = shared.of(|budget| Some(&budget.frequency.as_ref()?.map));
        sheet.draw_map(&flow.map, clipped(all));
        sheet.mark_frequency(Some(flow.edge), BAND_EDGE, INK);
        figures.push(sheet.figure("power-flow"));
    }
    if let Some(found) = &budget.wavenumber {
        let name = captioned(name, &closure.wavenumber);
        let second = Some(("k a / π".to_owned(), budget.pitch / std::f64::consts::PI));
        let edge = found.edge.is_finite().then_some(found.edge);
        let title = "Energy spectrum E(k, t)";
        let mut sheet = MapFigure::new(style, title, &name, &found.energy_map, second.clone());
        let all = shared.of(|budget| Some(&budget.wavenumber.as_ref()?.energy_map));
        sheet.draw_map(&found.energy_map, ColorScale::log(all, style.depth));
        sheet.mark_wavenumber(edge, BAND_EDGE, WHITE);
        figures.push(sheet.figure("energy-spectrum"));
        let title = "Spectral flux Π(k, t), towards high k";
        let mut sheet = MapFigure::new(style, title, &name, &found.flux_map, second);
        let all = shared.of(|budget| Some(&budget.wavenumber.as_ref()?.flux_map));
        sheet.draw_map(&found.flux_map, clipped(all));
        sheet.mark_wavenumber(edge, BAND_EDGE, INK);
        figures.push(sheet.figure("spectral-flux"));
    }
    if let Some(scales) = &budget.scales
        && let Some(map) = &scales.flux_map
    {
        let of = scales.scales.iter().find(|of| of.scale == scales.map_scale);
        let cutoff = of.map_or(f64::NAN, |of| of.cutoff_wavenumber);
        let title = format!(
            "Scale flux Π_l(x, t) at l = {:.4} (gain 1/2 at k = {cutoff:.3})",
            scales.map_scale
        );
        let name = captioned(name, &closure.scale);
        let mut sheet = MapFigure::new(style, &title, &name, map, None);
        let all = shared.of(|budget| budget.scales.as_ref()?.flux_map.as_ref());
        sheet.draw_map(map, clipped(all));
        figures.push(sheet.figure("scale-flux"));
    }
    figures.extend(views(&[(name, budget)], style));
    figures
}

/// The files of figures, in one format.
///
/// # Errors
/// [`crate::Error::Draw`].
pub fn encode_all(figures: &[Figure], format: Format) -> Result<Vec<Vec<u8>>> {
    use rayon::prelude::*;
    figures
        .par_iter()
        .map(|figure| figure.encode(format))
        .collect()
}

/// A scale about zero that ends where one cell in two hundred that are not 0 is beyond it: what
/// happens at the striker would hide the rest.
fn clipped(values: impl Iterator<Item = f64>) -> ColorScale {
    ColorScale::diverging(std::iter::once(ordinary(values)))
}

/// The largest magnitude when one in two hundred of those that are not 0 is left out; 0 for none.
pub(crate) fn ordinary(values: impl Iterator<Item = f64>) -> f64 {
    let sizes = values.map(f64::abs);
    let mut sizes: Vec<f64> = sizes.filter(|s| *s > 0.0 && s.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    let kept = (0.995 * sizes.len() as f64).ceil() as usize;
    sizes[..kept].last().copied().unwrap_or(0.0)
}

fn captioned(name: &str, residual: &Residual) -> String {
    match residual {
        Residual::Closed(value) => format!("{name}; balance closes to {value:.1e}"),
        Residual::Undefined(_) => name.to_owned(),
    }
}

fn flux_map(budget: &Budget, name: &str, shared: &SharedScales, style: &Style) -> Figure {
    let map = &budget.flux_map;
    let mut sheet = MapFigure::new(style, "Energy flux J(x, t), towards +x", name, map, None);
    sheet.draw_map(map, clipped(shared.of(|budget| Some(&budget.flux_map))));
    sheet.figure("energy-flux")
}

/// Motion, contacts, losses and input over time.
fn energies(budget: &Budget, name: &str, shared: &SharedScales) -> FigureLayout {
    let curve = |label, colour, y: &[f64]| Series::of(label, colour, &budget.time, y);
    let mut curves = vec![
        curve("in the chain", BLACK, &budget.energies()),
        curve("of motion", BLUE, &budget.kinetic),
        curve("of contacts", VERMILLION, &budget.contact),
    ];
    let any = |values: &[f64]| values.iter().any(|value| *value != 0.0);
    if any(&budget.lost) {
        curves.push(curve("lost", GREEN, &budget.lost));
    }
    if any(&budget.input) {
        curves.push(curve("put in", PURPLE, &budget.input));
    }
    let all = shared.0.iter().flat_map(|budget| {
        let held = budget.energies().into_iter();
        let rest = [
            &budget.kinetic,
            &budget.contact,
            &budget.lost,
            &budget.input,
        ];
        held.chain(rest.into_iter().flatten().copied())
    });
    let times = shared.0.iter().flat_map(|budget| &budget.time).copied();
    let chart = Chart {
        x: extent(times),
        y: around(all),
        ..Chart::of(
            "",
            budget.units.time(),
            budget.units.energy("energy"),
            curves,
        )
    };
    single("Energy over time", name, chart)
}

fn single(title: &str, name: &str, chart: Chart) -> FigureLayout {
    FigureLayout {
        title: title.into(),
        data: name.into(),
        rows: vec![PlotRow::of([chart])],
        ..FigureLayout::default()
    }
}

/// Energy passed by the end through each contact, in either band, and what stayed behind.
fn passed(budget: &Budget, name: &str, shared: &SharedScales) -> FigureLayout {
    let x = positions(budget);
    let curve = |label: &str, colour, y: &[f64]| Series::of(label, colour, &x, y);
    let mut curves = vec![curve("passed by the end", BLACK, &budget.passed)];
    if let Some(flow) = &budget.frequency {
        let low = format!("low band (up to {:.3})", flow.edge);
        curves.push(curve(&low, BLUE, &flow.low));
        curves.push(curve("high band", VERMILLION, &flow.high));
    }
    curves.push(curve("held behind at the end", GREEN, &budget.left_behind));
    let all = shared.0.iter().flat_map(|budget| {
        let bands = budget
            .frequency
            .iter()
            .flat_map(|flow| [&flow.low, &flow.high]);
        let whole = [&budget.passed, &budget.left_behind].into_iter();
        whole.chain(bands).flatten().copied()
    });
    let places = shared.0.iter().flat_map(|budget| positions(budget));
    let chart = Chart {
        x: extent(places),
        y: around(all),
        ..Chart::of(
            "",
            budget.units.position(),
            budget.units.energy("energy"),
            curves,
        )
    };
    single("Energy passed along x", name, chart)
}

pub(super) fn positions(budget: &Budget) -> Vec<f64> {
    (0..budget.n_contacts)
        .map(|j| budget.pitch * (j as f64 + 0.5))
        .collect()
}
