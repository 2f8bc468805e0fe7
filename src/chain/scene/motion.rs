//! How a chain starts.

use std::f64::consts::PI;

use super::check::Check;
use super::pattern::random_factor;
use super::{EndsTyped, Units};
use crate::chain::{Chain, Drive};
use crate::error::Result;

/// How a chain starts.
pub(super) struct Start {
    pub(super) velocity: Vec<f64>,
    pub(super) displacement: Vec<f64>,
    /// Those of resonators, if they are not those of their bodies.
    pub(super) resonators: Option<[Vec<f64>; 2]>,
}

/// Initial velocities and displacements; a body whose motion is prescribed starts as it goes on.
pub(super) fn start(check: Check, chain: &Chain, drive: Option<&Drive>) -> Result<Start> {
    let (scene, n) = (check.scene, chain.n_sites());
    let or_rest = |typed: &Option<Vec<f64>>| typed.clone().unwrap_or(vec![0.0; n]);
    let mut velocity = or_rest(&scene.velocities);
    let mut displacement = or_rest(&scene.displacements);
    let own = [&scene.resonator_displacements, &scene.resonator_velocities];
    let mut resonators = None;
    if let (Some(mode), Some(energy)) = (scene.mode, scene.mode_energy) {
        let [bodies, own] = excited(check, "mode", [mode; 2], energy, chain)?;
        ([displacement, velocity], resonators) = (bodies, Some(own));
    } else if let Some(mode) = scene.mode {
        displacement = shape_of_mode(check, mode, n)?;
    } else if let Some(modes) = &scene.modes {
        let expected = "two modes, the first and the last";
        let &[first, last] = modes.as_slice() else {
            return Err(check.fault("modes", expected, format!("{} numbers", modes.len())));
        };
        let expected = "the energy of each mode";
        let energy = check.need("mode_energy", scene.mode_energy, expected)?;
        let [bodies, own] = excited(check, "modes", [first, last], energy, chain)?;
        ([displacement, velocity], resonators) = (bodies, Some(own));
    }
    let own_starts = [&scene.velocities, &scene.displacements, own[0], own[1]];
    let something = own_starts.iter().any(|typed| typed.is_some())
        || scene.mode.is_some()
        || scene.modes.is_some()
        || scene.drive.is_some();
    if let Some(speed) = scene.striker_velocity {
        velocity[0] = speed.value;
    } else if !something {
        velocity[0] = match check.units {
            Units::None => 1.0,
            Units::Si => {
                let expected = "the speed of the impact, or another start";
                return Err(check.fault("striker_velocity", expected, "nothing"));
            }
        };
    }
    // Masses and coefficients of the same seed draw from other numbers.
    let mut state = scene.seed.unwrap_or(0).wrapping_add(1 << 63);
    velocity[0] *= random_factor(scene.striker_velocity_spread, &mut state);
    if let Some((site, wave)) = drive.and_then(Drive::motion) {
        let own = [
            ("velocity", &mut velocity, wave.rate_at(0.0)),
            ("displacement", &mut displacement, wave.at(0.0)),
        ];
        for (what, values, told) in own {
            // A velocity that is computed elsewhere may be rounded otherwise.
            let is_off = (values[site] - told).abs() > 1e-9 * told.abs();
            if values[site] != 0.0 && is_off {
                let expected =
                    format!("a body of no other {what} at time 0 than the drive's, {told}");
                return Err(check.fault("drive", expected, values[site]));
            }
            values[site] = told;
        }
    }
    let moves = |values: &[f64]| values.iter().any(|v| *v != 0.0);
    let all = [&velocity, &displacement]
        .into_iter()
        .chain(own.into_iter().flatten());
    if !all.into_iter().any(|values| moves(values)) && scene.drive.is_none() {
        let keys = ["velocities", "displacements", "mode_amplitude"];
        let key = keys.iter().find(|key| check.places.has(key));
        let key = key.filter(|_| !check.places.has("striker_velocity"));
        let key = key.unwrap_or(&"striker_velocity");
        return Err(check.fault(key, "something that moves", "a chain at rest"));
    }
    if own.iter().any(|typed| typed.is_some()) {
        let [at, speed] = own.map(Option::as_ref);
        let followed = [at.unwrap_or(&displacement), speed.unwrap_or(&velocity)];
        resonators = Some(followed.map(Vec::clone));
    }
    Ok(Start {
        velocity,
        displacement,
        resonators: resonators.filter(|_| chain.resonators().is_some()),
    })
}

/// Displacements and velocities of modes of the chain itself.
fn excited(
    check: Check,
    key: &str,
    [first, last]: [usize; 2],
    energy: f64,
    chain: &Chain,
) -> Result<[[Vec<f64>; 2]; 2]> {
    let modes = chain.normal_modes();
    let modes = modes.map_err(|error| check.named(error, key))?;
    let most = modes.frequency.len() - modes.free;
    if !(1 <= first && first <= last && last <= most) {
        let expected = format!("modes from 1 to {most}, the first one before the last");
        let found = match first == last {
            true => first.to_string(),
            false => format!("{first}, {last}"),
        };
        return Err(check.fault(key, expected, found));
    }
    let seed = (key == "modes").then(|| check.scene.seed.unwrap_or(0));
    Ok(modes.excite(first..=last, energy, seed))
}

/// The mode of the uniform linear chain of unit springs with these ends.
///
/// Fixed: `sin(pi k (j+1)/(N+1))`; free: `cos(pi k (j+1/2)/N)`; free at the striker, fixed at the
/// wall: `cos(pi (k-1/2) (j+1/2)/(N+1/2))`; periodic: `sin(2 pi k j/N)`.
fn shape_of_mode(check: Check, mode: usize, n: usize) -> Result<Vec<f64>> {
    let scene = check.scene;
    let last = match scene.ends.unwrap_or_default() {
        EndsTyped::Wall | EndsTyped::Fixed => n,
        EndsTyped::Free => n - 1,
        EndsTyped::Periodic => n.div_ceil(2) - 1,
    };
    if !(1..=last).contains(&mode) {
        return Err(check.fault("mode", format!("a mode from 1 to {last}"), mode));
    }
    let expected = "the largest displacement of the mode";
    let amplitude = check.need("mode_amplitude", scene.mode_amplitude, expected)?;
    let (k, sites) = (mode as f64, n as f64);
    let shape = |j: f64| match scene.ends.unwrap_or_default() {
        EndsTyped::Fixed => (PI * k * (j + 1.0) / (sites + 1.0)).sin(),
        EndsTyped::Free => (PI * k * (j + 0.5) / sites).cos(),
        EndsTyped::Wall => (PI * (k - 0.5) * (j + 0.5) / (sites + 0.5)).cos(),
        EndsTyped::Periodic => (2.0 * PI * k * j / sites).sin(),
    };
    Ok((0..n).map(|j| amplitude.value * shape(j as f64)).collect())
}
