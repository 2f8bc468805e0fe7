//! Values that belong to a file, a group or a channel.

use crate::{Attributes, ByteOrder, time};

/// Seconds since 1904-01-01 and 2^-64 of a second.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stamp {
    pub seconds: i64,
    pub fraction: u64,
}

impl Stamp {
    pub(super) const BYTES: u64 = 16;
    /// The text of a time that is none: LabVIEW writes the first second.
    pub(super) const NONE: &str = "1904-01-01T00:00:00";

    /// From 16 bytes: in the little byte order the fraction comes first.
    pub(super) fn read(order: ByteOrder, bytes: &[u8]) -> Stamp {
        let (first, second) = (order.unsigned(&bytes[..8]), order.unsigned(&bytes[8..16]));
        let (seconds, fraction) = match order {
            ByteOrder::Little => (second, first),
            ByteOrder::Big => (first, second),
        };
        Stamp {
            seconds: seconds.cast_signed(),
            fraction,
        }
    }

    /// Since 1970, to the nearest; none before 1677 and after 2262.
    pub(super) fn nanoseconds(self) -> Option<i64> {
        /// Seconds from there to 1970.
        const EPOCH: i128 = 2_082_844_800;
        let per_second = i128::from(time::PER_SECOND);
        // Writers cut the fraction: 1 us is stored as slightly less.
        let fraction = (i128::from(self.fraction) * per_second + (1 << 63)) >> 64;
        i64::try_from((i128::from(self.seconds) - EPOCH) * per_second + fraction).ok()
    }

    pub(super) fn text(self) -> String {
        match self.nanoseconds() {
            Some(nanoseconds) => time::text(nanoseconds),
            None => format!("{} s since 1904-01-01", self.seconds),
        }
    }
}

/// The position of a channel along an axis, and its unit: `x`, `Position (mm)`, `x` beside `x_unit`.
pub(super) fn position<'p>(
    properties: &'p Attributes,
    axis: &str,
) -> Option<(f64, Option<&'p str>)> {
    let is_axis = |name: &str| split_unit(name).0.eq_ignore_ascii_case(axis);
    let mut found = properties.0.iter().filter(|(name, _)| is_axis(name));
    let (name, value) = found.find_map(|(name, value)| Some((name, value.number()?)))?;
    let is_beside = |name: &&String| {
        let lower = name.to_ascii_lowercase();
        let unit = lower.strip_prefix(axis).unwrap_or_default();
        let unit = unit.trim_start_matches(['_', ' ', '-']);
        matches!(unit, "unit" | "units" | "unit_string")
    };
    let beside = || properties.text(properties.0.keys().find(is_beside)?);
    Some((value, split_unit(name).1.or_else(beside)))
}

/// A name and the unit in brackets behind it: `Time (s)`, `x [mm]`.
pub(super) fn split_unit(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    let unit = |open, close| {
        let (before, unit) = name.strip_suffix(close)?.rsplit_once(open)?;
        let unit = Some(str::trim(unit)).filter(|unit| !unit.is_empty());
        Some((str::trim_end(before), unit))
    };
    let found = unit('(', ')').or_else(|| unit('[', ']'));
    found.unwrap_or((name, None))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Value;

    #[test]
    fn val_definition_times() {
        const EPOCH: i64 = 2_082_844_800;
        for (seconds, fraction, nanoseconds) in [
            (EPOCH, 0, Some(0)),
            (EPOCH - 1, 1 << 63, Some(-500_000_000)),
            // A microsecond, cut to 2^-64 of a second.
            (EPOCH, 18_446_744_073_709, Some(1000)),
            (EPOCH, u64::MAX, Some(1_000_000_000)),
            (i64::MAX, 0, None),
        ] {
            assert_eq!(Stamp { seconds, fraction }.nanoseconds(), nanoseconds);
        }
    }

    #[test]
    fn positions_and_their_units() {
        let number = |number| Value::Numbers(vec![number]);
        let text = |text: &str| Value::Text(text.into());
        for (pairs, expected) in [
            (
                vec![("X (mm)", Value::Integers(vec![3]))],
                Some((3.0, Some("mm"))),
            ),
            (
                vec![("x", number(0.5)), ("X_Unit", text("mm"))],
                Some((0.5, Some("mm"))),
            ),
            (vec![("x", number(0.5))], Some((0.5, None))),
            (vec![("x", text("0.5")), ("xx", number(1.0))], None),
        ] {
            let pairs = pairs
                .into_iter()
                .map(|(name, value)| (name.to_owned(), value));
            assert_eq!(position(&Attributes(pairs.collect()), "x"), expected);
        }
    }
}
