//! The free keys of a design as coordinates of a cube.

use crate::chain::scene::{SceneSource, Setting};
use crate::fit::{FreeKey, settings};
use crate::numeric::Random;
use crate::sweep::quantity;
use crate::{Error, Result};

/// A free key, with the values that it may take if they are a list.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Free {
    pub(super) key: FreeKey,
    pub(super) values: Option<Vec<f64>>,
}

fn refuse(expected: impl Into<String>, found: &str) -> Error {
    Error::request("free", expected, found)
}

impl Free {
    /// The keys of a text: `angle=2..90`, `radius=5mm|10mm`, `coefficients[3]=0.2..5`, `coefficients[]=0.2..5` for all
    /// entries of a list.
    pub(super) fn all_of(text: &str, scene: &SceneSource) -> Result<Vec<Free>> {
        let Some((name, rest)) = text.split_once("[]") else {
            return Ok(vec![Free::of(text, scene)?]);
        };
        let name = name.trim().replace('-', "_");
        let list = scene.typed_value(&name)?;
        let entries = list.as_ref().and_then(|list| list.as_array());
        let count = entries.map_or(0, Vec::len);
        let expected = format!("a list of {name} in the scene");
        Error::require(count > 0, "free", expected, text)?;
        let entries = (0..count).map(|i| format!("{name}[{i}]{rest}"));
        entries.map(|text| Free::of(&text, scene)).collect()
    }

    fn of(text: &str, scene: &SceneSource) -> Result<Free> {
        let listed = text
            .split_once('=')
            .filter(|(_, values)| values.contains('|'));
        let Some((name, values)) = listed else {
            let key = FreeKey::of(text, scene)?;
            let is_bounded = key.bounds.iter().all(|end| end.is_finite());
            let name = &key.name;
            let expected =
                format!("bounds of {name}, such as {name}=LOW..HIGH, or values {name}=A|B|C");
            Error::require(is_bounded, "free", expected, text)?;
            return Ok(Free { key, values: None });
        };
        let read: Option<Vec<(f64, &str)>> = values.split('|').map(quantity).collect();
        let expected = "numbers with bars between, all in one unit, such as 5mm|10mm|20mm";
        let form = || refuse(expected, text);
        let mut read = read.ok_or_else(form)?;
        read.sort_by(|a, b| a.0.total_cmp(&b.0));
        read.dedup();
        let (first, last) = (read[0], read[read.len() - 1]);
        if read.len() < 2 || read.iter().any(|value| value.1 != last.1) || last.0 == 0.0 {
            return Err(form());
        }
        let (unit, [low, high]) = (last.1, [first.0, last.0]);
        let key = FreeKey::of(&format!("{name}={low:?}{unit}..{high:?}{unit}"), scene)?;
        let size = key.bounds[1] / last.0;
        let values = read.iter().map(|value| value.0 * size).collect();
        let values = Some(values);
        Ok(Free { key, values })
    }

    /// Its values, 0 for all between its bounds.
    pub(super) fn listed(&self) -> usize {
        self.values.as_ref().map_or(0, Vec::len)
    }

    /// The value at a coordinate in 0..1.
    pub(super) fn at(&self, u: f64) -> f64 {
        match &self.values {
            Some(values) => values[((u * values.len() as f64) as usize).min(values.len() - 1)],
            None => {
                let [low, high] = self.key.coordinates();
                self.key.value_at(low + u * (high - low))
            }
        }
    }

    /// The coordinate of the scene's value.
    pub(super) fn start(&self) -> f64 {
        match &self.values {
            Some(values) => {
                let off = |i: &usize| (values[*i] - self.key.start).abs();
                let near = (0..values.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
                near.map_or(0.5, |i| (i as f64 + 0.5) / values.len() as f64)
            }
            None => {
                let [low, high] = self.key.coordinates();
                ((self.key.coordinate(self.key.start) - low) / (high - low)).clamp(0.0, 1.0)
            }
        }
    }
}

/// Manufacturing tolerance of a key: `angle=2deg`, `coefficients=10%`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tolerance {
    name: String,
    /// Up and down, of the value or in the unit of the key.
    by: f64,
    is_share: bool,
}

impl Tolerance {
    pub(super) fn parse(text: &str, free: &[Free]) -> Result<Tolerance> {
        let refuse = |expected: &str| Error::request("tolerance", expected, text);
        let form = "KEY=SPREAD of a free key, such as angle=2deg or coefficients=10%";
        let (name, by) = text.split_once('=').ok_or_else(|| refuse(form))?;
        let name = name.trim().replace('-', "_");
        let key = free.iter().find(|free| is_of(&free.key.name, &name));
        let key = key.ok_or_else(|| refuse(form))?;
        let percent = by.trim().strip_suffix('%');
        let is_share = percent.is_some();
        match quantity(percent.unwrap_or(by)) {
            Some((by, unit))
                if by > 0.0
                    && by.is_finite()
                    && (unit.is_empty() || (unit == key.key.unit && !is_share)) =>
            {
                let by = if is_share { 0.01 * by } else { by };
                Ok(Tolerance { name, by, is_share })
            }
            _ if key.key.unit.is_empty() => Err(refuse(form)),
            _ => Err(refuse(&format!(
                "a spread above 0 in {}, the scene's unit, or a share such as 5%",
                key.key.unit
            ))),
        }
    }
}

/// Whether a free key, `coefficients[3]`, is of a name, `coefficients`.
fn is_of(key: &str, name: &str) -> bool {
    key == name || key.split('[').next() == Some(name)
}

/// All free keys, with the tolerances of their values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Space {
    pub(super) free: Vec<Free>,
    /// By member and key, what a value is multiplied by and what is added to it; the first is the nominal one.
    off: Vec<Vec<(f64, f64)>>,
}

impl Space {
    pub(super) fn new(
        free: Vec<Free>,
        tolerances: &[Tolerance],
        members: usize,
        seed: u64,
    ) -> Space {
        let mut random = Random::new(seed ^ 0x701e);
        let exact = || vec![(1.0, 0.0); free.len()];
        let mut off = vec![exact()];
        for _ in 0..if tolerances.is_empty() { 0 } else { members } {
            let mut one = exact();
            for (free, off) in free.iter().zip(&mut one) {
                let r = 2.0 * random.uniform() - 1.0;
                if let Some(tolerance) = tolerances.iter().find(|t| is_of(&free.key.name, &t.name))
                {
                    *off = match tolerance.is_share {
                        true => (1.0 + tolerance.by * r, 0.0),
                        false => (1.0, tolerance.by * r),
                    };
                }
            }
            off.push(one);
        }
        Space { free, off }
    }

    /// The nominal design and those off it.
    pub(super) fn members(&self) -> usize {
        self.off.len()
    }

    pub(super) fn values(&self, point: &[f64]) -> Vec<f64> {
        let each = self.free.iter().zip(point);
        each.map(|(free, u)| free.at(*u)).collect()
    }

    pub(super) fn start(&self) -> Vec<f64> {
        self.free.iter().map(Free::start).collect()
    }

    /// The settings of a member of a design.
    pub(super) fn settings(&self, values: &[f64], member: usize) -> Vec<Setting> {
        let keys: Vec<FreeKey> = self.free.iter().map(|free| free.key.clone()).collect();
        let off = values.iter().zip(&self.off[member]);
        settings(&keys, off.map(|(value, (by, add))| value * by + add))
    }
}
