//! Energies and balances of one budget with its standard errors, or of two with their difference.

use serde_json::{Map, Value, json};

use crate::budget::BudgetUnits;
use crate::sheet::Table;

/// Energies: name, and where it is in the numbers.
const ENERGIES: [(&str, &str); 6] = [
    ("energy at the start", "/energy/start"),
    ("of motion, at the end", "/energy/kinetic_end"),
    ("of contacts, at the end", "/energy/contact_end"),
    ("lost", "/energy/lost"),
    ("put in", "/energy/put_in"),
    ("passed the middle", "/energy/passed_middle"),
];

/// What has passed, residuals and checks.
const SHARES: [(&str, &str); 7] = [
    (
        "share passed from low to high k",
        "/wavenumber/share_passed",
    ),
    ("residual, real space", "/closure/real_space"),
    ("residual, wavenumber", "/closure/wavenumber"),
    ("residual, frequency", "/closure/frequency"),
    ("residual, scale", "/closure/scale"),
    (
        "integrated flux at the largest k, over the energy",
        "/closure/integrated_flux/at_largest_wavenumber",
    ),
    (
        "integrated flux made two ways, difference",
        "/closure/integrated_flux/two_ways",
    ),
];

/// Energies with their unit, and shares of the energy, of one budget or of two.
pub(super) fn tables(budgets: &[(&str, &Value)], units: &BudgetUnits) -> Vec<Table> {
    let energies = ENERGIES.map(|(name, place)| (units.energy(name), place));
    let shares = SHARES.map(|(name, place)| (name.to_owned(), place));
    vec![
        table("Energies", budgets, &energies),
        table("Balances", budgets, &shares),
    ]
}

fn table(title: &str, budgets: &[(&str, &Value)], rows: &[(String, &str)]) -> Table {
    let mut head = vec![String::new()];
    head.extend(budgets.iter().map(|(name, _)| (*name).to_owned()));
    let is_measured = budgets[0].1["energy"].get("errors").is_some();
    head.extend(match budgets.len() {
        1 => is_measured.then(|| "standard error".into()),
        _ => Some("second less first".into()),
    });
    let rows = rows.iter().map(|(name, place)| {
        let value = |i: usize, place: &str| budgets[i].1.pointer(place)?.as_f64();
        let mut values = vec![value(0, place)];
        if budgets.len() > 1 {
            let (a, b) = (values[0], value(1, place));
            values.extend([b, a.zip(b).map(|(a, b)| b - a)]);
        } else if let Some((of, key)) = place.rsplit_once('/').filter(|_| is_measured) {
            values.push(value(0, &format!("{of}/errors/{key}")));
        }
        let cells = values.into_iter().map(number);
        [name.clone()].into_iter().chain(cells).collect()
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
