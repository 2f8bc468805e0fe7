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
    for (name, unit) in pickled.map_or(Vec::new(), |pickled| units(&pickled.raw_data)) {
        attributes.insert_text(format!("_attrs_{name}_units"), unit);
    }
}

/// Names the dimensions of the patches, finds their coordinates and units.
pub(super) fn assign(walk: &mut Walk) {
    if walk.attributes.text("__format__") != Some("DASDAE") {
        return;
    }
    let paths = walk.variables.iter().map(|v| v.path.clone());
    let places: HashMap<String, usize> = paths.zip(0..).collect();
    for (path, patch) in &walk.groups {
        let Some(dims) = patch.text("_dims") else {
            continue;
        };
        let split = |names: &str| -> Vec<String> {
            let names = names.split(',').map(str::trim);
            names.map(str::to_owned).collect()
        };
        let find = |name: &str| places.get(&format!("{path}/{name}")).copied();
        let coordinate = |walk: &Walk, name: &str, len: u64| {
            let found = find(&format!("_coord_{name}"))?;
            let variable = &walk.variables[found];
            let fits = variable.sample_type.number().is_some() && variable.shape() == [len];
            fits.then_some(Coordinate::Listed(found))
        };
        let mut arrays: Vec<(usize, Vec<String>)> = Vec::new();
        arrays.extend(find("data").map(|i| (i, split(dims))));
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

/// A value of a pickle: a text, a dictionary by its number, or what is not looked at.
#[derive(Clone, Copy)]
enum Pickled<'a> {
    Mark,
    Text(&'a str),
    Dictionary(usize),
    Other,
}

/// The units in a pickled dictionary of coordinates: `{"time": {"units": "s", ..}, ..}`.
///
/// Pickles of protocol 0 are codes of one letter, some with lines behind them, for a machine with a stack. Nothing is
/// executed: calls and classes give [`Pickled::Other`].
fn units(pickled: &[u8]) -> Vec<(String, String)> {
    use Pickled::{Dictionary, Mark, Other, Text};
    let text: String = pickled.iter().map(|&byte| char::from(byte)).collect();
    let mut rest = text.as_str();
    let (mut stack, mut memo) = (Vec::new(), HashMap::new());
    let (mut dictionaries, mut names, mut units) = (0, HashMap::new(), Vec::new());
    while let Some(code) = rest.chars().next() {
        rest = &rest[code.len_utf8()..];
        let mut line = || {
            let (line, after) = rest.split_once('\n').unwrap_or((rest, ""));
            rest = after;
            line
        };
        let pushed = match code {
            'V' => Text(line()),
            'g' => memo.get(line()).copied().unwrap_or(Other),
            'p' => {
                memo.extend(stack.last().map(|last| (line(), *last)));
                continue;
            }
            'c' | 'F' | 'I' | 'L' | 'S' => {
                line();
                if code == 'c' {
                    line();
                }
                Other
            }
            'N' => Other,
            '(' => Mark,
            'd' | 'l' | 't' => {
                while !matches!(stack.pop(), Some(Mark) | None) {}
                dictionaries += 1;
                Dictionary(dictionaries)
            }
            's' => {
                let (value, key) = (stack.pop(), stack.pop());
                match (stack.last(), key, value) {
                    (_, Some(Text(name)), Some(Dictionary(of))) => {
                        names.insert(of, name);
                    }
                    (Some(Dictionary(of)), Some(Text("units")), Some(Text(unit))) => {
                        units.push((*of, unit));
                    }
                    _ => {}
                }
                continue;
            }
            // A class and its arguments become an object.
            'R' => {
                stack.truncate(stack.len().saturating_sub(2));
                Other
            }
            'b' | 'a' | '0' => {
                stack.pop();
                continue;
            }
            _ => break,
        };
        stack.push(pushed);
    }
    let named = units.into_iter();
    let named = named.filter_map(|(of, unit)| Some((names.get(&of)?.to_string(), unit.to_owned())));
    named.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As Python writes `pickle.dumps(coordinates, protocol=0)`, with a coordinate without a unit before the other.
    #[test]
    fn val_python_units_of_pickled_coordinates() {
        let pickled = b"(dp0\nVdistance\np1\n(dp2\nVdtype\np3\nVfloat64\np4\nsVmin\np5\nF0.0\nsVunits\np8\nNssVtime\np9\n(dp10\n\
            g3\nVdatetime64\np11\nsg5\ncnumpy\nscalar\np12\n(I4\nV<\np17\nNtp18\nRp19\n(I1\ntbsg8\nVs\np59\nssVnew\n(dg8\ng59\nss.";
        let unit = |name: &str| (name.to_owned(), "s".to_owned());
        assert_eq!(units(pickled), [unit("time"), unit("new")]);
        assert_eq!(units(b"\x80\x04}"), []);
    }
}
