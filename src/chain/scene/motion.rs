//! How a chain starts and what drives it.

use std::f64::consts::PI;

use super::check::Check;
use super::{DriveTyped, EndsTyped, Units, WaveformTyped};
use crate::chain::{Drive, Waveform};
use crate::error::Result;

/// Initial velocities and displacements.
pub(super) fn start(check: Check, n: usize) -> Result<(Vec<f64>, Vec<f64>)> {
    let scene = check.scene;
    check.one_of(
        &["striker_velocity", "velocities"],
        "the velocity of the striker",
    )?;
    check.one_of(&["displacements", "mode"], "the displacements")?;
    check.only_with(&["mode_amplitude"], scene.mode.is_some(), "`mode`")?;
    let mut velocity = vec![0.0; n];
    let mut displacement = vec![0.0; n];
    for (key, typed, values) in [
        ("velocities", &scene.velocities, &mut velocity),
        ("displacements", &scene.displacements, &mut displacement),
    ] {
        let Some(typed) = typed else { continue };
        check.length(key, typed, n, "site")?;
        for (i, (to, &from)) in values.iter_mut().zip(typed).enumerate() {
            *to = check.finite(&format!("{key}[{i}]"), from)?;
        }
    }
    if let Some(mode) = scene.mode {
        displacement = shape_of_mode(check, mode, n)?;
    }
    let something = ["velocities", "displacements", "mode", "drive"];
    let something = something.iter().any(|key| check.places.has(key));
    if let Some(speed) = scene.striker_velocity {
        velocity[0] = check.finite("striker_velocity", speed.value)?;
    } else if !something {
        velocity[0] = match check.units {
            Units::None => 1.0,
            Units::Si => {
                let expected = "the speed of the impact, or another start";
                return Err(check.fault("striker_velocity", expected, "nothing"));
            }
        };
    }
    let moves = |values: &[f64]| values.iter().any(|v| *v != 0.0);
    if !moves(&velocity) && !moves(&displacement) && scene.drive.is_none() {
        let key = [
            "striker_velocity",
            "velocities",
            "displacements",
            "mode_amplitude",
        ];
        let key = key
            .iter()
            .find(|key| check.places.has(key))
            .unwrap_or(&key[0]);
        return Err(check.fault(key, "something that moves", "a chain at rest"));
    }
    Ok((velocity, displacement))
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
    let amplitude = check.finite("mode_amplitude", amplitude.value)?;
    let (k, sites) = (mode as f64, n as f64);
    let shape = |j: f64| match scene.ends.unwrap_or_default() {
        EndsTyped::Fixed => (PI * k * (j + 1.0) / (sites + 1.0)).sin(),
        EndsTyped::Free => (PI * k * (j + 0.5) / sites).cos(),
        EndsTyped::Wall => (PI * (k - 0.5) * (j + 0.5) / (sites + 0.5)).cos(),
        EndsTyped::Periodic => (2.0 * PI * k * j / sites).sin(),
    };
    Ok((0..n).map(|j| amplitude * shape(j as f64)).collect())
}

/// The drive, if there is one.
pub(super) fn drive(check: Check) -> Result<Option<Drive>> {
    let scene = check.scene;
    let Some(typed) = scene.drive else {
        let keys = [
            "drive_waveform",
            "drive_amplitude",
            "drive_frequency",
            "drive_duration",
        ];
        check.only_with(&keys, false, "`drive`")?;
        return Ok(None);
    };
    let ends = scene.ends.unwrap_or_default();
    match typed {
        DriveTyped::Wall if ends != EndsTyped::Fixed => {
            let expected = "it only beside `ends = \"fixed\"`: there is a wall before site 0";
            return Err(check.fault("drive", expected, "other ends"));
        }
        DriveTyped::Force if !matches!(ends, EndsTyped::Wall | EndsTyped::Free) => {
            let expected = "it only beside `ends` wall or free: the end that it pushes is free";
            return Err(check.fault("drive", expected, "other ends"));
        }
        _ => {}
    }
    let expected = "the amplitude of the drive";
    let amplitude = check.need("drive_amplitude", scene.drive_amplitude, expected)?;
    if !(amplitude != 0.0 && amplitude.is_finite()) {
        let expected = "a finite number other than 0";
        return Err(check.fault("drive_amplitude", expected, amplitude));
    }
    let is_sine = scene.drive_waveform.unwrap_or_default() == WaveformTyped::Sine;
    check.only_with(&["drive_frequency"], is_sine, "`drive_waveform = \"sine\"`")?;
    let half = "`drive_waveform = \"half-sine\"`";
    check.only_with(&["drive_duration"], !is_sine, half)?;
    let waveform = if is_sine {
        let key = "drive_frequency";
        let frequency = check.need(key, scene.drive_frequency, "the frequency of the sine")?;
        Waveform::Sine {
            amplitude,
            frequency: check.positive(key, frequency.value)?,
        }
    } else {
        let key = "drive_duration";
        let duration = check.need(key, scene.drive_duration, "the duration of the half-sine")?;
        Waveform::HalfSine {
            amplitude,
            duration: check.positive(key, duration.value)?,
        }
    };
    Ok(Some(match typed {
        DriveTyped::Force => Drive::Force(waveform),
        DriveTyped::Wall => Drive::Wall(waveform),
    }))
}
