//! A sidecar: a TOML file beside a field that states what the field's file cannot.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize};

use super::fault::InputFault;
use super::open::regular_file;
use super::{Layout, Quantity};
use crate::error::{Error, Result};

const LENGTH_LIMIT: u64 = 65_536;

/// The settings of a sidecar, all optional.
///
/// ```toml
/// layout = "time-site"
/// dt = 0.05
/// dx = 1.0
/// t0 = 0.0
/// x0 = 0.0
/// time_unit = "s"
/// space_unit = "m"
/// quantity = "velocity"
/// unit = "m/s"
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sidecar {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layout: Option<Layout>,
    /// Time step, above 0.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "positive")]
    pub dt: Option<f64>,
    /// Distance of neighbouring sites, above 0.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "positive")]
    pub dx: Option<f64>,
    /// Time of the first sample.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "finite")]
    pub t0: Option<f64>,
    /// Place of the first site.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "finite")]
    pub x0: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_unit: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub space_unit: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quantity: Option<Quantity>,
    /// Unit of the samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

impl Sidecar {
    /// The sidecar of a field: `field.toml` or `field.npy.toml` beside `field.npy`, if any.
    ///
    /// A run file states its own axes, and `run.toml` beside `run.npz` is its scene:
    /// [`Field::open`](super::Field::open) takes only `run.npz.toml` for the sidecar of a run.
    ///
    /// # Errors
    /// Both are there, one cannot be read, or one states something other than the known keys.
    pub fn find(field: &Path) -> Result<Option<(PathBuf, Sidecar)>> {
        Sidecar::find_for(field, false)
    }

    /// As [`Sidecar::find`]; beside a run only `run.npz.toml` is a sidecar.
    pub(super) fn find_for(field: &Path, is_run: bool) -> Result<Option<(PathBuf, Sidecar)>> {
        let replaced = field.with_extension("toml");
        let mut appended = OsString::from(field);
        appended.push(".toml");
        let appended = PathBuf::from(appended);
        let is_there = |path: &Path| path != field && path.symlink_metadata().is_ok();
        let path = match (!is_run && is_there(&replaced), is_there(&appended)) {
            (false, false) => return Ok(None),
            (true, false) => replaced,
            (false, true) => appended,
            (true, true) => {
                let name = |path: &Path| path.to_string_lossy().into_owned();
                return Err(Error::Input {
                    path: field.to_owned(),
                    fault: InputFault::TwoSidecars {
                        first: name(&replaced),
                        second: name(&appended),
                    },
                });
            }
        };
        let sidecar = Sidecar::read(&path)?;
        Ok(Some((path, sidecar)))
    }

    fn read(path: &Path) -> Result<Sidecar> {
        let fault = |fault| Error::Input {
            path: path.to_owned(),
            fault,
        };
        let found = regular_file(path)?.len();
        if found > LENGTH_LIMIT {
            let limit = LENGTH_LIMIT;
            return Err(fault(InputFault::SidecarLength { found, limit }));
        }
        let text = std::fs::read_to_string(path).map_err(Error::read("read", path))?;
        Sidecar::parse(&text).map_err(fault)
    }

    /// Reads the settings from TOML.
    ///
    /// # Errors
    /// [`InputFault::Sidecar`] with the line and the key at fault.
    pub fn parse(text: &str) -> std::result::Result<Sidecar, InputFault> {
        let line_of = |error: &toml::de::Error| {
            let before = text.get(..error.span()?.start)?;
            Some(before.matches('\n').count() + 1)
        };
        let deserializer =
            toml::Deserializer::parse(text).map_err(|error| InputFault::Sidecar {
                line: line_of(&error),
                key: None,
                reason: error.message().to_owned(),
            })?;
        serde_path_to_error::deserialize(deserializer).map_err(|error| InputFault::Sidecar {
            line: line_of(error.inner()),
            key: Some(error.path().to_string()).filter(|key| key != "."),
            reason: error.inner().message().to_owned(),
        })
    }
}

fn positive<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> std::result::Result<Option<f64>, D::Error> {
    number(deserializer, "a finite number above 0", |value| value > 0.0)
}

fn finite<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> std::result::Result<Option<f64>, D::Error> {
    number(deserializer, "a finite number", |_| true)
}

fn number<'de, D: Deserializer<'de>>(
    deserializer: D,
    expected: &str,
    accept: impl Fn(f64) -> bool,
) -> std::result::Result<Option<f64>, D::Error> {
    let value = f64::deserialize(deserializer)?;
    if value.is_finite() && accept(value) {
        Ok(Some(value))
    } else {
        Err(serde::de::Error::custom(format_args!(
            "expected {expected}, found {value}"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(text: &str) -> (Option<usize>, Option<String>, String) {
        match Sidecar::parse(text) {
            Err(InputFault::Sidecar { line, key, reason }) => (line, key, reason),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_is_written_is_read_back() {
        let sidecar = Sidecar {
            layout: Some(Layout::SiteTime),
            dt: Some(0.05),
            time_unit: Some("s".into()),
            quantity: Some(Quantity::StrainRate),
            ..Sidecar::default()
        };
        let text = toml::to_string(&sidecar).unwrap();
        assert_eq!(Sidecar::parse(&text), Ok(sidecar));
        assert!(!text.contains("dx"));
    }

    #[test]
    fn the_fault_names_line_and_key() {
        let (line, key, reason) = fault("dt = 1\ndx = -2.0\n");
        assert_eq!((line, key.as_deref()), (Some(2), Some("dx")));
        assert_eq!(reason, "expected a finite number above 0, found -2");

        let (line, key, _) = fault("dt = 1\n\nlayout = \"sideways\"\n");
        assert_eq!((line, key.as_deref()), (Some(3), Some("layout")));

        let (line, _, reason) = fault("dt = 1\nDT = 2\n");
        assert_eq!(line, Some(2));
        assert!(reason.contains("DT"), "{reason}");

        assert_eq!(fault("dt = 1\ndx = \n").0, Some(2));
        assert_eq!(fault("t0 = nan").1.as_deref(), Some("t0"));
        assert_eq!(fault("dt = inf").1.as_deref(), Some("dt"));
        assert_eq!(fault("dt = \"0.1\"").1.as_deref(), Some("dt"));
    }
}
