//! Files of a described result: `summary.json`, and its arrays.

use serde_json::{Map, Value, json};

use super::{ArrayFile, ArrayLabels, Attribute, Provenance};
use crate::error::Result;
use crate::sheet::{Sheet, Table};

impl Sheet<'_> {
    /// `cascade.coherence/1`.
    pub fn schema(&self) -> String {
        format!("cascade.{}/{}", self.name, self.version)
    }

    /// `summary.json`: schema, provenance, the answer in words, the numbers (`null` where undefined), warnings.
    ///
    /// # Errors
    /// None for results of this library.
    pub fn summary(&self, provenance: &Provenance) -> serde_json::Result<String> {
        serde_json::to_string_pretty(&self.summary_value(provenance))
    }

    /// The same as a value.
    pub fn summary_value(&self, provenance: &Provenance) -> Value {
        let mut all = Map::new();
        all.insert("schema".into(), self.schema().into());
        all.insert("provenance".into(), json!(provenance));
        all.insert("answer".into(), Value::from(&*self.answer));
        all.extend(self.numbers.clone());
        all.insert("warnings".into(), json!(self.warnings));
        all.into()
    }

    /// Hands the arrays to a file, or to memory, and says what those are that went there in blocks.
    ///
    /// # Errors
    /// Those of `file`.
    pub fn write_to(&self, file: &dyn ArrayFile) -> Result<()> {
        self.variables.iter().try_for_each(|variable| {
            let axes = variable.dimensions.iter();
            let axes: Vec<(&str, usize)> = axes.map(|(name, len)| (&**name, *len)).collect();
            let labels = ArrayLabels {
                name: &variable.name,
                axes: &axes,
                unit: &variable.unit,
                about: match &*variable.about {
                    "" => &variable.name.replace('_', " "),
                    about => about,
                },
            };
            if axes.is_empty() {
                file.describe(labels.name, labels.attributes());
                return Ok(());
            }
            file.append(&labels, &variable.values)
        })
    }

    /// Adds parts of a summary as attributes of a file: conventions, residuals, provenance. What the summary nests is a
    /// text in JSON.
    pub fn describe_file(&self, summary: &Value, file: &dyn ArrayFile) {
        for (part, prefix) in self.attributes {
            for (name, value) in summary[part].as_object().into_iter().flatten() {
                if let Some(value) = attribute(value) {
                    file.attribute(&format!("{prefix}{name}"), value);
                }
            }
        }
        if let Some(schema) = attribute(&summary["schema"]) {
            file.attribute("schema", schema);
        }
    }
}

/// A part of the summary as an attribute; nothing for what is not known.
fn attribute(value: &Value) -> Option<Attribute> {
    Some(match value {
        Value::Null => return None,
        Value::String(text) => Attribute::Text(text.clone()),
        Value::Number(number) => match number.as_i64().and_then(|n| i32::try_from(n).ok()) {
            Some(integer) => Attribute::Integer(integer),
            None => Attribute::Number(number.as_f64()?),
        },
        nested => Attribute::Text(nested.to_string()),
    })
}

impl Table {
    /// As CSV: the head, then the rows.
    ///
    /// # Errors
    /// None for results of this library.
    pub fn to_csv(&self) -> std::result::Result<String, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.head)?;
        self.rows
            .iter()
            .try_for_each(|row| writer.write_record(row))?;
        let bytes = writer.into_inner().map_err(|error| error.into_error())?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}
