//! Values that belong to a file, a group or a channel.

use std::collections::HashMap;

use crate::{ByteOrder, Sample, Value, time};

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Property {
    Text(String),
    Integer(i64),
    Number(f64),
    Complex([f64; 2]),
    Time(Stamp),
}

/// Seconds since 1904-01-01 and 2^-64 of a second.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Stamp {
    pub seconds: i64,
    pub fraction: u64,
}

impl Stamp {
    pub(super) const BYTES: u64 = 16;

    /// From 16 bytes: in the little byte order the fraction comes first.
    pub(super) fn read(order: ByteOrder, bytes: &[u8]) -> Stamp {
        let word = |at: usize| {
            let mut word = [0; 8];
            word.copy_from_slice(&bytes[at..at + 8]);
            match order {
                ByteOrder::Little => u64::from_le_bytes(word),
                ByteOrder::Big => u64::from_be_bytes(word),
            }
        };
        let (seconds, fraction) = match order {
            ByteOrder::Little => (word(8), word(0)),
            ByteOrder::Big => (word(0), word(8)),
        };
        Stamp {
            seconds: seconds.cast_signed(),
            fraction,
        }
    }

    /// Since 1970, to the nearest; none before 1677 and after 2262.
    pub(super) fn nanoseconds(self) -> Option<i64> {
        let epoch = i128::from(time::days_before(1904)) * 86_400;
        let per_second = i128::from(time::PER_SECOND);
        // Writers cut the fraction: 1 us is stored as slightly less.
        let fraction = (i128::from(self.fraction) * per_second + (1 << 63)) >> 64;
        i64::try_from((i128::from(self.seconds) + epoch) * per_second + fraction).ok()
    }

    fn text(self) -> String {
        match self.nanoseconds() {
            Some(nanoseconds) => time::text(nanoseconds),
            None => format!("{} s since 1904-01-01", self.seconds),
        }
    }
}

impl Property {
    /// As a value of an attribute.
    pub(super) fn value(&self) -> Value {
        match self {
            Property::Text(text) => Value::Text(text.clone()),
            Property::Integer(integer) => Value::Integers(vec![*integer]),
            Property::Number(number) => Value::Numbers(vec![*number]),
            Property::Complex(parts) => Value::Numbers(parts.to_vec()),
            Property::Time(stamp) => Value::Text(stamp.text()),
        }
    }

    pub(super) fn of_sample(sample: Sample, order: ByteOrder, bytes: &[u8]) -> Property {
        match sample.to_i64(order, bytes) {
            Some(integer) => Property::Integer(integer),
            None => Property::Number(sample.to_f64(order, bytes)),
        }
    }

    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Property::Integer(integer) => Some(*integer as f64),
            Property::Number(number) => Some(*number),
            _ => None,
        }
    }
}

/// The properties of one object, in the order of the file.
#[derive(Debug, Clone, Default)]
pub(super) struct Properties {
    pub list: Vec<(String, Property)>,
    places: HashMap<String, usize>,
}

impl Properties {
    /// Sets a property; what a later segment says replaces what an earlier one said. Whether it is new.
    pub(super) fn set(&mut self, name: String, property: Property) -> bool {
        if let Some(&place) = self.places.get(&name) {
            self.list[place].1 = property;
            return false;
        }
        self.places.insert(name.clone(), self.list.len());
        self.list.push((name, property));
        true
    }

    pub(super) fn get(&self, name: &str) -> Option<&Property> {
        self.places.get(name).map(|&place| &self.list[place].1)
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.get(name)?.number()
    }

    pub(super) fn integer(&self, name: &str) -> Option<i64> {
        match self.get(name)? {
            Property::Integer(integer) => Some(*integer),
            _ => None,
        }
    }

    pub(super) fn text(&self, name: &str) -> Option<&str> {
        match self.get(name)? {
            Property::Text(text) => Some(text.trim()).filter(|text| !text.is_empty()),
            _ => None,
        }
    }

    /// The position of a channel along an axis, and its unit: `x`, `Position (mm)`, `x` beside `x_unit`.
    pub(super) fn position(&self, axis: &str) -> Option<(f64, Option<&str>)> {
        let is_axis = |name: &str| split_unit(name).0.eq_ignore_ascii_case(axis);
        let mut found = self.list.iter().filter(|(name, _)| is_axis(name));
        let (name, value) = found.find_map(|(name, p)| Some((name, p.number()?)))?;
        let is_beside = |name: &&String| {
            let parts = name.get(..axis.len()).zip(name.get(axis.len()..));
            parts.is_some_and(|(start, rest)| {
                let rest = rest
                    .trim_start_matches(['_', ' ', '-'])
                    .to_ascii_lowercase();
                let is_unit = matches!(rest.as_str(), "unit" | "units" | "unit_string");
                is_unit && start.eq_ignore_ascii_case(axis)
            })
        };
        let unit = split_unit(name).1.or_else(|| {
            let mut names = self.list.iter().map(|(name, _)| name);
            self.text(names.find(is_beside)?)
        });
        Some((value, unit))
    }
}

/// A name and the unit in brackets behind it: `Time (s)`, `x [mm]`.
pub(super) fn split_unit(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    let unit = |open, close| {
        let (before, unit) = name.strip_suffix(close)?.rsplit_once(open)?;
        Some((
            str::trim_end(before),
            Some(str::trim(unit)).filter(|u| !u.is_empty()),
        ))
    };
    unit('(', ')')
        .or_else(|| unit('[', ']'))
        .unwrap_or((name, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_definition_times() {
        let stamp = |seconds, fraction| Stamp { seconds, fraction };
        let epoch = 2_082_844_800;
        assert_eq!(stamp(epoch, 0).nanoseconds(), Some(0));
        assert_eq!(stamp(epoch - 1, 1 << 63).nanoseconds(), Some(-500_000_000));
        // A microsecond, cut to 2^-64 of a second.
        assert_eq!(stamp(epoch, 18_446_744_073_709).nanoseconds(), Some(1000));
        assert_eq!(stamp(epoch, u64::MAX).nanoseconds(), Some(1_000_000_000));
        assert_eq!(stamp(i64::MAX, 0).nanoseconds(), None);
    }

    #[test]
    fn positions_and_their_units() {
        let position = |pairs: &[(&str, Property)]| {
            let mut properties = Properties::default();
            for (name, property) in pairs {
                properties.set((*name).into(), property.clone());
            }
            let found = properties.position("x");
            found.map(|(x, unit)| (x, unit.map(str::to_owned)))
        };
        let text = |text: &str| Property::Text(text.into());
        let mm = Some("mm".to_owned());
        assert_eq!(
            position(&[("X (mm)", Property::Integer(3))]),
            Some((3.0, mm.clone()))
        );
        let beside = [("x", Property::Number(0.5)), ("X_Unit", text("mm"))];
        assert_eq!(position(&beside), Some((0.5, mm)));
        assert_eq!(position(&[("x", Property::Number(0.5))]), Some((0.5, None)));
        assert_eq!(
            position(&[("x", text("0.5")), ("xx", Property::Integer(1))]),
            None
        );
    }
}
