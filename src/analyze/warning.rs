//! Findings that do not stop a run but that its user should know.

use serde_json::{Value, json};

use super::Axes;
use crate::field::Note;
pub use crate::sheet::Warning;
use crate::sheet::six_digits;

/// Sites of a finding, by index in the file and by position.
pub(super) struct Sites {
    indices: Vec<usize>,
    positions: Vec<f64>,
    /// Unit of the positions; `None` where sites are counted.
    unit: Option<String>,
}

impl Sites {
    /// Rows of the range analyzed, the first of which is the site `first` of the file.
    pub fn of(rows: &[usize], first: usize, axes: &Axes) -> Sites {
        let space = &axes.space;
        let is_counted = space.unit.is_none() && space.step == 1.0;
        Sites {
            indices: rows.iter().map(|j| first + j).collect(),
            positions: rows.iter().map(|j| space.at(*j)).collect(),
            unit: (!is_counted).then(|| axes.space_unit().to_owned()),
        }
    }

    /// Says this of them: `sites 3, 7 at 0.3, 0.7 m: no signal`.
    pub fn warning(&self, code: &'static str, what: &str, advice: &str, numbers: Value) -> Warning {
        let noun = if self.indices.len() == 1 {
            "site"
        } else {
            "sites"
        };
        let indices = some(self.indices.iter().map(usize::to_string));
        let at = match &self.unit {
            Some(unit) => format!(
                " at {} {unit}",
                some(self.positions.iter().map(|x| six_digits(*x)))
            ),
            None => String::new(),
        };
        let mut all = json!({"sites": self.indices, "positions": self.positions});
        if let (Value::Object(all), Value::Object(more)) = (&mut all, numbers) {
            all.extend(more);
        }
        Warning::new(format!("{noun} {indices}{at}: {what}"), advice).coded(code, all)
    }
}

/// A doubtful conclusion about the file of the field.
pub(super) fn of_note(note: &Note) -> Warning {
    let advice = note.advice().unwrap_or_default();
    Warning::new(note.message(), advice).coded(note.code(), json!({}))
}

/// The first few.
pub(super) fn some(words: impl ExactSizeIterator<Item = String>) -> String {
    let more = if words.len() > 8 { ", ..." } else { "" };
    format!("{}{more}", words.take(8).collect::<Vec<_>>().join(", "))
}
