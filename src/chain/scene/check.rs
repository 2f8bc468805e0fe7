//! The rules that keys declare, checked for all of them; shared by what else is checked: the scene, the places of its keys.

use std::fmt::Display;

use toml::{Table, Value};

use super::places::Places;
use super::properties::{Kind, Property, properties, property};
use super::{EndsTyped, Scene, Units};
use crate::error::{Error, Result, listed};
use crate::measure::counted;

/// Keys of which one makes the bodies of an SI scene.
const MATERIAL: [&str; 2] = ["material", "young"];

/// The units of a scene.
pub(super) fn units(table: &Table) -> Units {
    match table.get("units").and_then(Value::as_str) {
        Some("si") => Units::Si,
        None if MATERIAL.iter().any(|key| table.contains_key(*key)) => Units::Si,
        _ => Units::None,
    }
}

/// That the typed keys go together.
pub(super) fn keys(table: &Table, places: &Places) -> Result<()> {
    let is_typed = |key: &&String| table.contains_key(*key);
    if units(table) == Units::None && MATERIAL.iter().any(|key| table.contains_key(*key)) {
        let found = "none, though the scene has a material";
        return Err(places.fault("units", "si", found));
    }
    for property in properties().iter().filter(|of| is_typed(&&of.name)) {
        let key = &property.name;
        if let Some(other) = property.excludes.iter().find(is_typed) {
            let expected = format!("one key of `{key}` and `{other}`, which decide the same");
            let found = format!("it beside {}", places.mention(other));
            return Err(places.fault(key, expected, found));
        }
        if !(property.beside.is_empty() || property.beside.iter().any(|key| is_typed(&key))) {
            let expected = format!("it only beside {}", listed(&property.beside));
            return Err(places.fault(key, expected, "it alone"));
        }
        for (other, words) in &property.only_where {
            let word = word_of(other, table);
            if !words.iter().any(|allowed| allowed == word) {
                let expected = format!("it only beside `{other}` {}", listed(words));
                return Err(places.fault(key, expected, format!("`{word}`")));
            }
        }
    }
    Ok(())
}

/// That numbers have no units where the scene has none.
pub(super) fn texts(table: &Table, places: &Places) -> Result<()> {
    for property in properties().iter().filter(|of| of.name != "memory") {
        let typed = table.get(&property.name).and_then(Value::as_str);
        if let (Kind::Measure { words, .. }, Some(text)) = (&property.kind, typed)
            && units(table) == Units::None
            && !words.iter().any(|word| word == text)
        {
            let expected = "a number alone, since the scene is not in SI";
            return Err(places.fault(&property.name, expected, "a unit"));
        }
    }
    Ok(())
}

/// The word that is typed of a key, or holds by default.
fn word_of<'t>(key: &str, table: &'t Table) -> &'t str {
    let typed = table.get(key).and_then(Value::as_str);
    let default = || property(key)?.default.as_ref()?.as_str();
    let has_values = ["drive_file", "drive_times", "drive_values"]
        .iter()
        .any(|key| table.contains_key(*key));
    typed.or_else(default).unwrap_or(match has_values {
        true => "values",
        false => "sine",
    })
}

/// A scene while it is worked out.
#[derive(Clone, Copy)]
pub(super) struct Check<'a> {
    pub(super) scene: &'a Scene,
    pub(super) places: &'a Places,
    pub(super) units: Units,
}

impl<'a> Check<'a> {
    pub(super) fn new(scene: &'a Scene, places: &'a Places) -> Check<'a> {
        let has_material = scene.material.is_some() || scene.young.is_some();
        let by_material = if has_material { Units::Si } else { Units::None };
        Check {
            scene,
            places,
            units: scene.units.unwrap_or(by_material),
        }
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
        self.places.fault(key, expected, found)
    }

    /// The value of a key that must be there.
    pub(super) fn need<T>(&self, key: &str, value: Option<T>, expected: &str) -> Result<T> {
        value.ok_or_else(|| self.fault(key, expected, "nothing"))
    }

    /// A number that is made of others, or one of a table.
    pub(super) fn positive(&self, key: &str, value: f64) -> Result<f64> {
        if value > 0.0 && value.is_finite() {
            return Ok(value);
        }
        Err(self.fault(key, "a finite number above 0", value))
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

    /// The number of contacts.
    pub(super) fn contacts(&self, sites: usize) -> usize {
        match self.scene.ends.unwrap_or_default() {
            EndsTyped::Free => sites - 1,
            _ => sites,
        }
    }

    /// That all numbers are within their bounds, and that lists are as long as the chain, or cells of it.
    pub(super) fn values(&self, sites: usize) -> Result<()> {
        let values = Table::try_from(self.scene);
        let values = values.map_err(|error| self.fault("", "values that TOML can hold", error))?;
        for property in properties() {
            let key = &property.name;
            let check = |key: &str, value: &Value| {
                let number = value
                    .as_float()
                    .or(value.as_integer().map(|whole| whole as f64));
                match number.filter(|number| !property.allows(*number)) {
                    Some(number) => Err(self.fault(key, property.bounds(), number)),
                    None => Ok(()),
                }
            };
            match values.get(key) {
                Some(Value::Array(list)) => {
                    self.list(property, list.len(), sites)?;
                    let mut each = list.iter().enumerate();
                    each.try_for_each(|(i, value)| check(&format!("{key}[{i}]"), value))?;
                }
                Some(value) => check(key, value)?,
                None => {}
            }
        }
        // A ratio is a cell of two.
        let is_odd = sites % 2 == 1 && self.scene.ends == Some(EndsTyped::Periodic);
        let pairs = ["stiffness_ratio", "second_angle", "mass_ratio"];
        match pairs.iter().find(|key| is_odd && self.places.has(key)) {
            Some(key) => {
                let expected = format!("a cell that fits into the {sites} sites of the ring");
                Err(self.fault(key, expected, "2 values"))
            }
            None => Ok(()),
        }
    }

    fn list(&self, property: &Property, number: usize, sites: usize) -> Result<()> {
        let (key, Some(length)) = (&property.name, property.length) else {
            return Ok(());
        };
        let (most, of) = match length.is_of_sites {
            true => (sites, "site"),
            false => (self.contacts(sites), "contact"),
        };
        let is_ring = self.scene.ends == Some(EndsTyped::Periodic);
        let expected = match length.repeats {
            false if number != most => format!("{}, one a {of}", counted(most, "value")),
            true if number == 0 => "at least one value".into(),
            true if number > most => format!("at most {}, one a {of}", counted(most, "value")),
            true if is_ring && !most.is_multiple_of(number) => {
                format!(
                    "a cell that fits into the {} of the ring",
                    counted(most, "site")
                )
            }
            _ => return Ok(()),
        };
        Err(self.fault(key, expected, counted(number, "value")))
    }
}
