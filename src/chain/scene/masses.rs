//! Masses along the chain, and single sites and contacts that differ.

use super::Units;
use super::bodies::Bodies;
use super::check::Check;
use super::pattern::{along, check_cell};
use crate::chain::Pattern;
use crate::error::Result;

/// Masses along the chain.
pub(super) fn masses(check: Check, bodies: Option<&Bodies>, n: usize) -> Result<Vec<f64>> {
    let scene = check.scene;
    check.one_of(&["mass_cell", "masses", "length"], "the masses")?;
    check.one_of(&["mass_ratio", "mass_cell", "masses"], "the masses")?;
    let cell = match (&scene.masses, &scene.mass_cell) {
        (Some(masses), _) => {
            check.length("masses", masses, n, "site")?;
            check.all_positive("masses", masses)?;
            masses.clone()
        }
        (None, Some(cell)) => {
            check_cell(check, "mass_cell", cell)?;
            check.all_positive("mass_cell", cell)?;
            cell.clone()
        }
        (None, None) => {
            let one = match bodies {
                Some(bodies) => bodies.mass()?,
                None if check.units == Units::Si => {
                    let expected = "it, `masses`, or a `material` in an SI scene";
                    return Err(check.fault("mass_cell", expected, "nothing"));
                }
                None => 1.0,
            };
            match scene.mass_ratio {
                Some(ratio) => {
                    check_cell(check, "mass_ratio", &[1.0, ratio])?;
                    vec![one, one * check.positive("mass_ratio", ratio)?]
                }
                None => vec![one],
            }
        }
    };
    let seed = scene.seed.unwrap_or(0);
    let mut values = along(check, Pattern::Cell(cell), n, "mass", seed)?;
    let sphere = match bodies {
        Some(bodies) => bodies.striker()?.map(|(mass, _)| mass),
        None => None,
    };
    if let Some(own) = scene.striker_mass.map(|mass| mass.value).or(sphere) {
        values[0] = check.positive("striker_mass", own)?;
    }
    let random = [
        "mass_spread",
        "coefficient_spread",
        "striker_velocity_spread",
        "modes",
        "drive_band",
    ];
    check.only_with(
        &["seed"],
        random.iter().any(|key| check.places.has(key)),
        "what it decides: `mass_spread`, `coefficient_spread`, `striker_velocity_spread`, `modes` or noise",
    )?;
    Ok(values)
}

/// Changes single sites and contacts.
pub(super) fn defects(check: Check, masses: &mut [f64], coefficients: &mut [f64]) -> Result<()> {
    for (i, defect) in check.scene.defect.iter().flatten().enumerate() {
        let key = |name: &str| format!("defect[{i}].{name}");
        let whole = format!("defect[{i}]");
        let (name, index, values) = match (defect.site, defect.contact) {
            (Some(site), None) => ("site", site, &mut *masses),
            (None, Some(contact)) => ("contact", contact, &mut *coefficients),
            (Some(_), Some(_)) => return Err(check.fault(&whole, "a site or a contact", "both")),
            (None, None) => return Err(check.fault(&whole, "a site or a contact", "neither")),
        };
        let last = values.len().saturating_sub(1);
        let Some(value) = values.get_mut(index) else {
            let expected = format!("a {name} from 0 to {last}");
            return Err(check.fault(&key(name), expected, index));
        };
        let changed = match (defect.factor, defect.value) {
            (Some(factor), None) => *value * check.positive(&key("factor"), factor)?,
            (None, Some(value)) => check.positive(&key("value"), value)?,
            (Some(_), Some(_)) => return Err(check.fault(&whole, "a factor or a value", "both")),
            (None, None) if defect.law.is_some() => *value,
            (None, None) => return Err(check.fault(&whole, "a factor or a value", "neither")),
        };
        *value = check.positive(&whole, changed)?;
    }
    Ok(())
}
