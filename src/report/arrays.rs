//! Files of labelled arrays, and what they say of an analysis.

use serde_json::Value;

use super::netcdf::{ArrayLabels, Attribute};
use crate::analyze::Analysis;
use crate::analyze::labels::Power;
use crate::error::Result;
use crate::unit;

/// Takes arrays with their labels, and values that belong to all of them: a file ([`NetCdf`](super::NetCdf)), or memory.
pub trait LabelledArrays {
    /// Takes an array, row-major.
    ///
    /// # Errors
    /// If it cannot be kept.
    fn append(&self, labels: &ArrayLabels, values: &[f64]) -> Result<()>;

    /// Adds values to the array of this name, if there is one.
    fn describe(&self, array: &str, attributes: Vec<(&str, Attribute)>);

    /// Adds a value that belongs to all arrays.
    fn attribute(&self, name: &str, value: Attribute);
}

/// Adds units to the large arrays of an analysis, which went to the [`Sink`], and conventions, residuals and provenance
/// as attributes of the file. What `summary` nests is a text in JSON.
///
/// [`Sink`]: crate::arrays::Sink
pub fn describe_analysis(analysis: &Analysis, summary: &Value, file: &dyn LabelledArrays) {
    let power = Power::of(analysis);
    for (array, label) in [
        ("temporal_spectrum", power.over_frequency()),
        ("spatial_spectrum", power.over_wavenumber()),
        ("spacetime_spectrum", power.over_both()),
        ("kinetic_flux_surrogate", power.flux()),
    ] {
        let (name, unit) = unit::split(&label);
        file.describe(array, text_attributes(unit, name));
    }
    let parts = [
        ("provenance", ""),
        ("field", ""),
        ("conventions", ""),
        ("parseval", "parseval_"),
    ];
    describe_file(summary, &parts, file);
}

/// The unit and the name of an array as attributes, those of them that it has.
pub(super) fn text_attributes<'a>(unit: &str, about: &str) -> Vec<(&'a str, Attribute)> {
    let texts = [("units", unit), ("long_name", about)].into_iter();
    let texts = texts.filter(|(_, text)| !text.is_empty());
    texts
        .map(|(name, text)| (name, Attribute::Text(text.into())))
        .collect()
}

/// The numbers and texts of these parts of a summary as attributes of the file, their names behind a prefix.
pub(super) fn describe_file(summary: &Value, parts: &[(&str, &str)], file: &dyn LabelledArrays) {
    for &(part, prefix) in parts {
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
