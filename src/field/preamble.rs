//! What stands before the rows of a table: settings of an oscilloscope or a logger, names of the columns,
//! their units.

use std::borrow::Cow;

use csv::ByteRecord;
use wavecascade_formats::Value;

use super::csv::{excerpt, number};
use super::meaning::{Meaning, enclosed, known_as, quantity};
use super::rows::with_point;
use super::statements::{Statement, Statements};
use crate::error::Fault;
use crate::measure::{Frequency, Time, symbol};

/// Rows before those of numbers.
const MOST_ROWS: usize = 1000;

/// Cells before the columns of numbers, where settings stand beside them: name, value and unit.
pub(super) const SETTING_CELLS: usize = 3;

/// What the rows before those of numbers say.
#[derive(Debug, Default)]
pub(super) struct Preamble {
    /// Rows before the names of the columns.
    pub(super) rows: usize,
    /// Names of the columns.
    pub(super) names: Option<ByteRecord>,
    /// Units of the columns, from a row of their own; empty where there is none.
    pub(super) units: Vec<String>,
    /// Its settings.
    pub(super) statements: Statements,
    /// Of the samples of each channel.
    pub(super) channel_units: Vec<String>,
}

impl Preamble {
    /// One of the settings in the comments before the rows, `# Sampling rate: 1 kHz`.
    pub(super) fn of_comments(text: &[u8]) -> Preamble {
        let mut found = Preamble::default();
        found.statements.are_settings = true;
        for line in comments(text) {
            let end = line.iter().position(|byte| b":=,;\t".contains(byte));
            if let Some((name, value)) = end.map(|end| line.split_at(end)) {
                found.set_by_row(&ByteRecord::from(vec![name, value[1..].trim_ascii()]));
            }
        }
        found
    }

    /// Whether a row is one of them: it names something, or holds no number; behind several of them also one
    /// that is empty.
    pub(super) fn may_continue(rows: &[ByteRecord], row: &ByteRecord) -> bool {
        let is_empty = || rows.len() > 1 && row.iter().all(|cell| cell.trim_ascii().is_empty());
        let is_named = super::header::is_header(super::Header::Detect, row);
        !rows.is_empty() && rows.len() < MOST_ROWS && (is_named || is_empty())
    }

    /// What `rows` say about a table whose first row of numbers is `first`. The last of them that holds no
    /// units names the columns, if it has as many cells.
    ///
    /// # Errors
    /// The place of a row that is none of these, and its first cell.
    pub(super) fn with_rows(
        mut self,
        rows: &[ByteRecord],
        first: &ByteRecord,
    ) -> Result<Preamble, usize> {
        let found = &mut self;
        let width = length(first, |_| false);
        let mut named = rows.len() - 1;
        while named > 0 {
            let row = &rows[named];
            if length(row, |_| false) == 0 {
                named -= 1;
            } else if found.units.is_empty() && is_row_of_units(row, width) {
                found.units = row.iter().map(|cell| unit_of(&excerpt(cell))).collect();
                found.set_by_columns(&rows[named - 1], row);
                named -= 1;
            } else {
                break;
            }
        }
        let row = &rows[named];
        let cells = row.iter().map(String::from_utf8_lossy);
        cells.for_each(|cell| found.set_by_equation(&cell));
        // A single row is one of names, whose number may be wrong.
        let is_known = rows.len() > 1 && found.set_by_row(row);
        let has_names = rows.len() == 1 || !is_known && length(row, is_setting) >= width;
        if has_names {
            let is_number = |cell: &[u8]| number(cell).is_some_and(f64::is_finite);
            let begins_with_time = known_as(&String::from_utf8_lossy(&row[0]), Meaning::Time);
            let is_damaged = named > 0 && row.iter().any(is_number) && found.units.is_empty();
            if is_damaged && begins_with_time.is_none() {
                return Err(named);
            }
        }
        found.rows = named + usize::from(!has_names);
        let settings = rows[..found.rows].iter();
        let known = settings.filter(|row| found.set_by_row(row)).count();
        if !has_names && known == 0 {
            return Err(1);
        }
        found.names = has_names.then(|| row.clone());
        Ok(self)
    }

    /// The unit of a column in the row of units.
    pub(super) fn unit(&self, column: usize) -> Option<&String> {
        self.units.get(column).filter(|unit| !unit.is_empty())
    }

    /// Of settings in the first cells of rows of numbers, as older oscilloscopes of Tektronix write them.
    pub(super) fn beside(text: &[u8]) -> Preamble {
        let mut found = Preamble::of_comments(text);
        let mut channels = Vec::new();
        for line in text.split(|&byte| byte == b'\n').take(MOST_ROWS) {
            let cells = line.split(|&byte| byte == b',').take(SETTING_CELLS);
            let cells: Vec<&[u8]> = cells.map(|cell| bare(cell.trim_ascii())).collect();
            if cells[0].eq_ignore_ascii_case(b"source") {
                channels.extend(cells.get(1).map(|name| excerpt(name)));
            }
            found.set_by_row(&ByteRecord::from(cells));
        }
        let mut names = ByteRecord::from(vec!["time"]);
        let channel = channels.first().map_or("CH1", String::as_str);
        names.push_field(channel.as_bytes());
        found.names = Some(names);
        found
    }

    /// Whether settings stand beside the numbers of this row.
    pub(super) fn is_beside(row: &ByteRecord) -> bool {
        let is_number = |cell: &[u8]| number(cell).is_some_and(f64::is_finite);
        let is_first = |cell: &[u8]| cell.eq_ignore_ascii_case(b"record length");
        let numbers = [SETTING_CELLS, SETTING_CELLS + 1].map(|at| row.get(at));
        row.get(0).is_some_and(is_first) && numbers.iter().all(|cell| cell.is_some_and(is_number))
    }

    /// Takes a setting and its values; whether it is one that is known.
    fn set_by_row(&mut self, row: &ByteRecord) -> bool {
        let mut cells = row.iter().map(excerpt);
        let name = cells.next().unwrap_or_default();
        let values: Vec<String> = cells.filter(|cell| !cell.is_empty()).collect();
        let Some(value) = values.first() else {
            return false;
        };
        let is_unit = self.statements.has(&name, Meaning::Unit);
        if is_unit {
            self.channel_units = values.iter().map(|unit| unit_of(unit)).collect();
        }
        is_unit || self.set(&name, value, values.get(1).map(String::as_str))
    }

    /// Takes `tInc = 1e-6` of a cell.
    fn set_by_equation(&mut self, cell: &str) {
        if let Some((name, value)) = cell.split_once('=') {
            // Those oscilloscopes count in seconds.
            let unit = name.trim().eq_ignore_ascii_case("tinc").then_some("s");
            self.set(name.trim(), value.trim(), unit);
        }
    }

    /// Takes the columns `Start` and `Increment`, whose values stand in the row of units.
    fn set_by_columns(&mut self, names: &ByteRecord, values: &ByteRecord) {
        for (name, value) in names.iter().map(excerpt).zip(values) {
            if matches!(name.to_lowercase().as_str(), "start" | "increment") {
                self.set(&name, &excerpt(value), Some("s"));
            }
        }
    }

    /// Takes a setting with the unit that stands beside it; whether it is one that is known.
    fn set(&mut self, name: &str, value: &str, unit: Option<&str>) -> bool {
        let value = Value::Text(unit_of(value));
        let one = Statement::new(name, name, value, unit.map(unit_of));
        self.statements.take(one)
    }
}

/// A cell without the quotes around it.
fn bare(cell: &[u8]) -> &[u8] {
    let cell = cell.strip_prefix(b"\"").unwrap_or(cell);
    cell.strip_suffix(b"\"").unwrap_or(cell)
}

/// The comments before the first row, without their signs.
pub(super) fn comments(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let lines = text.split(|&byte| matches!(byte, b'\n' | b'\r'));
    let lines = lines.map(<[u8]>::trim_ascii);
    let preamble = lines.take_while(|line| line.is_empty() || line.starts_with(b"#"));
    preamble.filter_map(|line| line.strip_prefix(b"#"))
}

/// Cells as far as one holds something that is no setting of its own.
pub(super) fn length(row: &ByteRecord, is_setting: fn(&[u8]) -> bool) -> usize {
    let is_content = |cell: &[u8]| !cell.trim_ascii().is_empty() && !is_setting(cell);
    let cells: Vec<&[u8]> = row.iter().collect();
    let last = cells.iter().rposition(|&cell| is_content(cell));
    last.map_or(0, |last| last + 1)
}

/// Whether a cell of a row of names is no name, but `tInc = 1e-6`, or heads a column of one value.
pub(super) fn is_setting(cell: &[u8]) -> bool {
    let cell = excerpt(cell).to_lowercase();
    let value = cell
        .split_once('=')
        .map(|(_, value)| number(value.as_bytes()));
    value.is_some_and(|value| value.is_some_and(f64::is_finite))
        || matches!(cell.as_str(), "start" | "increment")
}

/// Whether each cell is a unit, or beyond the columns of the table a number.
fn is_row_of_units(row: &ByteRecord, width: usize) -> bool {
    let cells = row.iter().enumerate();
    let mut cells = cells.filter(|(_, cell)| !cell.trim_ascii().is_empty());
    cells.all(|(at, cell)| match number(cell) {
        Some(_) => at >= width,
        None => {
            let text = excerpt(cell);
            let unit = unit_of(&text);
            let counts = ["sequence", "points", "samples"];
            let is_count = || counts.contains(&unit.to_lowercase().as_str());
            enclosed(&text).is_some() || is_unit(&unit) || is_count()
        }
    })
}

fn is_unit(unit: &str) -> bool {
    const UNITS: [&str; 12] = [
        "V", "mV", "uV", "\u{b5}V", "kV", "A", "mA", "uA", "W", "Pa", "dB", "dBm",
    ];
    symbol::<Time>(unit).is_some()
        || symbol::<Frequency>(unit).is_some()
        || UNITS.contains(&unit)
        || quantity("", None, Some(unit)).is_some()
}

/// A unit as a symbol, without its brackets.
pub(super) fn unit_of(text: &str) -> String {
    let bare = enclosed(text).unwrap_or(text).trim();
    let lower = bare.to_lowercase();
    match lower.as_str() {
        "volt" | "volts" => "V".into(),
        "millivolt" | "millivolts" => "mV".into(),
        "ampere" | "amperes" | "amp" | "amps" => "A".into(),
        _ => symbol::<Time>(&lower).unwrap_or(bare).to_owned(),
    }
}

/// That no row of whole numbers between commas has one with zeros before its other digits, as only decimals
/// have them.
///
/// # Errors
/// The line of one that has.
pub(super) fn check_commas(text: &[u8]) -> Result<(), Fault> {
    let both = |line: usize, found: String| {
        let text = format!(
            "line {line}: expected commas between numbers or within them, found both in {found:?}; write the \
             table with semicolons or tabs between its cells"
        );
        Err(Fault::new(text, ""))
    };
    let is_digit = |byte: &u8| byte.is_ascii_digit();
    // The digits of a number without a point, before its exponent.
    let digits = |cell: &'_ [u8]| -> Option<Vec<u8>> {
        let mantissa = cell.split(|byte| matches!(byte, b'e' | b'E')).next()?;
        let digits = mantissa.strip_prefix(b"-").unwrap_or(mantissa);
        let is_whole = !digits.is_empty() && digits.iter().all(is_digit);
        (is_whole && number(cell).is_some()).then(|| digits.to_vec())
    };
    for (line, text) in (1..).zip(text.split(|&byte| byte == b'\n')) {
        let quoted = text.split(|&byte| byte == b'"').skip(1).step_by(2);
        let mut with_comma = quoted.filter(|cell| matches!(with_point(cell), Cow::Owned(_)));
        if let Some(cell) = with_comma.next() {
            return both(line, excerpt(cell));
        }
        let cells = text.split(|&byte| byte == b',');
        let cells: Vec<&[u8]> = cells.map(<[u8]>::trim_ascii).collect();
        let all: Option<Vec<Vec<u8>>> = cells.iter().map(|cell| digits(cell)).collect();
        let is_padded = |digits: &Vec<u8>| digits.len() > 1 && digits[0] == b'0';
        let padded = all.iter().flatten().skip(1).position(is_padded);
        if let Some(at) = padded {
            return both(line, [excerpt(cells[at]), excerpt(cells[at + 1])].join(","));
        }
    }
    Ok(())
}
