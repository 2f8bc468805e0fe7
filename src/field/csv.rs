//! Tables of text: one row a time (or a site), cells separated by commas, tabs, semicolons or
//! blanks, `#` before a comment, an empty cell or `nan` for a gap.

use csv::ByteRecord;

use super::coordinates::{Coordinates, Listed, Uneven};
use super::file_bytes::FileBytes;
use super::labelled::quantity;
use super::names::{self, row_unit};
use super::open::{Contents, FileSource};
use super::options::{Header, TimeColumn};
use super::preamble::{Preamble, SETTING_CELLS, length, unit_of};
use super::rows::{RowReader, line_of_row};
use super::storage::Storage;
use super::{Layout, Note, header};
use crate::error::{CoordinateKind, Error, InputFault, Result};
use crate::measure::{Time, size, symbol};
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
    let preamble = preamble(source, &mut rows, &mut record)?;
    let layout = source.layout();
    let header = match &preamble.names {
        Some(names) => Some(header::of_line(names.clone(), &rows, &record)),
        None if stated == Header::Detect => header::of_comments(
            &source.bytes,
            record.len(),
            layout,
            &source.options.time_column,
        ),
        None => None,
    };
    let width = header.as_ref().map_or(record.len(), ByteRecord::len);
    let axis_column = axis_column(source, header.as_ref(), &preamble, width)?;
    let n_columns = width - usize::from(axis_column.is_some());
    if n_columns == 0 {
        return Err(fault(InputFault::NoColumns));
    }
    let mut table = Table::new(source, width, axis_column, preamble)?;
    if rows.has_decimal_commas() {
        table.notes.push(Note::DecimalCommas);
    }
    loop {
        table.push(&record).map_err(fault)?;
        if !rows.next(&mut record).map_err(fault)? {
            break;
        }
    }
    table.leave_out(header.as_ref());
    let is_known = table.axis_column.is_some() || table.preamble.step().is_some();
    if !is_known && source.options.time_column == TimeColumn::Detect {
        table.judge_first_column().map_err(fault)?;
    }
    table.contents(header.as_ref())
}

/// What stands before the first row of numbers, which becomes `record`.
fn preamble(
    source: &FileSource,
    rows: &mut RowReader,
    record: &mut ByteRecord,
) -> Result<Preamble> {
    let fault = |fault| source.fault(fault);
    let stated = source.options.header;
    if stated == Header::Detect && Preamble::is_beside(record) {
        rows.leave_out(SETTING_CELLS, record);
        return Ok(Preamble::beside(&source.bytes));
    }
    let mut first_rows = Vec::new();
    let mut is_one = header::is_header(stated, record);
    while is_one {
        first_rows.push(record.clone());
        if !rows.next(record).map_err(fault)? {
            return Err(fault(InputFault::NoRows));
        }
        is_one = stated == Header::Detect && Preamble::may_continue(&first_rows, record);
    }
    if first_rows.is_empty() {
        return Ok(Preamble::default());
    }
    let cell = |row: &ByteRecord| InputFault::Cell {
        line: line_of_row(&source.bytes, starts_at(row)),
        column: 1,
        found: excerpt(&row[0]),
    };
    let places: Vec<InputFault> = first_rows.iter().map(cell).collect();
    Preamble::of(first_rows, record).map_err(|row| match places.into_iter().nth(row) {
        Some(place) => fault(place),
        None => fault(InputFault::NoRows),
    })
}

struct Table<'a> {
    source: &'a FileSource<'a>,
    width: usize,
    preamble: Preamble,
    /// The column of the rows' coordinates: times, or with the layout site-time positions.
    axis_column: Option<usize>,
    /// Columns of samples.
    columns: Vec<usize>,
    /// Which of all columns hold anything.
    is_filled: Vec<bool>,
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
        axis_column: Option<usize>,
        preamble: Preamble,
    ) -> Result<Table<'a>> {
        let columns: Vec<usize> = (0..width).filter(|&c| axis_column != Some(c)).collect();
        let n_columns = columns.len();
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
            notes: match preamble.rows {
                0 => Vec::new(),
                lines => vec![Note::Preamble { lines }],
            },
            preamble,
            axis_column,
            columns,
            is_filled: vec![false; width],
            values,
            places: Vec::new(),
            lines: Vec::new(),
            rounding: f64::INFINITY,
        })
    }

    fn push(&mut self, record: &ByteRecord) -> Result<(), InputFault> {
        // A separator behind the last cell of a row ends no cell.
        let is_longer = record.len() > self.width && length(record, |_| false) > self.width;
        if record.len() < self.width || is_longer {
            return Err(InputFault::Ragged {
                line: self.line(starts_at(record)),
                expected: self.width,
                found: record.len(),
            });
        }
        for (column, cell) in record.iter().take(self.width).enumerate() {
            let value = number(cell);
            self.is_filled[column] |= !cell.trim_ascii().is_empty();
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
    fn judge_first_column(&mut self) -> Result<(), InputFault> {
        // Two rows always rise evenly or fall, and a few rise by chance.
        const EVENLY: usize = 3;
        const UNEVENLY: usize = 8;
        let width = self.columns.len();
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
        (self.places, self.axis_column) = (first, Some(self.columns[0]));
        self.remove(|place| place == 0);
        Ok(())
    }

    /// Leaves out columns without a name that hold nothing behind the last that does, and columns that count
    /// the rows beside those of known times.
    fn leave_out(&mut self, header: Option<&ByteRecord>) {
        let name = |column: usize| {
            let name = header.and_then(|header| header.get(column));
            name.map_or(String::new(), excerpt)
        };
        let last = self
            .is_filled
            .iter()
            .rposition(|is_filled| *is_filled)
            .unwrap_or(0);
        let is_blank = |column: &usize| *column > last && name(*column).is_empty();
        let blank: Vec<usize> = self.columns.iter().copied().filter(is_blank).collect();
        let has_times = self.axis_column.is_some() || self.preamble.step().is_some();
        let width = self.columns.len();
        let counts = |place: usize| {
            let mut values = self.values.iter().skip(place).step_by(width).copied();
            let first = values.next().unwrap_or(f64::NAN);
            let n_rows = self.values.len() / width;
            n_rows > 2
                && first.fract() == 0.0
                && values.zip(1..).all(|(v, i)| v == first + f64::from(i))
        };
        let is_count = |&(place, column): &(usize, &usize)| {
            let unit = self.preamble.units.get(*column).map_or("", String::as_str);
            let is_named =
                names::counts_rows(&name(*column)) || unit.eq_ignore_ascii_case("sequence");
            has_times && is_named && counts(place)
        };
        let counting = self.columns.iter().enumerate().filter(is_count);
        let counting: Vec<usize> = counting.map(|(_, column)| *column).collect();
        let notes = counting.iter().map(|&column| Note::CountedRows {
            column: name(column),
        });
        self.notes.extend(notes.collect::<Vec<_>>());
        let columns = self.columns.clone();
        let out = |place: usize| {
            [&blank, &counting]
                .iter()
                .any(|all| all.contains(&columns[place]))
        };
        // What is left of a table of no other columns is its samples.
        if blank.len() + counting.len() < width {
            self.remove(out);
        }
    }

    /// Removes columns of samples by their place among them.
    fn remove(&mut self, is_out: impl Fn(usize) -> bool) {
        let width = self.columns.len();
        let is_out: Vec<bool> = (0..width).map(is_out).collect();
        if !is_out.contains(&true) {
            return;
        }
        let mut at = 0;
        self.values.retain(|_| {
            at += 1;
            !is_out[(at - 1) % width]
        });
        let mut place = 0;
        self.columns.retain(|_| {
            place += 1;
            !is_out[place - 1]
        });
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
        let fit = |axis, values: &[f64], rounding, has_step: bool| {
            let rules = (!has_step).then(|| source.options.evenness(axis));
            Coordinates::listed(axis, values, (rounding, None), rules)
        };
        let by_setting = rows_are_times.then(|| self.by_setting()).flatten();
        let rows = match by_setting.filter(|_| !has_step) {
            Some(even) => Ok(Listed {
                even,
                ..Listed::default()
            }),
            None => fit(row_axis, &self.places, self.rounding, has_step),
        };
        let rows = rows.map_err(|uneven| {
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
        let n_columns = self.columns.len();
        let n_rows = self.values.len() / n_columns;
        // Numbers above units are those of channels.
        let is_numbered = !self.preamble.units.is_empty();
        let columns = |axis: &'static str, has_step| {
            let labels = header
                .filter(|_| !is_numbered)
                .and_then(|header| header::labels(header, &self.columns));
            let (values, rounding) = labels.unwrap_or_default();
            fit(axis, &values, rounding, has_step)
                .map_err(|uneven| source.fault(uneven.fault(axis)))
        };
        let unit = header.zip(self.axis_column).and_then(|(header, column)| {
            row_unit(&excerpt(&header[column]), source.layout()).flatten()
        });
        let unit = unit.or_else(|| self.time_unit(header).filter(|_| rows_are_times));
        let rows = Listed {
            even: Coordinates { unit, ..rows.even },
            ..rows
        };
        let (n_times, n_sites, time, space) = if rows_are_times {
            let space = columns("space", stated.dx.is_some())?;
            (n_rows, n_columns, rows, space)
        } else {
            let time = columns("time", stated.dt.is_some())?;
            (n_columns, n_rows, time, rows)
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
        let name = |&column: &usize| header.and_then(|header| header.get(column)).map(excerpt);
        let channels = self
            .columns
            .iter()
            .filter(|_| rows_are_times)
            .filter_map(name);
        let channels: Vec<String> = channels.collect();
        let unit = rows_are_times.then(|| self.unit(&channels)).flatten();
        let storage = Storage::from_values(self.values, n_columns, rows_are_times);
        Ok(Contents {
            time: time.even,
            space: space.even,
            resampling: [time.resampling, space.resampling],
            quantity: quantity("", None, unit.as_deref()),
            unit,
            channels,
            notes: self.notes,
            ..Contents::of(storage, [n_times, n_sites])
        })
    }
}

impl Table<'_> {
    /// Times by the step that the preamble states, if those of the rows are none or agree.
    fn by_setting(&self) -> Option<Coordinates> {
        let step = self.preamble.step()?;
        let unit = |column: Option<usize>| {
            column
                .and_then(|column| self.preamble.units.get(column))
                .filter(|unit| !unit.is_empty())
        };
        let (Some(&first), Some(&last)) = (self.places.first(), self.places.last()) else {
            return Some(Coordinates {
                origin: self.preamble.origin(),
                step: Some(step),
                unit: None,
            });
        };
        // The times may be in another unit, which their column states.
        let own = unit(self.axis_column).map(String::as_str);
        let units = [own, self.preamble.time_unit()];
        let [own, of_step] = units.map(|unit| unit.and_then(size::<Time>));
        let step = match (own, of_step) {
            (Some(own), Some(of_step)) => step * of_step / own,
            _ => step,
        };
        let places = self.places.iter().zip(0u32..);
        let distance = |(place, i): (&f64, u32)| (place - first - f64::from(i) * step).abs();
        let farthest = places.map(distance).fold(0.0, f64::max);
        let is_it = farthest <= self.rounding + 1e-6 * (last - first).abs();
        is_it.then_some(Coordinates {
            origin: Some(first),
            step: Some(step),
            unit: None,
        })
    }

    /// The unit of the times in a row of units, or else in the preamble.
    fn time_unit(&self, header: Option<&ByteRecord>) -> Option<String> {
        let own = self.axis_column.and_then(|column| {
            let named = header.and_then(|header| names::table_time(&excerpt(&header[column])));
            let unit = self
                .preamble
                .units
                .get(column)
                .filter(|unit| !unit.is_empty());
            named.flatten().or(unit.cloned())
        });
        let is_stated = self.axis_column.is_some() || self.preamble.step().is_some();
        let of_preamble = self.preamble.time_unit().map(str::to_owned);
        own.or(of_preamble.filter(|_| is_stated))
    }

    /// The unit that all channels have, by the row of units, the preamble or their names.
    fn unit(&mut self, channels: &[String]) -> Option<String> {
        let of_column = |(place, column): (usize, &usize)| {
            let in_name = channels.get(place).and_then(|name| {
                let open = name.rfind(['(', '['])?;
                Some(unit_of(names::enclosed(&name[open..])?))
            });
            let own = self
                .preamble
                .units
                .get(*column)
                .filter(|unit| !unit.is_empty());
            let settings = &self.preamble.channel_units;
            let of_preamble = settings
                .get(place)
                .or(settings.first().filter(|_| settings.len() == 1));
            own.cloned().or(in_name).or(of_preamble.cloned())
        };
        let units: Vec<Option<String>> = self.columns.iter().enumerate().map(of_column).collect();
        let first = units.first()?.clone();
        if units.iter().all(|unit| *unit == first) {
            return first;
        }
        let units = units.into_iter().map(|unit| unit.unwrap_or("none".into()));
        let mut units: Vec<String> = units.collect();
        units.sort();
        units.dedup();
        self.notes.push(Note::Remark {
            text: format!(
                "the columns have different units, {}; their numbers are read as they are",
                units.join(" and ")
            ),
        });
        None
    }
}

fn axis_column(
    source: &FileSource,
    header: Option<&ByteRecord>,
    preamble: &Preamble,
    width: usize,
) -> Result<Option<usize>> {
    let asked = &source.options.time_column;
    let stated = matches!(asked, TimeColumn::Index(_) | TimeColumn::Name(_));
    let layout = source.layout();
    if stated && layout == Layout::SiteTime {
        let expected = "a table whose rows are times";
        return Err(Error::request(
            "time-column",
            expected,
            "the layout site-time",
        ));
    }
    let names: Vec<String> = match header {
        Some(header) => header.iter().map(excerpt).collect(),
        None => (0..width).map(|column| column.to_string()).collect(),
    };
    let (column, asked) = match asked {
        TimeColumn::None => return Ok(None),
        TimeColumn::Detect => {
            let is_named = |name: &String| match layout {
                Layout::TimeSite => names::table_time(name).is_some(),
                Layout::SiteTime => row_unit(name, layout).is_some(),
            };
            let named = names
                .iter()
                .position(|name| header.is_some() && is_named(name));
            let in_time = |unit: &String| symbol::<Time>(unit).is_some();
            let by_unit = || {
                preamble
                    .units
                    .iter()
                    .position(in_time)
                    .filter(|&c| c < width)
            };
            return Ok(named.or_else(|| by_unit().filter(|_| layout == Layout::TimeSite)));
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

pub(super) fn excerpt(cell: &[u8]) -> String {
    let cell = &cell[..cell.len().min(160)];
    let text = match str::from_utf8(cell) {
        // Old instruments write units in Latin-1.
        Err(fault) if fault.error_len().is_some() => {
            cell.iter().map(|&byte| char::from(byte)).collect()
        }
        _ => String::from_utf8_lossy(cell),
    };
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
