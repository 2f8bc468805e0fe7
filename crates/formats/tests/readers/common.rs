//! What a peer's reader found in a file, and damage to it.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use serde_json::Value as Json;
use wavecascade_formats::{Container, Format, Options, SampleType, Value, open};

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
pub fn bytes(container: &Container, variable: usize, block: &[Range<u64>]) -> Vec<u8> {
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

pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The files of a directory with what its peer read.
pub fn files(of: &str) -> Vec<(String, Vec<u8>, Json)> {
    let json = std::fs::read(directory(of).join("expected.json")).unwrap();
    let json: Json = serde_json::from_slice(&json).unwrap();
    let files = json["files"].as_object().unwrap();
    let read = |name: &String| std::fs::read(directory(of).join(name)).unwrap();
    files
        .iter()
        .map(|(name, found)| (name.clone(), read(name), found.clone()))
        .collect()
}

pub fn open_bytes(name: &str, bytes: &[u8]) -> Container {
    let format = Format::detect(name, bytes).unwrap_or_else(|| panic!("{name} is detected"));
    open(format, Arc::new(bytes.to_vec()), &Options::default()).unwrap()
}

/// All files of a folder, `count` of them, hold the arrays that the other reader found, and no others.
pub fn compare_all(folder: &str, count: usize) {
    let files = files(folder);
    assert_eq!(files.len(), count);
    for (name, bytes, found) in files {
        let container = open_bytes(&name, &bytes);
        let found = found.as_object().unwrap();
        assert_eq!(container.variables.len(), found.len(), "{name}");
        for (path, expected) in found {
            compare(&container, path, expected);
        }
    }
}

/// Compares type, shape and every bit with the peer's.
fn compare(container: &Container, path: &str, expected: &Json) {
    let i = container.find(path);
    let i = i.unwrap_or_else(|| panic!("{path} is listed"));
    let variable = &container.variables[i];
    if let Some(other) = expected.get("other") {
        let other = SampleType::Other(other.as_str().unwrap().into());
        assert_eq!(variable.sample_type, other, "{path}");
        return;
    }
    if let Some(text) = expected.get("text") {
        assert_eq!(variable.sample_type, SampleType::Other("text".into()));
        let rows: Vec<String> = serde_json::from_value(text.clone()).unwrap();
        let found = match container.attributes.get(path) {
            Some(Value::Text(text)) => vec![text.clone()],
            Some(Value::Texts(texts)) => texts.clone(),
            other => panic!("{path}: {other:?}"),
        };
        assert_eq!(found, rows, "{path}");
        return;
    }
    let shape: Vec<u64> = serde_json::from_value(expected["shape"].clone()).unwrap();
    assert_eq!(variable.shape(), shape, "{path}");
    let sample = variable.sample_type.number().unwrap();
    let kind = match sample.name() {
        "bool" => "b1".to_owned(),
        name => format!("{}{}", &name[..1], sample.bytes()),
    };
    assert_eq!(kind, expected["type"].as_str().unwrap(), "{path}");
    let all: Vec<_> = shape.iter().map(|len| 0..*len).collect();
    let out = bytes(container, i, &all);
    assert_eq!(hex(&out), expected["hex"].as_str().unwrap(), "{path}");

    // A block leaves out the first and the last index of each dimension that has three.
    let inner: Vec<_> = shape
        .iter()
        .map(|len| if *len < 3 { 0..*len } else { 1..len - 1 })
        .collect();
    let mut within = Vec::new();
    for (flat, one) in out.chunks_exact(sample.bytes()).enumerate() {
        let mut rest = flat as u64;
        let is_inner = shape.iter().zip(&inner).rev().all(|(len, range)| {
            let index = rest % len;
            rest /= len;
            range.contains(&index)
        });
        if is_inner {
            within.extend_from_slice(one);
        }
    }
    assert_eq!(bytes(container, i, &inner), within, "a block of {path}");
}

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
