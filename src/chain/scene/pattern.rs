//! Masses and coefficients along the chain: the pattern, the ends, the defects.

use super::bodies::Bodies;
use super::check::Check;
use super::{EndsTyped, FirstContact, LawTyped, Shape, Units};
use crate::chain::{Ends, Pattern};
use crate::error::Result;

/// The keys of which one decides the coefficients.
const COEFFICIENTS: [&str; 5] = [
    "stiffness_ratio",
    "coefficient_cell",
    "coefficients",
    "angle",
    "angle_cell",
];

/// Coefficients along the chain, and the ends with theirs.
pub(super) fn coefficients(
    check: Check,
    bodies: Option<&Bodies>,
    n: usize,
) -> Result<(Vec<f64>, Ends)> {
    let scene = check.scene;
    let ends = scene.ends.unwrap_or_default();
    let contacts = match ends {
        EndsTyped::Free => n - 1,
        _ => n,
    };
    let cell = cell(check, bodies, contacts)?;
    check.only_with(
        &["first_contact"],
        scene.stiffness_ratio.is_some(),
        "`stiffness_ratio`",
    )?;
    check.only_with(&["second_angle"], scene.angle.is_some(), "`angle`")?;
    let left = cell.last().copied();
    let seed = scene.seed.unwrap_or(0);
    // Coefficients draw from other numbers than masses of the same seed.
    let mut values = along(check, Pattern::Cell(cell), contacts, "coefficient", !seed)?;
    striker_contact(check, bodies, &mut values)?;
    wall_contact(check, bodies, ends, &mut values)?;
    check.only_with(
        &["left_wall_coefficient"],
        ends == EndsTyped::Fixed,
        "`ends = \"fixed\"`",
    )?;
    let ends = match ends {
        EndsTyped::Wall => Ends::Wall,
        EndsTyped::Free => Ends::Free,
        EndsTyped::Periodic => Ends::Periodic,
        EndsTyped::Fixed => {
            let own = scene.left_wall_coefficient;
            let pattern = left.filter(|_| scene.coefficients.is_none());
            let expected = "the coefficient at the wall before site 0";
            let key = "left_wall_coefficient";
            let left_coefficient = check.need(key, own.or(pattern), expected)?;
            check.positive(key, left_coefficient)?;
            Ends::Fixed { left_coefficient }
        }
    };
    Ok((values, ends))
}

/// The coefficients that repeat along the chain, or all of them.
fn cell(check: Check, bodies: Option<&Bodies>, contacts: usize) -> Result<Vec<f64>> {
    let scene = check.scene;
    let decides = check.one_of(&COEFFICIENTS, "the coefficients")?;
    let is_geometric = !matches!(decides, Some("coefficient_cell" | "coefficients"));
    if let Some(bodies) = bodies.filter(|_| is_geometric) {
        if scene.law.unwrap_or_default() != LawTyped::Hertz {
            let expected = "hertz, since the contacts of bodies follow Hertz's law";
            return Err(check.fault("law", expected, "another law"));
        }
        if let Some(angles) = &scene.angle_cell {
            check_cell(check, "angle_cell", angles)?;
            let at = |(i, &angle)| bodies.coefficient(&format!("angle_cell[{i}]"), angle);
            return angles.iter().enumerate().map(at).collect();
        }
        if let Some(ratio) = stiffness_ratio(check)? {
            if bodies.shape() == Shape::Sphere {
                let expected = "it only beside `shape = \"cylinder\"`";
                return Err(check.fault("stiffness_ratio", expected, "spheres"));
            }
            let soft = bodies.coefficient("stiffness_ratio", 90.0)?;
            return Ok(in_order(check, soft, soft * ratio));
        }
        if bodies.shape() == Shape::Sphere {
            return Ok(vec![bodies.coefficient("radius", 90.0)?]);
        }
        let expected = "the angle of the cylinders, or their coefficients";
        let angle = check.need("angle", scene.angle, expected)?.value;
        let mut cell = vec![bodies.coefficient("angle", angle)?];
        if let Some(second) = scene.second_angle {
            cell.push(bodies.coefficient("second_angle", second.value)?);
        }
        return Ok(cell);
    }
    if let Some(values) = &scene.coefficients {
        check.length("coefficients", values, contacts, "contact")?;
        check.all_positive("coefficients", values)?;
        return Ok(values.clone());
    }
    if let Some(cell) = &scene.coefficient_cell {
        check_cell(check, "coefficient_cell", cell)?;
        check.all_positive("coefficient_cell", cell)?;
        return Ok(cell.clone());
    }
    if check.units == Units::Si {
        let expected = "it, `coefficients`, or a `material` in an SI scene";
        return Err(check.fault("coefficient_cell", expected, "nothing"));
    }
    Ok(match stiffness_ratio(check)? {
        Some(ratio) => in_order(check, 1.0, ratio),
        None => vec![1.0],
    })
}

fn stiffness_ratio(check: Check) -> Result<Option<f64>> {
    match check.scene.stiffness_ratio {
        Some(ratio) if !(ratio >= 1.0 && ratio.is_finite()) => {
            Err(check.fault("stiffness_ratio", "a finite ratio of 1 or more", ratio))
        }
        ratio => Ok(ratio),
    }
}

fn in_order(check: Check, soft: f64, stiff: f64) -> Vec<f64> {
    match check.scene.first_contact.unwrap_or_default() {
        FirstContact::Soft => vec![soft, stiff],
        FirstContact::Stiff => vec![stiff, soft],
    }
}

fn check_cell(check: Check, key: &str, cell: &[f64]) -> Result<()> {
    if cell.is_empty() {
        return Err(check.fault(key, "at least one value", "an empty list"));
    }
    Ok(())
}

/// A pattern with the taper and the randomness of `what` (mass or coefficient).
fn along(check: Check, cell: Pattern, n: usize, what: &str, seed: u64) -> Result<Vec<f64>> {
    let scene = check.scene;
    let (taper, spread) = match what {
        "mass" => (scene.mass_taper, scene.mass_spread),
        _ => (scene.coefficient_taper, scene.coefficient_spread),
    };
    let (taper_key, spread_key) = (format!("{what}_taper"), format!("{what}_spread"));
    let last = check.positive(&taper_key, taper.unwrap_or(1.0))?;
    let spread = check.not_negative(&spread_key, spread.unwrap_or(0.0))?;
    if spread >= 1.0 {
        return Err(check.fault(&spread_key, "a spread below 1", spread));
    }
    let taper = Pattern::Tapered { first: 1.0, last };
    let random = Pattern::Random {
        mean: 1.0,
        spread,
        seed,
    };
    let values = |pattern: Pattern, key: &str| {
        let values = pattern.values(n);
        values.map_err(|error| check.named(error, key))
    };
    let (cell, taper, random) = (
        values(cell, what)?,
        values(taper, &taper_key)?,
        values(random, &spread_key)?,
    );
    let product = |((cell, taper), random): ((f64, f64), f64)| cell * taper * random;
    Ok(cell
        .into_iter()
        .zip(taper)
        .zip(random)
        .map(product)
        .collect())
}

fn striker_contact(check: Check, bodies: Option<&Bodies>, values: &mut [f64]) -> Result<()> {
    let scene = check.scene;
    let keys = ["striker_coefficient", "striker_radius"];
    let is_end = scene.ends != Some(EndsTyped::Periodic);
    check.only_with(&keys, is_end, "ends that are not periodic")?;
    check.only_with(&keys, values.len() > 1, "two contacts or more")?;
    let sphere = match bodies {
        Some(bodies) => bodies.striker()?,
        None => None,
    };
    let own = match (scene.striker_coefficient, sphere) {
        (Some(own), _) => check.positive("striker_coefficient", own)?,
        (None, Some((_, coefficient))) => coefficient,
        (None, None) => return Ok(()),
    };
    values[0] = own;
    Ok(())
}

fn wall_contact(
    check: Check,
    bodies: Option<&Bodies>,
    ends: EndsTyped,
    values: &mut [f64],
) -> Result<()> {
    let keys = ["wall_coefficient", "wall_radius", "wall_material"];
    let has_wall = matches!(ends, EndsTyped::Wall | EndsTyped::Fixed);
    check.only_with(&keys, has_wall, "a wall after the last site")?;
    if check.scene.wall_coefficient.is_some() {
        let found = keys[1..].iter().find(|key| check.places.has(key));
        if let Some(key) = found {
            let beside = check.places.mention("wall_coefficient");
            let expected = "one key that decides the wall's contact";
            return Err(check.fault(key, expected, format!("it beside {beside}")));
        }
    }
    let own = match (check.scene.wall_coefficient, bodies) {
        (Some(own), _) => Some(check.positive("wall_coefficient", own)?),
        (None, Some(bodies)) => bodies.wall()?,
        (None, None) => None,
    };
    if let (Some(own), Some(last)) = (own, values.last_mut()) {
        *last = own;
    }
    Ok(())
}

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
                Some(ratio) => vec![one, one * check.positive("mass_ratio", ratio)?],
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
    let is_random = scene.mass_spread.is_some() || scene.coefficient_spread.is_some();
    check.only_with(
        &["seed"],
        is_random,
        "`mass_spread` or `coefficient_spread`",
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
            (None, None) => return Err(check.fault(&whole, "a factor or a value", "neither")),
        };
        *value = check.positive(&whole, changed)?;
    }
    Ok(())
}
