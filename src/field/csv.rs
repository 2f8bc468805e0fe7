//! Tables of text: one row a time (or a site), cells separated by commas, tabs, semicolons or
//! blanks, `#` before a comment, an empty cell or `nan` for a gap.

use csv::ByteRecord;
use memmap2::Mmap;

use super::Layout;
use super::coordinates::{Coordinates, Uneven};
use super::fault::InputFault;
use super::open::{Contents, Source};
use super::options::{Header, TimeColumn};
use super::rows::{Rows, line_of_row};
use super::storage::{self, Storage};
use crate::error::{Error, Result};

/// A table, with the coordinates that its header and its time column state.
pub(super) fn read(source: &Source) -> Result<Contents> {
    let fault = |fault| source.fault(fault);
    let mut rows = Rows::new(source).map_err(fault)?;
    let mut record = ByteRecord::new();
    if !rows.next(&mut record).map_err(fault)? {
        return Err(fault(InputFault::NoRows));
    }
    let header = is_header(source.options.header, &record).then(|| record.clone());
    if header.is_some() && !rows.next(&mut record).map_err(fault)? {
        return Err(fault(InputFault::NoRows));
    }
    let time_column = time_column(source, header.as_ref(), record.len())?;
    let n_columns = record.len() - usize::from(time_column.is_some());
    if n_columns == 0 {
        return Err(fault(InputFault::NoColumns));
    }
    let width = header.as_ref().map_or(record.len(), ByteRecord::len);
    let mut table = Table::new(source, width, n_columns, time_column)?;
    loop {
        table.push(&record).map_err(fault)?;
        if !rows.next(&mut record).map_err(fault)? {
            break;
        }
    }
    table.contents(header.as_ref())
}

struct Table<'a> {
    source: &'a Source<'a>,
    width: usize,
    time_column: Option<usize>,
    n_columns: usize,
    values: Vec<f64>,
    times: Vec<f64>,
    /// For each of the times, the line from which its row was looked for.
    lines: Vec<u64>,
    /// What the last printed digit of the times counts.
    rounding: f64,
}

impl<'a> Table<'a> {
    fn new(
        source: &'a Source<'a>,
        width: usize,
        n_columns: usize,
        time_column: Option<usize>,
    ) -> Result<Table<'a>> {
        let most = count_lines(&source.map)
            .saturating_mul(n_columns)
            .min(source.map.len() + 1);
        let needed = most as u64 * size_of::<f64>() as u64;
        source.allow("the table", needed)?;
        let mut values = Vec::new();
        values
            .try_reserve_exact(most)
            .map_err(|refused| Error::Read {
                path: source.path.to_owned(),
                action: "hold the table in",
                source: refused.into(),
            })?;
        Ok(Table {
            source,
            width,
            time_column,
            n_columns,
            values,
            times: Vec::new(),
            lines: Vec::new(),
            rounding: f64::INFINITY,
        })
    }

    fn push(&mut self, record: &ByteRecord) -> std::result::Result<(), InputFault> {
        if record.len() != self.width {
            return Err(InputFault::Ragged {
                line: self.line(starts_at(record)),
                expected: self.width,
                found: record.len(),
            });
        }
        for (column, cell) in record.iter().enumerate() {
            let value = number(cell);
            let is_time = self.time_column == Some(column);
            match value {
                Some(time) if is_time && time.is_finite() => {
                    self.times.push(time);
                    self.lines.push(starts_at(record));
                    self.rounding = self.rounding.min(printed_unit(cell));
                }
                Some(value) if !is_time => self.values.push(value),
                _ => {
                    return Err(InputFault::Cell {
                        line: self.line(starts_at(record)),
                        column: column + 1,
                        found: excerpt(cell),
                    });
                }
            }
        }
        Ok(())
    }

    /// The line of the row that the reader looked for from line `from`.
    fn line(&self, from: u64) -> u64 {
        line_of_row(&self.source.map, from)
    }

    fn contents(self, header: Option<&ByteRecord>) -> Result<Contents> {
        let source = self.source;
        let stated = &source.stated;
        let rows = fit(&self.times, self.rounding, stated.dt).map_err(|uneven| {
            source.fault(InputFault::UnevenTimes {
                line: self.line(self.lines[uneven.index]),
                expected: uneven.expected,
                found: uneven.found,
            })
        })?;
        let n_rows = self.values.len() / self.n_columns;
        let columns = |axis: &'static str, step| {
            let labels = header.and_then(|header| labels(header, self.time_column));
            let (values, rounding) = labels.unwrap_or_default();
            fit(&values, rounding, step).map_err(|uneven| {
                source.fault(InputFault::UnevenAxis {
                    axis,
                    index: uneven.index,
                    expected: uneven.expected,
                    found: uneven.found,
                })
            })
        };
        let unit = header.zip(self.time_column).and_then(|(header, column)| {
            time_unit(&String::from_utf8_lossy(&header[column])).flatten()
        });
        let rows_are_times = source.layout() == Layout::TimeSite;
        let (n_times, n_sites, time, space) = if rows_are_times {
            let space = columns("space", stated.dx)?;
            (n_rows, self.n_columns, Coordinates { unit, ..rows }, space)
        } else {
            let time = columns("time", stated.dt)?;
            (self.n_columns, n_rows, time, Coordinates::default())
        };
        Ok(Contents {
            struck: None,
            storage: Storage::from_values(self.values, self.n_columns, rows_are_times),
            n_times,
            n_sites,
            time,
            space,
            quantity: None,
            unit: None,
        })
    }
}

/// Coordinates of `values`; where the step is stated, the values are not asked for theirs.
fn fit(
    values: &[f64],
    rounding: f64,
    step: Option<f64>,
) -> std::result::Result<Coordinates, Uneven> {
    match step {
        Some(_) => Ok(Coordinates::from_first(values)),
        None => Coordinates::fit(values, rounding),
    }
}

/// A header starts with a word, or holds no number at all.
fn is_header(stated: Header, record: &ByteRecord) -> bool {
    let is_text = |cell: &[u8]| number(cell).is_none();
    let is_number = |cell: &[u8]| number(cell).is_some_and(|value| !value.is_nan());
    let is_word = |cell: &[u8]| is_text(cell) && cell.trim_ascii()[0].is_ascii_alphabetic();
    match stated {
        Header::Present => true,
        Header::Absent => false,
        Header::Detect => {
            is_word(&record[0]) || record.iter().any(is_text) && !record.iter().any(is_number)
        }
    }
}

fn time_column(
    source: &Source,
    header: Option<&ByteRecord>,
    width: usize,
) -> Result<Option<usize>> {
    let asked = &source.options.time_column;
    let stated = matches!(asked, TimeColumn::Index(_) | TimeColumn::Name(_));
    if source.layout() == Layout::SiteTime {
        return match stated {
            false => Ok(None),
            true => Err(Error::Request {
                option: "time-column",
                expected: "a table whose rows are times".into(),
                found: "the layout site-time".into(),
            }),
        };
    }
    let names: Vec<String> = match header {
        Some(header) => header.iter().map(excerpt).collect(),
        None => (0..width).map(|column| column.to_string()).collect(),
    };
    let (column, asked) = match asked {
        TimeColumn::None => return Ok(None),
        TimeColumn::Detect => {
            let is_time = |name: &String| header.is_some() && time_unit(name).is_some();
            return Ok(names.iter().position(is_time));
        }
        TimeColumn::Index(index) => (Some(*index).filter(|&i| i < width), index.to_string()),
        TimeColumn::Name(name) => (
            names
                .iter()
                .position(|cell| header.is_some() && cell == name.trim()),
            format!("{name:?}"),
        ),
    };
    let missing = || {
        source.fault(InputFault::NoSuchColumn {
            asked,
            columns: names,
        })
    };
    column.ok_or_else(missing).map(Some)
}

/// The unit in `t`, `time`, `time_s`, `t/ms`, `Time (s)`, `time [µs]`; `None` for other names.
fn time_unit(name: &str) -> Option<Option<String>> {
    let name = name.trim();
    let lower = name.to_ascii_lowercase();
    let base = ["time", "t"]
        .into_iter()
        .find(|base| lower.starts_with(base))?;
    let rest = name[base.len()..].trim();
    if rest.is_empty() {
        return Some(None);
    }
    let enclosed = |open, close| rest.strip_prefix(open)?.strip_suffix(close);
    let unit = enclosed('(', ')').or(enclosed('[', ']')).or_else(|| {
        rest.strip_prefix(['_', '/'])
            .filter(|unit| ["s", "ms", "us", "µs", "ns", "min", "h"].contains(unit))
    })?;
    Some(Some(unit.trim().to_owned()).filter(|unit| !unit.is_empty()))
}

/// The numbers in a header that holds only numbers beside the time column, and their rounding.
fn labels(header: &ByteRecord, time_column: Option<usize>) -> Option<(Vec<f64>, f64)> {
    let cells = || {
        let cells = header.iter().enumerate();
        cells.filter_map(|(column, cell)| (time_column != Some(column)).then_some(cell))
    };
    let values: Option<Vec<f64>> = cells()
        .map(|cell| number(cell).filter(|value| value.is_finite()))
        .collect();
    Some((
        values?,
        cells().map(printed_unit).fold(f64::INFINITY, f64::min),
    ))
}

fn number(cell: &[u8]) -> Option<f64> {
    match cell.trim_ascii() {
        [] => Some(f64::NAN),
        text => str::from_utf8(text).ok()?.parse().ok(),
    }
}

/// What the last digit of a printed number counts: `1e-4` for `0.1250` and for `125.0e-3`.
fn printed_unit(cell: &[u8]) -> f64 {
    let mut parts = cell
        .trim_ascii()
        .splitn(2, |byte| matches!(byte, b'e' | b'E'));
    let mantissa = parts.next().unwrap_or_default();
    let exponent = parts.next().and_then(|text| str::from_utf8(text).ok());
    let exponent: i32 = exponent.and_then(|text| text.parse().ok()).unwrap_or(0);
    let point = mantissa.iter().position(|&byte| byte == b'.');
    let decimals = point.map_or(0, |point| mantissa.len() - point - 1);
    10f64.powi(exponent.saturating_sub(decimals as i32))
}

fn excerpt(cell: &[u8]) -> String {
    let text = String::from_utf8_lossy(&cell[..cell.len().min(160)]);
    text.trim().chars().take(40).collect()
}

/// The line from which a row was looked for; blank lines and comments may come before it.
fn starts_at(record: &ByteRecord) -> u64 {
    record.position().map_or(0, csv::Position::line)
}

fn count_lines(map: &Mmap) -> usize {
    let mut count = 1;
    let mut last = 0;
    storage::stream(map, 0..map.len(), |chunk| {
        for &byte in chunk {
            count += usize::from(byte == b'\r' || byte == b'\n' && last != b'\r');
            last = byte;
        }
    });
    count
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
            ("Time (ms)", Some("ms")),
            ("t [\u{b5}s]", Some("\u{b5}s")),
            ("t/ns", Some("ns")),
        ] {
            assert_eq!(time_unit(name), Some(unit.map(String::from)), "{name}");
        }
        for name in ["t0", "t_1", "temperature", "times", "x", "", "v(t)"] {
            assert_eq!(time_unit(name), None, "{name}");
        }
    }

    #[test]
    fn a_printed_number_is_exact_to_its_last_digit() {
        for (text, unit) in [
            ("0.1250", 1e-4),
            ("125.0e-3", 1e-4),
            ("3", 1.0),
            ("-2E+2", 1e2),
        ] {
            let found = printed_unit(text.as_bytes());
            assert!((found / unit - 1.0).abs() < 1e-12, "{text}: {found}");
        }
    }

    #[test]
    fn a_header_starts_with_a_word_or_holds_no_number() {
        let detected =
            |cells: &[&str]| is_header(Header::Detect, &ByteRecord::from(cells.to_vec()));
        assert!(detected(&["time", "0.0", "0.5"]));
        assert!(detected(&["", "v1", "v2"]));
        assert!(detected(&["(1)", "(2)"]));
        assert!(!detected(&["1.0x", "2.0"]));
        assert!(!detected(&["1.0", "v2"]));
        assert!(!detected(&["nan", ""]));
    }
}
