//! Dates and times of day as tables write them.

use jiff::fmt::temporal::Pieces;
use jiff::tz::Offset;

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
    ///
    /// Zones are `Z`, `UTC` or `GMT`, and `+02`, `+0200` or `+02:00`.
    pub(super) fn parse(cell: &[u8]) -> Option<Stamp> {
        const DAY: f64 = 86_400.0;
        let text = str::from_utf8(cell).ok()?.trim();
        if !text.starts_with(|c: char| c.is_ascii_digit()) {
            return None;
        }
        let (date, time) = match text.split_once(['T', ' ']) {
            Some((date, time)) => (Some(date), Some(time.trim())),
            None if text.contains(':') => (None, Some(text)),
            None => (Some(text), None),
        };
        let day = date.map_or_else(|| Some("1970-01-01".into()), iso)?;
        let time_of_day = time.unwrap_or("00:00");
        let is_zone = |c: char| c.is_ascii_alphabetic() || "+-".contains(c);
        let zone = time_of_day.find(is_zone).unwrap_or(time_of_day.len());
        let (clock, zone) = time_of_day.split_at(zone);
        let zone = match zone.to_ascii_uppercase().as_str() {
            "UTC" | "GMT" => "Z".to_owned(),
            zone => zone.to_owned(),
        };
        let clock = clock.trim();
        let point = clock.find(['.', ',']).unwrap_or(clock.len());
        // Nanoseconds are the last digits that count.
        let counted = clock.get(..point + 10).unwrap_or(clock);
        let text = format!("{day}T{counted}{zone}");
        let pieces = Pieces::parse(&text).ok()?;
        let at = pieces.date().to_datetime(pieces.time()?);
        let offset = pieces.to_numeric_offset().unwrap_or(Offset::UTC);
        let decimals = clock.len().saturating_sub(point + 1) as i32;
        Some(Stamp {
            nanoseconds: offset
                .to_timestamp(at)
                .ok()?
                .as_nanosecond()
                .try_into()
                .ok()?,
            has_date: date.is_some(),
            has_time: time.is_some(),
            rounding: match (time, clock.matches(':').count()) {
                (None, _) => DAY,
                (_, 1) => 60.0,
                _ => 10f64.powi(-decimals),
            },
        })
    }
}

/// A date as ISO 8601 writes it.
fn iso(date: &str) -> Option<String> {
    let parts: Vec<&str> = date.split(['-', '/', '.']).collect();
    // Whether days or months come first in 01/02/2026 is not known; of 01.02.2026 days do.
    let (year, month, day) = match parts[..] {
        [year, month, day] if year.len() == 4 => (year, month, day),
        [day, month, year] if date.contains('.') => (year, month, day),
        _ => return None,
    };
    Some(format!("{year}-{month:0>2}-{day:0>2}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_definition_dates_and_times_of_day() {
        const DAY: i64 = 86_400 * 1_000_000_000;
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
