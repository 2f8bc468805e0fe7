//! Energies and balances of one budget with its standard errors, or of two with their difference.

use serde_json::{Map, Value, json};

use super::RESIDUALS;
use crate::budget::{Budget, Curves};
use crate::sheet::Table;

/// Values in the order of the rows.
type Column = Vec<Option<f64>>;

/// Where the energy is, and what has passed.
pub(super) fn energies(budgets: &[(&str, &Budget)]) -> Table {
    let first = budgets[0].1;
    let mut names: Vec<String> = [
        "energy at the start",
        "of motion, at the end",
        "of contacts, at the end",
        "lost",
        "put in",
        "passed the middle",
    ]
    .map(|what| first.units.energy(what))
    .into();
    names.push("share passed from low to high k (net)".into());
    let column = |budget: &Budget, of: &Curves, input: Option<f64>, passed: Option<f64>| {
        let middle = of.passed.get(budget.n_contacts / 2);
        let [kinetic, contact, lost] = [&of.kinetic, &of.contact, &of.lost].map(|of| of.last());
        let values = [
            of.energy.first(),
            kinetic,
            contact,
            lost,
            input.as_ref(),
            middle,
        ];
        let mut column: Column = values.map(|value| value.copied()).into();
        column.push(passed.map(|passed| passed / budget.scale));
        column
    };
    let values = budgets.iter().map(|(_, budget)| {
        let found = budget.wavenumber.as_ref();
        let passed = found.and_then(|found| found.passed_edge());
        column(
            budget,
            &Curves::of(budget),
            budget.input.last().copied(),
            passed,
        )
    });
    let errors = first.errors.as_deref().map(|errors| {
        let found = first.wavenumber.as_ref();
        column(
            first,
            errors,
            None,
            found.map(|found| found.passed_error.value()),
        )
    });
    table("Energies", budgets, names, values.collect(), errors)
}

/// Residuals and checks.
pub(super) fn balances(budgets: &[(&str, &Budget)]) -> Table {
    let names = RESIDUALS
        .iter()
        .map(|(_, name, _)| format!("residual, {name}"));
    let checks = [
        "integrated flux at the largest k, over the energy",
        "integrated flux made two ways, difference",
    ];
    let names = names.chain(checks.map(str::to_owned)).collect();
    let values = budgets.iter().map(|(_, budget)| {
        let closure = &budget.closure;
        let check = closure.integrated_flux;
        let checks = check.map_or([None; 2], |of| {
            [Some(of.at_largest_wavenumber), Some(of.two_ways)]
        });
        let residuals = RESIDUALS.iter().map(|(_, _, of)| of(closure).value());
        residuals.chain(checks).collect()
    });
    table("Balances", budgets, names, values.collect(), None)
}

fn table(
    title: &str,
    budgets: &[(&str, &Budget)],
    names: Vec<String>,
    mut columns: Vec<Column>,
    errors: Option<Column>,
) -> Table {
    let mut head = vec![String::new()];
    head.extend(budgets.iter().map(|(name, _)| (*name).to_owned()));
    if let [a, b] = &columns[..] {
        let pairs = a.iter().zip(b);
        columns.push(pairs.map(|(a, b)| a.zip(*b).map(|(a, b)| b - a)).collect());
        head.push("second less first".into());
    } else if let Some(errors) = errors {
        columns.push(errors);
        head.push("standard error".into());
    }
    let rows = names.into_iter().enumerate().map(|(i, name)| {
        let numbers = columns.iter().map(|column| number(column[i]));
        [name].into_iter().chain(numbers).collect()
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
