//! Times as nanoseconds since 1970-01-01, without leap seconds.

pub(crate) const PER_SECOND: i64 = 1_000_000_000;
/// How the CF conventions write their unit.
pub(crate) const UNIT: &str = "nanoseconds since 1970-01-01";
const PER_DAY: i64 = 86_400 * PER_SECOND;

/// Days from 1970-01-01 to a date of the proleptic Gregorian calendar, without a check of the date.
pub fn days_to(year: i64, month: i64, day: i64) -> i64 {
    // Years that begin in March end with the day of leap years.
    let (year, month) = match month > 2 {
        true => (year, month - 3),
        false => (year - 1, month + 9),
    };
    let leap_days = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    365 * year + leap_days + (153 * month + 2) / 5 + day - 719_469
}

/// What numbers of `datetime64` (`is_date`) or `timedelta64` of NumPy count, in a unit such as `10us`: the unit as the CF
/// conventions write it, and how many of it.
pub fn numpy_times(unit: &str, is_date: bool) -> Option<(String, f64)> {
    let digits = unit.bytes().take_while(u8::is_ascii_digit).count();
    let (count, unit) = unit.split_at(digits);
    let count: f64 = if count.is_empty() {
        1.0
    } else {
        count.parse().ok()?
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

/// Year, month and day of so many days after 1970-01-01.
///
/// Years begin in March, so that the leap day is the last one: <https://howardhinnant.github.io/date_algorithms.html>.
fn civil(days: i64) -> [i64; 3] {
    let days = days + 719_468;
    let (era, day) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let late = i64::from(month >= 10);
    [400 * era + year + late, month + 3 - 12 * late, day]
}

/// The time as ISO 8601, with as many digits as it has: `2026-01-01T12:00:00.000000001`.
pub(crate) fn text(nanoseconds: i64) -> String {
    let [year, month, day] = civil(nanoseconds.div_euclid(PER_DAY));
    let rest = nanoseconds.rem_euclid(PER_DAY);
    let (second, fraction) = (rest / PER_SECOND, rest % PER_SECOND);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    let whole = format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}");
    match fraction {
        0 => whole,
        _ => format!("{whole}.{fraction:09}")
            .trim_end_matches('0')
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_definition_days_and_text() {
        assert_eq!(days_to(1970, 1, 1), 0);
        assert_eq!(days_to(1904, 1, 1), -24107);
        assert_eq!(days_to(2000, 1, 1), 10957);
        for (nanoseconds, expected) in [
            (0, "1970-01-01T00:00:00"),
            (-1, "1969-12-31T23:59:59.999999999"),
            (951_782_400 * PER_SECOND, "2000-02-29T00:00:00"),
            (
                1_767_225_599 * PER_SECOND + 120_000_000,
                "2025-12-31T23:59:59.12",
            ),
            (i64::MAX, "2262-04-11T23:47:16.854775807"),
            (i64::MIN, "1677-09-21T00:12:43.145224192"),
        ] {
            assert_eq!(text(nanoseconds), expected);
        }
    }
}
