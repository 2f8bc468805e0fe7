//! The groups and arrays of a store.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Map, Value as Json};
use zarrs::array::{Array, ArrayCreateError, ArrayMetadata, DataType};
use zarrs::filesystem::FilesystemStore;
use zarrs::plugin::PluginCreateError;
use zarrs::storage::StorageError;

use super::{Stored, caught, json};
use crate::{
    Attributes, ByteOrder, Dimension, Error, Place, Result, Sample, SampleType, Value, Variable,
    numpy_times,
};

/// Groups within groups.
const MOST_LEVELS: usize = 64;
/// Folders of a store.
const MOST_OBJECTS: usize = 100_000;
/// As NumPy has it.
const MOST_DIMENSIONS: usize = 64;
/// Names of dimensions in version 2, which xarray defined.
const NAMES: &str = "_ARRAY_DIMENSIONS";

/// What is found on the way through the groups.
pub(super) struct Walk<'a> {
    store: Arc<FilesystemStore>,
    /// The name of an array without a group.
    name: &'a str,
    pub attributes: Attributes,
    pub variables: Vec<Variable>,
    /// One for each variable; none for what is not read.
    pub arrays: Vec<Option<Stored>>,
    folders: usize,
}

impl Walk<'_> {
    pub(super) fn new(store: Arc<FilesystemStore>, name: &str) -> Walk<'_> {
        Walk {
            store,
            name,
            attributes: Attributes::default(),
            variables: Vec::new(),
            arrays: Vec::new(),
            folders: 0,
        }
    }

    /// Lists what is in `folder`, whose path in the store is `path`: empty for the store itself.
    pub(super) fn visit(&mut self, folder: &Path, path: &str, level: usize) -> Result<()> {
        let shown = if path.is_empty() { "/" } else { path };
        self.folders += 1;
        if level > MOST_LEVELS || self.folders > MOST_OBJECTS {
            let what =
                format!("more than {MOST_LEVELS} levels or {MOST_OBJECTS} folders of groups");
            return Err(Error::unsupported(what, "store fewer arrays together"));
        }
        if let Some(mut metadata) = json::read(folder, "zarr.json", shown)? {
            return match metadata.get("node_type").and_then(Json::as_str) {
                Some("group") => {
                    self.group(&member(&mut metadata, "attributes"), folder, path, level)
                }
                Some("array") => self.array(metadata, path),
                _ => Err(Error::damaged(
                    format!("zarr.json of {shown}"),
                    "a group or an array",
                    "neither",
                )),
            };
        }
        let attributes = || Ok(json::read(folder, ".zattrs", shown)?.unwrap_or_default());
        if let Some(mut metadata) = json::read(folder, ".zarray", shown)? {
            metadata.insert("attributes".into(), Json::Object(attributes()?));
            return self.array(metadata, path);
        }
        if json::read(folder, ".zgroup", shown)?.is_some() {
            return self.group(&attributes()?, folder, path, level);
        }
        Ok(())
    }

    fn group(
        &mut self,
        attributes: &Map<String, Json>,
        folder: &Path,
        path: &str,
        level: usize,
    ) -> Result<()> {
        for (name, value) in json::attributes(attributes).0 {
            let name = format!("{path}/{name}").trim_start_matches('/').to_owned();
            self.attributes.insert(name, value);
        }
        let failed = |error: std::io::Error| {
            Error::damaged(
                format!("group {path}/"),
                "a readable folder",
                error.to_string(),
            )
        };
        let mut names = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(failed)? {
            let name = entry.map_err(failed)?.file_name();
            names.extend(
                name.into_string()
                    .ok()
                    .filter(|name| !name.starts_with('.')),
            );
        }
        names.sort_unstable();
        for name in names {
            let folder = folder.join(&name);
            if folder.is_dir() {
                self.visit(&folder, &format!("{path}/{name}"), level + 1)?;
            }
        }
        Ok(())
    }

    fn array(&mut self, metadata: Map<String, Json>, path: &str) -> Result<()> {
        let name = if path.is_empty() {
            format!("/{}", self.name)
        } else {
            path.to_owned()
        };
        let place = || format!("variable {name}");
        let mut described = Described::of(metadata, place)?;
        let (sample_type, stored) = match described.other() {
            Some(other) => (SampleType::Other(other.into()), None),
            None => match caught(&place(), || open(&self.store, path, &described))? {
                Ok(array) => stored(&name, array)?,
                Err(cause) => match unsupported(&cause) {
                    Some(what) => (SampleType::Other(what), None),
                    None => {
                        let found = cause.to_string();
                        return Err(Error::damaged(place(), "sound metadata", found));
                    }
                },
            },
        };
        described.fill(sample_type.number(), stored.as_ref());
        let rows = stored.as_ref().map_or(1, |stored| stored.rows);
        self.variables.push(Variable {
            path: name,
            dimensions: described.dimensions,
            sample_type,
            attributes: described.attributes,
            place: Place::Encoded { rows },
        });
        self.arrays.push(stored);
        Ok(())
    }
}

/// The object of this name, taken out.
fn member(metadata: &mut Map<String, Json>, name: &str) -> Map<String, Json> {
    match metadata.remove(name) {
        Some(Json::Object(object)) => object,
        _ => Map::new(),
    }
}

/// What the metadata of an array say before its type is known.
struct Described {
    metadata: Map<String, Json>,
    dimensions: Vec<Dimension>,
    attributes: Attributes,
    /// Whether xarray reads its fill value as a gap.
    is_fill_a_gap: bool,
    /// Of `datetime64` and `timedelta64` in version 2, which are read as integers.
    time: Option<(String, f64)>,
}

impl Described {
    fn of(mut metadata: Map<String, Json>, place: impl Fn() -> String) -> Result<Described> {
        let shape = metadata.get("shape").and_then(Json::as_array);
        let shape: Option<Vec<u64>> =
            shape.and_then(|shape| shape.iter().map(Json::as_u64).collect());
        let Some(shape) = shape.filter(|shape| shape.len() <= MOST_DIMENSIONS) else {
            let expected = format!("a shape of at most {MOST_DIMENSIONS} dimensions");
            let found = metadata.get("shape").map_or("none".into(), Json::to_string);
            return Err(Error::damaged(place(), expected, found));
        };
        let bytes = shape.iter().try_fold(16u64, |n, &len| n.checked_mul(len));
        if bytes.is_none() && !shape.contains(&0) {
            let found = format!("the shape {shape:?}");
            return Err(Error::damaged(place(), "fewer than 2^60 values", found));
        }
        let is_v2 = metadata.get("zarr_format").and_then(Json::as_u64) == Some(2);
        let mut found = member(&mut metadata, "attributes");
        let names = match is_v2 {
            true => found.remove(NAMES),
            false => metadata.get("dimension_names").cloned(),
        };
        let names = names.as_ref().and_then(Json::as_array);
        let names = names.filter(|names| names.len() == shape.len());
        let name_of = |d: usize| names.and_then(|names| names[d].as_str());
        let dimensions = (0..shape.len()).map(|d| Dimension {
            name: name_of(d).map(str::to_owned),
            len: shape[d],
            coordinate: None,
        });
        let dimensions = dimensions.collect();
        let mut attributes = json::attributes(&found);
        let has_fill = metadata
            .get("fill_value")
            .is_some_and(|fill| !fill.is_null());
        let is_fill_a_gap = is_v2 && names.is_some() && has_fill;
        let fill = found.get("_FillValue").filter(|_| !is_v2);
        if let Some(fill) = fill.and_then(json::fill_of_xarray) {
            attributes.0.insert("_FillValue".into(), fill);
        }
        if let Some(Json::Bool(fill)) = metadata.get("fill_value").filter(|_| is_v2) {
            // The only form that zarrs knows.
            let fill = Json::from(u8::from(*fill));
            metadata.insert("fill_value".into(), fill);
        }
        let time = is_v2.then(|| integers_of_times(&mut metadata)).flatten();
        Ok(Described {
            metadata,
            dimensions,
            attributes,
            is_fill_a_gap,
            time,
        })
    }

    /// Adds what the type says: the fill value, the unit of times.
    fn fill(&mut self, sample: Option<Sample>, stored: Option<&Stored>) {
        let (Some(sample), Some(stored)) = (sample, stored) else {
            return;
        };
        let times = self.time.take();
        let times = times.or_else(|| times_of(stored.array.data_type()));
        if let Some(times) = times.filter(|_| self.attributes.get("units").is_none()) {
            self.attributes.insert_counts(times);
            self.attributes
                .insert("_FillValue", Value::Integers(vec![i64::MIN]));
            return;
        }
        let bits = stored.array.fill_value().as_ne_bytes();
        if !self.is_fill_a_gap || sample == Sample::Bool || bits.len() != sample.bytes() {
            return;
        }
        let value = Value::of_samples(sample, ByteOrder::NATIVE, bits);
        self.attributes.0.insert("_FillValue".into(), value);
    }

    /// What an array of version 2 holds that is no numbers.
    fn other(&self) -> Option<&'static str> {
        let dtype = match self.metadata.get("dtype")? {
            Json::String(dtype) => dtype,
            _ => return Some("a compound type"),
        };
        match dtype
            .trim_start_matches(['<', '>', '|', '='])
            .chars()
            .next()?
        {
            'c' => Some("complex numbers"),
            'U' | 'S' => Some("text"),
            'O' => Some("objects of Python, such as text"),
            'V' => Some("raw bytes"),
            _ => None,
        }
    }
}

/// Reads `datetime64` and `timedelta64` of version 2 as integers, and says in which unit.
fn integers_of_times(metadata: &mut Map<String, Json>) -> Option<(String, f64)> {
    let dtype = metadata.get("dtype")?.as_str()?;
    let (order, rest) = dtype.split_at_checked(1)?;
    let kind = rest.get(..3)?;
    let unit = rest[3..].strip_suffix(']')?;
    let times = match kind {
        "M8[" | "m8[" => numpy_times(unit, kind == "M8[")?,
        _ => return None,
    };
    let integer = format!("{order}i8");
    metadata.insert("dtype".into(), Json::String(integer));
    if metadata.get("fill_value").is_some_and(Json::is_string) {
        metadata.insert("fill_value".into(), Json::from(i64::MIN));
    }
    Some(times)
}

/// What `datetime64` and `timedelta64` of version 3 count.
fn times_of(data_type: &DataType) -> Option<(String, f64)> {
    let (unit, scale, is_date) = match data_type {
        DataType::NumpyDateTime64 { unit, scale_factor } => (unit, scale_factor, true),
        DataType::NumpyTimeDelta64 { unit, scale_factor } => (unit, scale_factor, false),
        _ => return None,
    };
    let unit = serde_json::to_value(unit).ok()?;
    numpy_times(&format!("{scale}{}", unit.as_str()?), is_date)
}

fn open(
    store: &Arc<FilesystemStore>,
    path: &str,
    described: &Described,
) -> std::result::Result<Array<FilesystemStore>, ArrayCreateError> {
    let metadata = parsed(Json::Object(described.metadata.clone()))?;
    let path = if path.is_empty() { "/" } else { path };
    Array::new_with_metadata(Arc::clone(store), path, metadata)
}

/// Metadata of either version.
fn parsed(json: Json) -> std::result::Result<ArrayMetadata, ArrayCreateError> {
    let is_v2 = json.get("zarr_format").and_then(Json::as_u64) == Some(2);
    let metadata = match is_v2 {
        true => serde_json::from_value(json).map(ArrayMetadata::V2),
        false => serde_json::from_value(json).map(ArrayMetadata::V3),
    };
    metadata.map_err(|error| StorageError::Other(error.to_string()).into())
}

/// The type of an array, and how it is decoded.
fn stored(name: &str, array: Array<FilesystemStore>) -> Result<(SampleType, Option<Stored>)> {
    let sample = match array.data_type() {
        DataType::Bool => Sample::Bool,
        DataType::Int8 => Sample::I8,
        DataType::Int16 => Sample::I16,
        DataType::Int32 => Sample::I32,
        DataType::Int64 => Sample::I64,
        DataType::UInt8 => Sample::U8,
        DataType::UInt16 => Sample::U16,
        DataType::UInt32 => Sample::U32,
        DataType::UInt64 => Sample::U64,
        DataType::Float16 => Sample::F16,
        DataType::Float32 => Sample::F32,
        DataType::Float64 => Sample::F64,
        DataType::NumpyDateTime64 { .. } | DataType::NumpyTimeDelta64 { .. } => Sample::I64,
        DataType::String => return Ok((SampleType::Other("text".into()), None)),
        DataType::Complex64 | DataType::Complex128 => {
            return Ok((SampleType::Other("complex numbers".into()), None));
        }
        other => {
            return Ok((
                SampleType::Other(format!("values of the type {other}")),
                None,
            ));
        }
    };
    let stored = Stored::new(name, array, sample)?;
    Ok((SampleType::Number(sample), Some(stored)))
}

/// What is sound but not read; none for damage.
fn unsupported(cause: &ArrayCreateError) -> Option<String> {
    use ArrayCreateError::*;
    match cause {
        DataTypeCreateError(PluginCreateError::Unsupported(what))
        | CodecsCreateError(PluginCreateError::Unsupported(what))
        | StorageTransformersCreateError(PluginCreateError::Unsupported(what))
        | ChunkGridCreateError(PluginCreateError::Unsupported(what))
        | ChunkKeyEncodingCreateError(PluginCreateError::Unsupported(what)) => {
            Some(format!("what is not read: {what}"))
        }
        UnsupportedZarrV2Array(what) => Some(format!("what is not read: {what}")),
        AdditionalFieldUnsupportedError(what) => Some(format!("what is not read: {what}")),
        _ => None,
    }
}
