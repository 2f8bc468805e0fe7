//! Dates and times of day as tables write them.

/// Nanoseconds of a second.
const SECOND: f64 = 1e9;
const DAY: i64 = 86_400 * 1_000_000_000;

/// A date, a time of day, or both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stamp {
    /// Nanoseconds since 1970-01-01, or since midnight.
    pub(super) nanoseconds: i64,
    pub(super) has_date: bool,
    pub(super) has_time: bool,
    /// What the last printed digit counts, in seconds.
    pub(super) rounding: f64,
}

impl Stamp {
    /// From `2026-01-31T12:00:00.001Z`, `2026-01-31 12:00`, `31.01.2026 12:00:00,5`, `2026-01-31`, `12:00:00.5`.
    pub(super) fn parse(cell: &[u8]) -> Option<Stamp> {
        let text = str::from_utf8(cell).ok()?.trim();
        if !text.starts_with(|c: char| c.is_ascii_digit()) {
            return None;
        }
        let (date, time) = match text.split_once(['T', ' ']) {
            Some((date, time)) => (Some(date), Some(time.trim())),
            None if text.contains(':') => (None, Some(text)),
            None => (Some(text), None),
        };
        let days = date.map(days).map_or(Some(None), |days| days.map(Some))?;
        let (of_day, rounding) = match time {
            Some(time) => of_day(time)?,
            None => (0, DAY as f64 / SECOND),
        };
        Some(Stamp {
            nanoseconds: days.unwrap_or(0).checked_mul(DAY)?.checked_add(of_day)?,
            has_date: days.is_some(),
            has_time: time.is_some(),
            rounding,
        })
    }
}

/// Days from 1970-01-01 to a date of the proleptic Gregorian calendar.
fn days(date: &str) -> Option<i64> {
    let parts: Vec<&str> = date.split(['-', '/', '.']).collect();
    let [first, month, last] = parts[..] else {
        return None;
    };
    // Whether days or months come first in 01/02/2026 is not known; of 01.02.2026 days do.
    let (year, day) = match (first.len(), last.len()) {
        (4, 1..=2) => (first, last),
        (1..=2, 4) if date.contains('.') => (last, first),
        _ => return None,
    };
    let number = |text: &str, most: i64| {
        let number: i64 = text.parse().ok()?;
        (1..=most).contains(&number).then_some(number)
    };
    let (year, month, day) = (number(year, 9999)?, number(month, 12)?, number(day, 31)?);
    Some(wavecascade_formats::days_to(year, month, day))
}

/// Nanoseconds since midnight of a time of day with its zone, less that of the zone, and what its last digit counts.
///
/// Zones are `Z`, `UTC` or `GMT`, and `+02`, `+0200` or `+02:00`.
fn of_day(time: &str) -> Option<(i64, f64)> {
    let at = time.find(|c: char| c.is_ascii_alphabetic() || "+-".contains(c));
    let (time, zone) = time.split_at(at.unwrap_or(time.len()));
    let zone = match zone.to_ascii_uppercase().as_str() {
        "" | "Z" | "UTC" | "GMT" => 0,
        zone => {
            let (hours, minutes) = zone.get(1..)?.split_at_checked(2)?;
            let minutes = match minutes.trim_start_matches(':') {
                "" => "00",
                minutes => minutes,
            };
            let ahead = seconds(&format!("{hours}:{minutes}"))?.0;
            match zone.as_bytes()[0] {
                b'+' => ahead,
                b'-' => -ahead,
                _ => return None,
            }
        }
    };
    let (nanoseconds, rounding) = seconds(time.trim())?;
    Some((nanoseconds - zone, rounding))
}

/// Nanoseconds of `hh:mm`, `hh:mm:ss` or `hh:mm:ss.fff`, and what the last digit counts in seconds.
fn seconds(text: &str) -> Option<(i64, f64)> {
    let (whole, fraction) = text.split_once(['.', ',']).unwrap_or((text, ""));
    let mut parts = whole
        .split(':')
        .map(|part| part.parse::<i64>().ok().filter(|_| part.len() == 2));
    let (hours, minutes) = (parts.next()??, parts.next()??);
    let seconds = parts.next();
    let is_whole = seconds.is_none() && !fraction.is_empty();
    if parts.next().is_some() || is_whole || !fraction.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let rounding = match seconds {
        Some(_) => 10f64.powi(-(fraction.len() as i32)),
        None => 60.0,
    };
    let seconds = seconds.unwrap_or(Some(0))?;
    let is_time = hours < 24 && minutes < 60 && seconds <= 60;
    let digits = format!("{fraction:0<9}");
    let fraction: i64 = digits[..9].parse().ok()?;
    let total = (3600 * hours + 60 * minutes + seconds) * 1_000_000_000 + fraction;
    is_time.then_some((total, rounding))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_definition_dates_and_times_of_day() {
        const NOON: i64 = 1_769_860_800 * 1_000_000_000;
        for (text, nanoseconds) in [
            ("2026-01-31T12:00:00Z", NOON),
            ("2026-01-31 12:00:00.001", NOON + 1_000_000),
            ("2026/01/31 12:00", NOON),
            ("31.01.2026 12:00:00,000000001", NOON + 1),
            ("2026-01-31T14:00:00+02:00", NOON),
            ("2026-01-31T14:00:00+02", NOON),
            ("2026-01-31 08:30:00.0 -0330", NOON),
            ("2026-01-31 12:00:00 UTC", NOON),
            ("2026-01-31T12:00:00z", NOON),
            ("2026-01-31", NOON - DAY / 2),
            ("1970-01-01", 0),
            ("2000-02-29", 951_782_400 * 1_000_000_000),
            ("12:00:00.5", DAY / 2 + 500_000_000),
        ] {
            let found = Stamp::parse(text.as_bytes()).map(|stamp| stamp.nanoseconds);
            assert_eq!(found, Some(nanoseconds), "{text}");
        }
        for text in [
            "01/02/2026 12:00",
            "1.5",
            "2026",
            "12:61:00",
            "12:00:00 1.0",
            "12:00:00 PM",
            "12:00:00 CET",
            "12:00:00+2",
            "1.2.3",
            "",
        ] {
            assert_eq!(Stamp::parse(text.as_bytes()), None, "{text}");
        }
    }
}
