//! Named values beside a file or a variable.

use indexmap::IndexMap;

use crate::{ByteOrder, Sample};

/// A value beside a file or a variable.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// One text.
    Text(String),
    /// Several texts.
    Texts(Vec<String>),
    /// Integers; those beyond an `i64` are [`Value::Numbers`].
    Integers(Vec<i64>),
    /// Floats.
    Numbers(Vec<f64>),
}

impl Value {
    /// The only number that it is.
    pub fn number(&self) -> Option<f64> {
        match &self.numbers()?[..] {
            [only] => Some(*only),
            _ => None,
        }
    }

    /// The first of its integers.
    pub(crate) fn integer(&self) -> Option<i64> {
        match self {
            Value::Integers(values) => values.first().copied(),
            _ => None,
        }
    }

    /// All numbers that it is.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        match self {
            Value::Integers(values) => Some(values.iter().map(|&value| value as f64).collect()),
            Value::Numbers(values) => Some(values.clone()),
            _ => None,
        }
    }

    /// The only text that it is, trimmed; `None` if it is empty.
    pub fn text(&self) -> Option<&str> {
        let text = match self {
            Value::Text(text) => text,
            Value::Texts(texts) if texts.len() == 1 => &texts[0],
            _ => return None,
        };
        Some(text.trim()).filter(|text| !text.is_empty())
    }

    /// The numbers in `bytes`: integers, unless they are floats or exceed an `i64`.
    pub(crate) fn of_samples(sample: Sample, order: ByteOrder, bytes: &[u8]) -> Value {
        let each = || bytes.chunks_exact(sample.bytes());
        let integers: Option<Vec<i64>> = each().map(|one| sample.to_i64(order, one)).collect();
        match integers.filter(|_| !sample.is_float()) {
            Some(integers) => Value::Integers(integers),
            None => Value::Numbers(each().map(|one| sample.to_f64(order, one)).collect()),
        }
    }

    /// What several arrays say under one name: one value if all are equal, else all of them.
    pub(crate) fn together(values: &[&Value]) -> Option<Value> {
        let first = *values.first()?;
        if values.iter().all(|value| *value == first) {
            return Some(first.clone());
        }
        let integer = |value: &&Value| value.integer().filter(|_| value.number().is_some());
        let text = |value: &&Value| match value {
            Value::Text(text) => text.clone(),
            Value::Texts(texts) => texts.join(", "),
            Value::Integers(integers) => format!("{integers:?}"),
            Value::Numbers(numbers) => format!("{numbers:?}"),
        };
        if let Some(integers) = values.iter().map(integer).collect() {
            return Some(Value::Integers(integers));
        }
        let numbers: Option<Vec<f64>> = values.iter().map(|value| value.number()).collect();
        let texts = || Value::Texts(values.iter().map(text).collect());
        Some(numbers.map_or_else(texts, Value::Numbers))
    }
}

/// Named values in the order of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Attributes(pub IndexMap<String, Value>);

impl Attributes {
    /// Adds a value, unless there is one of its name.
    pub fn insert(&mut self, name: impl Into<String>, value: Value) {
        self.0.entry(name.into()).or_insert(value);
    }

    /// Adds a text unless it is empty.
    pub fn insert_text(&mut self, name: impl Into<String>, text: impl Into<String>) {
        let text = text.into();
        if !text.is_empty() {
            self.insert(name, Value::Text(text));
        }
    }

    /// Adds a unit and, but for 1, how many of it a number counts.
    pub fn insert_counts(&mut self, (unit, count): (String, f64)) {
        self.insert_text("units", unit);
        if count != 1.0 {
            self.insert("scale_factor", Value::Numbers(vec![count]));
        }
    }

    /// The value of this name.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.get(name)
    }

    /// The text of this name, trimmed; `None` if it is empty or no text.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.get(name)?.text()
    }

    /// The only number of this name.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.get(name)?.number()
    }
}
