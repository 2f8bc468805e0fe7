//! Pages of one budget, or of two to compare.

use maud::{Markup, html as markup};

use super::budget_pictures;
use crate::budget::{Budget, Closure, Curves, Direction, Residual};
use crate::plot::Style;
use crate::report::page::{self, Page, in_powers};
use crate::report::percent;

/// The page of one budget; maps have the colours of `style`.
pub fn budget_html(name: &str, budget: &Budget, style: &Style) -> String {
    page_of(
        name.to_owned(),
        "Where the energy of the chain goes, with the residual of each balance.",
        &[(name, budget)],
        style,
    )
}

/// The page of two budgets: the same pictures on the same scales, and their differences.
pub fn comparison_html(both: [(&str, &Budget); 2], style: &Style) -> String {
    page_of(
        format!("{} and {}", both[0].0, both[1].0),
        "Two chains side by side; pictures of one kind share their colour scale.",
        &both,
        style,
    )
}

fn page_of(title: String, sentence: &str, budgets: &[(&str, &Budget)], style: &Style) -> String {
    let page = Page {
        title,
        sentence: sentence.into(),
        answers: answers(budgets),
        warnings: page::warnings(&[]),
        rows: budget_pictures::of(budgets),
        rest: markup! {
            (page::numbers(tables(budgets)))
            (page::how_to_read(&DEFINITIONS))
        },
        style: *style,
    };
    page.html()
}

type Answer = fn(&Budget) -> Option<String>;

/// The questions that a budget is made for, each with an answer for every budget.
fn answers(budgets: &[(&str, &Budget)]) -> Markup {
    let questions: [(&str, Answer); 4] = [
        ("How much energy passes along the chain?", passes),
        ("Does energy move to higher wavenumber?", direction),
        ("Where is the energy at the end?", held),
        ("Do the balances close?", closes),
    ];
    markup! {
        @for (question, answer) in questions {
            (page::answers(question, budgets
                .iter()
                .filter_map(|(name, budget)| {
                    let name = if budgets.len() > 1 { *name } else { "" };
                    Some((name.to_owned(), answer(budget)?))
                })
                .collect()))
        }
    }
}

fn passes(budget: &Budget) -> Option<String> {
    let middle = budget.passed.get(budget.n_contacts / 2)?;
    let last = budget.passed.last()?;
    let share = |energy: &f64| percent(energy / budget.scale);
    Some(format!(
        "{} of it has passed the middle of the chain by the end of the record, {} the last contact",
        share(middle),
        share(last)
    ))
}

fn held(budget: &Budget) -> Option<String> {
    let last = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
    let put_in = last(&budget.input);
    let all = budget.kinetic[0] + budget.contact[0] + put_in;
    if all <= 0.0 {
        return None;
    }
    let share = |energy: f64| percent(energy / all);
    let mut text = format!(
        "{} in motion, {} in contacts",
        share(last(&budget.kinetic)),
        share(last(&budget.contact))
    );
    if last(&budget.lost) != 0.0 {
        text += &format!(", {} lost", share(last(&budget.lost)));
    }
    let of = match put_in {
        0.0 => "of the energy at the start",
        _ => "of the energy at the start and put in",
    };
    Some(format!("{text}, {of}"))
}

fn closes(budget: &Budget) -> Option<String> {
    let closed: Vec<String> = RESIDUALS
        .iter()
        .filter_map(|(name, of)| {
            Some(format!(
                "{name} {}",
                in_powers(of(&budget.closure).value()?, 1)
            ))
        })
        .collect();
    (!closed.is_empty()).then(|| format!("Residual over the largest energy: {}", closed.join(", ")))
}

type ResidualOf = fn(&Closure) -> &Residual;

const RESIDUALS: [(&str, ResidualOf); 4] = [
    ("in real space", |c| &c.real_space),
    ("over wavenumbers", |c| &c.wavenumber),
    ("over frequencies", |c| &c.frequency),
    ("over scales", |c| &c.scale),
];

/// Energies and residuals, a column a budget, and the difference of two, or the standard errors of a
/// measured one.
fn tables(budgets: &[(&str, &Budget)]) -> Markup {
    let rows = rows(budgets);
    let measured = budgets.len() == 1 && budgets[0].1.errors.is_some();
    markup! {
        div class="scroll" {
            table {
                caption { "Energies and balances" }
                thead {
                    tr {
                        th {}
                        @for (name, _) in budgets { th { (name) } }
                        @if budgets.len() == 2 { th { "second less first" } }
                        @if measured { th { "standard error" } }
                    }
                }
                tbody {
                    @for (name, values, error) in &rows {
                        tr {
                            th { (name) }
                            @for value in values { td { (number(*value)) } }
                            @if let [Some(a), Some(b)] = values[..] { td { (number(Some(b - a))) } }
                            @else if values.len() == 2 { td { "–" } }
                            @if measured { td { (number(*error)) } }
                        }
                    }
                }
            }
            @for (name, budget) in budgets {
                @for (view, reason) in reasons(&budget.closure) {
                    p { (name) ": no balance " (view) ", since " (reason) "." }
                }
            }
        }
    }
}

/// Which way energy has passed between low and high k, where that is known.
fn direction(budget: &Budget) -> Option<String> {
    let found = budget.wavenumber.as_ref()?;
    let unit = match &budget.units.length {
        Some(unit) => format!("rad/{unit}"),
        None => "rad per site".into(),
    };
    let edge = format!("{} {unit}", number(Some(found.edge)));
    let share = found.passed_edge()? / budget.scale;
    let share = format!(
        "{} ± {}",
        number(Some(share)),
        in_powers(found.passed_error.value() / budget.scale, 1)
    );
    Some(match found.direction()? {
        Direction::None => format!(
            "No energy has passed between the wavenumbers below and above {edge}, net (share {share}, \
             which is numerical error)"
        ),
        Direction::Unresolved => format!(
            "The net share of the energy that has passed k = {edge} is {share}: its direction is \
             not resolved"
        ),
        direction => format!(
            "Energy has passed k = {edge} {}, net (share {share})",
            direction.name()
        ),
    })
}

/// The numbers of two budgets, as a table of text: name, first, second, and second less first.
pub fn comparison_rows(both: [(&str, &Budget); 2]) -> Vec<[String; 4]> {
    let head = [both[0].0, both[1].0].map(str::to_owned);
    let [first, second] = head;
    let mut table = vec![[String::new(), first, second, "second less first".into()]];
    for (name, values, _) in rows(&both) {
        let difference = match values[..] {
            [Some(a), Some(b)] => Some(b - a),
            _ => None,
        };
        table.push([
            name,
            number(values[0]),
            number(values[1]),
            number(difference),
        ]);
    }
    table
}

/// Name, a value a budget, and the standard error of the first.
type Row = (String, Vec<Option<f64>>, Option<f64>);

fn rows(budgets: &[(&str, &Budget)]) -> Vec<Row> {
    let erring = |name: &str, value: &dyn Fn(&Budget) -> Option<f64>, error: Option<f64>| {
        let values = budgets.iter().map(|(_, budget)| value(budget));
        (name.to_owned(), values.collect::<Vec<_>>(), error)
    };
    let row = |name: &str, value: &dyn Fn(&Budget) -> Option<f64>| erring(name, value, None);
    let first = budgets[0].1;
    let error_of = |of: &dyn Fn(&Curves) -> Option<f64>| of(first.errors.as_deref()?);
    let share_error = || {
        first.errors.as_ref()?;
        Some(first.wavenumber.as_ref()?.passed_error.value() / first.scale)
    };
    let last = |values: &[f64]| values.last().copied();
    let energy = |what: &str| first.units.energy(what);
    let mut rows = vec![
        erring(
            &energy("energy at the start"),
            &|b| Some(b.kinetic[0] + b.contact[0]),
            error_of(&|e| e.energy.first().copied()),
        ),
        erring(
            &energy("of motion, at the end"),
            &|b| last(&b.kinetic),
            error_of(&|e| last(&e.kinetic)),
        ),
        erring(
            &energy("of contacts, at the end"),
            &|b| last(&b.contact),
            error_of(&|e| last(&e.contact)),
        ),
        erring(
            &energy("lost"),
            &|b| last(&b.lost),
            error_of(&|e| last(&e.lost)),
        ),
        row(&energy("put in"), &|b| last(&b.input)),
        erring(
            &energy("passed the middle"),
            &|b| b.passed.get(b.n_contacts / 2).copied(),
            error_of(&|e| e.passed.get(first.n_contacts / 2).copied()),
        ),
        erring(
            "share passed from low to high k (net)",
            &|b| {
                let found = b.wavenumber.as_ref()?;
                Some(found.passed_edge()? / b.scale)
            },
            share_error(),
        ),
    ];
    for (name, of) in RESIDUALS {
        rows.push(row(&format!("residual {name}"), &|b| {
            of(&b.closure).value()
        }));
    }
    rows.push(row(
        "integrated flux at the largest k, over the energy",
        &|b| Some(b.closure.integrated_flux?.at_largest_wavenumber),
    ));
    rows.push(row("integrated flux made two ways, difference", &|b| {
        Some(b.closure.integrated_flux?.two_ways)
    }));
    rows
}

/// Balances that were not made, and why.
fn reasons(closure: &Closure) -> Vec<(&'static str, &str)> {
    let named = RESIDUALS.iter();
    named
        .filter_map(|(view, of)| Some((*view, of(closure).reason()?)))
        .collect()
}

fn number(value: Option<f64>) -> String {
    match value.filter(|value| value.is_finite()) {
        None => "–".into(),
        Some(0.0) => "0".into(),
        Some(value) if (1e-3..1e5).contains(&value.abs()) => {
            format!("{value:.6}").replace('-', "−")
        }
        Some(value) => in_powers(value, 3),
    }
}

const DEFINITIONS: [(&str, &str); 7] = [
    (
        "J(x, t)",
        "Power through each contact, positive towards +x.",
    ),
    (
        "E(k, t)",
        "Energy of motion and of contacts at a wavenumber, both signs of k in one. An impact starts \
         with E(k) flat, so that early flux towards low k is real.",
    ),
    ("Π(k, t)", "Power that passes from below k to above."),
    (
        "P(f)",
        "Power flow through a contact by frequency: it sums to the energy passed, may be negative in \
         a bin, and is large at f = 0.",
    ),
    (
        "Π_l(x, t)",
        "Power that leaves the scales larger than l at a place. Near the ends, where the filter does \
         not fit into the chain, it is undefined. Its split is not that over k, since the energy of \
         contacts is not quadratic.",
    ),
    (
        "Residual",
        "The largest difference, over all samples, between what an energy changed by and the integral \
         of its rate, relative to the largest energy of the chain.",
    ),
    (
        "Colours about zero",
        "On the linear scale they end where one cell in two hundred is beyond: what happens at the \
         striker would hide the rest.",
    ),
];
