//! Times as nanoseconds since 1970-01-01, without leap seconds.

pub(crate) const PER_SECOND: i64 = 1_000_000_000;
/// How the CF conventions write their unit.
pub(crate) const UNIT: &str = "nanoseconds since 1970-01-01";
const PER_DAY: i64 = 86_400 * PER_SECOND;

/// Days from 1970-01-01 to the first day of a year.
pub(crate) fn days_before(year: u16) -> i64 {
    let past = i64::from(year) - 1;
    let leap_days = past / 4 - past / 100 + past / 400;
    365 * (past - 1969) + leap_days - (1969 / 4 - 1969 / 100 + 1969 / 400)
}

/// The time as ISO 8601, with as many digits as it has: `2026-01-01T12:00:00.000000001`.
pub(crate) fn text(nanoseconds: i64) -> String {
    let (days, rest) = (
        nanoseconds.div_euclid(PER_DAY),
        nanoseconds.rem_euclid(PER_DAY),
    );
    // An `i64` reaches from 1677 to 2262.
    let mut year = 1677;
    while days_before(year + 1) <= days {
        year += 1;
    }
    let mut day = days - days_before(year);
    let is_leap = days_before(year + 1) - days_before(year) == 366;
    let mut month = 0;
    for length in [
        31,
        28 + i64::from(is_leap),
        31,
        30,
        31,
        30,
        31,
        31,
        30,
        31,
        30,
        31,
    ] {
        if day < length {
            break;
        }
        day -= length;
        month += 1;
    }
    let (second, fraction) = (rest / PER_SECOND, rest % PER_SECOND);
    let fraction = match fraction {
        0 => String::new(),
        _ => format!(".{fraction:09}").trim_end_matches('0').to_owned(),
    };
    format!(
        "{year:04}-{:02}-{:02}T{:02}:{:02}:{:02}{fraction}",
        month + 1,
        day + 1,
        second / 3600,
        second / 60 % 60,
        second % 60
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_definition_days_and_text() {
        assert_eq!(days_before(1970), 0);
        assert_eq!(days_before(1904), -24107);
        assert_eq!(days_before(2000), 10957);
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
