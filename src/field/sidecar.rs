//! A sidecar: a TOML file next to a field's file, with settings that the file itself cannot state.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::file_bytes::regular_file;
use super::{Layout, Quantity};
use crate::error::{Error, Fault, InputFault, Result};
use crate::measure::{Dimension, Frequency, Length, Measure, Time};

const LENGTH_LIMIT: u64 = 65_536;

/// The settings of a sidecar, all optional.
///
/// Steps and origins are numbers in the unit of their axis, or strings with a unit.
///
/// ```toml
/// layout = "time-site"
/// dt = "10 us" # or rate = "100 kHz"; fs is an alias of rate
/// dx = 1.0
/// t0 = 0.0
/// x0 = 0.0
/// time_unit = "s"
/// space_unit = "m"
/// quantity = "velocity"
/// unit = "m/s"
/// dispersion = "2*sqrt(c/m)*abs(sin(k*a/2)); c=1, m=1"
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sidecar {
    pub layout: Option<Layout>,
    /// Time step, above 0.
    #[serde(serialize_with = "typed", deserialize_with = "positive")]
    pub dt: Option<Measure<Time>>,
    /// Sampling rate, above 0; excludes `dt`.
    #[serde(alias = "fs", serialize_with = "typed", deserialize_with = "positive")]
    pub rate: Option<Measure<Frequency>>,
    /// Site spacing, above 0.
    #[serde(serialize_with = "typed", deserialize_with = "positive")]
    pub dx: Option<Measure<Length>>,
    /// Time of the first sample.
    #[serde(serialize_with = "typed")]
    pub t0: Option<Measure<Time>>,
    /// Position of the first site.
    #[serde(serialize_with = "typed")]
    pub x0: Option<Measure<Length>>,
    pub time_unit: Option<String>,
    pub space_unit: Option<String>,
    pub quantity: Option<Quantity>,
    /// Unit of the samples.
    pub unit: Option<String>,
    /// Dispersion relation that spectra are held against, as `--dispersion` takes it.
    pub dispersion: Option<String>,
}

impl Sidecar {
    /// The sidecar of a field, if any: `field.toml` or `field.npy.toml` next to `field.npy`.
    ///
    /// For a run `run.npz` or a field that this program wrote, [`Field::open`](super::Field::open) accepts
    /// only `run.npz.toml`: `run.toml` is its scene, or the sidecar of what it was made of. A scene is no sidecar.
    ///
    /// # Errors
    /// Both files exist, the sidecar cannot be read, or it has an unknown key.
    pub fn find(field: &Path) -> Result<Option<(PathBuf, Sidecar)>> {
        Sidecar::find_for(field, false)
    }

    /// As [`Sidecar::find`]; for a file of this program, only `run.npz.toml` is a sidecar.
    pub(super) fn find_for(field: &Path, is_own: bool) -> Result<Option<(PathBuf, Sidecar)>> {
        let replaced = field.with_extension("toml");
        let mut appended = OsString::from(field);
        appended.push(".toml");
        let appended = PathBuf::from(appended);
        let is_there = |path: &Path| path != field && path.symlink_metadata().is_ok();
        let is_own = is_own || is_scene(&replaced);
        let path = match (!is_own && is_there(&replaced), is_there(&appended)) {
            (false, false) => return Ok(None),
            (true, false) => replaced,
            (false, true) => appended,
            (true, true) => {
                let [first, second] = [&replaced, &appended].map(|path| path.to_string_lossy());
                let found = format!("{first:?} and {second:?}");
                let fault = Fault::expected("one sidecar", found, "keep one of the two");
                return Err(Error::input(field)(fault));
            }
        };
        let sidecar = Sidecar::read(&path)?;
        Ok(Some((path, sidecar)))
    }

    fn read(path: &Path) -> Result<Sidecar> {
        let fault = Error::input(path);
        let found = regular_file(path)?.len();
        if found > LENGTH_LIMIT {
            let limit = LENGTH_LIMIT;
            let expected = format!("at most {limit} bytes of settings");
            let advice = "keep only the settings of the field in it";
            return Err(fault(Fault::expected(expected, found, advice).into()));
        }
        let text = std::fs::read_to_string(path).map_err(Error::read("read", path))?;
        Sidecar::parse(&text).map_err(fault)
    }

    /// Reads the settings from TOML.
    ///
    /// # Errors
    /// With the line and the offending key.
    pub fn parse(text: &str) -> Result<Sidecar, InputFault> {
        let refused = |said: String| {
            let keys =
                "the keys are layout, dt, rate, dx, t0, x0, time_unit, space_unit, quantity, unit";
            InputFault::from(Fault::new(said, keys))
        };
        let fault = |error: &toml::de::Error, key: Option<String>| {
            let before = error.span().and_then(|span| text.get(..span.start));
            let line = before.map(|before| format!("line {}: ", before.matches('\n').count() + 1));
            let key = key.filter(|key| key != ".").map(|key| format!("{key}: "));
            refused(line.unwrap_or_default() + &key.unwrap_or_default() + error.message())
        };
        let deserializer = toml::Deserializer::parse(text).map_err(|error| fault(&error, None))?;
        let parsed: Result<Sidecar, _> = serde_path_to_error::deserialize(deserializer);
        let sidecar =
            parsed.map_err(|error| fault(error.inner(), Some(error.path().to_string())))?;
        match (sidecar.dt, sidecar.rate) {
            (Some(_), Some(_)) => Err(refused("rate: expected it or dt, found both".into())),
            _ => Ok(sidecar),
        }
    }

    /// The time step, from `dt` or `rate`.
    pub(super) fn step(&self) -> Option<Measure<Time>> {
        self.dt.or(self.rate.map(Measure::period))
    }
}

/// Whether a file states a chain, as the scene beside its records does.
fn is_scene(path: &Path) -> bool {
    const KEYS: &str = "sites law exponent stiffness_ratio mass_ratio mass_cell masses coefficient_cell coefficients \
                        striker_velocity striker_mass material radius ends drive precompression end_time samples";
    // Reading a pipe would wait for who writes to it.
    let is_short = regular_file(path).is_ok_and(|file| file.len() <= LENGTH_LIMIT);
    let text = is_short
        .then(|| std::fs::read_to_string(path).ok())
        .flatten();
    let table = text.and_then(|text| text.parse::<toml::Table>().ok());
    table.is_some_and(|table| KEYS.split_whitespace().any(|key| table.contains_key(key)))
}

fn positive<'de, R: Deserializer<'de>, D: Dimension>(
    deserializer: R,
) -> Result<Option<Measure<D>>, R::Error> {
    let measure = Measure::<D>::deserialize(deserializer)?;
    match measure.value > 0.0 {
        true => Ok(Some(measure)),
        false => Err(serde::de::Error::custom(format_args!(
            "expected a finite number above 0, found {}",
            measure.value
        ))),
    }
}

/// Writes a number with its unit if it has one: a bare number is in the unit of the axis.
fn typed<S: Serializer, D: Dimension>(
    stated: &Option<Measure<D>>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match stated {
        Some(measure) if measure.has_unit => {
            serializer.serialize_str(&format!("{} {}", measure.value, D::UNITS[0].0))
        }
        Some(measure) => serializer.serialize_f64(measure.value),
        None => serializer.serialize_none(),
    }
}
