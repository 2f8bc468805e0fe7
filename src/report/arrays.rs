//! What a file of arrays says of an analysis.

use serde_json::Value;

use super::{ArrayFile, Attribute};
use crate::analyze::Analysis;
use crate::analyze::labels::Power;
use crate::sheet::Sheet;
use crate::unit;

/// Parts of the numbers of an analysis that are attributes of the file, and what their names begin with there.
const ATTRIBUTES: [(&str, &str); 4] = [
    ("provenance", ""),
    ("field", ""),
    ("conventions", ""),
    ("parseval", "parseval_"),
];

/// Adds what the large arrays of an analysis are, which went to the [`Sink`], and that conventions, residuals and
/// provenance are attributes of their file.
///
/// [`Sink`]: crate::arrays::Sink
pub fn label_analysis(analysis: &Analysis, sheet: &mut Sheet) {
    sheet.attributes = &ATTRIBUTES;
    let power = Power::of(analysis);
    for (name, label) in [
        ("temporal_spectrum", power.over_frequency()),
        ("spatial_spectrum", power.over_wavenumber()),
        ("spacetime_spectrum", power.over_both()),
        ("kinetic_flux_surrogate", power.flux()),
    ] {
        let (about, unit) = unit::split(&label);
        sheet.variable(name, &[], unit, Vec::new());
        if let Some(added) = sheet.variables.last_mut() {
            added.about = about.into();
        }
    }
}

/// The numbers and texts of these parts of a summary as attributes of the file, their names behind a prefix.
pub(super) fn describe_file(summary: &Value, parts: &[(&str, &str)], file: &dyn ArrayFile) {
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
