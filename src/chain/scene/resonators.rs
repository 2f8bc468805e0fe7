//! Resonators on the bodies.

use std::f64::consts::TAU;

use super::check::Check;
use crate::chain::Resonators;
use crate::error::Result;

/// The resonators of a scene, if it has any.
pub(super) fn resonators(check: Check, n: usize) -> Result<Option<Resonators>> {
    let scene = check.scene;
    let along = |typed: &Option<Vec<f64>>| -> Option<Vec<f64>> {
        let cell = typed.as_ref()?;
        Some(cell.iter().copied().cycle().take(n).collect())
    };
    let Some(mass) = along(&scene.resonator_mass) else {
        return Ok(None);
    };
    let damping = along(&scene.resonator_damping);
    let springs = [&scene.resonator_frequency, &scene.resonator_stiffness].map(along);
    let (key, typed) = match springs.into() {
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
    let only = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let or_none = |j: usize| if is_there(&j) { of(j) } else { 0.0 };
        (0..n).map(or_none).collect()
    };
    Ok(Some(Resonators {
        stiffness: only(&spring),
        damping: damping.map_or(vec![0.0; n], |damping| only(&|j| damping[j])),
        mass,
    }))
}
