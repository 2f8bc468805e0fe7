//! Tables of text: one row a time (or a site), cells separated by commas, tabs, semicolons or
//! blanks, `#` before a comment, an empty cell or `nan` for a gap.

use csv::ByteRecord;

use super::coordinates::{Coordinates, Listed, Uneven};
use super::file_bytes::FileBytes;
use super::names::row_unit;
use super::open::{Contents, FileSource};
use super::options::{Header, TimeColumn};
use super::rows::{RowReader, line_of_row};
use super::storage::Storage;
use super::{Layout, Note, header};
use crate::error::{CoordinateKind, Error, InputFault, Result};
use crate::system::memory::try_with_capacity;

/// A table, with the coordinates that its header and its first column state.
pub(super) fn read(source: &FileSource) -> Result<Contents> {
    let fault = |fault| source.fault(fault);
    let mut rows = RowReader::new(source).map_err(fault)?;
    let mut record = ByteRecord::new();
    if !rows.next(&mut record).map_err(fault)? {
        return Err(fault(InputFault::NoRows));
    }
    let stated = source.options.header;
    let first_line = header::is_header(stated, &record).then(|| record.clone());
    if first_line.is_some() && !rows.next(&mut record).map_err(fault)? {
        return Err(fault(InputFault::NoRows));
    }
    let layout = source.layout();
    let header = match first_line {
        Some(line) => Some(header::of_line(line, &rows, record.len())),
        None if stated == Header::Detect => header::of_comments(
            &source.bytes,
            record.len(),
            layout,
            &source.options.time_column,
        ),
        None => None,
    };
    let axis_column = axis_column(source, header.as_ref(), record.len())?;
    let n_columns = record.len() - usize::from(axis_column.is_some());
    if n_columns == 0 {
        return Err(fault(InputFault::NoColumns));
    }
    let width = header.as_ref().map_or(record.len(), ByteRecord::len);
    let mut table = Table::new(source, width, n_columns, axis_column)?;
    loop {
        table.push(&record).map_err(fault)?;
        if !rows.next(&mut record).map_err(fault)? {
            break;
        }
    }
    if axis_column.is_none() && source.options.time_column == TimeColumn::Detect {
        table.judge_first_column().map_err(fault)?;
    }
    table.contents(header.as_ref())
}

struct Table<'a> {
    source: &'a FileSource<'a>,
    width: usize,
    /// The column of the rows' coordinates: times, or with the layout site-time positions.
    axis_column: Option<usize>,
    /// Columns of samples.
    n_columns: usize,
    values: Vec<f64>,
    /// The coordinates of the rows.
    places: Vec<f64>,
    /// For each of them, the line at which the search for its row began.
    lines: Vec<u64>,
    /// What the last printed digit of the coordinates counts; of the first column, where no column
    /// is known to hold them.
    rounding: f64,
    notes: Vec<Note>,
}

impl<'a> Table<'a> {
    fn new(
        source: &'a FileSource<'a>,
        width: usize,
        n_columns: usize,
        axis_column: Option<usize>,
    ) -> Result<Table<'a>> {
        let most = count_lines(&source.bytes)
            .saturating_mul(n_columns)
            .min(source.bytes.len() + 1);
        let needed = most as u64 * size_of::<f64>() as u64;
        source.allow("the table", needed)?;
        let values = try_with_capacity(most).map_err(|refused| Error::Read {
            path: source.path.to_owned(),
            action: "hold the table in",
            source: refused.into(),
        })?;
        Ok(Table {
            source,
            width,
            axis_column,
            n_columns,
            values,
            places: Vec::new(),
            lines: Vec::new(),
            rounding: f64::INFINITY,
            notes: Vec::new(),
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
            let is_place = self.axis_column == Some(column);
            if column == self.axis_column.unwrap_or(0) {
                self.rounding = self.rounding.min(printed_unit(cell));
            }
            match value {
                Some(place) if is_place && place.is_finite() => {
                    self.places.push(place);
                    self.lines.push(starts_at(record));
                }
                Some(value) if !is_place => self.values.push(value),
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

    /// The line of the row whose search began at line `from`.
    fn line(&self, from: u64) -> u64 {
        line_of_row(&self.source.bytes, from)
    }

    /// Decides whether the first column holds coordinates of the rows: it does if it rises evenly
    /// and no other does.
    ///
    /// # Errors
    /// If it may hold either coordinates or samples: other columns rise evenly too, or it rises
    /// unevenly.
    fn judge_first_column(&mut self) -> std::result::Result<(), InputFault> {
        // Two rows always rise evenly or fall, and a few rise by chance.
        const EVENLY: usize = 3;
        const UNEVENLY: usize = 8;
        let width = self.n_columns;
        let n_rows = self.values.len() / width;
        if width < 2 || n_rows < EVENLY {
            return Ok(());
        }
        let column =
            |j: usize| -> Vec<f64> { self.values.iter().skip(j).step_by(width).copied().collect() };
        let first = column(0);
        let layout = self.source.layout();
        let coordinates = match layout {
            Layout::TimeSite => CoordinateKind::Times,
            Layout::SiteTime => CoordinateKind::Positions,
        };
        let doubt = |reason| {
            Err(InputFault::FirstColumn {
                coordinates,
                reason,
            })
        };
        let Ok(even) = Coordinates::fit(&first, self.rounding) else {
            return match n_rows >= UNEVENLY && first.is_sorted_by(|a, b| a < b) {
                true => doubt("rises unevenly"),
                false => Ok(()),
            };
        };
        // Another column that rises about evenly might be a coordinate as well.
        let is_even = |j: usize| Coordinates::fit(&column(j), f64::INFINITY).is_ok();
        if (1..width).any(is_even) {
            return doubt("rises evenly, and so does another");
        }
        let step = even.step.unwrap_or(1.0);
        self.notes.push(Note::FirstColumn { layout, step });
        let mut at = 0;
        self.values.retain(|_| {
            at += 1;
            (at - 1) % width != 0
        });
        (self.places, self.n_columns, self.axis_column) = (first, width - 1, Some(0));
        Ok(())
    }

    fn contents(mut self, header: Option<&ByteRecord>) -> Result<Contents> {
        let source = self.source;
        let stated = &source.stated;
        let rows_are_times = source.layout() == Layout::TimeSite;
        let has_step = match rows_are_times {
            true => stated.dt.is_some(),
            false => stated.dx.is_some(),
        };
        let row_axis = if rows_are_times { "time" } else { "space" };
        let fit = |axis, values: &[f64], rounding, has_step| match has_step {
            true => Ok(Listed {
                even: Coordinates::from_first(values),
                ..Listed::default()
            }),
            false => Coordinates::listed(axis, values, rounding, source.options.evenness(axis)),
        };
        let rows = fit(row_axis, &self.places, self.rounding, has_step).map_err(|uneven| {
            source.fault(match uneven {
                Uneven {
                    index,
                    expected,
                    found,
                    is_gap: false,
                } if rows_are_times => InputFault::UnevenTimes {
                    line: self.line(self.lines[index]),
                    expected,
                    found,
                },
                other => other.fault(row_axis),
            })
        })?;
        let n_rows = self.values.len() / self.n_columns;
        let columns = |axis: &'static str, has_step| {
            let labels = header.and_then(|header| header::labels(header, self.axis_column));
            let (values, rounding) = labels.unwrap_or_default();
            fit(axis, &values, rounding, has_step)
                .map_err(|uneven| source.fault(uneven.fault(axis)))
        };
        let unit = header.zip(self.axis_column).and_then(|(header, column)| {
            row_unit(&String::from_utf8_lossy(&header[column]), source.layout()).flatten()
        });
        let rows = Listed {
            even: Coordinates { unit, ..rows.even },
            ..rows
        };
        let (n_times, n_sites, time, space) = if rows_are_times {
            let space = columns("space", stated.dx.is_some())?;
            (n_rows, self.n_columns, rows, space)
        } else {
            let time = columns("time", stated.dt.is_some())?;
            (self.n_columns, n_rows, time, rows)
        };
        self.notes.extend(
            [&time, &space]
                .into_iter()
                .filter_map(|listed| listed.note.clone()),
        );
        if stated.layout.is_none() && self.axis_column.is_none() {
            self.notes.extend(Note::on_shape(n_times, n_sites));
        }
        // Columns are sites where rows are times.
        let names = header.into_iter().flat_map(ByteRecord::iter).enumerate();
        let channels = names
            .filter(|(column, _)| rows_are_times && self.axis_column != Some(*column))
            .map(|(_, cell)| excerpt(cell))
            .collect();
        Ok(Contents {
            struck: None,
            dispersion: None,
            storage: Storage::from_values(self.values, self.n_columns, rows_are_times),
            n_times,
            n_sites,
            time: time.even,
            space: space.even,
            resampling: [time.resampling, space.resampling],
            quantity: None,
            unit: None,
            axis_names: [None, None],
            channels,
            notes: self.notes,
        })
    }
}

fn axis_column(
    source: &FileSource,
    header: Option<&ByteRecord>,
    width: usize,
) -> Result<Option<usize>> {
    let asked = &source.options.time_column;
    let stated = matches!(asked, TimeColumn::Index(_) | TimeColumn::Name(_));
    let layout = source.layout();
    if stated && layout == Layout::SiteTime {
        return Err(Error::Request {
            option: "time-column",
            expected: "a table whose rows are times".into(),
            found: "the layout site-time".into(),
        });
    }
    let names: Vec<String> = match header {
        Some(header) => header.iter().map(excerpt).collect(),
        None => (0..width).map(|column| column.to_string()).collect(),
    };
    let (column, asked) = match asked {
        TimeColumn::None => return Ok(None),
        TimeColumn::Detect => {
            let is_time = |name: &String| header.is_some() && row_unit(name, layout).is_some();
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

pub(super) fn number(cell: &[u8]) -> Option<f64> {
    match cell.trim_ascii() {
        [] => Some(f64::NAN),
        text => str::from_utf8(text).ok()?.parse().ok(),
    }
}

/// What the last digit of a printed number counts: `1e-4` for `0.1250` and for `125.0e-3`.
pub(super) fn printed_unit(cell: &[u8]) -> f64 {
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

/// The line at which the search for a row began; blank lines and comments may precede the row.
fn starts_at(record: &ByteRecord) -> u64 {
    record.position().map_or(0, csv::Position::line)
}

fn count_lines(bytes: &FileBytes) -> usize {
    let mut count = 1;
    let mut last = 0;
    bytes.stream(0..bytes.len(), |chunk| {
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
}
