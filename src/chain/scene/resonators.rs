//! Resonators on the bodies.

use std::f64::consts::TAU;

use super::check::Check;
use super::pattern::check_cell;
use crate::chain::Resonators;
use crate::error::Result;

/// The keys that say more of resonators than their masses.
const MORE: [&str; 5] = [
    "resonator_frequency",
    "resonator_stiffness",
    "resonator_damping",
    "resonator_displacements",
    "resonator_velocities",
];

/// The resonators of a scene, if it has any.
pub(super) fn resonators(check: Check, n: usize) -> Result<Option<Resonators>> {
    let scene = check.scene;
    check.only_with(&MORE, scene.resonator_mass.is_some(), "`resonator_mass`")?;
    check.one_of(
        &["resonator_frequency", "resonator_stiffness"],
        "the springs of resonators",
    )?;
    let along = |key: &str, typed: &Option<Vec<f64>>| -> Result<Option<Vec<f64>>> {
        let Some(cell) = typed else { return Ok(None) };
        check_cell(check, key, cell)?;
        for (i, value) in cell.iter().enumerate() {
            check.not_negative(&format!("{key}[{i}]"), *value)?;
        }
        Ok(Some(cell.iter().copied().cycle().take(n).collect()))
    };
    let Some(mass) = along("resonator_mass", &scene.resonator_mass)? else {
        return Ok(None);
    };
    let frequency = along("resonator_frequency", &scene.resonator_frequency)?;
    let stiffness = along("resonator_stiffness", &scene.resonator_stiffness)?;
    let damping = along("resonator_damping", &scene.resonator_damping)?;
    let (key, typed) = match (frequency, stiffness) {
        (Some(frequency), _) => ("resonator_frequency", frequency),
        (None, Some(stiffness)) => ("resonator_stiffness", stiffness),
        (None, None) => {
            let expected = "it or `resonator_stiffness`, since resonators have masses";
            return Err(check.fault("resonator_frequency", expected, "nothing"));
        }
    };
    let is_there = |j: &usize| mass[*j] > 0.0;
    if let Some(j) = (0..n).filter(is_there).find(|j| typed[*j] == 0.0) {
        let expected = "values above 0 where there are resonators";
        return Err(check.fault(
            key,
            expected,
            format!("0 at site {j}, whose resonator has the mass {}", mass[j]),
        ));
    }
    let spring = |j: usize| match key {
        "resonator_frequency" => mass[j] * (TAU * typed[j]).powi(2),
        _ => typed[j],
    };
    let only = |of: &dyn Fn(usize) -> f64| {
        (0..n)
            .map(|j| if is_there(&j) { of(j) } else { 0.0 })
            .collect()
    };
    Ok(Some(Resonators {
        stiffness: only(&spring),
        damping: damping.map_or(vec![0.0; n], |damping| only(&|j| damping[j])),
        mass,
    }))
}
