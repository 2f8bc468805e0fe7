//! The views of one or more budgets in one figure.

use std::f64::consts::PI;

use super::Figure;
use super::axis::PlotAxis;
use super::budget::{RIGHT, WIDTH, positions, rect};
use super::curve::{self, BLUE, Curve, GREEN, LEVEL, PURPLE, VERMILLION};
use super::panel::{self, Panel};
use super::scene::{Anchor, Color, INK, Rect, Scene};
use crate::budget::Budget;

/// Colours of fluxes over k and of those over scales, a pair a budget.
const COLORS: [(Color, Color); 3] = [
    (BLUE, [0x56, 0xb4, 0xe9]),
    (VERMILLION, [0xe6, 0x9f, 0x00]),
    (GREEN, PURPLE),
];

/// A curve and its data.
struct View {
    label: String,
    color: Color,
    x: Vec<f64>,
    y: Vec<f64>,
}

/// Energy that has passed from low to high k, out of the scales larger than l, and through x, as
/// shares of the largest energy; `None` without a budget over wavenumbers.
pub fn views(budgets: &[(&str, &Budget)]) -> Option<Figure> {
    let (_, first) = budgets
        .iter()
        .find(|(_, budget)| budget.wavenumber.is_some())?;
    let names: Vec<&str> = budgets.iter().map(|(name, _)| *name).collect();
    let name = names.join(" and ");
    let mut scene = Scene::new(&format!("Views of the energy: {name}"), WIDTH, 985);
    panel::heading(&mut scene, "Where the energy went", &name);
    let alone = budgets.len() == 1;
    let (mut fluxes, mut passed) = (Vec::new(), Vec::new());
    for ((name, budget), (dark, light)) in budgets.iter().zip(COLORS) {
        let view = |what: &str, color, x: Vec<f64>, y: &[f64]| View {
            label: match alone {
                true => what.to_owned(),
                false => format!("{name}: {what}"),
            },
            color,
            x,
            y: y.iter().map(|value| value / budget.scale).collect(),
        };
        if let Some(found) = &budget.wavenumber {
            let k = &found.wavenumber;
            if alone {
                let whole = &found.integrated_flux;
                fluxes.push(view("over k, whole record", INK, k.clone(), whole));
            }
            fluxes.push(view("over k", dark, k.clone(), &found.late_flux));
        }
        if let Some(scales) = &budget.scales {
            let k = scales.scales.iter().map(|scale| 2.0 * PI / scale.scale);
            fluxes.push(view(
                "over 2π/l",
                light,
                k.collect(),
                &scales.integrated_flux,
            ));
        }
        passed.push(view("passed x", dark, positions(budget), &budget.passed));
    }
    let flux = "passed to higher k, or smaller scales (share of the energy)";
    let place = [first.units.wavenumber(), first.units.position()];
    draw(&mut scene, rect(105.0, 425.0), [&place[0], flux], &fluxes);
    let through = "passed through x (share of the energy)";
    draw(
        &mut scene,
        rect(555.0, 875.0),
        [&place[1], through],
        &passed,
    );
    let note = "over k: the second half of the record, when the impact is taken up; over l: where the \
                filter fits into the chain";
    scene.text(note, (RIGHT, 962.0), panel::TICK_SIZE, Anchor::End);
    Some(Figure {
        name: "views",
        scene,
    })
}

fn draw(scene: &mut Scene, rect: Rect, [x, y]: [&str; 2], all: &[View]) {
    let highest = all
        .iter()
        .flat_map(|view| &view.x)
        .fold(0.0, |m: f64, x| m.max(*x));
    let y = PlotAxis::around(y, all.iter().flat_map(|view| view.y.iter().copied()));
    let panel = Panel::new(rect, PlotAxis::linear(x, 0.0, highest), y);
    let curves = all.iter().map(|view| Curve {
        label: &view.label,
        color: view.color,
        x: &view.x,
        y: &view.y,
    });
    let curves: Vec<Curve> = curves.collect();
    curve::draw_all(scene, &panel, &curves);
    curve::level(scene, &panel, 0.0, LEVEL);
}
