//! Times as nanoseconds since 1970-01-01, without leap seconds.

use jiff::Timestamp;
use jiff::tz::Offset;

pub(crate) const PER_SECOND: i64 = 1_000_000_000;
/// How the CF conventions write their unit.
pub(crate) const UNIT: &str = "nanoseconds since 1970-01-01";

/// What numbers of `datetime64` (`is_date`) or `timedelta64` of NumPy count, in a unit such as `10us`: the unit as the CF
/// conventions write it, and how many of it.
pub fn numpy_times(unit: &str, is_date: bool) -> Option<(String, f64)> {
    let digits = unit.bytes().take_while(u8::is_ascii_digit).count();
    let (count, unit) = unit.split_at(digits);
    let count: f64 = match digits {
        0 => 1.0,
        _ => count.parse().ok()?,
    };
    let (unit, size) = match unit {
        "W" => ("days", 7.0),
        "D" => ("days", 1.0),
        "h" => ("hours", 1.0),
        "m" => ("minutes", 1.0),
        "s" => ("seconds", 1.0),
        "ms" => ("milliseconds", 1.0),
        "us" => ("microseconds", 1.0),
        "ns" => ("nanoseconds", 1.0),
        "ps" => ("nanoseconds", 1e-3),
        _ => return None,
    };
    let since = if is_date { " since 1970-01-01" } else { "" };
    Some((format!("{unit}{since}"), count * size))
}

/// The time as ISO 8601, with as many digits as it has: `2026-01-01T12:00:00.000000001`.
pub(crate) fn text(nanoseconds: i64) -> String {
    let time = Timestamp::from_nanosecond(nanoseconds.into());
    let time = time.expect("a year from 1677 to 2262");
    Offset::UTC.to_datetime(time).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_definition_text() {
        assert_eq!(text(-1), "1969-12-31T23:59:59.999999999");
        assert_eq!(text(951_782_400 * PER_SECOND), "2000-02-29T00:00:00");
        assert_eq!(text(i64::MAX), "2262-04-11T23:47:16.854775807");
        assert_eq!(text(i64::MIN), "1677-09-21T00:12:43.145224192");
    }
}
