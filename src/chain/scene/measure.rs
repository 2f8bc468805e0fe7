//! Numbers with units: `9e-3` (in SI) and `"9 mm"` are the same length.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// What a [`Measure`] measures, and in which units it may be typed.
pub trait Dimension {
    const NAME: &'static str;
    /// Units and their size in the first one, which numbers without a unit are in.
    const UNITS: &'static [(&'static str, f64)];
}

macro_rules! dimensions {
    ($($(#[$doc:meta])* $name:ident, $words:literal: $($unit:literal = $size:expr),+;)+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name;

        impl Dimension for $name {
            const NAME: &'static str = $words;
            const UNITS: &'static [(&'static str, f64)] = &[$(($unit, $size)),+];
        }
    )+};
}

dimensions! {
    Length, "a length": "m" = 1.0, "km" = 1e3, "cm" = 1e-2, "mm" = 1e-3, "um" = 1e-6, "nm" = 1e-9;
    Time, "a time": "s" = 1.0, "ms" = 1e-3, "us" = 1e-6, "ns" = 1e-9;
    Speed, "a speed": "m/s" = 1.0, "km/s" = 1e3, "cm/s" = 1e-2, "mm/s" = 1e-3;
    Mass, "a mass": "kg" = 1.0, "g" = 1e-3, "mg" = 1e-6;
    Density, "a density": "kg/m^3" = 1.0, "g/cm^3" = 1e3;
    Pressure, "a pressure": "Pa" = 1.0, "kPa" = 1e3, "MPa" = 1e6, "GPa" = 1e9;
    Force, "a force": "N" = 1.0, "kN" = 1e3, "mN" = 1e-3;
    Frequency, "a frequency": "Hz" = 1.0, "kHz" = 1e3, "MHz" = 1e6;
    Angle, "an angle": "deg" = 1.0, "rad" = 180.0 / std::f64::consts::PI;
    Memory, "a size": "B" = 1.0, "kB" = 1e3, "MB" = 1e6, "GB" = 1e9, "TB" = 1e12,
        "KiB" = 1024.0, "MiB" = 1_048_576.0, "GiB" = 1_073_741_824.0, "TiB" = 1_099_511_627_776.0;
}

/// A finite number of dimension `D`, in the first of its units.
#[derive(Clone, Copy, PartialEq)]
pub struct Measure<D> {
    pub value: f64,
    /// Whether a unit was typed; a scene without units has none.
    pub has_unit: bool,
    dimension: PhantomData<D>,
}

impl<D: Dimension> Measure<D> {
    /// The measure of a number without a unit.
    pub fn new(value: f64) -> Self {
        Measure {
            value,
            has_unit: false,
            dimension: PhantomData,
        }
    }

    /// From a text such as `9 mm`; `None` where number or unit cannot be read.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        // Of the units that the text ends with, the longest is meant: in `3 mm`, not the metre.
        let fitting = D::UNITS.iter().filter(|(unit, _)| text.ends_with(unit));
        let (unit, size) = fitting.max_by_key(|(unit, _)| unit.len())?;
        let number = text[..text.len() - unit.len()].trim_end();
        let value = scaled(number, *size)?;
        value.is_finite().then_some(Measure {
            value,
            has_unit: true,
            dimension: PhantomData,
        })
    }

    /// From a number, or a number with a unit.
    ///
    /// # Errors
    /// What was expected instead.
    pub fn read(text: &str) -> Result<Self, String> {
        match text.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Measure::new(value)),
            _ => Measure::parse(text).ok_or_else(|| format!("expected {}", Self::expected())),
        }
    }

    fn expected() -> String {
        let units: Vec<&str> = D::UNITS.iter().map(|(unit, _)| *unit).collect();
        format!(
            "{} in {}, or a text of number and unit ({})",
            D::NAME,
            units[0],
            units.join(", ")
        )
    }
}

/// A number times a unit's size; a power of ten goes into the text, so that it is rounded once.
fn scaled(number: &str, size: f64) -> Option<f64> {
    let value: f64 = number.parse().ok()?;
    let power = size.log10().round();
    if format!("1e{power}").parse() != Ok(size) {
        return Some(value * size);
    }
    let (digits, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let exponent = exponent.parse::<f64>().ok()? + power;
    format!("{digits}e{exponent}").parse().ok()
}

impl<D: Dimension> fmt::Debug for Measure<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.value, D::UNITS[0].0)
    }
}

impl<D> Serialize for Measure<D> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.value)
    }
}

impl<'de, D: Dimension> Deserialize<'de> for Measure<D> {
    fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
        deserializer.deserialize_any(Visitor(PhantomData))
    }
}

struct Visitor<D>(PhantomData<D>);

impl<D: Dimension> de::Visitor<'_> for Visitor<D> {
    type Value = Measure<D>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&Measure::<D>::expected())
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<Self::Value, E> {
        Ok(Measure::new(value as f64))
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<Self::Value, E> {
        Ok(Measure::new(value as f64))
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Self::Value, E> {
        if value.is_finite() {
            Ok(Measure::new(value))
        } else {
            Err(E::invalid_value(de::Unexpected::Float(value), &self))
        }
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Self::Value, E> {
        Measure::parse(text).ok_or_else(|| E::invalid_value(de::Unexpected::Str(text), &self))
    }
}

impl<D: Dimension> JsonSchema for Measure<D> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        Cow::Owned(D::NAME.replace(' ', "_"))
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let units: Vec<&str> = D::UNITS.iter().map(|(unit, _)| *unit).collect();
        json_schema!({ "type": ["number", "string"], "x-units": units })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_have_a_number_and_a_known_unit() {
        let mm = |text| Measure::<Length>::parse(text).map(|m| m.value);
        assert_eq!(mm("9mm"), Some(9e-3));
        assert_eq!(mm(" 1.8e1 mm"), Some(18e-3));
        assert_eq!(mm("3.3 mm"), Some(3.3e-3));
        assert_eq!(mm("-.7cm"), Some(-0.7e-2));
        assert_eq!(mm("0.3 m"), Some(0.3));
        for wrong in [
            "", "mm", "9", "9 parsec", "9 GPa", "nan m", "1e400 m", "9 m m",
        ] {
            assert_eq!(mm(wrong), None, "{wrong}");
        }
        let pascal = Measure::<Pressure>::parse("72 GPa").map(|p| p.value);
        assert_eq!(pascal, Some(72e9));
        let size = Measure::<Memory>::parse("2GiB").map(|m| m.value);
        assert_eq!(size, Some(2147483648.0));
    }
}
