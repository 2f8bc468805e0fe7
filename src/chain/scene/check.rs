//! Shared by all checks of a scene: the scene, the places of its keys, and the construction of
//! faults.

use std::fmt::Display;

use super::places::Places;
use super::{Scene, Units};
use crate::error::{Error, Result, SceneFault};

/// A scene while it is worked out.
#[derive(Clone, Copy)]
pub(super) struct Check<'a> {
    pub(super) scene: &'a Scene,
    pub(super) places: &'a Places,
    pub(super) units: Units,
}

/// Keys of the geometry, which have no effect without a material.
const NEED_MATERIAL: [&str; 13] = [
    "poisson",
    "density",
    "shape",
    "radius",
    "length",
    "angle",
    "second_angle",
    "angle_cell",
    "ellipse",
    "striker_radius",
    "striker_material",
    "wall_radius",
    "wall_material",
];

impl<'a> Check<'a> {
    /// Settles the units, by which everything else is read.
    pub(super) fn new(scene: &'a Scene, places: &'a Places) -> Result<Check<'a>> {
        let has_material = scene.material.is_some() || scene.young.is_some();
        let units = match (scene.units, has_material) {
            (Some(units), _) => units,
            (None, true) => Units::Si,
            (None, false) => Units::None,
        };
        let check = Check {
            scene,
            places,
            units,
        };
        if units == Units::None && has_material {
            let found = "none, though the scene has a material";
            return Err(check.fault("units", "si", found));
        }
        if !has_material {
            check.only_with(&NEED_MATERIAL, false, "`material`")?;
        }
        if units == Units::None {
            check.no_unit_texts()?;
        }
        Ok(check)
    }

    pub(super) fn has_material(&self) -> bool {
        self.scene.material.is_some() || self.scene.young.is_some()
    }

    pub(super) fn fault(
        &self,
        key: &str,
        expected: impl Into<String>,
        found: impl Display,
    ) -> Error {
        Error::scene(SceneFault::new(self.places.of(key), key, expected, found))
    }

    /// The value of a key that must be there.
    pub(super) fn need<T>(&self, key: &str, value: Option<T>, expected: &str) -> Result<T> {
        value.ok_or_else(|| self.fault(key, expected, "nothing"))
    }

    pub(super) fn positive(&self, key: &str, value: f64) -> Result<f64> {
        if value > 0.0 && value.is_finite() {
            return Ok(value);
        }
        Err(self.fault(key, "a finite number above 0", value))
    }

    pub(super) fn not_negative(&self, key: &str, value: f64) -> Result<f64> {
        if value >= 0.0 && value.is_finite() {
            return Ok(value);
        }
        Err(self.fault(key, "a finite number of 0 or more", value))
    }

    pub(super) fn finite(&self, key: &str, value: f64) -> Result<f64> {
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.fault(key, "a finite number", value))
    }

    /// All of a list, each item named where it is at fault.
    pub(super) fn all_positive(&self, key: &str, values: &[f64]) -> Result<()> {
        let each = values.iter().enumerate();
        each.map(|(i, &value)| self.positive(&format!("{key}[{i}]"), value))
            .try_for_each(|checked| checked.map(|_| ()))
    }

    /// A list as long as the chain, of finite numbers.
    pub(super) fn length(&self, key: &str, values: &[f64], n: usize, of: &str) -> Result<()> {
        if values.len() != n {
            return Err(self.fault(key, format!("{n} values, one a {of}"), values.len()));
        }
        Ok(())
    }

    /// Rejects keys that have no effect because their condition does not hold.
    pub(super) fn only_with(&self, keys: &[&str], holds: bool, with: &str) -> Result<()> {
        match keys.iter().find(|key| !holds && self.places.has(key)) {
            Some(key) => Err(self.fault(key, format!("it only beside {with}"), "it alone")),
            None => Ok(()),
        }
    }

    /// Refuses two keys that both decide the same; the first one typed of `keys`, if any.
    pub(super) fn one_of(&self, keys: &[&'static str], what: &str) -> Result<Option<&'static str>> {
        let mut typed = keys.iter().copied().filter(|key| self.places.has(key));
        match (typed.next(), typed.next()) {
            (Some(first), Some(second)) => Err(self.fault(
                second,
                format!("one key that decides {what}"),
                format!("it beside {}", self.places.mention(first)),
            )),
            (first, _) => Ok(first),
        }
    }

    /// A fault that the library found in a value, under the key it was typed with.
    pub(super) fn named(&self, error: Error, key: &str) -> Error {
        match error {
            Error::Request {
                option,
                expected,
                found,
            } => {
                let own = option.replace('-', "_");
                let key = if self.places.has(&own) { &own } else { key };
                self.fault(key, expected, found)
            }
            other => other,
        }
    }

    fn no_unit_texts(&self) -> Result<()> {
        let s = self.scene;
        let typed = [
            ("precompression", s.precompression.map(|m| m.has_unit)),
            ("striker_mass", s.striker_mass.map(|m| m.has_unit)),
            ("striker_velocity", s.striker_velocity.map(|m| m.has_unit)),
            ("mode_amplitude", s.mode_amplitude.map(|m| m.has_unit)),
            ("drive_frequency", s.drive_frequency.map(|m| m.has_unit)),
            (
                "drive_end_frequency",
                s.drive_end_frequency.map(|m| m.has_unit),
            ),
            ("drive_duration", s.drive_duration.map(|m| m.has_unit)),
            ("tangent", s.tangent.map(|m| m.has_unit)),
            ("step", s.step.map(|m| m.has_unit)),
            (
                "end_time",
                match s.end_time {
                    Some(super::EndTimeTyped::At(time)) => Some(time.has_unit),
                    _ => None,
                },
            ),
        ];
        match typed.iter().find(|(_, has_unit)| *has_unit == Some(true)) {
            Some((key, _)) => {
                let expected = "a number alone, since the scene is not in SI";
                Err(self.fault(key, expected, "a unit"))
            }
            None => Ok(()),
        }
    }
}
