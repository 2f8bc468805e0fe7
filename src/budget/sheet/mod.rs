//! What a budget found, and how two differ.

mod numbers;
mod table;

use serde_json::{Value, json};

use super::measured::{MeasuredReport, MeasuredWarning};
use super::{
    Budget, Closure, Direction, FrequencyFlow, Integration, ModeBudget, PassedError, Residual,
    ScaleBudget, WavenumberBudget,
};
use crate::measure::cycles_per;
use crate::sheet::{Sheet, Warning, error_size, number, percent};

/// Coefficients that are doubted one by one.
const SHOWN: usize = 3;

/// Errors of shares from which on the digits printed do not hold.
const SEEN: f64 = 5e-6;

type ResidualOf = fn(&Closure) -> &Residual;

/// Name in files, name in words, and what it is.
const RESIDUALS: [(&str, &str, ResidualOf); 4] = [
    ("real_space", "real space", |c| &c.real_space),
    ("wavenumber", "wavenumber", |c| &c.wavenumber),
    ("frequency", "frequency", |c| &c.frequency),
    ("scale", "scale", |c| &c.scale),
];

const DEFINITIONS: [[&str; 2]; 7] = [
    [
        "J(x, t)",
        "Power through each contact, positive towards +x.",
    ],
    [
        "E(k, t)",
        "Energy of motion and of contacts at a wavenumber, both signs of k in one. An impact starts with E(k) flat, so \
         that early flux towards low k is real.",
    ],
    ["Π(k, t)", "Power that passes from below k to above."],
    [
        "P(f)",
        "Power flow through a contact by frequency: it sums to the energy passed, may be negative in a bin, and is large \
         at f = 0.",
    ],
    [
        "Π_l(x, t)",
        "Power that leaves the scales larger than l at a place. Near the ends, where the filter does not fit into the \
         chain, it is undefined. Its split is not that over k, since the energy of contacts is not quadratic.",
    ],
    [
        "Residual",
        "The largest difference, over all samples, between what an energy changed by and the integral of its rate, \
         relative to the largest energy of the chain.",
    ],
    [
        "Colours about zero",
        "On the linear scale they end where one cell in two hundred is beyond: what happens at the striker would hide the \
         rest.",
    ],
];

impl Budget {
    /// Answer, facts, warnings, numbers and tables; arrays are large and come in blocks. A measured field has a report
    /// of its noise, errors and momenta.
    pub fn describe(&self, measured: Option<&MeasuredReport>) -> Sheet<'static> {
        let mut sheet = Sheet {
            name: "budget",
            version: 2,
            title: "Energy budget".into(),
            about: "where the energy of the chain goes, with the residual of each balance".into(),
            answer: self.answer(),
            tables: vec![
                table::energies(&[("value", self)]),
                table::balances(&[("value", self)]),
            ],
            definitions: DEFINITIONS.to_vec(),
            ..Sheet::default()
        };
        self.energy(&mut sheet);
        if let Some(found) = &self.wavenumber {
            self.over_wavenumbers(&mut sheet, found);
        }
        if let Some(flow) = &self.frequency {
            self.over_frequencies(&mut sheet, flow);
        }
        self.closure(&mut sheet);
        if let Some(scales) = &self.scales {
            self.over_scales(&mut sheet, scales);
        }
        if let Some(modes) = &self.modes {
            self.over_modes(&mut sheet, modes);
        }
        sheet.numbers(numbers::of(self));
        if let Some(report) = measured {
            self.measurement(&mut sheet, report);
            sheet.numbers(json!({ "measured": report }));
        }
        sheet
    }

    /// Two budgets, with the numbers of both; `summaries` are those of the files.
    pub fn compare(both: [(&str, &Budget); 2], summaries: [Value; 2]) -> Sheet<'static> {
        let [first, second] = summaries;
        let mut energies = table::energies(&both);
        energies.is_fact = true;
        let mut sheet = Sheet {
            name: "compare",
            version: 2,
            title: "Two energy budgets".into(),
            about: "two chains; pictures of one kind share their colour scale".into(),
            answer: difference_in_words(both),
            tables: vec![energies, table::balances(&both)],
            definitions: DEFINITIONS.to_vec(),
            ..Sheet::default()
        };
        let difference = table::difference(&first, &second);
        sheet.numbers(json!({ "first": first, "second": second, "difference": difference }));
        sheet
    }

    /// Where most of the energy passes.
    fn answer(&self) -> String {
        let Some(most) = self.largest_passage() else {
            let lost = self.lost[self.time.len() - 1];
            return match lost > 0.0 && self.scale > 0.0 {
                true => format!("{:.3} % of the energy is lost", 100.0 * lost / self.scale),
                false => "its energies balance; no passage over wavenumbers is computed".into(),
            };
        };
        let is_measured = self.errors.is_some();
        let least = if is_measured {
            2.0 * most.error
        } else {
            most.error
        };
        let at = self.wavenumber_at(most.wavenumber);
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
        // Of a struck chain most of it is the launch.
        let late = 100.0 * most.late * most.share.signum();
        let then = match is_measured {
            true => String::new(),
            false if late < 0.0 => format!(
                ", of which {:.1} % come back in the second half of the run",
                -late
            ),
            false => format!(", of which {late:.1} % in the second half of the run"),
        };
        format!(
            "{:.1}{error} % of the energy passes {at} to {towards} wavenumbers (net){then}",
            100.0 * most.share.abs()
        )
    }

    /// `k = 12.5 rad/m`.
    fn wavenumber_at(&self, k: f64) -> String {
        let unit = match &self.units.length {
            Some(unit) => format!("rad/{unit}"),
            None => "rad per site".into(),
        };
        format!("k = {} {unit}", number(k))
    }

    fn energy(&self, sheet: &mut Sheet) {
        let last = self.time.len() - 1;
        let energy = |i: usize| self.kinetic[i] + self.contact[i];
        let unit = behind(self.units.energy.as_deref());
        let errors = self.errors.as_deref();
        let mut text = format!(
            "{}{unit} at the start, {}{unit} at the end",
            within(energy(0), errors.map(|e| e.energy[0])),
            within(energy(last), errors.map(|e| e.energy[last]))
        );
        for (what, value, error) in [
            ("lost", self.lost[last], errors.map(|e| e.lost[last])),
            ("put in", self.input[last], None),
        ] {
            if value != 0.0 {
                text += &format!(", {}{unit} {what}", within(value, error));
            }
        }
        sheet.fact("energy", text);
        let all = energy(0) + self.input[last];
        if all > 0.0 {
            let share = |energy: f64| percent(energy / all);
            let text = format!(
                "{} in motion, {} in contacts, of the energy at the start and put in",
                share(self.kinetic[last]),
                share(self.contact[last])
            );
            sheet.detail("at the end", text);
        }
        if let (Some(middle), Some(end)) =
            (self.passed.get(self.n_contacts / 2), self.passed.last())
        {
            let share = |energy: &f64| percent(energy / self.scale);
            let text = format!(
                "{} has passed the middle of the chain by the end, {} the last contact",
                share(middle),
                share(end)
            );
            sheet.detail("along x", text);
        }
    }

    fn over_wavenumbers(&self, sheet: &mut Sheet, found: &WavenumberBudget) {
        let (Some(passed), Some(direction)) = (found.passed_edge(), found.direction()) else {
            return;
        };
        let edge = self.wavenumber_at(found.edge);
        let (share, error) = (passed / self.scale, found.passed_error.value() / self.scale);
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
                "{percent:.3}{within} % of it has passed {edge}, net: less than twice its error, so no direction is \
                 resolved"
            ),
            Direction::TowardsHighK => {
                format!("{percent:.3}{within} % of it has passed to above {edge}")
            }
            Direction::TowardsLowK => {
                format!("{:.3}{within} % of it has passed to below {edge}", -percent)
            }
        };
        sheet.fact("wavenumber", text);
    }

    fn over_frequencies(&self, sheet: &mut Sheet, flow: &FrequencyFlow) {
        let inner = self.n_contacts.min(self.n_sites.saturating_sub(1));
        if inner <= 1 {
            return;
        }
        let between = flow.between(0, inner - 1);
        // The last of the usual pairs, which are the first of all.
        let first = 3 * if inner == 2 { 0 } else { 2 };
        let error = |part: usize| self.errors.as_deref()?.between.get(first + part).copied();
        let energy = behind(self.units.energy.as_deref());
        let frequency = behind(self.units.time.as_deref().map(cycles_per).as_deref());
        let between_them = match self.lost[self.time.len() - 1] > 0.0 {
            true => "lost or still between them",
            false => "still between them",
        };
        let text = format!(
            "through the last contact by the end, less what passed the first: {}{energy} up to {}{frequency}, \
             {}{energy} above; {}{energy} is {between_them}",
            within(between.low, error(0)),
            number(flow.edge),
            within(between.high, error(1)),
            within(between.behind, error(2))
        );
        sheet.fact("frequency", text);
    }

    fn over_modes(&self, sheet: &mut Sheet, found: &ModeBudget) {
        let last = found.entropy.len() - 1;
        let count = found.frequency.len();
        let shared = |i: usize| number(found.effective_modes(i));
        let even = number(found.equilibrium.exp());
        let when = match found.equipartition {
            Some(time) => format!(
                ", first as in equilibrium, by {even}, at {}{}",
                number(time),
                behind(self.units.time.as_deref())
            ),
            None if found.entropy[0] < found.equilibrium => {
                format!(", never as in equilibrium, by {even}")
            }
            None => String::new(),
        };
        let text = match found.entropy[0].is_nan() {
            true => format!(
                "the energy is shared by {} of {count} modes at the end",
                shared(last)
            ),
            false => format!(
                "the energy is shared by {} of {count} modes at the start, {} at the end{when}",
                shared(0),
                shared(last)
            ),
        };
        sheet.fact("modes", text);
        sheet.definitions.push([
            "Modes",
            "Energies of the normal modes of the chain, linearized about its static state, without the energy that the law \
             adds. Shared by exp(S) modes, S the entropy of the shares; in equilibrium S is 1/2 + 1/3 + ... + 1/N on average.",
        ]);
    }

    fn over_scales(&self, sheet: &mut Sheet, scales: &ScaleBudget) {
        let Some(of) = scales.scales.iter().find(|of| of.scale == scales.map_scale) else {
            return;
        };
        let sigma = of.sigma.map_or("none".into(), number);
        let text = format!(
            "flux mapped at l = {}{} ({:?} filter, sigma {sigma}, gain 1/2 at {})",
            number(of.scale),
            behind(self.units.length.as_deref()),
            of.filter,
            self.wavenumber_at(of.cutoff_wavenumber)
        );
        sheet.detail("scale", text);
    }

    fn closure(&self, sheet: &mut Sheet) {
        let closure = &self.closure;
        if closure.integration == Integration::Samples {
            let text = "rates are integrated over time by the trapezoid rule over the samples: transfers, scale fluxes, \
                        and losses and inputs of wavenumbers";
            sheet.detail("sampled", text);
        }
        if let Some(departure) = closure.departure {
            let text = format!(
                "departs from the record by {} of the energy",
                error_size(departure)
            );
            sheet.detail("stepped anew", text);
        }
        let mut closed = Vec::new();
        for (_, name, of) in RESIDUALS {
            match of(closure) {
                Residual::Closed(value) => closed.push(format!("{name} {}", error_size(*value))),
                Residual::Undefined(reason) => {
                    sheet.detail(format!("{name} balance"), format!("none: {reason}"));
                }
            }
        }
        if !closed.is_empty() {
            sheet.fact(
                "balances close to",
                format!("{} of the energy", closed.join(", ")),
            );
        }
        if let Some(check) = closure.integrated_flux {
            let text = format!(
                "{} of the energy at the largest k, where it is 0; from transfers and from energies it differs by {}",
                error_size(check.at_largest_wavenumber),
                error_size(check.two_ways)
            );
            sheet.detail("integrated flux", text);
        }
    }

    fn measurement(&self, sheet: &mut Sheet, report: &MeasuredReport) {
        let energy = report.energy;
        let text = format!(
            "{}{}, the median over the record of total energy and losses, less the bias of noise",
            within(energy.value, Some(energy.error)),
            behind(self.units.energy.as_deref())
        );
        sheet.fact("energy given", text);
        let (mut coefficients, others): (Vec<_>, Vec<_>) = (report.warnings.iter())
            .partition(|warning| matches!(warning, MeasuredWarning::Coefficient { .. }));
        coefficients.sort_by(|a, b| in_errors(b).total_cmp(&in_errors(a)));
        let more = coefficients.split_off(SHOWN.min(coefficients.len())).len();
        let told = others.into_iter().chain(coefficients);
        sheet
            .warnings
            .extend(told.map(|warning| Warning::new(warning.message(), warning.advice())));
        if more > 0 {
            let text = format!("{more} more contacts likewise: `measured` in summary.json");
            sheet.detail("coefficients", text);
        }
    }
}

impl MeasuredWarning {
    /// What to do about it.
    pub fn advice(&self) -> &'static str {
        match self {
            MeasuredWarning::MomentumOpen { .. }
            | MeasuredWarning::Coefficient { .. }
            | MeasuredWarning::Coefficients { .. } => {
                "check masses, contact law and coefficients of the chain and the gains of the channels, or state how \
                 uncertain they are, and that the contacts just touched at the start"
            }
            MeasuredWarning::BelowNoise { .. } => "leave these contacts out of what is concluded",
            MeasuredWarning::Missing { .. } => {
                "none is needed where the stated error is small enough"
            }
            MeasuredWarning::NoQuietPart { .. } => {
                "record some time before the impact, and state the sample at which it begins"
            }
            MeasuredWarning::CorrelatedNoise { .. } => {
                "look for hum or a filter in the measuring chain"
            }
        }
    }
}

/// How far apart two runs are: by what passes to high wavenumbers, or past the middle.
fn difference_in_words(both: [(&str, &Budget); 2]) -> String {
    let [first, second] = both.map(|(_, budget)| budget);
    if let (Some(a), Some(b)) = (first.largest_passage(), second.largest_passage()) {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share.abs());
        let apart = percent(b.share - a.share);
        let towards = |share: f64| if share < 0.0 { "lower" } else { "higher" };
        let (first, second) = (percent(a.share), percent(b.share));
        let passes = match (towards(a.share), towards(b.share)) {
            (one, other) if one == other => {
                format!("{first} and {second} pass to {one} wavenumbers")
            }
            (one, other) => format!("{first} pass to {one} wavenumbers, {second} to {other} ones"),
        };
        return format!("{apart} of the energy apart: {passes} (net)");
    }
    let passed = |budget: &Budget| budget.passed.get(budget.n_contacts / 2).copied();
    match (passed(first), passed(second)) {
        (Some(a), Some(b)) => format!(
            "{} passes the middle of {}, {} that of {}",
            number(a),
            both[0].0,
            number(b),
            both[1].0
        ),
        _ => "no energy passes".into(),
    }
}

/// How many standard errors a coefficient is off by.
fn in_errors(warning: &MeasuredWarning) -> f64 {
    match warning {
        MeasuredWarning::Coefficient { factor, .. } => (factor.factor - 1.0).abs() / factor.error,
        _ => 0.0,
    }
}

/// A unit behind a number, where there is one.
fn behind(unit: Option<&str>) -> String {
    unit.map_or(String::new(), |unit| format!(" {unit}"))
}

/// A number with its standard error, where it has one.
fn within(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{} \u{b1} {}", number(value), error_size(error)),
        None => number(value),
    }
}
