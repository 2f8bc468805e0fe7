//! Energies and balances of one budget with its standard errors, or of two with their difference.

use serde_json::{Map, Value, json};

use super::RESIDUALS;
use crate::budget::{Budget, Curves};
use crate::sheet::Table;

/// Name, a value a budget, and the standard error of the first.
type Row = (String, Vec<Option<f64>>, Option<f64>);

/// Where the energy is, and what has passed.
pub(super) fn energies(budgets: &[(&str, &Budget)]) -> Table {
    let first = budgets[0].1;
    let row = |name: String, value: &dyn Fn(&Budget) -> Option<f64>, error: Option<f64>| -> Row {
        (
            name,
            budgets.iter().map(|(_, budget)| value(budget)).collect(),
            error,
        )
    };
    let error_of = |of: &dyn Fn(&Curves) -> Option<f64>| of(first.errors.as_deref()?);
    let last = |values: &[f64]| values.last().copied();
    let energy = |what: &str| first.units.energy(what);
    let share_error = || {
        first.errors.as_ref()?;
        Some(first.wavenumber.as_ref()?.passed_error.value() / first.scale)
    };
    let rows = vec![
        row(
            energy("energy at the start"),
            &|b| Some(b.kinetic[0] + b.contact[0]),
            error_of(&|e| e.energy.first().copied()),
        ),
        row(
            energy("of motion, at the end"),
            &|b| last(&b.kinetic),
            error_of(&|e| last(&e.kinetic)),
        ),
        row(
            energy("of contacts, at the end"),
            &|b| last(&b.contact),
            error_of(&|e| last(&e.contact)),
        ),
        row(
            energy("lost"),
            &|b| last(&b.lost),
            error_of(&|e| last(&e.lost)),
        ),
        row(energy("put in"), &|b| last(&b.input), None),
        row(
            energy("passed the middle"),
            &|b| b.passed.get(b.n_contacts / 2).copied(),
            error_of(&|e| e.passed.get(first.n_contacts / 2).copied()),
        ),
        row(
            "share passed from low to high k (net)".into(),
            &|b| Some(b.wavenumber.as_ref()?.passed_edge()? / b.scale),
            share_error(),
        ),
    ];
    table("Energies", budgets, rows)
}

/// Residuals and checks.
pub(super) fn balances(budgets: &[(&str, &Budget)]) -> Table {
    let row = |name: String, value: &dyn Fn(&Budget) -> Option<f64>| -> Row {
        (
            name,
            budgets.iter().map(|(_, budget)| value(budget)).collect(),
            None,
        )
    };
    let mut rows: Vec<Row> = RESIDUALS
        .iter()
        .map(|(_, name, of)| row(format!("residual, {name}"), &|b| of(&b.closure).value()))
        .collect();
    rows.push(row(
        "integrated flux at the largest k, over the energy".into(),
        &|b| Some(b.closure.integrated_flux?.at_largest_wavenumber),
    ));
    rows.push(row(
        "integrated flux made two ways, difference".into(),
        &|b| Some(b.closure.integrated_flux?.two_ways),
    ));
    table("Balances", budgets, rows)
}

fn table(title: &str, budgets: &[(&str, &Budget)], rows: Vec<Row>) -> Table {
    let names = budgets.iter().map(|(name, _)| (*name).to_owned());
    let mut head: Vec<String> = [String::new()].into_iter().chain(names).collect();
    let is_measured = budgets.len() == 1 && rows.iter().any(|row| row.2.is_some());
    head.extend((budgets.len() == 2).then(|| "second less first".into()));
    head.extend(is_measured.then(|| "standard error".into()));
    let rows = rows.into_iter().map(|(name, values, error)| {
        let numbers = values.iter().map(|value| number(*value));
        let mut cells: Vec<String> = [name].into_iter().chain(numbers).collect();
        if let [a, b] = values[..] {
            cells.push(number(a.zip(b).map(|(a, b)| b - a)));
        }
        cells.extend(is_measured.then(|| number(error)));
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
