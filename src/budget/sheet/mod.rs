//! What a budget found, and how two differ.

mod numbers;
mod pictures;
mod table;

use serde_json::{Value, json};

use super::measured::MeasuredReport;
use super::{Budget, Closure, Direction, FrequencyFlow, ModeBudget, Residual, WavenumberBudget};
use crate::measure::cycles_per;
use crate::sheet::{Describe, FigureLayout, Sheet, error_size, number};

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

const DEFINITIONS: &str = "\
    J(x, t): Power through each contact, positive towards +x.
    E(k, t): Energy of motion and of contacts at a wavenumber, both signs of k in one. An impact starts with E(k) \
        flat, so that early flux towards low k is real.
    Π(k, t): Power that passes from below k to above.
    P(f): Power flow through a contact by frequency: it sums to the energy passed, may be negative in a bin, and is \
        large at f = 0.
    Π_l(x, t): Power that leaves the scales larger than l at a place. Near the ends, where the filter does not fit \
        into the chain, it is undefined. Its split is not that over k, since the energy of contacts is not quadratic.
    Residual: The largest difference, over all samples, between what an energy changed by and the integral of its \
        rate, relative to the largest energy of the chain.
    Colours about zero: On the linear scale they end where one cell in two hundred is beyond: what happens at the \
        striker would hide the rest.";

impl Describe for Budget {
    fn describe(&self) -> Sheet<'_> {
        Budget::describe(self, None)
    }

    fn figures(&self) -> Vec<FigureLayout> {
        pictures::figures(&[("", self)])
    }
}

/// Two budgets with their names.
#[derive(Debug, Clone)]
pub struct ComparedBudgets {
    pub both: [(String, Budget); 2],
    /// Those of their files.
    pub summaries: [Value; 2],
}

impl Describe for ComparedBudgets {
    /// The numbers of both and their difference.
    fn describe(&self) -> Sheet<'_> {
        let [first, second] = &self.summaries;
        let [(name, _), (other, of)] = &self.both;
        let mut tables = table::tables(&[(&**name, first), (other, second)], &of.units);
        tables[0].is_fact = true;
        let mut sheet = Sheet {
            version: 2,
            about: "two chains; pictures of one kind share their colour scale".into(),
            answer: difference_in_words(&self.both),
            tables,
            ..Sheet::of("compare", "Two energy budgets", DEFINITIONS)
        };
        let difference = table::difference(first, second);
        sheet.numbers(json!({ "first": first, "second": second, "difference": difference }));
        sheet
    }

    fn figures(&self) -> Vec<FigureLayout> {
        pictures::figures(&self.both.each_ref().map(|(name, of)| (&**name, of)))
    }
}

impl Budget {
    /// Answer, facts, warnings, numbers and tables; arrays are large and come in blocks. A measured field has a report
    /// of its noise, errors and momenta.
    pub fn describe(&self, measured: Option<&MeasuredReport>) -> Sheet<'static> {
        let numbers = numbers::of(self);
        let mut sheet = Sheet {
            version: 2,
            about: "where the energy of the chain goes, with the residual of each balance".into(),
            answer: self.answer(),
            tables: table::tables(&[("value", &numbers)], &self.units),
            ..Sheet::of("budget", "Energy budget", DEFINITIONS)
        };
        self.energy(&mut sheet);
        if let Some(found) = &self.wavenumber {
            self.over_wavenumbers(&mut sheet, found);
        }
        if let Some(flow) = &self.frequency {
            self.over_frequencies(&mut sheet, flow);
        }
        self.closure(&mut sheet);
        if let Some(modes) = &self.modes {
            self.over_modes(&mut sheet, modes);
        }
        sheet.numbers(numbers);
        if let Some(report) = measured {
            self.measurement(&mut sheet, report);
            sheet.numbers(json!({ "measured": report }));
        }
        sheet
    }

    /// Where most of the energy passes.
    fn answer(&self) -> String {
        let Some(most) = self.largest_passage() else {
            return "its energies balance; no passage over wavenumbers is computed".into();
        };
        let is_measured = self.errors.is_some();
        let least = if is_measured { 2.0 } else { 1.0 } * most.error;
        let at = self.units.at_wavenumber(most.wavenumber);
        if most.share.abs() <= least {
            return format!(
                "no passage over wavenumbers is resolved: the largest, at {at}, is within its error"
            );
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
            false => format!(", of which {late:.1} % in the second half of the run"),
        };
        format!(
            "{:.1}{error} % of the energy passes {at} to {towards} wavenumbers (net){then}",
            100.0 * most.share.abs()
        )
    }

    fn energy(&self, sheet: &mut Sheet) {
        let last = self.time.len() - 1;
        let energy = |i: usize| self.kinetic[i] + self.contact[i];
        let unit = behind(self.units.energy.as_deref());
        let mut text = format!(
            "{}{unit} at the start, {}{unit} at the end",
            within(energy(0), self.error("total_energy", 0)),
            within(energy(last), self.error("total_energy", last))
        );
        for (what, value, error) in [
            ("lost", self.lost[last], self.error("lost_energy", last)),
            ("put in", self.input[last], None),
        ] {
            if value != 0.0 {
                text += &format!(", {}{unit} {what}", within(value, error));
            }
        }
        sheet.fact("energy", text);
    }

    fn over_wavenumbers(&self, sheet: &mut Sheet, found: &WavenumberBudget) {
        let (Some(passed), Some(direction)) = (found.passed_edge(), self.direction()) else {
            return;
        };
        let edge = self.units.at_wavenumber(found.edge);
        let (share, error) = (passed / self.scale, found.passed_error / self.scale);
        let within = match self.errors.is_some() || error >= SEEN {
            true => format!(" \u{b1} {:.3}", 100.0 * error),
            false => String::new(),
        };
        let direction = match direction {
            Direction::None | Direction::Unresolved => {
                ", net: within its error, so that no direction is resolved"
            }
            Direction::TowardsHighK => " to higher wavenumbers",
            Direction::TowardsLowK => " to lower wavenumbers",
        };
        let text = format!(
            "{:.3}{within} % of it has passed {edge}{direction}",
            100.0 * share.abs()
        );
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
        let error = |part: usize| self.error("between", first + part);
        let energy = behind(self.units.energy.as_deref());
        let frequency = behind(self.units.time.as_deref().map(cycles_per).as_deref());
        let text = format!(
            "through the last contact by the end, less what passed the first: {}{energy} up to {}{frequency}, \
             {}{energy} above; {}{energy} is lost or still between them",
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
        let mut text = format!(
            "the energy is shared by {} of {count} modes at the end",
            number(found.effective_modes(last))
        );
        for (entropy, when) in [
            (found.entropy[0], "at the start"),
            (found.equilibrium, "in equilibrium"),
        ] {
            if entropy.is_finite() {
                text += &format!(", by {} {when}", number(entropy.exp()));
            }
        }
        if let Some(time) = found.equipartition {
            let unit = behind(self.units.time.as_deref());
            text += &format!(", first as in equilibrium at {}{unit}", number(time));
        }
        sheet.fact("modes", text);
        sheet.definitions.push([
            "Modes",
            "Energies of the normal modes of the chain, linearized about its static state, without the energy that the law \
             adds. Shared by exp(S) modes, S the entropy of the shares; in equilibrium S is 1/2 + 1/3 + ... + 1/N on average.",
        ]);
    }

    fn closure(&self, sheet: &mut Sheet) {
        let closure = &self.closure;
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
            let text = format!("{} of the energy", closed.join(", "));
            sheet.fact("balances close to", text);
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
        for warning in &report.warnings {
            let (said, advice) = warning.words();
            sheet.warn(said, advice);
        }
    }
}

/// How far apart two runs are: by what passes between wavenumbers.
fn difference_in_words(both: &[(String, Budget); 2]) -> String {
    let [Some(a), Some(b)] = both.each_ref().map(|(_, of)| of.largest_passage()) else {
        return "no passage over wavenumbers is computed of both".into();
    };
    let percent = |share: f64| format!("{:.1} %", 100.0 * share.abs());
    let passes = |share: f64| {
        let towards = if share < 0.0 { "lower" } else { "higher" };
        format!("{} to {towards} wavenumbers", percent(share))
    };
    format!(
        "{} of the energy apart: {} passes, and {} (net)",
        percent(b.share - a.share),
        passes(a.share),
        passes(b.share)
    )
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
