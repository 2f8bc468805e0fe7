//! A result as data: its answer in words, facts, numbers, arrays with dimensions and units, tables, charts and maps.
//!
//! A result [describes](Describe) itself once. Everything that is shown of it is made of that by writers that know no
//! result: the lines on a terminal, `summary.json`, archives, the figure, the page, a dataset of Python.

mod chart;
mod figure;
mod map;
mod units;
mod words;

use std::borrow::Cow;

use ndarray::Array2;
use serde_json::{Value, json};

use crate::field::Note;

pub(crate) use chart::{BLACK, BLUE, GREEN, PURPLE, SKY, VERMILLION};
pub use chart::{Band, Chart, Level, Look, Mark, Marker, PALETTE, Series, Weight, around, extent};
pub use figure::{FigureLayout, PlotRow};
#[cfg(feature = "figures")]
pub(crate) use map::blocks_of;
pub use map::{Colors, Curve, Map, MapAxis, Reduction, Role, magnitudes, ordinary};
pub(crate) use map::{block_extremes, range};
pub(crate) use units::Units;
pub use words::{confidence, error_size, listed, name_of, number, percent, with_half, with_range};
pub(crate) use words::{six_digits, three_digits, with_unit};

/// A result that says what it is.
pub trait Describe {
    /// Words, numbers and arrays.
    fn describe(&self) -> Sheet<'_>;

    /// Charts and maps of the one figure of most results, made only where they are drawn.
    fn pictures(&self) -> Vec<PlotRow> {
        Vec::new()
    }

    /// All figures.
    fn figures(&self) -> Vec<FigureLayout> {
        vec![FigureLayout {
            rows: self.pictures(),
            ..FigureLayout::default()
        }]
    }
}

impl<D: Describe + ?Sized> Describe for Box<D> {
    fn describe(&self) -> Sheet<'_> {
        (**self).describe()
    }

    fn figures(&self) -> Vec<FigureLayout> {
        (**self).figures()
    }
}

/// A result as data.
#[derive(Debug, Clone, Default)]
pub struct Sheet<'a> {
    /// Name of the result: that of its schema, its arrays and its figure.
    pub name: &'static str,
    /// Version of the schema of its numbers.
    pub version: u32,
    /// Heading of figures and pages.
    pub title: String,
    /// What was computed, in one sentence.
    pub about: String,
    /// What was found, in one sentence without its subject, the data.
    pub answer: String,
    /// Whether it holds only of sites in step: of one sign, and none late.
    pub needs_sites_in_step: bool,
    pub facts: Vec<Fact>,
    pub warnings: Vec<Warning>,
    /// Beside schema, provenance, answer and warnings in `summary.json`; undefined numbers are `null`.
    pub numbers: serde_json::Map<String, Value>,
    pub variables: Vec<Variable<'a>>,
    /// Parts of the summary whose numbers and texts are attributes of a file of the variables, with what their names begin
    /// with there.
    pub attributes: &'static [(&'static str, &'static str)],
    pub tables: Vec<Table>,
    /// One row for each point, with all digits: a file of its own. Empty for none.
    pub records: Table,
    /// Below the plots of a figure.
    pub note: String,
    /// Terms with their meaning.
    pub definitions: Vec<[&'static str; 2]>,
}

/// A finding with its name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fact {
    pub name: String,
    pub text: String,
    /// Whether `--verbose` alone prints it.
    pub is_detail: bool,
    /// One number a place, for a small profile; may be empty.
    pub profile: Vec<f64>,
}

impl Fact {
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Fact {
        Fact {
            name: name.into(),
            text: text.into(),
            ..Fact::default()
        }
    }

    /// With a small profile, if there is one.
    pub(crate) fn along(self, profile: Option<Vec<f64>>) -> Fact {
        Fact {
            profile: profile.unwrap_or_default(),
            ..self
        }
    }
}

/// What the user should know, and what to do about it.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct Warning {
    /// Stable name, for programs; may be empty.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub code: &'static str,
    pub message: String,
    /// Empty if nothing can be done.
    pub advice: String,
    /// An object of those behind the message; `null` where none are stated.
    #[serde(skip_serializing_if = "Value::is_null")]
    pub numbers: Value,
}

impl Warning {
    pub fn new(message: impl Into<String>, advice: impl Into<String>) -> Warning {
        Warning {
            message: message.into(),
            advice: advice.into(),
            ..Warning::default()
        }
    }

    /// With a stable name and the numbers behind the message.
    pub(crate) fn coded(self, code: &'static str, numbers: Value) -> Warning {
        Warning {
            code,
            numbers,
            ..self
        }
    }
}

impl From<&Note> for Warning {
    /// A conclusion about the file of a field.
    fn from(note: &Note) -> Warning {
        let advice = note.advice.unwrap_or_default();
        Warning::new(note.text.clone(), advice).coded(note.code, json!({}))
    }
}

/// An array with its dimensions.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable<'a> {
    pub name: String,
    /// Name and length of each dimension, the slowest first. An array of one dimension with the name of that dimension
    /// holds its coordinates. Without dimensions it says what an array is that goes to files in blocks.
    pub dimensions: Vec<(String, usize)>,
    /// Empty for none.
    pub unit: String,
    /// What it is in words; empty for its name.
    pub about: String,
    /// Row-major.
    pub values: Cow<'a, [f64]>,
}

/// What a table says of an item; `None` for nothing.
pub(crate) type Cell<T> = fn(&T) -> Option<String>;

/// Name, unit and value of a column of items.
pub(crate) type Column<'a, T> = (&'a str, &'a str, fn(&T) -> f64);

/// Rows under named columns.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    pub title: String,
    /// Empty for names and values.
    pub head: Vec<String>,
    pub rows: Vec<Vec<String>>,
    /// Whether it is printed without `--verbose` too.
    pub is_fact: bool,
}

impl Table {
    /// Rows under named columns.
    pub fn of(
        title: impl Into<String>,
        head: &[&str],
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Table {
        Table {
            title: title.into(),
            head: head.iter().map(|name| (*name).to_owned()).collect(),
            rows: rows.into_iter().collect(),
            ..Table::default()
        }
    }

    /// A row for each item, of the columns in which any has a cell.
    pub(crate) fn of_columns<T>(title: &str, items: &[T], columns: &[(&str, Cell<T>)]) -> Table {
        let is_filled =
            |(_, cell): &&(&str, Cell<T>)| items.iter().any(|item| cell(item).is_some());
        let columns: Vec<_> = columns.iter().filter(is_filled).collect();
        let head: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
        let row = |item| {
            let cells = columns.iter().map(|(_, cell)| cell(item));
            cells
                .map(|cell| cell.unwrap_or_else(|| "-".into()))
                .collect()
        };
        Table::of(title, &head, items.iter().map(row))
    }

    /// A row for each object, of the values at these places of it (JSON pointers), under their names. Numbers have all
    /// digits; cells are empty where nothing is known.
    pub(crate) fn of_places(
        places: &[(&str, &str)],
        objects: impl Iterator<Item = Value>,
    ) -> Table {
        let cell = |object: &Value, place: &str| match object.pointer(place) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) => text.clone(),
            Some(value) => value.to_string(),
        };
        let row = |object| {
            places
                .iter()
                .map(|(_, place)| cell(&object, place))
                .collect()
        };
        let names: Vec<&str> = places.iter().map(|(name, _)| *name).collect();
        Table::of("", &names, objects.map(row))
    }

    /// Printed without `--verbose` too.
    pub fn printed(self) -> Table {
        Table {
            is_fact: true,
            ..self
        }
    }

    /// Names with their values.
    pub fn of_values(title: &str, rows: impl IntoIterator<Item = (&'static str, String)>) -> Table {
        let rows = rows.into_iter();
        Table::of(
            title,
            &[],
            rows.map(|(name, value)| vec![name.to_owned(), value]),
        )
    }
}

/// The values of an array, row-major; borrowed where they lie so.
pub(crate) fn flat(values: &Array2<f64>) -> Cow<'_, [f64]> {
    match values.as_slice() {
        Some(values) => Cow::Borrowed(values),
        None => Cow::Owned(values.iter().copied().collect()),
    }
}

/// Terms with their meaning, one a line: `Term: meaning`.
pub(crate) fn terms(text: &'static str) -> impl Iterator<Item = [&'static str; 2]> {
    let lines = text.lines().map(str::trim);
    lines.filter_map(|line| line.split_once(": ").map(Into::into))
}

impl<'a> Sheet<'a> {
    /// An empty one, the first version of its schema.
    pub(crate) fn of(name: &'static str, title: &str, definitions: &'static str) -> Sheet<'a> {
        Sheet {
            name,
            version: 1,
            title: title.into(),
            definitions: terms(definitions).collect(),
            ..Sheet::default()
        }
    }

    pub fn fact(&mut self, name: impl Into<String>, text: impl Into<String>) {
        self.facts.push(Fact::new(name, text));
    }

    pub fn detail(&mut self, name: impl Into<String>, text: impl Into<String>) {
        self.facts.push(Fact {
            is_detail: true,
            ..Fact::new(name, text)
        });
    }

    pub fn warn(&mut self, message: impl Into<String>, advice: impl Into<String>) {
        self.warnings.push(Warning::new(message, advice));
    }

    /// Takes in another result: its facts, warnings, tables and definitions, its numbers as one of this name, its
    /// variables with the name before theirs.
    pub fn include(&mut self, name: &str, other: Sheet<'a>) {
        self.fact(name, other.answer);
        self.facts.extend(other.facts);
        self.warnings.extend(other.warnings);
        self.numbers.insert(name.into(), other.numbers.into());
        for mut table in other.tables {
            table.title = format!("{}: {}", other.title, table.title);
            self.tables.push(table);
        }
        self.definitions.extend(other.definitions);
        let prefixed = |text: &str| format!("{name}_{text}");
        for mut variable in other.variables {
            variable.name = prefixed(&variable.name);
            for (dimension, _) in &mut variable.dimensions {
                *dimension = prefixed(dimension);
            }
            self.variables.push(variable);
        }
    }

    /// Adds the members of a JSON object to the numbers.
    pub fn numbers(&mut self, object: Value) {
        if let Value::Object(members) = object {
            self.numbers.extend(members);
        }
    }

    /// Adds an array of one dimension; with the name of the dimension it holds its coordinates.
    pub fn line(
        &mut self,
        name: &str,
        dimension: &str,
        unit: &str,
        values: impl Into<Cow<'a, [f64]>>,
    ) {
        let values = values.into();
        self.variable(name, &[(dimension, values.len())], unit, values);
    }

    /// Adds the coordinates of an axis.
    pub(crate) fn axis(&mut self, role: Role, units: &Units, values: impl Into<Cow<'a, [f64]>>) {
        let [name, _] = role.words();
        self.line(name, name, units.unit(role), values);
    }

    /// Adds an array for each column of items along one dimension.
    pub(crate) fn columns<'i, T: 'i>(
        &mut self,
        dimension: &str,
        items: impl IntoIterator<Item = &'i T> + Clone,
        columns: &[Column<T>],
    ) {
        for (name, unit, of) in columns {
            let values: Vec<f64> = items.clone().into_iter().map(of).collect();
            self.line(name, dimension, unit, values);
        }
    }

    /// Adds an array of two dimensions.
    pub fn plane(
        &mut self,
        name: &str,
        dimensions: [&str; 2],
        unit: &str,
        values: &'a Array2<f64>,
    ) {
        let (rows, columns) = values.dim();
        let dimensions = [(dimensions[0], rows), (dimensions[1], columns)];
        self.variable(name, &dimensions, unit, flat(values));
    }

    /// Adds an array of any dimensions.
    pub fn variable(
        &mut self,
        name: &str,
        dimensions: &[(&str, usize)],
        unit: &str,
        values: impl Into<Cow<'a, [f64]>>,
    ) {
        let dimensions = dimensions.iter();
        self.variables.push(Variable {
            name: name.into(),
            dimensions: dimensions
                .map(|(name, len)| ((*name).to_owned(), *len))
                .collect(),
            unit: unit.into(),
            about: String::new(),
            values: values.into(),
        });
    }
}
