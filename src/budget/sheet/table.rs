//! Energies and balances of one budget with its standard errors, or of two with their difference.

use serde_json::{Map, Value, json};

use crate::budget::{Budget, Curves};
use crate::sheet::Table;

/// Name, its value in a budget, and in its standard errors.
type Row = (
    String,
    fn(&Budget) -> Option<f64>,
    fn(&Curves, &Budget) -> Option<f64>,
);

/// Where the energy is, and what has passed.
pub(super) fn energies(budgets: &[(&str, &Budget)]) -> Table {
    let energy = |what: &str| budgets[0].1.units.energy(what);
    fn last(values: &[f64]) -> Option<f64> {
        values.last().copied()
    }
    fn middle(values: &[f64], budget: &Budget) -> Option<f64> {
        values.get(budget.n_contacts / 2).copied()
    }
    let rows: [Row; 7] = [
        (
            energy("energy at the start"),
            |b| Some(b.kinetic[0] + b.contact[0]),
            |e, _| e.energy.first().copied(),
        ),
        (
            energy("of motion, at the end"),
            |b| last(&b.kinetic),
            |e, _| last(&e.kinetic),
        ),
        (
            energy("of contacts, at the end"),
            |b| last(&b.contact),
            |e, _| last(&e.contact),
        ),
        (energy("lost"), |b| last(&b.lost), |e, _| last(&e.lost)),
        (energy("put in"), |b| last(&b.input), |_, _| None),
        (
            energy("passed the middle"),
            |b| middle(&b.passed, b),
            |e, b| middle(&e.passed, b),
        ),
        (
            "share passed from low to high k (net)".into(),
            |b| Some(b.wavenumber.as_ref()?.passed_edge()? / b.scale),
            |_, b| Some(b.wavenumber.as_ref()?.passed_error.value() / b.scale),
        ),
    ];
    table("Energies", budgets, &rows)
}

/// Residuals and checks.
pub(super) fn balances(budgets: &[(&str, &Budget)]) -> Table {
    let rows: [Row; 6] = [
        (
            "residual, real space".into(),
            |b| b.closure.real_space.value(),
            |_, _| None,
        ),
        (
            "residual, wavenumber".into(),
            |b| b.closure.wavenumber.value(),
            |_, _| None,
        ),
        (
            "residual, frequency".into(),
            |b| b.closure.frequency.value(),
            |_, _| None,
        ),
        (
            "residual, scale".into(),
            |b| b.closure.scale.value(),
            |_, _| None,
        ),
        (
            "integrated flux at the largest k, over the energy".into(),
            |b| Some(b.closure.integrated_flux?.at_largest_wavenumber),
            |_, _| None,
        ),
        (
            "integrated flux made two ways, difference".into(),
            |b| Some(b.closure.integrated_flux?.two_ways),
            |_, _| None,
        ),
    ];
    table("Balances", budgets, &rows)
}

fn table(title: &str, budgets: &[(&str, &Budget)], rows: &[Row]) -> Table {
    let first = budgets[0].1;
    let names = budgets.iter().map(|(name, _)| (*name).to_owned());
    let mut head: Vec<String> = [String::new()].into_iter().chain(names).collect();
    head.extend((budgets.len() == 2).then(|| "second less first".into()));
    let errors = first.errors.as_deref().filter(|_| budgets.len() == 1);
    let errors = errors.filter(|errors| rows.iter().any(|row| row.2(errors, first).is_some()));
    head.extend(errors.map(|_| "standard error".into()));
    let rows = rows.iter().map(|(name, value, error)| {
        let values: Vec<_> = budgets.iter().map(|(_, budget)| value(budget)).collect();
        let mut cells = vec![name.clone()];
        cells.extend(values.iter().map(|value| number(*value)));
        if let [a, b] = values[..] {
            cells.push(number(a.zip(b).map(|(a, b)| b - a)));
        }
        cells.extend(errors.map(|errors| number(error(errors, first))));
        cells
    });
    Table {
        title: title.into(),
        head,
        rows: rows.collect(),
        is_fact: false,
    }
}

fn number(value: Option<f64>) -> String {
    match value.filter(|value| value.is_finite()) {
        None => "-".into(),
        Some(0.0) => "0".into(),
        Some(value) if (1e-3..1e5).contains(&value.abs()) => format!("{value:.6}"),
        Some(value) => format!("{value:.3e}"),
    }
}

/// Second less first, for every number that both have under the same name.
pub(super) fn difference(first: &Value, second: &Value) -> Value {
    match (first, second) {
        (Value::Object(a), Value::Object(b)) => {
            let pairs = a.iter();
            let pairs = pairs.filter_map(|(key, a)| Some((key, difference(a, b.get(key)?))));
            let kept = pairs.filter(|(_, value)| !value.is_null());
            let map: Map<_, _> = kept.map(|(key, value)| (key.clone(), value)).collect();
            match map.is_empty() {
                true => Value::Null,
                false => Value::Object(map),
            }
        }
        (Value::Number(a), Value::Number(b)) => match (a.as_f64(), b.as_f64()) {
            (Some(a), Some(b)) => json!(b - a),
            _ => Value::Null,
        },
        _ => Value::Null,
    }
}
