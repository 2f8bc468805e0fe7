//! The views of one or more budgets in one figure.

use std::f64::consts::PI;

use super::Figure;
use super::axis::around;
use super::budget::positions;
use super::layout::FigureLayout;
use super::style::Style;
use crate::budget::Budget;
use crate::sheet::PlotRow;
use crate::sheet::{
    BLACK, BLUE, Chart, GREEN, Level, ORANGE, PURPLE, SKY, Series, VERMILLION, extent,
};

/// Colours of fluxes over k and of those over scales, a pair a budget.
const COLORS: [(usize, usize); 3] = [(BLUE, SKY), (VERMILLION, ORANGE), (GREEN, PURPLE)];

/// Energy that has passed from low to high k, out of the scales larger than l, and through x, as
/// shares of the largest energy; `None` without a budget over wavenumbers.
pub fn views(budgets: &[(&str, &Budget)], style: &Style) -> Option<Figure> {
    let (_, first) = budgets
        .iter()
        .find(|(_, budget)| budget.wavenumber.is_some())?;
    let names: Vec<&str> = budgets.iter().map(|(name, _)| *name).collect();
    let alone = budgets.len() == 1;
    let (mut fluxes, mut passed) = (Vec::new(), Vec::new());
    for ((name, budget), (dark, light)) in budgets.iter().zip(COLORS) {
        let view = |what: &str, colour, x: &[f64], y: &[f64]| {
            let label = match alone {
                true => what.to_owned(),
                false => format!("{name}: {what}"),
            };
            let shares: Vec<f64> = y.iter().map(|value| value / budget.scale).collect();
            Series::of(label, colour, x, &shares)
        };
        if let Some(found) = &budget.wavenumber {
            let k = &found.wavenumber;
            if alone {
                let whole = &found.integrated_flux;
                fluxes.push(view("over k, whole record", BLACK, k, whole));
            }
            fluxes.push(view("over k", dark, k, &found.late_flux));
        }
        if let Some(scales) = &budget.scales {
            let k = scales.scales.iter().map(|scale| 2.0 * PI / scale.scale);
            let k: Vec<f64> = k.collect();
            fluxes.push(view("over 2π/l", light, &k, &scales.integrated_flux));
        }
        passed.push(view("passed x", dark, &positions(budget), &budget.passed));
    }
    let flux = "passed to higher k, or smaller scales (share of the energy)";
    let through = "passed through x (share of the energy)";
    let note = "over k: the second half of the record, when the impact is taken up; over l: where the \
                filter fits into the chain";
    let sheet = FigureLayout {
        title: "Where the energy went".into(),
        data: names.join(" and "),
        rows: vec![
            PlotRow::of([chart(first.units.wavenumber(), flux, fluxes)]),
            PlotRow::of([chart(first.units.position(), through, passed)]),
        ],
        notes: vec![note.into()],
        ..FigureLayout::default()
    };
    Some(sheet.figure("views", style))
}

fn chart(x_label: String, y_label: &str, series: Vec<Series>) -> Chart {
    let points = || series.iter().flat_map(|series| &series.points);
    let highest = extent(points().map(|point| point.0)).end;
    let y = around(points().map(|point| point.1));
    Chart {
        x: 0.0..highest,
        y,
        levels: vec![Level::zero()],
        ..Chart::of("", x_label, y_label, series)
    }
}
