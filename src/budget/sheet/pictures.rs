//! Figures of one budget, or of several whose pictures share their axes and colours.

use std::f64::consts::PI;

use crate::budget::{Budget, Closure, FrequencyFlow, Residual, WavenumberBudget};
use crate::sheet::{
    BLACK, BLUE, Chart, Colors, FigureLayout, GREEN, Level, Look, Map, Mark, PURPLE, PlotRow,
    Reduction, Role, SKY, Series, VERMILLION, around, extent, magnitudes, ordinary,
};

/// Budgets with their names.
pub(super) type Named<'a> = (&'a str, &'a Budget);

/// Height of a map over that of a chart.
const TALL: f64 = 1.7;

type Points = Vec<(f64, f64)>;

/// One kind of map.
struct Kind {
    name: &'static str,
    title: &'static str,
    shows: &'static str,
    roles: [Role; 2],
    map: for<'a> fn(&'a Budget) -> Option<&'a Map>,
    residual: fn(&Closure) -> &Residual,
}

const FLUX: Kind = Kind {
    name: "energy-flux",
    title: "Energy flux J(x, t), towards +x",
    shows: "Power through each contact, positive towards +x. Look for the leading pulse, and for what \
            comes back behind it.",
    roles: [Role::Position, Role::Time],
    map: |budget| Some(&budget.flux_map),
    residual: |closure| &closure.real_space,
};

const POWER_FLOW: Kind = Kind {
    name: "power-flow",
    title: "Power flow P(f) through each contact",
    shows: "Energy that passes each contact at each frequency. Where the top of the picture fades along \
            x, high frequencies do not pass. The dashed line is the band edge.",
    roles: [Role::Position, Role::Frequency],
    map: |budget| Some(&budget.frequency.as_ref()?.map),
    residual: |closure| &closure.frequency,
};

const SPECTRUM: Kind = Kind {
    name: "energy-spectrum",
    title: "Energy spectrum E(k, t)",
    shows: "Energy of motion and of contacts at each wavenumber. The dashed line is the band edge.",
    roles: [Role::Wavenumber, Role::Time],
    map: |budget| Some(&budget.wavenumber.as_ref()?.energy_map),
    residual: |closure| &closure.wavenumber,
};

const SPECTRAL_FLUX: Kind = Kind {
    name: "spectral-flux",
    title: "Spectral flux Π(k, t), towards high k",
    shows: "Power that passes from below k to above it: positive towards high k.",
    roles: [Role::Wavenumber, Role::Time],
    map: |budget| Some(&budget.wavenumber.as_ref()?.flux_map),
    residual: |closure| &closure.wavenumber,
};

const SCALE_FLUX: Kind = Kind {
    name: "scale-flux",
    title: "Scale flux Π_l(x, t)",
    shows: "Power that leaves the scales larger than l, where it does so; grey where the filter does \
            not fit into the chain.",
    roles: [Role::Position, Role::Time],
    map: |budget| budget.scales.as_ref()?.flux_map.as_ref(),
    residual: |closure| &closure.scale,
};

/// The figures in the order of reading.
pub(super) fn figures(budgets: &[Named]) -> Vec<FigureLayout> {
    let figures = [
        views(budgets),
        maps(budgets, &FLUX),
        Some(energies(budgets)),
        modes(budgets),
        Some(passed(budgets)),
    ];
    let others = [&POWER_FLOW, &SPECTRUM, &SPECTRAL_FLUX, &SCALE_FLUX];
    let others = others.map(|kind| maps(budgets, kind));
    let mut figures: Vec<FigureLayout> = figures.into_iter().chain(others).flatten().collect();
    for figure in &mut figures {
        figure.is_on_page_only |= budgets.len() > 1 && figure.name != "views";
    }
    figures
}

fn figure(
    name: &'static str,
    title: impl Into<String>,
    rows: Vec<PlotRow>,
    notes: Vec<String>,
) -> FigureLayout {
    FigureLayout {
        name,
        title: title.into(),
        rows,
        notes,
        ..FigureLayout::default()
    }
}

/// What a balance closes to, of each budget of which it is known.
fn residuals(budgets: &[Named], of: fn(&Closure) -> &Residual) -> Vec<String> {
    let residuals = budgets.iter().filter_map(|(_, budget)| {
        let value = of(&budget.closure).value()?;
        Some(format!("balance closes to {value:.1e}"))
    });
    residuals.collect()
}

/// Maps of one kind beside each other; `None` where no budget has one.
fn maps(budgets: &[Named], kind: &Kind) -> Option<FigureLayout> {
    let found = budgets.iter();
    let found = found.filter_map(|(name, budget)| Some((*name, *budget, (kind.map)(budget)?)));
    let found: Vec<(&str, &Budget, &Map)> = found.collect();
    let maps = || found.iter().map(|(_, _, map)| *map);
    let signed = matches!(maps().next()?.reduction, Reduction::Extreme { .. });
    let colors = match signed {
        // What happens at the striker would hide the rest.
        true => Colors::about_zero(ordinary(maps())),
        false => Colors::Powers,
    };
    let is_alone = budgets.len() == 1;
    let charts = found.iter().map(|(name, budget, map)| {
        let frequency = budget.frequency.as_ref().map(|flow| flow.edge);
        let wavenumber = budget.wavenumber.as_ref().map(|found| found.edge);
        let edge = |role: Role, at: Option<f64>| {
            at.filter(|edge| edge.is_finite() && kind.roles.contains(&role))
        };
        let marks = edge(Role::Wavenumber, wavenumber).map(|edge| Mark::new(edge, "band edge"));
        let levels = edge(Role::Frequency, frequency).map(|edge| Level::new(edge, "band edge"));
        Chart {
            title: if is_alone { "" } else { *name }.into(),
            caption: kind.shows.into(),
            colors: colors.clone(),
            shared: (!is_alone).then(|| magnitudes(maps())),
            roles: kind.roles.map(Some),
            second: Some(("k a / π".to_owned(), budget.pitch / PI)),
            marks: marks.into_iter().collect(),
            levels: levels.into_iter().collect(),
            ..Chart::of_map(map)
        }
    });
    let scales = found[0].1.scales.as_ref();
    let scales = scales.filter(|_| kind.name == "scale-flux");
    let title = scales.map_or(kind.title.to_owned(), |found| {
        let of = found.scales.iter().find(|of| of.scale == found.map_scale);
        let cutoff = of.map_or(f64::NAN, |of| of.cutoff_wavenumber);
        let scale = found.map_scale;
        format!(
            "{} at l = {scale:.4} (gain 1/2 at k = {cutoff:.3})",
            kind.title
        )
    });
    let row = PlotRow::of(charts).high(TALL);
    Some(figure(
        kind.name,
        title,
        vec![row],
        residuals(budgets, kind.residual),
    ))
}

/// What a curve is, its colour, and its points of a budget that has them.
type Curve<'a> = (&'a str, usize, &'a dyn Fn(&Budget) -> Option<Points>);

/// A chart around zero of curves: one colour for each quantity, the second budget's dashed.
fn chart(
    budgets: &[Named],
    caption: &str,
    (x_label, role): (String, Role),
    y_label: String,
    curves: &[Curve],
) -> Chart {
    let each = curves.iter().flat_map(|curve| {
        let budgets = budgets.iter().enumerate();
        budgets.map(move |(n, (name, budget))| (curve, n, *name, *budget))
    });
    let series = each.filter_map(|((what, colour, of), n, name, budget)| {
        let label = match budgets.len() {
            1 => (*what).to_owned(),
            _ => format!("{name}: {what}"),
        };
        let look = if n == 0 { Look::Line } else { Look::Dashed };
        Some(Series::line(label, *colour, of(budget)?).with(look))
    });
    let chart = Chart::of("", x_label, y_label, series.collect());
    let points = || chart.series.iter().flat_map(|series| &series.points);
    Chart {
        caption: caption.into(),
        x: extent(points().map(|point| point.0)),
        y: around(points().map(|point| point.1)),
        roles: [Some(role), None],
        ..chart
    }
}

fn over(x: &[f64], y: impl IntoIterator<Item = f64>) -> Points {
    x.iter().copied().zip(y).collect()
}

/// Motion, contacts, losses and input over time.
fn energies(budgets: &[Named]) -> FigureLayout {
    let units = &budgets[0].1.units;
    let any = |budget: &Budget, values: &[f64]| {
        let is_any = values.iter().any(|value| *value != 0.0);
        is_any.then(|| over(&budget.time, values.iter().copied()))
    };
    let caption =
        "What the chain holds, in motion and in contacts, what it has lost, and what was put in.";
    let (time, energy) = ((units.time(), Role::Time), units.energy("energy"));
    let curves: [Curve; 5] = [
        ("in the chain", BLACK, &|b| {
            Some(over(&b.time, b.energies()))
        }),
        ("of motion", BLUE, &|b| any(b, &b.kinetic)),
        ("of contacts", VERMILLION, &|b| any(b, &b.contact)),
        ("lost", GREEN, &|b| any(b, &b.lost)),
        ("put in", PURPLE, &|b| any(b, &b.input)),
    ];
    let rows = vec![PlotRow::of([chart(
        budgets, caption, time, energy, &curves,
    )])];
    figure("energies", "Energy over time", rows, Vec::new())
}

/// By how many normal modes the energy is shared over time, and by how many in equilibrium; `None` without modes.
fn modes(budgets: &[Named]) -> Option<FigureLayout> {
    let (_, first) = budgets.iter().find(|(_, budget)| budget.modes.is_some())?;
    let caption = "exp(S), S the entropy of the shares of the normal modes: 1 where one mode holds all of it. Beside it \
                   the mean of a chain in equilibrium.";
    let curves: [Curve; 2] = [
        ("modes", BLUE, &|budget| {
            let shared = budget.modes.as_ref()?.entropy.iter();
            Some(over(&budget.time, shared.map(|entropy| entropy.exp())))
        }),
        ("in equilibrium", VERMILLION, &|budget| {
            let equilibrium = budget.modes.as_ref()?.equilibrium.exp();
            let ends = [*budget.time.first()?, *budget.time.last()?];
            let is_known = equilibrium.is_finite();
            is_known.then(|| over(&ends, [equilibrium; 2]))
        }),
    ];
    let time = (first.units.time(), Role::Time);
    let chart = chart(budgets, caption, time, "modes".into(), &curves);
    let rows = vec![PlotRow::of([chart.logarithmic()])];
    Some(FigureLayout {
        is_on_page_only: true,
        ..figure("modes", "Modes that share the energy", rows, Vec::new())
    })
}

fn at_contacts(budget: &Budget, values: &[f64]) -> Points {
    let place = |j: usize| budget.pitch * (j as f64 + 0.5);
    let values = values.iter().enumerate();
    values.map(|(j, &value)| (place(j), value)).collect()
}

/// Energy passed by the end through each contact, in either band, and what stayed behind.
fn passed(budgets: &[Named]) -> FigureLayout {
    let units = &budgets[0].1.units;
    let band = |b: &Budget, of: fn(&FrequencyFlow) -> &Vec<f64>| {
        Some(at_contacts(b, of(b.frequency.as_ref()?)))
    };
    let low = match &budgets[0].1.frequency {
        Some(flow) => format!("low band (up to {:.3})", flow.edge),
        None => String::new(),
    };
    let curves: [Curve; 4] = [
        ("passed by the end", BLACK, &|b| {
            Some(at_contacts(b, &b.passed))
        }),
        (&low, BLUE, &|b| band(b, |flow| &flow.low)),
        ("high band", VERMILLION, &|b| band(b, |flow| &flow.high)),
        ("held behind at the end", GREEN, &|b| {
            Some(at_contacts(b, &b.left_behind))
        }),
    ];
    let caption = "Energy that has passed each contact by the end of the record, split at the band edge, and \
                   what the bodies behind it hold.";
    let (x, y) = ((units.position(), Role::Position), units.energy("energy"));
    let rows = vec![PlotRow::of([chart(budgets, caption, x, y, &curves)])];
    let notes = residuals(budgets, |closure| &closure.frequency);
    figure("energy-passed", "Energy passed along x", rows, notes)
}

/// Energy that has passed from low to high k, out of the scales larger than l, and through x, as
/// shares of the largest energy; `None` without a budget over wavenumbers.
fn views(budgets: &[Named]) -> Option<FigureLayout> {
    let (_, first) = budgets.iter().find(|(_, of)| of.wavenumber.is_some())?;
    let units = &first.units;
    let shares = |budget: &Budget, values: &[f64]| -> Vec<f64> {
        values.iter().map(|value| value / budget.scale).collect()
    };
    let over_k = |budget: &Budget, flux: fn(&WavenumberBudget) -> &Vec<f64>| {
        let found = budget.wavenumber.as_ref()?;
        Some(over(&found.wavenumber, shares(budget, flux(found))))
    };
    let fluxes: [Curve; 3] = [
        ("over k, whole record", BLACK, &|b| {
            over_k(b, |found| &found.integrated_flux)
        }),
        ("over k, second half", BLUE, &|b| {
            over_k(b, |found| &found.late_flux)
        }),
        ("over 2π/l", SKY, &|budget| {
            let found = budget.scales.as_ref()?;
            let k: Vec<f64> = found.scales.iter().map(|of| 2.0 * PI / of.scale).collect();
            Some(over(&k, shares(budget, &found.integrated_flux)))
        }),
    ];
    let passed: [Curve; 1] = [("passed x", BLUE, &|budget| {
        Some(at_contacts(budget, &shares(budget, &budget.passed)))
    })];
    let caption = "Net energy that has passed k towards higher k, as a share of the largest energy: over the \
                   whole record, and over its second half, when the impact is taken up. Beside it what has left \
                   the scales larger than l for smaller ones, where the filter fits into the chain.";
    let k = (units.wavenumber(), Role::Wavenumber);
    let y = "passed to higher k, or smaller scales (share of the energy)";
    let along_k = chart(budgets, caption, k, y.into(), &fluxes);
    let caption = "Energy that has passed x by the end, as a share of the largest energy.";
    let x = (units.position(), Role::Position);
    let y = "passed through x (share of the energy)";
    let along_x = chart(budgets, caption, x, y.into(), &passed);
    let charts = [(along_k, "to higher wavenumber"), (along_x, "along x")];
    let rows = charts.map(|(chart, title)| {
        PlotRow::of([Chart {
            title: title.into(),
            x: 0.0..chart.x.end,
            levels: vec![Level::zero()],
            ..chart
        }])
    });
    let note = "over k, second half: when the impact is taken up; over l: where the filter fits into the chain";
    let title = "Where the energy went";
    Some(figure("views", title, rows.into(), vec![note.into()]))
}
