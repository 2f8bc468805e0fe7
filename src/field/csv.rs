//! Tables of text: one row a time (or a site), cells separated by commas, tabs, semicolons or
//! blanks, `#` before a comment, an empty cell or `nan` for a gap.

use std::collections::HashSet;

use csv::ByteRecord;

use super::beside::{Given, Listing};
use super::coordinates::Coordinates;
use super::file_bytes::FileBytes;
use super::labelled::counted;
use super::meaning::{Meaning, counts_rows, enclosed, is_of_column, known_as, quantity, with_unit};
use super::open::{Contents, FileSource};
use super::options::{Header, TimeColumn};
use super::preamble::{Preamble, SETTING_CELLS, length, unit_of};
use super::rows::{RowReader, line_of_row};
use super::stamp::Stamp;
use super::storage::{Storage, by_rows};
use super::{Field, Layout, Note, header};
use crate::error::{Error, Fault, InputFault, Result, UNFINISHED, uneven_advice};
use crate::measure::{self, Time, digits, symbol};
use crate::system::memory::try_with_capacity;

/// A table, with the coordinates that its header and its first column state.
pub(super) fn read(source: &FileSource) -> Result<Contents> {
    let mut rows = RowReader::new(source)?;
    let mut record = ByteRecord::new();
    if !rows.next(&mut record)? {
        return Err(no_rows().into());
    }
    let options = source.options;
    let mut preamble = preamble(source, &mut rows, &mut record)?;
    let header = match preamble.names.take() {
        Some(names) => Some(header::of_line(names, &rows, &record)),
        None if options.header == Header::Detect => {
            let (layout, asked) = (source.layout(), &options.time_column);
            header::of_comments(&source.bytes, record.len(), layout, asked)
        }
        None => None,
    };
    let width = header.as_ref().map_or(record.len(), ByteRecord::len);
    let names = header.iter().flat_map(|header| header.iter().map(excerpt));
    let mut names: Vec<String> = names.collect();
    let has_names = !names.is_empty();
    names.resize(width, String::new());
    let mut notes = Vec::new();
    if preamble.rows > 0 {
        let rows = measure::counted(preamble.rows, "row");
        let text = format!("read as settings, not as names or samples: the first {rows}");
        notes.push(Note::told("preamble", text));
    }
    let mut table = Table {
        source,
        rows_are_times: source.layout() == Layout::TimeSite,
        clocks: Vec::new(),
        columns: Vec::new(),
        is_filled: vec![false; width],
        values: Vec::new(),
        lines: Vec::new(),
        rounding: f64::INFINITY,
        notes,
        preamble,
        has_names,
        names,
    };
    table.take_columns(&record)?;
    if rows.has_decimal_commas() {
        let text = "commas in the numbers are decimal signs";
        table.notes.push(Note::told("decimal-commas", text));
    }
    table.push(&record)?;
    while rows.next(&mut record)? {
        table.push(&record)?;
    }
    table.contents()
}

/// What stands before the first row of numbers, which becomes `record`.
fn preamble(
    source: &FileSource,
    rows: &mut RowReader,
    record: &mut ByteRecord,
) -> Result<Preamble, Fault> {
    let stated = source.options.header;
    if stated == Header::Detect && Preamble::is_beside(record) {
        rows.leave_out(SETTING_CELLS, record);
        return Ok(Preamble::beside(&source.bytes));
    }
    let mut first_rows = Vec::new();
    let mut is_one = header::is_header(stated, record);
    while is_one {
        first_rows.push(record.clone());
        if !rows.next(record)? {
            return Err(no_rows());
        }
        is_one = stated == Header::Detect && Preamble::may_continue(&first_rows, record);
    }
    let preamble = Preamble::of_comments(&source.bytes);
    if first_rows.is_empty() {
        return Ok(preamble);
    }
    preamble.with_rows(&first_rows, record).map_err(|row| {
        let row = &first_rows[row.min(first_rows.len() - 1)];
        no_number(line_of_row(&source.bytes, starts_at(row)), 1, &row[0])
    })
}

fn no_rows() -> Fault {
    Fault::expected("rows of numbers", "only a header", UNFINISHED)
}

/// The fault of a cell; lines and columns count from 1.
fn no_number(line: u64, column: usize, cell: &[u8]) -> Fault {
    let advice = match line {
        1 => "state `--header present` if it is a header; an empty cell is a gap",
        _ => "write numbers with a decimal point; an empty cell or `nan` is a gap",
    };
    let found = excerpt(cell);
    let said = format!("line {line}, column {column}: expected a number, found {found:?}");
    Fault::new(said, advice)
}

/// A column of coordinates of the rows.
#[derive(Debug, Default)]
struct Clock {
    column: usize,
    /// Numbers, or nanoseconds from the first one on.
    values: Vec<f64>,
    /// What the last printed digit counts.
    rounding: f64,
    /// The first date or time of day, and its cell.
    first: Option<(Stamp, String)>,
}

impl Clock {
    fn new(column: usize) -> Clock {
        Clock {
            column,
            rounding: f64::INFINITY,
            ..Clock::default()
        }
    }

    /// Takes a number, or a date or time of day; whether a cell is one.
    fn push(&mut self, cell: &[u8]) -> bool {
        if let Some(value) = number(cell).filter(|_| self.first.is_none()) {
            self.rounding = self.rounding.min(printed_unit(cell));
            self.values.push(value);
            return value.is_finite();
        }
        let may_be_dated = self.values.is_empty() || self.first.is_some();
        let Some(stamp) = Stamp::parse(cell).filter(|_| may_be_dated) else {
            return false;
        };
        let (first, _) = self.first.get_or_insert_with(|| (stamp, excerpt(cell)));
        let apart = (stamp.nanoseconds - first.nanoseconds) as f64;
        self.rounding = self.rounding.min(stamp.rounding);
        self.values.push(apart);
        (first.has_date, first.has_time) == (stamp.has_date, stamp.has_time)
    }
}

struct Table<'a> {
    source: &'a FileSource<'a>,
    rows_are_times: bool,
    preamble: Preamble,
    /// Names of all columns; empty ones without a header.
    names: Vec<String>,
    has_names: bool,
    /// The columns of the rows' coordinates: times, or with the layout site-time positions.
    clocks: Vec<Clock>,
    /// Columns of samples.
    columns: Vec<usize>,
    /// Which of all columns hold anything.
    is_filled: Vec<bool>,
    values: Vec<f64>,
    /// For each row, the line at which the search for it began.
    lines: Vec<u64>,
    /// What the last printed digit of the first column counts.
    rounding: f64,
    notes: Vec<Note>,
}

impl Table<'_> {
    /// Decides which columns are clocks and which samples, and reserves the samples.
    fn take_columns(&mut self, first: &ByteRecord) -> Result<()> {
        let (source, width) = (self.source, self.names.len());
        let clocks = self.axis_columns(first)?;
        self.clocks = clocks.into_iter().map(Clock::new).collect();
        let is_clock = |c: &usize| self.clocks.iter().any(|clock| clock.column == *c);
        self.columns = (0..width).filter(|c| !is_clock(c)).collect();
        if self.columns.is_empty() {
            let advice = "state `--time-column none` if the one column holds samples";
            return Err(
                Fault::expected("a column of samples beside the times", "none", advice).into(),
            );
        }
        let most = count_lines(&source.bytes).saturating_mul(self.columns.len());
        let most = most.min(source.bytes.len() + 1);
        source.allow("the table", most as u64 * size_of::<f64>() as u64)?;
        let reserved = try_with_capacity(most).map_err(std::io::Error::from);
        self.values = reserved.map_err(Error::read("hold the table in", source.path))?;
        Ok(())
    }

    /// The columns of coordinates: that which is stated, else those that names, units or dates say.
    fn axis_columns(&self, first: &ByteRecord) -> Result<Vec<usize>> {
        let asked = &self.source.options.time_column;
        let width = self.names.len();
        let is_stated = matches!(asked, TimeColumn::Index(_) | TimeColumn::Name(_));
        if is_stated && !self.rows_are_times {
            let expected = "a table whose rows are times";
            let found = "the layout site-time";
            return Err(Error::request("time-column", expected, found));
        }
        let (column, asked) = match asked {
            TimeColumn::None => return Ok(Vec::new()),
            TimeColumn::Detect => return Ok(self.detected_columns(first)),
            TimeColumn::Index(index) => (Some(*index).filter(|&i| i < width), index.to_string()),
            TimeColumn::Name(name) => {
                let mut names = self.names.iter().filter(|_| self.has_names);
                (
                    names.position(|cell| cell == name.trim()),
                    format!("{name:?}"),
                )
            }
        };
        let columns = match self.has_names {
            true => self.names.clone(),
            false => (0..width).map(|column| column.to_string()).collect(),
        };
        let no_such = || {
            let found = format!("the columns {}", columns.join(", "));
            let advice = "name one of the columns, or count them from 0";
            Fault::expected(format!("the time column {asked}"), found, advice)
        };
        Ok(vec![column.ok_or_else(no_such)?])
    }

    /// Those that names, units or dates in the first row say.
    fn detected_columns(&self, first: &ByteRecord) -> Vec<usize> {
        let columns = |is_it: &dyn Fn(usize) -> bool| -> Vec<usize> {
            (0..self.names.len()).filter(|c| is_it(*c)).collect()
        };
        let meaning = row_meaning(self.source.layout());
        let bases: HashSet<&str> = self.names.iter().map(|name| with_unit(name).0).collect();
        let named = columns(&|c| {
            let name = &self.names[c];
            known_as(name, meaning).is_some() || is_of_column(name, meaning, &bases)
        });
        if !named.is_empty() || !self.rows_are_times {
            return named;
        }
        let is_time = |unit: &String| symbol::<Time>(unit).is_some();
        let mut by_unit = columns(&|c| self.preamble.unit(c).is_some_and(is_time));
        by_unit.truncate(1);
        let is_date = |cell: &[u8]| number(cell).is_none() && Stamp::parse(cell).is_some();
        match by_unit.is_empty() {
            true => columns(&|c| first.get(c).is_some_and(is_date)),
            false => by_unit,
        }
    }

    fn push(&mut self, record: &ByteRecord) -> Result<(), Fault> {
        let width = self.names.len();
        // A separator behind the last cell of a row ends no cell.
        let is_longer = record.len() > width && length(record, |_| false) > width;
        if record.len() < width || is_longer {
            let (line, found) = (self.line(starts_at(record)), record.len());
            let advice = "give every row the same number of cells; an empty cell is a gap";
            let said = format!("line {line}: expected {width} cells, found {found}");
            return Err(Fault::new(said, advice));
        }
        if let Some(cell) = record.get(0) {
            self.rounding = self.rounding.min(printed_unit(cell));
        }
        self.lines.push(starts_at(record));
        for (column, cell) in record.iter().take(width).enumerate() {
            self.is_filled[column] |= !cell.trim_ascii().is_empty();
            let clock = self.clocks.iter_mut().find(|clock| clock.column == column);
            let is_read = match (clock, number(cell)) {
                (Some(clock), _) => clock.push(cell),
                (None, value) => {
                    self.values.extend(value);
                    value.is_some()
                }
            };
            if !is_read {
                return Err(no_number(self.line(starts_at(record)), column + 1, cell));
            }
        }
        Ok(())
    }

    /// What a column is called in sentences.
    fn label(&self, column: usize) -> String {
        match self.names[column].as_str() {
            "" => format!("column {}", column + 1),
            name => name.to_owned(),
        }
    }

    /// The line of the row whose search began at line `from`.
    fn line(&self, from: u64) -> u64 {
        line_of_row(&self.source.bytes, from)
    }

    /// The samples in a column, by its place among those.
    fn column(&self, place: usize) -> Vec<f64> {
        let values = self.values.iter().skip(place);
        values.step_by(self.columns.len()).copied().collect()
    }

    /// Decides whether the first column holds coordinates of the rows: it does if it rises evenly
    /// and no other does.
    ///
    /// # Errors
    /// If it may hold either coordinates or samples: other columns rise evenly too, or it rises
    /// unevenly, or never falls as a coarse clock does.
    fn judge_first_column(&mut self) -> Result<(), Fault> {
        // Two rows always rise evenly or fall, and a few rise by chance.
        const EVENLY: usize = 3;
        const UNEVENLY: usize = 8;
        let (width, n_rows) = (self.columns.len(), self.lines.len());
        if width < 2 || n_rows < EVENLY {
            return Ok(());
        }
        let first = self.column(0);
        let layout = self.source.layout();
        let (what, advice) = match layout {
            Layout::TimeSite => (
                "times",
                "state `--time-column 0` if it holds times, `--time-column none` if it holds samples",
            ),
            Layout::SiteTime => (
                "positions",
                "name positions `x` in a header; state `--time-column none` for samples",
            ),
        };
        let doubt = |reason: &str| {
            let expected = format!("a first column of samples or of {what}");
            let found = format!("one that {reason}");
            Err(Fault::expected(expected, found, advice))
        };
        let rises = |values: &[f64]| values.is_sorted() && values.first() < values.last();
        let Ok(even) = Coordinates::fit(&first, self.rounding) else {
            if n_rows < UNEVENLY || !rises(&first) {
                return Ok(());
            }
            return match first.is_sorted_by(|a, b| a < b) {
                true => doubt("rises unevenly"),
                false if (1..width).any(|j| rises(&self.column(j))) => Ok(()),
                false => doubt("rises with equal values between, as a coarse clock does"),
            };
        };
        // Another column that rises about evenly might be a coordinate as well.
        let is_even = |j: usize| Coordinates::fit(&self.column(j), f64::INFINITY).is_ok();
        if (1..width).any(is_even) {
            return doubt("rises evenly, and so does another");
        }
        let step = digits(even.step.unwrap_or(1.0));
        let text = format!("the first column holds the {what}, since it rises evenly by {step}");
        let note = Note::told("first-column", text);
        let advice = "where it holds samples, state `--time-column none`";
        self.notes.push(note.advising(advice));
        self.clocks.push(Clock {
            column: self.columns[0],
            values: first,
            rounding: self.rounding,
            first: None,
        });
        self.remove(|place| place == 0);
        Ok(())
    }

    /// Leaves out columns without a name that hold nothing behind the last that does, and columns that count
    /// the rows beside those of known times.
    fn leave_out(&mut self, has_times: bool) {
        let last = self.is_filled.iter().rposition(|is_filled| *is_filled);
        let mut out = vec![false; self.columns.len()];
        for (place, &column) in self.columns.iter().enumerate() {
            let name = &self.names[column];
            let unit = self.preamble.unit(column).map_or("", String::as_str);
            let is_named = counts_rows(name) || unit.eq_ignore_ascii_case("sequence");
            let is_counted = has_times && is_named && {
                let values = self.column(place);
                let counts = |(i, v): (u32, &f64)| *v == values[0] + f64::from(i);
                values.len() > 2 && values[0].fract() == 0.0 && (0..).zip(&values).all(counts)
            };
            if is_counted {
                let text = format!("{} counts the rows and is left out", self.label(column));
                self.notes.push(Note::told("counted-rows", text));
            }
            out[place] = is_counted || Some(column) > last && name.is_empty();
        }
        // What is left of a table of no other columns is its samples.
        if out.contains(&false) {
            self.remove(|place| out[place]);
        }
    }

    /// Removes columns of samples by their place among them.
    fn remove(&mut self, is_out: impl Fn(usize) -> bool) {
        let width = self.columns.len();
        let is_kept: Vec<bool> = (0..width).map(|place| !is_out(place)).collect();
        let mut places = is_kept.iter().cycle();
        self.values.retain(|_| places.next() == Some(&true));
        let mut places = is_kept.iter();
        self.columns.retain(|_| places.next() == Some(&true));
    }

    /// The coordinates in a column, counted from the first if that is a date.
    fn listing(&self, clock: &Clock) -> Listing {
        let (name, place) = (&self.names[clock.column], self.label(clock.column));
        if let Some((stamp, cell)) = &clock.first {
            return Listing {
                place,
                values: clock.values.iter().map(|v| v / 1e9).collect(),
                rounding: clock.rounding,
                unit: Some("s".into()),
                start: stamp.has_date.then(|| cell.clone()),
                ..Listing::default()
            };
        }
        let own = self.preamble.unit(clock.column).cloned();
        let in_name = known_as(name, row_meaning(self.source.layout())).flatten();
        let unit = in_name.or(own).or(with_unit(name).1.map(str::to_owned));
        let may_count = self.rows_are_times && self.source.stated.time_unit.is_none();
        let stored = (&clock.values[..], None);
        Listing {
            place,
            ..counted(stored, [1.0, 0.0], clock.rounding, unit, may_count)
        }
    }

    fn contents(mut self) -> Result<Contents> {
        let source = self.source;
        let (stated, options) = (&source.stated, source.options);
        let statements = &self.preamble.statements;
        let time = statements.time(stated, options)?;
        let space = statements.space(stated, options)?;
        let has_times = !self.clocks.is_empty() || time.has_step();
        self.leave_out(has_times);
        if !has_times && options.time_column == TimeColumn::Detect {
            self.judge_first_column()?;
        }
        let clocks = self.clocks.iter().map(|clock| self.listing(clock));
        let rows = Listing::best(clocks.collect())?;
        let rows = rows.map(Given::Listed);
        let (n_rows, n_columns) = (self.lines.len(), self.columns.len());
        let columns = self.labels().map(Given::Listed);
        let rows_are_times = self.rows_are_times;
        let (times, sites) = by_rows(rows_are_times, rows, columns);
        let (n_times, n_sites) = by_rows(rows_are_times, n_rows, n_columns);
        let time = time.axis(times, &mut self.notes);
        let time = time.map_err(|uneven| match uneven {
            InputFault::UnevenAxis {
                index,
                expected,
                found,
                ..
            } if rows_are_times => {
                let line = self.line(self.lines[index]);
                let said =
                    format!("line {line}: expected a time step of {expected}, found {found}");
                Fault::new(said, uneven_advice(found)).into()
            }
            other => other,
        })?;
        let space = space.axis(sites, &mut self.notes)?;
        if stated.layout.is_none() && self.clocks.is_empty() {
            self.notes.extend(Note::on_shape(n_times, n_sites));
        }
        // Columns are sites where rows are times.
        let name = |&column: &usize| self.names[column].clone();
        let is_named = rows_are_times && self.has_names;
        let channels = self.columns.iter().filter(|_| is_named).map(name);
        let channels: Vec<String> = channels.collect();
        let unit = rows_are_times.then(|| self.unit()).flatten();
        let quantity = quantity("", None, unit.as_deref());
        let storage = Storage::from_values(self.values, n_columns, rows_are_times);
        let field = Field {
            unit,
            channels,
            notes: self.notes,
            ..Field::of_storage(storage, (n_times, n_sites))
        };
        Ok(Contents {
            field,
            time,
            space,
            quantity,
        })
    }

    /// The names of the columns of samples as numbers, if all are; above units they number channels.
    fn labels(&self) -> Option<Listing> {
        let cell = |&column: &usize| self.names[column].as_bytes();
        let cells = || self.columns.iter().map(cell);
        let value = |cell: &[u8]| number(cell).filter(|value| value.is_finite());
        let values: Option<Vec<f64>> = cells().map(value).collect();
        Some(Listing {
            place: "the header".into(),
            values: values.filter(|_| self.preamble.units.is_empty())?,
            rounding: cells().map(printed_unit).fold(f64::INFINITY, f64::min),
            ..Listing::default()
        })
    }

    /// The unit that all channels have, by the row of units, the preamble or their names.
    fn unit(&mut self) -> Option<String> {
        let of_column = |(place, &column): (usize, &usize)| {
            let name = &self.names[column];
            let in_name = || Some(unit_of(enclosed(&name[name.rfind(['(', '['])?..])?));
            let own = self.preamble.unit(column);
            let settings = &self.preamble.channel_units;
            let place = if settings.len() == 1 { 0 } else { place };
            own.cloned()
                .or_else(in_name)
                .or(settings.get(place).cloned())
        };
        let units: Vec<Option<String>> = self.columns.iter().enumerate().map(of_column).collect();
        let first = units.first()?.clone();
        if units.iter().all(|unit| *unit == first) {
            return first;
        }
        let units = units.into_iter().map(|unit| unit.unwrap_or("none".into()));
        let mut units: Vec<String> = units.collect();
        units.sort_unstable();
        units.dedup();
        let text = format!("the columns have different units, {}", units.join(" and "));
        let text = format!("{text}; their numbers are read as they are");
        self.notes.push(Note::doubt("remark", text));
        None
    }
}

/// What coordinates of rows are.
pub(super) fn row_meaning(layout: Layout) -> Meaning {
    match layout {
        Layout::TimeSite => Meaning::Time,
        Layout::SiteTime => Meaning::Position,
    }
}

pub(super) fn number(cell: &[u8]) -> Option<f64> {
    match cell.trim_ascii() {
        [] => Some(f64::NAN),
        text => str::from_utf8(text).ok()?.parse().ok(),
    }
}

/// What the last digit of a printed number counts: `1e-4` for `0.1250` and for `125.0e-3`.
pub(super) fn printed_unit(cell: &[u8]) -> f64 {
    let is_exponent = |byte: &u8| matches!(byte, b'e' | b'E');
    let mut parts = cell.trim_ascii().splitn(2, is_exponent);
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
