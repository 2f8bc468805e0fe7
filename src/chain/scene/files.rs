//! Files that a scene names, put into it as values: a run then carries them.

use std::path::{Path, PathBuf};

use toml::{Table, Value};

use super::Units;
use super::check::units;
use super::places::Places;
use crate::error::{Error, Fault, KeyPlace, Result, listed};
use crate::field::{
    Field, OpenOptions, check_written, is_netcdf, is_run_archive, read_members, regular_file,
};
use crate::measure::{self, Dimension, Force, Length, Speed, Time, size};
use crate::unit::split;

/// Bytes and rows of a table that are read at most.
const MOST_BYTES: u64 = 16 << 20;
const MOST_ROWS: usize = 100_000;

/// A file named by a key.
struct Named<'a> {
    key: &'static str,
    path: PathBuf,
    places: &'a Places,
    is_si: bool,
}

/// Shape and values of an array.
type Samples = (Vec<u64>, Vec<f64>);

/// A column of a table.
struct Column {
    name: String,
    unit: String,
    values: Vec<f64>,
}

/// The arrays of a run that its last state is of.
const STATE: [&str; 4] = [
    "displacement",
    "velocity",
    "resonator_displacement",
    "resonator_velocity",
];

/// Keys that name files, and those of the values that they hold.
const KEYS: [(&str, &[&str]); 3] = [
    ("drive_file", &["drive_times", "drive_values"]),
    (
        "state",
        &[
            "displacements",
            "velocities",
            "resonator_displacements",
            "resonator_velocities",
        ],
    ),
    ("law_file", &["law"]),
];

/// Refuses keys that name files; false, since none were read.
pub(super) fn refuse(table: &Table, places: &Places) -> Result<bool> {
    match KEYS.iter().find(|(key, _)| table.contains_key(*key)) {
        Some((key, own)) => {
            let expected = format!("{}: a run carries the values of files", listed(own));
            Err(places.fault(key, expected, "the name of a file"))
        }
        None => Ok(false),
    }
}

/// Puts what files hold in place of the keys that name them; whether there were any.
pub(super) fn read_in(table: &mut Table, places: &mut Places) -> Result<bool> {
    let is_si = units(table) == Units::Si;
    let mut any = false;
    for (key, own) in KEYS {
        let Some(path) = table.get(key).and_then(Value::as_str) else {
            continue;
        };
        let file = Named {
            key,
            path: places.beside(key, path),
            places,
            is_si,
        };
        if !file.path.exists() {
            let expected = "a file that is there; a relative path starts at the scene's folder";
            return Err(file.fault(expected, "nothing"));
        }
        let values: Vec<Value> = match key {
            "state" => file.state()?.into_iter().map(numbers).collect(),
            "law_file" => vec![Value::String(file.law()?)],
            _ => {
                let drive = table.get("drive").and_then(Value::as_str);
                file.drive(drive)?.map(numbers).into()
            }
        };
        table.remove(key);
        for (own, value) in own.iter().zip(values) {
            table.insert((*own).to_owned(), value);
            places.stands_for(own, key);
        }
        any = true;
    }
    Ok(any)
}

fn numbers(values: Vec<f64>) -> Value {
    Value::Array(values.into_iter().map(Value::Float).collect())
}

impl Named<'_> {
    fn fault(&self, expected: impl Into<String>, found: impl Into<String>) -> Error {
        let found = format!("{} in {}", found.into(), self.path.display());
        self.places.fault(self.key, expected, found)
    }

    /// The values of a column in the unit of the scene.
    fn in_si<D: Dimension>(&self, column: &Column) -> Result<Vec<f64>> {
        if column.unit.is_empty() {
            return Ok(column.values.clone());
        }
        let found = format!("[{}] of {}", column.unit, column.name);
        if !self.is_si {
            let expected = "columns without units, since the scene is not in SI (`units = \"si\"`)";
            return Err(self.fault(expected, found));
        }
        let Some(factor) = size::<D>(&column.unit) else {
            return Err(self.fault(format!("a unit of {}", measure::units::<D>()), found));
        };
        Ok(column.values.iter().map(|value| factor * value).collect())
    }

    /// Times and values.
    fn drive(&self, kind: Option<&str>) -> Result<[Vec<f64>; 2]> {
        let [first, second] = self.pair("times and values", |[_, second]| second.starts('t'))?;
        let times = self.in_si::<Time>(&first)?;
        if let Some(row) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
            let found = format!("{} after {} in row {}", times[row + 1], times[row], row + 2);
            return Err(self.fault("times that rise", found));
        }
        let values = match kind {
            Some("wall" | "displacement") => self.in_si::<Length>(&second)?,
            Some("wall-velocity" | "velocity") => self.in_si::<Speed>(&second)?,
            _ => self.in_si::<Force>(&second)?,
        };
        Ok([times, values])
    }

    /// Overlaps and forces, as the text of a law.
    fn law(&self) -> Result<String> {
        let [first, second] = self.pair("overlaps and forces", |[first, _]| first.starts('f'))?;
        let overlaps = self.in_si::<Length>(&first)?;
        let forces = self.in_si::<Force>(&second)?;
        let rows = overlaps.iter().zip(&forces);
        let rows: Vec<String> = rows.map(|(d, f)| format!("{d} {f}")).collect();
        Ok(format!("table {}", rows.join(", ")))
    }

    /// Displacements and velocities, and those of resonators where the run has them.
    fn state(&self) -> Result<Vec<Vec<f64>>> {
        regular_file(&self.path)?;
        if is_run_archive(&self.path)? || is_netcdf(&self.path)? {
            return read_members(&self.path, |run| {
                let rows = STATE.iter().map(|name| run.array(name));
                let rows = rows.collect::<Result<_>>()?;
                let (scene, hashes) = (run.text("scene")?, run.text("hashes")?);
                self.last_rows(rows, scene.as_deref(), hashes.as_deref())
            });
        }
        if self.path.extension().is_some_and(|end| end == "npy") {
            let field = Field::open(&self.path, &OpenOptions::default())?;
            let (rows, columns) = (field.n_times(), field.n_sites());
            if columns != 2 {
                let found = format!("the shape ({rows}, {columns})");
                return Err(self.fault("the shape (sites, 2), displacements and velocities", found));
            }
            let mut values = vec![0.0; 2 * rows];
            field.read_time_major(0..rows, 0..2, &mut values);
            let column = |of: usize| values.iter().skip(of).step_by(2).copied().collect();
            return Ok(vec![column(0), column(1)]);
        }
        let what = "displacements and velocities";
        let [first, second] = self.pair(what, |[first, _]| first.starts('v'))?;
        Ok(vec![
            self.in_si::<Length>(&first)?,
            self.in_si::<Speed>(&second)?,
        ])
    }

    /// The last displacements and velocities of a run.
    fn last_rows(
        &self,
        arrays: Vec<Option<Samples>>,
        scene: Option<&str>,
        hashes: Option<&str>,
    ) -> Result<Vec<Vec<f64>>> {
        for (name, array) in STATE.iter().zip(&arrays) {
            let Some((_, values)) = array else { continue };
            let refused = |fault: Fault| Error::input(&self.path)(fault);
            check_written(hashes, name, values).map_err(refused)?;
        }
        let expected = "a run that recorded displacements (`record` with \"displacement\")";
        let last = |array: Option<Samples>| -> Option<Vec<f64>> {
            let (shape, values) = array?;
            let from = values.len().checked_sub(*shape.last()? as usize)?;
            Some(values[from..].to_vec())
        };
        if arrays[0].is_none() || arrays[1].is_none() {
            return Err(self.fault(expected, "none"));
        }
        let rows: Vec<Vec<f64>> = arrays.into_iter().filter_map(last).collect();
        let table = scene.and_then(|text| text.parse::<Table>().ok());
        if table.is_some_and(|table| (units(&table) == Units::Si) != self.is_si) {
            let word = |is_si: bool| if is_si { "in SI" } else { "without units" };
            let expected = format!("a run {}, as this scene is", word(self.is_si));
            return Err(self.fault(expected, format!("one {}", word(!self.is_si))));
        }
        Ok(rows)
    }

    /// The two columns of a table of text, turned round where their names say so.
    fn pair(&self, what: &str, is_turned: fn([&Column; 2]) -> bool) -> Result<[Column; 2]> {
        let columns = self.columns()?;
        let number = columns.len();
        let Ok([first, second]) = <[Column; 2]>::try_from(columns) else {
            let expected = format!("two columns, {what}");
            return Err(self.fault(expected, format!("{number} columns")));
        };
        let are_named = !(first.name.is_empty() || second.name.is_empty());
        Ok(match are_named && is_turned([&first, &second]) {
            true => [second, first],
            false => [first, second],
        })
    }

    /// The columns of a table of text.
    fn columns(&self) -> Result<Vec<Column>> {
        let length = regular_file(&self.path)?.len();
        if length > MOST_BYTES {
            let expected = format!("a table of at most {MOST_BYTES} bytes");
            return Err(self.fault(expected, length.to_string()));
        }
        let read = std::fs::read_to_string(&self.path);
        let text = read.map_err(Error::read("read", &self.path))?;
        let text = text.trim_start_matches('\u{feff}');
        let separator = [';', '\t', ','].into_iter().find(|c| text.contains(*c));
        let number = |cell: &str| -> Option<f64> {
            match separator {
                // A comma that separates no cells is that of a decimal.
                Some(',') | None => cell.parse().ok(),
                Some(_) => cell.replace(',', ".").parse().ok(),
            }
        };
        let (mut head, mut columns) = (Vec::new(), Vec::<Column>::new());
        for (line, text) in (1..).zip(text.lines()) {
            let is_comment = text.trim_start().starts_with('#');
            if text.trim().is_empty() || is_comment && !columns.is_empty() {
                continue;
            }
            let cells = cells(text, separator);
            let numbers: Vec<Option<f64>> = cells.iter().map(|cell| number(cell)).collect();
            if columns.is_empty() && (is_comment || numbers.iter().all(Option::is_none)) {
                head = cells;
                continue;
            }
            if columns.is_empty() {
                let is_head = head.len() == cells.len();
                let name = |i: usize| if is_head { head[i] } else { "" };
                columns.extend((0..cells.len()).map(|i| Column::of(name(i))));
            }
            if cells.len() != columns.len() {
                let expected = format!("{} columns in every row", columns.len());
                return Err(self.fault(expected, format!("{} in line {line}", cells.len())));
            }
            for ((column, number), cell) in columns.iter_mut().zip(numbers).zip(&cells) {
                let Some(number) = number.filter(|number| number.is_finite()) else {
                    let found = format!("{cell:?} in line {line}");
                    return Err(self.fault("a finite number", found));
                };
                column.values.push(number);
            }
            if columns[0].values.len() > MOST_ROWS {
                let expected =
                    format!("at most {MOST_ROWS} rows; keep every second or tenth of them");
                return Err(self.fault(expected, "more"));
            }
        }
        match columns.is_empty() {
            true => Err(self.fault("rows of numbers", "none")),
            false => Ok(columns),
        }
    }
}

/// The cells of a line, which may be a comment; blanks separate them where nothing else does.
fn cells(line: &str, separator: Option<char>) -> Vec<&str> {
    let line = line.trim_start_matches('#').trim();
    match separator {
        Some(separator) => line.split(separator).map(str::trim).collect(),
        None => line.split_whitespace().collect(),
    }
}

impl Column {
    /// One without values, of a name with a unit: `time [ms]`.
    fn of(text: &str) -> Column {
        let (name, unit) = split(text);
        Column {
            name: name.trim().to_owned(),
            unit: unit.to_owned(),
            values: Vec::new(),
        }
    }

    fn starts(&self, letter: char) -> bool {
        self.name.to_lowercase().starts_with(letter)
    }
}

impl Places {
    /// A path that a key holds: typed in a scene's file, it is beside that file.
    fn beside(&self, key: &str, path: &str) -> PathBuf {
        match self.of(key) {
            KeyPlace::File { path: scene, .. } => match scene.parent() {
                Some(folder) => folder.join(path),
                None => PathBuf::from(path),
            },
            _ => Path::new(path).to_owned(),
        }
    }
}
