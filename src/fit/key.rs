//! Keys of a scene that are fitted: their names, bounds, starting values, and how they are set.

use toml::Value;

use crate::chain::scene::{Kind, SceneSource, Setting, properties};
use crate::error::nearest_key;
use crate::measure::{self, Dimension};
use crate::sweep::quantity;
use crate::{Error, Result};

const FORM: &str =
    "KEY or KEY=LOW..HIGH, such as young=50GPa..90GPa, mass_cell[1] or defect[0].factor";

/// Share of the value, in both directions, over which starts without bounds are spread.
const SPREAD: f64 = 0.1;

/// A fitted key as it is typed: `young`, `young=50GPa..90GPa`, `mass_cell[1]`, `defect[0].factor=1..3`.
#[derive(Debug, Clone, PartialEq)]
struct TypedKey {
    name: String,
    place: Place,
    bounds: Option<[(f64, String); 2]>,
}

/// Which number of a key's value.
#[derive(Debug, Clone, PartialEq)]
enum Place {
    Whole,
    Entry(usize),
    Member(usize, String),
}

/// A key that is fitted, with its number at the start.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeKey {
    /// As typed, without bounds.
    pub name: String,
    /// The unit that the scene, or else a bound, states; empty for none.
    pub unit: String,
    pub start: f64,
    /// In the same unit; infinite where none are stated.
    pub bounds: [f64; 2],
    /// Whether it is searched in its logarithm, as positive keys are.
    pub is_log: bool,
    typed: TypedKey,
    list: Option<Value>,
}

impl TypedKey {
    fn parse(text: &str) -> Result<TypedKey> {
        let refuse = || refuse(FORM, text);
        let (path, bounds) = match text.split_once('=') {
            Some((path, bounds)) => (path, Some(ends(bounds).ok_or_else(refuse)?)),
            None => (text, None),
        };
        let (name, place) = match path.split_once('[') {
            None => (path, Place::Whole),
            Some((name, rest)) => {
                let (index, member) = rest.split_once(']').ok_or_else(refuse)?;
                let index = index.trim().parse().map_err(|_| refuse())?;
                match member.trim().strip_prefix('.') {
                    Some(member) => (name, Place::Member(index, member.trim().to_owned())),
                    None if member.trim().is_empty() => (name, Place::Entry(index)),
                    None => return Err(refuse()),
                }
            }
        };
        let name = name.trim().replace('-', "_");
        if name.is_empty() {
            return Err(refuse());
        }
        Ok(TypedKey {
            name,
            place,
            bounds,
        })
    }

    fn shown(&self) -> String {
        match &self.place {
            Place::Whole => self.name.clone(),
            Place::Entry(index) => format!("{}[{index}]", self.name),
            Place::Member(index, member) => format!("{}[{index}].{member}", self.name),
        }
    }

    /// Whether numbers can be searched continuously.
    fn check(&self) -> Result<()> {
        let shown = self.shown();
        let Some(property) = properties().iter().find(|p| p.name == self.name) else {
            let near = nearest_key(&self.name, properties().iter().map(|p| &*p.name));
            let expected = match near {
                Some(near) => format!("a key of scenes (`{near}`?)"),
                None => "a key of scenes (`cascade scene` prints them)".into(),
            };
            return Err(refuse(&expected, &shown));
        };
        let expected = match (&property.kind, &self.place) {
            (Kind::Number | Kind::Measure { .. }, Place::Whole) => return Ok(()),
            (Kind::Numbers, Place::Entry(_)) | (Kind::Tables, Place::Member(..)) => return Ok(()),
            (Kind::Numbers, _) => format!("one number of the list, such as {}[0]", self.name),
            (Kind::Tables, _) => format!("a number of a table, such as {}[0].factor", self.name),
            (Kind::Whole, _) => {
                "a key that varies continuously: `cascade sweep` compares whole numbers".into()
            }
            _ => "a key whose value is a number".into(),
        };
        Err(refuse(&expected, &shown))
    }

    /// The number that the scene states, with the list that holds it.
    fn value<'v>(&self, whole: Option<&'v Value>) -> Result<Option<&'v Value>> {
        let list = |index: &usize| {
            let found = whole
                .and_then(Value::as_array)
                .and_then(|list| list.get(*index));
            let expected = format!("an entry of the scene's {}", self.name);
            found.ok_or_else(|| refuse(&expected, &self.shown()))
        };
        match &self.place {
            Place::Whole => Ok(whole),
            Place::Entry(index) => list(index).map(Some),
            Place::Member(index, member) => Ok(list(index)?.get(member)),
        }
    }
}

impl FreeKey {
    /// Reads a free key, and its starting value from the scene; without one there, the middle of its bounds.
    ///
    /// # Errors
    /// [`Error::Request`] for what cannot be read, an unknown key, one that holds no number, bounds in the wrong
    /// order, a start outside of them, and a key without a start.
    pub fn of(text: &str, scene: &SceneSource) -> Result<FreeKey> {
        let typed = TypedKey::parse(text)?;
        typed.check()?;
        let whole = scene.typed_value(&typed.name)?;
        let stated = typed.value(whole.as_ref())?.and_then(number_of);
        let from_bounds = || typed.bounds.iter().flatten().map(|(_, unit)| unit.clone());
        let unit = match &stated {
            Some((_, unit)) => unit.clone(),
            None => from_bounds()
                .find(|unit| !unit.is_empty())
                .unwrap_or_default(),
        };
        let bounds = typed.in_unit(&unit)?;
        let start = match (stated, bounds) {
            (Some((value, _)), _) => value,
            (None, [low, high]) if (high - low).is_finite() => middle(low, high),
            (None, _) => {
                let expected = format!(
                    "a value of {} in the scene to start from, or bounds",
                    typed.name
                );
                return Err(refuse(&expected, "neither"));
            }
        };
        if !(bounds[0]..=bounds[1]).contains(&start) {
            let expected = format!("bounds that hold the scene's {} = {start}", typed.shown());
            return Err(refuse(&expected, text));
        }
        let is_open = bounds[1].is_infinite();
        if start == 0.0 && is_open {
            let expected = format!(
                "bounds of {0}, which starts at 0, such as {0}=0..1",
                typed.shown()
            );
            return Err(refuse(&expected, text));
        }
        let list = whole.filter(|_| typed.place != Place::Whole);
        Ok(FreeKey {
            name: typed.shown(),
            unit,
            start,
            is_log: start > 0.0 && (bounds[0] > 0.0 || is_open),
            bounds,
            typed,
            list,
        })
    }

    /// Puts a value in its place of what the scene states of its key.
    fn put(&self, value: f64, stated: &mut Value) {
        let one = match self.unit.as_str() {
            "" => Value::Float(value),
            unit => Value::String(format!("{value:?} {unit}")),
        };
        match (&self.typed.place, stated) {
            (Place::Whole, stated) => *stated = one,
            (Place::Entry(index), Value::Array(entries)) => entries[*index] = one,
            (Place::Member(index, member), Value::Array(entries)) => {
                if let Some(table) = entries[*index].as_table_mut() {
                    table.insert(member.clone(), one);
                }
            }
            _ => {}
        }
    }

    /// What a unit of its coordinate is, for keys that are not searched in their logarithm.
    fn scale(&self) -> f64 {
        match (self.bounds[1] - self.bounds[0]).is_finite() {
            true => self.bounds[1] - self.bounds[0],
            false => self.start.abs(),
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
        match self.is_log {
            true => [
                self.coordinate(self.bounds[0].max(0.0)),
                self.coordinate(self.bounds[1]),
            ],
            false => self.bounds.map(|end| self.coordinate(end)),
        }
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
        let name = key.typed.name.as_str();
        if !set.iter().any(|(other, _)| *other == name) {
            set.push((name, key.list.clone().unwrap_or(Value::Float(0.0))));
        }
        let stated = set.iter_mut().find(|(other, _)| *other == name);
        if let Some((_, stated)) = stated {
            key.put(value, stated);
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

impl TypedKey {
    /// The bounds in a unit; infinite for none.
    fn in_unit(&self, unit: &str) -> Result<[f64; 2]> {
        let Some(ends) = &self.bounds else {
            return Ok([f64::NEG_INFINITY, f64::INFINITY]);
        };
        let shared = ends[1].1.as_str();
        let of = |(value, own): &(f64, String)| {
            let own = if own.is_empty() { shared } else { own };
            match ratio(own, unit) {
                _ if own == unit => Ok(*value),
                Some(ratio) => Ok(value * ratio),
                None => Err(refuse(
                    &format!("bounds of {} in {unit}", self.shown()),
                    own,
                )),
            }
        };
        let [low, high] = [of(&ends[0])?, of(&ends[1])?];
        if low >= high {
            return Err(refuse("the lower bound first", &format!("{low}..{high}")));
        }
        Ok([low, high])
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
            (young.start, young.unit.as_str(), young.is_log),
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
        assert_eq!(
            (tangent.start, tangent.is_log, tangent.scale()),
            (2.5, false, 5.0)
        );
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
