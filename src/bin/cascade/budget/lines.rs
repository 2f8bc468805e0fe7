//! What a budget found, in lines on the terminal.

use wavecascade::budget::measured::{MeasuredReport, MeasuredWarning};
use wavecascade::budget::{
    Budget, Direction, FrequencyFlow, Integration, PassedError, Residual, ScaleBudget,
    WavenumberBudget,
};
use wavecascade::measure::cycles_per;

use crate::advice;
use crate::summary::Summary;
use crate::terminal::{error_size, number};

/// Coefficients that are doubted one by one.
const SHOWN: usize = 3;

/// Errors of shares from which on the digits printed do not hold.
const SEEN: f64 = 5e-6;

/// Where the energy went, and what supports it.
pub(super) fn of(subject: &str, budget: &Budget, measured: Option<&MeasuredReport>) -> Summary {
    let mut summary = Summary::new(subject, &answer(budget));
    energy(&mut summary, budget);
    if let Some(found) = &budget.wavenumber {
        wavenumber(&mut summary, budget, found);
    }
    if let Some(flow) = &budget.frequency {
        frequency(&mut summary, budget, flow);
    }
    closure(&mut summary, budget);
    if let Some(scales) = &budget.scales {
        scale(&mut summary, budget, scales);
    }
    if let Some(report) = measured {
        measurement(&mut summary, budget, report);
    }
    summary
}

/// Where most of the energy passes.
fn answer(budget: &Budget) -> String {
    let Some(most) = budget.largest_passage() else {
        let last = budget.time.len() - 1;
        let lost = budget.lost[last];
        return match lost > 0.0 && budget.scale > 0.0 {
            true => format!("{:.3} % of the energy is lost", 100.0 * lost / budget.scale),
            false => "its energies balance; no passage over wavenumbers is computed".into(),
        };
    };
    let is_measured = budget.errors.is_some();
    let least = if is_measured {
        2.0 * most.error
    } else {
        most.error
    };
    let at = wavenumber_at(budget, most.wavenumber);
    if most.share.abs() <= least {
        return match is_measured {
            true => format!(
                "no passage over wavenumbers is resolved: the largest is below twice its error ({at})"
            ),
            false => "no energy passes between wavenumbers".into(),
        };
    }
    let towards = if most.share > 0.0 { "higher" } else { "lower" };
    let error = match is_measured || most.error >= SEEN {
        true => format!(" \u{b1} {:.2}", 100.0 * most.error),
        false => String::new(),
    };
    format!(
        "{:.1}{error} % of the energy passes {at} to {towards} wavenumbers (net)",
        100.0 * most.share.abs()
    )
}

/// `k = 12.5 rad/m`.
fn wavenumber_at(budget: &Budget, k: f64) -> String {
    let unit = match &budget.units.length {
        Some(unit) => format!("rad/{unit}"),
        None => "rad per site".into(),
    };
    format!("k = {} {unit}", number(k))
}

/// A unit behind a number, where there is one.
fn behind(unit: Option<&str>) -> String {
    unit.map_or(String::new(), |unit| format!(" {unit}"))
}

fn energy(summary: &mut Summary, budget: &Budget) {
    let last = budget.time.len() - 1;
    let energy = |i: usize| budget.kinetic[i] + budget.contact[i];
    let unit = behind(budget.units.energy.as_deref());
    let errors = budget.errors.as_deref();
    let mut text = format!(
        "{}{unit} at the start, {}{unit} at the end",
        within(energy(0), errors.map(|e| e.energy[0])),
        within(energy(last), errors.map(|e| e.energy[last]))
    );
    for (what, value, error) in [
        ("lost", budget.lost[last], errors.map(|e| e.lost[last])),
        ("put in", budget.input[last], None),
    ] {
        if value != 0.0 {
            text += &format!(", {}{unit} {what}", within(value, error));
        }
    }
    summary.fact("energy", &text);
}

/// A number with its standard error, where it has one.
fn within(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{} \u{b1} {}", number(value), error_size(error)),
        None => number(value),
    }
}

fn wavenumber(summary: &mut Summary, budget: &Budget, found: &WavenumberBudget) {
    let (Some(passed), Some(direction)) = (found.passed_edge(), found.direction()) else {
        return;
    };
    let edge = wavenumber_at(budget, found.edge);
    let (share, error) = (
        passed / budget.scale,
        found.passed_error.value() / budget.scale,
    );
    let within = match found.passed_error {
        PassedError::Numerical(_) if error < SEEN => String::new(),
        _ => format!(" \u{b1} {:.3}", 100.0 * error),
    };
    let percent = 100.0 * share;
    let text = match direction {
        Direction::None => format!(
            "none of it has passed {edge}, net: a share of {} at a numerical error of {}",
            error_size(share),
            error_size(error)
        ),
        Direction::Unresolved => format!(
            "{percent:.3}{within} % of it has passed {edge}, net: less than twice its error, so \
             no direction is resolved"
        ),
        Direction::TowardsHighK => {
            format!("{percent:.3}{within} % of it has passed to above {edge}")
        }
        Direction::TowardsLowK => {
            format!("{:.3}{within} % of it has passed to below {edge}", -percent)
        }
    };
    summary.fact("wavenumber", &text);
}

fn frequency(summary: &mut Summary, budget: &Budget, flow: &FrequencyFlow) {
    let inner = budget.n_contacts.min(budget.n_sites.saturating_sub(1));
    if inner > 1 {
        let between = flow.between(0, inner - 1);
        // The last of the usual pairs, which are the first of all.
        let first = 3 * if inner == 2 { 0 } else { 2 };
        let error = |part: usize| budget.errors.as_deref()?.between.get(first + part).copied();
        let energy = behind(budget.units.energy.as_deref());
        let frequency = behind(budget.units.time.as_deref().map(cycles_per).as_deref());
        let text = format!(
            "from the first contact to the last the band up to {}{frequency} changed by {}{energy}, that \
             above by {}{energy}, {}{energy} stayed behind",
            number(flow.edge),
            within(between.low, error(0)),
            within(between.high, error(1)),
            within(between.behind, error(2))
        );
        summary.fact("frequency", &text);
    }
}

fn scale(summary: &mut Summary, budget: &Budget, scales: &ScaleBudget) {
    let Some(of) = scales.scales.iter().find(|of| of.scale == scales.map_scale) else {
        return;
    };
    let sigma = of.sigma.map_or("none".into(), number);
    let text = format!(
        "flux mapped at l = {}{} ({:?} filter, sigma {sigma}, gain 1/2 at {})",
        number(of.scale),
        behind(budget.units.length.as_deref()),
        of.filter,
        wavenumber_at(budget, of.cutoff_wavenumber)
    );
    summary.detail("scale", &text);
}

fn closure(summary: &mut Summary, budget: &Budget) {
    let closure = &budget.closure;
    if closure.integration == Integration::Samples {
        let text = "rates are integrated over time by the trapezoid rule over the samples: \
                    transfers, scale fluxes, and losses and inputs of wavenumbers";
        summary.detail("sampled", text);
    }
    if let Some(departure) = closure.departure {
        let text = format!(
            "departs from the record by {} of the energy",
            error_size(departure)
        );
        summary.detail("stepped anew", &text);
    }
    let mut closed = Vec::new();
    for (name, residual) in [
        ("real space", &closure.real_space),
        ("wavenumber", &closure.wavenumber),
        ("frequency", &closure.frequency),
        ("scale", &closure.scale),
    ] {
        let text = match residual {
            Residual::Closed(value) => format!("closes to {} of the energy", error_size(*value)),
            Residual::Undefined(reason) => format!("no balance: {reason}"),
        };
        match residual {
            Residual::Closed(_) => closed.push(format!(
                "{name} {}",
                error_size(residual.value().unwrap_or(0.0))
            )),
            Residual::Undefined(_) => {}
        }
        summary.detail(&format!("{name} balance"), &text);
    }
    let text = format!("{} of the energy", closed.join(", "));
    summary.fact("balances close to", &text);
    if let Some(check) = closure.integrated_flux {
        let text = format!(
            "{} of the energy at the largest k, where it is 0; from transfers and from energies it \
             differs by {}",
            error_size(check.at_largest_wavenumber),
            error_size(check.two_ways)
        );
        summary.detail("integrated flux", &text);
    }
}

fn measurement(summary: &mut Summary, budget: &Budget, report: &MeasuredReport) {
    let energy = report.energy;
    let text = format!(
        "{}{}, the median over the record of total energy and losses, less the bias of noise",
        within(energy.value, Some(energy.error)),
        behind(budget.units.energy.as_deref())
    );
    summary.fact("energy given", &text);
    let (mut coefficients, others): (Vec<_>, Vec<_>) = (report.warnings.iter())
        .partition(|warning| matches!(warning, MeasuredWarning::Coefficient { .. }));
    coefficients.sort_by(|a, b| in_errors(b).total_cmp(&in_errors(a)));
    let more = coefficients.split_off(SHOWN.min(coefficients.len())).len();
    for warning in others.into_iter().chain(coefficients) {
        summary.warning(&warning.message(), advice::of_measured(warning));
    }
    if more > 0 {
        let text = format!("{more} more contacts likewise: `measured` in summary.json");
        summary.detail("coefficients", &text);
    }
}

/// How many standard errors a coefficient is off by.
fn in_errors(warning: &MeasuredWarning) -> f64 {
    match warning {
        MeasuredWarning::Coefficient { factor, .. } => (factor.factor - 1.0).abs() / factor.error,
        _ => 0.0,
    }
}
