//! Coefficients along the chain, and the ends with theirs.

use super::bodies::Bodies;
use super::check::Check;
use super::pattern::{along, check_cell};
use super::{EndsTyped, FirstContact, Shape, Units};
use crate::chain::{Ends, Law, Laws, Pattern};
use crate::error::Result;

/// Alternative keys that determine the coefficients.
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
    laws: &Laws,
    n: usize,
) -> Result<(Vec<f64>, Ends)> {
    let scene = check.scene;
    let ends = scene.ends.unwrap_or_default();
    let contacts = match ends {
        EndsTyped::Free => n - 1,
        _ => n,
    };
    let cell = cell(check, bodies, laws, contacts)?;
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
fn cell(check: Check, bodies: Option<&Bodies>, laws: &Laws, contacts: usize) -> Result<Vec<f64>> {
    let scene = check.scene;
    let decides = check.one_of(&COEFFICIENTS, "the coefficients")?;
    let is_geometric = !matches!(decides, Some("coefficient_cell" | "coefficients"));
    if let Some(bodies) = bodies.filter(|_| is_geometric) {
        if laws.only() != Some(&Law::Hertz) {
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
        let expected = match scene.shape {
            None => {
                "`shape = \"sphere\"`, or the angle of the cylinders that bodies are by default"
            }
            Some(_) => "the angle of the cylinders, or their coefficients",
        };
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
    // Tables and formulas of an SI scene are in N themselves.
    let is_whole = laws.each().iter().all(|law| law.coefficient_unit() == "1");
    if check.units == Units::Si && !is_whole {
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
        Some(ratio) => check_cell(check, "stiffness_ratio", &[1.0, ratio]).map(|()| Some(ratio)),
        None => Ok(None),
    }
}

fn in_order(check: Check, soft: f64, stiff: f64) -> Vec<f64> {
    match check.scene.first_contact.unwrap_or_default() {
        FirstContact::Soft => vec![soft, stiff],
        FirstContact::Stiff => vec![stiff, soft],
    }
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
