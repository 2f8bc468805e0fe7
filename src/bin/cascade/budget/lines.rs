//! What a budget found, in lines on the terminal.

use wavecascade::budget::measured::{MeasuredReport, MeasuredWarning};
use wavecascade::budget::{
    Budget, Direction, FrequencyFlow, Integration, PassedError, Residual, ScaleBudget,
    WavenumberBudget,
};

use crate::advice;
use crate::terminal::{self, Lines, error_size, number};

/// Coefficients that are doubted one by one.
const SHOWN: usize = 3;

/// Errors of shares from which on the digits printed do not hold.
const SEEN: f64 = 5e-6;

pub(super) fn of(budget: &Budget, measured: Option<&MeasuredReport>) -> String {
    let mut lines = Lines::new(terminal::width());
    energy(&mut lines, budget);
    if let Some(found) = &budget.wavenumber {
        wavenumber(&mut lines, budget, found);
    }
    if let Some(flow) = &budget.frequency {
        frequency(&mut lines, budget, flow);
    }
    if let Some(scales) = &budget.scales {
        scale(&mut lines, scales);
    }
    closure(&mut lines, budget);
    if let Some(report) = measured {
        measurement(&mut lines, report);
    }
    lines.text
}

fn energy(lines: &mut Lines, budget: &Budget) {
    let last = budget.time.len() - 1;
    let energy = |i: usize| budget.kinetic[i] + budget.contact[i];
    let unit = budget
        .units
        .energy
        .as_deref()
        .map_or(String::new(), |unit| format!(" {unit}"));
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
    lines.line("energy", &text);
}

/// A number with its standard error, where it has one.
fn within(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{} \u{b1} {}", number(value), error_size(error)),
        None => number(value),
    }
}

fn wavenumber(lines: &mut Lines, budget: &Budget, found: &WavenumberBudget) {
    let (Some(passed), Some(direction)) = (found.passed_edge(), found.direction()) else {
        return;
    };
    let edge = number(found.edge);
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
            "none of it has passed k = {edge}, net: a share of {} at a numerical error of {}",
            error_size(share),
            error_size(error)
        ),
        Direction::Unresolved => format!(
            "{percent:.3}{within} % of it has passed k = {edge}, net: less than twice its error, so \
             no direction is resolved"
        ),
        Direction::TowardsHighK => {
            format!("{percent:.3}{within} % of it has passed to above k = {edge}")
        }
        Direction::TowardsLowK => format!(
            "{:.3}{within} % of it has passed to below k = {edge}",
            -percent
        ),
    };
    lines.line("wavenumber", &text);
}

fn frequency(lines: &mut Lines, budget: &Budget, flow: &FrequencyFlow) {
    let inner = budget.n_contacts.min(budget.n_sites.saturating_sub(1));
    if inner > 1 {
        let between = flow.between(0, inner - 1);
        // The last of the usual pairs, which are the first of all.
        let first = 3 * if inner == 2 { 0 } else { 2 };
        let error = |part: usize| budget.errors.as_deref()?.between.get(first + part).copied();
        let text = format!(
            "from the first contact to the last the band up to {} changed by {}, that above by \
             {}, {} stayed behind",
            number(flow.edge),
            within(between.low, error(0)),
            within(between.high, error(1)),
            within(between.behind, error(2))
        );
        lines.line("frequency", &text);
    }
}

fn scale(lines: &mut Lines, scales: &ScaleBudget) {
    let Some(of) = scales.scales.iter().find(|of| of.scale == scales.map_scale) else {
        return;
    };
    let sigma = of.sigma.map_or("none".into(), number);
    let text = format!(
        "flux mapped at l = {} ({:?} filter, sigma {sigma}, gain 1/2 at k = {})",
        number(of.scale),
        of.filter,
        number(of.cutoff_wavenumber)
    );
    lines.line("scale", &text);
}

fn closure(lines: &mut Lines, budget: &Budget) {
    let closure = &budget.closure;
    if closure.integration == Integration::Samples {
        let text = "rates are integrated over time by the trapezoid rule over the samples: \
                    transfers, scale fluxes, and losses and inputs of wavenumbers";
        lines.line("sampled", text);
    }
    if let Some(departure) = closure.departure {
        let text = format!(
            "departs from the record by {} of the energy",
            error_size(departure)
        );
        lines.line("stepped anew", &text);
    }
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
        lines.line(&format!("{name} balance"), &text);
    }
    if let Some(check) = closure.integrated_flux {
        let text = format!(
            "{} of the energy at the largest k, where it is 0; from transfers and from energies it \
             differs by {}",
            error_size(check.at_largest_wavenumber),
            error_size(check.two_ways)
        );
        lines.line("integrated flux", &text);
    }
}

fn measurement(lines: &mut Lines, report: &MeasuredReport) {
    let energy = report.energy;
    let text = format!(
        "{}, the median over the record of total energy and losses, less the bias of noise",
        within(energy.value, Some(energy.error))
    );
    lines.line("energy given", &text);
    let (mut coefficients, others): (Vec<_>, Vec<_>) = (report.warnings.iter())
        .partition(|warning| matches!(warning, MeasuredWarning::Coefficient { .. }));
    coefficients.sort_by(|a, b| in_errors(b).total_cmp(&in_errors(a)));
    let more = coefficients.split_off(SHOWN.min(coefficients.len())).len();
    let mut shown = others.into_iter().chain(coefficients).peekable();
    while let Some(warning) = shown.next() {
        let advice = advice::of_measured(warning);
        let is_repeated = |next: &&MeasuredWarning| advice::of_measured(next) == advice;
        match shown.peek().is_some_and(is_repeated) {
            true => lines.warning(&warning.message(), ""),
            false => lines.warning(&warning.message(), advice),
        }
    }
    if more > 0 {
        let text = format!("{more} more contacts likewise: `measured` in summary.json");
        lines.line("", &text);
    }
}

/// How many standard errors a coefficient is off by.
fn in_errors(warning: &MeasuredWarning) -> f64 {
    match warning {
        MeasuredWarning::Coefficient { factor, .. } => (factor.factor - 1.0).abs() / factor.error,
        _ => 0.0,
    }
}
