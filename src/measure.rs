//! Numbers with units: `9e-3` (in SI) and `"9 mm"` are the same length.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// What a [`Measure`] measures, and in which units it may be typed.
pub trait Dimension {
    const NAME: &'static str;
    /// Units and their size in the first one.
    const UNITS: &'static [(&'static str, f64)];
    /// Other spellings, and the unit that each stands for.
    const ALIASES: &'static [(&'static str, &'static str)];
}

/// The unit of `D` that `name` spells: `s` for `s`, `sec.` and `Seconds`; `None` for no unit of it. The case of letters
/// counts in symbols, not in words.
pub fn symbol<D: Dimension>(name: &str) -> Option<&'static str> {
    spelled::<D>(name).map(|(symbol, _)| symbol)
}

/// The symbol of a unit of `D`; another text as it is.
pub(crate) fn symbol_or<D: Dimension>(unit: &str) -> String {
    symbol::<D>(unit).unwrap_or(unit).to_owned()
}

/// The size of the unit that `name` spells, in the first unit of `D`; `None` for no unit of it.
pub fn size<D: Dimension>(name: &str) -> Option<f64> {
    spelled::<D>(name).map(|(_, size)| size)
}

fn spelled<D: Dimension>(name: &str) -> Option<(&'static str, f64)> {
    let name = name.trim().trim_end_matches('.');
    let is_word =
        |alias: &str| alias.is_ascii() && alias.len() > 2 && alias.eq_ignore_ascii_case(name);
    let is_it = |(alias, _): &&(&str, _)| *alias == name || is_word(alias);
    let alias = D::ALIASES.iter().find(is_it);
    let name = alias.map_or(name, |(_, unit)| unit);
    D::UNITS.iter().copied().find(|(unit, _)| *unit == name)
}

/// The units of `D`, separated by commas.
pub fn units<D: Dimension>() -> String {
    let units: Vec<&str> = D::UNITS.iter().map(|(unit, _)| *unit).collect();
    units.join(", ")
}

/// The unit of frequencies whose period is in the unit of time `unit`: `Hz` for `s`, `kHz` for
/// `ms`.
pub fn cycles_per(unit: &str) -> String {
    let named = [("s", "Hz"), ("ms", "kHz"), ("us", "MHz"), ("ns", "GHz")];
    match named.iter().find(|(time, _)| *time == unit) {
        Some((_, frequency)) => (*frequency).into(),
        None => format!("cycles/{unit}"),
    }
}

/// A unit as a quotient of symbols: `m/s` for `m s-1`, `m.s^-1`, `metre second**-1` and `metres / second`, as the CF
/// conventions and other programs write them. A text that is no such product stays as it is.
pub(crate) fn quotient(unit: &str) -> String {
    let is_between = |c: char| c.is_whitespace() || matches!(c, '.' | '*' | '\u{b7}');
    let spelled = unit.replace("**", "^").replace('/', " / ");
    let mut is_changed = false;
    let (mut over, mut under) = (Vec::new(), Vec::new());
    let mut is_divisor = false;
    for word in spelled.split(is_between).filter(|word| !word.is_empty()) {
        if word == "/" {
            is_divisor = true;
            continue;
        }
        let end = word
            .find(|c: char| !c.is_alphabetic())
            .unwrap_or(word.len());
        let (name, exponent) = word.split_at(end);
        let exponent = match exponent.trim_start_matches('^') {
            "" => Some(1),
            digits => digits.parse::<i32>().ok().filter(|exponent| *exponent != 0),
        };
        let (Some(exponent), false) = (exponent, name.is_empty()) else {
            return unit.to_owned();
        };
        // A micro sign stays as it is.
        let symbol = symbol::<Length>(name).or(symbol::<Time>(name));
        let symbol = symbol.filter(|symbol| *symbol != name.replace(['\u{b5}', '\u{3bc}'], "u"));
        is_changed |= exponent < 0 || symbol.is_some();
        let symbol = symbol.unwrap_or(name);
        let raised = match exponent.abs() {
            1 => symbol.to_owned(),
            exponent => format!("{symbol}^{exponent}"),
        };
        match (exponent < 0) != std::mem::take(&mut is_divisor) {
            true => under.push(raised),
            false => over.push(raised),
        }
    }
    let over = match over.is_empty() {
        true => "1".to_owned(),
        false => over.join(" "),
    };
    match &under[..] {
        _ if !is_changed => unit.to_owned(),
        [] => over,
        [unit] => format!("{over}/{unit}"),
        units => format!("{over}/({})", units.join(" ")),
    }
}

/// A number of things in words: `1 value`, `2 values`.
pub(crate) fn counted(number: usize, thing: &str) -> String {
    let ending = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{ending}")
}

/// The number with the fewest digits that lies within `tolerance` of `value`.
pub(crate) fn shortest(value: f64, tolerance: f64) -> f64 {
    let near = |digits: usize| format!("{value:.digits$e}").parse::<f64>().ok();
    let is_near = |near: &f64| (near - value).abs() <= tolerance;
    (0..17).filter_map(near).find(is_near).unwrap_or(value)
}

/// A number with the digits it has, twelve at most: `1e-5`, `0.00025`, `48000`.
pub fn digits(value: f64) -> String {
    let value = format!("{value:.11e}").parse().unwrap_or(value);
    match (1e-4..1e6).contains(&value.abs()) || value == 0.0 {
        true => value.to_string(),
        false => format!("{value:e}"),
    }
}

macro_rules! dimensions {
    ($($(#[$doc:meta])* $name:ident, $words:literal: $($unit:literal = $size:expr),+
        $(; $($alias:literal = $symbol:literal),+)?;)+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name;

        impl Dimension for $name {
            const NAME: &'static str = $words;
            const UNITS: &'static [(&'static str, f64)] = &[$(($unit, $size)),+];
            const ALIASES: &'static [(&'static str, &'static str)] =
                &[$($(($alias, $symbol)),+)?];
        }
    )+};
}

dimensions! {
    Length, "a length": "m" = 1.0, "km" = 1e3, "cm" = 1e-2, "mm" = 1e-3, "um" = 1e-6, "nm" = 1e-9;
        "metre" = "m", "metres" = "m", "meter" = "m", "meters" = "m", "\u{b5}m" = "um", "\u{3bc}m" = "um";
    Time, "a time": "s" = 1.0, "ms" = 1e-3, "us" = 1e-6, "ns" = 1e-9, "min" = 60.0, "h" = 3600.0;
        "sec" = "s", "secs" = "s", "second" = "s", "seconds" = "s", "msec" = "ms",
        "millisecond" = "ms", "milliseconds" = "ms", "usec" = "us", "microsecond" = "us",
        "microseconds" = "us", "\u{b5}s" = "us", "\u{3bc}s" = "us", "nsec" = "ns",
        "nanosecond" = "ns", "nanoseconds" = "ns", "minute" = "min", "minutes" = "min",
        "hour" = "h", "hours" = "h";
    Speed, "a speed": "m/s" = 1.0, "km/s" = 1e3, "cm/s" = 1e-2, "mm/s" = 1e-3;
    Mass, "a mass": "kg" = 1.0, "g" = 1e-3, "mg" = 1e-6;
    LinearDensity, "a mass per length": "kg/m" = 1.0, "g/m" = 1e-3, "mg/m" = 1e-6, "g/cm" = 0.1, "g/mm" = 1.0, "kg/mm" = 1e3;
    Density, "a density": "kg/m^3" = 1.0, "g/cm^3" = 1e3;
    Pressure, "a pressure": "Pa" = 1.0, "kPa" = 1e3, "MPa" = 1e6, "GPa" = 1e9;
    Force, "a force": "N" = 1.0, "kN" = 1e3, "mN" = 1e-3;
    Frequency, "a frequency": "Hz" = 1.0, "kHz" = 1e3, "MHz" = 1e6;
    Wavenumber, "a wavenumber": "rad/m" = 1.0, "rad/km" = 1e-3, "rad/cm" = 1e2, "rad/mm" = 1e3,
        "rad/um" = 1e6;
    Angle, "an angle": "deg" = 1.0, "rad" = 180.0 / std::f64::consts::PI;
    Memory, "a size": "B" = 1.0, "kB" = 1e3, "MB" = 1e6, "GB" = 1e9, "TB" = 1e12,
        "KiB" = 1024.0, "MiB" = 1_048_576.0, "GiB" = 1_073_741_824.0, "TiB" = 1_099_511_627_776.0;
}

/// A finite number of dimension `D`: with a unit, in the first unit of `D`; without one, in the
/// unit that its place implies (of an SI scene that first unit, of an axis the unit of the axis).
#[derive(Clone, Copy, PartialEq)]
pub struct Measure<D> {
    pub value: f64,
    /// Whether a unit was typed.
    pub has_unit: bool,
    dimension: PhantomData<D>,
}

impl<D: Dimension> Measure<D> {
    /// The measure of a number without a unit.
    pub fn new(value: f64) -> Self {
        Measure::of(value, false)
    }

    fn of(value: f64, has_unit: bool) -> Self {
        let dimension = PhantomData;
        Measure {
            value,
            has_unit,
            dimension,
        }
    }

    /// From a text such as `9 mm`; `None` where number or unit cannot be read.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        // Of the units that the text ends with, the longest is meant: in `3 mm`, not the metre.
        let names = D::UNITS.iter().map(|(unit, _)| *unit);
        let names = names.chain(D::ALIASES.iter().map(|(alias, _)| *alias));
        let fitting = names.filter(|unit| text.ends_with(unit));
        let unit = fitting.max_by_key(|unit| unit.len())?;
        let number = text[..text.len() - unit.len()].trim_end();
        let value = scaled(number, size::<D>(unit)?)?;
        value.is_finite().then(|| Measure::of(value, true))
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

    /// The number in `unit`: as typed where no unit was, else converted, and rounded once if the
    /// units are a power of ten apart. `None` for a `unit` that is none of `D`.
    pub fn in_unit(self, unit: &str) -> Option<f64> {
        if !self.has_unit {
            return Some(self.value);
        }
        let size = size::<D>(unit)?;
        // The shortest text that gives the value back is the number that was meant.
        scaled(&format!("{:e}", self.value), 1.0 / size)
    }

    fn expected() -> String {
        format!(
            "{} in {}, or a text of number and unit ({})",
            D::NAME,
            D::UNITS[0].0,
            units::<D>()
        )
    }
}

impl Measure<Frequency> {
    /// The time between two of so many samples: `1 / rate`.
    pub fn period(self) -> Measure<Time> {
        Measure::of(1.0 / self.value, self.has_unit)
    }
}

impl<D: Dimension> From<f64> for Measure<D> {
    fn from(value: f64) -> Self {
        Measure::new(value)
    }
}

/// A number times a unit's size; a power of ten goes into the text, so that it is rounded once.
fn scaled(number: &str, size: f64) -> Option<f64> {
    let value: f64 = number.parse().ok()?;
    let power = size.log10().round();
    // The reciprocal of a unit's size may be off its power of ten by a rounding.
    if (size / 10f64.powi(power as i32) - 1.0).abs() > 4.0 * f64::EPSILON {
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
    fn val_definition_units_with_exponents_are_quotients() {
        let pairs = "m s-1=m/s; m.s^-1=m/s; m s**-1=m/s; metre second-1=m/s; meters / second=m/s; m s-2=m/s^2; \
            kg m-1 s-2=kg/(m s^2); s-1=1/s; metres=m; \u{b5}m/s=\u{b5}m/s; m/s=m/s; mm/s^2=mm/s^2; \
            (m/s)^2=(m/s)^2; counts=counts; =";
        for pair in pairs.split("; ") {
            let (written, unit) = pair.split_once('=').unwrap();
            assert_eq!(quotient(written), unit, "{written}");
        }
    }

    #[test]
    fn numbers_are_written_with_the_digits_they_have() {
        for text in ["1e-5", "0.00025", "-48000", "2.5e9", "0"] {
            assert_eq!(digits(text.parse().unwrap()), text);
        }
        let rounded = [9.999999999999999e-6, 0.1 + 0.2, 295.0 / 4095.0].map(digits);
        assert_eq!(rounded, ["1e-5", "0.3", "0.0720390720391"]);
        assert_eq!(shortest(9.99999974e-6, 1e-12), 1e-5);
        assert_eq!(shortest(0.3333, 1e-5), 0.3333);
        assert_eq!(shortest(0.1, 0.0), 0.1);
        assert_eq!([cycles_per("ms"), cycles_per("min")], ["kHz", "cycles/min"]);
    }

    #[test]
    fn units_have_other_spellings() {
        for (names, unit, ten) in [
            ("s sec seconds", Some(("s", 1.0)), Some(10.0)),
            (
                "us usec \u{b5}s \u{3bc}s microseconds",
                Some(("us", 1e-6)),
                Some(1e-5),
            ),
            ("S samples m lightyears millimetre", None, None),
        ] {
            for name in names.split(' ') {
                assert_eq!(spelled::<Time>(name), unit, "{name}");
                let found = Measure::<Time>::parse(&format!("10 {name}"));
                assert_eq!(found.map(|found| found.value), ten, "{name}");
            }
        }
        assert_eq!(symbol::<Time>(" SEC. "), Some("s"));
        assert_eq!(spelled::<Time>(""), None);
    }

    /// Each is the number nearest to the decimal one.
    #[test]
    fn conversions_by_powers_of_ten_round_once() {
        let us = |digits: usize| Measure::<Time>::parse(&format!("{digits} us")).unwrap();
        for digits in 1..2000 {
            for (unit, power) in [("s", -6), ("ms", -3), ("us", 0), ("ns", 3)] {
                let expected = format!("{digits}e{power}").parse().ok();
                assert_eq!(us(digits).in_unit(unit), expected, "{digits} us in {unit}");
            }
        }
        assert_eq!(us(120_000_000).in_unit("min"), Some(2.0));
        assert_eq!(us(1).in_unit("parsec"), None);
        assert_eq!(Measure::<Time>::new(0.3).in_unit("parsec"), Some(0.3));
        let period = Measure::<Frequency>::parse("100 kHz").unwrap().period();
        assert_eq!(
            ["s", "us"].map(|unit| period.in_unit(unit)),
            [Some(1e-5), Some(10.0)]
        );
    }

    #[test]
    fn texts_have_a_number_and_a_known_unit() {
        let mm = |text| Measure::<Length>::parse(text).map(|m| m.value);
        let texts = ["9mm", " 1.8e1 mm", "3.3 mm", "-.7cm", "0.3 m"];
        let values = [9e-3, 18e-3, 3.3e-3, -0.7e-2, 0.3].map(Some);
        assert_eq!(texts.map(mm), values);
        for wrong in ",mm,9,9 parsec,9 GPa,nan m,1e400 m,9 m m".split(',') {
            assert_eq!(mm(wrong), None, "{wrong}");
        }
        let pascal = Measure::<Pressure>::parse("72 GPa").map(|p| p.value);
        let size = Measure::<Memory>::parse("2GiB").map(|m| m.value);
        assert_eq!([pascal, size], [Some(72e9), Some(2147483648.0)]);
    }
}
