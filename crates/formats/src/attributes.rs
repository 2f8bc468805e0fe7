//! Named values beside a file or a variable.

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

/// Named values in the order of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Attributes(pub Vec<(String, Value)>);

impl Attributes {
    /// Adds a value.
    pub fn insert(&mut self, name: impl Into<String>, value: Value) {
        self.0.push((name.into(), value));
    }

    /// Adds a text unless it is empty.
    pub fn insert_text(&mut self, name: impl Into<String>, text: impl Into<String>) {
        let text = text.into();
        if !text.is_empty() {
            self.insert(name, Value::Text(text));
        }
    }

    /// The value of this name.
    pub fn get(&self, name: &str) -> Option<&Value> {
        let found = self.0.iter().find(|(found, _)| found == name);
        found.map(|(_, value)| value)
    }

    /// The text of this name, trimmed; `None` if it is empty or no text.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.get(name)? {
            Value::Text(text) => Some(text.trim()).filter(|text| !text.is_empty()),
            Value::Texts(texts) if texts.len() == 1 => {
                Some(texts[0].trim()).filter(|text| !text.is_empty())
            }
            _ => None,
        }
    }

    /// The only number of this name.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.get(name)? {
            Value::Integers(values) if values.len() == 1 => Some(values[0] as f64),
            Value::Numbers(values) if values.len() == 1 => Some(values[0]),
            _ => None,
        }
    }
}
