//! What a file holds, and what of it is taken for the field.

use std::path::Path;

use wavecascade_formats::{Attributes, Container, Coordinate, Format, Place, Value, Variable};

use super::Field;
use super::labelled::{Arrays, dimensions};
use super::open::Opened;
use super::options::{OpenOptions, ReadMode};
use crate::error::Result;

/// Characters of an attribute that are shown.
const SHOWN: usize = 60;

/// What a file holds.
#[derive(Debug)]
pub struct Inspection {
    /// `an HDF5 file`.
    pub format: String,
    /// Values that belong to the whole file, as text.
    pub attributes: Vec<(String, String)>,
    /// Its arrays; none for a format of one array.
    pub variables: Vec<VariableInfo>,
    /// The field that would be analyzed, or why there is none.
    pub field: Result<Field>,
}

/// An array of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct VariableInfo {
    pub path: String,
    /// `time: 2000, x: 64`.
    pub dimensions: String,
    /// `f32`, or what it holds in place of numbers.
    pub sample: String,
    /// Whether its samples stay in the file, and are not decoded first.
    pub is_in_place: bool,
    /// What the coordinates of its dimensions are, one each: `0 to 1.999 s by 0.001`.
    pub coordinates: Vec<Option<String>>,
    pub attributes: Vec<(String, String)>,
}

/// What the file at `path` holds, and what `options` make of it.
///
/// # Errors
/// [`crate::Error::Read`]; [`crate::Error::Input`] if the format is not read or the file is damaged. Where the arrays
/// can be listed but none can be taken for a field, the reason is [`Inspection::field`].
pub fn inspect(path: &Path, options: &OpenOptions) -> Result<Inspection> {
    options.check()?;
    let options = OpenOptions {
        read: ReadMode::Map,
        hash: false,
        ..options.clone()
    };
    let opened = Opened::at(path, &options)?;
    let format = opened.format;
    let (attributes, variables) = match format {
        Format::Table => (Vec::new(), Vec::new()),
        format => opened.arrays(path, &options, |Arrays { container, .. }| {
            // One array without a name is not listed.
            let is_listed = format != Format::Npy;
            let listed = container.variables.iter().filter(|_| is_listed);
            let infos = listed.map(|v| info(container, v)).collect();
            Ok((texts(&container.attributes), infos))
        })?,
    };
    Ok(Inspection {
        format: format.to_string(),
        attributes,
        variables,
        field: Field::open(path, &options),
    })
}

fn info(container: &Container, variable: &Variable) -> VariableInfo {
    let coordinate = |coordinate: &Option<Coordinate>, len: u64| match coordinate.as_ref()? {
        Coordinate::Even { step, .. } if step.is_nan() => None,
        Coordinate::Even { origin, step, unit } => {
            let last = origin + len.saturating_sub(1) as f64 * step;
            let unit = unit.as_deref().unwrap_or_default();
            Some(format!("{origin} to {last} {unit} by {step}"))
        }
        Coordinate::Listed(i) => Some(container.variables[*i].path.clone()),
    };
    let all = variable.dimensions.iter();
    VariableInfo {
        path: variable.path.clone(),
        dimensions: dimensions(variable),
        sample: variable.sample_type.name().to_owned(),
        is_in_place: matches!(&variable.place, Place::Strided(strided) if strided.is_in_file),
        coordinates: all.map(|d| coordinate(&d.coordinate, d.len)).collect(),
        attributes: texts(&variable.attributes),
    }
}

/// Attributes as texts, long ones cut.
fn texts(attributes: &Attributes) -> Vec<(String, String)> {
    let joined = |values: Vec<String>| match values.len() {
        0..=6 => values.join(", "),
        n => format!("{}, .. ({n})", values[..4].join(", ")),
    };
    let text = |value: &Value| match value {
        Value::Text(text) => text.clone(),
        Value::Texts(texts) => joined(texts.clone()),
        Value::Integers(values) => joined(values.iter().map(i64::to_string).collect()),
        Value::Numbers(values) => joined(values.iter().map(f64::to_string).collect()),
    };
    let cut = |text: String| {
        let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        match line.char_indices().nth(SHOWN) {
            Some((at, _)) => format!("{}..", &line[..at]),
            None => line,
        }
    };
    let named = attributes.0.iter();
    named
        .map(|(name, value)| (name.clone(), cut(text(value))))
        .collect()
}
