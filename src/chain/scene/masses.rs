//! Masses along the chain, and single sites and contacts that differ.

use super::Units;
use super::bodies::Bodies;
use super::check::Check;
use super::pattern::along;
use crate::error::Result;

/// Masses along the chain.
pub(super) fn masses(check: Check, bodies: Option<&Bodies>, n: usize) -> Result<Vec<f64>> {
    let scene = check.scene;
    let cell = match scene.masses.as_ref().or(scene.mass_cell.as_ref()) {
        Some(typed) => typed.clone(),
        None => {
            let one = match bodies {
                Some(bodies) => bodies.mass()?,
                None if check.units == Units::Si => {
                    let expected = "it, `masses`, or a `material` in an SI scene";
                    return Err(check.fault("mass_cell", expected, "nothing"));
                }
                None => 1.0,
            };
            let other = scene.mass_ratio.map(|ratio| one * ratio);
            [Some(one), other].into_iter().flatten().collect()
        }
    };
    let mut values = along(check, &cell, n, "mass", scene.seed.unwrap_or(0))?;
    let sphere = bodies.map(Bodies::striker).transpose()?.flatten();
    let striker = scene.striker_mass.map(|mass| mass.value);
    if let Some(own) = striker.or(sphere.map(|(mass, _)| mass)) {
        values[0] = own;
    }
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
