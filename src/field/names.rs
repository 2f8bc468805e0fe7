//! By which names the members of an archive and the columns of a table are known.

use super::Layout;
use crate::measure::{Dimension, Length, Time, symbol};

/// Names of a member that is the field, the first one first.
pub(super) const FIELD: [&str; 2] = ["velocity", "v"];
/// Of one that holds the times.
pub(super) const TIME: [&str; 2] = ["time", "t"];
/// Of one that holds the positions.
pub(super) const SPACE: [&str; 2] = ["position", "x"];

/// Names of a single number that may be the position of a record.
pub(super) const POSITION: [&str; 15] = [
    "x",
    "y",
    "z",
    "r",
    "position",
    "distance",
    "offset",
    "depth",
    "elevation",
    "location",
    "group_x",
    "group_y",
    "source_x",
    "source_y",
    "x0",
];

/// The unit that the name of a column of coordinates of the rows states: `None` for another name.
pub(super) fn row_unit(name: &str, layout: Layout) -> Option<Option<String>> {
    match layout {
        Layout::TimeSite => unit::<Time>(name, &TIME),
        Layout::SiteTime => unit::<Length>(name, &SPACE),
    }
}

/// As [`row_unit`], of a column of times in a table, whose name may be German, French, Spanish or Italian, or
/// the unit itself.
pub(super) fn table_time(name: &str) -> Option<Option<String>> {
    const TIMES: [&str; 4] = ["zeit", "temps", "tiempo", "tempo"];
    const SECONDS: [&str; 3] = ["second", "seconds", "sec"];
    let lower = name.trim().to_ascii_lowercase();
    unit::<Time>(name, &TIME)
        .or_else(|| unit::<Time>(name, &TIMES))
        .or_else(|| {
            SECONDS
                .contains(&lower.as_str())
                .then(|| Some("s".to_owned()))
        })
}

/// Whether a column of this name counts the rows of a table.
pub(super) fn counts_rows(name: &str) -> bool {
    const COUNTS: [&str; 22] = [
        "", "#", "n", "i", "no", "nr", "num", "number", "index", "idx", "row", "line", "sample",
        "samples", "point", "points", "count", "counter", "sequence", "record", "unnamed", "frame",
    ];
    let lower = name.trim().to_lowercase();
    let words = lower.split([' ', '_', ':', '.', '-', '(', ')']);
    let mut words = words
        .filter(|word| !word.is_empty() && *word != "0")
        .peekable();
    words.peek().is_none() || words.all(|word| COUNTS.contains(&word))
}

/// What stands in round or square brackets.
pub(super) fn enclosed(text: &str) -> Option<&str> {
    let text = text.trim();
    let within = |open, close| text.strip_prefix(open)?.strip_suffix(close);
    within('(', ')').or(within('[', ']'))
}

/// As [`row_unit`], of a column of positions.
pub(super) fn position_unit(name: &str) -> Option<Option<String>> {
    unit::<Length>(name, &SPACE)
}

/// The unit in `t`, `time`, `time_s`, `t/ms`, `Time (s)`, `time [µs]`; `None` for other names.
fn unit<D: Dimension>(name: &str, names: &[&str]) -> Option<Option<String>> {
    let name = name.trim();
    let lower = name.to_ascii_lowercase();
    let base = names.iter().find(|base| lower.starts_with(**base))?;
    let rest = name[base.len()..].trim();
    if rest.is_empty() {
        return Some(None);
    }
    let unit = enclosed(rest).or_else(|| {
        rest.strip_prefix(['_', '/'])
            .filter(|unit| symbol::<D>(unit).is_some())
    })?;
    Some(Some(unit.trim().to_owned()).filter(|unit| !unit.is_empty()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_column_is_known_by_its_name() {
        for (name, unit) in [
            ("t", None),
            ("Time", None),
            ("time_s", Some("s")),
            ("time_sec", Some("sec")),
            ("Time (ms)", Some("ms")),
            ("t [\u{b5}s]", Some("\u{b5}s")),
            ("t/ns", Some("ns")),
        ] {
            let found = row_unit(name, Layout::TimeSite);
            assert_eq!(found, Some(unit.map(String::from)), "{name}");
        }
        for name in ["t0", "t_1", "temperature", "times", "x", "", "v(t)"] {
            assert_eq!(row_unit(name, Layout::TimeSite), None, "{name}");
        }
        let found = row_unit("x_mm", Layout::SiteTime);
        assert_eq!(found, Some(Some("mm".into())));
        assert_eq!(row_unit("x0", Layout::SiteTime), None);
    }
}
