//! Coefficients along the chain, and the ends with theirs.

use super::bodies::Bodies;
use super::check::Check;
use super::pattern::along;
use super::{EndsTyped, FirstContact, Shape, Units};
use crate::chain::{Ends, Law, Laws};
use crate::error::Result;

/// Coefficients along the chain, and the ends with theirs.
pub(super) fn coefficients(
    check: Check,
    bodies: Option<&Bodies>,
    laws: &Laws,
    n: usize,
) -> Result<(Vec<f64>, Ends)> {
    let scene = check.scene;
    let cell = cell(check, bodies, laws)?;
    // Coefficients draw from other numbers than masses of the same seed.
    let seed = !scene.seed.unwrap_or(0);
    let mut values = along(check, &cell, check.contacts(n), "coefficient", seed)?;
    let sphere = bodies.map(Bodies::striker).transpose()?.flatten();
    let striker = scene.striker_coefficient.or(sphere.map(|(_, own)| own));
    if striker.is_some() && values.len() < 2 {
        let typed = scene.striker_coefficient.map(|_| "striker_coefficient");
        let expected = "it only beside two contacts or more";
        return Err(check.fault(typed.unwrap_or("striker_radius"), expected, values.len()));
    }
    let of_wall = bodies.map(Bodies::wall).transpose()?.flatten();
    if let (Some(own), Some(first)) = (striker, values.first_mut()) {
        *first = own;
    }
    if let (Some(own), Some(last)) = (scene.wall_coefficient.or(of_wall), values.last_mut()) {
        *last = own;
    }
    let ends = match scene.ends.unwrap_or_default() {
        EndsTyped::Wall => Ends::Wall,
        EndsTyped::Free => Ends::Free,
        EndsTyped::Periodic => Ends::Periodic,
        EndsTyped::Fixed => {
            let pattern = cell.last().copied();
            let pattern = pattern.filter(|_| scene.coefficients.is_none());
            let own = scene.left_wall_coefficient.or(pattern);
            let expected = "the coefficient at the wall before site 0";
            Ends::Fixed {
                left_coefficient: check.need("left_wall_coefficient", own, expected)?,
            }
        }
    };
    Ok((values, ends))
}

/// The coefficients that repeat along the chain, or all of them.
fn cell(check: Check, bodies: Option<&Bodies>, laws: &Laws) -> Result<Vec<f64>> {
    let scene = check.scene;
    if let Some(typed) = scene
        .coefficients
        .as_ref()
        .or(scene.coefficient_cell.as_ref())
    {
        return Ok(typed.clone());
    }
    let Some(bodies) = bodies else {
        // Tables and formulas of an SI scene are in N themselves.
        let is_whole = laws.each().iter().all(|law| law.coefficient_unit() == "1");
        if check.units == Units::Si && !is_whole {
            let expected = "it, `coefficients`, or a `material` in an SI scene";
            return Err(check.fault("coefficient_cell", expected, "nothing"));
        }
        return Ok(match scene.stiffness_ratio {
            Some(ratio) => in_order(check, 1.0, ratio),
            None => vec![1.0],
        });
    };
    if laws.only() != Some(&Law::Hertz) {
        let expected = "hertz, since the contacts of bodies follow Hertz's law";
        return Err(check.fault("law", expected, "another law"));
    }
    if let Some(angles) = &scene.angle_cell {
        let at = |(i, &angle)| bodies.coefficient(&format!("angle_cell[{i}]"), angle);
        return angles.iter().enumerate().map(at).collect();
    }
    if let Some(ratio) = scene.stiffness_ratio {
        let soft = bodies.coefficient("stiffness_ratio", 90.0)?;
        return Ok(in_order(check, soft, soft * ratio));
    }
    if bodies.shape() == Shape::Sphere {
        return Ok(vec![bodies.coefficient("radius", 90.0)?]);
    }
    let expected = "the angle of the cylinders, their coefficients, or `shape = \"sphere\"`";
    let angle = check.need("angle", scene.angle, expected)?.value;
    let mut cell = vec![bodies.coefficient("angle", angle)?];
    if let Some(second) = scene.second_angle {
        cell.push(bodies.coefficient("second_angle", second.value)?);
    }
    Ok(cell)
}

fn in_order(check: Check, soft: f64, stiff: f64) -> Vec<f64> {
    match check.scene.first_contact.unwrap_or_default() {
        FirstContact::Soft => vec![soft, stiff],
        FirstContact::Stiff => vec![stiff, soft],
    }
}
