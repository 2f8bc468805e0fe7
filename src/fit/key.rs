//! Keys of a scene that are fitted: their names, bounds, starting values, and how they are set.

use toml::Value;

use crate::chain::scene::{Kind, Property, SceneSource, Setting, properties};
use crate::error::nearest_key;
use crate::measure::{self, Dimension};
use crate::sweep::quantity;
use crate::{Error, Result};

const FORM: &str =
    "KEY or KEY=LOW..HIGH, such as young=50GPa..90GPa, mass_cell[1] or defect[0].factor";

/// Groups of keys that change how a run is made and not what runs.
const NO_PROPERTIES: [&str; 2] = ["Stepping", "What is kept"];

/// Share of the value, in both directions, over which starts without bounds are spread.
const SPREAD: f64 = 0.1;

/// A key as it is typed, without its bounds: `young`, `mass_cell[1]`, `defect[0].factor`.
#[derive(Debug, Clone, PartialEq)]
struct Place {
    /// As typed.
    shown: String,
    key: String,
    /// In a list, and in a table there.
    index: Option<usize>,
    member: Option<String>,
}

/// A key that is fitted, with its number at the start.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeKey {
    /// As typed, without bounds.
    pub name: String,
    /// The unit that the scene, or else a bound, states; empty for none.
    pub unit: String,
    pub start: f64,
    /// In the same unit; those of the scene where none are stated, which may be infinite.
    pub bounds: [f64; 2],
    /// Whether it is searched in its logarithm, as keys that are above 0 are.
    pub is_log: bool,
    place: Place,
    list: Option<Value>,
}

impl Place {
    fn parse(text: &str) -> Option<Place> {
        let (key, rest) = text.split_once('[').unwrap_or((text, ""));
        let (mut index, mut member) = (None, None);
        if key != text {
            let (number, behind) = rest.split_once(']')?;
            index = Some(number.trim().parse().ok()?);
            if !behind.trim().is_empty() {
                member = Some(behind.trim().strip_prefix('.')?.trim().to_owned());
            }
        }
        let key = key.trim().replace('-', "_");
        let mut shown = key.clone();
        shown.extend(index.map(|index: usize| format!("[{index}]")));
        shown.extend(member.iter().map(|member| format!(".{member}")));
        (!key.is_empty()).then_some(Place {
            shown,
            key,
            index,
            member,
        })
    }

    /// The property of the chain that it is, whose numbers can be searched continuously.
    fn property(&self) -> Result<&'static Property> {
        let Some(property) = properties().iter().find(|p| p.name == self.key) else {
            let near = nearest_key(&self.key, properties().iter().map(|p| &*p.name));
            let expected = match near {
                Some(near) => format!("a key of scenes (`{near}`?)"),
                None => "a key of scenes (`cascade scene` prints them)".into(),
            };
            return Err(refuse(&expected, &self.shown));
        };
        let expected = match (&property.kind, self.index, &self.member) {
            (Kind::Number | Kind::Measure { .. }, None, _)
            | (Kind::Numbers, Some(_), None)
            | (Kind::Tables, _, Some(_)) => {
                if !NO_PROPERTIES.contains(&property.group.as_str()) {
                    return Ok(property);
                }
                "a key of the chain or of what moves it, not of how a run is made".into()
            }
            (Kind::Numbers, ..) => format!("one number of the list, such as {}[0]", self.key),
            (Kind::Tables, ..) => format!("a number of a table, such as {}[0].factor", self.key),
            (Kind::Whole, ..) => {
                "a key that varies continuously: `cascade sweep` compares whole numbers".into()
            }
            _ => "a key whose value is a number".into(),
        };
        Err(refuse(&expected, &self.shown))
    }

    /// The number that a scene states, if it does.
    fn value<'v>(&self, stated: Option<&'v Value>) -> Result<Option<&'v Value>> {
        let Some(index) = self.index else {
            return Ok(stated);
        };
        let list = stated.and_then(Value::as_array);
        let expected = format!("an entry of the scene's {}", self.key);
        let entry = list.and_then(|list| list.get(index));
        let entry = entry.ok_or_else(|| refuse(&expected, &self.shown))?;
        Ok(match &self.member {
            Some(member) => entry.get(member),
            None => Some(entry),
        })
    }

    /// Puts a number in its place of what a scene states of the key.
    fn put(&self, number: Value, stated: &mut Value) {
        match (self.index, &self.member, stated) {
            (None, _, stated) => *stated = number,
            (Some(index), None, Value::Array(entries)) => entries[index] = number,
            (Some(index), Some(member), Value::Array(entries)) => {
                if let Some(table) = entries[index].as_table_mut() {
                    table.insert(member.clone(), number);
                }
            }
            _ => {}
        }
    }
}

impl FreeKey {
    /// Reads several, each of which may be there once.
    pub(super) fn each(texts: &[String], scene: &SceneSource) -> Result<Vec<FreeKey>> {
        let mut keys: Vec<FreeKey> = Vec::new();
        for text in texts {
            let key = FreeKey::of(text, scene)?;
            if keys.iter().any(|other| other.name == key.name) {
                return Err(refuse("each key once", &format!("{} twice", key.name)));
            }
            keys.push(key);
        }
        match keys.is_empty() {
            true => Err(refuse("a key to fit, such as young=50GPa..90GPa", "none")),
            false => Ok(keys),
        }
    }

    /// Reads a free key, and its starting value from the scene; without one there, the middle of its bounds. Bounds are no wider
    /// than the scene's own, such as 1 for a ratio.
    ///
    /// # Errors
    /// [`Error::Request`] for what cannot be read, an unknown key, one that holds no number or is no
    /// property of the chain, bounds in the wrong
    /// order, a start outside of them, and a key without a start.
    pub fn of(text: &str, scene: &SceneSource) -> Result<FreeKey> {
        let (path, bounds) = match text.split_once('=') {
            Some((path, bounds)) => (path, ends(bounds).map(Some)),
            None => (text, Some(None)),
        };
        let typed = Place::parse(path).zip(bounds);
        let (place, ends) = typed.ok_or_else(|| refuse(FORM, text))?;
        let property = place.property()?;
        let whole = scene.typed_value(&place.key)?;
        let stated = place.value(whole.as_ref())?.and_then(number_of);
        let units = ends.iter().flatten().map(|(_, unit)| unit);
        let of_bounds = units.clone().find(|unit| !unit.is_empty());
        let unit = match &stated {
            Some((_, unit)) => unit.clone(),
            None => of_bounds.cloned().unwrap_or_default(),
        };
        let bounds = ends.map(|ends| in_unit(&place, &ends, &unit)).transpose()?;
        let name = &place.shown;
        let start = match (stated, bounds) {
            (Some((value, _)), _) => value,
            (None, Some([low, high])) => middle(low, high),
            (None, None) => {
                let key = &place.key;
                let expected = format!("a value of {key} in the scene to start from, or bounds");
                return Err(refuse(&expected, "neither"));
            }
        };
        let [low, high] = bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let bounds = [low.max(property.least), high];
        if !(bounds[0]..=bounds[1]).contains(&start) {
            let value = format!("{start} {unit}");
            let expected = format!("bounds that hold the scene's {name} = {}", value.trim_end());
            return Err(refuse(&expected, text));
        }
        let is_open = bounds[1].is_infinite();
        if start == 0.0 && is_open {
            let expected = format!("bounds of {name}, which starts at 0, such as {name}=0..1");
            return Err(refuse(&expected, text));
        }
        Ok(FreeKey {
            name: name.clone(),
            unit,
            start,
            is_log: start > 0.0 && (bounds[0] > 0.0 || (property.is_above && is_open)),
            bounds,
            list: whole.filter(|_| place.index.is_some()),
            place,
        })
    }

    /// What a unit of its coordinate is, for keys that are not searched in their logarithm.
    pub(super) fn scale(&self) -> f64 {
        let span = self.bounds[1] - self.bounds[0];
        if span.is_finite() {
            span
        } else {
            self.start.abs()
        }
    }

    /// The value at a coordinate of the search.
    pub(crate) fn value_at(&self, u: f64) -> f64 {
        let value = match self.is_log {
            true => self.start * u.exp(),
            false => self.start + self.scale() * u,
        };
        value.clamp(self.bounds[0], self.bounds[1])
    }

    /// The coordinate of a value.
    pub(crate) fn coordinate(&self, value: f64) -> f64 {
        match self.is_log {
            true => (value / self.start).ln(),
            false => (value - self.start) / self.scale(),
        }
    }

    /// Bounds of the coordinate.
    pub(crate) fn coordinates(&self) -> [f64; 2] {
        let least = if self.is_log { 0.0 } else { f64::NEG_INFINITY };
        self.bounds.map(|end| self.coordinate(end.max(least)))
    }

    /// A start at this share, in 0..1, of what the bounds, or else a tenth up and down, span.
    pub(super) fn spread(&self, share: f64) -> f64 {
        let [low, high] = self.coordinates();
        let low = if low.is_finite() { low } else { -SPREAD };
        let high = if high.is_finite() { high } else { SPREAD };
        low + share * (high - low)
    }
}

/// The settings that give keys these values; entries of one list are set together.
pub(crate) fn settings(keys: &[FreeKey], values: impl Iterator<Item = f64>) -> Vec<Setting> {
    let mut set: Vec<(&str, Value)> = Vec::new();
    for (key, value) in keys.iter().zip(values) {
        let name = key.place.key.as_str();
        if !set.iter().any(|(other, _)| *other == name) {
            set.push((name, key.list.clone().unwrap_or(Value::Float(0.0))));
        }
        let stated = set.iter_mut().find(|(other, _)| *other == name);
        if let Some((_, stated)) = stated {
            let number = match key.unit.as_str() {
                "" => Value::Float(value),
                unit => Value::String(format!("{value:?} {unit}")),
            };
            key.place.put(number, stated);
        }
    }
    let text = |value: Value| match value {
        Value::String(text) => text,
        other => other.to_string(),
    };
    set.into_iter()
        .map(|(name, value)| Setting::new(name, text(value), format!("--free {name}")))
        .collect()
}

/// Bounds in a unit; one that states none has that of the upper one.
fn in_unit(place: &Place, ends: &[(f64, String); 2], unit: &str) -> Result<[f64; 2]> {
    let of = |(value, own): &(f64, String)| {
        let own = if own.is_empty() { &ends[1].1 } else { own };
        match ratio(own, unit) {
            _ if own == unit => Ok(*value),
            Some(ratio) => Ok(value * ratio),
            None => Err(refuse(&format!("bounds of {} in {unit}", place.shown), own)),
        }
    };
    let [low, high] = [of(&ends[0])?, of(&ends[1])?];
    match low < high {
        true => Ok([low, high]),
        false => Err(refuse("the lower bound first", &format!("{low}..{high}"))),
    }
}

fn middle(low: f64, high: f64) -> f64 {
    match low > 0.0 {
        true => (low * high).sqrt(),
        false => 0.5 * (low + high),
    }
}

fn ends(text: &str) -> Option<[(f64, String); 2]> {
    let (low, high) = text.split_once("..")?;
    let end = |text: &str| {
        let (value, unit) = quantity(text)?;
        value.is_finite().then(|| (value, unit.to_owned()))
    };
    Some([end(low)?, end(high)?])
}

fn number_of(value: &Value) -> Option<(f64, String)> {
    match value {
        Value::Integer(number) => Some((*number as f64, String::new())),
        Value::Float(number) => Some((*number, String::new())),
        Value::String(text) => quantity(text).map(|(number, unit)| (number, unit.to_owned())),
        _ => None,
    }
}

/// One unit over another of the same dimension; a number without a unit is in the first one of its dimension.
pub(super) fn ratio(unit: &str, other: &str) -> Option<f64> {
    fn of<D: Dimension>(unit: &str) -> Option<f64> {
        match unit {
            "" => Some(1.0),
            unit => measure::size::<D>(unit),
        }
    }
    let all = [
        of::<measure::Length>,
        of::<measure::Time>,
        of::<measure::Speed>,
        of::<measure::Mass>,
        of::<measure::Density>,
        of::<measure::Pressure>,
        of::<measure::Force>,
        of::<measure::Frequency>,
        of::<measure::Angle>,
    ];
    all.iter().find_map(|size| Some(size(unit)? / size(other)?))
}

pub(super) fn refuse(expected: &str, found: &str) -> Error {
    Error::request("free", expected, found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> SceneSource {
        let text = "sites = 5\nmaterial = \"steel\"\nradius = \"9 mm\"\nyoung = \"72 GPa\"\npoisson = 0.17\n\
                    density = 2200\nmass_cell = [1.0, 2.0]\n[[defect]]\nsite = 2\nfactor = 2.0";
        SceneSource::new(None, text)
    }

    #[test]
    fn keys_are_read_with_units_and_set_again() {
        let of = |text: &str| FreeKey::of(text, &scene()).unwrap();
        let young = of("young=50e9..90e9");
        assert_eq!(
            (young.start, &*young.unit, young.is_log),
            (72.0, "GPa", true)
        );
        assert!((young.bounds[1] - 90.0).abs() < 1e-12, "{:?}", young.bounds);
        let set = |keys: &[FreeKey], values: &[f64]| -> Vec<String> {
            let all = settings(keys, values.iter().copied());
            all.into_iter().map(|setting| setting.text).collect()
        };
        assert_eq!(set(std::slice::from_ref(&young), &[60.5]), ["60.5 GPa"]);
        assert!((young.value_at(young.coordinate(61.0)) - 61.0).abs() < 1e-12);
        let entries = [of("mass_cell[1]"), of("mass_cell[0]")];
        assert_eq!(set(&entries, &[2.5, 0.5]), ["[0.5, 2.5]"]);
        let factor = of("defect[0].factor=1..3");
        assert!(set(&[factor], &[1.5])[0].contains("factor = 1.5"));
        let tangent = of("tangent=0..5us");
        let found = (tangent.start, tangent.is_log, tangent.scale());
        assert_eq!(found, (2.5, false, 5.0));
    }

    /// A ratio is 1 or more, a loss 0 or more, a coefficient of a law may be negative: by what scenes accept.
    #[test]
    fn keys_have_the_bounds_of_the_scene() {
        let text = "sites = 5\nstiffness_ratio = 1\nlaw = \"spring\"\nalpha = -0.1\ndashpot = 0.1\nmass_ratio = 2";
        let scene = SceneSource::new(None, text);
        for (text, low, is_log) in [
            ("stiffness_ratio", 1.0, true),
            ("stiffness_ratio=0.5..3", 1.0, true),
            ("stiffness_ratio=0.5..0.9", f64::NAN, false),
            ("alpha", f64::NEG_INFINITY, false),
            ("dashpot", 0.0, false),
            ("mass_ratio", 0.0, true),
        ] {
            match FreeKey::of(text, &scene) {
                Ok(key) => assert_eq!((key.bounds[0], key.is_log), (low, is_log), "{text}"),
                Err(error) => assert!(low.is_nan(), "{text}: {error}"),
            }
        }
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        for (text, part) in [
            ("", "KEY"),
            ("young=3", "LOW..HIGH"),
            ("young=90GPa..50GPa", "lower bound first"),
            ("young=80GPa..90GPa", "hold the scene's young"),
            ("yuong", "`young`?"),
            ("sites", "sweep"),
            ("end_time=5..10", "a key of the chain"),
            ("ends", "is a number"),
            ("mass_cell", "mass_cell[0]"),
            ("mass_cell[7]", "an entry"),
            ("tangent", "to start from"),
            ("young=1s..2s", "bounds of young in GPa"),
        ] {
            let error = FreeKey::of(text, &scene()).unwrap_err();
            assert!(error.to_string().contains(part), "{text}: {error}");
        }
    }
}
