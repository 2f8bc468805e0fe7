//! What a peer's reader found in a file, and damage to it.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use serde_json::{Map, Value as Json};
use wavecascade_formats::{
    ByteOrder, Container, Coordinate, Format, Options, Sample, SampleType, Value, Variable, open,
    open_directory,
};

pub fn directory(of: &str) -> PathBuf {
    let tests = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/files");
    tests.join(of)
}

pub fn file(of: &str, name: &str) -> Vec<u8> {
    std::fs::read(directory(of).join(name)).unwrap()
}

pub fn values(container: &Container, path: &str) -> Vec<f64> {
    container.numbers(container.find(path).unwrap()).unwrap()
}

/// Samples of a block, the lowest byte first.
fn bytes(container: &Container, variable: usize, block: &[Range<u64>]) -> Vec<u8> {
    let sample = container.variables[variable].sample_type.number().unwrap();
    let count: u64 = block.iter().map(|range| range.end - range.start).product();
    let mut out = vec![0; count as usize * sample.bytes()];
    container.read(variable, block, &mut out).unwrap();
    if cfg!(target_endian = "big") {
        out.chunks_exact_mut(sample.bytes())
            .for_each(<[u8]>::reverse);
    }
    out
}

/// Numbers of a block.
pub fn block(container: &Container, variable: usize, block: &[Range<u64>]) -> Vec<f64> {
    let found = &container.variables[variable];
    let sample = found.sample_type.number().unwrap();
    numbers(found, sample, &bytes(container, variable, block), false)
}

/// What the peer of a folder read, by the names of its files.
pub fn expected(of: &str) -> Map<String, Json> {
    let mut json: Json = serde_json::from_slice(&file(of, "expected.json")).unwrap();
    match json.get_mut("files") {
        Some(files) => files.take(),
        None => json,
    }
    .as_object()
    .unwrap()
    .clone()
}

pub fn open_bytes(name: &str, bytes: &[u8]) -> Container {
    let format = Format::detect(name, bytes).unwrap_or_else(|| panic!("{name} is detected"));
    open(format, Arc::new(bytes.to_vec()), &Options::default()).unwrap()
}

/// A file of a folder, or a store.
pub fn opened(of: &str, name: &str) -> Container {
    let path = directory(of).join(name);
    match Format::detect_directory(&path) {
        Some(format) => open_directory(format, &path, &Options::default()).unwrap(),
        None => open_bytes(name, &file(of, name)),
    }
}

/// Every array that the peer of a folder found is in its file: type, shape and every bit, also of blocks, what its samples stand
/// for, steps, names and attributes. Counts files, arrays that were compared, those that are not read, and listed variables of numbers.
pub fn compare_all(folder: &str) -> [usize; 4] {
    let mut counts = [0; 4];
    for (name, found) in expected(folder) {
        let container = opened(folder, &name);
        counts[0] += 1;
        let is_number = |variable: &&Variable| variable.sample_type.number().is_some();
        counts[3] += container.variables.iter().filter(is_number).count();
        for (path, expected) in found.as_object().unwrap() {
            let is_compared = compare(&container, path, expected, &format!("{name} {path}"));
            counts[if is_compared { 1 } else { 2 }] += 1;
        }
    }
    counts
}

/// The variable of this path, or the one that has it for a row: a channel or a trace.
fn place(container: &Container, path: &str) -> Option<(usize, Option<u64>)> {
    if let Some(at) = container.find(path) {
        return Some((at, None));
    }
    let mut variables = container.variables.iter().enumerate();
    variables.find_map(|(at, variable)| {
        let mut keys = ["channels", "traces"].into_iter();
        let Some(Value::Texts(names)) = keys.find_map(|key| variable.attributes.get(key)) else {
            return None;
        };
        let group = variable.path.trim_start_matches('/');
        let above = group.rsplit_once('/').map_or("", |(above, _)| above);
        let is_it = |name: &String| {
            let is_below = |group: &str| path == format!("{group}/{name}");
            name == path || is_below(group) || is_below(above)
        };
        Some((at, Some(names.iter().position(is_it)? as u64)))
    })
}

/// A type as NumPy names it.
fn kind(sample: Sample) -> String {
    match sample.name() {
        "bool" => "b1".to_owned(),
        name => format!("{}{}", &name[..1], sample.bytes()),
    }
}

/// Parts of a dimension: samples left out before and behind, if there are as many.
const PARTS: [[u64; 2]; 4] = [[0, 0], [1, 1], [2, 1], [3, 4]];

/// Blocks of an array: parts of all dimensions, and each index of the first, with the next, of all but the first of the others.
fn blocks(shape: &[u64]) -> Vec<Vec<Range<u64>>> {
    let part = |len: u64, [before, behind]: [u64; 2]| match len > before + behind {
        true => before..len - behind,
        false => 0..len,
    };
    let parts = PARTS.map(|skipped| shape.iter().map(|len| part(*len, skipped)).collect());
    let first = shape.first().map_or(0, |len| *len.min(&12));
    let others = shape.iter().skip(1).map(|len| part(*len, [1, 0]));
    let rows = (0..first).map(|i| {
        let pair = i..(i + 2).min(shape[0]);
        std::iter::once(pair).chain(others.clone()).collect()
    });
    parts.into_iter().chain(rows).collect()
}

/// The bytes of a block within those of an array.
fn within(all: &[u8], size: usize, shape: &[u64], block: &[Range<u64>]) -> Vec<u8> {
    let is_within = |flat: usize| {
        let mut rest = flat as u64;
        shape.iter().zip(block).rev().all(|(len, range)| {
            let index = rest % len;
            rest /= len;
            range.contains(&index)
        })
    };
    let samples = all.chunks_exact(size).enumerate();
    samples
        .filter(|(flat, _)| is_within(*flat))
        .flat_map(|(_, one)| one.to_vec())
        .collect()
}

/// Numbers of samples; where they are packed, those that they stand for, NaN for gaps.
fn numbers(variable: &Variable, sample: Sample, bytes: &[u8], is_packed: bool) -> Vec<f64> {
    let number = |name| variable.attributes.number(name).filter(|_| is_packed);
    let [scale, offset, fill] = ["scale_factor", "add_offset", "_FillValue"].map(number);
    let of = |one: &[u8]| {
        let number = sample.to_f64(ByteOrder::Little, one);
        match fill == Some(number) {
            true => f64::NAN,
            false => number * scale.unwrap_or(1.0) + offset.unwrap_or(0.0),
        }
    };
    bytes.chunks_exact(sample.bytes()).map(of).collect()
}

/// Whether an array is what the peer found; false for one that is listed and not read.
fn compare(container: &Container, path: &str, expected: &Json, what: &str) -> bool {
    let (at, row) = match path {
        "." => (None, None),
        path => {
            let found = place(container, path).unwrap_or_else(|| panic!("{what} is listed"));
            (Some(found.0), found.1)
        }
    };
    let attributes = at.map_or(&container.attributes, |at| {
        &container.variables[at].attributes
    });
    for (name, value) in expected["attributes"].as_object().into_iter().flatten() {
        let found = match value.as_str() {
            Some(_) => attributes.text(name).map(Json::from),
            None => attributes.number(name).map(Json::from),
        };
        assert_eq!(found.as_ref(), Some(value), "{what}: {name}");
    }
    let Some(at) = at else { return true };
    let variable = &container.variables[at];
    let is_text = expected.get("text").map(|_| "text");
    if let Some(other) = expected["other"].as_str().or(is_text) {
        let other = SampleType::Other(other.into());
        assert_eq!(variable.sample_type, other, "{what}");
    }
    if expected["other"].is_string() {
        return true;
    }
    if let Some(text) = expected.get("text") {
        let rows: Vec<String> = serde_json::from_value(text.clone()).unwrap();
        let found = match container.attributes.get(&variable.path) {
            Some(Value::Text(text)) => vec![text.clone()],
            Some(Value::Texts(texts)) => texts.clone(),
            other => panic!("{what}: {other:?}"),
        };
        assert_eq!(found, rows, "{what}");
        return true;
    }
    let Some(sample) = variable.sample_type.number() else {
        return false;
    };
    if let Some(even) = expected.get("even") {
        let [origin, step]: [f64; 2] = serde_json::from_value(even.clone()).unwrap();
        let unit = Some("s".to_owned());
        let even = Some(Coordinate::Even { origin, step, unit });
        let is_even = variable.dimensions.iter().any(|d| d.coordinate == even);
        assert!(is_even, "{what}: {:?}", variable.dimensions);
    }
    if let Some(names) = expected.get("dimensions") {
        let found: Vec<_> = variable.dimensions.iter().map(|d| d.name.clone()).collect();
        assert_eq!(serde_json::json!(found), *names, "{what}");
    }
    let shape: Vec<u64> = serde_json::from_value(expected["shape"].clone()).unwrap();
    // Of channels of one variable, which one, and along which dimension they lie.
    let is_across = |name: &str| ["channel", "trace"].contains(&name);
    let mut dimensions = variable.dimensions.iter();
    let across = dimensions.position(|d| d.name.as_deref().is_some_and(is_across));
    let row = row.map(|row| (across.unwrap(), row..row + 1));
    let mut own = variable.shape();
    if let Some((across, _)) = row {
        own.remove(across);
    }
    assert_eq!(own, shape, "{what}");
    let theirs = expected["type"].as_str().unwrap();
    let mut all_kinds = ALL.into_iter();
    let theirs = all_kinds.find(|sample| kind(*sample) == theirs).unwrap();
    // As they are, and as they are meant.
    for key in ["hex", "decoded"] {
        let Some(hex) = expected[key].as_str() else {
            continue;
        };
        let is_packed = key == "decoded";
        let theirs = match is_packed && expected.get("hex").is_some() {
            true => Sample::F64,
            false => theirs,
        };
        let digits = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).unwrap();
        let all: Vec<u8> = (0..hex.len()).step_by(2).map(digits).collect();
        for mut block in blocks(&shape) {
            let wanted = within(&all, theirs.bytes(), &shape, &block);
            if let Some((across, row)) = row.clone() {
                block.insert(across, row);
            }
            let found = bytes(container, at, &block);
            if !is_packed && kind(sample) == kind(theirs) {
                assert_eq!(found, wanted, "{what} {block:?}");
                continue;
            }
            let found = numbers(variable, sample, &found, is_packed);
            let wanted = numbers(variable, theirs, &wanted, false);
            assert_eq!(found.len(), wanted.len(), "{what} {block:?}");
            for (found, wanted) in found.into_iter().zip(wanted) {
                // Floats of IBM are rounded to singles.
                let found = match theirs {
                    Sample::F32 => f64::from(found as f32),
                    _ => found,
                };
                let is_same = found == wanted || found.is_nan() && wanted.is_nan();
                assert!(is_same, "{what} {block:?}: {found} instead of {wanted}");
            }
        }
    }
    true
}

/// Types of numbers that peers have.
const ALL: [Sample; 12] = {
    use Sample::*;
    [F64, F32, F16, I8, I16, I32, I64, U8, U16, U32, U64, Bool]
};

/// Opens cut and changed copies of a file and reads what they list.
pub fn survives(format: Format, bytes: &[u8], is_bounded: bool) {
    let mut options = Options::default();
    options.memory = Some(16 << 20);
    let read = |bytes: Vec<u8>| {
        let length = bytes.len() as u64;
        let Ok(container) = open(format, Arc::new(bytes), &options) else {
            return;
        };
        for (i, variable) in container.variables.iter().enumerate() {
            let is_number = variable.sample_type.number().is_some();
            let Some(count) = variable.count().filter(|_| is_number) else {
                continue;
            };
            assert!(!is_bounded || count <= 8 * length, "{}", variable.path);
            if count < 1 << 20 {
                let _ = container.numbers(i);
            }
        }
    };
    let step = if bytes.len() > 4096 { 7 } else { 1 };
    for len in (0..bytes.len()).step_by(step) {
        read(bytes[..len].to_vec());
    }
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for _ in 0..1500 {
        let mut changed = bytes.to_vec();
        for _ in 0..=random(4) {
            let at = random(changed.len());
            changed[at] = [random(256) as u8, 0, 0xff, 0x7f, 0x80][random(5)];
        }
        read(changed);
    }
}
