//! What drives a chain.

use super::check::Check;
use super::{DriveTyped, EndsTyped, Units, WaveformTyped};
use crate::chain::{Drive, Waveform};
use crate::error::{Error, Result};
use crate::sheet::name_of;

/// Parts of a time between values, in units of their median: a longer one is a gap.
const GAP: f64 = 20.0;

/// The drive, if there is one, and the same in words.
pub(super) fn drive(check: Check, n: usize) -> Result<Option<(Drive, String)>> {
    let scene = check.scene;
    let Some(typed) = scene.drive else {
        return Ok(None);
    };
    let ends = scene.ends.unwrap_or_default();
    let is_wall = matches!(typed, DriveTyped::Wall | DriveTyped::WallVelocity);
    if is_wall && ends != EndsTyped::Fixed {
        let expected = "it only beside `ends = \"fixed\"`: there is a wall before site 0";
        return Err(check.fault("drive", expected, "other ends"));
    }
    let site = scene.drive_site.unwrap_or(0);
    if site >= n {
        return Err(check.fault("drive_site", format!("a body from 0 to {}", n - 1), site));
    }
    let (waveform, about) = waveform(check, typed)?;
    let (waveform, what) = match typed {
        DriveTyped::Force => (waveform, "force"),
        DriveTyped::Wall | DriveTyped::Displacement => (waveform.held(), "displacement"),
        DriveTyped::WallVelocity | DriveTyped::Velocity => {
            let displacement = waveform.integral();
            let displacement =
                displacement.map_err(|error| check.named(error, "drive_waveform"))?;
            (displacement, "velocity")
        }
    };
    let is_open = matches!(ends, EndsTyped::Wall | EndsTyped::Free);
    let (drive, of) = match typed {
        _ if is_wall => (Drive::Wall(waveform), "of the first wall".to_owned()),
        DriveTyped::Force => {
            let drive = match site == 0 && is_open {
                true => Drive::Force(waveform),
                false => Drive::Body(site, waveform),
            };
            (drive, format!("on site {site}"))
        }
        _ => (Drive::Motion(site, waveform), format!("of site {site}")),
    };
    Ok(Some((drive, format!("{what} {of}, {about}"))))
}

fn waveform(check: Check, typed: DriveTyped) -> Result<(Waveform, String)> {
    let scene = check.scene;
    let has_values = scene.drive_times.is_some() || scene.drive_values.is_some();
    let kind = scene.drive_waveform.unwrap_or(match has_values {
        true => WaveformTyped::Values,
        false => WaveformTyped::Sine,
    });
    let is_values = kind == WaveformTyped::Values;
    let amplitude = match (scene.drive_amplitude, is_values) {
        (None, true) => 1.0,
        (typed, _) => check.need("drive_amplitude", typed, "the amplitude of the drive")?,
    };
    if amplitude == 0.0 {
        return Err(check.fault("drive_amplitude", "a number other than 0", amplitude));
    }
    let [unit, hertz, seconds] = match (check.units, typed) {
        (Units::None, _) => [""; 3],
        (Units::Si, DriveTyped::Force) => [" N", " Hz", " s"],
        (Units::Si, DriveTyped::Wall | DriveTyped::Displacement) => [" m", " Hz", " s"],
        (Units::Si, _) => [" m/s", " Hz", " s"],
    };
    let [frequency, end, duration] = [
        scene.drive_frequency.map(|m| m.value),
        scene.drive_end_frequency.map(|m| m.value),
        scene.drive_duration.map(|m| m.value),
    ];
    let mut about = format!("{} of amplitude {amplitude}{unit}", name_of(&kind));
    let mut take = |key: &str, typed: Option<f64>, unit: &str| {
        let value = check.need(key, typed, "it beside this waveform")?;
        let name = key.trim_start_matches("drive_").replace('_', " ");
        about += &format!(", {name} {value}{unit}");
        Ok::<f64, Error>(value)
    };
    let waveform = match kind {
        WaveformTyped::Sine => {
            Waveform::sine(amplitude, take("drive_frequency", frequency, hertz)?)
        }
        WaveformTyped::HalfSine => {
            Waveform::half_sine(amplitude, take("drive_duration", duration, seconds)?)
        }
        WaveformTyped::ToneBurst => {
            let frequency = take("drive_frequency", frequency, hertz)?;
            let cycles = take("drive_cycles", scene.drive_cycles, "")?;
            Waveform::tone_burst(amplitude, frequency, cycles)
        }
        WaveformTyped::Chirp => {
            let from = take("drive_frequency", frequency, hertz)?;
            let to = take("drive_end_frequency", end, hertz)?;
            let duration = take("drive_duration", duration, seconds)?;
            Waveform::chirp(amplitude, [from, to], duration)
        }
        WaveformTyped::Noise => {
            let key = "drive_band";
            let band = check.need(key, scene.drive_band.as_ref(), "the band of the noise")?;
            let &[low, high] = band.as_slice() else {
                let expected = "two frequencies, the lowest and the highest";
                return Err(check.fault(key, expected, format!("{} values", band.len())));
            };
            if high <= low {
                let expected = "a lowest frequency and a higher one";
                return Err(check.fault(key, expected, format!("{low}, {high}")));
            }
            let seed = scene.drive_seed.or(scene.seed).unwrap_or(0);
            about += &format!(" (root mean square), band {low} to {high}{hertz}");
            let duration = duration.unwrap_or(f64::INFINITY);
            Waveform::noise(amplitude, [low, high], seed, duration)
        }
        WaveformTyped::Values => return values(check, amplitude, seconds),
    };
    Ok((waveform, about))
}

/// The spline through typed values.
fn values(check: Check, factor: f64, seconds: &str) -> Result<(Waveform, String)> {
    let scene = check.scene;
    let expected = "the times of the values";
    let times = check.need("drive_times", scene.drive_times.as_ref(), expected)?;
    let expected = "the drive at the times, or a `drive_file`";
    let values = check.need("drive_values", scene.drive_values.as_ref(), expected)?;
    if values.len() != times.len() {
        let expected = format!("{} values, one a time", times.len());
        return Err(check.fault("drive_values", expected, values.len()));
    }
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let median = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let is_gap = |at: &&[f64]| at[1] - at[0] > GAP * median && median > 0.0;
    if let Some(at) = times.windows(2).find(is_gap) {
        let expected = format!("times at most {GAP} times as far apart as most of them");
        let found = format!("a gap from {} to {}", at[0], at[1]);
        return Err(check.fault("drive_times", expected, found));
    }
    let scaled: Vec<f64> = values.iter().map(|value| factor * value).collect();
    let waveform = Waveform::through(times, &scaled);
    let waveform = waveform.map_err(|error| check.named(error, "drive_values"))?;
    if waveform.end() <= 0.0 {
        let (expected, found) = ("times after 0, when the run begins", waveform.end());
        return Err(check.fault("drive_times", expected, format!("all before {found}")));
    }
    if scaled.iter().all(|value| *value == 0.0) {
        return Err(check.fault("drive_values", "a value other than 0", "zeros alone"));
    }
    let (first, last) = (times[0], times[times.len() - 1]);
    let about = format!("{} values from {first} to {last}{seconds}", times.len());
    Ok((waveform, about))
}
