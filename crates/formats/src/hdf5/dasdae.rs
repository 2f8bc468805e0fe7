//! DASDAE, the layout of DASCore: a group for each patch, with `data`, `_coord_time`, `_coord_distance`.

use std::collections::HashMap;

use hdf5_reader::Attribute;

use super::Walk;
use crate::{Attributes, Coordinate};

/// Pickled description of the coordinates of a patch.
const PICKLED: &str = "_attrs_coords";

/// Adds the units of the pickled coordinates as `_attrs_time_units` and so on.
pub(super) fn keep_units(found: &[Attribute], attributes: &mut Attributes) {
    let pickled = found.iter().find(|found| found.name == PICKLED);
    let Some(pickled) = pickled else {
        return;
    };
    for (name, unit) in units(&pickled.raw_data) {
        let key = format!("_attrs_{name}_units");
        if attributes.get(&key).is_none() {
            attributes.insert_text(key, unit);
        }
    }
}

/// Names the dimensions of the patches, finds their coordinates and units.
pub(super) fn assign(walk: &mut Walk) {
    if walk.attributes.text("__format__") != Some("DASDAE") {
        return;
    }
    let places: HashMap<String, usize> = walk
        .variables
        .iter()
        .enumerate()
        .map(|(i, v)| (v.path.clone(), i))
        .collect();
    for (path, patch) in &walk.groups {
        let Some(dims) = patch.text("_dims") else {
            continue;
        };
        let split = |names: &str| -> Vec<String> {
            names
                .split(',')
                .map(|name| name.trim().to_owned())
                .collect()
        };
        let dims = split(dims);
        let find = |name: &str| places.get(&format!("{path}/{name}")).copied();
        let coordinate = |walk: &Walk, name: &str, len: u64| {
            let found = find(&format!("_coord_{name}"))?;
            let is_number = walk.variables[found].sample_type.number().is_some();
            let fits = walk.variables[found].shape() == [len];
            (is_number && fits).then_some(Coordinate::Listed(found))
        };
        let mut arrays: Vec<(usize, Vec<String>)> = Vec::new();
        arrays.extend(find("data").map(|i| (i, dims.clone())));
        for (key, _) in &patch.0 {
            let Some(name) = key.strip_prefix("_cdims_") else {
                continue;
            };
            let (Some(i), Some(dims)) = (find(&format!("_coord_{name}")), patch.text(key)) else {
                continue;
            };
            arrays.push((i, split(dims)));
            let flag = |flag| walk.variables[i].attributes.number(flag) == Some(1.0);
            let unit = match (flag("is_datetime64"), flag("is_timedelta64")) {
                (true, _) => Some("nanoseconds since 1970-01-01"),
                (_, true) => Some("nanoseconds"),
                _ => patch.text(&format!("_attrs_{name}_units")),
            };
            let attributes = &mut walk.variables[i].attributes;
            attributes.insert_text("units", unit.unwrap_or_default());
        }
        for (i, dims) in arrays {
            if walk.variables[i].dimensions.len() != dims.len() {
                continue;
            }
            for (d, name) in dims.into_iter().enumerate() {
                let len = walk.variables[i].dimensions[d].len;
                let found = coordinate(walk, &name, len);
                let dimension = &mut walk.variables[i].dimensions[d];
                dimension.coordinate = found;
                dimension.name = Some(name);
            }
        }
        if let Some(i) = find("data") {
            let unit = patch.text("_attrs_data_units").unwrap_or_default();
            let kind = patch.text("_attrs_data_type").unwrap_or_default();
            let attributes = &mut walk.variables[i].attributes;
            attributes.insert_text("units", unit);
            attributes.insert_text("long_name", kind);
        }
    }
}

/// The units in a pickled dictionary of coordinates: `{"time": {"units": "s", ..}, ..}`.
///
/// Pickles of protocol 0 are lines of text. No part of them is executed: only texts (`V..`), their later
/// repetitions (`g` and the number given by `p`) and the begin of a dictionary (`(dp`) are looked at.
fn units(pickled: &[u8]) -> Vec<(String, String)> {
    let text = |line: &[u8]| -> String { line.iter().map(|&byte| char::from(byte)).collect() };
    let lines: Vec<String> = pickled.split(|&byte| byte == b'\n').map(text).collect();
    let mut known: HashMap<&str, &str> = HashMap::new();
    let mut texts: Vec<Option<&str>> = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        // `s` stores the pair before.
        let line = line.trim_start_matches('s');
        let found = match line.as_bytes().first() {
            Some(b'V') => Some(&line[1..]),
            Some(b'g') => known.get(&line[1..]).copied(),
            _ => None,
        };
        if let (Some(found), Some(Some(number))) =
            (found, lines.get(i + 1).map(|next| next.strip_prefix('p')))
        {
            known.insert(number, found);
        }
        texts.push(found);
    }
    // The line of the value: behind that of the key, and behind its number.
    let value = |key: usize| match lines.get(key + 1) {
        Some(next) if next.starts_with('p') => key + 2,
        _ => key + 1,
    };
    let mut units = Vec::new();
    let mut coordinate = None;
    for (i, text) in texts.iter().enumerate() {
        let Some(text) = text else { continue };
        let at = value(i);
        if lines.get(at).is_some_and(|line| line.starts_with("(dp")) {
            coordinate = Some(*text);
        } else if let ("units", Some(coordinate), Some(Some(unit))) =
            (*text, coordinate, texts.get(at))
        {
            units.push((coordinate.to_owned(), (*unit).to_owned()));
        }
    }
    units
}
